"""Columns of the tables that pawnb writes and reads, and what a missing one says.

They are listed here once, so that every writer and reader agrees.
"""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from pawnb.errors import InputError, did_you_mean

START_COLUMNS = ("frame", "view", "point", "u", "v")
TRACKS_COLUMNS = ("frame", "view", "point", "u", "v", "confidence", "origin")
POINTS3D_COLUMNS = ("frame", "point", "x", "y", "z", "residual_px", "origin")
EVENTS_COLUMNS = ("animal", "trial", "leg", "event", "frame", "time_s", "method")
STRIDES_COLUMNS = (
    "animal",
    "trial",
    "leg",
    "stride",
    "start_s",
    "period_s",
    "frequency_hz",
    "stance_s",
    "swing_s",
    "duty_factor",
    "stride_length",
    "speed",
)
PHASES_COLUMNS = ("animal", "trial", "leg", "reference", "stride", "phase")
_PHASE_STATISTICS = (
    "mean",
    "ci_low",
    "ci_high",
    "r",
    "circular_sd",
    "rayleigh_z",
    "rayleigh_p",
    "pattern",
)
PHASE_SUMMARY_COLUMNS = (
    "leg",
    "reference",
    "n",
    "n_animals",
    *_PHASE_STATISTICS,
    *(f"{name}_strides" for name in _PHASE_STATISTICS),
    "moore_r",
    "moore_p",
    "note",
    "r_low",
    "r_high",
    "r_low_strides",
    "r_high_strides",
)
DROPPED_COLUMNS = ("animal", "trial", "leg", "start_s", "end_s", "what", "why")
SUSPECTS_COLUMNS = ("frame", "view", "point", "reason", "score")


def check_columns(table: pd.DataFrame, expected: Sequence[str], *, where: str) -> pd.DataFrame:
    """Return ``table`` if it has every expected column; further columns are welcome.

    Parameters
    ----------
    table : pandas.DataFrame
        A table as it was read.
    expected : sequence of str
        Names of the columns it must have.
    where : str
        File name for the message.

    Returns
    -------
    pandas.DataFrame
        The same table.

    Raises
    ------
    InputError
        If it is no table, or a column is missing (a near name is suggested) or there twice.
    """
    if not isinstance(table, pd.DataFrame):
        raise InputError(
            f"{where}: expected a table (pandas.DataFrame), found {type(table).__name__}."
        )
    missing = [name for name in expected if name not in table.columns]
    if missing:
        found = [str(name) for name in table.columns]
        spare = [name for name in found if name not in expected]
        hint = did_you_mean(missing[0], spare).replace("did you mean", "is it in column")
        raise InputError(
            f"{where}: column {missing[0]!r} is missing{hint}; "
            f"expected {', '.join(expected)}, found {', '.join(found)}."
        )
    columns = list(table.columns)
    twice = next((name for name in expected if columns.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{where}: column {twice!r} is there twice; keep one of them.")
    return table
