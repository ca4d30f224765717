"""Description of a sample of phases: spreads, median, concentration, moments, classes.

Phases are in cycles. The names of the measures of spread differ from book to book; each
function says which is meant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import (
    MeanVector,
    check_phases,
    check_r,
    circular_sd,
    mean_interval,
    mean_vector,
)
from pawnb.gait.inference.circular_length import kappa_of_length
from pawnb.schema.arguments import checked_arguments


class CircularDescription(NamedTuple):
    """Description of one sample of phases; see :func:`describe_circular`.

    Attributes
    ----------
    n : int
        Size of the sample.
    mean, median : float
        Cycles in [0, 1).
    ci_low, ci_high : float
        Interval of the mean, as if the phases were independent; cycles, may wrap.
    r : float
        Length of the mean vector.
    variance : float
        1 - r, from 0 to 1.
    circular_sd, angular_deviation : float
        Two standard deviations, cycles.
    kappa : float
        Concentration of the von Mises distribution, corrected for small samples.
    """

    n: int
    mean: float
    median: float
    ci_low: float
    ci_high: float
    r: float
    variance: float
    circular_sd: float
    angular_deviation: float
    kappa: float


@checked_arguments
def describe_circular(phases: FloatArray, *, level: float = 0.95) -> CircularDescription:
    """Describe a sample of phases by all the usual numbers.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    level : float
        Confidence level of the interval.

    Returns
    -------
    CircularDescription
        Numbers of the sample. The interval takes the phases to be independent: strides of
        one animal are not; see :func:`pawnb.gait.inference.animal_phases.phase_of_animals`.

    Raises
    ------
    InputError
        If there is no phase, one is not a finite number, or level is out of range.
    """
    mean, r, n = mean_vector(phases)
    low, high = mean_interval(mean, r, n, level=level)
    return CircularDescription(
        n=n,
        mean=mean,
        median=circular_median(phases),
        ci_low=low,
        ci_high=high,
        r=r,
        variance=1.0 - r,
        circular_sd=circular_sd(r),
        angular_deviation=angular_deviation(r),
        kappa=concentration(r, n=n),
    )


@checked_arguments
def angular_deviation(r: float) -> float:
    """Compute the angular deviation ``sqrt(2 (1 - r)) / 2 pi``, in cycles.

    Zar (2010), Eq. 26.20; CircStat's first and astropy's "angular" standard deviation. At
    most 0.225 cycle. Twice the variance 1 - r is what R calls the angular variance. See
    :func:`pawnb.gait.circular.circular_sd` for the other standard deviation, which pawnb
    reports, as the paper of 2009 does.

    Parameters
    ----------
    r : float
        Length of the mean vector, 0 to 1.

    Returns
    -------
    float
        Cycles.

    Raises
    ------
    InputError
        If r is not between 0 and 1.
    """
    check_r(r)
    return math.sqrt(2.0 * (1.0 - r)) / (2.0 * math.pi)


def circular_median(phases: FloatArray) -> float:
    """Compute the median phase: nearest on average to all phases along the circle.

    One of the phases where n is odd, the middle of the two innermost where n is even: Zar
    (2010), section 26.6; CircStat and R agree.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.

    Returns
    -------
    float
        Cycles in [0, 1). NaN where candidates all round the circle are as near, as for
        phases that are evenly spaced.

    Raises
    ------
    InputError
        If there is no phase or one is not a finite number.
    """
    phases = np.sort(np.mod(check_phases(phases), 1.0))
    n = len(phases)
    candidates, first = np.unique(phases, return_index=True)
    # phases up to half a cycle ahead, then those behind, from sums along two turns
    turns = np.concatenate((phases, phases + 1.0))
    sums = np.concatenate(([0.0], np.cumsum(turns)))
    end = np.searchsorted(turns, candidates + 0.5, side="right")
    ahead = sums[end] - sums[first] - (end - first) * candidates
    behind = (first + n - end) * (candidates + 1.0) - (sums[first + n] - sums[end])
    distance = (ahead + behind) / n
    nearest = candidates[distance <= distance.min() + 1e-12]
    middle = mean_vector(nearest)
    return middle.mean if middle.r > 1e-9 else math.nan


@checked_arguments
def concentration(r: float, *, n: int | None = None, method: str = "exact") -> float:
    """Estimate the concentration kappa of a von Mises distribution from r.

    The maximum likelihood estimate solves ``I1(kappa) / I0(kappa) = r``: ``"exact"`` does
    so to rounding; ``"fisher"`` is the approximation of Best and Fisher (1981; Fisher 1993,
    p. 88), up to 2.5 % off, which CircStat, R and astropy use and Watson and Williams' test
    inherits from them. With ``n`` of 15 or fewer the estimate is too large and is corrected
    as Fisher advises, as CircStat and R (``bias=TRUE``) do.

    Parameters
    ----------
    r : float
        Length of the mean vector, 0 to 1.
    n : int, optional
        Size of the sample; without it nothing is corrected.
    method : {"exact", "fisher"}
        Which estimate.

    Returns
    -------
    float
        kappa, 0 for r of 0 and infinite for r of 1.

    Raises
    ------
    InputError
        If r is not between 0 and 1 or the method is unknown.
    """
    check_r(r)
    if method not in ("exact", "fisher"):
        raise InputError(f"method is {method!r}; expected 'exact' or 'fisher'.")
    if r < 1e-9 or r >= 1.0:
        return 0.0 if r < 1.0 else math.inf
    kappa = _fisher_kappa(r) if method == "fisher" else kappa_of_length(r)
    if n is None or n > 15:
        return kappa
    if kappa < 2.0:
        return max(kappa - 2.0 / (n * kappa), 0.0)
    return (n - 1) ** 3 * kappa / (n**3 + n)


def _fisher_kappa(r: float) -> float:
    """Approximate it piecewise."""
    if r < 0.53:
        return 2.0 * r + r**3 + 5.0 * r**5 / 6.0
    if r < 0.85:
        return -0.4 + 1.39 * r + 0.43 / (1.0 - r)
    return 1.0 / (r**3 - 4.0 * r**2 + 3.0 * r)


def circular_moment(phases: FloatArray, order: int) -> MeanVector:
    """Compute a trigonometric moment about zero: the mean vector of ``order`` times the phase.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    order : int
        1 for the mean vector itself.

    Returns
    -------
    MeanVector
        Angle of the moment (cycles, in [0, 1)), its length, and n.

    Raises
    ------
    InputError
        If there is no phase, one is not a finite number, or the order is no whole number of 1
        or more.
    """
    if not isinstance(order, (int, np.integer)) or order < 1:
        raise InputError(f"order is {order!r}; expected a whole number of 1 or more.")
    return mean_vector(np.mod(check_phases(phases) * order, 1.0))


def axial_mean(phases: FloatArray) -> MeanVector:
    """Compute the mean of axial data, whose two ends mean the same (Zar 2010, section 26.7).

    Phases are doubled, averaged, and the mean is halved.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles; p and p + 0.5 are the same axis.

    Returns
    -------
    MeanVector
        Mean in [0, 0.5), the length r of the doubled phases, and n.

    Raises
    ------
    InputError
        If there is no phase or one is not a finite number.
    """
    doubled = circular_moment(phases, 2)
    return doubled._replace(mean=doubled.mean / 2.0)


@checked_arguments
def grouped_mean(
    centres: FloatArray, counts: AnyArray, *, class_width: float | None = None
) -> MeanVector:
    """Compute the mean vector of phases that were counted in classes (Zar 2010, section 26.5).

    Parameters
    ----------
    centres : ndarray, shape (k,)
        Centre of each class, cycles.
    counts : ndarray, shape (k,)
        Number of phases in each class.
    class_width : float, optional
        Width of a class, cycles: r is then corrected for the grouping by
        ``pi w / sin(pi w)`` (Zar's Eq. 26.16).

    Returns
    -------
    MeanVector
        Mean, r, and n, the sum of the counts.

    Raises
    ------
    InputError
        If the numbers do not fit together or the width is not above 0 and below 0.5.
    """
    found = mean_vector(centres, weights=counts)
    r = found.r
    if class_width is not None:
        if not 0.0 < class_width < 0.5:
            raise InputError(f"class_width is {class_width}; expected above 0 and below 0.5 cycle.")
        r = min(1.0, r * math.pi * class_width / math.sin(math.pi * class_width))
    return MeanVector(found.mean, r, round(float(np.sum(counts))))


@checked_arguments
def difference(phases: FloatArray, other: FloatArray | float) -> FloatArray:
    """Compute signed differences of phases, the short way round.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    other : ndarray, shape (n,), or float
        What is taken away.

    Returns
    -------
    ndarray, shape (n,)
        ``phases - other`` in [-0.5, 0.5) cycle.
    """
    return np.mod(np.asarray(phases, dtype=float) - other + 0.5, 1.0) - 0.5
