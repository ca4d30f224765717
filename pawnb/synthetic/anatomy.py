"""Measures of a mouse, in mm, as plain tables; nose to base of the tail is 87 mm.

The proportions were set by eye against pictures of C57BL/6 mice: hip 21 mm high,
back 41 mm, belly 9 mm above the ground, hind foot 18 mm, front paw 8 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from pawnb.arrays import FloatArray
from pawnb.synthetic.surfaces import unit

_TAIL_LENGTH = 82.0

# forward, height of the middle, half height, half width of the trunk and head
_TRUNK_TABLE = np.array(
    [
        [-39.5, 26.4, 1.6, 1.6],
        [-38.5, 26.2, 3.6, 3.4],
        [-35.5, 25.6, 7.0, 6.4],
        [-30.0, 24.7, 11.3, 10.2],
        [-22.0, 24.5, 14.8, 13.0],
        [-11.0, 24.8, 16.6, 14.2],
        [0.0, 23.8, 15.9, 13.4],
        [9.0, 22.4, 14.3, 12.2],
        [16.0, 21.8, 13.2, 11.2],
        [22.0, 22.4, 11.3, 9.8],
        [28.0, 22.8, 9.8, 8.8],
        [34.0, 22.2, 8.8, 8.4],
        [39.0, 20.6, 8.0, 7.4],
        [43.5, 18.6, 6.2, 5.4],
        [47.0, 16.9, 4.5, 3.9],
        [49.2, 15.9, 2.9, 2.6],
        [50.0, 15.6, 1.2, 1.2],
    ]
)
TRUNK_RINGS, TRUNK_SEGMENTS = 64, 40


def trunk_profile() -> FloatArray:
    """Return the trunk's rings (TRUNK_RINGS, 4): forward, height, half height, half width."""
    table = _TRUNK_TABLE
    # rings stand closer where the radius changes fast, at the two ends
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, TRUNK_RINGS))
    share = 0.6 * share + 0.4 * np.linspace(0.0, 1.0, TRUNK_RINGS)
    forward = table[0, 0] + share * (table[-1, 0] - table[0, 0])
    rest = PchipInterpolator(table[:, 0], table[:, 1:])(forward)
    return np.column_stack([forward, rest])


@dataclass(frozen=True)
class Limb:
    """Measures of one pair of limbs.

    The limb bends forwards (``bend`` +1, knee) or backwards (-1, elbow); the skin of the
    flank keeps that joint within ``bend_height``. ``pitch_deg`` is the angle of the foot's
    back part above the belt and ``toe_deg`` that of the digits, as (phase, angle) with
    phase 0-1 in stance and 1-2 in swing.
    """

    joint: tuple[float, float, float]
    slide: float
    upper: float
    lower: float
    foot: float
    digits: float
    bend: float
    bend_height: tuple[float, float]
    splay_deg: float
    pitch_deg: tuple[tuple[float, float], ...]
    toe_deg: tuple[tuple[float, float], ...]
    shaft_width: tuple[float, ...]
    shaft_depth: tuple[float, ...]
    foot_width: tuple[float, ...]
    foot_height: tuple[float, ...]
    paw_from: float
    toe_count: int
    toe_fan_deg: float
    bare_from: float
    segments: int = 14


FRONT = Limb(
    joint=(19.0, 5.8, 17.5),
    slide=0.28,
    upper=11.0,
    lower=12.5,
    foot=4.5,
    digits=3.6,
    bend=-1.0,
    bend_height=(0.0, 14.5),
    splay_deg=4.0,
    pitch_deg=(
        (0, 22), (0.35, 32), (0.7, 60), (1.0, 100), (1.15, 138), (1.38, 150), (1.62, 105),
        (1.85, 40), (2.0, 22),
    ),
    toe_deg=(
        (0, 0), (0.85, 0), (1.0, -15), (1.15, -75), (1.4, -85), (1.65, -35), (1.86, 8), (2.0, 0),
    ),
    shaft_width=(3.4, 3.9, 4.1, 3.8, 3.3, 2.8, 2.2, 1.7, 1.4),
    shaft_depth=(5.5, 6.4, 6.4, 5.6, 4.5, 3.6, 2.6, 1.9, 1.5),
    foot_width=(1.3, 1.5, 1.7, 2.1, 2.2),
    foot_height=(1.3, 1.3, 1.2, 1.1, 0.9),
    paw_from=0.0,
    toe_count=4,
    toe_fan_deg=44.0,
    bare_from=0.9,
)  # fmt: skip

