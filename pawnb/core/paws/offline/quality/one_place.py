"""Two names on one place, in the pictures and in space: at most one of them is right."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
from scipy.ndimage import binary_opening

from pawnb.arrays import BoolArray
from pawnb.core.paws.offline.quality.labels import Labels, Measure, QualityLimits, in_views
from pawnb.core.paws.offline.quality.parameters import QUALITY

_OF_A_PAIR = ("front", "hind")
"""Kinds of points of which there is one on either side of the animal."""


def on_one_place(labels: Labels, limits: QualityLimits) -> Measure:
    """Measure how long two names lie on one place in all pictures that have both."""

    def near(p: int, q: int) -> BoolArray:
        away = np.linalg.norm(labels.uv[:, :, p] - labels.uv[:, :, q], axis=-1)
        both = np.isfinite(away)
        # in space they share a place only where every view that has both says so
        beside = (away < limits.beside * labels.body_px) | ~both
        return np.asarray(beside.all(axis=1) & both.any(axis=1))

    return _shared(labels, near, lambda _p, _q: limits.beside_s)


def on_one_place_in_space(labels: Labels, limits: QualityLimits) -> Measure:
    """Measure how long two names lie on one place in space, though no picture need show both.

    A paw of the one side that is followed by cameras of the other as well has two names there. A
    front paw and the hind paw that lands beside it come near for a moment; two of a kind do not.
    """
    body = np.nanmax(labels.clicked_apart, initial=0.0)

    def near(p: int, q: int) -> BoolArray:
        away = np.linalg.norm(labels.space[:, p] - labels.space[:, q], axis=-1)
        # what is not known is NaN and compares as False
        return np.asarray(
            away
            < min(
                limits.beside_in_space * body, QUALITY.shared_clicked * labels.clicked_apart[p, q]
            )
        )

    def shortest_s(p: int, q: int) -> float:
        alike = labels.kinds[p] == labels.kinds[q] and labels.kinds[p] in _OF_A_PAIR
        return limits.beside_of_a_kind_s if alike else limits.beside_in_space_s

    return _shared(labels, near, shortest_s)


def _shared(
    labels: Labels,
    near: Callable[[int, int], np.ndarray],
    shortest_s: Callable[[int, int], float],
) -> Measure:
    """Return what is left of labels of which two are ``near`` for longer than a time."""
    _, n_views, n_points = labels.origin.shape
    shared = np.zeros((len(labels.uv), n_points), dtype=bool)
    other = np.zeros(shared.shape, dtype=int)
    for p, q in combinations(range(n_points), 2):
        lasting = np.ones(max(2, round(shortest_s(p, q) * labels.fps) + 1))
        lasts = binary_opening(near(p, q), lasting)
        shared[lasts, p] = shared[lasts, q] = True
        other[lasts, p], other[lasts, q] = q, p
    left = np.where(shared, QUALITY.shared_left, 1.0)
    others = np.repeat(other[:, None], n_views, axis=1)
    return Measure("{point} and {other} lie on one place", in_views(left, labels), others)
