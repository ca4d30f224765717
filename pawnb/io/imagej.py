"""Points digitised in ImageJ and Fiji: Manual Tracking's table, and MTrackJ's .mdf.

Manual Tracking as its source writes it (MTrack_.java); .mdf as its author describes it
(imagescience.org/meijering/software/mtrackj/format).
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from pawnb.errors import InputError, InputWarning
from pawnb.files import read_bytes, read_text
from pawnb.input_warnings import warn_of_input
from pawnb.io.digitised import digitised_tracks, to_frames, to_number
from pawnb.io.separators import separator_of
from pawnb.schema import Tracks, check_fps
from pawnb.schema.arguments import checked_arguments

_MANUAL = "the results of ImageJ's Manual Tracking"
_MDF = "a .mdf of MTrackJ"


@checked_arguments
def read_manual_tracking(path: str | Path, *, fps: float) -> Tracks:
    r"""Read the results of Manual Tracking, a plugin of ImageJ and part of Fiji.

    Parameters
    ----------
    path : str or Path
        The results as ImageJ saves them, ``.xls`` (a text), ``.txt`` or ``.csv``. X and Y are in
        px, whatever calibration its distances have; its slices count from 1, frames from 0.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane, px, without confidence. Points are called ``track1``, ``track2`` and so
        on.

    Raises
    ------
    InputError
        If the file is damaged.

    Examples
    --------
    >>> text = " \tTrack n°\tSlice n°\tX\tY\tDistance\n1\t1\t1\t256\t140\t-1\n"
    >>> Path("results.xls").write_text(text, encoding="utf-8") > 0
    True
    >>> pawnb.io.read_manual_tracking("results.xls", fps=250.0)["frame"].values.tolist()
    [0]
    """
    check_fps(fps)
    where = Path(path).name
    data = read_bytes(path, expected=_MANUAL)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # its ° as Windows writes it; all else is plain
    lines = text.splitlines()
    mark = separator_of(lines[0]) if lines else ","
    rows = [[c.strip() for c in row] for row in csv.reader(lines, delimiter=mark)]
    names = rows[0] if rows else []
    at = [
        next((i for i, name in enumerate(names) if name.startswith(word)), None)
        for word in ("Track n", "Slice n", "X", "Y")
    ]
    if None in at:
        raise InputError(f"{where}: no columns Track n°, Slice n°, X and Y; expected {_MANUAL}.")
    points: dict[str, list[list[float]]] = {}
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        here = f"{where}: line {line}"
        if len(row) < len(names) - 1:
            raise InputError(f"{here} has {len(row)} of {len(names)} cells; save the table anew.")
        number, *rest = [to_number(row[i], where=here) for i in at if i is not None]
        points.setdefault(f"track{number:g}", []).append(rest)
    return _tracks(points, fps, where, "Manual Tracking")


@checked_arguments
def read_mtrackj(path: str | Path, *, fps: float) -> Tracks:
    r"""Read tracks of MTrackJ, a plugin of ImageJ and Fiji.

    Parameters
    ----------
    path : str or Path
        ``.mdf``, in px; its frames count from 1.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane, px, without confidence. Points are called ``track1``, ``track2`` and so
        on; of several clusters ``cluster1 track1``.

    Raises
    ------
    InputError
        If the file is damaged.

    Warns
    -----
    InputWarning
        If all points have one time, but slices of their own, which are taken for frames then.

    Examples
    --------
    >>> lines = ["MTrackJ 1.5.1 Data File", "Assembly 1", "Cluster 1", "Track 1",
    ...          "Point 1 187.1 263.2 1.0 1.0 1.0", "End of MTrackJ Data File"]
    >>> Path("clip.mdf").write_text("\n".join(lines)) > 0
    True
    >>> pawnb.io.read_mtrackj("clip.mdf", fps=250.0)["keypoint"].values.tolist()
    ['track1']
    """
    check_fps(fps)
    where = Path(path).name
    cluster, track = "", ""
    found: dict[tuple[str, str], list[list[float]]] = {}
    for line, text in enumerate(read_text(path, expected=_MDF).split("\n"), start=1):
        word, *rest = text.split() or [""]
        if word == "Cluster" and rest:
            cluster, track = rest[0], ""
        elif word == "Track" and rest:
            track = rest[0]
            if (cluster, track) in found:
                raise InputError(f"{where}: line {line}, track {track} is there twice; keep one.")
            found[cluster, track] = []
        elif word == "Point":
            if len(rest) < 5 or not track:
                raise InputError(f"{where}: line {line} is no point of a track; expected {_MDF}.")
            numbers = [to_number(one, where=f"{where}: line {line}") for one in rest[1:5]]
            found[cluster, track].append(numbers)
    every = np.array([row for rows in found.values() for row in rows]).reshape(-1, 4)
    slices = len(np.unique(every[:, 3])) == 1 and len(np.unique(every[:, 2])) > 1
    if slices:
        warn_of_input(
            f"{where}: all points have time {every[0, 3]:g}, as in a film that ImageJ opened as "
            "slices; their slices are taken for frames.",
            InputWarning,
            stacklevel=2,
        )
    several = len({one for one, _ in found}) > 1
    points = {
        f"cluster{one} track{two}" if several else f"track{two}": [
            [row[2 if slices else 3], *row[:2]] for row in rows
        ]
        for (one, two), rows in found.items()
    }
    return _tracks(points, fps, where, "MTrackJ")


def _tracks(points: dict[str, list[list[float]]], fps: float, where: str, program: str) -> Tracks:
    """Make Tracks of rows frame, x, y of each point, frames counted from 1."""
    found = {}
    for name, rows in points.items():
        values = np.array(rows, dtype=float).reshape(-1, 3)
        found[name] = (to_frames(values[:, 0], where=where) - 1, values[:, 1:])
    return digitised_tracks(found, fps=fps, unit="px", program=program, where=where)
