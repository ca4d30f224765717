"""Spots of TrackMate (Fiji): its project and its export of tracks as .xml, its table as .csv.

Laid out as in files that users published: TrackMate 3.8 to 7.11.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.files import read_text
from pawnb.io.digitised import digitised_tracks, read_xml, tell_units, to_frames, to_number
from pawnb.io.lengths import units_per_unit
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks, check_fps
from pawnb.schema.arguments import checked_arguments

_EXPECTED = "spots of TrackMate as .csv, or its tracks or project as .xml"
_UNITS = {
    "pixel": "px", "pixels": "px", "micron": "um", "microns": "um", "µm": "um", "inch": "in",
}  # fmt: skip
_COLUMNS = ("TRACK_ID", "POSITION_X", "POSITION_Y", "FRAME")


@checked_arguments
def read_trackmate(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    r"""Read the spots of TrackMate that belong to a track.

    Parameters
    ----------
    path : str or Path
        The table of spots, ``.csv``; or ``.xml``: TrackMate's own, or its export of tracks.
    fps : float
        Frames per second of the recording.
    unit : str, optional
        Unit that positions are brought to; default as the file says, px where it says none.

    Returns
    -------
    xarray.Dataset
        Tracks in a plane without confidence. Points are called as the tracks, ``Track_0`` and so
        on; spots without a track are left out.

    Raises
    ------
    InputError
        If the file is damaged, has no track, a track has two spots in a frame, or its unit cannot
        be brought to that which is given.

    Warns
    -----
    InputWarning
        If the file says no unit.

    Examples
    --------
    >>> text = "LABEL,ID,TRACK_ID,POSITION_X,POSITION_Y,FRAME\n,,,(pixel),(pixel),\nID1,1,0,5,6,0\n"
    >>> Path("spots.csv").write_text(text) > 0
    True
    >>> pawnb.io.read_trackmate("spots.csv", fps=250.0)["keypoint"].values.tolist()
    ['Track_0']
    """
    check_fps(fps)
    where = Path(path).name
    if read_text(path, expected=_EXPECTED).lstrip().startswith("<"):
        found, said = _of_xml(read_xml(path, expected=_EXPECTED), where)
    else:
        found, said = _of_table(path, where)
    if not said and unit is None:
        tell_units(where, taken="lengths are called px")
    said = _UNITS.get(said, said) or unit or "px"
    scale = 1.0 if unit is None else units_per_unit(said, unit, where=where)
    points = {
        name: (to_frames(rows[:, 0], where=where), rows[:, 1:] * scale)
        for name, rows in found.items()
    }
    return digitised_tracks(points, fps=fps, unit=unit or said, program="TrackMate", where=where)


def _of_table(path: str | Path, where: str) -> tuple[dict[str, FloatArray], str]:
    """Return frame, x, y of each track of a table of spots, and its unit."""
    cells = read_cells(path, _COLUMNS)
    # up to three rows of names and units stand above the first spot
    data = cells["FRAME"].str.fullmatch(r"\d+(\.0*)?").to_numpy(bool)
    first = int(np.argmax(data)) if data.any() else len(cells)
    units = [re.fullmatch(r"\((.+)\)", cell) for cell in cells["POSITION_X"].iloc[:first]]
    said = next((unit[1] for unit in units if unit), "")
    cells = cells.iloc[first:]
    cells = cells[~cells["TRACK_ID"].isin(("", "None"))].reset_index(drop=True)
    track, *numbers = [read_numbers(cells, name, where=where) for name in _COLUMNS]
    rows = np.column_stack([numbers[2], numbers[0], numbers[1]])
    return {f"Track_{one:g}": rows[track == one] for one in np.unique(track)}, said


def _of_xml(root: ElementTree.Element, where: str) -> tuple[dict[str, FloatArray], str]:
    """Return frame, x, y of each track of a file in XML, and its unit."""
    if root.tag == "Tracks":
        tracks = {
            f"Track_{i}": _rows(list(one.iterfind("detection")), ("t", "x", "y"), where)
            for i, one in enumerate(root.iterfind("particle"))
        }
        return tracks, root.get("spaceUnits") or ""
    model = root.find("Model")
    if model is None:
        raise InputError(f"{where}: no Model in it; expected {_EXPECTED}.")
    spots = {spot.get("ID"): spot for spot in model.iterfind("AllSpots/SpotsInFrame/Spot")}
    kept = {one.get("TRACK_ID") for one in model.iterfind("FilteredTracks/TrackID")}
    found: dict[str, FloatArray] = {}
    for track in model.iterfind("AllTracks/Track"):
        number = track.get("TRACK_ID")
        if kept and number not in kept:
            continue
        name = track.get("name") or f"Track_{number}"
        if name in found:
            raise InputError(
                f"{where}: two tracks are called {name!r}; name them differently in TrackMate."
            )
        ids = {edge.get(f"SPOT_{end}_ID") for edge in track for end in ("SOURCE", "TARGET")}
        if lost := ids - set(spots):
            raise InputError(f"{where}: spot {lost.pop()} of {name} is not there; save it anew.")
        own = [spots[one] for one in sorted(ids, key=str)]
        found[name] = _rows(own, ("FRAME", "POSITION_X", "POSITION_Y"), where)
    return found, model.get("spatialunits") or ""


def _rows(spots: list[ElementTree.Element], names: tuple[str, ...], where: str) -> FloatArray:
    """Return attributes of elements as numbers, shape (n, 3)."""
    rows = [[to_number(one.get(name) or "", where=f"{where}: {name}") for name in names]
            for one in spots]  # fmt: skip
    return np.array(rows, dtype=float).reshape(-1, len(names))
