"""Markers of motion capture as text: OpenSim's .trc, .tsv of Qualisys (QTM) and .csv of Vicon."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError, InputWarning
from pawnb.files import read_text
from pawnb.input_warnings import warn_of_input
from pawnb.io.lengths import short_unit, tell_no_unit, units_per_unit
from pawnb.io.points import SLOWEST_FILM_HZ, build_tracks, by_subject, check_names, tell_rate
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

_TRC, _QTM = "a .trc with markers, as OpenSim reads it", "a .tsv with 3D markers, as QTM writes it"
_VICON = "a .csv with Trajectories, as Vicon Nexus writes it"
_NO_PLACE = ("", "nan", "null")
_ROWS_OF_NAMES = {"trajectory_types", "frame"}
"""Rows of QTM between the names of its markers and their places."""
_TRAJECTORIES = "Trajectories"
_OFF_RATE = 0.01
"""Times that last longer or shorter than the rate says by more than this share, and by more than a
frame, are of another rate. Set by hand: times are written with as few as two decimals."""
_OFF_USUAL = 0.05
"""Share by which a usual step of time may differ from that of the rate. Set by hand, as above."""
_BEFORE = ("Devices", "Joints", "Model Outputs", "Segments")
"""Parts of Vicon's csv that may come before the trajectories, such as those of force plates."""


@dataclass(frozen=True, kw_only=True)
class _Capture:
    """What a file says: markers, rate, unit, number of rows, and its rows of cells below."""

    where: str
    program: str
    markers: Sequence[str]
    rate_hz: float
    unit: str
    rows: Sequence[tuple[int, Sequence[str]]]
    counted: int
    """Columns before the places: none, that of frames, or those of frames and times."""
    n_rows: int | None = None


def motion_capture_format(lines: Sequence[str]) -> str | None:
    """Say which text of motion capture begins with these lines, None for no such.

    Parameters
    ----------
    lines : sequence of str
        The first lines of a file.

    Returns
    -------
    str or None
        ``"trc"``, ``"qtm"``, ``"vicon"`` or None.
    """
    first = lines[0] if lines else ""
    if first.startswith("PathFileType"):
        return "trc"
    if first.startswith("NO_OF_FRAMES\t"):
        return "qtm"
    if first.strip(",\t ") == _TRAJECTORIES:
        return "vicon"
    counted = len(lines) > 1 and lines[1].strip(",\t ").isdigit()
    return "vicon" if counted and first.strip(",\t ") in _BEFORE else None


