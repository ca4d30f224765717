"""Points digitised with DLTdv: ``...xyzpts.csv`` in space, ``...xypts.csv`` in the views.

DLTdv 7 and 8 also write both sparse (``.tsv``): a title, or the names of the columns, then the
numbers of rows, of columns and of values, then row, column and value of each point, counted from
1. Points whose names are not said are called pt1, pt2, ... as in DLTdv's own tables. Beside them
lie ``...offsets.csv``, how many frames each camera runs ahead, and ``...xyzres.csv``, DLTdv's
algebraic residual of each point. XMALab exports its markers with the same columns, those in space
with a column ``Frame`` before them where only some frames are saved.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.errors import InputError
from pawnb.files import check_file, read_text
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

_SPACE = re.compile(r"(?P<point>.+)_(?P<axis>[XYZ])")
_IMAGE = re.compile(r"(?P<point>.+)_cam(?P<view>\d+)_(?P<axis>[XY])")
_FRAME_COLUMNS = {"frame0": 0, "Frame": 1}
"""Columns that number frames, and what they call the first: XMALab's ``Frame`` begins at 1."""

_SPARSE_CELL = re.compile(
    r"(\d{1,9})\s+(\d{1,9})\s+([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)"
)

DLTRES = "dltres"
"""Variable of Tracks: DLTdv's algebraic residual of a point in space."""

OFFSETS = "view_offset"
"""Variable of Tracks (time, view): by how many frames a camera's file runs ahead."""

SPARSE_TITLES = {
    "camera coordinates": "xypts",
    "3D coordinates": "xyzpts",
    "triangulation residuals": "xyzres",
    "camera offsets": "offsets",
}
"""What the title of a sparse file of DLTdv says of it, and what the file is called."""

_MOST_CELLS = 10**8
"""More than an hour of a thousand pictures a second with a dozen points in two cameras."""


