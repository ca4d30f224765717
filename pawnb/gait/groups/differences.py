"""Differences of two samples of animals: intervals, effect sizes and p.

Each animal is one number; :mod:`pawnb.gait.groups` makes them from strides.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import gammaln, ndtr
from scipy.stats import chi2
from scipy.stats import t as student

from pawnb.arrays import FloatArray
from pawnb.gait.circular.describe import difference
from pawnb.gait.circular.mean import mean_vector
from pawnb.gait.inference.animal_phases import WHOLE_CYCLE
from pawnb.gait.inference.checks import NOTHING_VARIES, is_rounding
from pawnb.gait.inference.circular_sample import TINY, phase_standard_error
from pawnb.gait.inference.linear_fit import t_quantile
from pawnb.schema.arguments import checked_arguments

_BLANK = (math.nan,) * 3


class Difference(NamedTuple):
    """Difference between two samples of animals; see :func:`compare_groups`.

    Attributes
    ----------
    mean_a, mean_b : float
        Means of the samples.
    difference, ci_low, ci_high : float
        b less a, with its interval.
    effect, effect_low, effect_high : float
        Hedges' g with its interval; NaN for phases.
    p : float
        p of no difference.
    n_animals_a, n_animals_b : int
        Numbers in the samples.
    method : str
        How it was found.
    note : str
        What the reader must know, else empty.
    """

    mean_a: float
    mean_b: float
    difference: float
    ci_low: float
    ci_high: float
    effect: float
    effect_low: float
    effect_high: float
    p: float
    n_animals_a: int
    n_animals_b: int
    method: str
    note: str = ""


@checked_arguments
def compare_two(a: FloatArray, b: FloatArray, *, level: float = 0.95) -> Difference:
    """Compare two samples of one number an animal: Welch's t and Hedges' g.

    Parameters
    ----------
    a, b : ndarray
        One number an animal.
    level : float
        Level of the intervals.

    Returns
    -------
    Difference
        b less a. Without interval where a sample has one animal, or the animals of both differ by
        rounding only.
    """
    counts = len(a), len(b)
    means = float(a.mean()), float(b.mean())
    away = means[1] - means[0]
    if min(len(a), len(b)) < 2:
        return _no_test(*means, away, counts)
    squares = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    if is_rounding(math.sqrt(sum(squares)), np.concatenate((a, b))):
        return _no_test(*means, away, counts, NOTHING_VARIES)
    half, p, df = _welch(away, squares, (len(a) - 1, len(b) - 1), level)
    pooled_df = len(a) + len(b) - 2
    pooled = math.sqrt(((len(a) - 1) * a.var(ddof=1) + (len(b) - 1) * b.var(ddof=1)) / pooled_df)
    size = 1.0 / math.sqrt(1.0 / len(a) + 1.0 / len(b))
    effect = hedges_g(away / pooled, size, pooled_df, level=level)
    method = f"Welch's t, {df:.1f} df"
    return Difference(*means, away, away - half, away + half, *effect, p, *counts, method)


@checked_arguments
def compare_two_phases(a: FloatArray, b: FloatArray, *, level: float = 0.95) -> Difference:
    """Compare two samples of one phase an animal; see :func:`compare_groups`.

    Parameters
    ----------
    a, b : ndarray
        One phase an animal, cycles.
    level : float
        Level of the interval.

    Returns
    -------
    Difference
        b less a, the short way round. Without interval where a sample has one animal, or the
        animals of both differ by rounding only.
    """
    counts = len(a), len(b)
    means = mean_vector(a).mean, mean_vector(b).mean
    away = float(difference(np.array([means[1]]), means[0])[0])
    if min(len(a), len(b)) < 2 or not math.isfinite(away):
        return _no_test(*means, away, counts)
    squares = phase_standard_error(a) ** 2, phase_standard_error(b) ** 2
    if is_rounding(math.sqrt(sum(squares)), np.ones(1)):
        return _no_test(*means, away, counts, NOTHING_VARIES)
    half, p, df = _welch(away, squares, (len(a) - 1, len(b) - 1), level)
    half, note = _at_most(half, level)
    method = f"Welch's t of phases, {df:.1f} df"
    return Difference(*means, away, away - half, away + half, *_BLANK, p, *counts, method, note)


@checked_arguments
def compare_paired(
    a: FloatArray, b: FloatArray, *, circular: bool = False, level: float = 0.95
) -> Difference:
    """Compare two conditions of the same animals by each animal's difference.

    Parameters
    ----------
    a, b : ndarray, shape (k,)
        One number or phase an animal, in the same order.
    circular : bool
        Whether they are phases in cycles.
    level : float
        Level of the intervals.

    Returns
    -------
    Difference
        Mean of b less a. Without interval for one animal, or where the differences of all are the
        same but for rounding.
    """
    k = len(a)
    counts = k, k
    if circular:
        means = mean_vector(a).mean, mean_vector(b).mean
        each = np.mod(b - a, 1.0)
        away = float(difference(np.array([mean_vector(each).mean]), 0.0)[0])
        error = phase_standard_error(each) if k > 1 and math.isfinite(away) else math.nan
    else:
        means, each = (float(a.mean()), float(b.mean())), b - a
        away = float(each.mean())
        error = float(each.std(ddof=1)) / math.sqrt(k) if k > 1 else math.nan
    if k < 2 or not math.isfinite(away):
        return _no_test(*means, away, counts, "one animal in both: no interval and no p")
    if is_rounding(error, np.ones(1) if circular else np.concatenate((a, b))):
        return _no_test(*means, away, counts, NOTHING_VARIES)
    half, p, df = _welch(away, (error**2, 0.0), (k - 1, 1), level)
    method = f"paired t{' of phases' if circular else ''}, {df:.0f} df"
    half, note = _at_most(half, level) if circular else (half, "")
    effect = _BLANK
    if not circular:
        effect = hedges_g(away / (error * math.sqrt(k)), math.sqrt(k), k - 1, level=level)
    return Difference(*means, away, away - half, away + half, *effect, p, *counts, method, note)


@checked_arguments
def hedges_g(d: float, size: float, df: int, *, level: float = 0.95) -> tuple[float, float, float]:
    """Correct a standardised difference for small samples and give its interval.

    ``g = J d`` with the exact J of Hedges (1981); interval: noncentral t distributions whose
    tail begins at the t observed, ``t = d size`` (Cumming & Finch 2001).

    Parameters
    ----------
    d : float
        Difference over the standard deviation.
    size : float
        ``1 / sqrt(1 / n1 + 1 / n2)``, or sqrt(n) for differences of pairs.
    df : int
        Degrees of freedom of the standard deviation.
    level : float
        Level of the interval.

    Returns
    -------
    g, low, high : float
        Effect size and interval.
    """
    j = (
        math.exp(gammaln(df / 2.0) - gammaln((df - 1) / 2.0)) * math.sqrt(2.0 / df)
        if df > 1
        else 1.0
    )
    t, tail = d * size, (1.0 - level) / 2.0
    reach = abs(t) + 10.0 + 8.0 * abs(t) / math.sqrt(df)

    def end(share: float) -> float:
        return float(brentq(lambda c: _noncentral_t(t, df, c) - share, -reach, reach)) / size

    return j * d, j * end(1.0 - tail), j * end(tail)


def _noncentral_t(t: float, df: int, centre: float) -> float:
    """Return P(T <= t) of the noncentral t; scipy's is NaN far from its centre."""
    return float(ndtr(t * _chi_quantiles(df) - centre).mean())


