"""Other programs' predictions that a trial names under ``[tracking] detections``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.predictions import (
    Predictions,
    distances_from_clicks,
    find_extent,
)
from pawnb.core.video.viewset import ViewSet
from pawnb.errors import InputError, did_you_mean
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.tracking.trial_views import points_by_view

_OWN_PROGRAMS = ("pawnb", "csv")
"""Formats of pawnb itself: in the pixels and frames of the trial, not of a view's file."""
_FAR_OF_EXTENT = 0.2
"""Predictions farther than this from clicks, in extents of the animal, are on something else."""
_FEWEST_COMMON = 2
"""One click may be a slip of the hand, or of the program."""


def predictions_for(
    trial: Trial, views: ViewSet, clicks: pd.DataFrame, *, frames: tuple[int, int]
) -> dict[str, Predictions]:
    """Read the predictions of the points that a trial tracks, see :func:`read_predictions`.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    clicks : DataFrame
        Start clicks: they say which points each view tracks.
    frames : tuple of int
        First frame that is tracked, and one past the last.

    Returns
    -------
    dict
        View to its predictions.

    Raises
    ------
    InputError
        As for :func:`read_predictions`.
    """
    own = points_by_view(trial, clicks).values()
    points = list(dict.fromkeys(point for names in own for point in names))
    return read_predictions(trial, views, points=points, frames=frames)


def read_predictions(
    trial: Trial, views: ViewSet, *, points: Sequence[str], frames: tuple[int, int]
) -> dict[str, Predictions]:
    """Read the predictions of every view that has some.

    Parameters
    ----------
    trial : Trial
        Its ``detections`` name the files: DeepLabCut and Lightning Pose (csv, h5), SLEAP
        (``.slp``, analysis ``.h5``), or any other that :mod:`pawnb.io.formats` reads.
    views : ViewSet
        Its open views. Predictions count frames and pixels as the view's video does, before
        it is straightened, cropped and mirrored; those of pawnb's own files as the trial does.
    points : sequence of str
        Points of the trial. One of the same name in a file, in capitals or not, is the same
        unless ``detections_points`` says otherwise.
    frames : tuple of int
        First frame that is tracked, and one past the last.

    Returns
    -------
    dict
        View to its predictions.

    Raises
    ------
    InputError
        If a file is missing or of another format, has points in space, several animals, none
        of the points or none of the frames.
    """
    found = {}
    for view, name in trial.detections.items():
        path = trial.path(name)
        program = recognise_format(path)
        tracks = _of_animal(read_any_tracks(path, fps=trial.fps, program=program), trial, path)
        uv, likelihood = _in_picture(tracks, view, path)
        names = tracks["keypoint"].to_numpy().astype(str).tolist()
        here = match_points(names, points, trial.detections_points, where=path.name)
        columns = [names.index(one) for one in here]
        offset = 0 if program in _OWN_PROGRAMS else trial.view(view).offset
        rows = _rows_of(tracks, frames, offset, where=path.name)
        uv, likelihood = _taken(uv[:, columns], rows), _taken(likelihood[:, columns], rows)
        if program not in _OWN_PROGRAMS:
            uv = views.readers[view].uv_of_file(uv)
        found[view] = Predictions(
            path.name, tuple(here.values()), uv, np.clip(np.nan_to_num(likelihood), 0.0, 1.0)
        )
    return found


def match_points(
    names: Sequence[str], points: Sequence[str], renamed: Mapping[str, str], *, where: str
) -> dict[str, str]:
    """Return which point of the trial each point of a file is.

    Parameters
    ----------
    names : sequence of str
        Points of the file.
    points : sequence of str
        Points of the trial.
    renamed : mapping
        What the trial says: name in the file to point.
    where : str
        How messages name the file.

    Returns
    -------
    dict
        Name in the file to point, of those that are in both.

    Raises
    ------
    InputError
        If none is, or the trial speaks of a point that is not there.
    """
    for name, point in renamed.items():
        if point not in points:
            raise InputError(
                f"[tracking.detections_points] {name} is {point!r}, and the trial has no such "
                f"point{did_you_mean(point, points)}; its points are {', '.join(points)}."
            )
    given = {point: name for name, point in renamed.items() if name in names}
    for point in points:
        like = [name for name in names if name.lower() == point.lower() and name not in renamed]
        if like and point not in given:
            given[point] = point if point in like else like[0]
    if not given:
        raise InputError(
            f"{where} has points {', '.join(names)}, and the trial has {', '.join(points)}: name "
            f"them alike, or say which is which under [tracking.detections_points], for instance "
            f'{_key(names[0])} = "{points[0]}".'
        )
    return {given[point]: point for point in points if point in given}


