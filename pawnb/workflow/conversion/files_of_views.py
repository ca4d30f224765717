"""Tracks of several views that each have a file of their own, as most programs write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from pawnb.errors import InputError
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.io.outgoing import Outgoing, take_view, views_of
from pawnb.schema import ORIGIN_CODE, Tracks, every_frame, make_tracks, note_absent
from pawnb.trial import Trial

OWN = ("pawnb", "csv")
"""Formats of pawnb itself: in the pixels and frames of the trial, not of a view's file."""


def read_files_of_views(trial: Trial) -> Tracks:
    """Read a file of tracks for each view and put them side by side.

    Parameters
    ----------
    trial : Trial
        Its ``[tracks] file`` names a file a view; ``offset`` of a view is its file's frame that
        belongs to frame 0 of the trial.

    Returns
    -------
    xarray.Dataset
        Tracks with image positions in every view, in px as the files have them, and positions in
        space still missing. Points and animals are those of any file; a point that a file lacks is
        missing in its view.

    Raises
    ------
    InputError
        If a file cannot be read, has points in space or of several views, names other animals than
        the others, or has no point in common with them.
    """
    views = [view.name for view in trial.views if view.name in trial.tracks_of_views]
    views = views or list(trial.tracks_of_views)
    offsets = {view.name: view.offset for view in trial.views}
    parts = {}
    for view in views:
        path = trial.path(trial.tracks_of_views[view])
        program = recognise_format(path)
        own = _of_one_view(read_any_tracks(path, fps=trial.fps, program=program), view, path)
        parts[view] = (own, 0 if program in OWN else offsets.get(view, 0))
    points = list(dict.fromkeys(point for own, _ in parts.values() for point in own.points))
    animals = _common_animals(trial, {view: own.individuals for view, (own, _) in parts.items()})
    frames = np.unique(np.concatenate([own.frames - offset for own, offset in parts.values()]))
    tracks = make_tracks(
        every_frame(frames), points, fps=trial.fps, views=views,
        source_software=str(next(iter(parts.values()))[0].attrs.get("source_software") or "pawnb"),
    )  # fmt: skip
    if len(animals) > 1:
        tracks = tracks.isel(individual=np.zeros(len(animals), dtype=int)).copy(deep=True)
    tracks = tracks.assign_coords(individual=np.array(animals, dtype=str))
    for i, (own, offset) in enumerate(parts.values()):
        rows = np.searchsorted(tracks["frame"].to_numpy(), own.frames - offset)
        _enter(tracks, own, i, rows, [points.index(point) for point in own.points])
    return note_absent(tracks, frames, file=", ".join(trial.track_files))


def _of_one_view(tracks: Tracks, view: str, path: Path) -> Outgoing:
    """Return the points of the one view that a file holds."""
    views = views_of(tracks)
    if not views:
        raise InputError(f"{path.name}: points in space; [tracks] file names one view's points.")
    if len(views) > 1 and view not in views:
        raise InputError(
            f"{path.name}: points of views {', '.join(views)}, and none of them is {view!r}; name "
            "it alone, as [tracks] file."
        )
    return take_view(tracks, view if view in views else views[0])


def _common_animals(trial: Trial, animals: dict[str, list[str]]) -> list[str]:
    """Return the animals, which all files must call the same where there are several."""
    first, *others = animals.values()
    if all(len(names) == 1 for names in animals.values()):
        return [trial.animal.id]
    for view, names in zip(list(animals)[1:], others, strict=True):
        if sorted(names) != sorted(first):
            raise InputError(
                f"{trial.tracks_of_views[view]}: animals {', '.join(names)}, and in the first view "
                f"{', '.join(first)}; call each animal the same in every view."
            )
    return first


def _enter(tracks: Tracks, own: Outgoing, view: int, rows: np.ndarray, columns: list[int]) -> None:
    """Enter the points of one view."""
    names = [str(name) for name in tracks["individual"].to_numpy()]
    who = [names.index(n) for n in own.individuals] if len(names) > 1 else [0]
    seen = np.isfinite(own.place).all(axis=-1)
    at = np.ix_(rows, np.array(columns), np.array(who))
    for name, values in (
        ("image_confidence", np.where(seen, own.confidence, 0.0)),
        ("image_origin", np.where(seen, ORIGIN_CODE["measured"], ORIGIN_CODE["missing"])),
    ):
        _part(tracks[name], view)[at] = values
    place = _part(tracks["image_position"], view)  # frame, axis, point, animal
    for axis in range(2):
        place[:, axis][at] = own.place[..., axis]


def _part(variable: xr.DataArray, view: int) -> np.ndarray:
    """Return what a variable holds of one view, to be written into."""
    return variable.to_numpy()[:, view]
