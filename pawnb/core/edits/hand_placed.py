"""Where a person placed a point in two views or more, these say where it is in space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, Points2D, Points3D

_CLICK_SD_PX = 2.0
"""What clicks are off by, px, where they agree better by chance: set by hand. In mouse-4cam-cage
(proofread points of a mouse, four cameras whose calibration is off by 3 to 10 px) the residual of
two views is often larger, and counts then."""
_MOST_SD = 3.0
"""A tracked view that lies farther off than this many standard deviations is on something else.
Measured in mouse-4cam-cage, two views by hand: a third that is 80 px off counts in 0 to 24 % and
moves the place by a median of 3 to 12 mm from that of all views (6 to 53 mm where it counted
alike); one that is right counts in 34 to 100 %, less often where its calibration is off."""


def views_in_force(
    uv: Points2D,
    *,
    used: BoolArray,
    by_hand: BoolArray,
    triangulate: Callable[[Points2D, BoolArray], tuple[AnyArray, AnyArray]],
    project: Callable[[Points3D], FloatArray],
) -> BoolArray:
    """Leave out tracked views that disagree with what a person placed in two views or more.

    How far a tracked view may lie off is told from the clicks: by their residual, and by how far
    the place that they give moves in that view if each is a pixel off. So two views from nearly
    the same side leave the third its say on the distance.

    Parameters
    ----------
    uv : ndarray, shape (..., V, 2)
        Image positions, px.
    used : ndarray of bool, shape (..., V)
        Views that see the point.
    by_hand : ndarray of bool, shape (..., V)
        Views in which a person placed it.
    triangulate : callable
        Gives places (..., 3) and residuals (...) px of ``uv`` and views that count.
    project : callable
        Gives image positions (..., V, 2) of places.

    Returns
    -------
    ndarray of bool, shape (..., V)
        ``used`` without those views.
    """
    hand = used & by_hand
    asked = (hand.sum(axis=-1) >= 2) & (used & ~hand).any(axis=-1)
    if not asked.any():
        return used
    own, counts = uv[asked], hand[asked]
    xyz, residual = triangulate(own, counts)
    seen = np.asarray(project(xyz))
    spread = np.broadcast_to(np.eye(2), (*own.shape, 2)).copy()
    for view in range(own.shape[-2]):
        for axis in range(2):
            moved = own.copy()
            moved[:, view, axis] += counts[:, view]
            shift = np.asarray(project(triangulate(moved, counts)[0])) - seen
            spread += shift[..., :, None] * shift[..., None, :]
    off = own - seen
    known = np.isfinite(spread).all(axis=(-2, -1)) & np.isfinite(off).all(axis=-1)
    spread[~known] = np.eye(2)
    apart = np.einsum("...i,...ij,...j->...", off, np.linalg.inv(spread), off)
    sd = np.maximum(residual, _CLICK_SD_PX)[:, None]
    agree = ~known | (apart <= (_MOST_SD * sd) ** 2)
    result = used.copy()
    result[asked] &= counts | agree
    return result
