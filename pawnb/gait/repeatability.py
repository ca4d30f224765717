"""How well two people, or two runs, agree: Bland-Altman limits and intraclass correlation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import f as fisher
from scipy.stats import t as student

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.inference.linear_fit import t_quantile
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

REPEATABLE = (
    "period_s", "stance_s", "swing_s", "duty_factor", "stride_length", "speed",
    "step_displacement",
)  # fmt: skip
REPEATABILITY_COLUMNS = (
    "measure", "n", "n_animals", "bias", "bias_low", "bias_high", "sd", "limit_low",
    "limit_low_low", "limit_low_high", "limit_high", "limit_high_low", "limit_high_high",
    "within_sd", "icc", "icc_low", "icc_high", "trend_p",
)  # fmt: skip
_KEY = ("animal", "trial", "leg")


class Agreement(NamedTuple):
    """Bland-Altman agreement of two sets of measurements.

    Attributes
    ----------
    n : int
        Pairs.
    bias, bias_low, bias_high : float
        Mean of the differences (second minus first) with its interval.
    sd : float
        Standard deviation of the differences.
    limit_low, limit_high : float
        Limits of agreement: 95 % of differences are expected between them.
    limit_error : float
        Half the width of the interval of each limit.
    within_sd : float
        Standard deviation of one measurement, bias included: the root of half the mean
        squared difference.
    trend_p : float
        p of the correlation between difference and mean: small where they differ more for
        large values, so that one pair of limits does not fit all.
    """

    n: int
    bias: float
    bias_low: float
    bias_high: float
    sd: float
    limit_low: float
    limit_high: float
    limit_error: float
    within_sd: float
    trend_p: float


class IntraclassCorrelation(NamedTuple):
    """Intraclass correlation with its interval.

    Attributes
    ----------
    icc, low, high : float
        Coefficient and interval.
    n, k : int
        Targets, and measurements of each.
    """

    icc: float
    low: float
    high: float
    n: int
    k: int


@checked_arguments
def bland_altman(
    first: FloatArray, second: FloatArray, *, level: float = 0.95, factor: float = 1.96
) -> Agreement:
    """Compute bias and limits of agreement (Bland & Altman 1986, 1999).

    Limits are ``bias ± factor sd``; the standard error of each limit is
    ``sd sqrt(1 / n + factor² / (2 (n - 1)))`` (1999, §2.2; the paper of 1986 uses a factor of 2
    and ``sqrt(3 / n)``).

    Parameters
    ----------
    first, second : ndarray, shape (n,)
        The same things measured twice.
    level : float
        Level of the intervals.
    factor : float
        Standard deviations between bias and limit.

    Returns
    -------
    Agreement
        Bias, limits and their intervals.

    Raises
    ------
    InputError
        If there are fewer than three pairs, a value is not finite, or level or factor cannot
        be.
    """
    first, second = (np.asarray(v, dtype=float) for v in (first, second))
    if first.shape != second.shape or first.ndim != 1 or len(first) < 3:
        raise InputError(
            f"agreement: shapes {first.shape} and {second.shape}; expected at least three pairs."
        )
    difference = second - first
    if not np.isfinite(difference).all():
        raise InputError("agreement: a value is not finite; leave out what was not measured.")
    if not 0.0 < level < 1.0 or not factor > 0.0:
        raise InputError(
            f"level is {level}, factor {factor}; expected a level between 0 and 1 and a factor "
            "above 0."
        )
    n = len(difference)
    quantile = t_quantile(level, n - 1)
    bias, sd = float(difference.mean()), float(difference.std(ddof=1))
    reach = quantile * sd / math.sqrt(n)
    error = quantile * sd * math.sqrt(1.0 / n + factor**2 / (2.0 * (n - 1)))
    return Agreement(
        n, bias, bias - reach, bias + reach, sd, bias - factor * sd, bias + factor * sd, error,
        math.sqrt(float(np.mean(difference**2)) / 2.0), _trend_p(first + second, difference),
    )  # fmt: skip


def _trend_p(total: FloatArray, difference: FloatArray) -> float:
    """Return p of the correlation of two samples; 1 where either does not vary."""
    if np.ptp(total) == 0.0 or np.ptp(difference) == 0.0:
        return 1.0
    r = float(np.corrcoef(total, difference)[0, 1])
    df = len(total) - 2
    t = abs(r) * math.sqrt(df / max(1.0 - r**2, 1e-300))
    return float(2.0 * student.sf(t, df))


@checked_arguments
def intraclass_correlation(
    values: FloatArray,
    *,
    form: Literal["ICC1", "ICC2", "ICC3"] = "ICC2",
    level: float = 0.95,
) -> IntraclassCorrelation:
    """Compute the intraclass correlation of single measurements (Shrout & Fleiss 1979).

    The share of the variance that lies between targets. ``ICC1``: each target measured by
    other people; ``ICC2``: all by the same people, who stand for any (absolute agreement: a
    bias counts against it); ``ICC3``: these people only (consistency: a bias does not count).

    Parameters
    ----------
    values : ndarray, shape (n, k)
        n targets, k measurements of each; none missing.
    form : {"ICC1", "ICC2", "ICC3"}
        Which.
    level : float
        Level of the interval (Shrout & Fleiss, Eq. 6-13; McGraw & Wong 1996).

    Returns
    -------
    IntraclassCorrelation
        Coefficient and interval. Estimates below 0 are possible where targets hardly differ.

    Raises
    ------
    InputError
        If there are fewer than two targets or measurements, a value is not finite, nothing
        varies, or form or level cannot be.
    """
    values = np.asarray(values, dtype=float)
    if values.ndim != 2 or min(values.shape) < 2 or not np.isfinite(values).all():
        raise InputError(
            f"intraclass correlation: values of shape {values.shape}; expected at least two "
            "targets with two finite measurements each."
        )
    if form not in ("ICC1", "ICC2", "ICC3") or not 0.0 < level < 1.0:
        raise InputError(
            f"form is {form!r}, level {level}; expected ICC1, ICC2 or ICC3 and a level between "
            "0 and 1."
        )
    if np.ptp(values) == 0.0:
        raise InputError("intraclass correlation: all values are equal; nothing varies.")
    n, k = values.shape
    rows, columns, rest, within = _mean_squares(values)
    tail = (1.0 - level) / 2.0
    if form == "ICC2":
        icc = (rows - rest) / (rows + (k - 1) * rest + k * (columns - rest) / n)
        low, high = _icc2_interval(rows, columns, rest, (n, k), icc, tail)
        return IntraclassCorrelation(icc, low, high, n, k)
    error, df = (within, n * (k - 1)) if form == "ICC1" else (rest, (n - 1) * (k - 1))
    icc = (rows - error) / (rows + (k - 1) * error)
    if error == 0.0:
        return IntraclassCorrelation(icc, 1.0, 1.0, n, k)
    ratio = rows / error
    least = ratio / float(fisher.isf(tail, n - 1, df))
    most = ratio * float(fisher.isf(tail, df, n - 1))
    return IntraclassCorrelation(
        icc, (least - 1.0) / (least + k - 1.0), (most - 1.0) / (most + k - 1.0), n, k
    )


def _mean_squares(values: FloatArray) -> tuple[float, float, float, float]:
    """Return the mean squares of targets, of measurers, of the rest, and within targets."""
    n, k = values.shape
    of_rows, of_columns, mean = values.mean(axis=1), values.mean(axis=0), values.mean()
    rows = k * float(np.sum((of_rows - mean) ** 2)) / (n - 1)
    columns = n * float(np.sum((of_columns - mean) ** 2)) / (k - 1)
    left = values - of_rows[:, None] - of_columns[None, :] + mean
    rest = float(np.sum(left**2)) / ((n - 1) * (k - 1))
    within = float(np.sum((values - of_rows[:, None]) ** 2)) / (n * (k - 1))
    return rows, columns, rest, within


def _icc2_interval(
    rows: float, columns: float, rest: float, size: tuple[int, int], icc: float, tail: float
) -> tuple[float, float]:
    """Return the interval of ICC2, with Satterthwaite's degrees of freedom."""
    n, k = size
    if rest == 0.0 and columns == 0.0:
        return 1.0, 1.0
    ratio = columns / rest if rest else math.inf
    if math.isinf(ratio):  # measurers differ by a constant: only their number matters
        df = float(k - 1)
    else:
        bend = n * (1.0 + (k - 1) * icc) - k * icc
        df = (
            (k - 1) * (n - 1) * (k * icc * ratio + bend) ** 2
            / ((n - 1) * k**2 * icc**2 * ratio**2 + bend**2)
        )  # fmt: skip
    low_f, high_f = float(fisher.isf(tail, n - 1, df)), float(fisher.isf(tail, df, n - 1))
    spread = k * columns + (k * n - k - n) * rest
    low = n * (rows - low_f * rest) / (low_f * spread + n * rows)
    high = n * (high_f * rows - rest) / (spread + n * high_f * rows)
    return low, high


