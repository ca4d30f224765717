"""Where a point may be that is not certain: about where it usually is, on no other's place.

The certain places of a point say how far ahead of the middle of the animal, behind it and to its
sides the point ever is. A hind paw that is not seen for some frames is not where front paws
stand, and a left one is not on the right. A place in space belongs to one point: where another
is certain to be, this one is not. A point that is certain in few frames goes as far as those of
its kind, on the side of the animal where it was placed by hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.scene.motion_model import MotionModel


class UsualRegion(NamedTuple):
    """Where a point may be in the frames of a stretch and those that follow.

    Parameters
    ----------
    axes : ndarray, shape (k, d)
        Unit vectors: forward and, in space, across.
    low, high : ndarray, shape (f + a, k)
        How far along each of them the point usually is, infinite where nothing is known.
    sd : float
        How far beyond is one standard deviation.
    others : ndarray, shape (f + a, q, d)
        Where the other points certainly are in space, NaN elsewhere.
    nearest : float
        Distance that two points keep.
    shared : float
        Cost of a frame on another point's place.
    """

    axes: np.ndarray
    low: np.ndarray
    high: np.ndarray
    sd: float
    others: np.ndarray
    nearest: float
    shared: float


def usual_region(
    sure: FloatArray,
    body: FloatArray | None,
    point: int,
    *,
    frames: IntArray,
    motion_model: MotionModel,
    alike: Sequence[tuple[int, FloatArray]] = (),
    are_apart: bool = True,
) -> UsualRegion:
    """Learn where a point may be.

    Parameters
    ----------
    sure : ndarray, shape (n, P, d)
        Certain places, NaN elsewhere.
    body : ndarray, shape (n, d), optional
        The slowly moving middle of the animal; without it nothing is known.
    point : int
        The point.
    frames : ndarray of int
        The frames in question.
    motion_model : MotionModel
        Axes and size of the animal.
    alike : sequence of (int, ndarray)
        Points that go as far, and the step (d,) from each to this one; see :func:`same_kind`.
        They are asked where the point itself is certain in few frames.
    are_apart : bool
        Whether places are known so well that two points keep their distance, and that a point's
        own say how far it goes.

    Returns
    -------
    UsualRegion
        Without limits where they all are certain in few frames, or its own places are not asked.
    """
    axes = np.ascontiguousarray(motion_model.axes[:-1])
    low = np.full((len(frames), len(axes)), -np.inf)
    high = -low
    along = _about_body(sure, body, point, axes)
    is_own = len(along) >= GAP_CLOSING.region_least
    if not is_own:
        others_alike = [_about_body(sure, body, p, axes) + step @ axes.T for p, step in alike]
        along = np.concatenate([along, *others_alike])
    # places that err show too little of swings to say how far the point itself goes
    is_told = len(along) >= GAP_CLOSING.region_least and (are_apart or not is_own)
    if body is not None and is_told:
        tail = GAP_CLOSING.region_tail
        few, most = np.quantile(along, (tail, 1.0 - tail), axis=0)
        spare = (GAP_CLOSING.region_ahead, GAP_CLOSING.region_aside)[: len(axes)]
        beyond = motion_model.body_scale * np.array(spare)
        middle = body[frames] @ axes.T
        low, high = middle + few - beyond, middle + most + beyond
    others = np.delete(sure[frames], point, axis=1)
    if body is None or len(axes) < 2 or not are_apart:
        others = others[:, :0]  # in one picture points meet that do not meet in space
    return UsualRegion(
        axes,
        low,
        high,
        GAP_CLOSING.region_sd * motion_model.body_scale,
        np.ascontiguousarray(others),
        GAP_CLOSING.region_nearest * motion_model.paw_width,
        GAP_CLOSING.region_shared,
    )


def same_kind(
    assignment: Assignment,
    body: FloatArray | None,
    point: int,
    *,
    kinds: Sequence[str],
    across: FloatArray,
) -> list[tuple[int, FloatArray]]:
    """Return the other points of a kind, with the step from the side of each to this one's.

    Front paws go as far ahead and behind as each other, and so do hind ones; how far to the side
    of each other they do is told by where they were placed by hand.

    Parameters
    ----------
    assignment : Assignment
        Certain places.
    body : ndarray, shape (n, d), optional
        The slowly moving middle of the animal.
    point : int
        The point.
    kinds : sequence of str
        Kind of each point.
    across : ndarray, shape (d,)
        Unit vector to the side.

    Returns
    -------
    list of (int, ndarray)
        Numbers of points, and steps (d,); none for points that nobody placed.
    """
    if body is None:
        return []
    steps = []
    for other, kind in enumerate(kinds):
        if other == point or kind != kinds[point]:
            continue
        side = [
            np.mean((assignment.at[here, p] - body[here]) @ across)
            for p in (other, point)
            if (here := assignment.by_hand[:, p]).any()
        ]
        if len(side) == 2:
            steps.append((other, (side[1] - side[0]) * across))
    return steps


def _about_body(
    sure: np.ndarray, body: np.ndarray | None, point: int, axes: np.ndarray
) -> np.ndarray:
    """Return how far along axes (m, k) a point is from the middle of the animal where certain."""
    if body is None:
        return np.empty((0, len(axes)))
    known = np.isfinite(sure[:, point, 0])
    return np.asarray((sure[known, point] - body[known]) @ axes.T)


@compiled
def add_region_cost(x: np.ndarray, region: UsualRegion, frame: int, cost: np.ndarray) -> None:
    """Add what speaks against positions to costs.

    Parameters
    ----------
    x : ndarray, shape (d, b)
        Where the point may be.
    region : UsualRegion
        Where it usually is.
    frame : int
        Row of the region.
    cost : ndarray, shape (b,)
        Costs, added to.
    """
    d = len(x)
    for b in range(len(cost)):
        for k in range(len(region.axes)):
            along = 0.0
            for i in range(d):
                along += x[i, b] * region.axes[k, i]
            beyond = max(region.low[frame, k] - along, along - region.high[frame, k], 0.0)
            cost[b] += 0.5 * (beyond / region.sd) ** 2
        for q in range(region.others.shape[1]):
            square = 0.0
            for i in range(d):
                square += (x[i, b] - region.others[frame, q, i]) ** 2
            # NaN where the other is not certain compares as False
            if square < region.nearest**2:
                cost[b] += region.shared * (1.0 - np.sqrt(square) / region.nearest)
