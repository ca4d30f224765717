"""Which points are clicked, and the clicks there are already."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pawnb.errors import InputError
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import START_COLUMNS
from pawnb.trial import Trial

MOUSE_PAWS = {
    "FR": "right front paw",
    "HR": "right hind paw",
    "FL": "left front paw",
    "HL": "left hind paw",
}


def read_unfinished(path: Path) -> pd.DataFrame:
    """Read clicks that may be incomplete: a tracker would refuse them, here they go on.

    Parameters
    ----------
    path : Path
        ``start.csv``.

    Returns
    -------
    pandas.DataFrame
        Columns frame, view, point, u, v.

    Raises
    ------
    InputError
        If the file is not such a table.
    """
    cells = read_cells(path, START_COLUMNS)
    numbers = {name: read_numbers(cells, name, where=path.name) for name in ("u", "v")}
    return cells.assign(frame=read_numbers(cells, "frame", where=path.name, whole=True), **numbers)


def points_by_view(trial: Trial, start: pd.DataFrame | None) -> dict[str, tuple[str, ...]]:
    """Return the points each view tracks; a view that names none tracks every point.

    Parameters
    ----------
    trial : Trial
        The trial; a mouse whose views name no points has its four paws.
    start : pandas.DataFrame or None
        Clicks there are already.

    Returns
    -------
    dict of str to tuple of str
        Points by view, both in the order of the trial.

    Raises
    ------
    InputError
        If no points are named and the animal is not a mouse.
    """
    named = [p for view in trial.views for p in view.points]
    if start is not None and "point" in start:
        named += list(start["point"])
    every = tuple(dict.fromkeys(named))
    if not every and trial.animal.species == "mouse":
        every = tuple(MOUSE_PAWS)
    if not every:
        raise InputError(
            f"trial {trial.name!r} does not say which points to click; add "
            'points = ["FR", "HR"] to its [[views]].'
        )
    return {view.name: view.points or every for view in trial.views}
