"""Circular statistics of phases: mean, spread, Rayleigh's p, interval of the mean.

Phases are in cycles; 0.98 and 0.02 are near each other. NaN is refused: a phase that
could not be measured does not belong in a sample. More description is in
:mod:`pawnb.gait.circular.describe`, tests are in :mod:`pawnb.gait.circular.tests`.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import hankel1e, ive
from scipy.stats import chi2

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.inference.checks import as_numbers, check_level

_LARGE_KAPPA = 1e6
_NEARLY_ONE = 1.0 - 1e-5
_TINY = float(np.finfo(float).tiny)
_BLOCK, _LEFT_OUT = 128, 1e-8
"""Points of an integral at first, and the share of it at which its end is left out."""
# differences and sums of two phases are phases; degrees and radians are not
_LEAST_PHASE, _MOST_PHASE = -1.0, 2.0


class MeanVector(NamedTuple):
    """Mean vector of a sample of phases.

    Attributes
    ----------
    mean : float
        Mean phase in cycles, in [0, 1).
    r : float
        Length, from 0 (no direction) to 1 (all phases equal).
    n : int
        Size of the sample.
    """

    mean: float
    r: float
    n: int


def mean_vector(phases: FloatArray, *, weights: np.ndarray | None = None) -> MeanVector:
    """Compute mean phase and length of the mean vector.

    ``mean = atan2(Y, X) / 2 pi`` with X and Y the means of cosine and sine: Zar (2010),
    Eq. 26.2-26.7, and the paper of 2009, Eq. 3.22, with the division by n put where it
    belongs, outside cosine and sine.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    weights : ndarray, shape (n,), optional
        Weights, or how often each phase was found; the same for all without it.

    Returns
    -------
    MeanVector
        Mean in [0, 1), length r, and n. Where r is 0 (to rounding) no mean exists and
        it is NaN.

    Raises
    ------
    InputError
        If there is no phase or one is not a finite number, or weights do not fit.
    """
    phases = check_phases(phases)
    if weights is not None:
        weights = as_numbers(weights, "weights")
        known = np.isfinite(weights).all() and (weights >= 0).all()
        if len(weights) != len(phases) or not known or not 0 < weights.sum() < math.inf:
            raise InputError(
                f"weights: expected {len(phases)} numbers of 0 or more, not all 0, one a phase."
            )
    vector = np.average(np.exp(2j * np.pi * phases), weights=weights)
    r = min(float(abs(vector)), 1.0)
    if r < 1e-12:
        return MeanVector(math.nan, 0.0, len(phases))
    return MeanVector(wrap(float(np.angle(vector)) / (2.0 * math.pi)), r, len(phases))


def wrap(phase: float) -> float:
    """Return a phase in cycles as its equal in [0, 1).

    Parameters
    ----------
    phase : float
        Phase in cycles.

    Returns
    -------
    float
        The same phase, at least 0 and below 1.
    """
    turned = phase % 1.0
    return 0.0 if turned >= 1.0 else turned  # -1e-17 % 1.0 is 1.0


def circular_sd(r: float) -> float:
    """Compute the circular standard deviation, in cycles.

    ``sqrt(-2 ln r) / 2 pi``: Mardia's form, Zar (2010) Eq. 26.21, paper 2009 Eq. 3.23.
    Not to be confused with the angular deviation ``sqrt(2 (1 - r))``, which is smaller.

    Parameters
    ----------
    r : float
        Length of the mean vector, 0 to 1.

    Returns
    -------
    float
        Standard deviation in cycles; infinite where r is 0.

    Raises
    ------
    InputError
        If r is not between 0 and 1.
    """
    check_r(r)
    return math.inf if r == 0.0 else math.sqrt(max(0.0, -2.0 * math.log(r))) / (2.0 * math.pi)


def rayleigh_p(n: int, r: float, *, method: str = "exact") -> float:
    """Compute p of Rayleigh's test: P(mean vector longer than r) for n phases.

    ``"exact"`` is Kluyver's integral; see :func:`resultant_p`. ``"zar"`` is the closed
    form of the paper of 2009, Eq. 3.25 (Zar 2010, Eq. 27.4; also CircStat and pingouin):
    it agrees with the exact p to about 15 % above p = 0.001 (35-45 % with 5 phases), but
    is 8 to 70 times too large below 0.0001, where phases of gaits often lie. The series of
    Greenwood and Durand, which astropy and R use, is not offered: it can be negative.

    Parameters
    ----------
    n : int
        Number of phases.
    r : float
        Length of their mean vector, 0 to 1.
    method : {"exact", "zar"}
        Which p.

    Returns
    -------
    float
        p, above 0 (2e-308 where it would be less) and at most 1; 1 for a single phase,
        which tells nothing.

    Raises
    ------
    InputError
        If n is no whole number of 1 or more, r is not between 0 and 1, or the method is unknown.
    """
    if not isinstance(n, (int, np.integer)) or n < 1:
        raise InputError(f"n is {n!r}; expected a whole number of phases, at least one.")
    check_r(r)
    if method not in ("exact", "zar"):
        raise InputError(f"method is {method!r}; expected 'exact' or 'zar'.")
    if method == "zar":
        total = n * r
        root = math.sqrt(1.0 + 4.0 * n + 4.0 * (n**2 - total**2))
        return min(1.0, max(math.exp(root - (1.0 + 2.0 * n)), _TINY))
    return _rayleigh_exact(int(n), float(n * r))


@lru_cache(maxsize=1024)  # table, pattern and interval of the same phases all ask for it
def _rayleigh_exact(n: int, total: float) -> float:
    return resultant_p(np.ones(n), total)


def resultant_p(lengths: FloatArray, total: float) -> float:
    """Compute the exact p of a resultant: vectors of given lengths in random directions.

    Kluyver (1906) gave P(resultant > R) for n vectors of lengths a as ``1 - R * integral of
    J1(R t) prod J0(a t) dt`` from 0 to infinity. With J1 written as a Hankel function and
    the path of integration moved up to ``t = u + i k``, the 1 cancels and

        p = -(R / 2) * integral of H1(R (u + i k)) prod J0(a (u + i k)) du,   all real u,

    for any k > 0. With k near the saddle point, ``sum of a I1(a k) / I0(a k) = R``, nothing
    is lost to cancellation, and the trapezoid rule gives small p too with a relative error
    below 1e-5. Equal lengths make it Rayleigh's test, ranks Moore's.

    Parameters
    ----------
    lengths : ndarray, shape (n,)
        Lengths of the vectors, above 0.
    total : float
        Length of their resultant R, 0 to the sum of the lengths.

    Returns
    -------
    float
        p, above 0 (2e-308 where it would be less) and at most 1; 1 for a single vector.

    Raises
    ------
    InputError
        If a length is not positive or the resultant is longer than their sum.
    """
    lengths = as_numbers(lengths, "lengths of vectors")
    n, whole = len(lengths), float(lengths.sum())
    if n == 0 or not (lengths > 0.0).all() or not math.isfinite(whole):
        raise InputError("lengths of vectors: expected at least one, all above 0 and finite.")
    r = total / whole
    if not 0.0 <= r <= 1.0 + 1e-12:
        raise InputError(f"the resultant is {total}; expected 0 to {whole}, the sum of lengths.")
    if n == 1 or r < 1e-6:
        return 1.0
    if n == 2:  # the law of cosines; the integral converges too slowly
        a, b = lengths
        cosine = (total**2 - a**2 - b**2) / (2.0 * a * b)
        return max(math.acos(float(np.clip(cosine, -1.0, 1.0))) / math.pi, _TINY)
    if r > _NEARLY_ONE:  # p goes as (1 - r)^((n - 1) / 2)
        shrink = (max(1.0 - r, 0.0) / (1.0 - _NEARLY_ONE)) ** ((n - 1) / 2.0)
        return max(_resultant_integral(lengths, _NEARLY_ONE * whole) * shrink, _TINY)
    return _resultant_integral(lengths, total)


def _resultant_integral(lengths: FloatArray, total: float) -> float:
    """Evaluate the shifted integral of :func:`resultant_p` by the trapezoid rule."""
    n = len(lengths)
    unit = total / float(lengths.sum())
    # thousands of equal lengths are one length, thousands of times
    lengths, times = np.unique(lengths / lengths.mean(), return_counts=True)
    total = n * unit

    def excess(k: float) -> float:
        return float((times * lengths * length_of_kappa(lengths * k)).sum()) - total

    height = max(brentq(excess, 0.0, 10.0 * n / (1.0 - unit)), n**-0.5)
    width = math.sqrt(2.0 / n) * max(1.0, 0.7 * height)  # of the peak at u = 0
    step = min(height / 8.0, width / 2.0)
    # beyond the peak the integrand falls at least as (height / u)^((n + 1) / 2)
    reach = height * min(1000.0, 10.0 ** (60.0 / (n + 1))) + 12.0 * width
    count, both_sides = math.ceil(reach / step), 0.0
    first, beyond = 0, _BLOCK
    while first < count:
        t = step * np.arange(first, min(beyond, count)) + 1j * height
        # logarithms with the growth of both factors taken out: ive and hankel1e are scaled
        log_j0 = np.zeros(len(t), dtype=complex)
        for length, often in zip(lengths, times, strict=True):
            log_j0 += often * (np.log(ive(0, -1j * length * t)) + length * height)
        log_h1 = np.log(hankel1e(1, total * t)) + 1j * total * t
        values = np.exp(log_j0 + log_h1)
        # the value at -u is the complex conjugate
        both_sides += float(2.0 * values.real.sum() - (values[0].real if first == 0 else 0.0))
        # all that follows is less than the last value times its distance
        if abs(values[-1]) * t[-1].real < _LEFT_OUT * step * abs(both_sides):
            break
        first, beyond = beyond, 4 * beyond
    return float(np.clip(-total / 2.0 * step * both_sides, _TINY, 1.0))


def length_of_kappa(kappa: np.ndarray | float) -> FloatArray:
    """Return the length of the mean vector of von Mises distributions, ``I1 / I0``.

    Parameters
    ----------
    kappa : ndarray
        Concentrations, 0 or more and finite.

    Returns
    -------
    ndarray
        Lengths, 0 to 1.
    """
    kappa = np.asarray(kappa, dtype=float)
    # far out the functions are no longer evaluated (NaN); the next term is below rounding there
    some = np.minimum(kappa, _LARGE_KAPPA)
    near = ive(1, some) / ive(0, some)
    far = 1.0 - 0.5 / np.maximum(kappa, 1.0) - 0.125 / np.maximum(kappa, 1.0) ** 2
    return np.where(kappa < _LARGE_KAPPA, near, far)


def mean_interval(mean: float, r: float, n: int, *, level: float = 0.95) -> tuple[float, float]:
    """Compute the confidence interval of a mean phase (Upton; Zar 2010, Eq. 26.24-26.25).

    Zar recommends it for n of 8 or more; with fewer it is a rough guide. The two
    equations are for r up to 0.9 and above.

    Parameters
    ----------
    mean : float
        Mean phase in cycles.
    r : float
        Length of the mean vector.
    n : int
        Size of the sample.
    level : float
        Confidence level.

    Returns
    -------
    low, high : float
        Ends in [0, 1), in cycles; the interval runs upwards from low to high and may
        wrap (low > high). Both NaN for one phase. Where the vectors are so scattered (n r² at
        most half the quantile of chi²) that any mean is possible it is
        :func:`widest_interval`.

    Raises
    ------
    InputError
        If r or level is out of range.
    """
    check_r(r)
    check_level(level)
    quantile = float(chi2.ppf(level, 1))
    total = n * r
    if n < 2:
        return math.nan, math.nan
    if not math.isfinite(mean) or 2.0 * total**2 <= n * quantile:
        return widest_interval(mean, level)
    if r <= 0.9:
        under = 2.0 * n * (2.0 * total**2 - n * quantile) / (4.0 * n - quantile)
    else:
        under = n**2 - (n**2 - total**2) * math.exp(quantile / n)
    if under < 0.0:
        return widest_interval(mean, level)
    half = math.acos(min(1.0, math.sqrt(under) / total)) / (2.0 * math.pi)
    return wrap(mean - half), wrap(mean + half)


def widest_interval(mean: float, level: float) -> tuple[float, float]:
    """Return the interval of a mean phase that may be any: ``level`` of the cycle about it.

    An arc of 95 % of the cycle holds any phase in 95 % of the studies, even where the mean in its
    middle is chance.

    Parameters
    ----------
    mean : float
        Mean phase in cycles; NaN where there is none.
    level : float
        Level of the interval.

    Returns
    -------
    low, high : float
        Ends in [0, 1), which may wrap; 0 and 1, the whole cycle, without a mean.
    """
    if not math.isfinite(mean):
        return 0.0, 1.0
    return wrap(mean - level / 2.0), wrap(mean + level / 2.0)


def check_phases(phases: FloatArray) -> FloatArray:
    """Return a sample of phases as a flat array of floats.

    Parameters
    ----------
    phases : array_like
        Phases in cycles.

    Returns
    -------
    ndarray, shape (n,)
        The same phases.

    Raises
    ------
    InputError
        If there is none, one is not a finite number, or one is not between -1 and 2: it then is
        no phase in cycles.
    """
    phases = as_numbers(phases, "phases")
    bad = int((~np.isfinite(phases)).sum())
    if len(phases) == 0 or bad:
        found = f"{bad} of {len(phases)} are not finite" if bad else "none was given"
        raise InputError(
            f"phases: {found}; expected at least one finite number of cycles: "
            "leave out what was not measured."
        )
    far = phases[(phases < _LEAST_PHASE) | (phases > _MOST_PHASE)]
    if len(far):
        raise InputError(
            f"phases: {len(far)} of {len(phases)} are far from a cycle, such as {far[0]:g}; "
            "expected cycles from 0 to 1: divide degrees by 360, radians by 2 pi."
        )
    return phases


def check_r(r: float) -> None:
    """Refuse a length that no mean vector can have.

    Parameters
    ----------
    r : float
        What should be a length.

    Raises
    ------
    InputError
        If it is not between 0 and 1.
    """
    if not 0.0 <= r <= 1.0:
        raise InputError(f"r is {r}; expected the length of a mean vector, 0 to 1.")
