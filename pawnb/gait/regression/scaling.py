"""Gait against size and speed: the tables 4.3, 4.4 and 4.5 of Pullar (2009) on any data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.inference.linear_fit import AnimalSlopes, Line
from pawnb.gait.regression.lines import (
    compare_slope,
    differ,
    fit_line,
    fit_power,
    fit_rma,
    slope_over_animals,
)
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

STATISTICS = ("mean", "min", "max")
SCALING_COLUMNS = (
    "statistic", "parameter", "size", "method", "a", "b", "ci_low", "ci_high", "r2", "p",
    "significant", "n_animals", "b_se", "df",
)  # fmt: skip
EXPECTED_COLUMNS = (
    "parameter", "size", "expected", "source", "observed", "ci_low", "ci_high",
    "observed_significant", "t", "df", "p", "differs", "n_animals",
)  # fmt: skip
SPEED_COLUMNS = (
    "outcome", "predictor", "a", "b", "ci_low", "ci_high", "r2", "p_if_independent",
    "b_animals", "ci_low_animals", "ci_high_animals", "p", "significant", "n_points",
    "n_animals", "n_slopes",
)  # fmt: skip


class ExpectedExponent(NamedTuple):
    """An exponent that others found or derived.

    Attributes
    ----------
    parameter, size : str
        Columns that the power law joins: ``parameter = a size^exponent``.
    exponent : float
        The exponent.
    source : str
        Where it comes from.
    """

    parameter: str
    size: str
    exponent: float
    source: str


EXPECTED_EXPONENTS = (
    ExpectedExponent("speed", "mass", 0.0, "Hill 1950"),
    ExpectedExponent("speed", "mass", 0.24, "Heglund et al. 1974"),
    ExpectedExponent("speed", "mass", 0.17, "Garland 1983"),
    ExpectedExponent("relative_speed", "mass", -0.33, "Hill 1950"),
    ExpectedExponent("relative_speed", "mass", -0.09, "Calder 1984"),
    ExpectedExponent("relative_speed", "mass", -0.17, "Iriarte-Díaz 2002"),
    ExpectedExponent("frequency_hz", "mass", -0.33, "Hill 1950"),
    ExpectedExponent("frequency_hz", "mass", -0.14, "Heglund et al. 1974"),
    ExpectedExponent("frequency_hz", "mass", -0.17, "Alexander 1982"),
    ExpectedExponent("stride_length", "mass", 0.38, "Heglund et al. 1974"),
    ExpectedExponent("stride_length", "mass", 0.33, "Hill 1950"),
)
"""The expectations of Pullar (2009), Table 4.4, for maximal speeds.

