"""Positions in space: a place belongs to one point, and none lies far beyond the body."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core import dlt
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


def misses_clicks(
    uv: FloatArray,
    *,
    clicked: BoolArray,
    chance: FloatArray,
    coefs: FloatArray,
    sure: float,
    gates: FloatArray,
) -> BoolArray:
    """Tell in which views the others put a point elsewhere than where it was clicked.

    Where cameras moved since they were calibrated, or clicks in two views are of two places on
    the skin, a place in space is projected off the point, however sure the other views are of it.
    A view in which a point was not clicked goes by the median of those in which it was.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Positions in the views, px; clicks where there are any.
    clicked : ndarray of bool, shape (n, P, V)
        Where a person placed a point.
    chance : ndarray, shape (n, P, V)
        Probability that each is right, 1 where it was clicked.
    coefs : ndarray, shape (11, V)
        DLT coefficients.
    sure : float
        Other views say where a point is from this probability on, if they are two or more.
    gates : ndarray, shape (V,)
        Distance from a click, px, up to which they hit it: by the median over clicked frames.

    Returns
    -------
    ndarray of bool, shape (P, V)
        False where that is not known.
    """
    if not clicked.any():  # a run that was stopped has no frames at all
        return np.zeros(clicked.shape[1:], bool)
    off = np.full(clicked.shape, np.nan)
    for v in range(clicked.shape[2]):
        rows = np.flatnonzero(clicked[..., v].any(axis=1))
        used = chance[rows] >= sure
        used[..., v] = False
        places = np.where(used[..., None], uv[rows], np.nan)
        found = dlt.triangulate(coefs, places, refine=True).xyz
        shown = dlt.project(coefs, found)[..., v, :]
        away = np.linalg.norm(shown - uv[rows][..., v, :], axis=-1) / gates[v]
        off[rows, :, v] = np.where(clicked[rows, :, v], away, np.nan)
    own = _median_of_known(off, axis=0)
    every = _median_of_known(own, axis=1)
    return np.where(np.isnan(own), every[:, None], own) > 1.0


def _median_of_known(values: FloatArray, *, axis: int) -> FloatArray:
    """Return the median along an axis, NaN where nothing is known."""
    unknown = np.isnan(values).all(axis=axis)
    median = np.nanmedian(np.where(np.expand_dims(unknown, axis), 0.0, values), axis=axis)
    return np.where(unknown, np.nan, median)
