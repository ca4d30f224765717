"""Which certain places of a point are associated again after all.

A path of certain places may leave its point: it is drawn to another paw and lost there, or it
stands again where no paw can have swung to. What is known of the recording's strides tells.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.stance import Stance, learn_substrate
from pawnb.core.paws.offline.stride.swing import Swings


def frames_to_reassociate(
    chosen: FloatArray,
    annotated: BoolArray,
    *,
    motion_model: MotionModel,
    duty_factor: DutyFactor | None = None,
    swings: Swings | None = None,
) -> BoolArray:
    """Return the frames in which points are not certain, or not any more.

    Parameters
    ----------
    chosen : ndarray, shape (n, P, d)
        Certain places, NaN elsewhere.
    annotated : ndarray of bool, shape (n, P)
        Placed by hand: those are never associated again.
    motion_model : MotionModel
        How points move.
    duty_factor : DutyFactor, optional
        When they lift off.
    swings : Swings, optional
        Where they swing.

    Returns
    -------
    ndarray of bool, shape (n, P)
        True in those frames.
    """
    certain = np.isfinite(chosen[..., 0])
    is_open = np.stack(
        [open_frames(*of) for of in zip(certain.T, annotated.T, strict=True)], axis=1
    )
    sure = np.where(is_open[..., None], np.nan, chosen)
    off = (
        np.zeros(is_open.shape, bool)
        if swings is None
        else off_trajectory(sure, swings, motion_model)
    )
    for p, mine in enumerate(learn_substrate(sure, motion_model).stances(sure)):
        lost = off[:, p] | drawn_off(
            mine, is_open[:, p], most=round(GAP_CLOSING.drawn_s * motion_model.fps)
        )
        if duty_factor is not None:
            lost |= hops(mine, is_open[:, p], least=duty_factor.shortest_swing(p))
        is_open[lost & ~annotated[:, p], p] = True
    return is_open


def off_trajectory(sure: FloatArray, swings: Swings, motion_model: MotionModel) -> BoolArray:
    """Tell which places (n, P, d) are off the arcs of swings, forward or up; shape (n, P).

    Parameters
    ----------
    sure : ndarray, shape (n, P, d)
        Places.
    swings : Swings
        The arcs.
    motion_model : MotionModel
        Axes and size of the animal.

    Returns
    -------
    ndarray of bool, shape (n, P)
        Which are off.
    """
    step = (sure - swings.place) @ motion_model.axes.T
    size = np.hypot(swings.sd, GAP_CLOSING.off_at_least * motion_model.paw_width)
    square = (step / size)[..., [0, -1]] ** 2
    # NaN where nothing is known compares as False
    return np.asarray(square.sum(axis=-1) > GAP_CLOSING.off_arc**2)


def drawn_off(stances: Sequence[Stance], is_open: BoolArray, *, most: int) -> BoolArray:
    """Tell which frames of a point lie between the end of a stance and a gap soon after it.

    What seems to lift off and is lost at once was mostly drawn off: the end of its path lies on
    the paw that lands there.

    Parameters
    ----------
    stances : sequence of Stance
        Those of the point.
    is_open : ndarray of bool, shape (n,)
        Frames without a certain place.
    most : int
        Frames in which the gap must begin.

    Returns
    -------
    ndarray of bool, shape (n,)
        True in those frames.
    """
    lost = np.zeros(len(is_open), bool)
    for one in stances:
        near = is_open[one.stop : one.stop + most + 1]
        # one that has stood since before the first frame may have for long
        settled = not one.first or one.stop - one.first >= GAP_CLOSING.rejection_settled
        if settled and near.any():
            lost[one.stop : one.stop + int(np.argmax(near))] = True
    return lost


def hops(stances: Sequence[Stance], is_open: BoolArray, *, least: float) -> BoolArray:
    """Tell which frames of a point belong to a stance that no swing leads to.

    Of two stances with hardly a swing between them the shorter one is another paw's, with all of
    the certain path that leads away from the longer one.

    Parameters
    ----------
    stances : sequence of Stance
        Those of the point.
    is_open : ndarray of bool, shape (n,)
        Frames without a certain place.
    least : float
        Frames that a swing lasts.

    Returns
    -------
    ndarray of bool, shape (n,)
        True in those frames.
    """
    lost = np.zeros(len(is_open), bool)
    for now, after in pairwise(stances):
        if after.first - now.stop >= least or lost[now.first : now.stop].any():
            continue
        if after.stop - after.first <= now.stop - now.first:
            lost[now.stop : after.stop + _until_open(is_open[after.stop :])] = True
        else:
            lost[now.first - _until_open(is_open[: now.first][::-1]) : after.first] = True
    return lost


def without_hops(
    stances: Sequence[Sequence[Stance]], is_open: BoolArray, duty_factor: DutyFactor | None
) -> tuple[list[list[Stance]], BoolArray]:
    """Leave out stances that no swing leads to: what follows the last of them is another paw.

    Parameters
    ----------
    stances : sequence
        Those of each point.
    is_open : ndarray of bool, shape (n, P)
        Frames without a certain place.
    duty_factor : DutyFactor, optional
        How long swings last; without it all are kept.

    Returns
    -------
    kept : list of list of Stance
        The others.
    lost : ndarray of bool, shape (n, P)
        Frames in which a point was on another paw; see :func:`hops`.
    """
    lost = np.zeros(is_open.shape, bool)
    if duty_factor is not None:
        for p, mine in enumerate(stances):
            lost[:, p] = hops(mine, is_open[:, p], least=duty_factor.shortest_swing(p))
    kept = [
        [one for one in mine if not lost[one.first : one.stop, p].any()]
        for p, mine in enumerate(stances)
    ]
    return kept, lost


def _until_open(is_open: BoolArray) -> int:
    """Return how many frames come before the first open one."""
    return int(np.argmax(is_open)) if is_open.any() else len(is_open)


def open_frames(certain: BoolArray, annotated: BoolArray) -> BoolArray:
    """Return the frames (n,) of one point whose detections are to be chosen.

    Parameters
    ----------
    certain : ndarray of bool, shape (n,)
        Frames with a certain place.
    annotated : ndarray of bool, shape (n,)
        Those placed by hand; they stay.
    """
    is_open = ~certain
    for first, stop in runs(certain):
        if stop - first < GAP_CLOSING.rejection_least:
            is_open[first:stop] = True
    return np.asarray(is_open & ~(annotated & certain))


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return first frame and one past the last of every run of True."""
    edge = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edge.reshape(-1, 2)]
