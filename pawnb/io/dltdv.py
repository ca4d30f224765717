"""Points digitised with DLTdv: ``...xyzpts.csv`` in space, ``...xypts.csv`` in the views."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks

_SPACE = re.compile(r"(?P<point>.+)_(?P<axis>[XYZ])")
_IMAGE = re.compile(r"(?P<point>.+)_cam(?P<view>\d+)_(?P<axis>[XY])")
_FRAME = "frame0"


def read_dltdv_points3d(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read 3D points of DLTdv.

    Parameters
    ----------
    path : str or Path
        ``...xyzpts.csv`` with columns ``<point>_X, _Y, _Z``; a row a frame, or a column
        ``frame0`` with the frame's number.
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
    return build_tracks(
        frames, places, points=points, fps=fps, unit=unit, program="DLTdv", where=Path(path).name
    )


def read_dltdv_points(
    path: str | Path, *, fps: float, heights_px: Sequence[int] | None = None
) -> Tracks:
    """Read points in the views of DLTdv.

    Parameters
    ----------
    path : str or Path
        ``...xypts.csv`` with columns ``<point>_cam<n>_X, _Y``.
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
    return build_tracks(
        frames,
        places.transpose(0, 2, 1, 3)[:, :, :, None],
        points=points,
        fps=fps,
        unit="px",
        program="DLTdv",
        where=Path(path).name,
        views=[f"cam{n}" for n in numbers],
    )


def _read(path: str | Path) -> tuple[np.ndarray, pd.DataFrame]:
    """Return frame numbers and the table of numbers; NaN where nothing was digitised."""
    where = Path(path).name
    cells = read_cells(path, ())
    cells = cells.mask(cells.apply(lambda column: column.str.lower() == "nan"), "")
    table = pd.DataFrame(
        {
            name: read_numbers(cells, name, where=where, empty=True)
            for name in map(str, cells)
            if name != _FRAME
        }
    )
    if _FRAME in cells:
        return read_numbers(cells, _FRAME, where=where, whole=True), table
    return np.arange(len(table)), table


def _check_layout(
    path: str | Path, table: pd.DataFrame, wanted: Sequence[str], layout: str
) -> None:
    """Refuse a table without the columns of DLTdv."""
    missing = [name for name in wanted if name not in table]
    if not wanted or missing:
        what = f"column {missing[0]} is missing" if missing else "no column of that kind"
        raise InputError(f"{Path(path).name}: {what}; DLTdv writes {layout}.")
