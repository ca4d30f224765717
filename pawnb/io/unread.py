"""Files of other programs that are not read here: named, with the way to a file that is."""

from __future__ import annotations

import re
from pathlib import Path

import h5py

from pawnb.errors import InputError
from pawnb.io.hdf5 import open_hdf5
from pawnb.io.tables import read_column_names
from pawnb.io.wide import has_points

_HEAD_BYTES = 2**16
_COLUMNS = "frame and <point>_x, <point>_y (and _z) of each"
AS_TABLE = f"write its points as csv with {_COLUMNS}"
"""The way that is open from any program."""
_BY_SLEAP_IO = "make a .slp of it by sleap-io: sio convert FILE -o clip.slp --from "
_ONE_POINT = (
    "it holds one point of each animal, and gait needs its feet: track them, in pawnb or elsewhere"
)

_BY_PANDAS = 'save it as csv by pandas: pandas.read_{}(FILE).to_csv("points.csv"), with columns '
_BY_BYTES = (
    (b"PK\x03\x04", rb"xl/|mimetypeapplication/vnd\.oasis", "a spreadsheet",
     "save the sheet that has the points as csv"),
    (b"PK\x03\x04", rb"\.npy", "arrays of NumPy (.npz), as TRex writes", AS_TABLE),
    (b"PK\x03\x04", rb"\.trk", "a project of Tracker with its film (.trz)",
     "unpack it as a zip archive, and name the .trk that is in it"),
    (b"\x93NUMPY", rb"", "an array of NumPy (.npy), as idtracker.ai and VAME write", AS_TABLE),
    (b"\xd0\xcf\x11\xe0", rb"", "an old spreadsheet (.xls)", "save the sheet as csv"),
    (b"\x80", rb"", "a pickle of Python, which may run programs when it is read",
     f"of DeepLabCut, name the .h5 or .csv of the same video; of another program, {AS_TABLE}"),
    (b"MATLAB 7.3", rb"", "a .mat of MATLAB 7.3, as DANNCE and projects of DLTdv 8 are",
     f"export points from DLTdv as xypts.csv; of another program, {AS_TABLE}"),
    (b"PK\x03\x04", rb"", "a zip archive", "unpack it, and name the file of tracks that is in it"),
    (b"PAR1", rb"", "a table in Parquet", _BY_PANDAS.format("parquet") + _COLUMNS),
    (b"ARROW1", rb"", "a table in Feather", _BY_PANDAS.format("feather") + _COLUMNS),
)  # fmt: skip
"""What a file begins with, what else is near its beginning, what it is, and the way out."""

_BY_TEXT = (
    (r"\A[^\n]*(\bSPOT_SOURCE_ID\b|\bTRACK_INDEX\b|\bNUMBER_SPOTS\b)",
     "edges or tracks of TrackMate", "name its table of spots (.csv), or its .xml"),
    (r"\A[^\n]*<\?mso-application progid=.Excel|urn:schemas-microsoft-com:office:spreadsheet",
     "a spreadsheet in XML, as Kinovea exports for Excel",
     "name the .kva of Kinovea; of another program, save the sheet as csv"),
    (r"\A\W*Time \(\w+\)\W+[;,]", "a table of Kinovea's kinematics, with one coordinate of each",
     "name its .kva, or export its trajectories as text"),
    (r"\A[^\n]*mass[^\n]*\n\s*t[,;\t]", "a table of Tracker without x and y, or pixelx and pixely",
     "choose these columns as Tracker exports it"),
    (r"\A\W*(Label\W+)?Area\b[^\n]*\bX\W+Y\b", "results of ImageJ, of one point a row",
     "digitise the feet with Manual Tracking, MTrackJ or TrackMate, or " + AS_TABLE),
    (r"inDegrees\s*=|^nRows=\d+[\s\S]*endheader", "a .mot or .sto of OpenSim, angles or forces",
     "name the markers that they were made from (.trc)"),
    (r'"pose_keypoints_2d"', "a frame of OpenPose", "join all frames to one: " + AS_TABLE),
    (r'"instance_info"|"keypoint_scores"', "predictions of MMPose", AS_TABLE),
    (r'"annotations"[\s\S]*"result"', "annotations of Label Studio", AS_TABLE),
    (r'"annotations"[\s\S]*"keypoints"|"images"[\s\S]*"file_name"', "keypoints of COCO",
     _BY_SLEAP_IO + "coco (with the pictures beside it)"),
    (r"^frame_idx,(video_path,)?(node,x,y|inst\d+\.)",
     "a csv of sleap-io laid out by points or frames",
     'save it anew with format="sleap", or by sio convert FILE -o clip.slp --from csv'),
    (r"^\W*time\W*,\W*x1\W*,\W*y1\b", "trajectories of idtracker.ai", _ONE_POINT),
    (r"\A\W*\w+_dltres\b|\A\W*cam\d+_offset\b", "residuals or offsets of DLTdv",
     "name the xypts or xyzpts beside it"),
    (r"\A\W*IMPORTED_POSE\b", "poses of SimBA as they were imported",
     "name its file of csv/outlier_corrected_movement_location"),
    (r"\A(?=[^\n]*\b(bodyparts?|landmarks?|keypoints?|points?|markers?)\b)(?=[^\n]*\bx\W+y\b)",
     "a table with a row for each point", "spread it by pandas: wide = table.pivot(index='frame', "
     "columns=<names of points>, values=['x', 'y']); wide.columns = [f'{point}_{axis}' for axis, "
     "point in wide.columns]; wide.to_csv('points.csv')"),
    (r"\A([^,\n]+),\1,\1(,[^\n]*)?\nx,y,(z,)?confidence\b",
     "a csv of JARVIS, whose names take two lines",
     "join them by pandas: table = pandas.read_csv(FILE, header=[0, 1]); table.columns = "
     "['_'.join(column) for column in table.columns]; table.to_csv('points.csv', "
     "index_label='frame')"),
    (r"\AFormat Version,", "a csv of OptiTrack's Motive", "export .c3d or .trc from Motive"),
    (r"X#wcentroid|^[^\n]*\bposeX0\b", "a table of TRex",
     f"{AS_TABLE}; poseX0, poseY0, ... are its points"),
    (r"^[^\n]*\bsyllable\b", "results of keypoint-moseq",
     "name the tracks that they were made from"),
    (r"B-SOiD labels", "behaviours of B-SOiD", "name the tracks that they were made from"),
    (r'\A\s*\{\s*"trajectories"', "trajectories of idtracker.ai", _ONE_POINT),
    (r"\A\s*(#[^\n]*\s+)*\[[^\],]+\]\s*\n\s*[\w\"]+\s*=", "a text in TOML",
     "name tracks; cameras go below [calibration] of a trial.toml"),
    (r"\A\s*[{\[]", "a text in JSON", AS_TABLE),
    (r"^\s*<\?xml", "a text in XML", AS_TABLE),
)  # fmt: skip
"""Patterns at the beginning of a text, the first that fits, what it is, and the way out."""


