"""Samples of Zar (2010) and of libraries' own tests, in cycles."""

from __future__ import annotations

import numpy as np


def _cycles(*degrees):
    return np.array(degrees, dtype=float) / 360.0


D1 = _cycles(45, 55, 81, 96, 110, 117, 132, 154)
D2_CENTRES = _cycles(*range(45, 286, 30))
D2_COUNTS = np.array([6, 9, 13, 15, 22, 17, 12, 8, 3])
D3 = _cycles(35, 40, 40, 45, 45, 55, 60, 215, 220, 225, 225, 235, 235, 240, 245)
D4_MEANS = _cycles(160, 169, 117, 140, 186, 134, 171)
D4_LENGTHS = np.array([0.8954, 0.7747, 0.4696, 0.8794, 0.3922, 0.6952, 0.3338])
D7 = _cycles(66, 75, 86, 88, 88, 93, 97, 101, 118, 130)
D8 = _cycles(10, 15, 25, 30, 30, 30, 35, 45, 50, 60, 75, 80, 100, 110, 255, 270, 280, 280,
             300, 320, 330, 350, 350, 355)  # fmt: skip
D9 = _cycles(97, 104, 121, 159, 164, 172, 195, 213)
D10 = (_cycles(94, 65, 45, 52, 38, 47, 73, 82, 90, 40, 87),
       _cycles(77, 70, 61, 45, 50, 35, 48, 65, 36))  # fmt: skip
D11 = (_cycles(135, 145, 125, 140, 165, 170), _cycles(150, 130, 175, 190, 180, 220),
       _cycles(140, 165, 185, 180, 125, 175, 140))  # fmt: skip
D12 = (_cycles(35, 45, 50, 55, 60, 70, 85, 95, 105, 120),
       _cycles(75, 80, 90, 100, 110, 130, 135, 140, 150, 155, 165))  # fmt: skip
D20_INSECT = _cycles(145, 190, 310, 210, 80)
D20_LIGHT = _cycles(120, 180, 330, 225, 55)
D21_VALUES = np.array([48.0, 55, 26, 23, 22, 62, 64])
D21_ANGLES = _cycles(190, 160, 210, 225, 220, 140, 120)
X5 = _cycles(190.18, 175.48, 155.95, 217.83, 156.36)
PIGEON = _cycles(20, 135, 145, 165, 170, 200, 300, 325, 335, 350, 350, 350, 355)
PG5 = np.array([0.785, 1.570, 3.141, 0.839, 5.934]) / (2.0 * np.pi)
PG5_VALUES = np.array([1.593, 1.291, -0.248, -2.892, 0.102])
MILWAUKEE_THETA = _cycles(356, 97, 211, 232, 343, 292, 157, 302, 335, 302, 324, 85, 324, 340,
                          157, 238, 254, 146, 232, 122, 329)  # fmt: skip
MILWAUKEE_PSI = _cycles(119, 162, 221, 259, 270, 29, 97, 292, 40, 313, 94, 45, 47, 108, 221,
                        270, 119, 248, 270, 45, 23)  # fmt: skip
M6 = _cycles(51, 67, 40, 109, 31, 358)
W7 = _cycles(0, 3.6, 36, 72, 108, 169.2, 324)
W7_WEIGHTS = np.array([12, 1, 6, 1, 2, 1, 1])


def nudged(sample):
    """Return a perturbed twin: the first phase 2 degrees on."""
    twin = np.array(sample, dtype=float)
    twin[0] += 2.0 / 360.0
    return twin


def labelled(samples):
    """Return samples as one array and the group of each phase."""
    groups = np.repeat(np.arange(len(samples)), [len(s) for s in samples])
    return np.concatenate(samples), groups
