"""Tracks for DeepLabCut and Lightning Pose: csv or h5, predictions or labels for training."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.files import write_whole
from pawnb.io.deeplabcut import DEEPLABCUT, GROUP, ONE, PICTURES, POINTS_OF, SCORER
from pawnb.io.outgoing import Outgoing, take_space, take_view, views_of, word
from pawnb.io.pandas_frame import pandas_frame_bytes
from pawnb.io.tables import write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

LIGHTNING_POSE = "heatmap_tracker"
"""The scorer of Lightning Pose's predictions."""


@checked_arguments
def write_deeplabcut(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write predictions as DeepLabCut does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; points in pictures, or in space where there are no others.
    path : str or Path
        ``.csv`` or ``.h5``.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file: rows are numbered by frames, columns by scorer, (individuals, where several)
        bodyparts and coords x, y (z), likelihood.

    Raises
    ------
    InputError
        If there are no points, or the file cannot be written.

    Examples
    --------
    >>> path = pawnb.io.write_deeplabcut(tracks, "copyDLC.csv")
    >>> pawnb.io.recognise_format(path)
    'deeplabcut'
    """
    own = take_view(tracks, view) if views_of(tracks) else take_space(tracks)
    return _write_predictions(own, path, str(own.attrs.get(SCORER) or "pawnb"))


@checked_arguments
def write_lightning_pose(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write predictions as Lightning Pose does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures.
    path : str or Path
        ``.csv``.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file: as DeepLabCut's of one animal, of the scorer ``heatmap_tracker``.

    Raises
    ------
    InputError
        If there are no points in pictures, or several animals.

    Examples
    --------
    >>> pawnb.io.write_lightning_pose(tracks, "predictions.csv").name
    'predictions.csv'
    """
    own = take_view(tracks, view)
    own.only_animal("Lightning Pose")
    scorer = str(own.attrs.get(SCORER) or "")
    return _write_predictions(own, path, scorer if "heatmap" in scorer else LIGHTNING_POSE)


@checked_arguments
def write_collected(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write labels for training as DeepLabCut's ``CollectedData_<scorer>``.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures.
    path : str or Path
        ``.csv`` or ``.h5``.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file: a row for each frame with a point, named by its picture
        (``labeled-data/<folder>/img0000.png``, or as the labels that were read named theirs).

    Raises
    ------
    InputError
        If there are no points in pictures.

    Examples
    --------
    >>> few = tracks.isel(time=[0, 10])
    >>> pawnb.io.write_collected(few, "CollectedData_me.csv").name
    'CollectedData_me.csv'
    """
    path = Path(path)
    own = take_view(tracks, view)
    scorer = str(own.attrs.get(SCORER) or path.stem.partition("_")[2] or "pawnb")
    values, columns, levels = _table(own, scorer, ("x", "y"))
    known = np.isfinite(values).any(axis=1)
    pattern = str(own.attrs.get(PICTURES) or f"labeled-data/{view or 'video'}/img%04d.png")
    rows = [tuple((pattern % frame).split("/")) for frame in own.frames[known]]
    return _write(path, values[known], columns, levels, rows)


def _write_predictions(own: Outgoing, path: str | Path, scorer: str) -> Path:
    """Write a row a frame."""
    axes = ("x", "y", "z")[: own.place.shape[-1]]
    values, columns, levels = _table(own, scorer, (*axes, "likelihood"))
    return _write(Path(path), values, columns, levels, own.frames)


def _table(
    own: Outgoing, scorer: str, coords: Sequence[str]
) -> tuple[FloatArray, list[tuple[str, ...]], list[str]]:
    """Return the numbers, the names of the columns and those of their levels."""
    parts = [own.place[..., "xyz".index(c)] if c in "xyz" else own.confidence for c in coords]
    values = np.stack(parts, axis=-1).transpose(0, 2, 1, 3)
    known = _columns_there(own)
    named = own.attrs.get("source_software") == DEEPLABCUT and own.individuals != [ONE]
    several = len(own.individuals) > 1 or named
    columns = [
        (scorer, *((who,) if several else ()), point, coord)
        for i, who in enumerate(own.individuals)
        for k, point in enumerate(own.points)
        for coord in coords
        if known[i, k]
    ]
    levels = ["scorer", *(["individuals"] if several else []), "bodyparts", "coords"]
    return values[:, known].reshape(len(own.frames), -1), columns, levels


def _columns_there(own: Outgoing) -> BoolArray:
    """Say which points (n_individuals, n_points) have columns: those of the file that was read."""
    said = json.loads(own.attrs.get(POINTS_OF, "{}"))
    every = {point for points in said.values() for point in points}
    lacking = {who: every.difference(points) for who, points in said.items()}
    listed = [[p not in lacking.get(who, ()) for p in own.points] for who in own.individuals]
    return np.array(listed) | np.isfinite(own.place).all(axis=-1).any(axis=0).T


def _write(
    path: Path,
    values: FloatArray,
    columns: list[tuple[str, ...]],
    levels: list[str],
    index: np.ndarray | list[tuple[str, ...]],
) -> Path:
    """Write the table as csv or h5."""
    if path.suffix != ".csv":
        data = pandas_frame_bytes(values, key=GROUP, columns=columns, levels=levels, index=index)
        return write_whole(path, data)
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    names = [(str(frame),) for frame in index] if isinstance(index, np.ndarray) else index
    blank = [""] * (len(names[0]) - 1 if names else 0)
    for i, level in enumerate(levels):
        out.writerow([level, *blank, *(column[i] for column in columns)])
    for name, row in zip(names, values, strict=True):
        out.writerow([*name, *map(word, row)])
    return write_text(text.getvalue(), path)