@checked_arguments
def read_dltdv_points3d(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read 3D points of DLTdv.

    Parameters
    ----------
    path : str or Path
        ``...xyzpts.csv`` with columns ``<point>_X, _Y, _Z``; a row a frame, or a column
        ``frame0`` (or XMALab's ``Frame``, from 1) with its number; or the sparse ``.tsv``. Where
        ``...xyzres`` lies beside it, its residuals are kept as ``dltres``.
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of length of the calibration.

    Returns
    -------
    xarray.Dataset
        Tracks in space; DLTdv gives no confidence, so that of a digitised point is NaN.

    Raises
    ------
    InputError
        If the file is missing or of another layout, or frames do not rise.

    Examples
    --------
    >>> table = pd.DataFrame({"pt1_X": [1.0, 2.0], "pt1_Y": 0.0, "pt1_Z": [5.0, 5.5]})
    >>> table.to_csv("clip_xyzpts.csv", index=False)
    >>> tracks = pawnb.io.read_dltdv_points3d("clip_xyzpts.csv", fps=250.0)
    >>> tracks["keypoint"].values.tolist(), tracks.attrs["units"]
    (['pt1'], 'mm')
    """
    frames, table = _read(path)
    names = [name for name in map(str, table) if not _IMAGE.fullmatch(name)]
    found = [m for name in names if (m := _SPACE.fullmatch(name))]
    points = list(dict.fromkeys(m["point"] for m in found))
    wanted = [f"{point}_{axis}" for point in points for axis in "XYZ"]
    _check_layout(path, table, wanted, "<point>_X, <point>_Y, <point>_Z")
    places = table[wanted].to_numpy(dtype=float).reshape(len(frames), len(points), 1, 3)
    if is_sparse(path):  # which leaves zeros out, and a point has all three coordinates or none
        some = np.isfinite(places).any(axis=-1, keepdims=True)
        places = np.where(some & np.isnan(places), 0.0, places)
    tracks = build_tracks(
        frames, places, points=points, fps=fps, unit=unit, program="DLTdv", where=Path(path).name
    )
    residuals = _beside(path, "xyzpts", "xyzres")
    if residuals is None:
        return tracks
    names = [f"{point}_{DLTRES}" for point in points]
    values = _aligned(residuals, names, tracks)
    return tracks.assign({DLTRES: (("time", "keypoint", "individual"), values[..., None])})


@checked_arguments
def read_dltdv_points(
    path: str | Path, *, fps: float, heights_px: Sequence[int] | None = None
) -> Tracks:
    """Read points in the views of DLTdv.

    Parameters
    ----------
    path : str or Path
        ``...xypts.csv`` with columns ``<point>_cam<n>_X, _Y``, or the sparse ``.tsv``. Where
        ``...offsets.csv`` lies beside it, its numbers are kept as ``view_offset``: points are in
        the frames of the first camera already.
    fps : float
        Frames per second of the recording.
    heights_px : sequence of int, optional
        Height of each camera's picture. DLTdv 7 and older count Y upwards from the bottom edge,
        from 1: v is height - Y. A height of 0 leaves it at -Y, which is enough for
        triangulation with coefficients that are moved alike. Without heights, Y counts
        downwards from 1, as in MATLAB's pictures and in DLTdv 8.

    Returns
    -------
    xarray.Dataset
        Tracks with ``image_position`` in px of the views ``cam1``, ``cam2``, ... DLTdv gives no
        confidence, so that of a digitised point is NaN.

    Raises
    ------
    InputError
        If the file is missing or of another layout, frames do not rise, or the heights do not
        fit the cameras.

    Notes
    -----
    ``DLTcoefs.csv`` of DLTdv belongs to its own pixels: move it by the same change before using
    it with these points (:func:`pawnb.core.rig.load_rig` does with ``first_pixel=1``).

    Examples
    --------
    >>> table = pd.DataFrame({"pt1_cam1_X": [1.0, 2.0], "pt1_cam1_Y": 9.0,
    ...                       "pt1_cam2_X": [3.0, 4.0], "pt1_cam2_Y": 9.0})
    >>> table.to_csv("clip_xypts.csv", index=False)
    >>> tracks = pawnb.io.read_dltdv_points("clip_xypts.csv", fps=250.0)
    >>> u = tracks["image_position"].sel(image_space="u")
    >>> u.isel(time=0).values.ravel().tolist()  # DLTdv counts pixels from 1
    [0.0, 2.0]
    """
    frames, table = _read(path)
    found = [m for name in map(str, table) if (m := _IMAGE.fullmatch(name))]
    points = list(dict.fromkeys(m["point"] for m in found))
    numbers = sorted({int(m["view"]) for m in found})
    wanted = [f"{point}_cam{n}_{axis}" for point in points for n in numbers for axis in "XY"]
    _check_layout(path, table, wanted, "<point>_cam1_X, <point>_cam1_Y, ...")
    if heights_px is not None and len(heights_px) != len(numbers):
        raise InputError(
            f"{Path(path).name}: {len(numbers)} cameras but {len(heights_px)} heights; give one "
            "height a camera."
        )
    places = np.array(table[wanted], dtype=float).reshape(len(frames), len(points), len(numbers), 2)
    places[..., 0] -= 1.0
    if heights_px is None:
        places[..., 1] -= 1.0
    else:
        places[..., 1] = np.asarray(heights_px, dtype=float) - places[..., 1]
    tracks = build_tracks(
        frames,
        places.transpose(0, 2, 1, 3)[:, :, :, None],
        points=points,
        fps=fps,
        unit="px",
        program="DLTdv",
        where=Path(path).name,
        views=[f"cam{n}" for n in numbers],
    )
    offsets = _beside(path, "xypts", "offsets")
    if offsets is None:
        return tracks
    values = _aligned(offsets, [f"cam{n}_offset" for n in numbers], tracks)
    return tracks.assign({OFFSETS: (("time", "view"), values)})


def _beside(path: str | Path, kind: str, other: str) -> Path | None:
    """Return the file of another kind that DLTdv wrote beside one, if it is there."""
    name = Path(path).name
    if kind not in name:
        return None
    for ending in (Path(path).suffix, ".csv", ".tsv"):
        found = Path(path).with_name(name.replace(kind, other)).with_suffix(ending)
        if found.is_file():
            return found
    return None


def _aligned(path: Path, names: Sequence[str], tracks: Tracks) -> np.ndarray:
    """Return columns of a table (n_frames, n_names) in the frames of tracks; NaN where absent."""
    frames, table = _read(path)
    values = np.full((tracks.sizes["time"], len(names)), np.nan)
    rows = np.searchsorted(tracks["frame"].to_numpy(), frames)
    inside = rows < len(values)
    inside[inside] = tracks["frame"].to_numpy()[rows[inside]] == frames[inside]
    for i, name in enumerate(names):
        if name in table:
            values[rows[inside], i] = table[name].to_numpy()[inside]
    return values


def _read(path: str | Path) -> tuple[IntArray, pd.DataFrame]:
    """Return frame numbers and the table of numbers; NaN where nothing was digitised."""
    where = Path(path).name
    if is_sparse(path):
        return _read_sparse(path)
    cells = read_cells(path, ())
    cells = cells.mask(cells.apply(lambda column: column.str.lower() == "nan"), "")
    table = pd.DataFrame(
        {
            name: read_numbers(cells, name, where=where, empty=True)
            for name in map(str, cells)
            if name not in _FRAME_COLUMNS
        }
    )
    for name, first in _FRAME_COLUMNS.items():
        if name in cells:
            return read_numbers(cells, name, where=where, whole=True) - first, table
    return np.arange(len(table)), table


def is_sparse(path: str | Path) -> bool:
    """Say whether a table is one of DLTdv's sparse ones: three whole numbers in its second line.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    bool
        True where it looks like that.
    """
    with check_file(path, expected="points digitised with DLTdv").open("rb") as file:
        file.readline(2**22)
        second = file.readline(100).split()
    return len(second) == 3 and all(cell.isdigit() for cell in second)


def _read_sparse(path: str | Path) -> tuple[np.ndarray, pd.DataFrame]:
    """Return frame numbers and the table of a sparse file; NaN where nothing was digitised."""
    where = Path(path).name
    lines = read_text(path, expected="points digitised with DLTdv").rstrip("\n").split("\n")
    n_rows, n_columns, n_values = map(int, lines[1].split())
    kind = sparse_kind(lines[0])
    names = re.split(r"[,\t]", lines[0].strip())
    if kind is not None:
        names = _names_of_columns(Path(path), kind, n_columns)
    if n_columns != len(names) or n_values != len(lines) - 2 or n_rows * n_columns > _MOST_CELLS:
        raise InputError(
            f"{where}: says {n_rows} rows, {n_columns} columns and {n_values} values, and has "
            f"{len(names)} names and {len(lines) - 2} values: the file was cut short; copy it "
            "again from where it is whole."
        )
    values = np.full((n_rows, n_columns), 0.0 if names[0].endswith("_offset") else np.nan)
    for i, line in enumerate(lines[2:], start=3):
        cell = _SPARSE_CELL.fullmatch(line.strip())
        at = (int(cell[1]) - 1, int(cell[2]) - 1) if cell else (-1, -1)
        if cell is None or not (0 <= at[0] < n_rows and 0 <= at[1] < n_columns):
            raise InputError(f"{where}: line {i} is {line[:40]!r}; expected row, column and value.")
        values[at] = float(cell[3])
    return np.arange(n_rows), pd.DataFrame(values, columns=names)


def sparse_kind(title: str) -> str | None:
    """Return what kind of sparse file a title is that of, where it is one of DLTdv's titles.

    Parameters
    ----------
    title : str
        The first line of a sparse file.

    Returns
    -------
    str or None
        ``xypts``, ``xyzpts``, ``xyzres`` or ``offsets``; None where the line names the columns.
    """
    if not title.startswith("Sparse format"):
        return None
    return next((kind for words, kind in SPARSE_TITLES.items() if words in title), None)


def _names_of_columns(path: Path, kind: str, n_columns: int) -> list[str]:
    """Return the names that DLTdv gives the columns in its full tables."""
    if kind == "offsets":
        return [f"cam{i + 1}_offset" for i in range(n_columns)]
    if kind == "xyzres":
        return [f"pt{i + 1}_{DLTRES}" for i in range(n_columns)]
    if kind == "xyzpts":
        return [f"pt{i // 3 + 1}_{'XYZ'[i % 3]}" for i in range(n_columns)]
    n_views = _number_of_cameras(path, n_columns)
    n = range(n_columns // 2)
    return [f"pt{i // n_views + 1}_cam{i % n_views + 1}_{axis}" for i in n for axis in "XY"]


def _number_of_cameras(path: Path, n_columns: int) -> int:
    """Return how many cameras a sparse file of views has, which only those beside it say."""
    for kind, columns_of_a_point in (("offsets", 0), ("xyzres", 1), ("xyzpts", 3)):
        other = _beside(path, "xypts", kind)
        if other is None or not is_sparse(other):
            continue
        with other.open(encoding="utf-8") as file:
            file.readline()
            n = int(file.readline().split()[1])
        n_views = n_columns * columns_of_a_point // max(2 * n, 1) if columns_of_a_point else n
        if n_views > 0 and n_columns % (2 * n_views) == 0:
            return n_views
    raise InputError(
        f"{path.name}: DLTdv's sparse file says neither its cameras nor its points; put the "
        f"{path.name.replace('xypts', 'offsets')} that DLTdv wrote with it beside it (both names "
        "as DLTdv gave them), or export flat (csv)."
    )


def _check_layout(
    path: str | Path, table: pd.DataFrame, wanted: Sequence[str], layout: str
) -> None:
    """Refuse a table without the columns of DLTdv."""
    missing = [name for name in wanted if name not in table]
    if not wanted or missing:
        what = f"column {missing[0]} is missing" if missing else "no column of that kind"
        raise InputError(f"{Path(path).name}: {what}; DLTdv writes {layout}.")
