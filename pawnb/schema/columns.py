"""Columns of the tables that pawnb writes and reads, and what a missing one says.

They are listed here once, so that every writer and reader agrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real

import numpy as np
import pandas as pd
from pandas.api.types import is_float_dtype, is_numeric_dtype

from pawnb.errors import InputError, did_you_mean
from pawnb.schema.settings import shown

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


_NUMBER_ENDS = ("_s", "_hz", "_px", "_deg", "_percent", "_fraction", "_factor", "_length", "_bl")
_NUMBER_NAMES = frozenset(
    (
        "acceleration",
        "bias",
        "difference",
        "frame",
        "heading",
        "high",
        "low",
        "mean",
        "n",
        "n_animals",
        "n_strides",
        "percent",
        "sd",
        "speed",
        "step_displacement",
        "u",
        "v",
        "velocity",
        "x",
        "y",
        "z",
    )
)
"""Columns that hold numbers in every table that has them, by their ends and by their names."""


def check_columns(
    table: pd.DataFrame,
    expected: Sequence[str],
    *,
    where: str,
    numbers: Sequence[str] = (),
    cells: bool = True,
) -> pd.DataFrame:
    """Return ``table`` if it has every expected column; further columns are welcome.

    Parameters
    ----------
    table : pandas.DataFrame
        A table as it was read.
    expected : sequence of str
        Names of the columns it must have.
    where : str
        File name for the message.
    numbers : sequence of str
        Those of them that must hold numbers here, beside the columns that do in every table.
    cells : bool
        Whether cells are looked at. A reader, whose cells are text still, says itself in which
        line of a file a wrong one is.

    Returns
    -------
    pandas.DataFrame
        The same table.

    Raises
    ------
    InputError
        If it is no table, a column is missing (a near name is suggested) or there twice, text
        stands where numbers should, a number is infinite, or a leg has no name.
    """
    if not isinstance(table, pd.DataFrame):
        raise InputError(
            f"{where}: expected a table (pandas.DataFrame), found {type(table).__name__}."
        )
    missing = [name for name in expected if name not in table.columns]
    if missing:
        found = [str(name) for name in table.columns]
        spare = [name for name in found if name not in expected]
        hint = did_you_mean(str(missing[0]), spare).replace("did you mean", "is it in column")
        raise InputError(
            f"{where}: column {missing[0]!r} is missing{hint}; "
            f"expected {', '.join(map(str, expected))}, found {', '.join(found)}."
        )
    columns = list(table.columns)
    twice = next((name for name in expected if columns.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{where}: column {twice!r} is there twice; keep one of them.")
    for name in expected if cells else ():
        _check_cells(table[name], f"{where}: column {name!r}", is_number=name in numbers)
    return table


def check_finite(table: pd.DataFrame, *, where: str) -> None:
    """Refuse infinite numbers in the columns that hold numbers in every table that has them.

    They come of a division by 0, and means and intervals of them look like results.

    Parameters
    ----------
    table : pandas.DataFrame
        Any table; columns of other names are not looked at.
    where : str
        How the message names it.

    Raises
    ------
    InputError
        For the first infinite number.
    """
    for name, column in table.items():
        if _holds_numbers(name):
            _refuse_infinite(column, f"{where}: column {name!r}")


def _holds_numbers(name: object) -> bool:
    """Tell whether a column of this name holds numbers in every table."""
    return isinstance(name, str) and (name in _NUMBER_NAMES or name.endswith(_NUMBER_ENDS))


def _check_cells(column: pd.Series, what: str, *, is_number: bool) -> None:
    """Refuse text among numbers, infinite numbers, and legs without a name."""
    if column.name == "leg" and column.isna().any():
        row = int(column.isna().to_numpy().argmax()) + 1
        raise InputError(f"{what} is empty in row {row}; expected the name of a leg.")
    if (is_number or _holds_numbers(column.name)) and not is_numeric_dtype(column):
        other = next((v for v in column.dropna() if not isinstance(v, Real)), None)
        if other is not None:
            raise InputError(
                f"{what} holds {shown(other)}; expected numbers: turn text into them with "
                "pandas.to_numeric."
            )
    _refuse_infinite(column, what)


def _refuse_infinite(column: pd.Series, what: str) -> None:
    """Refuse infinite numbers: they are no measurements, and no missing ones either."""
    if is_float_dtype(column):
        infinite = np.isinf(column.to_numpy(dtype=float, na_value=np.nan))
        if infinite.any():
            raise InputError(
                f"{what} is infinite in row {int(infinite.argmax()) + 1}; expected finite numbers, "
                "and none where nothing was measured."
            )
