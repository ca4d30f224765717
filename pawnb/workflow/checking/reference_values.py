"""Published and exact values that this installation must reproduce, one function a value."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pawnb.core.dlt import project, triangulate
from pawnb.gait.circular import circular_sd, mean_vector, rayleigh_p
from pawnb.gait.circular.groups import watson_williams_test
from pawnb.signals import butterworth_lowpass, differentiate


class ReferenceValue(NamedTuple):
    """A value with its source.

    Attributes
    ----------
    what : str
        What is computed.
    source : str
        Where the expected value stands.
    expected : float
        The value.
    tolerance : float
        How far from it is still right: half of its last printed digit, or rounding error.
    compute : callable
        Computes it with pawnb.
    """

    what: str
    source: str
    expected: float
    tolerance: float
    compute: Callable[[], float]


_ZAR_26_4 = np.array([45, 55, 81, 96, 110, 117, 132, 154]) / 360.0
_ZAR_27_7 = (
    np.array([94, 65, 45, 52, 38, 47, 73, 82, 90, 40, 87]) / 360.0,
    np.array([77, 70, 61, 45, 50, 35, 48, 65, 36]) / 360.0,
)
_TWO_CAMERAS = np.array(
    [
        [10.0, 0.2, -1.0, 500.0, 0.1, 9.0, -2.0, 400.0, 0.001, 0.0005, 0.002],
        [8.0, -3.0, 1.0, 450.0, 0.5, 2.0, -9.0, 420.0, -0.001, 0.002, 0.0003],
    ]
).T
_FS_HZ = 250.0
_CUTOFF_HZ = 20.0


def _filtered_amplitude() -> float:
    """Return what is left of a wave of amplitude 1 at the cut-off."""
    t = np.arange(2000) / _FS_HZ
    wave = np.cos(2 * np.pi * _CUTOFF_HZ * t)
    out = butterworth_lowpass(wave, cutoff_hz=_CUTOFF_HZ, fs_hz=_FS_HZ)
    return float(np.sqrt(2 * np.mean(out[500:1500] ** 2)))


def _second_derivative() -> float:
    """Return the second derivative of 3 t squared at its first sample."""
    t = np.arange(50) / _FS_HZ
    return float(differentiate(3 * t**2, dt=1 / _FS_HZ, order=2)[0])


def _triangulated() -> float:
    """Return how far a point lies, once projected into two views and triangulated, from itself."""
    xyz = np.array([[12.0, -7.0, 3.5]])
    return float(np.abs(triangulate(_TWO_CAMERAS, project(_TWO_CAMERAS, xyz)).xyz - xyz).max())


REFERENCE_VALUES = (
    ReferenceValue(
        "circular mean, degrees", "Zar 2010, example 26.4", 99.0, 0.5,
        lambda: mean_vector(_ZAR_26_4).mean * 360,
    ),
    ReferenceValue(
        "mean vector length", "Zar 2010, example 26.4", 0.82522, 5e-6,
        lambda: mean_vector(_ZAR_26_4).r,
    ),
    ReferenceValue(
        "circular standard deviation, degrees", "CircStat, Zar's example 26.4", 35.514880, 5e-6,
        lambda: circular_sd(mean_vector(_ZAR_26_4).r) * 360,
    ),
    ReferenceValue(
        "Rayleigh's p of two phases, r 0.6", "P(r > R) = (2/pi) arccos R of two phases",
        2 / np.pi * np.arccos(0.6), 1e-6, lambda: rayleigh_p(2, 0.6),
    ),
    ReferenceValue(
        "Watson-Williams F", "Zar 2010, example 27.7", 1.61, 0.005,
        lambda: watson_williams_test(
            np.concatenate(_ZAR_27_7), [g for g, own in enumerate(_ZAR_27_7) for _ in own]
        ).statistic,
    ),
    ReferenceValue(
        "amplitude at the filter's cut-off", "half power, Winter 2009", np.sqrt(0.5), 0.005,
        _filtered_amplitude,
    ),
    ReferenceValue(
        "second derivative of 3 t squared at its end", "exact", 6.0, 1e-6, _second_derivative
    ),
    ReferenceValue("a point projected and triangulated, off by", "exact", 0.0, 1e-9, _triangulated),
)  # fmt: skip
"""All of them."""
