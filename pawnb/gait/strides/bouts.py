"""Bouts of locomotion: where an animal that stops and goes is going."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import find_runs

_FAST_PERCENTILE = 95.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Bouts:
    """Bouts and what lies between them.

    Parameters
    ----------
    bouts, pauses : ndarray of int, shape (k, 2) and (m, 2)
        First and one past the last sample of each; together they are the recording.
    start_speed, stop_speed : float
        A bout begins above the one and ends below the other, unit of the positions / s.
    """

    bouts: IntArray
    pauses: IntArray
    start_speed: float
    stop_speed: float


@checked_arguments
def find_bouts(
    speed: FloatArray,
    *,
    fs_hz: float,
    start_fraction: float,
    stop_fraction: float,
    min_bout_s: float,
    min_pause_s: float,
) -> Bouts:
    """Find the bouts of locomotion in the speed of the body.

    A bout begins where the speed rises above ``start_fraction`` of the animal's fast speed
    (its 95th percentile) and lasts until it falls below ``stop_fraction`` (hysteresis), so
    that starting and stopping are left out (Pullar 2009, section 2.2 does the same by eye). An
    animal that runs steadily is one bout.

    Parameters
    ----------
    speed : ndarray, shape (n,)
        Low-passed speed of the body; NaN where not known, which ends no bout.
    fs_hz : float
        Samples per second.
    start_fraction, stop_fraction : float
        Shares of the fast speed.
    min_bout_s : float
        Shorter bouts count as pauses.
    min_pause_s : float
        Shorter pauses are part of the bout around or beside them.

    Returns
    -------
    Bouts
        Bouts, pauses and the two speeds. Where no speed is known, all of it is one bout.
    """
    n = len(speed)
    known = np.isfinite(speed)
    if not known.any():
        whole = np.array([[0, n]])
        return Bouts(bouts=whole, pauses=np.empty((0, 2), int), start_speed=0.0, stop_speed=0.0)
    fast = float(np.percentile(speed[known], _FAST_PERCENTILE))
    start, stop = start_fraction * fast, stop_fraction * fast
    filled = np.interp(np.arange(n), np.flatnonzero(known), speed[known])
    going = np.zeros(n, dtype=bool)
    for first, last in find_runs(filled > stop):
        if (filled[first:last] > start).any():
            going[first:last] = True
    for first, last in find_runs(~going):
        # at the ends too: the smoothing says least there
        if going.any() and last - first < min_pause_s * fs_hz:
            going[first:last] = True
    for first, last in find_runs(going):
        if last - first < min_bout_s * fs_hz:
            going[first:last] = False
    return Bouts(
        bouts=find_runs(going), pauses=find_runs(~going), start_speed=start, stop_speed=stop
    )