HIND = Limb(
    joint=(-21.0, 6.2, 22.5),
    slide=0.06,
    upper=15.5,
    lower=17.0,
    foot=12.0,
    digits=6.0,
    bend=1.0,
    bend_height=(12.5, 40.0),
    splay_deg=7.0,
    pitch_deg=(
        (0, 18), (0.3, 23), (0.6, 36), (0.85, 54), (1.0, 74), (1.14, 108), (1.28, 114), (1.44, 88),
        (1.64, 44), (1.84, 22), (2.0, 18),
    ),
    toe_deg=(
        (0, 0), (0.85, 0), (1.0, -12), (1.12, -55), (1.28, -52), (1.55, -15), (1.82, 8), (2.0, 0),
    ),
    shaft_width=(3.4, 4.6, 5.3, 5.4, 4.9, 4.2, 3.1, 2.2, 1.7),
    shaft_depth=(8.5, 10.5, 10.0, 8.2, 6.6, 5.2, 3.6, 2.3, 1.9),
    foot_width=(1.4, 1.7, 1.7, 2.0, 2.3),
    foot_height=(1.7, 1.6, 1.4, 1.3, 1.0),
    paw_from=0.6,
    toe_count=5,
    toe_fan_deg=36.0,
    bare_from=0.8,
)  # fmt: skip


def posture(nodes: tuple[tuple[float, float], ...]) -> PchipInterpolator:
    """Return an angle in rad as a smooth periodic function of phase 0-2."""
    phase, angle = np.array(nodes, dtype=float).T
    phase = np.concatenate([phase[:-1] - 2.0, phase, phase[1:] + 2.0])
    angle = np.radians(np.concatenate([angle[:-1], angle, angle[1:]]))
    return PchipInterpolator(phase, angle)


def two_links(
    top: FloatArray, end: FloatArray, *, lengths: tuple[float, float], bend: FloatArray
) -> FloatArray:
    """Return the middle joint of two links that bend.

    Where the end is out of reach the links stretch, so the limb never comes apart.

    Parameters
    ----------
    top, end : ndarray, shape (3,)
        Where the first link begins and the second ends.
    lengths : tuple of float
        Lengths of the two links.
    bend : ndarray, shape (3,)
        Direction that the joint points to.

    Returns
    -------
    ndarray, shape (3,)
        The joint between them.
    """
    a, b = lengths
    span = end - top
    distance = float(np.linalg.norm(span))
    along = span / distance
    stretch = max(1.0, distance / (0.985 * (a + b)))
    a, b = a * stretch, b * stretch
    reach = (a**2 - b**2 + distance**2) / (2 * distance)
    height = np.sqrt(max(a**2 - reach**2, 0.0))
    across = bend - (bend @ along) * along
    return top + reach * along + height * unit(across)


def tail_line(rings: int, *, lift_deg: float, beat: float, sway: float) -> FloatArray:
    """Return the middle of the tail: it rises behind and sways with a lag along its length.

    Parameters
    ----------
    rings : int
        How many places, base to tip.
    lift_deg : float
        How steeply it is carried, degrees.
    beat : float
        Phase of the gait, radians.
    sway : float
        Yaw of the body, radians.

    Returns
    -------
    ndarray, shape (rings, 3)
        Places in the body frame, mm.
    """
    s = np.linspace(0.0, 1.0, rings)
    lift = np.radians(lift_deg)
    rise = -0.35 + (lift + 0.5) * np.clip(s * 2.4, 0.0, 1.0) ** 1.2
    rise += 0.12 * s * np.sin(2 * beat - 4.0 * s)
    turn = (0.35 * np.sin(beat - 3.5 * s) + 2.0 * sway) * s
    step = np.column_stack(
        [-np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)]
    )
    length = _TAIL_LENGTH / (rings - 1)
    start = np.array([-36.0, 0.0, 26.2])
    return np.asarray(start + np.vstack([np.zeros(3), np.cumsum(step[1:] * length, axis=0)]))