Two rows stand one relationship too low in that table: Garland's exponent, printed as of
normalised speed, is of absolute speed, and Alexander's is of stride frequency.
"""


@checked_arguments
def per_animal(
    table: pd.DataFrame,
    columns: Sequence[str],
    *,
    statistics: Sequence[str] = STATISTICS,
    animal: str = "animal",
    trial: str = "trial",
) -> pd.DataFrame:
    """Make one point of each animal, so that its strides do not count as animals.

    Strides are averaged within trials first (where the table names trials); mean, minimum
    and maximum are then those over the animal's trials (paper 2009, §3.7).

    Parameters
    ----------
    table : pandas.DataFrame
        Strides or trials, a row each.
    columns : sequence of str
        What to take; NaN is left out.
    statistics : sequence of {"mean", "min", "max", "median"}
        Which statistics.
    animal, trial : str
        Columns that name animal and trial.

    Returns
    -------
    pandas.DataFrame
        ``animal, statistic, n`` (trials, or rows where trials are not named) and the columns:
        one row for an animal and statistic.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or a statistic is not known.
    """
    check_columns(table, [animal, *columns], where="measures")
    odd = [name for name in statistics if name not in (*STATISTICS, "median")]
    if odd or len(table) == 0:
        raise InputError(
            f"measures: statistic {odd[0]!r}; expected mean, min, max or median."
            if odd
            else "measures: no row; expected at least one stride or trial."
        )
    names = list(columns)
    points = table
    if trial in table:
        points = table.groupby([animal, trial], sort=True)[names].mean().reset_index()
    groups = points.groupby(animal, sort=True)
    parts = []
    for statistic in statistics:
        part = groups[names].agg(statistic).reset_index()
        part = part.rename(columns={animal: "animal"})
        part.insert(1, "statistic", statistic)
        part.insert(2, "n", groups.size().to_numpy())
        parts.append(part)
    return pd.concat(parts, ignore_index=True)


@checked_arguments
def scaling_table(
    table: pd.DataFrame,
    parameters: Sequence[str],
    sizes: Sequence[str],
    *,
    statistics: Sequence[str] = STATISTICS,
    method: str = "OLS",
    level: float = 0.95,
) -> pd.DataFrame:
    """Fit power laws of gait parameters on size, one point an animal (paper 2009, Table 4.3).

    Parameters
    ----------
    table : pandas.DataFrame
        Strides or trials: animal, trial (optional), and the columns named below.
    parameters : sequence of str
        Columns to explain, for instance speed, frequency_hz, stride_length.
    sizes : sequence of str
        Columns of size, for instance mass_g, body_length; the mean over an animal's rows.
    statistics : sequence of str
        Which statistic of an animal's trials; see :func:`per_animal`.
    method : {"OLS", "RMA"}
        Least squares on logarithms with Sprugel's correction, or reduced major axis.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``SCALING_COLUMNS``: ``parameter = a size^b`` with the interval of b. ``significant``
        follows the interval: it is true where the interval excludes 0. (In the paper's
        table two stars do not.)

    Raises
    ------
    InputError
        If a column is missing, the method is not known, or a fit is not possible.
    """
    rows = []
    for parameter, size, statistic, line in _size_lines(
        table, parameters, sizes, statistics=statistics, method=method, level=level
    ):
        rows.append(
            (statistic, parameter, size, method, line.a, line.b, line.b_low, line.b_high,
             line.r2, line.p, line.significant, line.n_animals, line.b_se, line.df)
        )  # fmt: skip
    return pd.DataFrame(rows, columns=list(SCALING_COLUMNS))


@checked_arguments
def expected_slopes_table(
    table: pd.DataFrame,
    expected: Sequence[ExpectedExponent | tuple[str, str, float, str]] = EXPECTED_EXPONENTS,
    *,
    statistic: str = "max",
    level: float = 0.95,
) -> pd.DataFrame:
    """Compare exponents with expected ones by two-tailed t tests (paper 2009, Table 4.4).

    Parameters
    ----------
    table : pandas.DataFrame
        Strides or trials, as for :func:`scaling_table`.
    expected : sequence of ExpectedExponent
        Parameter, size, exponent and source; default :data:`EXPECTED_EXPONENTS`, whose
        columns are called speed, relative_speed, frequency_hz, stride_length and mass.
    statistic : str
        Which statistic of an animal's trials.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``EXPECTED_COLUMNS``, a row for each expectation. That an exponent does not differ
        from an expected one is weak support where its interval is wide.

    Raises
    ------
    InputError
        If a column is missing or a fit is not possible.
    """
    wanted = [ExpectedExponent(*row) for row in expected]
    lines = {
        pair: next(
            iter(_size_lines(table, [pair[0]], [pair[1]], statistics=[statistic], level=level))
        )[3]
        for pair in dict.fromkeys((row.parameter, row.size) for row in wanted)
    }
    rows = []
    for row in wanted:
        line = lines[row.parameter, row.size]
        test = compare_slope(line, row.exponent)
        rows.append(
            (row.parameter, row.size, row.exponent, row.source, line.b, line.b_low, line.b_high,
             line.significant, test.t, test.df, test.p, test.differs, line.n_animals)
        )  # fmt: skip
    return pd.DataFrame(rows, columns=list(EXPECTED_COLUMNS))


@checked_arguments
def speed_table(
    table: pd.DataFrame,
    outcomes: Sequence[str],
    predictors: Sequence[str] = ("speed",),
    *,
    level: float = 0.95,
) -> pd.DataFrame:
    """Fit gait measures on speed, one point a trial (paper 2009, Table 4.5).

    The paper's line runs through all trials as if they were independent; its p is named for
    that. Trials of one animal are alike, and animals that are fast are often large: beside it
    stands the mean slope of the animals (:func:`pawnb.gait.regression.slope_over_animals`),
    each counted once, whose interval decides ``significant``.

    Parameters
    ----------
    table : pandas.DataFrame
        Strides or trials: animal, trial (optional: strides are averaged within trials), and
        the columns named below.
    outcomes : sequence of str
        Columns to explain, for instance frequency_hz, stride_length, swing_s, duty_factor.
    predictors : sequence of str
        Columns of speed, or frequency.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``SPEED_COLUMNS``: ``outcome = a + b predictor``; ``b_animals`` with interval and ``p``
        over the ``n_slopes`` animals that have trials of different speed. With one trial an
        animal points are animals: those columns are NaN but for ``p``, which is that of b, and
        ``significant`` follows the interval of b. Where some but fewer than two animals have
        several trials, nothing can be said of animals: ``p`` is NaN and ``significant`` False.

    Raises
    ------
    InputError
        If a column is missing or a fit is not possible.
    """
    names = list(dict.fromkeys([*outcomes, *predictors]))
    check_columns(table, ["animal", *names], where="measures")
    points = table
    if "trial" in table:
        points = table.groupby(["animal", "trial"], sort=True)[names].mean().reset_index()
    rows = []
    for outcome in outcomes:
        for predictor in predictors:
            if predictor == outcome:
                continue
            known = points.dropna(subset=[outcome, predictor])
            x, y = known[predictor].to_numpy(float), known[outcome].to_numpy(float)
            animals = known["animal"].astype(str).tolist()
            line = fit_line(x, y, animals=animals, level=level)
            nan = math.nan
            over: tuple[float | None, ...]
            if line.n == line.n_animals:
                over = (nan, nan, nan, line.p, line.significant, line.n, line.n_animals, 0)
            elif (own := animal_slopes(known, predictor, outcome, level=level)) is None:
                over = (nan, nan, nan, nan, False, line.n, line.n_animals, 0)
            else:
                over = (own.b, own.b_low, own.b_high, own.p, own.significant, line.n,
                        line.n_animals, own.n_animals)  # fmt: skip
            rows.append(
                (outcome, predictor, line.a, line.b, line.b_low, line.b_high, line.r2, line.p,
                 *over)
            )  # fmt: skip
    return pd.DataFrame(rows, columns=list(SPEED_COLUMNS))


@checked_arguments
def animal_slopes(
    points: pd.DataFrame,
    predictor: str,
    outcome: str,
    *,
    kind: Literal["linear", "power"] = "linear",
    level: float = 0.95,
) -> AnimalSlopes | None:
    """Return the animals' slopes, or None where fewer than two animals have one.

    Parameters
    ----------
    points : pandas.DataFrame
        ``animal`` and the two columns, a row a point, none missing.
    predictor, outcome : str
        Columns of x and y.
    kind : {"linear", "power"}
        Whether to fit the values or their logarithms.
    level : float
        Level of the interval.

    Returns
    -------
    AnimalSlopes or None
        See :func:`pawnb.gait.regression.slope_over_animals`.
    """
    each = points.groupby("animal")[predictor]
    if sum(differ(own.to_numpy(float)) for _, own in each) < 2:
        return None
    return slope_over_animals(
        points[predictor].to_numpy(float),
        points[outcome].to_numpy(float),
        animals=points["animal"].astype(str).tolist(),
        kind=kind,
        level=level,
    )


def _size_lines(
    table: pd.DataFrame,
    parameters: Sequence[str],
    sizes: Sequence[str],
    *,
    statistics: Sequence[str],
    method: str = "OLS",
    level: float,
) -> list[tuple[str, str, str, Line]]:
    """Fit every parameter on every size: parameter, size, statistic and line."""
    if method not in ("OLS", "RMA"):
        raise InputError(f"method is {method!r}; expected 'OLS' or 'RMA'.")
    measures = per_animal(table, list(parameters), statistics=statistics)
    size = per_animal(table, list(sizes), statistics=["mean"]).set_index("animal")
    lines = []
    for parameter in parameters:
        for statistic in statistics:
            own = measures[measures["statistic"] == statistic]
            animals = own["animal"].tolist()
            for name in sizes:
                x = size.loc[animals, name].to_numpy(float)
                y = own[parameter].to_numpy(float)
                line = (
                    fit_power(x, y, animals=animals, level=level)
                    if method == "OLS"
                    else fit_rma(x, y, kind="power", animals=animals, level=level)
                )
                lines.append((parameter, name, statistic, line))
    return lines
