"""Names of phase relations of two legs: in-phase, anti-phase, shifted, random."""

from __future__ import annotations

import functools
import math

from scipy.optimize import brentq

from pawnb.gait.circular.mean import check_r
from pawnb.gait.circular.rayleigh import rayleigh_p
from pawnb.gait.inference.circular_length import chance_of_length, kappa_of_length

IN_PHASE, ANTI_PHASE, SHIFTED = "in-phase", "anti-phase", "shifted"
RANDOM, NOT_DETERMINED = "random", "not determined"

NEAR = 0.1
"""Cycles from 0, or from 0.5, within which a mean phase is in-phase, or anti-phase."""

RANDOM_LENGTH = 0.5
"""Phases are random where their mean vector is surely shorter."""

RAYLEIGH_LEVEL = 0.05
_TAIL = 0.025


def name_pattern(mean: float, r: float, n: int) -> str:
    """Name the phase relation of a pair of legs.

    **random**: the interval of r (:func:`pawnb.gait.inference.circular_length.length_interval`, 95
    %) lies below 0.5. **not determined**: it does not, and Rayleigh's p is above 0.05, so there may
    or may not be a preferred phase. Else by the mean: **in-phase** within 0.1 cycle of 0,
    **anti-phase** within 0.1 of 0.5, **shifted** elsewhere. (The paper of 2009, section 3.6, halves
    the cycle at 0.25 and 0.75 instead, and calls random what fails Rayleigh's test, which few
    animals always do unless they are nearly alike.)

    Parameters
    ----------
    mean : float
        Mean phase in cycles; NaN where there is none.
    r : float
        Length of the mean vector.
    n : int
        Number of phases, 2 or more.

    Returns
    -------
    str
        The name.

    Raises
    ------
    InputError
        If r is out of range.
    """
    check_r(r)
    # the interval's upper end is below a length where so short an r is too rare under it; it is
    # never below r itself
    if r == 0.0 or (r < RANDOM_LENGTH and chance_of_length(r, n, _random_kappa())[0] < _TAIL):
        return RANDOM
    if not math.isfinite(mean) or rayleigh_p(n, r) > RAYLEIGH_LEVEL:
        return NOT_DETERMINED
    from_anti = abs(mean % 1.0 - 0.5)
    rounding = 1e-9
    if from_anti <= NEAR + rounding:
        return ANTI_PHASE
    return IN_PHASE if from_anti >= 0.5 - NEAR - rounding else SHIFTED


def say_pattern(pattern: str, r: float, n: int) -> str:
    """Say what the reader must know of a name that was given to animals.

    Parameters
    ----------
    pattern : str
        From :func:`name_pattern`.
    r : float
        Length of the mean vector.
    n : int
        Number of animals.

    Returns
    -------
    str
        For ``not determined``: how alike so many animals must be. The exact Rayleigh test has no
        smallest p: it falls to 0 as the animals' phases become equal. For ``random``: where
        there still is a preference. Else empty.
    """
    p = rayleigh_p(n, r)
    if pattern == NOT_DETERMINED:
        return (
            f"pattern not determined: Rayleigh's p is {p:.2g}; {n} animals reach p "
            f"{RAYLEIGH_LEVEL} only with an r of {length_needed(n):.3f} or more "
            "(smallest p possible: 0, at r 1)"
        )
    if pattern == RANDOM and p <= RAYLEIGH_LEVEL:
        return f"r is surely below {RANDOM_LENGTH}, but there is a weak preference (p {p:.2g})"
    return ""


@functools.cache
def _random_kappa() -> float:
    """Return the concentration of the longest mean vector that is called random."""
    return kappa_of_length(RANDOM_LENGTH)


@functools.cache
def length_needed(n: int) -> float:
    """Return the shortest mean vector of n phases that has a Rayleigh's p of 0.05.

    Parameters
    ----------
    n : int
        Number of phases, 2 or more.

    Returns
    -------
    float
        Its length r.
    """
    return float(brentq(lambda r: rayleigh_p(n, r) - RAYLEIGH_LEVEL, 1e-3, 1.0 - 1e-9))
