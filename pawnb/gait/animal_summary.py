"""Stride measures summarised over animals, with the share of variance between animals."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.gait.animals import check_values, mean_of_animals
from pawnb.gait.circular_sample import animal_codes
from pawnb.gait.lines import t_quantile
from pawnb.schema import check_columns

ANIMAL_COLUMNS = (
    "measure", "n", "n_animals", "mean", "ci_low", "ci_high", "sd_animals", "sd_within", "icc",
    "ci_low_strides", "ci_high_strides", "note",
)  # fmt: skip


def summarise_animals(
    table: pd.DataFrame,
    measures: Sequence[str],
    *,
    by: Sequence[str] = ("leg",),
    level: float = 0.95,
) -> pd.DataFrame:
    """Summarise stride measures over animals, with what strides would say beside it.

    Parameters
    ----------
    table : pandas.DataFrame
        Strides: ``animal``, the columns of ``by``, and the measures. Missing values are left
        out; n says how many remain.
    measures : sequence of str
        Columns to summarise, not phases.
    by : sequence of str
        Columns that divide the table; may be empty.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``by`` and ``ANIMAL_COLUMNS``: mean and interval count animals
        (:func:`pawnb.gait.animals.mean_of_animals`); ``sd_animals`` is that of the animals'
        means, ``sd_within`` that of strides about them; ``icc`` is the share of the variance
        that lies between animals; ``ci_low_strides`` and ``ci_high_strides`` are the interval
        if strides were independent, for comparison only.

    Raises
    ------
    InputError
        If a column is missing or level cannot be used.
    """
    check_columns(table, ["animal", *by, *measures], where="summary of animals")
    groups = table.groupby(list(by), sort=False) if by else [((), table)]
    rows = []
    for key, own in groups:
        for measure in measures:
            known = own[["animal", measure]].dropna()
            row = dict(zip(by, key, strict=True)) | {"measure": measure}
            if known.empty:
                rows.append(row | {"n": 0, "n_animals": 0, "note": "no values"})
                continue
            rows.append(row | _describe_measure(known, measure, level))
    return pd.DataFrame(rows, columns=[*by, *ANIMAL_COLUMNS])


def _describe_measure(known: pd.DataFrame, measure: str, level: float) -> dict[str, object]:
    """Describe one measure; see :func:`summarise_animals`."""
    values = check_values(known[measure].to_numpy())
    animals = known["animal"].tolist()
    found = mean_of_animals(values, animals, level=level)
    half = math.nan
    if len(values) > 1:
        half = t_quantile(level, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    within, icc = variance_shares(values, animals)
    return {
        "n": found.n, "n_animals": found.n_animals, "mean": found.estimate,
        "ci_low": found.low, "ci_high": found.high, "sd_animals": found.sd,
        "sd_within": within, "icc": icc,
        "ci_low_strides": values.mean() - half, "ci_high_strides": values.mean() + half,
        "note": found.note,
    }  # fmt: skip


def variance_shares(values: np.ndarray, animals: Sequence[object]) -> tuple[float, float]:
    """Divide the variance of strides into that within and that between animals.

    One-way analysis of variance with unequal numbers (Donner 1986): the intraclass
    correlation is ``(MSB - MSW) / (MSB + (n0 - 1) MSW)``, here at least 0.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One value a stride.
    animals : sequence, shape (n,)
        Animal of each.

    Returns
    -------
    sd_within : float
        Standard deviation of strides about their animal's mean; NaN where every animal has
        one stride.
    icc : float
        Share of the variance that lies between animals; NaN with one animal, with one stride
        an animal, or where nothing varies.

    Raises
    ------
    InputError
        If values or animals cannot be used.
    """
    values = check_values(values)
    codes, k = animal_codes(animals, len(values))
    each = np.bincount(codes, minlength=k)
    means = np.bincount(codes, values, k) / each
    n = len(values)
    if n == k:
        return math.nan, math.nan
    within = float(((values - means[codes]) ** 2).sum()) / (n - k)
    if k < 2:
        return math.sqrt(within), math.nan
    between = float((each * (means - values.mean()) ** 2).sum()) / (k - 1)
    typical = (n - float((each**2).sum()) / n) / (k - 1)
    whole = between + (typical - 1.0) * within
    least = 1e-24 * float(values @ values) / n  # below it is rounding
    icc = max(0.0, (between - within) / whole) if whole > least else math.nan
    return math.sqrt(within), icc
