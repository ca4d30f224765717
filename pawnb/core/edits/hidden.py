"""Which points a person has marked as not visible, after all corrections."""

from __future__ import annotations

from collections.abc import Sequence

from pawnb.core.edits.records import Accept, Edit, Hide, Interpolate, Move, Pose, Swap
from pawnb.core.edits.stretches import rows_of_edit
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
