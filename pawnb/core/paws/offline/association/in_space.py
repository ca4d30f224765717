"""Positions in space: a place belongs to one point, and none lies far beyond the body."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.quality.measures import largest_distance

_MOST_CHANCE = 1 - 1e-6
"""Guard: chances of 1 on one place would leave nothing to compare."""


def surest_two(chance: FloatArray) -> FloatArray:
    """Return how likely points are where they are in space: they need two views.

    Parameters
    ----------
    chance : ndarray, shape (n, P, V)
        Probability that the label in each view is right.

    Returns
    -------
    ndarray, shape (n, P)
        The second largest; of one view its own.
    """
    if chance.shape[2] < 2:
        return np.asarray(chance[..., 0])
    return np.asarray(np.sort(chance, axis=2)[..., -2])


def shared_places(x: FloatArray, chance: FloatArray, nearest: float) -> FloatArray:
    """Return what is left of the chance of each point by others that lie on its place.

    Of points nearer to each other than two paws can be, at most one is right. With odds
    w = p / (1 - p) of each by itself, that one is the point has the probability w / (1 + sum of w).

    Parameters
    ----------
    x : ndarray, shape (n, P, 3)
        Positions in space; NaN where unknown.
    chance : ndarray, shape (n, P)
        How likely each is by itself, 0 to 1.
    nearest : float
        Distance that two points keep at least, in the unit of ``x``.

    Returns
    -------
    ndarray, shape (n, P)
        Factors, 1 where a point is alone.
    """
    near = np.linalg.norm(x[:, :, None] - x[:, None], axis=-1) < nearest
    own = np.arange(x.shape[1])
    near[:, own, own] = True
    p = np.clip(np.nan_to_num(chance), 0.0, _MOST_CHANCE)
    odds = p / (1 - p)
    total = (near * odds[:, None]).sum(axis=2)
    # w / (1 + total) / p, with p = w / (1 + w)
    return np.asarray((1 + odds) / (1 + total))


def beyond_body(x: FloatArray, chance: FloatArray, *, sure: float, gate: float) -> BoolArray:
    """Tell which positions in space are farther from the other points than any animal reaches.

    Parameters
    ----------
    x : ndarray, shape (n, P, 3)
        Positions in space; NaN where unknown.
    chance : ndarray, shape (n, P)
        How likely each is.
    sure : float
        Points from this chance on say where the body is, and how large.
    gate : float
        Largest distance from the middle of the other points, in body sizes: the usual largest
        distance between two sure points.

    Returns
    -------
    ndarray of bool, shape (n, P)
        False where no other point is sure.
    """
    sound = np.where((chance >= sure)[..., None], x, np.nan)
    spans = np.array([largest_distance(here) for here in sound])
    beyond = np.zeros(x.shape[:2], bool)
    if not np.isfinite(spans).any():
        return beyond
    reach = gate * float(np.nanmedian(spans))
    for p in range(x.shape[1]):
        others = np.delete(sound, p, axis=1)
        some = np.isfinite(others[..., 0]).any(axis=1)
        middle = np.nanmedian(others[some], axis=1)
        beyond[some, p] = np.linalg.norm(x[some, p] - middle, axis=-1) > reach
    return beyond
