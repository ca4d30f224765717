"""Point masses of Tracker (Open Source Physics): its .trk, and its table as text.

Laid out as the program's source writes them (PointMass.java, ExportDataDialog.java), the .trk also
as in the examples that come with it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.files import read_text
from pawnb.io.digitised import (
    digitised_format,
    digitised_tracks,
    frames_of_times,
    names_of_tracker,
    read_xml,
    tell_units,
    to_frames,
    to_number,
)
from pawnb.io.points import tell_rate
from pawnb.schema import Tracks, check_fps
from pawnb.schema.arguments import checked_arguments

_EXPECTED = "a .trk of Tracker, or its table of points as text (File > Export)"
_POINT = "org.opensourcephysics.cabrillo.tracker.PointMass"
_UNNAMED = re.compile(r".*[ _][A-H]")
"""What Tracker calls point masses that nobody named: mass A, mass_A, masa A."""
_CORNER = 0.5
"""Its help (Coordinate System): the upper left corner is at (0, 0), the lower right at the size."""
_ENDINGS = (".txt", ".csv", ".tsv", ".dat")
_HEAD = 4096


@checked_arguments
def read_osp_tracker(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    r"""Read point masses of Tracker, the video analysis of Open Source Physics.

    Parameters
    ----------
    path : str or Path
        ``.trk``, which has px and frames. Or a table as text: one or several point masses as
        Tracker exports or copies them, or a folder with one file for each. A table with
        ``pixelx`` and ``pixely`` is read in px; else ``x`` and ``y``, in the unit of its
        calibration and with y upwards.
    fps : float
        Frames per second of the recording.
    unit : str, optional
        Unit of ``x`` and ``y``, which a table does not say. Where it is given, and is not px,
        these are read, not ``pixelx`` and ``pixely``.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane without confidence, y downwards. Points are called as the point masses;
        those of a folder as their files, where nobody named the mass or several have one name.

    Raises
    ------
    InputError
        If a file is damaged, or has no point mass.

    Warns
    -----
    InputWarning
        If the file says another frame rate, its times go in other steps, or it says no unit.

    Examples
    --------
    >>> text = "\tFR\t\t\t\n" "t\tframe\tpixelx\tpixely\t\n" "0.0\t10\t320.5\t240.5\n"
    >>> Path("FR.txt").write_text(text) > 0
    True
    >>> pawnb.io.read_osp_tracker("FR.txt", fps=250.0)["position"].values.ravel()
    array([320., 240.])
    """
    check_fps(fps)
    path = Path(path)
    where = path.name
    told = None if unit == "px" else unit
    if path.is_dir():
        found, px = _of_folder(path, fps, told)
    else:
        text = read_text(path, expected=_EXPECTED)
        if text.lstrip().startswith("<"):
            found, px, told = _of_trk(read_xml(path, expected=_EXPECTED), fps, where), True, None
        else:
            found, px = _of_table(text, fps, told, where)
    if not px and unit is None:
        tell_units(
            where,
            taken="lengths are called px, with y upwards, as Tracker writes x and y (its pixelx "
            "and pixely are in px)",
        )
    return digitised_tracks(found, fps=fps, unit=told or "px", program="Tracker", where=where)


def tables_in_folder(folder: Path) -> list[Path]:
    """Return the files of a folder that are tables of Tracker.

    Parameters
    ----------
    folder : Path
        The folder.

    Returns
    -------
    list of Path
        By name; none where there is any trial, or other texts than these.
    """
    texts = [one for one in sorted(folder.iterdir()) if one.suffix.lower() in _ENDINGS]
    if any((folder / name).exists() for name in ("trial.toml", "tracks.nc", "events.csv")):
        return []
    for one in texts:
        with one.open("rb") as file:
            head = file.read(_HEAD).decode("utf-8-sig", "replace")
        if digitised_format(head.splitlines()) != "tracker":
            return []
    return texts


def _of_folder(
    folder: Path, fps: float, unit: str | None
) -> tuple[dict[str, tuple[IntArray, FloatArray]], bool]:
    """Return the points of a folder with a table for each."""
    files = tables_in_folder(folder)
    if not files:
        raise InputError(f"{folder}: not a folder with tables of Tracker only; name one of them.")
    tables = [_of_table(read_text(one, expected=_EXPECTED), fps, unit, one.name) for one in files]
    px = {own for _, own in tables}
    if len(px) > 1:
        raise InputError(
            f"{folder}: some of its tables have pixelx and pixely, others x and y only; export all "
            "with the same columns."
        )
    names = [name for points, _ in tables for name in points]
    found: dict[str, tuple[IntArray, FloatArray]] = {}
    for file, (points, _) in zip(files, tables, strict=True):
        for name, rows in points.items():
            told = names.count(name) == 1 and not _UNNAMED.fullmatch(name)
            own = name if told else file.stem if len(points) == 1 else f"{file.stem} {name}"
            if own in found:
                raise InputError(f"{folder}: two points are called {own!r}; name them differently.")
            found[own] = rows
    return found, px.pop()


def _of_trk(
    root: ElementTree.Element, fps: float, where: str
) -> dict[str, tuple[IntArray, FloatArray]]:
    """Return the point masses of a .trk, by name."""
    for clip in root.iterfind("property[@name='clipcontrol']/object"):
        duration = clip.findtext("property[@name='delta_t']")  # ms
        if duration is not None:
            tell_rate(
                where, 1e3 / to_number(duration, where=f"{where}: delta_t"), fps, stacklevel=4
            )
    found: dict[str, tuple[IntArray, FloatArray]] = {}
    for point in root.iter("object"):
        if point.get("class") != _POINT:
            continue
        name = point.findtext("property[@name='name']") or f"mass{len(found) + 1}"
        if name in found:
            raise InputError(
                f"{where}: two point masses are called {name!r}; name them differently in Tracker."
            )
        frames, places = [], []
        for step in point.iterfind("property[@name='framedata']/property"):
            here = f"{where}: {name}, {step.get('name')}"
            said = [step.findtext(f"object/property[@name='{axis}']") for axis in "xy"]
            frames.append(to_number((step.get("name") or "").strip("[]"), where=here))
            places.append([to_number(one or "", where=here) - _CORNER for one in said])
        found[name] = to_frames(frames, where=where), np.array(places).reshape(-1, 2)
    if not any(len(frames) for frames, _ in found.values()):
        raise InputError(f"{where}: no point mass in it; in Tracker, make one of each foot.")
    return found


def _of_table(
    text: str, fps: float, unit: str | None, where: str
) -> tuple[dict[str, tuple[IntArray, FloatArray]], bool]:
    """Return the point masses of a table, by name, and whether they are in px."""
    lines = text.split("\n")
    if (at := names_of_tracker(lines)) is None:
        raise InputError(f"{where}: no lines with names and with t, x, y; expected {_EXPECTED}.")
    mark = lines[at][0]
    columns = _columns(lines[at], lines[at + 1], mark, where)
    decimal = "." if mark == "," else ","
    rows = []
    for i, line in enumerate(lines[at + 2 :], start=at + 3):
        cells = [cell.strip() for cell in line.split(mark)]
        if any(cells):
            rows.append([
                to_number(cell, where=f"{where}: line {i}", mark=decimal) if cell else np.nan
                for cell in (*cells, *[""] * len(lines[at + 1].split(mark)))
            ])  # fmt: skip
    width = min(map(len, rows), default=0)
    values = np.array([row[:width] for row in rows], dtype=float)
    if not rows or np.isnan(values[:, 0]).any():
        raise InputError(f"{where}: a row without a time, or no row; export the table anew.")
    px = unit is None and all({"pixelx", "pixely"} <= set(own) for own in columns.values())
    named = ("pixelx", "pixely") if px else ("x", "y")
    found, frames = {}, _frames(values, columns, fps, where)
    for name, own in columns.items():
        if lacking := [one for one in named if one not in own]:
            raise InputError(
                f"{where}: {name} has no column {lacking[0]}; export it with pixelx and pixely "
                "(Columns > pixel_x, pixel_y), or x and y."
            )
        xy = values[:, [own[one] for one in named]]
        seen = ~np.isnan(xy).any(axis=1)
        found[name] = frames[name][seen], xy[seen] - _CORNER if px else xy[seen] * [1.0, -1.0]
    return found, px


def _columns(names: str, heads: str, mark: str, where: str) -> dict[str, dict[str, int]]:
    """Return the place of each column of each point mass."""
    cells = [cell.strip() for cell in names.split(mark)]
    columns: dict[str, dict[str, int]] = {}
    name = ""
    for i, head in enumerate(cell.strip() for cell in heads.split(mark)):
        if i < len(cells) and cells[i]:
            name = cells[i]
            if name in columns:
                raise InputError(
                    f"{where}: two point masses are called {name!r}; name them differently."
                )
            columns[name] = {}
        if name and head:
            columns[name][head] = i
    return columns


def _frames(
    values: FloatArray, columns: Mapping[str, Mapping[str, int]], fps: float, where: str
) -> dict[str, IntArray]:
    """Return the frame of each row for each point mass: as a column says, else by its time."""
    if not all("frame" in own for own in columns.values()):
        return dict.fromkeys(columns, frames_of_times(values[:, 0], fps=fps, where=where))
    found = {}
    for name, own in columns.items():
        said = values[:, own["frame"]]
        found[name] = to_frames(np.where(np.isnan(said), -1, said), where=where)
    times, frames = values[:, 0], np.max(list(found.values()), axis=0)
    seen = np.flatnonzero(frames >= 0)
    if len(seen) and times[seen[-1]] > times[seen[0]]:
        rate = (frames[seen[-1]] - frames[seen[0]]) / (times[seen[-1]] - times[seen[0]])
        tell_rate(where, float(rate), fps, stacklevel=4)
    return found
