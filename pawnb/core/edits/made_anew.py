"""Corrections that were saved with other tracks than those that are opened."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

import numpy as np

from pawnb.core.edits.records import Edit, Swap
from pawnb.core.edits.words import describe_edit
from pawnb.errors import PawnbError
from pawnb.schema import Tracks

_ROUNDED_PX = 1e-3
"""Files of tracks may keep single precision: 1/4096 px at 4096 px."""


def same_places(one: Tracks, other: Tracks) -> bool:
    """Tell whether two tracks have each point in the same places, but for how files round.

    Parameters
    ----------
    one, other : xarray.Dataset
        Tracks.
    """
    a, b = (tracks["image_position"].to_numpy() for tracks in (one, other))
    return a.shape == b.shape and np.allclose(a, b, atol=_ROUNDED_PX, equal_nan=True)


def say_made_anew(
    tracks: Tracks, before: Callable[[], Tracks] | None, edits: Sequence[Edit]
) -> list[str]:
    """Say that a trial was tracked anew since its corrections were saved, if it was.

    They are made in the new tracks, too. A place is right in any tracks; but points that the new
    tracks do not exchange any more are exchanged by them.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks that are opened.
    before : callable, optional
        ``before() -> Tracks`` reads the tracks in which the corrections were made.
    edits : sequence of Edit
        The corrections in force.

    Returns
    -------
    list of str
        One sentence, or nothing where the tracks contain corrections or are those from before;
        also where those from before cannot be read.
    """
    steps = json.loads(tracks.attrs.get("provenance", "{}")).get("steps", [])
    if before is None or not edits or any(step.get("step") == "edit" for step in steps):
        return []
    try:
        if same_places(tracks, before()):
            return []
    except PawnbError as error:
        return [
            f"Whether the trial was tracked anew since corrections were saved is not known: {error}"
        ]
    n = len(edits)
    said = "the correction saved before is" if n == 1 else f"the {n} corrections saved before are"
    swaps = "; ".join(describe_edit(edit) for edit in edits if isinstance(edit, Swap))
    look = f"look whether this is still needed: {swaps}" if swaps else "look at them"
    return [f"The trial was tracked anew, and {said} made in the new tracks, too; {look}."]