@checked_arguments
def match_strides(
    first: pd.DataFrame, second: pd.DataFrame, *, tolerance: float = 0.25
) -> pd.DataFrame:
    """Find the strides that two tables share: same animal, trial and leg, nearest in time.

    Parameters
    ----------
    first, second : pandas.DataFrame
        Strides of two people, or of two runs.
    tolerance : float
        Largest difference of their starts, as a share of the first one's period.

    Returns
    -------
    pandas.DataFrame
        Columns of both, ``..._1`` and ``..._2``, beside animal, trial and leg. A stride is
        used once: the nearest pairs come first.

    Raises
    ------
    InputError
        If a column is missing or no stride is shared.
    """
    for table in (first, second):
        check_columns(table, [*_KEY, "start_s", "period_s"], where="strides")
    parts = []
    others = dict(list(second.groupby(list(_KEY), sort=True)))
    for key, own in first.groupby(list(_KEY), sort=True):
        if key not in others:
            continue
        a, b = own.reset_index(drop=True), others[key].reset_index(drop=True)
        away = np.abs(a["start_s"].to_numpy()[:, None] - b["start_s"].to_numpy()[None, :])
        allowed = tolerance * a["period_s"].to_numpy()[:, None]
        pairs = _nearest_first(away, allowed)
        left, right = (t.iloc[[p[k] for p in pairs]] for k, t in enumerate((a, b)))
        shown = [t.drop(columns=list(_KEY)).reset_index(drop=True) for t in (left, right)]
        parts.append(
            pd.concat(
                [
                    left[list(_KEY)].reset_index(drop=True),
                    shown[0].add_suffix("_1"),
                    shown[1].add_suffix("_2"),
                ],
                axis=1,
            )
        )
    matched = [part for part in parts if len(part)]
    if not matched:
        raise InputError(
            "repeatability: the two tables share no stride; expected the same animals, trials "
            f"and legs, with starts within {tolerance:g} of a period."
        )
    return pd.concat(matched, ignore_index=True)


