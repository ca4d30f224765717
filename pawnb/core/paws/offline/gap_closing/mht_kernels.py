"""Telling what a point did in a stretch of frames, compiled: frame after frame, then back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import (
    Moves,
    Stories,
    advance,
    begin,
    cell,
    copy,
    expect,
    room_for,
    stand,
)
from pawnb.core.paws.offline.gap_closing.mht_parameters import Telling
from pawnb.core.paws.offline.gap_closing.update_kernels import Cameras, room_for_pairs, see
from pawnb.core.paws.offline.stride.plausibility_kernels import Doubts, doubt

_LAG = 25.0
"""Stories dearer than the best by this are forgotten."""
_ASTRAY = 50.0
"""Cost of a frame farther from where the stretch begins than a point goes."""


class Shown(NamedTuple):
    """What the frames of a stretch show; certain frames follow those that show candidates.

    Parameters
    ----------
    number : ndarray of int, shape (f, V)
        Candidates of each frame and view.
    at : ndarray, shape (f, V, c, 2)
        Where each says the point is, px.
    against : ndarray, shape (2, f, V, c)
        What speaks against each: a poor look, or that another point explains it; and the same
        for a paw that has just lifted off.
    covered : ndarray of bool, shape (f,)
        Whether another paw covers the point in all views that track it, if it stands.
    certain : ndarray, shape (a, d)
        Certain places in the frames that follow.
    lifting : ndarray, shape (f + a,)
        Cost of lifting off before each frame.
    """

    number: np.ndarray
    at: np.ndarray
    against: np.ndarray
    covered: np.ndarray
    certain: np.ndarray
    lifting: np.ndarray


class Expected(NamedTuple):
    """Where a point is expected in the frames of a stretch and those that follow.

    Parameters
    ----------
    at, variance : ndarray, shape (k, f + a, d)
        The places, by each of some reasons, NaN where there is none, and their variances
        along the axes.
    axes : ndarray, shape (k, d, d)
        Unit vectors.
    most : ndarray, shape (k,)
        Largest cost of being elsewhere.
    """

    at: np.ndarray
    variance: np.ndarray
    axes: np.ndarray
    most: np.ndarray


class How(NamedTuple):
    """How a point is told of.

    Parameters
    ----------
    cameras : Cameras
        What sees it.
    moves, doubts : Moves, Doubts
        How it moves.
    told : Telling
        How its stories are told.
    """

    cameras: Cameras
    moves: Moves
    doubts: Doubts
    told: Telling


class Past(NamedTuple):
    """What the stories were at the end of each frame.

    Parameters
    ----------
    origin : ndarray of int, shape (f, b)
        Which of the stories of the frame before each was.
    taken : ndarray of int, shape (f, V, b)
        Candidates that each took, -1 where none.
    standing : ndarray of bool, shape (f, b)
        Whether it stood.
    """

    origin: np.ndarray
    taken: np.ndarray
    standing: np.ndarray


@compiled
def tell_stretch(
    state: np.ndarray,
    covariance: np.ndarray,
    place: np.ndarray,
    shown: Shown,
    expected: Expected,
    how: How,
) -> tuple[np.ndarray, np.ndarray]:
    """Tell what a point did in a stretch of frames.

    Parameters
    ----------
    state, covariance : ndarray, shape (3, d) and (3, 3)
        Position, speed and acceleration before the first frame, and their covariance, the same
        along each axis.
    place : ndarray, shape (d,)
        Where it stands, NaN where it does not: it goes on standing until it lifts off.
    shown : Shown
        What the frames show.
    expected : Expected
        Where the point is expected.
    how : How
        How it is told of.

    Returns
    -------
    taken : ndarray of int, shape (f, V)
        The candidates that the likeliest story took, -1 where none.
    stood : ndarray of bool, shape (f,)
        Whether the point stands in it.
    """
    told, (frames, views) = how.told, shown.number.shape
    every = frames + len(shown.certain)
    room = max(2 * told.most, told.most_within)
    now, then = room_for(room, len(place), views), room_for(room, len(place), views)
    pairs = room_for_pairs(room * shown.at.shape[2])
    past = Past(
        np.empty((every, told.most), np.int64), np.empty((every, views, told.most), np.int64),
        np.empty((every, told.most), np.bool_),
    )  # fmt: skip
    n = begin(now, state, covariance, place, how.moves)
    for t in range(every):
        n = advance(now, n, then, how.moves, told.kick_cost, shown.lifting[t])
        now, then = then, now
        if t >= frames:
            stand(now, n, shown.certain[t - frames], told.noise**2)
        else:
            for v in range(views):
                c = shown.number[t, v]
                now, then, n = see(
                    now, n, then, v, how.cameras, shown.at[t, v, :c], shown.against[:, t, v, :c],
                    told, pairs,
                )  # fmt: skip
        for k in range(len(expected.at)):
            at, variance = expected.at[k, t], expected.variance[k, t]
            if not np.isnan(at[0]):
                expect(now, n, at, expected.axes[k], variance, expected.most[k])
        charge(now, n, state[0], how, t >= frames, t < frames and shown.covered[t])
        n = settle(now, n, then, told)
        now, then = then, now
        for b in range(n):
            past.origin[t, b], past.standing[t, b] = now.origin[b], now.standing[b]
            for v in range(views):
                past.taken[t, v, b] = now.taken[v, b]
    return _read(past, frames)


@compiled
def charge(
    stories: Stories, n: int, home: np.ndarray, how: How, certain: bool, covered: bool
) -> None:
    """Let stories pay for what is unlikely of them in a frame, and note which are hidden.

    Parameters
    ----------
    stories : Stories
        The stories, and
    n : int
        how many there are.
    home : ndarray, shape (d,)
        Where the point was when they began.
    how : How
        How they are told.
    certain : bool
        Whether the frame had a certain place, so that nothing is hidden.
    covered : bool
        Whether another paw covers the point in all views that track it, if it stands.
    """
    d, told = len(home), how.told
    recent = np.empty(n, np.bool_)
    for b in range(n):
        square = 0.0
        for i in range(d):
            square += (stories.mean[i, b] - home[i]) ** 2
        if square > told.reach * told.reach:
            stories.cost[b] += _ASTRAY
        recent[b] = 0 < stories.since[b] <= told.swinging
        if certain:
            stories.hidden[b] = False
        else:
            stories.cost[b] += _hide(stories, b, how.cameras.own, told, covered)
    doubt(stories.mean[:d, :n], stories.mean[d : 2 * d, :n], recent, how.doubts, stories.cost[:n])


@compiled
def _hide(stories: Stories, b: int, own: np.ndarray, told: Telling, covered: bool) -> float:
    """Return what being seen or hidden costs a story, and note whether it is hidden."""
    views, most, was = 0, 0, stories.hidden[b]
    for v in range(len(own)):
        if own[v]:
            most += 1
            views += stories.taken[v, b] >= 0
    stories.hidden[b] = views == 0
    if views > 0:
        return (told.show if was else 0.0) + told.half * (1.0 - views / most)
    if covered and stories.standing[b]:
        return told.covered
    return told.stay if was else told.hide


@compiled
def settle(now: Stories, n: int, then: Stories, told: Telling) -> int:
    """End the frame: forget unlikely stories and those that tell the same.

    Parameters
    ----------
    now, then : Stories
        The stories, and where those go that are left, the likeliest first.
    n : int
        How many there are.
    told : Telling
        How they are told.

    Returns
    -------
    int
        How many are left.
    """
    size = len(now.mean) // 3 * 2
    grain = np.empty((size, n))
    for i in range(size):
        for b in range(n):
            # rounding may take a variance below nothing
            spread = np.sqrt(max(now.covariance[cell(i, i), b], 0.0))
            grain[i, b] = 0.5 * told.noise + told.alike * spread
    kept, left = np.empty(told.most, np.int64), np.empty(n)
    count, limit = 0, np.inf
    for b in range(n):
        left[b] = now.cost[b]
        limit = min(limit, left[b] + _LAG)
    while count < told.most:
        best = 0
        for b in range(n):
            if left[b] < left[best]:
                best = b
        if left[best] >= limit:
            break
        kept[count] = best
        count += 1
        for b in range(n):
            if left[b] < limit and _alike(now, b, best, grain):
                left[b] = np.inf
    copy(now, kept[:count], then)
    return count


@compiled
def _alike(stories: Stories, a: int, b: int, grain: np.ndarray) -> bool:
    """Tell whether two stories are the same, given differences (2 d, b) that are none."""
    if stories.standing[a] != stories.standing[b]:
        return False
    for i in range(len(grain)):
        apart = abs(stories.mean[i, a] - stories.mean[i, b])
        if apart > min(grain[i, a], grain[i, b]):
            return False
    return True


@compiled
def _read(past: Past, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what the likeliest story took in the first frames, and whether it stood.

    It is read backwards; the likeliest is the first of the last frame.
    """
    every, views, _ = past.taken.shape
    taken, stood = np.empty((frames, views), np.int64), np.empty(frames, np.bool_)
    at = 0
    for t in range(every - 1, -1, -1):
        if t < frames:
            stood[t] = past.standing[t, at]
            for v in range(views):
                taken[t, v] = past.taken[t, v, at]
        at = past.origin[t, at]
    return taken, stood
