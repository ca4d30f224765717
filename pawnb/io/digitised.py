"""Points digitised by hand in Kinovea, Tracker and ImageJ: what their readers have in common."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError, InputWarning
from pawnb.files import read_bytes
from pawnb.input_warnings import warn_of_input
from pawnb.io.points import build_tracks
from pawnb.io.separators import separator_of
from pawnb.schema import Tracks

_XML = (
    ("<KinoveaVideoAnalysis", "kinovea"),
    ("org.opensourcephysics.cabrillo.tracker", "tracker"),
    ("<TrackMate", "trackmate"),
    ("<particle", "trackmate"),
)
_SPOTS = {"TRACK_ID", "POSITION_X", "POSITION_Y", "FRAME"}
_TRAJECTORY = re.compile(r".+/.+/[XY]")
_MANUAL = re.compile(r"Track n.{1,2}[,;\t]\"?Slice n")
_SAME_STEP = 0.02
"""Part by which steps of times may differ from those of the frame rate. Set by hand: times that
are rounded to ms are off by 0.6 % after 20 frames at 120 frames per second."""

_ONE_STEP = 1.75
"""Times farther apart than this many of their median step are not of frames in succession.
Mathematics: rounded steps of 2 and 3 are both of one frame, 4 and more of two."""


def digitised_format(lines: Sequence[str]) -> str | None:
    """Say which program's digitised points begin with these lines, None for no such.

    Parameters
    ----------
    lines : sequence of str
        The first lines of a file.

    Returns
    -------
    str or None
        ``"kinovea"``, ``"tracker"``, ``"trackmate"``, ``"mtrackj"``, ``"manual-tracking"`` or
        None.
    """
    first = lines[0] if lines else ""
    if first.lstrip().startswith("<"):
        head = "\n".join(lines)
        return next((name for word, name in _XML if word in head), None)
    if first.startswith("#Kinovea Trajectory") or _is_kinovea_table(first):
        return "kinovea"
    if set(_cells(first)) >= _SPOTS:
        return "trackmate"
    if re.match(r"MTrackJ [\d.]+ Data File", first):
        return "mtrackj"
    if _MANUAL.search(first):
        return "manual-tracking"
    return "tracker" if names_of_tracker(lines) is not None else None


def _cells(line: str) -> list[str]:
    """Return the names of the columns of a table."""
    return [cell.strip(' "') for cell in line.split(separator_of(line))]


def _is_kinovea_table(line: str) -> bool:
    """Say whether a line names the columns of Kinovea's trajectories."""
    first, *others = _cells(line) or [""]
    return first == "Time" and bool(others) and all(map(_TRAJECTORY.fullmatch, others))


def names_of_tracker(lines: Sequence[str]) -> int | None:
    """Return which line of a table of Tracker names its point masses, None where none does.

    Parameters
    ----------
    lines : sequence of str
        The first lines of a file.

    Returns
    -------
    int or None
        0, or 1 below ``#multi:``.
    """
    at = 1 if lines and lines[0].strip() == "#multi:" else 0
    if len(lines) < at + 2 or lines[at][:1] not in ("\t", ",", ";"):
        return None
    mark = lines[at][0]
    names, columns = ([c.strip() for c in line.split(mark)] for line in lines[at : at + 2])
    has_points = {"x", "y"} <= set(columns) or {"pixelx", "pixely"} <= set(columns)
    return at if columns[0] == "t" and any(names) and has_points else None


def read_xml(path: str | Path, *, expected: str) -> ElementTree.Element:
    """Read XML that defines no entities of its own.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for messages.

    Returns
    -------
    xml.etree.ElementTree.Element
        Its outermost element.

    Raises
    ------
    InputError
        If it is damaged, or defines entities: a short text may become endless by them.
    """
    data = read_bytes(path, expected=expected)
    where = Path(path).name
    if any(mark in data for mark in (b"<!DOCTYPE", b"<!ENTITY", b"\0")):
        raise InputError(
            f"{where}: XML that defines entities, or not in UTF-8; expected {expected}: save it "
            "anew from the program."
        )
    try:
        return ElementTree.fromstring(data)  # noqa: S314 (without entities)
    except (ElementTree.ParseError, ValueError, LookupError) as reason:
        raise InputError(
            f"{where}: damaged XML ({reason}); expected {expected}: copy it again from where it is "
            "whole, or save it anew."
        ) from None


def to_number(word: str, *, where: str, mark: str = ".") -> float:
    """Return a number of a file.

    Parameters
    ----------
    word : str
        What stands there.
    where : str
        File and place, for the message.
    mark : str
        What begins its decimals, beside the point.

    Returns
    -------
    float
        The number.

    Raises
    ------
    InputError
        If it is none, or not finite.
    """
    try:
        value = float(word.strip().replace(mark, "."))
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{where}: {word.strip()!r}; expected a number.")
    return value


