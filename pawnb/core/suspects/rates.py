"""How many errors are to be expected where: what is measured of tracks, weighed by experience.

The logarithm of the odds that an error of a point lies in a frame is taken as a sum of curves,
one for each thing that is measured (:mod:`pawnb.core.suspects.uncertainty`), fitted by
``benchmarks/learn_suspects.py`` to tracks of rendered scenes with truth. An error counts once,
however long it lasts, so that rates can be added up over the frames that a look shows: the
sum is the number of errors that the look is expected to find.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.suspects.uncertainty import Doubt

WRONG_AROUND_FRAMES = 5
"""Who looks at a frame sees what is wrong so many frames before and after it."""

_PLATEAU = 0.95
"""Of frames from which nearly as much is seen, the one that is most doubtful itself is shown."""

_GOES_ON = 0.03
"""Where more errors of a point than this are expected in every frame, it is one doubt without
a break: who sees a part of it goes on to where the point is right again."""

Look = tuple[int, float, np.ndarray, np.ndarray]
"""Row; errors expected to be found; of each point (P,) how many; and where it is most doubtful."""

INTERCEPT = -8.55
CURVES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "unrecognised": (
        (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1),
        (0.15, -0.04, -0.07, -0.12, -0.15, -0.08, 0.09, 0.78, 1.44, 1.57),
    ),
    "vague": (
        (-3, -2.7, -2.4, -2, -1.6, -1.2, -0.8, -0.4, 0.4),
        (-1.13, -0.86, 0.11, 1.32, 1.67, 1.57, 1.99, 2.51, 3.25),
    ),
    "revision": (
        (0, 0.03, 0.1, 0.3, 0.6, 1, 2, 4),
        (-0.01, 0.09, -0.34, -0.25, 0.91, 0.87, 0.56, 1.38),
    ),
    "separation": (
        (-4, 0, 2, 4, 6, 10),
        (0.55, 0.45, 0.25, 0.05, -0.05, -0.05),
    ),
    "apart": (
        (0, 0.2, 0.4, 0.7, 1, 1.5, 2.5),
        (-0.09, -0.09, 0.05, 0.13, 0.46, 0.58, 0.68),
    ),
    "off_cycle": (
        (0, 1, 2, 3, 4, 6, 10),
        (-0.41, -0.28, 0.2, 0.85, 1.28, 2.16, 3.33),
    ),
    "near": (
        (0, 0.15, 0.3, 0.5, 0.75, 1, 1.5, 2.5),
        (0.78, 0.75, 0.55, 0.53, 0.8, 0, -0.17, -0.52),
    ),
    "pace_before": (
        (0, 0.1, 0.25, 0.5, 0.75, 1, 1.5),
        (-0.5, 1.12, 0.39, -0.19, -0.22, 0.08, 0.8),
    ),
    "pace": (
        (0, 0.1, 0.25, 0.5, 0.75, 1, 1.5),
        (0.26, 1.25, 0.99, -0.32, -1.9, -1.76, -0.44),
    ),
    "pace_after": (
        (0, 0.1, 0.25, 0.5, 0.75, 1, 1.5),
        (-0.72, 0.38, 0.66, 1.77, 0.89, -0.09, 0.23),
    ),
}
"""Change of the log-odds by each measure: its knots, and the curve's values there; on
average 0, so that what is not known does not count. As the benchmark prints them for 21 rendered
scenes of half scale and 300 frames, 59 tracks of which it learns from 52: ``--vary --clicked 0.5
0.99 --seeds`` 0 to 4, 6, 7, 8 and 21 of normal ones, 0 to 8, 12 and 21 of hard ones, and, without
``--clicked``, 11 and 12 of easy ones. It went on from curves that it had printed for tracks of an
earlier tracker: 45 scenes, ``--seeds`` 21 to 23 and 51 to 57 with ``--vary``, others as they come
or with one thing changed.

