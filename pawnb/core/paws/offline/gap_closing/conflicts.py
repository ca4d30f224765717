"""Detections that two points took: a place in space belongs to one of them.

Stretches in which points are not certain are closed one by one. A front paw that is not seen where
it lifts off, and the hind paw that lands beside it, may then both take what shows the one. Where
two views agree on that, one of the two goes without: the one that finds something else more easily.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.gap_closing.gap import Gap
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING

_LEAST_VIEWS = 2
"""Definition: so many views tell a place in space; in one alone points meet that do not meet
there."""


@dataclass(frozen=True)
class ClosedGap:
    """What a point did in a stretch of f frames.

    Parameters
    ----------
    point : int
        Its number.
    gap : Gap
        The stretch.
    taken : ndarray of int, shape (f, V)
        The detections taken, -1 where none.
    stood : ndarray of bool, shape (f,)
        Where the point stands, and
    standing : ndarray, shape (stood frames, d)
        on which places.
    cost : float
        Minus the logarithm of how likely that is.
    """

    point: int
    gap: Gap
    taken: IntArray
    stood: BoolArray
    standing: FloatArray
    cost: float


def resolve_conflicts(
    closed: list[ClosedGap],
    close_again: Callable[[ClosedGap, AnyArray], ClosedGap],
    n_detections: int,
) -> list[ClosedGap]:
    """Leave detections that two points took to one of them.

    A stretch goes without all that its rivals took, or they go without what it took, whichever is
    likelier. Stretches with most rivals come first: a point on the paw of another meets it again
    and again.

    Parameters
    ----------
    closed : list of ClosedGap
        What was found for every stretch by itself.
    close_again : callable
        Closes a stretch again, given what speaks against each detection besides, (f, V, C).
    n_detections : int
        Most detections C in a picture.

    Returns
    -------
    list of ClosedGap
        In the same order.
    """
    closed = list(closed)
    against = [np.zeros((*one.taken.shape, n_detections)) for one in closed]

    def without(goes: int, others: list[int]) -> tuple[ClosedGap, FloatArray]:
        claimed = against[goes].copy()
        for k in others:
            claimed = np.maximum(claimed, _claims(closed[k], closed[goes], n_detections))
        return close_again(closed[goes], claimed), claimed

    rivals = [[k for k in range(len(closed)) if _share(one, closed[k])] for one in closed]
    for one in sorted(range(len(closed)), key=lambda k: -len(rivals[k])):
        left = [k for k in rivals[one] if _share(closed[one], closed[k])]
        if not left:
            continue
        yields = {one: without(one, left)}
        prevails = {k: without(k, [one]) for k in left}
        gain = sum(closed[k].cost - other.cost for k, (other, _) in yields.items())
        loss = sum(closed[k].cost - other.cost for k, (other, _) in prevails.items())
        for k, (other, claimed) in (yields if gain >= loss else prevails).items():
            closed[k], against[k] = other, claimed
    return closed


def _share(one: ClosedGap, other: ClosedGap) -> bool:
    """Tell whether two points took the same detections of two views in a frame."""
    if one.point == other.point:
        return False
    mine, theirs = _together(one, other)
    a, b = one.taken[mine], other.taken[theirs]
    return bool((((a == b) & (a >= 0)).sum(axis=1) >= _LEAST_VIEWS).any())


def _together(one: ClosedGap, other: ClosedGap) -> tuple[IntArray, IntArray]:
    """Return the rows of either of the frames that both have."""
    _, mine, theirs = np.intersect1d(one.gap.frames, other.gap.frames, return_indices=True)
    return mine, theirs


def _claims(stays: ClosedGap, goes: ClosedGap, n_detections: int) -> FloatArray:
    """Return what speaks against detections (f, V, C) of one that another took."""
    cost = np.zeros((*goes.taken.shape, n_detections))
    theirs, mine = _together(stays, goes)
    taken = stays.taken[theirs]
    row, view = np.nonzero(taken >= 0)
    cost[mine[row], view, taken[row, view]] = GAP_CLOSING.gap_closing_other
    return cost
