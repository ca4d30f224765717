"""Tracks of any program: the format is recognised by what is in the file."""

from __future__ import annotations

import re
from pathlib import Path

from pawnb.errors import InputError, did_you_mean
from pawnb.files import check_file
from pawnb.io import native, track_tables
from pawnb.io.anipose import read_anipose
from pawnb.io.deeplabcut import GROUP, read_deeplabcut
from pawnb.io.dltdv import read_dltdv_points, read_dltdv_points3d
from pawnb.io.hdf5 import open_hdf5
from pawnb.io.sleap import read_sleap
from pawnb.io.tables import read_column_names
from pawnb.io.wide import is_wide_table, read_wide_table
from pawnb.schema import Tracks, check_fps

FORMATS = (
    "pawnb", "movement", "deeplabcut", "sleap", "anipose", "dltdv-3d", "dltdv", "csv", "csv-3d",
    "table",
)  # fmt: skip
"""Names of the formats that are read."""

_ANIPOSE = re.compile(r"(.+)_(x|y|z|error|ncams|score)")
_DLTDV_SPACE = re.compile(r".+_[XYZ]")
_DLTDV_IMAGE = re.compile(r".+_cam\d+_[XY]")


def recognise_format(path: str | Path) -> str:
    """Say which program's tracks a file holds.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    str
        One of :data:`FORMATS`: ``"csv"`` and ``"csv-3d"`` are pawnb's tables ``tracks.csv``
        and ``points3d.csv``, ``"table"`` a csv with ``<point>_x, <point>_y`` of every point.

    Raises
    ------
    InputError
        If there is no such file or it is none of them.

    Examples
    --------
    >>> pawnb.io.recognise_format("sample/m01DLC.csv")
    'deeplabcut'
    """
    path = check_file(path, expected="a file of tracks")
    found = None
    if path.suffix == ".slp":
        found = "sleap"
    elif path.suffix in {".h5", ".hdf5", ".nc"}:
        found = _recognise_hdf5(path)
    elif path.suffix == ".csv":
        found = _recognise_csv(path)
    if found is None:
        raise InputError(
            f"{path.name}: not tracks that are read here; expected tracks.nc, tracks.csv, "
            "points3d.csv, or a file of DeepLabCut (.csv, .h5), SLEAP (.slp, .h5), Anipose (.csv), "
            "DLTdv (xypts.csv, xyzpts.csv) or movement (.nc), or a csv with frame and <point>_x, "
            "<point>_y (and _z) of every point."
        )
    return found


def read_any_tracks(
    path: str | Path,
    *,
    fps: float | None = None,
    program: str | None = None,
    unit: str | None = None,
) -> Tracks:
    """Read tracks of pawnb or of another program.

    Parameters
    ----------
    path : str or Path
        The file.
    fps : float, optional
        Frames per second, needed where the file does not say.
    program : str, optional
        One of :data:`FORMATS`; default as :func:`recognise_format` says.
    unit : str, optional
        Unit of length of 3D points whose file does not say; default mm.

    Returns
    -------
    xarray.Dataset
        Tracks.

    Raises
    ------
    InputError
        If the file cannot be read, or the frame rate is needed and not given.

    Examples
    --------
    >>> tracks = pawnb.io.read_any_tracks("sample/m01DLC.csv", fps=200.0)
    >>> "hindpaw_R" in tracks["keypoint"]
    True
    """
    path = Path(path)
    check_rate(fps)
    found = recognise_format(path) if program is None else program
    if found not in FORMATS:
        raise InputError(
            f"unknown format {found!r}{did_you_mean(found, FORMATS)}; "
            f"expected {', '.join(FORMATS)}."
        )
    if found in {"pawnb", "movement"}:
        return native.read_tracks(path, fps=fps)
    if fps is None:
        raise InputError(
            f"{path.name}: this file does not say its frame rate; give fps, the frames per second "
            "of the recording (--fps on the command line)."
        )
    if found == "deeplabcut":
        return read_deeplabcut(path, fps=fps, unit=unit or "mm")
    if found == "sleap":
        return read_sleap(path, fps=fps)
    if found == "anipose":
        return read_anipose(path, fps=fps, unit=unit or "mm")
    if found == "dltdv-3d":
        return read_dltdv_points3d(path, fps=fps, unit=unit or "mm")
    if found == "dltdv":
        return read_dltdv_points(path, fps=fps)
    if found == "table":
        return read_wide_table(path, fps=fps, unit=unit)
    if found == "csv-3d":
        return track_tables.read_points3d_table(path, fps=fps, unit=unit or "mm")
    return track_tables.read_tracks_table(path, fps=fps)


def check_rate(fps: float | None) -> None:
    """Refuse a frame rate that cannot be, given or not needed.

    Parameters
    ----------
    fps : float, optional
        Frames per second.

    Raises
    ------
    InputError
        If it is not a number above 0.
    """
    if fps is not None:
        check_fps(fps)


def _recognise_hdf5(path: Path) -> str | None:
    """Tell files of HDF5 apart by the names inside."""
    with path.open("rb") as start:
        if start.read(3) == b"CDF":
            return "movement"  # netCDF 3 is no HDF5
    with open_hdf5(path, expected="tracks in HDF5 or netCDF") as file:
        names = set(file)
    if GROUP in names:
        return "deeplabcut"
    if {"tracks", "node_names"} <= names:
        return "sleap"
    if "position" in names:
        return "pawnb" if {"origin", "frame"} <= names else "movement"
    return None


def _recognise_csv(path: Path) -> str | None:
    """Tell tables apart by their first line."""
    names = read_column_names(path, expected="tracks as csv")
    columns = set(names)
    if names[:1] == ["scorer"]:
        return "deeplabcut"
    if {"frame", "point", "x", "y", "z"} <= columns:
        return "csv-3d"
    if {"frame", "view", "point", "u", "v"} <= columns:
        return "csv"
    if "fnum" in columns and any(_ANIPOSE.fullmatch(name) for name in names):
        return "anipose"
    if any(_DLTDV_IMAGE.fullmatch(name) for name in names):
        return "dltdv"
    if sum(bool(_DLTDV_SPACE.fullmatch(name)) for name in names) >= 3:
        return "dltdv-3d"
    if is_wide_table(names):
        return "table"
    return None
