"""The inner loop of :mod:`pawnb.core.paws.offline.gap_closing.clutter.wrist_clutter`, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled


class WristGates(NamedTuple):
    """Distances, px, by which wrists are followed; see the ``wrist_...`` of the stage.

    Parameters
    ----------
    nearest, farthest : float
        How near to a paw that stands its wrist may be, and how far from it.
    same : float
        How far what is followed may be from where it is expected.
    risen : float
        How far from the ground what is followed may be.
    """

    nearest: float
    farthest: float
    same: float
    risen: float


@compiled
def follow(
    at: np.ndarray,
    count: np.ndarray,
    last: np.ndarray,
    stood: np.ndarray,
    gates: WristGates,
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
    gates : WristGates
        Distances, px.
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
            if not _is_apart(at[t, i], stood[s, 0], gates):
                continue
            # what stays about a paw that stands goes with the ground, as that does
            for c in range(2):
                substrate[c] = stood[s, 0, c] - stood[s, 1, c]
                place[c] = at[t, i, c] - substrate[c]
            k = _nearest(at[t - 1], count[t - 1], place, gates.same)
            if k < 0 or not _is_apart(at[t - 1, k], stood[s, 1], gates):
                continue
            speed[0], speed[1] = at[t, i, 0] - at[t - 1, k, 0], at[t, i, 1] - at[t - 1, k, 1]
            here = i
            for then in range(t + 1, min(t + 1 + steps, len(at))):
                for c in range(2):
                    place[c] = at[then - 1, here, c] + speed[c]
                k = _nearest(at[then], count[then], place, gates.same)
                if k < 0:
                    break
                for c in range(2):
                    place[c] = at[t, i, c] + (then - t) * substrate[c]
                if _distance(at[then, k], place) > gates.risen:
                    break
                found[then, k] = True
                for c in range(2):
                    away[then, k, c] = at[t, i, c] - stood[s, 0, c]
                    speed[c] = 0.5 * (speed[c] + at[then, k, c] - at[then - 1, here, c])
                here = k


@compiled
def _is_apart(at: np.ndarray, paw: np.ndarray, gates: WristGates) -> bool:
    """Tell whether a detection is near a paw, but not the paw."""
    return gates.nearest < _distance(at, paw) < gates.farthest


@compiled
def _nearest(at: np.ndarray, count: int, place: np.ndarray, within: float) -> int:
    """Return the detection nearest to a place, -1 where none is near."""
    best, least = -1, within
    for i in range(count):
        away = _distance(at[i], place)
        if away < least:
            best, least = i, away
    return best


@compiled
def _distance(a: np.ndarray, b: np.ndarray) -> float:
    """Return how far two places are apart."""
    return np.hypot(a[0] - b[0], a[1] - b[1])
