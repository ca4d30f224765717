"""Trajectories of Kinovea: its own .kva, and its exports as text and csv.

Laid out as the program's source writes them (MetadataSerializer.cs, DrawingTrack.cs,
ExporterTXTTrajectory.cs, ExporterCSV.cs); the text also as in files that users published.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.files import read_text
from pawnb.io.digitised import (
    digitised_tracks,
    frames_of_times,
    read_xml,
    step_of_times,
    tell_units,
    to_number,
)
from pawnb.io.points import tell_rate
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks, check_fps
from pawnb.schema.arguments import checked_arguments

_EXPECTED = "a .kva of Kinovea, or its trajectories as .txt or .csv"
_TIMECODE = re.compile(r"(\d+):(\d+):(\d+)[:.](\d+)")
_SUFFIX = re.compile(r"[\d.,-]*\d\s*(px|pixels?|[mcd]?m|in|ft|%)(?=\s|$)")
_HALF = 0.5
"""Kinovea counts pixels from the corner of the picture: its default origin is half its size
(CalibrationHelper.cs)."""

_OFF_GRID = 0.25
"""Part of a frame by which time stamps may lie beside the whole number of stamps a frame that is
said. Mathematics: of a frame of 2.5 or 1.5 stamps every second one is half a stamp off."""
_Points = dict[str, tuple[IntArray, FloatArray]]


@checked_arguments
def read_kinovea(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    r"""Read trajectories of Kinovea.

    Parameters
    ----------
    path : str or Path
        ``.kva``, in which Kinovea keeps its trajectories in px with the frame of each, or its
        trajectories as ``.txt`` (for gnuplot) or ``.csv``, with times, in the unit of its
        calibration and with y upwards.
    fps : float
        Frames per second of the recording.
    unit : str, optional
        Unit of the lengths of a ``.txt`` or ``.csv``, which does not say it; default px. Those of
        a ``.kva`` are px.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane without confidence, y downwards. Points are called as the trajectories.

    Raises
    ------
    InputError
        If the file is damaged, of a Kinovea before 0.8.16, or has no trajectory.

    Warns
    -----
    InputWarning
        If the file says another frame rate, its times go in other steps, or it says no unit.

    Examples
    --------
    >>> text = "#Kinovea Trajectory data export\n#T X Y\n\n# FR\n0 12,5 -3\n5 13 -3\n"
    >>> Path("clip.txt").write_text(text) > 0
    True
    >>> pawnb.io.read_kinovea("clip.txt", fps=200.0, unit="mm")["position"].values[0].ravel()
    array([12.5,  3. ])
    """
    check_fps(fps)
    where = Path(path).name
    text = read_text(path, expected=_EXPECTED)
    if text.lstrip().startswith("<"):
        found, unit = _of_kva(read_xml(path, expected=_EXPECTED), fps, where), "px"
    else:
        gnuplot = text.startswith("#")
        rows = _of_text(text, where) if gnuplot else _of_table(path, where)
        found = _with_frames(rows, fps, where)
    if unit is None:
        tell_units(
            where,
            taken="lengths are called px, with y upwards, as Kinovea writes it (its .kva is in px)",
        )
    return digitised_tracks(found, fps=fps, unit=unit or "px", program="Kinovea", where=where)


def _of_kva(root: ElementTree.Element, fps: float, where: str) -> _Points:
    """Return the trajectories of a .kva."""
    version = to_number(root.findtext("FormatVersion") or "", where=f"{where}: FormatVersion")
    if version < 2:
        raise InputError(
            f"{where}: written by a Kinovea before 0.8.16; open it with its film in a newer one, "
            "and save it again."
        )
    each = to_number(
        root.findtext("AverageTimeStampsPerFrame") or "",
        where=f"{where}: AverageTimeStampsPerFrame",
    )
    if each <= 0:
        raise InputError(f"{where}: AverageTimeStampsPerFrame is {each:g}; expected one above 0.")
    begin = to_number(root.findtext("FirstTimeStamp") or "0", where=f"{where}: FirstTimeStamp")
    if (rate := root.findtext("CaptureFramerate")) is not None:
        tell_rate(where, to_number(rate, where=f"{where}: CaptureFramerate"), fps, stacklevel=4)
    found: dict[str, FloatArray] = {}
    for i, track in enumerate(root.iterfind("Tracks/Track"), start=1):
        label = track.find("MainLabel")
        name = track.get("name") or (label.get("Text") if label is not None else None)
        rows = _rows_of_kva(track, where)
        if len(rows) and rows[0, 2] == 0:  # 0.8.15 counts from the track's first time stamp
            rows[:, 2] += to_number(track.findtext("TimePosition") or "0", where=where)
        own = name or f"track{i}"
        _tell_twice(found, own, where)
        found[own] = rows
    if not found:
        raise InputError(
            f"{where}: no trajectory in it; track the feet in Kinovea (right click on a marker, "
            "Track path), and save again."
        )
    stamps = np.unique(np.concatenate([rows[:, 2] for rows in found.values()]))
    frames = _frames_of_stamps(stamps, begin, each)
    return {
        name: (frames[np.searchsorted(stamps, rows[:, 2])], rows[:, :2] - _HALF)
        for name, rows in found.items()
    }


def _frames_of_stamps(stamps: FloatArray, begin: float, each: float) -> IntArray:
    """Return the frame of each of rising time stamps.

    The file says how many stamps a frame lasts in whole numbers, as 2 or 3 where it lasts 2.5 (240
    frames a second in 600 stamps a second, of telephones): then the stamps themselves tell it.
    """
    numbers = (stamps - begin) / each
    if len(stamps) > 1 and (np.abs(numbers - np.rint(numbers)) > _OFF_GRID).any():
        step = step_of_times(stamps)
        numbers = (stamps - stamps[0]) / step + np.rint((stamps[0] - begin) / step)
    return np.rint(numbers).astype(np.int64)


def _rows_of_kva(track: ElementTree.Element, where: str) -> FloatArray:
    """Return x, y and time stamp of each point of a trajectory, shape (n, 3)."""
    rows = [
        [to_number(word, where=f"{where}: a TrackPoint") for word in (point.text or "").split(";")]
        for point in track.iterfind("TrackPointList/TrackPoint")
    ]
    if any(len(row) < 3 for row in rows):
        raise InputError(f"{where}: a TrackPoint without x;y;time; save the file anew.")
    return np.array([row[:3] for row in rows], dtype=float).reshape(-1, 3)


def _tell_twice(found: Collection[str], name: str, where: str) -> None:
    """Refuse a name that another trajectory has."""
    if name in found:
        raise InputError(
            f"{where}: two trajectories are called {name!r}; name them differently in Kinovea."
        )


def _of_text(text: str, where: str) -> dict[str, FloatArray]:
    """Return time, x, y of each point of the export for gnuplot: a block a trajectory."""
    blocks: list[tuple[str, list[list[float]]]] = []
    fresh = True  # whether the next row begins a block; older files name none
    for i, line in enumerate(text.split("\n"), start=1):
        words = line.split()
        if i <= 2 or not words:
            fresh = True
        elif line.startswith("#"):
            blocks.append((line[1:].strip(), []))
            fresh = False
        else:
            if fresh:
                blocks.append(("", []))
            fresh = False
            here = f"{where}: line {i}"
            _tell_suffix(line, here)
            blocks[-1][1].append(
                [_time(words[0], here), *(to_number(w, where=here, mark=",") for w in words[1:])]
            )
    found: dict[str, FloatArray] = {}
    for k, (name, rows) in enumerate(blocks, start=1):
        if not rows:
            continue  # a trajectory without a point
        widths = {len(row) for row in rows}
        if len(widths) > 1 or min(widths) % 2 == 0 or min(widths) < 3:
            raise InputError(f"{where}: {name or k} has a row without time, x and y; export anew.")
        values = np.array(rows, dtype=float)
        own = name or f"track{k}"
        several = values.shape[1] > 3  # an angle or a figure with several points
        for j in range(1, values.shape[1], 2):
            called = f"{own} {(j + 1) // 2}" if several else own
            _tell_twice(found, called, where)
            found[called] = values[:, [0, j, j + 1]]
    return found


def _tell_suffix(line: str, where: str) -> None:
    """Refuse a row whose lengths have their unit behind them."""
    if (unit := _SUFFIX.search(line)) is not None:
        raise InputError(
            f"{where}: {unit[0].strip()!r}; expected time, x and y as bare numbers: take "
            f"{unit[1]!r} away from all of them, and name the file in a trial.toml of kind "
            f"'tracks' with the unit below [calibration], where it is not px."
        )


def _time(word: str, where: str) -> float:
    """Return a time: a number, or hours:minutes:seconds:parts of older files in s."""
    if (code := _TIMECODE.fullmatch(word)) is None:
        return to_number(word, where=where, mark=",")
    hours, minutes, seconds = (int(code[i]) for i in (1, 2, 3))
    return 3600 * hours + 60 * minutes + seconds + int(code[4]) / 10 ** len(code[4])


def _of_table(path: str | Path, where: str) -> dict[str, FloatArray]:
    """Return time, x, y of each point of the csv: a column a coordinate."""
    cells = read_cells(path, ("Time",))
    times = (
        np.array([_time(cell, where) for cell in cells["Time"]])
        if cells["Time"].str.fullmatch(_TIMECODE.pattern).all()
        else read_numbers(cells, "Time", where=where)
    )
    found: dict[str, FloatArray] = {}
    for column in map(str, cells):
        if not column.endswith("/X"):
            continue
        name, key, _ = column.rsplit("/", 2)
        other = f"{name}/{key}/Y"
        if other not in cells:
            raise InputError(f"{where}: column {other!r} is missing; export the file anew.")
        values = [read_numbers(cells, one, where=where, empty=True) for one in (column, other)]
        rows = np.column_stack([times, *values])
        own = name if key == "0" else f"{name} {key}"
        _tell_twice(found, own, where)
        found[own] = rows[~np.isnan(rows).any(axis=1)]
    return found


def _with_frames(rows: dict[str, FloatArray], fps: float, where: str) -> _Points:
    """Return frames in place of times, and y downwards."""
    times = np.unique(np.concatenate([own[:, 0] for own in rows.values()] or [np.zeros(0)]))
    frames = frames_of_times(times, fps=fps, where=where)
    return {
        name: (frames[np.searchsorted(times, own[:, 0])], own[:, 1:] * [1.0, -1.0])
        for name, own in rows.items()
    }
