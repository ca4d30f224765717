"""Interval of the length of a mean vector: how alike phases may be.

The length r of a sample's mean vector is above that of the population it came from, by more the
fewer the phases: two animals at random have an r of 0.64 on average. The interval here is
exact for phases of a von Mises distribution, for any number of them from two.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import hankel1e, ive
from scipy.stats import chi2, norm

from pawnb.errors import InputError
from pawnb.gait.circular.mean import check_r
from pawnb.gait.circular.rayleigh import length_of_kappa, rayleigh_p
from pawnb.gait.inference.checks import check_level

_LONGEST_ESTIMATE = 1.0 - 1e-4
_WIDEST = 1e9  # concentration at which 1 - r is nothing
_MANY_PHASES = 10_000  # phases, of which r is normally distributed

BelowR = Callable[[float], tuple[float, float]]


def length_interval(r: float, n: int, *, level: float = 0.95) -> tuple[float, float]:
    """Compute the interval of the length of the population's mean vector.

    It holds every concentration kappa of a von Mises distribution under which neither a mean
    vector as short as r, nor one as long, is rarer than half of ``1 - level``; each is given
    as its length ``I1(kappa) / I0(kappa)``. The probabilities are exact: see
    :func:`chance_of_length`. With a concentration of 0 they are Rayleigh's p. Nearly equal
    phases (r above 0.9999) and samples of more than 10,000 have their limits, chi² and normal
    (Mardia & Jupp 2000, Directional Statistics, section 4.8).

    Parameters
    ----------
    r : float
        Length of the sample's mean vector, 0 to 1.
    n : int
        Number of phases (animals, where each counts once).
    level : float
        Level of the interval.

    Returns
    -------
    low, high : float
        Ends, 0 to 1. Both NaN for fewer than two phases. Both 0 where r is so short that even
        phases at random would rarely give it.

    Raises
    ------
    InputError
        If r or level is out of range.
    """
    check_r(r)
    check_level(level)
    if n < 2:
        return math.nan, math.nan
    tail = (1.0 - level) / 2.0
    if r > _LONGEST_ESTIMATE:
        return _concentrated_interval(r, n, tail)
    if n > _MANY_PHASES:
        kappa = kappa_of_length(r)
        spread = (1.0 - r**2 - r / kappa) / n if r > 1e-6 else 0.5 / n
        half = float(norm.isf(tail)) * math.sqrt(spread)
        return max(r - half, 0.0), min(r + half, 1.0)
    random = rayleigh_p(n, r)
    chance = _chances(r, n)
    low = high = 0.0
    if random < tail:
        low = float(length_of_kappa(_solve(lambda kappa: chance(kappa)[1] - tail)))
    if 1.0 - random > tail:
        high = float(length_of_kappa(_solve(lambda kappa: tail - chance(kappa)[0])))
    return low, high


def _concentrated_interval(r: float, n: int, tail: float) -> tuple[float, float]:
    """Return the interval of nearly equal phases, where n (1 - r) / (1 - length) is chi²."""
    low, high = n * (1.0 - r) / chi2.ppf((tail, 1.0 - tail), n - 1)
    return max(1.0 - float(low), 0.0), 1.0 - float(high)


def chance_of_length(r: float, n: int, kappa: float) -> tuple[float, float]:
    """Compute how often the mean vector of n von Mises phases is as short, and as long, as r.

    The resultant R of von Mises phases has the density ``I0(kappa R) / I0(kappa)^n h(R)``, with
    h that of phases at random (Mardia & Jupp 2000, Directional Statistics, section 4.5.2),
    which is Kluyver's integral of ``R t J0(R t) J0(t)^n``. Its integral from 0 to R over R is
    Lommel's, and there remains

        P = R / I0(kappa)^n * integral of t J0(t)^n (t I0(kappa R) J1(t R)
            + kappa I1(kappa R) J0(t R)) / (kappa² + t²) dt,   t from 0 to infinity.

    It is taken along a line parallel to the real axis through its saddle point, as in
    :func:`pawnb.gait.circular.resultant_p`, where nothing is lost to cancellation; a line
    above the pole at ``i kappa`` gives the other tail. Two phases have an integral of their own.

    Parameters
    ----------
    r : float
        Length of the mean vector, above 0 and below 1.
    n : int
        Number of phases, 2 or more.
    kappa : float
        Concentration, above 0.

    Returns
    -------
    below, above : float
        P(length at most r) and P(length above r).

    Raises
    ------
    InputError
        If a number is out of range.
    """
    if n < 2 or not 0.0 < r < 1.0 or not 0.0 < kappa < math.inf:
        raise InputError(
            f"r is {r}, n {n}, kappa {kappa}; expected r between 0 and 1, two phases or more and "
            "a concentration above 0."
        )
    return _chances(r, n)(kappa)


@functools.lru_cache(maxsize=8)
def _chances(r: float, n: int) -> BelowR:
    """Return the function of kappa; see :func:`chance_of_length`."""
    if n == 2:
        return lambda kappa: _chances_of_two(r, kappa)
    total = n * r
    middle = max(kappa_of_length(r), n**-0.5)  # the saddle point, or near it
    step = min(middle / 8.0, math.sqrt(2.0 / n) * max(1.0, 0.7 * middle) / 2.0)
    paths: dict[float, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def chance(kappa: float) -> tuple[float, float]:
        height = middle
        if abs(kappa - middle) < 3.0 * step:  # away from the pole
            height += math.copysign(3.0 * step, middle - kappa)
        if height not in paths:
            paths[height] = _path(n, total, height, step)
        t, first, second = paths[height]
        values = first * ive(0, kappa * total) + second * kappa * ive(1, kappa * total)
        values = (values / (kappa**2 + t**2)).real
        growth = (n - total) * (height - kappa) + n * math.log(ive(0, height) / ive(0, kappa))
        integral = step * float(2.0 * values.sum() - values[0])
        found = total / 2.0 * integral * math.exp(growth)
        below, above = (found, 1.0 - found) if kappa > height else (1.0 + found, -found)
        return min(max(below, 0.0), 1.0), min(max(above, 0.0), 1.0)

    return chance


def _path(
    n: int, total: float, height: float, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a line of integration, and what of the integrand does not depend on kappa."""
    # beyond the peak the integrand falls at least as (height / u)^((n + 1) / 2)
    reach = height * min(1000.0, 10.0 ** (14.0 / (n + 1))) + 24.0 * step
    t = step * np.arange(math.ceil(reach / step)) + 1j * height
    # without its size where t is i height, which is put back with that of kappa
    common = np.exp(n * np.log(ive(0, -1j * t) / ive(0, height)) + 1j * total * t.real) * t
    return t, common * t * hankel1e(1, total * t), common * hankel1e(0, total * t)


