"""Stride measures summarised over animals, with the share of variance between animals."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from pawnb.gait.groups.animals import mean_of_animals
from pawnb.gait.inference.checks import check_animals, check_values
from pawnb.gait.inference.linear_fit import t_quantile
from pawnb.gait.inference.variance_shares import icc_interval, variance_shares
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

ANIMAL_COLUMNS = (
    "measure", "n", "n_animals", "mean", "ci_low", "ci_high", "sd_animals", "sd_within", "icc",
    "ci_low_strides", "ci_high_strides", "note", "icc_low", "icc_high",
)  # fmt: skip


@checked_arguments
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
        (:func:`pawnb.gait.groups.animals.mean_of_animals`); ``sd_animals`` is that of the animals'
        means, ``sd_within`` that of strides about them; ``icc`` is the share of the variance
        that lies between animals, with its exact interval
        (:func:`pawnb.gait.inference.variance_shares.icc_interval`); ``ci_low_strides`` and
        ``ci_high_strides`` are the interval if strides were independent, for comparison only.

    Raises
    ------
    InputError
        If a column is missing, an animal has no name, or level cannot be used.
    """
    check_columns(table, ["animal", *by, *measures], where="summary of animals")
    check_animals(table, where="summary of animals")
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
    icc_low, icc_high = icc_interval(values, animals, level=level)
    return {
        "n": found.n, "n_animals": found.n_animals, "mean": found.estimate,
        "ci_low": found.low, "ci_high": found.high, "sd_animals": found.sd,
        "sd_within": within, "icc": icc,
        "ci_low_strides": values.mean() - half, "ci_high_strides": values.mean() + half,
        "note": found.note, "icc_low": icc_low, "icc_high": icc_high,
    }  # fmt: skip
