"""Circular statistics of phases: mean, spread, interval of the mean.

Phases are in cycles; 0.98 and 0.02 are near each other. NaN is refused: a phase that
could not be measured does not belong in a sample. :mod:`pawnb.gait.circular.rayleigh` has
Rayleigh's p. More description is in
:mod:`pawnb.gait.circular.describe`, tests are in :mod:`pawnb.gait.circular.tests`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from pawnb.arrays import AnyArray, FloatArray
from pawnb.errors import InputError
from pawnb.gait.inference.checks import as_numbers, check_level
from pawnb.schema.arguments import checked_arguments

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


def mean_vector(phases: FloatArray, *, weights: AnyArray | None = None) -> MeanVector:
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


@checked_arguments
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


@checked_arguments
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