@checked_arguments
def read_trc(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    r"""Read markers of OpenSim, as Pose2Sim, OpenCap, Cortex and Motive write them, too.

    Parameters
    ----------
    path : str or Path
        ``.trc``.
    fps : float, optional
        Frames per second; default as the file says, by its times where these do not fit its
        header.
    unit : str, optional
        Unit of length that positions are brought to; default as the file says.

    Returns
    -------
    xarray.Dataset
        Tracks in space without confidence. Axes are the file's own: in OpenSim y is up. The row
        at time 0 is frame 0. Empty cells, NaN and (0, 0, 0) are markers that were not seen.

    Raises
    ------
    InputError
        If the file is damaged, or its unit cannot be brought to that which is given.

    Warns
    -----
    InputWarning
        That y may be up, where no ``unit`` is given, as that of a trial with a calibration is; if
        the file says another frame rate or number of rows, no unit, or its header another rate
        than its times.

    Examples
    --------
    >>> text = '''PathFileType\t4\t(X/Y/Z)\tclip.trc
    ... DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits
    ... 100\t100\t2\t1\tmm
    ... Frame#\tTime\tFR\t\t
    ... \t\tX1\tY1\tZ1
    ... 1\t0.00\t1.5\t0.5\t2.5
    ... 2\t0.01\t1.6\t0.5\t2.5
    ... '''
    >>> Path("clip.trc").write_text(text) > 0
    True
    >>> pawnb.io.read_trc("clip.trc", unit="mm")["position"].values[0].ravel().tolist()
    [1.5, 0.5, 2.5]
    """
    where = Path(path).name
    rows = _rows(path, "\t", _TRC)
    head = {cells[0]: i for i, (_, cells) in reversed(list(enumerate(rows[:6])))}
    if "DataRate" not in head or "Frame#" not in head:
        raise InputError(f"{where}: no lines DataRate and Frame#; expected {_TRC}.")
    said = dict(zip(rows[head["DataRate"]][1], rows[head["DataRate"] + 1][1], strict=False))
    at = head["Frame#"]
    markers = [cell for cell in rows[at][1][2:] if cell]
    below = at + 1
    while below < len(rows) and not rows[below][1][0]:
        below += 1  # the line of X1, Y1, Z1
    if unit is None:
        warn_of_input(
            f"{where}: axes are the file's own, and in OpenSim y is up, which is taken to be z "
            "elsewhere. Where it is y, name the file in a trial.toml of kind 'tracks' with "
            'unit = "mm" (or what lengths shall be in) and up = [0, 1, 0] below [calibration].',
            InputWarning,
            stacklevel=2,
        )
    return _tracks(
        _Capture(
            where=where, program="OpenSim trc", markers=markers,
            rate_hz=_number(said.get("DataRate"), "DataRate", where),
            unit=short_unit(said.get("Units", "")), rows=rows[below:], counted=2,
            n_rows=int(_number(said.get("NumFrames"), "NumFrames", where)),
        ),
        fps, unit,
    )  # fmt: skip


@checked_arguments
def read_qtm(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    r"""Read markers of Qualisys Track Manager (QTM).

    Parameters
    ----------
    path : str or Path
        ``.tsv`` of 3D data, with or without a header of its columns.
    fps : float, optional
        Frames per second; default as the file says.
    unit : str, optional
        Unit of length that positions are brought to; default mm, in which QTM writes.

    Returns
    -------
    xarray.Dataset
        Tracks in space without confidence; the first frame of the measurement is frame 0. Empty
        cells, NULL and (0, 0, 0) are markers that were not seen.

    Raises
    ------
    InputError
        If the file is damaged or holds no 3D data, or mm cannot be brought to the unit.

    Warns
    -----
    InputWarning
        If the file says another frame rate or number of rows, or its header another rate than
        its times.

    Examples
    --------
    >>> text = "NO_OF_FRAMES\t1\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\tFR\n1\t2\t3\n"
    >>> Path("clip.tsv").write_text(text) > 0
    True
    >>> pawnb.io.read_qtm("clip.tsv")["position"].values.ravel().tolist()
    [1.0, 2.0, 3.0]
    """
    where = Path(path).name
    rows = _rows(path, "\t", _QTM)
    at = next((i for i, (_, cells) in enumerate(rows) if cells[0] == "MARKER_NAMES"), None)
    said = {cells[0]: (cells[1:] or [""])[0] for _, cells in rows[:at]}
    if at is None or said.get("DATA_INCLUDED") != "3D":
        raise InputError(
            f"{where}: it holds {said.get('DATA_INCLUDED') or 'no'} data; expected {_QTM}: choose "
            "3D data as QTM exports it."
        )
    begin, counted = at + 1, 0
    markers = [name for name in rows[at][1][1:] if name]
    headings = {*_ROWS_OF_NAMES, *(f"{name} x".lower() for name in markers[:1])}
    while begin < len(rows) and rows[begin][1][0].lower() in headings:
        counted = 2 if rows[begin][1][0].lower() == "frame" else counted
        begin += 1
    return _tracks(
        _Capture(
            where=where, program="QTM", markers=markers,
            rate_hz=_number(said.get("FREQUENCY"), "FREQUENCY", where), unit="mm",
            rows=rows[begin:], counted=counted,
            n_rows=int(_number(said.get("NO_OF_FRAMES"), "NO_OF_FRAMES", where)),
        ),
        fps, unit,
    )  # fmt: skip


@checked_arguments
def read_vicon(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    r"""Read trajectories of Vicon Nexus.

    Parameters
    ----------
    path : str or Path
        ``.csv`` with a part ``Trajectories``; others, such as ``Devices``, are left out.
    fps : float, optional
        Frames per second; default as the file says.
    unit : str, optional
        Unit of length that positions are brought to; default as the file says.

    Returns
    -------
    xarray.Dataset
        Tracks in space without confidence; frame 1 of the file is frame 0. Empty cells and
        (0, 0, 0) are markers that were not seen. Subjects are the animals.

    Raises
    ------
    InputError
        If the file is damaged, or its unit cannot be brought to that which is given.

    Warns
    -----
    InputWarning
        If the file says another frame rate.

    Examples
    --------
    >>> text = "Trajectories\n100\n,,m07:FR,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n"
    >>> Path("clip.csv").write_text(text) > 0
    True
    >>> pawnb.io.read_vicon("clip.csv")["keypoint"].values.tolist()
    ['FR']
    """
    where = Path(path).name
    rows = _rows(path, ",", _VICON, begin=_TRAJECTORIES)
    if not rows:
        raise InputError(f"{where}: no part {_TRAJECTORIES}; choose it as Nexus exports the file.")
    lines = [cells for _, cells in rows[:5]]
    if len(lines) < 5 or lines[3][:1] != ["Frame"]:
        raise InputError(f"{where}: no line Frame, Sub Frame, X, Y, Z; expected {_VICON}.")
    own = [i for i, cell in enumerate(lines[2]) if cell and "'" not in cell]
    n = len(own)
    if own != list(range(2, 2 + 3 * n, 3)):
        raise InputError(f"{where}: markers stand in other columns; expected {_VICON}.")
    return _tracks(
        _Capture(
            where=where, program="Vicon", markers=[lines[2][i] for i in own],
            rate_hz=_number(lines[1][0], "the rate", where), unit=short_unit(lines[4][2] or "mm"),
            rows=[(i, cells[: 2 + 3 * n]) for i, cells in rows[5:]], counted=2,
        ),
        fps, unit,
    )  # fmt: skip


def _rows(
    path: str | Path, mark: str, expected: str, *, begin: str = ""
) -> list[tuple[int, list[str]]]:
    """Return the lines that hold anything, with their numbers.

    Where a part of the file begins with a line, from there to the first empty one.
    """
    text = read_text(path, expected=expected)
    found: list[tuple[int, list[str]]] = []
    for i, cells in enumerate(csv.reader(text.split("\n"), delimiter=mark), start=1):
        row = [cell.strip() for cell in cells]
        if any(row) and (found or not begin or row[0] == begin):
            found.append((i, row))
        elif begin and len(found) > 5:
            break  # another part follows
    return found


def _number(said: str | None, what: str, where: str) -> float:
    """Return a number of the header above 0."""
    try:
        value = float(said or "")
    except ValueError:
        value = np.nan
    if not 0 < value < np.inf:
        raise InputError(f"{where}: {what} is {said!r}; expected a number above 0.")
    return value


def _tracks(said: _Capture, fps: float | None, unit: str | None) -> Tracks:
    """Make Tracks of what a file says."""
    where, width = said.where, said.counted + 3 * len(said.markers)
    if not said.rows or not said.markers:
        raise InputError(f"{where}: no rows, or no markers; expected one row for each frame.")
    cells = [[*row[:width], *[""] * (width - len(row))] for _, row in said.rows]
    over = next((i for i, row in said.rows if any(row[width:])), None)
    if over is not None:
        raise InputError(
            f"{where}: line {over} has more cells than the {len(said.markers)} markers need; mend "
            "that line, or export the file again."
        )
    table = pd.Series([cell for row in cells for cell in row])
    values = pd.to_numeric(table, errors="coerce").to_numpy(float).reshape(len(cells), width)
    empty = table.str.lower().isin(_NO_PLACE).to_numpy(bool).reshape(values.shape)
    empty = empty & (np.arange(width) >= said.counted)
    if (bad := ~np.isfinite(values) & ~empty).any():
        row, column = np.argwhere(bad)[0]
        raise InputError(
            f"{where}: line {said.rows[row][0]}, cell {column + 1} is {cells[row][column]!r}; "
            "expected a number, or an empty cell."
        )
    counted = _numbered_by_times(values[:, : said.counted], said)
    said = _at_rate_of_times(said, counted, fps)
    _tell_doubts(said, fps)
    place = values[:, said.counted :].reshape(len(cells), -1, 3)
    place = np.where((place == 0).all(axis=-1, keepdims=True), np.nan, place)
    if not (unit or said.unit):
        tell_no_unit(where, stacklevel=3)
    own = said.unit or "mm"
    check_names(said.markers, what="marker", where=where)
    points, animals, place = by_subject(said.markers, place)
    return build_tracks(
        _frames(counted, said),
        place * (1.0 if unit is None else units_per_unit(own, unit, where=where)),
        points=points,
        fps=fps or said.rate_hz,
        unit=unit or own,
        program=said.program,
        where=where,
        individuals=animals,
    )


def _frames(counted: FloatArray, said: _Capture) -> IntArray:
    """Return the number of each row's frame, from 0."""
    if not said.counted:
        return np.arange(len(counted))
    numbers = np.rint(counted[:, 0]).astype(np.int64)
    if said.program == "Vicon":  # its second column is no time
        return numbers - 1
    # Pose2Sim counts frames from 0, OpenSim and QTM from 1
    first = numbers[0] - np.rint(counted[0, 1] * said.rate_hz)
    return numbers - (int(first) if first in (0, 1) else 1)


def _numbered_by_times(counted: FloatArray, said: _Capture) -> FloatArray:
    """Return numbers and times of rows, numbers mended where times jump and they do not.

    OpenSim writes 1, 2, 3 ... whatever the times are, and goes by these.
    """
    if said.counted < 2 or said.program == "Vicon" or len(counted) < 3:
        return counted
    steps, steps_s = np.diff(counted, axis=0).T
    usual_s = float(np.median(steps_s / steps)) if (steps > 0).all() else 0.0
    if usual_s <= 0.0:
        return counted
    exact = abs(usual_s * said.rate_hz - 1.0) <= _OFF_USUAL  # else rounded times jump by one, too
    off = steps_s / usual_s - steps
    taken = np.where(np.abs(off) > (0.75 if exact else 1.5), np.rint(off), 0.0)
    if (steps + taken < 1).any():
        return counted
    return np.column_stack(
        [counted[:, 0] + np.concatenate([[0.0], np.cumsum(taken)]), counted[:, 1]]
    )


def _at_rate_of_times(said: _Capture, counted: FloatArray, fps: float | None) -> _Capture:
    """Return what a file says with the rate of its times, which OpenSim goes by."""
    if said.counted < 2 or said.program == "Vicon" or len(counted) < 2:
        return said
    numbers, times = counted.T
    n, span_s = numbers[-1] - numbers[0], times[-1] - times[0]
    off_s = abs(span_s - n / said.rate_hz)
    if not (n > 0 and span_s > 0) or off_s <= _OFF_RATE * span_s + 1.0 / said.rate_hz:
        return said
    if fps is not None and abs(fps - said.rate_hz) <= _OFF_RATE * fps:
        return said  # the header is right, as a person says
    step_s = np.polyfit(numbers - numbers[0], times - times[0], 1)[0]  # each may be rounded
    rate_hz = float(f"{1.0 / step_s:.6g}") if step_s > 0 else n / span_s
    if rate_hz <= SLOWEST_FILM_HZ:
        return said
    if fps is None:
        warn_of_input(
            f"{said.where} says {said.rate_hz:g} frames per second in its header, and its times "
            f"are those of {rate_hz:g}, which is used, as OpenSim does: all times and speeds "
            "follow from it. Where the header is right, give it as fps (--fps in a terminal).",
            InputWarning,
            stacklevel=4,
        )
    return replace(said, rate_hz=rate_hz)


def _tell_doubts(said: _Capture, fps: float | None) -> None:
    """Warn of another frame rate or number of rows than the file says."""
    tell_rate(said.where, said.rate_hz, fps, stacklevel=4)
    if said.n_rows is not None and said.n_rows != len(said.rows):
        warn_of_input(
            f"{said.where} says that it has {said.n_rows} frames, and has {len(said.rows)}: where "
            "it was cut short, copy it again from where it is whole.",
            InputWarning,
            stacklevel=4,
        )
