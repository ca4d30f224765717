"""Tracks for DLTdv: points in the views or in space, full or sparse, with what lies beside them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.io.dltdv import DLTRES, OFFSETS
from pawnb.io.outgoing import Outgoing, has_space, take_space, take_view, views_of, word
from pawnb.io.tables import write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def write_dltdv_points(
    tracks: Tracks, path: str | Path, *, heights_px: Sequence[int] | None = None
) -> Path:
    """Write points in the views as DLTdv does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures, of one animal.
    path : str or Path
        ``...xypts.csv``, or ``...xypts.tsv`` for the sparse layout of DLTdv 8.
    heights_px : sequence of int, optional
        Height of each view's picture (or one of all): Y then counts upwards from the lower edge,
        as in DLTdv 7 and older. Without it, Y counts downwards, as in DLTdv 8. Both count from 1.

    Returns
    -------
    Path
        The file: a row for every frame from 0 on, cameras numbered in the order of the views.
        DLTdv opens it together with ``...xyzpts``, ``...xyzres`` and ``...offsets``: these are
        written beside it, with points in space and offsets where the tracks know them and empty
        otherwise. A file of that name that is there already is kept where there is nothing to say.

    Raises
    ------
    InputError
        If there are no points in pictures, several animals, or heights do not fit the views.

    Examples
    --------
    >>> pawnb.io.write_dltdv_points(tracks, "copy_xypts.csv").name
    'copy_xypts.csv'
    """
    path = Path(path)
    names, values, own = view_columns(tracks, "DLTdv", heights_px)
    write_columns(path, names, values)
    _write_beside(tracks, path, own, range(1, values.shape[1] // len(own.points) // 2 + 1))
    return path


def view_columns(
    tracks: Tracks, program: str, heights_px: Sequence[int] | None
) -> tuple[list[str], FloatArray, Outgoing]:
    """Return points in the views as columns, counted from 1 as DLTdv and XMALab do.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures, of one animal.
    program : str
        Whose file it will be, for messages.
    heights_px : sequence of int or None
        Height of each view's picture (or one of all), where Y counts upwards.

    Returns
    -------
    names : list of str
        ``<point>_cam<n>_X, _Y`` of every point in every view.
    values : ndarray, shape (n_frames, n_names)
        A row for every frame from 0 on, NaN where missing.
    own : Outgoing
        The points of the last view.

    Raises
    ------
    InputError
        If there are no points in pictures, several animals, or heights do not fit the views.
    """
    views = views_of(tracks)
    if heights_px is not None and len(heights_px) not in (1, len(views)):
        raise InputError(f"{len(views)} views but {len(heights_px)} heights; give one a view.")
    heights = None if heights_px is None else [*heights_px] * (
        len(views) if len(heights_px) == 1 else 1
    )  # fmt: skip
    parts = []
    for i, view in enumerate(views or [""]):
        own = take_view(tracks, view)
        own.only_animal(program)
        place = own.whole(own.place[:, :, 0])
        place[..., 0] += 1.0
        place[..., 1] = place[..., 1] + 1.0 if heights is None else heights[i] - place[..., 1]
        parts.append(place)
    numbers = range(1, len(parts) + 1)
    names = [f"{p}_cam{n}_{axis}" for p in own.points for n in numbers for axis in "XY"]
    values = np.stack(parts, axis=2)
    return names, values.reshape(len(values), -1), own


def _write_beside(tracks: Tracks, path: Path, own: Outgoing, numbers: Sequence[int]) -> None:
    """Write the files without which DLTdv does not open one of points in the views."""
    n_rows = len(own.whole(own.place[:, :, 0]))
    offsets = np.zeros((n_rows, len(numbers)))
    if OFFSETS in tracks:
        offsets = np.nan_to_num(own.whole(own_offsets(tracks, own.frames)))
    if OFFSETS in tracks or not beside(path, "offsets").exists():
        write_columns(beside(path, "offsets"), [f"cam{n}_offset" for n in numbers], offsets)
    if has_space(tracks):
        space = take_space(tracks)
        if space.points == own.points and np.array_equal(space.frames, own.frames):
            write_dltdv_points3d(tracks, beside(path, "xyzpts"))
    for kind, axes in (("xyzpts", "XYZ"), ("xyzres", [DLTRES])):
        if not beside(path, kind).exists():
            names = [f"{point}_{axis}" for point in own.points for axis in axes]
            write_columns(beside(path, kind), names, np.full((n_rows, len(names)), np.nan))


def own_offsets(tracks: Tracks, frames: IntArray) -> FloatArray:
    """Return the offsets (n_frames, n_views) of some frames of tracks.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with ``view_offset``.
    frames : ndarray, shape (n_frames,)
        Frames of theirs.

    Returns
    -------
    ndarray, shape (n_frames, n_views)
        By how many frames each camera's file runs ahead.
    """
    rows = np.searchsorted(tracks["frame"].to_numpy(), frames)
    return np.asarray(tracks[OFFSETS].transpose("time", "view").to_numpy()[rows], dtype=float)


@checked_arguments
def write_dltdv_points3d(tracks: Tracks, path: str | Path) -> Path:
    """Write points in space as DLTdv does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in space, of one animal.
    path : str or Path
        ``...xyzpts.csv``, or ``...xyzpts.tsv`` for the sparse layout of DLTdv 8.

    Returns
    -------
    Path
        The file: a row for every frame from 0 on. Where the tracks know DLTdv's residual
        (``dltres``), it is written beside it as ``...xyzres``.

    Raises
    ------
    InputError
        If there are no points in space, or several animals.

    Examples
    --------
    >>> pawnb.io.write_dltdv_points3d(space, "copy_xyzpts.csv").name
    'copy_xyzpts.csv'
    """
    path = Path(path)
    own = take_space(tracks)
    own.only_animal("DLTdv")
    names = [f"{point}_{axis}" for point in own.points for axis in "XYZ"]
    values = own.whole(own.place[:, :, 0])
    write_columns(path, names, values.reshape(len(values), -1))
    if DLTRES in own.tracks:
        residuals = own.whole(own.tracks[DLTRES].to_numpy()[..., 0])
        write_columns(
            beside(path, "xyzres"), [f"{point}_{DLTRES}" for point in own.points], residuals
        )
    return path


def beside(path: Path, kind: str) -> Path:
    """Return what DLTdv calls the file of another kind beside one of points.

    Parameters
    ----------
    path : Path
        ``...xypts.csv`` or ``...xyzpts.csv``; any other name gets the kind at its end.
    kind : str
        ``offsets``, ``xyzres`` or ``DLTcoefs``.

    Returns
    -------
    Path
        Its name.
    """
    for own in ("xyzpts", "xypts"):
        if own in path.name:
            return path.with_name(path.name.replace(own, kind))
    return path.with_name(f"{path.stem}_{kind}{path.suffix}")


def write_columns(path: Path, names: Sequence[str], values: FloatArray) -> Path:
    """Write a table of numbers, full (NaN as DLTdv says it) or sparse.

    Parameters
    ----------
    path : Path
        The file; ``.tsv`` is sparse.
    names : sequence of str
        Names of the columns.
    values : ndarray, shape (n_rows, n_names)
        The numbers.

    Returns
    -------
    Path
        The file.
    """
    rows = [",".join(names)]
    if path.suffix == ".tsv":
        # what is not there is 0 in a sparse file
        at = np.argwhere(np.isfinite(values) & ((values != 0.0) | ("offset" not in names[0])))
        rows.append(f"{values.shape[0]}\t{values.shape[1]}\t{len(at)}")
        # by columns, as MATLAB goes through a matrix
        for row, column in at[np.lexsort((at[:, 0], at[:, 1]))]:
            rows.append(f"{row + 1}\t{column + 1}\t{word(values[row, column])}")
    else:
        rows += [",".join(word(value) or "NaN" for value in row) for row in values]
    return write_text("\n".join(rows) + "\n", path)