def _nearest_first(away: FloatArray, allowed: FloatArray) -> list[tuple[int, int]]:
    """Pair rows with columns, nearest first, each once."""
    i, j = np.nonzero(away <= allowed)
    order = np.argsort(away[i, j], kind="stable")
    pairs: dict[int, int] = {}
    for row, column in zip(i[order].tolist(), j[order].tolist(), strict=True):
        if row not in pairs and column not in pairs.values():
            pairs[row] = column
    return sorted(pairs.items())


@checked_arguments
def repeatability_table(
    first: pd.DataFrame,
    second: pd.DataFrame,
    *,
    measures: Sequence[str] | None = None,
    tolerance: float = 0.25,
    level: float = 0.95,
) -> pd.DataFrame:
    """Compare every stride measure of two people, or of two runs, stride by stride.

    Parameters
    ----------
    first, second : pandas.DataFrame
        Their strides, of the same trials.
    measures : sequence of str, optional
        Columns to compare; default those of :data:`REPEATABLE` that both have.
    tolerance : float
        How far apart two starts may be; see :func:`match_strides`.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``REPEATABILITY_COLUMNS``: :func:`bland_altman` and ICC2 of each measure. Intervals
        take strides as independent; they are of what two people differ in, not of animals.
        A measure with fewer than three shared strides has NaN.

    Raises
    ------
    InputError
        If a measure is in neither table or no stride is shared.
    """
    pairs = match_strides(first, second, tolerance=tolerance)
    shared = [m for m in REPEATABLE if m in first and m in second]
    names = list(shared if measures is None else measures)
    check_columns(first, names, where="strides")
    check_columns(second, names, where="strides")
    rows = []
    for name in names:
        known = pairs.dropna(subset=[f"{name}_1", f"{name}_2"])
        values = known[[f"{name}_1", f"{name}_2"]].to_numpy(dtype=float)
        row: dict[str, float | str] = dict.fromkeys(REPEATABILITY_COLUMNS, math.nan)
        row |= {"measure": name, "n": len(known), "n_animals": known["animal"].nunique()}
        if len(known) >= 3:
            found = bland_altman(values[:, 0], values[:, 1], level=level)
            row |= {c: v for c, v in found._asdict().items() if c in row}
            for end in ("limit_low", "limit_high"):
                middle = float(getattr(found, end))
                row[f"{end}_low"] = middle - found.limit_error
                row[f"{end}_high"] = middle + found.limit_error
            if np.ptp(values) > 0.0:
                icc = intraclass_correlation(values, level=level)
                row |= {"icc": icc.icc, "icc_low": icc.low, "icc_high": icc.high}
        rows.append(row)
    return pd.DataFrame(rows, columns=list(REPEATABILITY_COLUMNS))
