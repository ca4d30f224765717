"""What each correction does to Tracks: image positions first, then the 3D point again."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np

from pawnb.arrays import BoolArray, IntArray
from pawnb.core.edits.copies import copy_tracks
from pawnb.core.edits.exchanges import exchange_again
from pawnb.core.edits.hidden import hide_again
from pawnb.core.edits.pose_stretches import edit_legs
from pawnb.core.edits.records import (
    Accept,
    Delete,
    Edit,
    Hide,
    Interpolate,
    Move,
    Pose,
    Retrack,
    Swap,
)
from pawnb.core.edits.solving import PositionSolver, RigLike
from pawnb.core.edits.stretches import (
    EDITED,
    clear,
    interpolate,
    only_within,
    place_of,
    row_of,
    rows_of_edit,
)
from pawnb.core.pose.as_tracks import is_pose
from pawnb.core.pose.corrected import put_pose
from pawnb.errors import InputError
from pawnb.schema import Tracks, check_tracks

Retracker = Callable[..., Tracks]


def apply_edit(
    tracks: Tracks,
    edit: Edit,
    *,
    rig: RigLike | None = None,
    px_per_unit: float | None = None,
    retrack: Retracker | None = None,
    hidden: Iterable[Hide] = (),
    exchanged: Iterable[Swap] = (),
) -> Tracks:
    """Return Tracks with one correction applied.

    A corrected point is of origin ``edited`` with confidence 1. Its 3D position and
    residual are computed again from the views that see it (measured, resolved or
    edited; predicted ones only where fewer than two see it), and the views that show
    it as ``reprojected`` follow. What a person placed in the only view that sees it stays as
    far from that camera as it was (origin ``resolved``), if it had a place in space. Without a
    rig, ``position`` is the image position in the first view that has the point.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one individual with image positions; not modified.
    edit : Move, Accept, Hide, Swap, Pose or Retrack
        The correction. Of a jointed animal it is a whole pose, tracking again, or what is done to
        its legs over a stretch (:func:`pawnb.core.edits.pose_stretches.edit_legs`).
    rig : Rig, optional
        The calibrated views.
    px_per_unit : float, optional
        Scale of a single view whose ``position`` is in real units, px per unit.
    retrack : callable, optional
        ``retrack(tracks, frame)`` tracks again from a frame on; needed for ``Retrack``. It is
        called with ``learn=True`` as well where colours are to be learnt anew.
        What a person corrected in that frame and after it is put back into its result.
    hidden : iterable of Hide
        Points a person marked as not visible; those of later frames are marked again
        after tracking again.
    exchanged : iterable of Swap
        Exchanges that a person made; they hold after tracking again.

    Returns
    -------
    xarray.Dataset
        New Tracks.

    Raises
    ------
    InputError
        If the frame, view or point is not in the tracks, or the correction is of another kind
        of animal.
    """
    check_editable(tracks)
    row = row_of(tracks, edit.frame)
    if isinstance(edit, Pose):
        return put_pose(tracks, edit.frame, edit.pose)
    if isinstance(edit, Retrack):
        if retrack is not None and edit.learn:
            retrack = partial(retrack, learn=True)
        track_again = _poses_again if is_pose(tracks) else _points_again
        new = track_again(tracks, edit.frame, retrack, rig, px_per_unit)
        exchange = partial(apply_edit, rig=rig, px_per_unit=px_per_unit)
        new = exchange_again(tracks, new, exchanged, frame=edit.frame, exchange=exchange)
        solver = partial(PositionSolver, rig=rig, px_per_unit=px_per_unit)
        new = hide_again(new, hidden, frame=edit.frame, solver=solver)
        return new if edit.stop is None else only_within(tracks, new, edit)
    if is_pose(tracks) and isinstance(edit, Swap | Interpolate | Hide | Delete):
        return edit_legs(tracks, edit)
    if is_pose(tracks):
        raise InputError(
            "a point of a jointed animal cannot be moved by itself; correct its pose with "
            "pawnb.widgets.PoseReviewer(trial, tracks)."
        )
    new = copy_tracks(tracks)
    solve = PositionSolver(new, rig, px_per_unit)
    rows = rows_of_edit(new, edit)
    if isinstance(edit, Swap):
        _swap(new, edit, rows, solve)
        return new
    if isinstance(edit, Interpolate):
        interpolate(new, rows, edit.point, view=edit.view)
    elif isinstance(edit, Hide | Delete):
        clear(new, rows, edit.point, view=edit.view)
    else:
        _put(new, row, edit)
    point, placed = place_of(new, "keypoint", edit.point), isinstance(edit, Move | Accept)
    solve(np.arange(rows.start, rows.stop), [point], keep_depth=placed)
    return new


def check_editable(tracks: Tracks) -> None:
    """Raise InputError unless these are Tracks of one animal with image positions."""
    check_tracks(tracks)
    if "image_position" not in tracks:
        raise InputError(
            "these tracks have no image positions, so there is nothing to correct in a picture; "
            "open tracks that pawnb made from video."
        )
    if tracks.sizes["individual"] != 1:
        raise InputError(
            f"these tracks hold {tracks.sizes['individual']} individuals; "
            "choose one with tracks.isel(individual=[0])."
        )


def _put(tracks: Tracks, row: int, edit: Move | Accept) -> None:
    """Write one image position."""
    view, point = place_of(tracks, "view", edit.view), place_of(tracks, "keypoint", edit.point)
    tracks["image_position"].values[row, view, :, point, 0] = edit.u, edit.v
    tracks["image_origin"].values[row, view, point, 0] = EDITED
    tracks["image_confidence"].values[row, view, point, 0] = 1.0


def _swap(tracks: Tracks, edit: Swap, rows: slice, solve: PositionSolver) -> None:
    """Exchange two points over some rows, in one view or in everything there is."""
    if edit.first == edit.second:
        raise InputError(f"a point cannot be exchanged with itself ({edit.first!r}).")
    pair = [place_of(tracks, "keypoint", name) for name in (edit.first, edit.second)]
    if edit.view is not None:
        view = place_of(tracks, "view", edit.view)
        for name in ("image_position", "image_origin", "image_confidence"):
            values = tracks[name].values[rows, view]
            values[..., pair, :] = values[..., pair[::-1], :]
        solve(np.arange(rows.start, rows.stop), pair)
        return
    for variable in tracks.data_vars.values():
        if "time" in variable.dims and "keypoint" in variable.dims:
            places = [variable.dims.index(dim) for dim in ("time", "keypoint")]
            values = np.moveaxis(variable.values, places, [0, 1])[rows]
            values[:, pair] = values[:, pair[::-1]]


def _poses_again(
    tracks: Tracks,
    frame: int,
    retrack: Retracker | None,
    _rig: RigLike | None,
    _px_per_unit: float | None,
) -> Tracks:
    """Track poses again about a frame: the tracker itself keeps what a person posed."""
    new = _tracker(retrack, frame)(copy_tracks(tracks), frame)
    check_editable(new)
    return new


def _tracker(retrack: Retracker | None, frame: int) -> Retracker:
    """Return the tracker, or say that none was given."""
    if retrack is None:
        raise InputError(
            f"tracking again from frame {frame} is not possible here: no tracker was given; "
            "open the tracks together with their trial."
        )
    return retrack


def _points_again(
    tracks: Tracks,
    frame: int,
    retrack: Retracker | None,
    rig: RigLike | None,
    px_per_unit: float | None,
) -> Tracks:
    """Track again from a frame, then put back what a person had corrected from there on."""
    new = copy_tracks(_tracker(retrack, frame)(copy_tracks(tracks), frame))
    check_editable(new)
    for name in ("view", "keypoint"):
        if list(new[name].to_numpy()) != list(tracks[name].to_numpy()):
            raise InputError(
                f"tracking again from frame {frame} gave other {name}s "
                f"({', '.join(map(str, new[name].to_numpy()))}); the tracks stay as they were."
            )
    kept = np.intersect1d(tracks["frame"], new["frame"], return_indices=True)
    rows_old, rows_new = (rows[kept[0] >= frame] for rows in kept[1:])
    edited = tracks["image_origin"].values[rows_old] == EDITED
    # rows that were not tracked again are as they were: what is clicked at the start stays smoothed
    again = ~_are_same(tracks, rows_old, new, rows_new)
    for name in ("image_origin", "image_confidence"):
        values = new[name].values[rows_new]
        new[name].values[rows_new] = np.where(edited, tracks[name].values[rows_old], values)
    uv = new["image_position"].values[rows_new]
    old_uv = tracks["image_position"].values[rows_old]
    new["image_position"].values[rows_new] = np.where(edited[:, :, None], old_uv, uv)
    touched = edited.any(axis=(1, 3)) & again
    solve = PositionSolver(new, rig, px_per_unit)
    for point in np.flatnonzero(touched.any(axis=0)):
        solve(rows_new[touched[:, point]], [int(point)], keep_depth=True)
    return new


def _are_same(tracks: Tracks, rows: IntArray, others: Tracks, other_rows: IntArray) -> BoolArray:
    """Tell where points (n, P) of some rows are placed alike in two tracks."""
    same = np.ones((len(rows), tracks.sizes["keypoint"]), dtype=bool)
    for name in ("position", "image_position", "image_origin"):
        axes = tuple(
            i for i, dim in enumerate(tracks[name].dims) if dim not in ("time", "keypoint")
        )
        pair = (tracks[name].values[rows], others[name].values[other_rows])
        same &= ((pair[0] == pair[1]) | (pair[0] != pair[0]) & (pair[1] != pair[1])).all(axis=axes)
    return same
