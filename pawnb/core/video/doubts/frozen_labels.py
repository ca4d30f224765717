"""Labels of frames in which a film stood still: nothing was seen there, so nothing was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.schema import ORIGIN_CODE, Tracks

Freezes = Mapping[str, Sequence[tuple[int, int]]]
"""View to half-open ranges of frames of the trial in which its film shows one picture again."""

_STANDS_STILL = "stands_still"
"""Attribute of tracks: where the films stood still, as JSON."""


def without_frozen(tracks: Tracks, freezes: Freezes, *, needs_all: bool = False) -> Tracks:
    """Return tracks whose labels in freezes count as predicted, without any confidence.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    freezes : mapping
        Where the film of each view stood still.
    needs_all : bool
        Whether a position in space needs every view, as the joints of a pose do.

    Returns
    -------
    xarray.Dataset
        Positions are as they were; what a person has placed stays as it is. A position in space
        is predicted where no view has measured it, or not every view where all are needed.
        :func:`freezes_of_tracks` tells where that is.
    """
    frames = tracks["frame"].to_numpy()
    frozen = np.zeros((tracks.sizes["time"], tracks.sizes["view"]), bool)
    for v, name in enumerate(tracks["view"].to_numpy()):
        for first, stop in freezes.get(str(name), ()):
            frozen[:, v] |= (frames >= first) & (frames < stop)
    if not frozen.any():
        return tracks
    measured, predicted = ORIGIN_CODE["measured"], ORIGIN_CODE["predicted"]
    origin, confidence = tracks["image_origin"], tracks["image_confidence"]
    hit = frozen[..., None, None] & np.isin(origin, (measured, predicted))
    seen = np.isin(np.where(hit, predicted, origin), (measured, ORIGIN_CODE["edited"]))
    sure = seen.all(axis=1) if needs_all else seen.any(axis=1)
    placed = np.isin(tracks["origin"], (measured, predicted))
    in_space = hit.any(axis=1) & ~sure & placed
    return tracks.assign(
        image_origin=origin.copy(data=np.where(hit, predicted, origin).astype(origin.dtype)),
        image_confidence=confidence.copy(data=np.where(hit, 0.0, confidence)),
        origin=tracks["origin"].copy(
            data=np.where(in_space, predicted, tracks["origin"]).astype(tracks["origin"].dtype)
        ),
        confidence=tracks["confidence"].copy(data=np.where(in_space, 0.0, tracks["confidence"])),
    ).assign_attrs({_STANDS_STILL: _as_text(freezes)})


def _as_text(freezes: Freezes) -> str:
    """Return where films stood still as JSON; NumPy's whole numbers are none of JSON's."""
    return json.dumps({view: [[int(a), int(b)] for a, b in own] for view, own in freezes.items()})


def freezes_of_tracks(tracks: Tracks) -> dict[str, list[tuple[int, int]]]:
    """Return where the films stood still that tracks were made from.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    dict
        View to half-open ranges of frames, as far as there are tracks of them; views without any
        are left out.
    """
    document = json.loads(tracks.attrs.get(_STANDS_STILL, "{}"))
    frames = tracks["frame"].to_numpy()
    found = {}
    for view in tracks["view"].to_numpy().tolist() if document else ():
        own = [(int(a), int(b)) for a, b in document.get(view, ())]
        if own := [(a, b) for a, b in own if ((frames >= a) & (frames < b)).any()]:
            found[str(view)] = own
    return found


def freezes_in_words(freezes: Sequence[tuple[int, int]]) -> str:
    """Return half-open ranges of frames as ``frames 101 to 114 and 130 to 133``."""
    *most, last = [f"{a} to {b - 1}" for a, b in freezes]
    before = f"{', '.join(most)} and " if most else ""
    return f"frames {before}{last}"
