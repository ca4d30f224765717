"""A fitted line: what is known of it, its band, and tests of its slope."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pawnb.arrays import FloatArray
from pawnb.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Line:
    """A fitted line ``y = a + b x``, or power law ``y = a x^b``.

    Parameters
    ----------
    kind : {"linear", "power"}
        Which of the two.
    method : {"OLS", "RMA", "within"}
        Ordinary least squares, reduced major axis, or least squares within animals.
    n, n_animals : int
        Points and animals; ``n_animals`` is None where animals were not named.
    a, b : float
        Intercept and slope; of a power law factor and exponent, the factor multiplied by
        ``correction``.
    b_se : float
        Standard error of b.
    b_low, b_high : float
        Confidence interval of b.
    a_low, a_high : float
        Confidence interval of a (NaN for RMA and within animals).
    r, r2 : float
        Correlation (of the logarithms, for a power law) and its square.
    t, df, p : float
        Two-tailed t test of b = 0 with its degrees of freedom; for RMA, of r = 0.
    see : float
        Standard error of the estimate: residual standard deviation (of the natural
        logarithms, for a power law).
    correction : float
        Sprugel's factor exp(see² / 2) by which a was multiplied; 1 where it was not.
    level : float
        Level of the intervals.
    x_low, x_high, x_mean, x_squares : float
        Range, mean and sum of squares about the mean of x (of its logarithms, for the last
        two of a power law).
    """

    kind: Literal["linear", "power"]
    method: Literal["OLS", "RMA", "within"]
    n: int
    n_animals: int | None
    a: float
    b: float
    b_se: float
    b_low: float
    b_high: float
    a_low: float
    a_high: float
    r: float
    r2: float
    t: float
    df: int
    p: float
    see: float
    correction: float
    level: float
    x_low: float
    x_high: float
    x_mean: float
    x_squares: float

    @property
    def significant(self) -> bool:
        """Whether b differs from 0: its interval excludes 0 (of RMA, r does)."""
        if self.method == "RMA":
            return self.p < 1.0 - self.level
        return self.b_low > 0.0 or self.b_high < 0.0

    def predict(self, x: FloatArray) -> pd.DataFrame:
        """Return the line and the confidence band of its height.

        Parameters
        ----------
        x : ndarray, shape (n,)
            Where; above 0 for a power law.

        Returns
        -------
        pandas.DataFrame
            ``x, fit, low, high``: the band is that of the mean at x, not of single points.
            Of a power law all three carry Sprugel's factor. No band is defined for RMA and
            within animals: NaN.

        Raises
        ------
        InputError
            If x is not above 0 for a power law.
        """
        at = np.asarray(x, dtype=float)
        if self.kind == "power" and not (at > 0.0).all():
            raise InputError("predict: expected x above 0 for a power law.")
        u = np.log(at) if self.kind == "power" else at
        a = math.log(self.a) if self.kind == "power" else self.a
        line = a + self.b * u
        half = np.full(len(at), np.nan)
        if self.method == "OLS":
            spread = self.see * np.sqrt(1.0 / self.n + (u - self.x_mean) ** 2 / self.x_squares)
            half = t_quantile(self.level, self.df) * spread
        columns = {"fit": line, "low": line - half, "high": line + half}
        back = np.exp if self.kind == "power" else np.asarray
        return pd.DataFrame({"x": at, **{name: back(v) for name, v in columns.items()}})


@dataclass(frozen=True, kw_only=True)
class SlopeTest:
    """Two-tailed t test of a slope against an expected one.

    Parameters
    ----------
    observed, expected : float
        The two slopes.
    t, df, p : float
        Statistic, degrees of freedom and p.
    differs : bool
        Whether p is below one minus the level of the line's interval; of least squares, this
        is whether the interval excludes the expected slope.
    """

    observed: float
    expected: float
    t: float
    df: int
    p: float
    differs: bool


@dataclass(frozen=True, kw_only=True)
class AnimalSlopes:
    """Slopes of single animals, and their mean.

    Parameters
    ----------
    kind : {"linear", "power"}
        Whether slopes are of values or of their logarithms.
    slopes, intercepts : dict
        Slope and intercept (of a power law: the logarithm of its factor) by animal.
    left_out : tuple of str
        Animals without two points of different x.
    b, b_low, b_high : float
        Mean slope with its interval.
    t, df, p : float
        Two-tailed t test of a mean slope of 0, animals counted once.
    level : float
        Level of the interval.
    """

    kind: Literal["linear", "power"]
    slopes: dict[str, float]
    intercepts: dict[str, float]
    left_out: tuple[str, ...]
    b: float
    b_low: float
    b_high: float
    t: float
    df: int
    p: float
    level: float

    @property
    def n_animals(self) -> int:
        """Animals that have a slope."""
        return len(self.slopes)

    @property
    def significant(self) -> bool:
        """Whether the interval excludes 0."""
        return self.b_low > 0.0 or self.b_high < 0.0


def compare_slope(line: Line, expected: float) -> SlopeTest:
    """Test whether a slope differs from an expected one (paper 2009, Table 4.4).

    Least squares: ``t = (b - expected) / se``, on the line's degrees of freedom. Reduced
    major axis: the correlation of ``y - expected x`` with ``y + expected x`` is 0 where the
    slope is the expected one (Pitman 1939; Warton et al. 2006).

    Parameters
    ----------
    line : Line
        A fitted line.
    expected : float
        The slope, or exponent, to compare with.

    Returns
    -------
    SlopeTest
        t, degrees of freedom, two-tailed p and whether the slopes differ.

    Raises
    ------
    InputError
        If the expected slope is not a finite number, or is 0 for a reduced major axis.
    """
    if not math.isfinite(expected) or (line.method == "RMA" and expected == 0.0):
        raise InputError(
            f"expected slope is {expected}; expected a finite number, and not 0 for a reduced "
            "major axis, whose slope is never 0."
        )
    if line.method == "RMA":
        squares, target = line.b**2, expected**2
        crossed = line.b * expected * abs(line.r)
        spread = math.sqrt(max((squares + target) ** 2 - 4.0 * crossed**2, 0.0))
        r = (squares - target) / spread if spread else 0.0
        t = r * math.sqrt(line.df / max(1.0 - r**2, 1e-300))
    else:
        t = t_of(line.b - expected, line.b_se)
    p = float(2.0 * student.sf(abs(t), line.df))
    return SlopeTest(
        observed=line.b, expected=expected, t=t, df=line.df, p=p, differs=p < 1.0 - line.level
    )


def sprugel_factor(see: float, *, base: float = math.e) -> float:
    """Compute Sprugel's (1983) correction for going back from logarithms.

    Parameters
    ----------
    see : float
        Standard error of the estimate of the regression on logarithms.
    base : float
        Base of the logarithms: e, or 10.

    Returns
    -------
    float
        ``exp((see ln base)² / 2)``.

    Raises
    ------
    InputError
        If ``see`` is negative or the base is not above 1.
    """
    if not see >= 0.0 or not base > 1.0:
        raise InputError(f"see is {see}, base {base}; expected 0 or more, and a base above 1.")
    return math.exp((see * math.log(base)) ** 2 / 2.0)


def t_quantile(level: float, df: float) -> float:
    """Return Student's quantile of a two-sided interval.

    Parameters
    ----------
    level : float
        Level of the interval.
    df : float
        Degrees of freedom.

    Returns
    -------
    float
        The quantile, above 0.
    """
    return float(student.ppf((1.0 + level) / 2.0, df))


def t_of(estimate: float, se: float) -> float:
    """Return an estimate over its standard error.

    Parameters
    ----------
    estimate, se : float
        Estimate and standard error.

    Returns
    -------
    float
        t; infinite where the error is 0 and the estimate is not, 0 where both are.
    """
    if se > 0.0:
        return estimate / se
    return math.copysign(math.inf, estimate) if estimate else 0.0
