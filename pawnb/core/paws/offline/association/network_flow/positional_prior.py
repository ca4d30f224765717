"""Where each point usually is relative to the body: front paws ahead of hind ones, and so on.

Learnt from the recording itself: tracks that are mostly right say where a point is
how often, relative to the slowly moving middle of all points; a second look then knows
that a front paw does not ride backwards to where hind paws leave the ground.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, joined

_BINS = 160
_MOST = 4.0
"""Largest cost of one frame: a rare place is not an impossible one."""


def follow_body(x: np.ndarray, frames: int) -> np.ndarray:
    """Return the slowly moving middle (n, d) of tracks (n, P, d) with NaN where hidden.

    Parameters
    ----------
    x : ndarray
        Tracks.
    frames : int
        Frames over which the middle is averaged, about two strides.
    """
    n, n_points, d = x.shape
    filled = np.full_like(x, np.nan)
    time = np.arange(n)
    for p in range(n_points):
        seen = np.isfinite(x[:, p, 0])
        if not seen.any():
            continue  # nobody clicked it and it was never found: it tells nothing
        for c in range(d):
            filled[:, p, c] = np.interp(time, time[seen], x[seen, p, c])
    middle = np.nanmean(filled, axis=1)
    return np.asarray(uniform_filter1d(middle, min(frames, n), axis=0, mode="nearest"))


def learn_habits(
    x: np.ndarray,
    body: np.ndarray,
    *,
    axes: Sequence[np.ndarray],
    groups: Sequence[Sequence[str]],
    span: float,
) -> list[list[np.ndarray]]:
    """Learn how often each point is where, along some axes.

    Parameters
    ----------
    x, body : ndarray, shape (n, P, d) and (n, d)
        Tracks, NaN where hidden, and the middle of the body.
    axes : sequence of ndarray, shape (d,)
        Unit vectors.
    groups : sequence
        For each axis the group of each point; points of one group share their habit.
    span : float
        Distance of front from hind paws.

    Returns
    -------
    list of list of ndarray
        For each axis and point, the cost of every bin of :func:`habit_cost`.
    """
    costs = []
    for axis, names in zip(axes, groups, strict=True):
        along = (x - body[:, None]) @ axis
        own = []
        for name in names:
            part = along[:, [other == name for other in names]]
            part = part[np.isfinite(part)]
            count = np.bincount(_bin(part, span), minlength=_BINS).astype(float)
            density = gaussian_filter1d(count, 0.05 * _BINS / 3.0)
            density = density / max(density.max(), 1e-9)
            own.append(np.minimum(-np.log(density + 1e-3), _MOST))
        costs.append(own)
    return costs


def habit_cost(
    pieces: Sequence[Tracklet],
    body: np.ndarray,
    *,
    axes: Sequence[np.ndarray],
    habits: Sequence[Sequence[np.ndarray]],
    span: float,
) -> np.ndarray:
    """Return the cost (P, pieces) of each piece for each point."""
    if not pieces:
        return np.zeros((len(habits[0]), 0))
    frame, at, first = joined(pieces)
    at = at - body[frame]
    total = np.zeros((len(habits[0]), len(pieces)))
    for axis, own in zip(axes, habits, strict=True):
        number = _bin(at @ axis, span)
        for p, cost in enumerate(own):
            total[p] += np.add.reduceat(cost[number], first)
    return total


def _bin(along: np.ndarray, span: float) -> np.ndarray:
    """Return the bin of positions, from -1.5 to 1.5 spans."""
    return np.clip(((along / span + 1.5) / 3.0 * _BINS).astype(int), 0, _BINS - 1)