def to_frames(numbers: Sequence[float] | FloatArray, *, where: str) -> IntArray:
    """Return numbers of frames as whole numbers.

    Parameters
    ----------
    numbers : sequence of float, shape (n,)
        The numbers.
    where : str
        How messages name the file.

    Returns
    -------
    ndarray, shape (n,)
        The same, int64.

    Raises
    ------
    InputError
        If one is not whole.
    """
    values = np.asarray(numbers, dtype=float)
    if (off := values[values != np.rint(values)]).size:
        raise InputError(f"{where}: {off[0]:g} is no number of a frame; expected whole numbers.")
    return values.astype(np.int64)


def frames_of_times(times: FloatArray, *, fps: float, where: str) -> IntArray:
    """Return the frame that each time belongs to, whatever unit times are in.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Rising times of all rows: s, ms, µs or frames, perhaps rounded.
    fps : float
        Frames per second of the recording.
    where : str
        How messages name the file.

    Returns
    -------
    ndarray, shape (n,)
        Frames; 0 is at time 0, or at the first time where that lies before 0.

    Raises
    ------
    InputError
        If times are rounded so coarsely that several are those of one frame.

    Warns
    -----
    InputWarning
        If times do not go in steps of one frame.
    """
    if len(times) < 2:
        return np.zeros(len(times), dtype=np.int64)
    known = _known_step(times, fps)
    step = known or step_of_times(times)
    first = 0 if times[0] < 0 else int(np.rint(times[0] / step))
    frames = np.rint((times - times[0]) / step).astype(np.int64) + first
    if (close := np.flatnonzero(np.diff(frames) < 1)).size:
        first, second = times[close[0]], times[close[0] + 1]
        raise InputError(
            f"{where}: times {first:g} and {second:g} are those of one frame, as most go in steps "
            f"of {step:.4g}: rounded too coarsely, or wrong; let the program write times in frames "
            "or milliseconds, and export again."
        )
    if known is None:
        warn_of_input(
            f"{where}: its times go in steps of {step:.4g}, and at {fps:g} frames per second a "
            f"frame lasts {1 / fps:.4g} s. One step is taken to be one frame, as in a film that "
            "plays slowed down; if every second or third frame only was digitised, give the rate "
            "of those.",
            InputWarning,
            stacklevel=4,
        )
    return frames


def _known_step(times: FloatArray, fps: float) -> float | None:
    """Return the step of times of which the nearest are one frame apart, None where not."""
    gaps = np.diff(times)
    for frame in (1 / fps, 1e3 / fps, 1e6 / fps, 1.0):  # in s, ms, µs, frames
        counted = np.rint(gaps / frame)
        if counted.min() == 1:
            step = float((times[-1] - times[0]) / counted.sum())
            if abs(step - frame) <= _SAME_STEP * frame:
                return step
    return None


def step_of_times(times: FloatArray) -> float:
    """Return the step that most times go in, as exactly as they tell.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Two or more rising times, perhaps rounded, some steps left out.

    Returns
    -------
    float
        The step, in the unit of the times.
    """
    gaps = np.diff(times)
    step = float(gaps[gaps < _ONE_STEP * np.median(gaps)].mean())
    return float((times[-1] - times[0]) / np.rint(gaps / step).sum())


def tell_units(where: str, *, taken: str) -> None:
    """Warn that a text does not say its unit of length.

    Parameters
    ----------
    where : str
        How messages name the file.
    taken : str
        What is taken to be so.
    """
    warn_of_input(
        f"{where}: it says no unit, and {taken}. Where they are in another unit, name the file in "
        "a trial.toml of kind 'tracks' with it below [calibration] (unit = \"cm\").",
        InputWarning,
        stacklevel=3,
    )


def digitised_tracks(
    found: Mapping[str, tuple[IntArray, FloatArray]],
    *,
    fps: float,
    unit: str,
    program: str,
    where: str,
) -> Tracks:
    """Make Tracks of points that each have frames of their own.

    Parameters
    ----------
    found : mapping
        Name of a point to its frames, shape (n,), in any order, and places, shape (n, 2).
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of places.
    program : str
        Who made the file.
    where : str
        How messages name the file.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane, one animal, without confidence.

    Raises
    ------
    InputError
        If there is no point, or one has two places in a frame.
    """
    found = {name: rows for name, rows in found.items() if len(rows[0])}
    if not found:
        raise InputError(f"{where}: no point that was digitised; expected the feet of an animal.")
    frames = np.unique(np.concatenate([own for own, _ in found.values()]))
    place = np.full((len(frames), len(found), 1, 2), np.nan)
    for k, (name, (own, xy)) in enumerate(found.items()):
        numbers, count = np.unique(own, return_counts=True)
        if (count > 1).any():
            raise InputError(
                f"{where}: point {name!r} has {count.max()} places in frame "
                f"{numbers[count > 1][0]}; keep one of them."
            )
        place[np.searchsorted(frames, own), k, 0] = xy
    return build_tracks(
        frames, place, points=list(found), fps=fps, unit=unit, program=program, where=where
    )
