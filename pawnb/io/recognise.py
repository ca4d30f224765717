"""Which program's tracks a file holds: told by what is in it, never by its name."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import h5py

from pawnb.errors import InputError
from pawnb.files import check_file
from pawnb.io import argus
from pawnb.io.authors2019 import HEADER_LINES
from pawnb.io.deeplabcut import DEEPLABCUT, GROUP, dataframe_of, program_of
from pawnb.io.digitised import digitised_format
from pawnb.io.dltdv import sparse_kind
from pawnb.io.hdf5 import open_hdf5
from pawnb.io.motion_capture import motion_capture_format
from pawnb.io.nwb import is_nwb
from pawnb.io.osp_tracker import tables_in_folder
from pawnb.io.separators import header_lines, separator_of
from pawnb.io.tables import read_column_names
from pawnb.io.unread import tell_folder
from pawnb.io.wide import is_wide_table

_ANIPOSE = re.compile(r"(.+)_(x|y|z|error|ncams|score)")
_DLTDV_SPACE = re.compile(r".+_[XYZ]")
_DLTDV_IMAGE = re.compile(r".+_cam\d+_[XY]")
_HEAD_BYTES = 2**16
_EXPECTED = "a file of tracks"


def find_format(path: str | Path) -> str | None:
    """Return the name of a file's format, or None where it is none that is known.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    str or None
        One of :data:`pawnb.io.formats.FORMATS`.

    Raises
    ------
    InputError
        If there is no such file, it is empty, damaged HDF5, or text in UTF-16.
    """
    tell_folder(Path(path))
    if Path(path).is_dir() and tables_in_folder(Path(path)):
        return "tracker"
    path = check_file(path, expected=_EXPECTED)
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except OSError as reason:
        raise InputError(f"{path}: cannot be read ({reason.strerror or reason}).") from None
    if not head:
        raise InputError(f"{path.name}: an empty file; copy it again from where it is whole.")
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(
            f"{path.name}: text in UTF-16, as Excel's 'Unicode text'; save it as UTF-8."
        )
    if head.startswith(b"CDF"):
        return "movement"  # netCDF 3 is no HDF5
    if head.startswith(b"\x89HDF"):
        return _find_in_hdf5(path)
    if head.startswith(b"MATLAB 5.0"):
        return "locomouse"
    if len(head) >= 512 and head[1] == 0x50 and head[0] in range(2, 17):
        return "c3d"  # a C3D file begins with the block of its parameters and the key 0x50
    return _find_in_text(path, head)


def _find_in_hdf5(path: Path) -> str | None:
    """Tell files of HDF5 apart by the names inside."""
    with open_hdf5(path, expected="tracks in HDF5 or netCDF") as file:
        names = set(file)
        if (table := dataframe_of(file)) is not None:
            return "collected" if _rows_have_names(table) else "deeplabcut"
        if GROUP in names:
            return "deeplabcut"
        if {"instances", "metadata", "frames"} <= names or {"tracks", "node_names"} <= names:
            return "sleap"
        if is_nwb(file):
            return "nwb"
        if "position" in names:
            return "pawnb" if {"origin", "frame"} <= names else "movement"
    return None


def _rows_have_names(group: h5py.Group) -> bool:
    """Say whether the rows of a DataFrame are named by words."""
    table, axis = group.get("table"), group.get("axis1")
    if isinstance(table, h5py.Dataset):
        return "index" in (table.dtype.names or ()) and table.dtype["index"].kind == "S"
    if isinstance(axis, h5py.Dataset):
        return axis.dtype.kind == "S"
    return "axis1_level0" in group


def _find_in_text(path: Path, head: bytes) -> str | None:
    """Tell tables apart by their first lines."""
    lines = header_lines(head.decode("utf-8-sig", "replace"))
    if (capture := motion_capture_format(lines)) is not None:
        return capture
    if (digitised := digitised_format(lines)) is not None:
        return digitised
    if len(lines) > HEADER_LINES and lines[HEADER_LINES].startswith("Frames,First Camera"):
        return "authors2019"
    if len(lines) > 1 and "\t" in lines[1] and len(lines[1].split()) == 3:
        kind = sparse_kind(lines[0])
        if kind is not None:
            return {"xypts": "dltdv", "xyzpts": "dltdv-3d"}.get(kind)
        names = [cell.strip() for cell in re.split(r"[,\t]", lines[0])]
        if (found := _find_dltdv(names)) is not None:
            return found
    names = read_column_names(path, expected="tracks as csv")
    if names[:1] == ["scorer"]:
        return _find_deeplabcut(lines, names)
    return _find_by_columns(names)


def _find_deeplabcut(lines: list[str], names: list[str]) -> str:
    """Tell predictions, labels and those of Lightning Pose apart."""
    header = 4 if len(lines) > 1 and lines[1].startswith("individuals") else 3
    mark = separator_of(lines[0])
    first = next(csv.reader(lines[header : header + 1], delimiter=mark), [""])
    if names[1:2] == [""] or re.search(r"\.(png|jpe?g|tiff?|bmp)$", first[0]):
        return "collected"
    own = len(names) < 2 or program_of(names[1]) == DEEPLABCUT
    return "deeplabcut" if own else "lightning-pose"


def _find_by_columns(names: list[str]) -> str | None:
    """Tell tables apart by the names of their columns."""
    columns = set(names)
    if {"frame", "point", "x", "y", "z"} <= columns:
        return "csv-3d"
    if {"frame", "view", "point", "u", "v"} <= columns:
        return "csv"
    if {"track", "frame_idx"} <= columns and "node" not in columns:
        return "sleap"
    if "fnum" in columns and any(_ANIPOSE.fullmatch(name) for name in names):
        return "anipose"
    if any(argus.IMAGE.fullmatch(name) for name in names):
        return "argus"
    dltdv = _find_dltdv(names)
    if dltdv is not None:
        return dltdv
    if is_wide_table(names):
        return "table"
    space = [m["point"] for name in names if (m := argus.SPACE.fullmatch(name))]
    return "argus-3d" if names and len(space) == len(names) == 3 * len(set(space)) else None


def _find_dltdv(names: list[str]) -> str | None:
    """Tell the tables of DLTdv apart."""
    if "TRACK_ID" in names:
        return None  # of TrackMate, with POSITION_X
    if any(_DLTDV_IMAGE.fullmatch(name) for name in names):
        return "dltdv"
    space = [name for name in names if _DLTDV_SPACE.fullmatch(name)]
    if len(space) >= 3 and any(name.endswith("_Z") for name in space):
        return "dltdv-3d"
    return None
