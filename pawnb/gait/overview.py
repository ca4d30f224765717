"""All measures of a study at once, standardised over animals, and their principal components."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.groups.comparison import mean_by_animal
from pawnb.gait.groups.shared_names import keep_shared
from pawnb.gait.inference.checks import check_animals
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

_FEWEST_SHOWN = 3


class Standardised(NamedTuple):
    """Measures of animals in standard deviations from their mean.

    Attributes
    ----------
    z : pandas.DataFrame
        A row an animal, a column a measure: mean 0 and standard deviation 1 over animals.
    mean, sd : pandas.Series
        What was taken off, and by what was divided.
    left_out : dict
        Measures that are not there, and why.
    """

    z: pd.DataFrame
    mean: pd.Series
    sd: pd.Series
    left_out: dict[str, str]


class Components(NamedTuple):
    """Principal components of standardised measures.

    Attributes
    ----------
    scores : pandas.DataFrame
        A row an animal, a column a component (``PC1``, ...).
    loadings : pandas.DataFrame
        A row a measure, a column a component: directions of length 1.
    explained : pandas.Series
        Share of the variance, by component.
    note : str
        What the reader must know, else empty.
    """

    scores: pd.DataFrame
    loadings: pd.DataFrame
    explained: pd.Series
    note: str


@checked_arguments
def measures_by_animal(strides: pd.DataFrame, measures: Sequence[str]) -> pd.DataFrame:
    """Make one row of each animal: the mean of its legs' means, so that every leg counts alike.

    Legs that an animal lacks are left out in all, as legs differ from each other.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides: animal, leg and the measures.
    measures : sequence of str
        Columns.

    Returns
    -------
    pandas.DataFrame
        Animals in alphabetical order, a column a measure; NaN where an animal has none.

    Raises
    ------
    InputError
        If a column is missing, an animal has no name, or there is no stride.
    """
    check_columns(strides, ["animal", "leg", *measures], where="strides")
    check_animals(strides, where="strides")
    if not len(strides):
        raise InputError("overview of measures: there is no stride.")
    columns = {}
    for name in measures:
        known, _ = keep_shared(strides[["animal", "leg", name]].dropna(), "leg")
        columns[name] = mean_by_animal(known, name, average_over="leg")
    found = pd.DataFrame(columns, index=pd.Index(sorted(strides["animal"].unique())))
    return found.rename_axis("animal")


@checked_arguments
def standardise(table: pd.DataFrame) -> Standardised:
    """Express measures in standard deviations from their mean over animals.

    Parameters
    ----------
    table : pandas.DataFrame
        A row an animal, a column a measure.

    Returns
    -------
    Standardised
        Without the measures that an animal lacks or that are the same in all.

    Raises
    ------
    InputError
        If there are fewer than three animals, or fewer than two measures are left.
    """
    if len(table) < _FEWEST_SHOWN:
        raise InputError(
            f"overview of measures: {len(table)} animals; expected {_FEWEST_SHOWN} or more, as two "
            "are always one standard deviation apart in everything."
        )
    left_out = {}
    for name in table:
        own = table[name].to_numpy(dtype=float)
        if not np.isfinite(own).all():
            left_out[str(name)] = f"not known of {table.index[~np.isfinite(own)][0]}"
        elif np.ptp(own) <= 1e-9 * np.abs(own).max():
            left_out[str(name)] = "the same in all animals"
    kept = table[[name for name in table if str(name) not in left_out]].astype(float)
    if kept.shape[1] < 2:
        raise InputError(
            f"overview of measures: {kept.shape[1]} measures that all animals have and that "
            "differ; expected two or more."
        )
    mean, sd = kept.mean(), kept.std(ddof=1)
    return Standardised((kept - mean) / sd, mean, sd, left_out)


@checked_arguments
def principal_components(z: pd.DataFrame) -> Components:
    """Find the directions in which animals differ most, by a singular value decomposition.

    Parameters
    ----------
    z : pandas.DataFrame
        Standardised measures (:func:`standardise`), a row an animal.

    Returns
    -------
    Components
        As many as there can be: one less than animals, at most one a measure. The sign of each is
        such that the largest loading is positive.

    Examples
    --------
    >>> measures = ["frequency_hz", "duty_factor", "stride_length"]
    >>> table = pawnb.gait.overview.measures_by_animal(gait.strides, measures)
    >>> found = pawnb.gait.overview.principal_components(
    ...     pawnb.gait.overview.standardise(table).z
    ... )
    """
    values = z.to_numpy(dtype=float)
    left, size, right = np.linalg.svd(values - values.mean(axis=0), full_matrices=False)
    count = min(len(z) - 1, z.shape[1])
    left, size, right = left[:, :count], size[:count], right[:count]
    sign = np.sign(right[np.arange(count), np.abs(right).argmax(axis=1)])
    names = [f"PC{k + 1}" for k in range(count)]
    variance = size**2
    note = ""
    if len(z) <= z.shape[1]:
        note = (
            f"{len(z)} animals and {z.shape[1]} measures: {count} components always hold all of "
            "the variance; they describe these animals and say little of others"
        )
    return Components(
        scores=pd.DataFrame(left * size * sign, index=z.index, columns=names),
        loadings=pd.DataFrame((right * sign[:, None]).T, index=z.columns, columns=names),
        explained=pd.Series(variance / (values - values.mean(axis=0)).var(axis=0).sum() / len(z),
                            index=names),
        note=note,
    )  # fmt: skip