def say_unread(path: Path) -> str | None:
    """Say of which program a file is that is not read here, and how to come to one that is.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str or None
        ``"<what it is>, not read here; <the way out>"``; None for a file that is not known either.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    if head.startswith(b"\x89HDF"):
        return _say_hdf5(path)
    for begin, within, what, way in _BY_BYTES:
        if head.startswith(begin) and re.search(within, head):
            return _not_read(what, way)
    text = head.decode("utf-8-sig", "replace")
    for pattern, what, way in _BY_TEXT:
        if re.search(pattern, text, re.MULTILINE):
            return _not_read(what, way)
    return None


def say_found(path: Path) -> str:
    """Say what is in a file that no program is known by.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        Such as ``"its columns are time, FR[0], FR[1], ..."``; empty where there is nothing to say.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    if head.startswith(b"\x89HDF"):
        with open_hdf5(path, expected="tracks in HDF5") as inside:
            return f"it holds {_some(sorted(inside))}"
    line = head.partition(b"\n")[0]
    try:
        line.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "its first line is not text in UTF-8; save it as UTF-8"
    names = read_column_names(path, expected="tracks")
    if "\0" in line.decode("utf-8-sig") or len(names) < 2:
        return ""
    said = f"its columns are {_some([name or '(no name)' for name in names])}"
    return f"{said}: add a column frame that counts from 0" if has_points(names) else said


def _some(names: list[str], most: int = 6) -> str:
    """Return the first of some names."""
    more = ", ..." if len(names) > most else ""
    return ", ".join(name[:30] for name in names[:most]) + more


def tell_folder(path: Path) -> None:
    """Refuse a folder that is one of Zarr, with the way out.

    Parameters
    ----------
    path : Path
        What was named.

    Raises
    ------
    InputError
        If it is one.
    """
    if any((path / name).exists() for name in ("zarr.json", ".zgroup", ".zmetadata")):
        raise InputError(
            f"{path}: a folder of Zarr, not read here; save it as netCDF: "
            'xarray.open_zarr(FOLDER).to_netcdf("poses.nc").'
        )


def _not_read(what: str, way: str) -> str:
    """Say both."""
    return f"{what}, not read here; {way}"


def _say_hdf5(path: Path) -> str | None:
    """Say the same of HDF5, by the names inside."""
    try:
        with open_hdf5(path, expected="tracks in HDF5") as file:
            names = set(file)
            groups = {n: item for n, item in file.items() if isinstance(item, h5py.Group)}
            inside = {name for item in groups.values() for name in item}
            tables = [name for name, item in groups.items() if "pandas_type" in item.attrs]
    except InputError:
        return None
    if tables:
        return _not_read(f"tables of pandas ({_some(tables)})", _BY_PANDAS.format("hdf") + _COLUMNS)
    if "poseest" in names:
        return _not_read("poses of JABS", f"{_BY_SLEAP_IO}jabs")
    if "trajectories" in names:
        return _not_read("trajectories of idtracker.ai", _ONE_POINT)
    if {"annotations", "skeleton"} <= names:
        return _not_read("points of DeepPoseKit", AS_TABLE)
    if "syllable" in inside:
        return _not_read("results of keypoint-moseq", "name the tracks that they were made from")
    return None
