"""Where two points pass each other: there they are most easily mistaken for one another."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import Points2D

CLOSE = 0.25
"""Two points pass each other where they come nearer than this share of their usual (median)
distance in some view. A choice, not a measurement: feet of a left and right leg that are at
opposite phases come within a tenth of it twice a stride, feet that keep their distance never do."""


def find_crossings(first: Points2D, second: Points2D) -> list[tuple[int, int, int]]:
    """Find the encounters in which two points pass each other.

    Parameters
    ----------
    first, second : ndarray, shape (n, V, 2)
        Image positions in V views, px; NaN where missing. Over gaps a straight path is taken.

    Returns
    -------
    list of (begin, nearest, stop)
        Rows of each encounter, half open, and that of least distance, in order; those of
        several views that overlap count once.
    """
    n = len(first)
    near = np.full(n, np.inf)
    for view in range(first.shape[1]):
        apart = np.hypot(*(_bridged(first[:, view]) - _bridged(second[:, view])).T)
        if np.isfinite(apart).any():
            usual = float(np.nanmedian(apart))
            if usual > 0:
                near = np.fmin(near, apart / usual)
    close = np.concatenate([[False], near < CLOSE, [False]])
    edges = np.flatnonzero(close[1:] != close[:-1]).reshape(-1, 2)
    return [(int(a), int(a + np.argmin(near[a:b])), int(b)) for a, b in edges]


def _bridged(uv: np.ndarray) -> np.ndarray:
    """Return (n, 2) positions with a straight path over the gaps between known ones."""
    known = np.flatnonzero(np.isfinite(uv).all(axis=1))
    if not len(known):
        return np.full_like(uv, np.nan)
    rows = np.arange(len(uv))
    paths = [np.interp(rows, known, uv[known, k], left=np.nan, right=np.nan) for k in (0, 1)]
    return np.stack(paths, axis=1)
