"""The speed of a treadmill's belt, from a csv."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pawnb.errors import InputError
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def read_belt_speed(path: str | Path) -> pd.DataFrame:
    """Read the speed of a treadmill's belt.

    Parameters
    ----------
    path : str or Path
        A csv with the columns ``frame, speed`` (unit of length / s).

    Returns
    -------
    pandas.DataFrame
        ``frame`` (whole numbers, rising) and ``speed``.

    Raises
    ------
    InputError
        For a missing column, a cell that is not a number, or a frame given twice.

    Examples
    --------
    >>> pd.DataFrame({"frame": [0, 250], "speed": [300.0, 350.0]}).to_csv("belt.csv", index=False)
    >>> pawnb.io.read_belt_speed("belt.csv")["speed"].tolist()
    [300.0, 350.0]
    """
    where = Path(path).name
    table = read_cells(path, ("frame", "speed"))
    clean = pd.DataFrame(
        {
            "frame": read_numbers(table, "frame", where=where, whole=True),
            "speed": read_numbers(table, "speed", where=where),
        }
    ).sort_values("frame", ignore_index=True)
    if clean.empty:
        raise InputError(f"{where}: no rows; expected frame and speed of at least one frame.")
    twice = clean["frame"].duplicated()
    if twice.any():
        raise InputError(
            f"{where}: frame {clean['frame'][twice].iloc[0]} is there twice; keep one of them."
        )
    return clean
