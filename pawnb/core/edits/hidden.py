"""Points that a person has marked as not visible: which, and that they stay so."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from pawnb.arrays import IntArray
from pawnb.core.edits.copies import copy_tracks
from pawnb.core.edits.pose_stretches import hide_leg
from pawnb.core.edits.records import Accept, Edit, Hide, Interpolate, Move, Pose, Swap
from pawnb.core.edits.stretches import clear, place_of, row_of, rows_of_edit
from pawnb.core.pose.as_tracks import is_pose
from pawnb.schema import Tracks


def hidden_by_hand(past: Sequence[Edit], tracks: Tracks) -> list[Hide]:
    """Return the points that a person marked as not visible and did not place again.

    Parameters
    ----------
    past : sequence of Edit
        Corrections in the order they were made.
    tracks : xarray.Dataset
        The tracks that they were made in.

    Returns
    -------
    list of Hide
        One for each point, view and frame.
    """
    frames = tracks["frame"].to_numpy()
    views = [str(name) for name in tracks["view"].to_numpy()]

    def places(edit: Hide | Interpolate) -> list[tuple[int, str, str]]:
        own = views if edit.view is None else [edit.view]
        return [(int(f), v, edit.point) for f in frames[rows_of_edit(tracks, edit)] for v in own]

    hidden: dict[tuple[int, str, str], None] = {}
    for edit in past:
        if isinstance(edit, Hide):
            hidden |= dict.fromkeys(places(edit))
        elif isinstance(edit, Move | Accept):
            hidden.pop((edit.frame, edit.view, edit.point), None)
        elif isinstance(edit, Pose):
            hidden = {place: None for place in hidden if place[0] != edit.frame}
        elif isinstance(edit, Interpolate):
            for place in places(edit):
                hidden.pop(place, None)
        elif isinstance(edit, Swap):
            other = {edit.first: edit.second, edit.second: edit.first}
            stop = frames[-1] + 1 if edit.stop is None else edit.stop
            hidden = {
                (f, v, other.get(p, p))
                if edit.frame <= f < stop and edit.view in (None, v)
                else (f, v, p): None
                for f, v, p in hidden
            }
    return [Hide(frame=f, view=v, point=p) for f, v, p in hidden]


def hide_again(
    tracks: Tracks,
    hidden: Iterable[Hide],
    *,
    frame: int,
    solver: Callable[[Tracks], Callable[[IntArray, list[int]], None]],
) -> Tracks:
    """Return tracks that were tracked again, with what a person hid hidden again.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks; not modified.
    hidden : iterable of Hide
        What a person marked as not visible, as :func:`hidden_by_hand` gives it.
    frame : int
        The frame from which it was tracked again: points from there on, poses both ways.
    solver : callable
        ``solver(tracks)(rows, points)`` computes 3D positions of points again, in place.

    Returns
    -------
    xarray.Dataset
        The tracks.
    """
    jointed, known = is_pose(tracks), set(tracks["frame"].to_numpy().tolist())
    again = [hide for hide in hidden if hide.frame in known and (jointed or hide.frame >= frame)]
    if not again:
        return tracks
    new = copy_tracks(tracks)
    for hide in again:
        rows = rows_of_edit(new, hide)
        if jointed:
            hide_leg(new, rows, hide.point)
        else:
            clear(new, rows, hide.point, view=hide.view)
    if not jointed:
        solve = solver(new)
        for name in dict.fromkeys(hide.point for hide in again):
            at = sorted({row_of(new, hide.frame) for hide in again if hide.point == name})
            solve(np.array(at), [place_of(new, "keypoint", name)])
    return new
