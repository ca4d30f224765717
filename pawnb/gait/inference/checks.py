"""What numbers and levels must be, for every part of the statistics."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.arrays import AnyArray, FloatArray
from pawnb.errors import InputError

NOTHING_VARIES = "no spread between animals beyond rounding: no interval and no p"
EQUAL_SHARE = 1e-9
"""Values that differ by less than this share of their size are equal."""


def as_numbers(values: AnyArray, name: str) -> FloatArray:
    """Return values as a flat array of floats; they may be missing.

    Parameters
    ----------
    values : array_like
        Numbers.
    name : str
        What the message calls them.

    Returns
    -------
    ndarray, shape (n,)
        The same numbers.

    Raises
    ------
    InputError
        If one is no number.
    """
    if np.iscomplexobj(values):
        raise InputError(f"{name}: expected numbers; found complex ones.")
    try:
        if isinstance(values, np.ma.MaskedArray):  # what is masked was not measured
            values = np.ma.filled(values.astype(float), np.nan)
        return np.asarray(values, dtype=float).ravel()
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers ({error}).") from error


def check_values(values: FloatArray) -> FloatArray:
    """Return numbers as a flat array of floats.

    Parameters
    ----------
    values : array_like
        Numbers.

    Returns
    -------
    ndarray, shape (n,)
        The same numbers.

    Raises
    ------
    InputError
        If there is none, or one is not finite.
    """
    values = as_numbers(values, "values")
    bad = int((~np.isfinite(values)).sum())
    if len(values) == 0 or bad:
        found = f"{bad} of {len(values)} are not finite" if bad else "none was given"
        raise InputError(
            f"values: {found}; expected finite numbers: leave out what was not measured."
        )
    return values


def check_animals(table: pd.DataFrame, *, where: str) -> None:
    """Refuse rows of no animal: they would be left out, or count as one more.

    Parameters
    ----------
    table : pandas.DataFrame
        Its column ``animal``.
    where : str
        How the message names it.

    Raises
    ------
    InputError
        If an animal is missing.
    """
    empty = table["animal"].isna().to_numpy()
    if empty.any():
        raise InputError(
            f"{where}: column 'animal' is empty in row {int(empty.argmax()) + 1}; expected a name."
        )


def check_level(level: float) -> None:
    """Refuse a level that no interval can have.

    Parameters
    ----------
    level : float
        What should be a level.

    Raises
    ------
    InputError
        If it is not between 0 and 1.
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"level is {level}; expected between 0 and 1, for instance 0.95.")


def is_rounding(error: float, values: FloatArray) -> bool:
    """Say whether a standard error is that of rounding: nothing varies, and nothing can be tested.

    R's ``t.test`` refuses such data as "essentially constant". Its limit is ten times the spacing
    of numbers, which is too little here: a period is a difference of times, and 0.16 s that begin
    100 s into a film are exact to 1e-14 s only.

    Parameters
    ----------
    error : float
        Standard error of a mean or a difference.
    values : ndarray
        What it came from.

    Returns
    -------
    bool
        True below :data:`EQUAL_SHARE` of the largest of them.
    """
    return error <= EQUAL_SHARE * float(np.abs(values).max())
