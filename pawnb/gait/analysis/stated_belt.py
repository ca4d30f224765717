"""The speed of a treadmill's belt as it is stated: a number, a table, or a trial's."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.locomotion.grid import Grid
from pawnb.io.belt import read_belt_speed
from pawnb.schema import check_columns, shown
from pawnb.trial import Trial


def belt_on_grid(
    belt_speed: float | pd.DataFrame | None, trial: Trial | None, grid: Grid
) -> FloatArray | None:
    """Return the belt speed at every sample.

    Parameters
    ----------
    belt_speed : float or DataFrame, optional
        Speed in unit/s, or a table frame, speed; default the trial's.
    trial : Trial, optional
        What was filmed.
    grid : Grid
        The samples.

    Returns
    -------
    ndarray, shape (n,)
        Speed in unit/s; None where none is stated.

    Raises
    ------
    InputError
        If it is neither a number nor such a table, or the table has not all frames once.
    """
    where = "belt_speed"
    stated: float | str | pd.DataFrame | None = belt_speed
    if stated is None and trial is not None:
        stated = trial.belt_speed
    if stated is None:
        return None
    if isinstance(stated, str) and trial is not None:
        where = stated
        path = trial.path(stated)
        if not path.is_file():
            raise InputError(f"{path}: no such table of belt speed; mend [treadmill] belt_speed.")
        stated = read_belt_speed(path)
    if isinstance(stated, pd.DataFrame):
        belt = _interpolate(stated, grid, where)
    elif isinstance(stated, int | float | np.number) and not isinstance(stated, bool):
        belt = np.full(len(grid.frame), float(stated))
    else:
        raise InputError(
            f"{where} is {shown(stated)}; expected a number in unit per second, or a table with "
            "the columns frame, speed."
        )
    if not np.isfinite(belt).all():
        raise InputError(f"{where}: a speed is not a finite number; expected unit per second.")
    return belt


def _interpolate(table: pd.DataFrame, grid: Grid, where: str) -> FloatArray:
    """Return the speeds of a table at the samples; frames between its own lie on a line."""
    check_columns(table, ("frame", "speed"), where=where, cells=False)
    try:
        frame, speed = (
            table[name].to_numpy(dtype=float, na_value=np.nan) for name in ("frame", "speed")
        )
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: expected numbers in frame and speed ({error}).") from None
    if not np.isfinite(frame).all():
        raise InputError(f"{where}: a frame is no number; give each row its frame.")
    order = np.argsort(frame, kind="stable")
    frame, speed = frame[order], speed[order]
    twice = frame[1:][np.diff(frame) == 0]
    if len(twice):
        raise InputError(f"{where}: frame {twice[0]:g} is there twice; keep one of them.")
    if len(frame) == 0 or frame[0] > grid.frame[0] or frame[-1] < grid.frame[-1]:
        have = f"{frame[0]:g} to {frame[-1]:g}" if len(frame) else "none"
        raise InputError(
            f"{where}: frames {have}; expected all from {grid.frame[0]:g} to {grid.frame[-1]:g}."
        )
    return np.interp(grid.frame, frame, speed)
