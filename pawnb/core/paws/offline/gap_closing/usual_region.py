"""Where a point may be that is not certain: about where it usually is, on no other's place.

The certain places of a point say how far ahead of the middle of the animal, behind it and to its
sides the point ever is. A hind paw that is not seen for some frames is not where front paws
stand, and a left one is not on the right. A place in space belongs to one point: where another
is certain to be, this one is not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
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
    sure: np.ndarray,
    body: np.ndarray | None,
    point: int,
    *,
    frames: np.ndarray,
    motion_model: MotionModel,
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

    Returns
    -------
    UsualRegion
        Without limits where the point is certain in few frames.
    """
    axes = np.ascontiguousarray(motion_model.axes[:-1])
    low = np.full((len(frames), len(axes)), -np.inf)
    high = -low
    known = np.isfinite(sure[:, point, 0])
    if body is not None and known.sum() >= GAP_CLOSING.region_least:
        along = (sure[known, point] - body[known]) @ axes.T
        tail = GAP_CLOSING.region_tail
        few, most = np.quantile(along, (tail, 1.0 - tail), axis=0)
        spare = (GAP_CLOSING.region_ahead, GAP_CLOSING.region_aside)[: len(axes)]
        beyond = motion_model.body_scale * np.array(spare)
        middle = body[frames] @ axes.T
        low, high = middle + few - beyond, middle + most + beyond
    others = np.delete(sure[frames], point, axis=1)
    if body is None or len(axes) < 2:
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