def _chances_of_two(r: float, kappa: float) -> tuple[float, float]:
    """Integrate over half the angle between two phases, whose cosine is r."""
    angle = math.acos(r)

    def integral(low: float, high: float) -> float:
        nodes, weights = np.polynomial.legendre.leggauss(60)
        x = (low + high) / 2.0 + (high - low) / 2.0 * nodes
        c = np.cos(x)
        values = ive(0, 2.0 * kappa * c) * np.exp(2.0 * kappa * (c - 1.0))
        return float(weights @ values) * (high - low) / 2.0

    # beyond this nothing is left of the integrand
    far = 12.0 / math.sqrt(kappa)
    scale = 2.0 / math.pi / float(ive(0, kappa)) ** 2
    above = scale * integral(0.0, min(angle, far))
    below = scale * integral(angle, min(math.pi / 2.0, angle + far))
    return min(below, 1.0), min(above, 1.0)


def kappa_of_length(r: float) -> float:
    """Return the concentration of the von Mises distribution with a mean vector of a length.

    Parameters
    ----------
    r : float
        Length, 0 to below 1.

    Returns
    -------
    float
        kappa, that solves ``I1(kappa) / I0(kappa) = r``.
    """
    return float(brentq(lambda kappa: float(length_of_kappa(kappa)) - r, 0.0, 2.0 / (1.0 - r)))


def _solve(excess: Callable[[float], float]) -> float:
    """Find the concentration at which a function that rises with it is 0."""
    high = 1.0
    while excess(high) < 0.0 and high < _WIDEST:
        high *= 4.0
    low = high / 4.0
    while excess(low) > 0.0 and low > 1e-6:
        low /= 4.0
    return float(brentq(excess, low, high, rtol=1e-7)) if low > 1e-6 else 0.0
