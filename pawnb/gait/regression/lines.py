"""Lines through gait measures: least squares, power laws, reduced major axis.

statsmodels does the fitting. Points are animals, or trials where the question is about
speed; strides of one animal are not independent, see :mod:`pawnb.gait.regression.scaling` for one
point an animal and :func:`fit_within_animals` for slopes within animals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.inference.checks import EQUAL_SHARE, check_level
from pawnb.gait.inference.linear_fit import (
    AnimalSlopes,
    Line,
    SlopeTest,
    compare_slope,
    sprugel_factor,
    t_of,
    t_quantile,
)
from pawnb.schema.arguments import checked_arguments

__all__ = [
    "AnimalSlopes",
    "Line",
    "SlopeTest",
    "compare_slope",
    "fit_line",
    "fit_power",
    "fit_rma",
    "fit_within_animals",
    "slope_over_animals",
    "sprugel_factor",
]

LEAST_POINTS = 3


@checked_arguments
def fit_line(
    x: FloatArray,
    y: FloatArray,
    *,
    animals: Sequence[str] | None = None,
    level: float = 0.95,
) -> Line:
    """Fit ``y = a + b x`` by ordinary least squares (paper 2009, Table 4.5).

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One value a point; points where either is NaN are left out.
    animals : sequence of str, optional
        The animal of each point. With several points an animal, p and intervals are those
        of independent points, which they are not.
    level : float
        Level of the intervals.

    Returns
    -------
    Line
        The line.

    Raises
    ------
    InputError
        If fewer than three points are left, or all x are equal.
    """
    x, y, names = _points(x, y, animals, level)
    return _least_squares(x, y, names, level=level, kind="linear", corrected=False)


@checked_arguments
def fit_power(
    x: FloatArray,
    y: FloatArray,
    *,
    animals: Sequence[str] | None = None,
    level: float = 0.95,
    corrected: bool = True,
) -> Line:
    """Fit ``y = a x^b`` by least squares on logarithms (paper 2009, Table 4.3).

    Going back from logarithms gives the median of y, not its mean. Sprugel (1983) multiplies
    a by ``exp(see² / 2)``, where see is the standard error of the estimate in natural
    logarithms; for a fit in logarithms to base 10 that is ``exp((2.303 see)² / 2)``. It is
    exact where the residuals of the logarithms are normal.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One value a point, all above 0; points where either is NaN are left out.
    animals : sequence of str, optional
        The animal of each point.
    level : float
        Level of the intervals.
    corrected : bool
        Whether a (with its interval, and the curve) is multiplied by Sprugel's factor.

    Returns
    -------
    Line
        The power law.

    Raises
    ------
    InputError
        If fewer than three points are left, a value is not above 0, or all x are equal.
    """
    x, y, names = _points(x, y, animals, level)
    _check_positive(x, y)
    return _least_squares(
        np.log(x), np.log(y), names, level=level, kind="power", corrected=corrected
    )


@checked_arguments
def fit_rma(
    x: FloatArray,
    y: FloatArray,
    *,
    kind: Literal["linear", "power"] = "linear",
    animals: Sequence[str] | None = None,
    level: float = 0.95,
) -> Line:
    """Fit the reduced (standard) major axis: ``b = sign(r) sd_y / sd_x``.

    For two measured variables of which neither is the cause. The interval is that of
    Jolicoeur & Mosimann (1968; McArdle 1988): ``b (sqrt(B + 1) ± sqrt(B))`` with
    ``B = t² (1 - r²) / (n - 2)``. Its slope is never 0, so ``p`` tests the correlation.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One value a point; points where either is NaN are left out.
    kind : {"linear", "power"}
        Whether to fit the values or their logarithms; the factor of a power law is not
        corrected, for Sprugel's correction belongs to the prediction of y from x.
    animals : sequence of str, optional
        The animal of each point.
    level : float
        Level of the intervals.

    Returns
    -------
    Line
        The line; ``b_se`` is ``|b| sqrt((1 - r²) / (n - 2))``.

    Raises
    ------
    InputError
        If fewer than three points are left, x or y do not vary or are uncorrelated, a value
        is not above 0 for a power law, or the kind is not known.
    """
    x, y, names = _points(x, y, animals, level)
    if kind not in ("linear", "power"):
        raise InputError(f"kind is {kind!r}; expected 'linear' or 'power'.")
    x_low, x_high = float(x.min()), float(x.max())
    if kind == "power":
        _check_positive(x, y)
        x, y = np.log(x), np.log(y)
    if np.ptp(y) == 0.0:
        raise InputError("reduced major axis: all y are equal; expected values that vary.")
    r = float(np.corrcoef(x, y)[0, 1])
    if r == 0.0:
        raise InputError("reduced major axis: r is 0, so the slope has no sign.")
    df = len(x) - 2
    b = math.copysign(float(y.std() / x.std()), r)
    a = float(y.mean() - b * x.mean())
    quantile = t_quantile(level, df)
    widen = quantile**2 * (1.0 - r**2) / df
    ends = sorted(b * (math.sqrt(widen + 1.0) + s * math.sqrt(widen)) for s in (-1.0, 1.0))
    t = r * math.sqrt(df / max(1.0 - r**2, 1e-300))
    return Line(
        kind=kind, method="RMA", n=len(x), n_animals=_count(names),
        a=math.exp(a) if kind == "power" else a, b=b,
        b_se=abs(b) * math.sqrt((1.0 - r**2) / df), b_low=ends[0], b_high=ends[1],
        a_low=math.nan, a_high=math.nan, r=r, r2=r**2, t=t, df=df,
        p=float(2.0 * student.sf(abs(t), df)), see=math.sqrt(np.sum((y - a - b * x) ** 2) / df),
        correction=1.0, level=level, x_low=x_low, x_high=x_high,
        x_mean=float(x.mean()), x_squares=float(np.sum((x - x.mean()) ** 2)),
    )  # fmt: skip


@checked_arguments
def fit_within_animals(
    x: FloatArray,
    y: FloatArray,
    *,
    animals: Sequence[str],
    kind: Literal["linear", "power"] = "linear",
    level: float = 0.95,
) -> Line:
    """Fit one slope to all animals, each with its own intercept (Bland & Altman 1995).

    Tells whether y changes with x *within* animals: differences between animals are taken
    out, and each costs a degree of freedom. It supposes that animals share one slope and
    that an animal's points differ from its own line independently. Where slopes differ from
    animal to animal its p is far too small; :func:`slope_over_animals` does not suppose it.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One value a point; points where either is NaN are left out.
    animals : sequence of str
        The animal of each point.
    kind : {"linear", "power"}
        Whether to fit the values or their logarithms.
    level : float
        Level of the intervals.

    Returns
    -------
    Line
        ``a`` is the mean of the animals' intercepts, weighted by points; ``r`` is the
        correlation within animals.

    Raises
    ------
    InputError
        If too few points are left after one for each animal, x does not vary within any
        animal, or a value is not above 0 for a power law.
    """
    x, y, names = _points(x, y, animals, level)
    x_low, x_high = float(x.min()), float(x.max())
    if kind == "power":
        _check_positive(x, y)
        x, y = np.log(x), np.log(y)
    codes, who = pd.factorize(np.asarray(names))
    df = len(x) - len(who) - 1
    counts = np.bincount(codes)
    dx, dy = (v - (np.bincount(codes, weights=v) / counts)[codes] for v in (x, y))
    squares = float(dx @ dx)
    if df < 1 or squares <= 1e-24 * float(x @ x):
        raise InputError(
            f"within animals: {len(x)} points of {len(who)} animals with x that "
            f"{'varies' if squares else 'does not vary'} in them; expected more points than "
            "animals, and at least one animal with different x."
        )
    from statsmodels.regression.linear_model import OLS  # slow to import

    fitted = OLS(y, np.column_stack((x, np.eye(len(who))[codes]))).fit()
    low, high = (float(v) for v in fitted.conf_int(alpha=1.0 - level)[0])
    b = float(fitted.params[0])
    t = t_of(b, float(fitted.bse[0]))
    a = float(y.mean() - b * x.mean())
    r = float(dx @ dy) / math.sqrt(squares * float(dy @ dy)) if np.any(dy) else 0.0
    return Line(
        kind=kind, method="within", n=len(x), n_animals=len(who),
        a=math.exp(a) if kind == "power" else a, b=b, b_se=float(fitted.bse[0]),
        b_low=low, b_high=high, a_low=math.nan, a_high=math.nan, r=r, r2=r**2,
        t=t, df=df, p=float(2.0 * student.sf(abs(t), df)),
        see=math.sqrt(fitted.scale), correction=1.0, level=level, x_low=x_low, x_high=x_high,
        x_mean=float(x.mean()), x_squares=squares,
    )  # fmt: skip


@checked_arguments
def slope_over_animals(
    x: FloatArray,
    y: FloatArray,
    *,
    animals: Sequence[str],
    kind: Literal["linear", "power"] = "linear",
    level: float = 0.95,
) -> AnimalSlopes:
    """Fit one line to each animal and test the mean of their slopes: each animal counts once.

    The summary measure of Matthews et al. (1990). It supposes neither one level nor one slope
    for all animals. In simulations of 5 to 15 animals with 2 to 10 points each, whose slopes
    varied about 0, 2 to 5 % of its tests at the level of 0.95 were false alarms, against 10 to
    54 % of those of :func:`fit_within_animals`. With two points an animal it is cautious.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One value a point; points where either is NaN are left out.
    animals : sequence of str
        The animal of each point.
    kind : {"linear", "power"}
        Whether to fit the values or their logarithms.
    level : float
        Level of the interval.

    Returns
    -------
    AnimalSlopes
        The slopes, their mean, its interval and test.

    Raises
    ------
    InputError
        If fewer than two animals have two points of different x, or a value is not above 0
        for a power law.
    """
    x, y, names = _points(x, y, animals, level)
    who = np.asarray(names).astype(str)
    usable = {name for name in set(who.tolist()) if differ(x[who == name])}
    if kind == "power":
        _check_positive(x, y)
        x, y = np.log(x), np.log(y)
    slopes, intercepts = {}, {}
    for name in sorted(set(who.tolist())):
        own, high = x[who == name], y[who == name]
        away = own - own.mean()
        if name in usable:
            slopes[name] = float(away @ high / (away @ away))
            intercepts[name] = float(high.mean() - slopes[name] * own.mean())
    if len(slopes) < 2:
        raise InputError(
            f"slopes of animals: {len(slopes)} animals have two points of different x; expected "
            "at least two such animals."
        )
    values = np.array(list(slopes.values()))
    df, mean = len(values) - 1, float(values.mean())
    se = float(values.std(ddof=1)) / math.sqrt(len(values))
    t = t_of(mean, se)
    half = t_quantile(level, df) * se
    return AnimalSlopes(
        kind=kind, slopes=slopes, intercepts=intercepts,
        left_out=tuple(sorted(set(who.tolist()) - set(slopes))),
        b=mean, b_low=mean - half, b_high=mean + half, t=t, df=df,
        p=float(2.0 * student.sf(abs(t), df)), level=level,
    )  # fmt: skip


def _least_squares(
    x: FloatArray,
    y: FloatArray,
    names: np.ndarray | None,
    *,
    level: float,
    kind: Literal["linear", "power"],
    corrected: bool,
) -> Line:
    """Fit by least squares; x and y are logarithms already for a power law."""
    from statsmodels.regression.linear_model import OLS  # slow to import

    fitted = OLS(y, np.column_stack((np.ones(len(x)), x))).fit()
    (a_low, a_high), (b_low, b_high) = fitted.conf_int(alpha=1.0 - level)
    a, b = (float(v) for v in fitted.params)
    t = t_of(b, float(fitted.bse[1]))
    see = math.sqrt(max(float(fitted.scale), 0.0))
    factor = sprugel_factor(see) if corrected else 1.0
    ends = (float(a_low), a, float(a_high))
    if kind == "power":
        ends = tuple(factor * math.exp(v) for v in ends)  # type: ignore[assignment]
    r = float(np.corrcoef(x, y)[0, 1]) if np.ptp(y) > 0.0 else 0.0
    span = np.exp([x.min(), x.max()]) if kind == "power" else (x.min(), x.max())
    return Line(
        kind=kind, method="OLS", n=len(x), n_animals=_count(names), a=ends[1], b=b,
        b_se=float(fitted.bse[1]), b_low=float(b_low), b_high=float(b_high), a_low=ends[0],
        a_high=ends[2], r=r, r2=r**2, t=t, df=len(x) - 2,
        p=float(2.0 * student.sf(abs(t), len(x) - 2)), see=see, correction=factor, level=level,
        x_low=float(span[0]), x_high=float(span[1]), x_mean=float(x.mean()),
        x_squares=float(np.sum((x - x.mean()) ** 2)),
    )  # fmt: skip


def differ(x: FloatArray) -> bool:
    """Say whether values differ by more than rounding: those of a belt of one speed do not."""
    return len(x) > 0 and bool(np.ptp(x) > EQUAL_SHARE * np.abs(x).max())


def _points(
    x: FloatArray, y: FloatArray, animals: Sequence[str] | None, level: float
) -> tuple[FloatArray, FloatArray, np.ndarray | None]:
    """Return the points where both are known; refuse what cannot be fitted."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    names = None if animals is None else np.asarray(animals, dtype=object)
    if x.ndim != 1 or x.shape != y.shape or (names is not None and names.shape != x.shape):
        raise InputError(
            f"regression: x has shape {x.shape}, y {y.shape}"
            f"{'' if names is None else f', animals {names.shape}'}; expected one value a point."
        )
    check_level(level)
    if np.isinf(x).any() or np.isinf(y).any():
        raise InputError("regression: some values are infinite; leave those points out.")
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < LEAST_POINTS or not differ(x):
        found = f"{len(x)} points" if len(x) < LEAST_POINTS else "all x are equal"
        raise InputError(
            f"regression: {found}; expected at least {LEAST_POINTS} points with different x."
        )
    return x, y, None if names is None else names[known]


def _check_positive(x: FloatArray, y: FloatArray) -> None:
    """Refuse values that have no logarithm."""
    bad = int(np.sum((x <= 0.0) | (y <= 0.0)))
    if bad:
        raise InputError(f"power law: {bad} points are not above 0 in x and y; leave them out.")


def _count(names: np.ndarray | None) -> int | None:
    """Return the number of animals."""
    return None if names is None else len(set(names.tolist()))
