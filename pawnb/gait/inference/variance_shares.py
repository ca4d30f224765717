"""How much of the variance of strides lies between animals: intraclass correlation, its interval.

Estimates by analysis of variance and the interval from the exact distribution of a ratio of two
sums of squares, one between animals and one within (Wald 1940, 1947; for equal numbers it is that
of Shrout & Fleiss 1979 for their first form).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.stats import f as fisher

from pawnb.arrays import FloatArray
from pawnb.gait.inference.checks import check_level, check_values
from pawnb.gait.inference.circular_sample import animal_codes

_LARGEST_RATIO = 1e12


def variance_shares(values: FloatArray, animals: Sequence[object]) -> tuple[float, float]:
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


def icc_interval(
    values: FloatArray,
    animals: Sequence[object],
    *,
    design: FloatArray | None = None,
    level: float = 0.95,
) -> tuple[float, float]:
    """Compute the interval of the intraclass correlation of animals.

    With t the parts of the values that lie between animals, each of variance
    ``sd² (1 + ratio lambda)``, ``sum(t² / (1 + ratio lambda)) / r`` over the mean square within
    animals has the F distribution at the true ratio of the two variances. The interval holds
    the ratios at which it is not extreme: exact for normal values, for any numbers of strides
    and any terms.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One value a stride.
    animals : sequence, shape (n,)
        Animal of each.
    design : ndarray, shape (n, p), optional
        Terms that are taken out first, with a column of ones; default the mean alone.
    level : float
        Level of the interval.

    Returns
    -------
    low, high : float
        Share of the variance that lies between animals, 0 to 1; NaN with one animal, with too
        few strides, or where nothing varies within animals.

    Raises
    ------
    InputError
        If values, animals or level cannot be used.
    """
    values = check_values(values)
    check_level(level)
    codes, k = animal_codes(animals, len(values))
    x = np.ones((len(values), 1)) if design is None else np.asarray(design, dtype=float)
    basis = np.linalg.qr(x)[0]
    left = values - basis @ (basis.T @ values)
    # sums by animal: cross products of the animals' columns with the terms taken out
    sums = np.column_stack([np.bincount(codes, column, k) for column in basis.T])
    lambdas, vectors = np.linalg.eigh(np.diag(np.bincount(codes, minlength=k)) - sums @ sums.T)
    kept = lambdas > 1e-9 * max(float(lambdas[-1]), 1e-300)
    lambdas, r = lambdas[kept], int(kept.sum())
    squares = (vectors[:, kept].T @ np.bincount(codes, left, k)) ** 2 / lambdas
    df = len(values) - x.shape[1] - r
    within = float(left @ left - squares.sum())
    if r < 1 or df < 1 or within <= 1e-12 * float(left @ left):
        return math.nan, math.nan

    def ratio_at(quantile: float) -> float:
        """Return the ratio of variances at which F is this quantile, at least 0."""

        def excess(log_ratio: float) -> float:
            f = float((squares / (1.0 + math.exp(log_ratio) * lambdas)).sum()) / r
            return f / (within / df) - quantile

        if squares.sum() / r / (within / df) <= quantile:
            return 0.0
        top = math.log(_LARGEST_RATIO)
        return _LARGEST_RATIO if excess(top) > 0.0 else math.exp(brentq(excess, -60.0, top))

    tail = (1.0 - level) / 2.0
    ratios = [ratio_at(float(q)) for q in (fisher.isf(tail, r, df), fisher.ppf(tail, r, df))]
    return ratios[0] / (1.0 + ratios[0]), ratios[1] / (1.0 + ratios[1])
