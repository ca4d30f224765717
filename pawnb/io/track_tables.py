"""``tracks.csv`` and ``points3d.csv`` read as Tracks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.errors import InputError, did_you_mean
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import (
    ORIGIN_CODE,
    ORIGINS,
    POINTS3D_COLUMNS,
    TRACKS_COLUMNS,
    Tracks,
    check_frames,
    make_tracks,
    note_absent,
)
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def read_tracks_table(
    path: str | Path,
    *,
    fps: float,
    points3d: str | Path | None = None,
    unit: str = "px",
    individual: str = "animal",
) -> Tracks:
    """Read ``tracks.csv``, and ``points3d.csv`` where there is one, as Tracks.

    Parameters
    ----------
    path : str or Path
        A csv with the columns ``frame, view, point, u, v, confidence, origin``; others are
        ignored.
    fps : float
        Frames per second.
    points3d : str or Path, optional
        A csv with ``frame, point, x, y, z, residual_px, origin``. Without it, the positions
        of a single view are its image positions in px; those of several are missing.
    unit : str
        Unit of x, y, z.
    individual : str
        The animal's id.

    Returns
    -------
    xarray.Dataset
        Tracks of every frame from the first to the last in the file; what the file does
        not hold is missing, and the provenance says of which frames it has no row.

    Raises
    ------
    InputError
        For a missing column, a cell that is not what it should be, a row given twice, or
        frames of a point that do not rise.

    Examples
    --------
    >>> pawnb.io.tracks_table(tracks).to_csv("tracks.csv", index=False)
    >>> again = pawnb.io.read_tracks_table("tracks.csv", fps=200.0)
    >>> again.sizes["time"] == tracks.sizes["time"]
    True
    """
    where = Path(path).name
    table = _read_points(path, TRACKS_COLUMNS, ("view", "point"), ("u", "v", "confidence"))
    views, points = (list(dict.fromkeys(table[name])) for name in ("view", "point"))
    space_table = None
    frames = table["frame"].to_numpy()
    if points3d is not None:
        space_table = _read_points(
            points3d, POINTS3D_COLUMNS, ("point",), ("x", "y", "z", "residual_px")
        )
        points += [p for p in dict.fromkeys(space_table["point"]) if p not in points]
        frames = np.concatenate([frames, space_table["frame"].to_numpy()])
    if not frames.size:
        raise InputError(f"{where}: no rows; expected one for each frame, view and point.")
    frames = check_frames(np.unique(frames), where=where)
    every = np.arange(frames[0], frames[-1] + 1)
    flat = points3d is None and len(views) == 1
    tracks = make_tracks(
        every,
        points,
        fps=fps,
        views=views,
        space=("x", "y") if flat else ("x", "y", "z"),
        individual=individual,
        unit="px" if points3d is None else unit,
    )
    at = np.searchsorted(every, table["frame"].to_numpy())
    view, point = (table[n].map(names.index) for n, names in (("view", views), ("point", points)))
    for axis, name in enumerate(("u", "v")):
        tracks["image_position"].to_numpy()[at, view, axis, point, 0] = table[name]
    tracks["image_confidence"].to_numpy()[at, view, point, 0] = table["confidence"]
    tracks["image_origin"].to_numpy()[at, view, point, 0] = table["origin"]
    if flat:
        tracks["position"].to_numpy()[:] = tracks["image_position"].to_numpy()[:, 0]
        tracks["confidence"].to_numpy()[:] = tracks["image_confidence"].to_numpy()[:, 0]
        tracks["origin"].to_numpy()[:] = tracks["image_origin"].to_numpy()[:, 0]
    if space_table is not None:
        _fill_space(tracks, space_table, points)
    return note_absent(tracks, frames, file=where)


@checked_arguments
def read_points3d_table(
    path: str | Path, *, fps: float, unit: str = "mm", individual: str = "animal"
) -> Tracks:
    """Read ``points3d.csv`` alone as Tracks without image positions.

    Parameters
    ----------
    path : str or Path
        A csv with ``frame, point, x, y, z, residual_px, origin``.
    fps : float
        Frames per second.
    unit : str
        Unit of x, y, z.
    individual : str
        The animal's id.

    Returns
    -------
    xarray.Dataset
        Tracks; confidence is 1 where a point is known.

    Raises
    ------
    InputError
        For a missing column, a cell that is not what it should be, a row given twice, or
        frames of a point that do not rise.

    Examples
    --------
    >>> space = pawnb.schema.make_tracks([0, 1], ["FR"], fps=250.0, unit="mm")
    >>> space["position"].loc[{"keypoint": "FR"}] = 1.5
    >>> pawnb.io.points3d_table(space).to_csv("points3d.csv", index=False)
    >>> pawnb.io.read_points3d_table("points3d.csv", fps=250.0).sizes["space"]
    3
    """
    table = _read_points(path, POINTS3D_COLUMNS, ("point",), ("x", "y", "z", "residual_px"))
    if table.empty:
        raise InputError(f"{Path(path).name}: no rows; expected one for each frame and point.")
    points = list(dict.fromkeys(table["point"]))
    where = Path(path).name
    frames = check_frames(np.unique(table["frame"].to_numpy()), where=where)
    every = np.arange(frames[0], frames[-1] + 1)
    tracks = make_tracks(every, points, fps=fps, individual=individual, unit=unit)
    at = np.searchsorted(every, table["frame"].to_numpy())
    point = table["point"].map(points.index)
    _enter_space(tracks, table, at, point)
    known = tracks["origin"].to_numpy() != ORIGIN_CODE["missing"]
    tracks["confidence"].to_numpy()[:] = known
    return note_absent(tracks, frames, file=where)


def _enter_space(tracks: Tracks, table: pd.DataFrame, at: IntArray, point: pd.Series) -> None:
    """Enter positions, residuals and origins at rows ``at`` of the points ``point``."""
    for axis, name in enumerate("xyz"):
        tracks["position"].to_numpy()[at, axis, point, 0] = table[name]
    tracks["residual"].to_numpy()[at, point, 0] = table["residual_px"]
    tracks["origin"].to_numpy()[at, point, 0] = table["origin"]


def _fill_space(tracks: Tracks, table: pd.DataFrame, points: Sequence[str]) -> None:
    """Enter the rows of ``points3d.csv``; confidence is the mean of the views that see it."""
    at = np.searchsorted(tracks["frame"].to_numpy(), table["frame"].to_numpy())
    _enter_space(tracks, table, at, table["point"].map(list(points).index))
    seen = tracks["image_origin"].to_numpy() != ORIGIN_CODE["missing"]
    total = np.where(seen, tracks["image_confidence"].to_numpy(), 0.0).sum(axis=1)
    mean = total / np.maximum(seen.sum(axis=1), 1)
    known = tracks["origin"].to_numpy() != ORIGIN_CODE["missing"]
    tracks["confidence"].to_numpy()[:] = np.where(known, mean, 0.0)


def _read_points(
    path: str | Path, columns: Sequence[str], keys: Sequence[str], numbers: Sequence[str]
) -> pd.DataFrame:
    """Read one of the two exports: frames whole, numbers or empty, origins as codes."""
    where = Path(path).name
    table = read_cells(path, columns)
    table["frame"] = read_numbers(table, "frame", where=where, whole=True)
    for name in numbers:
        table[name] = read_numbers(table, name, where=where, empty=True)
    unknown = ~table["origin"].isin(ORIGINS)
    if unknown.any():
        line = int(np.argmax(unknown))
        word = table["origin"].iloc[line]
        raise InputError(
            f"{where}: line {line + 2}, origin is {word!r}{did_you_mean(word, ORIGINS)}; expected "
            f"{', '.join(ORIGINS)}."
        )
    table["origin"] = table["origin"].map(ORIGIN_CODE)
    twice = table.duplicated(["frame", *keys])
    if twice.any():
        row = table[twice].iloc[0]
        named = ", ".join(f"{key} {row[key]}" for key in ("frame", *keys))
        raise InputError(f"{where}: {named} is there twice; keep one of them.")
    falls = table.groupby(list(keys), sort=False)["frame"].diff() < 0
    if falls.any():
        row = table[falls].iloc[0]
        named = ", ".join(f"{key} {row[key]}" for key in keys)
        raise InputError(
            f"{where}: frame {row['frame']} of {named} comes after a later one; sort the rows by "
            "frame."
        )
    return table
