"""The inner loop of :mod:`pawnb.core.paws.offline.gap_closing.wrist_decoys`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled

NEAREST, FARTHEST = 0.8, 2.5
"""Detections at such distances from a paw that stands, in paw widths, may be its wrist. Set by
hand."""
ALIKE = 0.5
"""A detection is that of the frame before if it is within so many paw widths of where that was to
be. Set by hand."""
RISEN = 0.7
"""What has moved so many paw widths against the ground has left it, and may be the paw itself: it
goes up to where its wrist was. Set by hand."""


@compiled
def follow(
    at: np.ndarray,
    count: np.ndarray,
    last: np.ndarray,
    stood: np.ndarray,
    paw_width: float,
    steps: int,
    found: np.ndarray,
    away: np.ndarray,
) -> None:
    """Follow what is apart from a paw that stands into the frames after, in one view.

    Parameters
    ----------
    at : ndarray, shape (n, C, 2)
        Detections, px, those that are there first.
    count : ndarray of int, shape (n,)
        How many are there.
    last : ndarray of int, shape (S,)
        Last frame of each stance, at least 1.
    stood : ndarray, shape (S, 2, 2)
        Where the paw stood in that frame, px, and in the one before it.
    paw_width : float
        Of a paw, px.
    steps : int
        Frames for which it is followed.
    found : ndarray of bool, shape (n, C)
        Set where a detection was followed to, and
    away : ndarray, shape (n, C, 2)
        how far it was from the paw, px, when that was last seen to stand.
    """
    place, speed, substrate = np.empty(2), np.empty(2), np.empty(2)
    for s in range(len(last)):
        t = last[s]
        for i in range(count[t]):
            if not _is_apart(at[t, i], stood[s, 0], paw_width):
                continue
            # what stays about a paw that stands goes with the ground, as that does
            for c in range(2):
                substrate[c] = stood[s, 0, c] - stood[s, 1, c]
                place[c] = at[t, i, c] - substrate[c]
            k = _nearest(at[t - 1], count[t - 1], place, paw_width)
            if k < 0 or not _is_apart(at[t - 1, k], stood[s, 1], paw_width):
                continue
            speed[0], speed[1] = at[t, i, 0] - at[t - 1, k, 0], at[t, i, 1] - at[t - 1, k, 1]
            here = i
            for then in range(t + 1, min(t + 1 + steps, len(at))):
                for c in range(2):
                    place[c] = at[then - 1, here, c] + speed[c]
                k = _nearest(at[then], count[then], place, paw_width)
                if k < 0:
                    break
                for c in range(2):
                    place[c] = at[t, i, c] + (then - t) * substrate[c]
                if _distance(at[then, k], place) > RISEN * paw_width:
                    break
                found[then, k] = True
                for c in range(2):
                    away[then, k, c] = at[t, i, c] - stood[s, 0, c]
                    speed[c] = 0.5 * (speed[c] + at[then, k, c] - at[then - 1, here, c])
                here = k


@compiled
def _is_apart(at: np.ndarray, paw: np.ndarray, paw_width: float) -> bool:
    """Tell whether a detection is near a paw, but not the paw."""
    return NEAREST * paw_width < _distance(at, paw) < FARTHEST * paw_width


@compiled
def _nearest(at: np.ndarray, count: int, place: np.ndarray, paw_width: float) -> int:
    """Return the detection nearest to a place, -1 where none is near."""
    best, least = -1, ALIKE * paw_width
    for i in range(count):
        away = _distance(at[i], place)
        if away < least:
            best, least = i, away
    return best


@compiled
def _distance(a: np.ndarray, b: np.ndarray) -> float:
    """Return how far two places are apart."""
    return np.hypot(a[0] - b[0], a[1] - b[1])
