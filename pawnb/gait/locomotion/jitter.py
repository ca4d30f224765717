"""How much tracks jitter from frame to frame, against the way of the feet."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.events.extremes import Extreme
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.signals.robust import MAD_TO_SD

_TOO_MUCH = 0.09
"""Standard deviation of a label over the way of the feet, from which strides are not to be trusted.
Made walks of 100 and 120 frames a second: at 0.07 their number is right, at 0.11 it is up to 8 %
too large, at 0.13 up to 23 %. A real fly has 0.02, a real mouse below 0.001."""

_LEAST_FRAMES = 12.0
"""Of fewer frames a stride, motion itself has third differences like those of jitter."""

_THIRD_DIFFERENCE = math.sqrt(1.0 + 9.0 + 9.0 + 1.0)
"""Standard deviation of a third difference of white noise, over that of the noise."""


def jitter_of(position: FloatArray) -> float:
    """Estimate the standard deviation of the jitter of a track from its third differences.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Positions, evenly sampled; NaN where missing.

    Returns
    -------
    float
        In the unit of the positions: the median of absolute third differences, which leaves the
        few of a swing aside. NaN with fewer than ten.
    """
    third = np.diff(position, 3)
    third = third[np.isfinite(third)]
    if len(third) < 10:
        return math.nan
    return MAD_TO_SD * float(np.median(np.abs(third))) / _THIRD_DIFFERENCE


def say_jitter(
    feet: FootPaths, position: FloatArray, extremes: Sequence[Sequence[Extreme]]
) -> list[str]:
    """Name the feet whose tracks jitter so much that turns of it pass for strides.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    position : ndarray, shape (n, k)
        Their positions along forward, not smoothed.
    extremes : sequence of sequences of Extreme
        AEP and PEP of each.

    Returns
    -------
    list of str
        A note; none where tracks are steady, or have too few frames a stride to tell.
    """
    lasted = [np.diff([e.sample for e in own if e.kind > 0]) for own in extremes]
    periods = np.concatenate(lasted) if lasted else np.empty(0)
    if not len(periods) or float(np.median(periods)) < _LEAST_FRAMES:
        return []
    seen = [column[np.isfinite(column)] for column in position.T]
    ways = [float(np.ptp(np.percentile(one, [5, 95]))) for one in seen if len(one)]
    way = float(np.median(ways))
    shares = {
        leg: jitter_of(column) / way
        for leg, column in zip(feet.legs, position.T, strict=True)
        if way > 0.0
    }
    bad = {leg: share for leg, share in shares.items() if share > _TOO_MUCH}
    if not bad:
        return []
    return [
        f"{', '.join(bad)} jitter{'s' * (len(bad) == 1)} from frame to frame by "
        f"{max(bad.values()):.0%} of the way of a foot: turns of that pass for strides, and their "
        "number and durations are not to be trusted. Correct the tracks, or track anew."
    ]