def doubt_predictions(
    predictions: Mapping[str, Predictions], clicks: pd.DataFrame, *, views: ViewSet, first: int
) -> list[str]:
    """Say where most predictions lie far from the clicks: they are of another video, or crop.

    Parameters
    ----------
    predictions : mapping
        View to its predictions.
    clicks : pandas.DataFrame
        frame, view, point, u, v.
    views : ViewSet
        The open views.
    first : int
        First frame that is tracked.

    Returns
    -------
    list of str
        A sentence for each such file.
    """
    doubts = []
    for view, own in predictions.items():
        reader = views.readers[view]
        annotations = _annotations(clicks, view, own.points, first)
        apart = distances_from_clicks(own.uv, annotations)
        apart = apart[np.isfinite(apart)]
        extent = find_extent(own.uv, annotations, (reader.width, reader.height))
        if len(apart) >= _FEWEST_COMMON and np.median(apart) > _FAR_OF_EXTENT * extent:
            doubts.append(
                f"{own.file}: predictions lie {np.median(apart):.0f} px from the clicks in view "
                f"{view!r} (median of {len(apart)}), so they count for little; if they are of "
                "another video, crop or frame range, give those of this one."
            )
    return doubts


def _annotations(
    clicks: pd.DataFrame, view: str, points: tuple[str, ...], first: int
) -> Annotations:
    """Return the clicks of a view on the points of its predictions."""
    places: dict[int, dict[int, np.ndarray]] = {}
    own = clicks[(clicks["view"] == view) & clicks["point"].isin(points)]
    for frame, point, u, v in zip(*(own[c] for c in ("frame", "point", "u", "v")), strict=True):
        places.setdefault(int(frame) - first, {})[points.index(point)] = np.array([u, v], float)
    return Annotations(places)


def _of_animal(tracks: Tracks, trial: Trial, path: Path) -> Tracks:
    """Return the tracks of the one animal, or of the one that is called as the trial's is."""
    names = tracks["individual"].to_numpy().astype(str).tolist()
    if len(names) == 1:
        return tracks.isel(individual=0)
    if trial.animal.id in names:
        return tracks.sel(individual=trial.animal.id)
    raise InputError(
        f"{path.name} has {len(names)} animals, {', '.join(names)}; name the one that is tracked "
        "as [animal] id."
    )


def _in_picture(tracks: Tracks, view: str, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (time, points, 2) and likelihoods (time, points) in the file of a view."""
    name, prefix = "position", ""
    if "image_position" in tracks:
        names = tracks["view"].to_numpy().astype(str).tolist()
        if view not in names:
            raise InputError(
                f"{path.name} has views {', '.join(names)}, and none is {view!r}; give the file "
                "of that view, or name the views alike."
            )
        tracks, name, prefix = tracks.sel(view=view), "image_position", "image_"
    elif tracks.sizes["space"] != 2:
        raise InputError(
            f"{path.name} has points in space; [tracking] detections needs those of a picture."
        )
    axes = "image_space" if prefix else "space"
    uv = tracks[name].transpose("time", "keypoint", axes).to_numpy()
    likelihood = tracks[f"{prefix}confidence"].transpose("time", "keypoint").to_numpy()
    # a file without likelihoods is believed as far as the clicks say
    return uv, np.where(np.isnan(likelihood) & np.isfinite(uv).all(axis=2), 1.0, likelihood)


def _rows_of(tracks: Tracks, frames: tuple[int, int], offset: int, *, where: str) -> np.ndarray:
    """Return the row of the file for every frame that is tracked; -1 where it has none."""
    known = tracks["frame"].to_numpy()
    wanted = np.arange(*frames) + offset
    rows = np.searchsorted(known, wanted)
    there = (rows < len(known)) & (known[np.minimum(rows, len(known) - 1)] == wanted)
    if not there.any():
        raise InputError(
            f"{where} has frames {known[0]} to {known[-1]}, none of {wanted[0]} to {wanted[-1]} "
            "that are tracked; give the predictions of this recording."
        )
    return np.where(there, rows, -1)


def _taken(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return rows of values, NaN where there is none."""
    taken = values[rows].astype(float)
    taken[rows < 0] = np.nan
    return taken


def _key(name: str) -> str:
    """Return a name as TOML writes it on the left."""
    return name if name.replace("_", "").replace("-", "").isalnum() else f'"{name}"'