``apart`` is as printed when tracks first said it, for the same scenes with the present tracker,
in whose tracks there are 17 errors to learn from; the other curves were left as they stood.
There ``separation`` added hardly anything to them (-0.19 to 0.04), so that it is set by hand:
the less candidates are separated, the more is doubted, by a factor of two at most."""

DOUBT_LIMITS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "reprojection": ((0.9, 1.5), (0, 11)),
    "leap": ((1.8, 3), (0, 11)),
    "passes": ((0.5, 1.5), (0, 8)),
}
"""The same of what no sound track shows (:mod:`pawnb.core.suspects.limits`), and of another pass
through the recording, which may be the one that errs: not learnt. Beyond the second knot the odds
of an error are about even, though all else speaks for the point."""


def weigh(doubt: Doubt) -> FloatArray:
    """Return how a reason changes the log-odds (n, P) of an error."""
    parts = []
    for name, values in doubt.measures.items():
        curve = CURVES.get(name) or DOUBT_LIMITS[name]
        parts.append(np.where(np.isnan(values), 0.0, np.interp(values, *curve)))
    return np.asarray(np.sum(parts, axis=0))


def error_rates(doubts: Iterable[Doubt]) -> FloatArray:
    """Return how many errors of each point are expected in each frame (n, P)."""
    odds = INTERCEPT + np.sum([weigh(doubt) for doubt in doubts], axis=0)
    return np.asarray(1.0 / (1.0 + np.exp(-odds)))


def choose_looks(
    rates: FloatArray, frames: IntArray, *, around: float, least: float, at_least: int = 0
) -> list[Look]:
    """Take the frame where a look finds most errors, and go on with what it did not show.

    Parameters
    ----------
    rates : ndarray, shape (n, P)
        Errors expected of each point in each frame.
    frames : ndarray of int, shape (n,)
        Their numbers, ascending.
    around : float
        A look shows what is wrong in so many frames before and after.
    least : float
        Looks that are expected to find fewer errors are left out.
    at_least : int
        So many looks are listed however few errors they are expected to find, if any.

    Returns
    -------
    list of (int, float, ndarray, ndarray)
        Row; errors expected to be found; of each point (P,) how many of them; and in which
        row it is most doubtful. The look that is expected to find most comes first.
    """
    left = rates.copy()
    first = np.searchsorted(frames, frames - around)
    stop = np.searchsorted(frames, frames + around, side="right")
    follows = np.diff(frames, prepend=-np.inf) <= around
    # a point has hardly more than one error in a look
    found = -np.expm1(-_sums(left, first, stop))
    gain = found.sum(axis=1)
    chosen: list[Look] = []
    while len(gain) and gain.max() > 0:
        best = int(gain.argmax())
        if gain[best] < least and len(chosen) >= at_least:
            break
        near = np.arange(first[best], stop[best])
        good = near[gain[near] >= _PLATEAU * gain[best]]
        t = int(good[left[good].sum(axis=1).argmax()])
        shown = slice(first[t], stop[t])
        chosen.append((t, float(gain[t]), found[t].copy(), first[t] + left[shown].argmax(axis=0)))
        begin, end = shown.start, shown.stop
        for p in range(left.shape[1]):
            seen = _without_a_break(left[:, p], shown, follows)
            left[seen, p] = 0.0
            begin, end = min(begin, seen.start), max(end, seen.stop)
        touched = slice(first[begin], stop[end - 1])
        found[touched] = -np.expm1(-_sums(left, first[touched], stop[touched]))
        gain[touched] = found[touched].sum(axis=1)
    return sorted(chosen, key=lambda look: -look[1])


def _without_a_break(rates: FloatArray, shown: slice, follows: BoolArray) -> slice:
    """Return the rows shown, and those beside them in which the doubt goes on."""
    first, stop = shown.start, shown.stop
    while first > 0 and follows[first] and rates[first - 1] >= _GOES_ON:
        first -= 1
    while stop < len(rates) and follows[stop] and rates[stop] >= _GOES_ON:
        stop += 1
    return slice(first, stop)


def _sums(values: FloatArray, first: IntArray, stop: IntArray) -> FloatArray:
    """Return the sums of rows first to stop."""
    begin = int(first.min()) if len(first) else 0
    part = values[begin : int(stop.max(initial=0))]
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(part, axis=0)])
    return np.asarray(total[stop - begin] - total[first - begin])