@functools.cache
def _chi_quantiles(df: int) -> FloatArray:
    """Return evenly spaced quantiles of a standard deviation of ``df`` degrees of freedom."""
    middles = (np.arange(4000) + 0.5) / 4000
    return np.asarray(np.sqrt(chi2.ppf(middles, df) / df))


def _welch(
    away: float, squares: tuple[float, float], dfs: tuple[int, int], level: float
) -> tuple[float, float, float]:
    """Return half the interval, p and the degrees of freedom of a difference of two means."""
    whole = squares[0] + squares[1]
    if not math.isfinite(whole):  # phases as scattered as at random
        return math.inf, 1.0, float(min(dfs))
    df = whole**2 / (squares[0] ** 2 / dfs[0] + squares[1] ** 2 / dfs[1])
    error = math.sqrt(whole)
    quantile = t_quantile(level, df)
    p = max(float(2.0 * student.sf(abs(away) / error, df)), TINY)
    return quantile * error, p, df


def _at_most(half: float, level: float) -> tuple[float, str]:
    """Return half an interval of phases, of ``level`` of the cycle at most, and a note."""
    return (half, "") if half < level / 2.0 else (level / 2.0, WHOLE_CYCLE)


def _no_test(
    mean_a: float,
    mean_b: float,
    away: float,
    counts: tuple[int, int],
    note: str = "one animal in a group: no interval and no p",
) -> Difference:
    """Return a difference that has neither interval nor p."""
    if not math.isfinite(away):
        note = "a group has no mean phase"
    return Difference(mean_a, mean_b, away, *_BLANK, *_BLANK, *counts, "none", note)
