"""Mean phases over animals, with an interval made for few animals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pawnb.gait.checks import check_level
from pawnb.gait.circular import circular_sd, mean_vector, rayleigh_p, wrap
from pawnb.gait.circular_sample import NO_MEAN, ONE_ANIMAL, phase_standard_error
from pawnb.gait.lines import t_quantile
from pawnb.gait.second_order import animal_vectors, moore_test

WHOLE_CYCLE = "the animals do not determine a mean phase: any is possible"


class AnimalPhase(NamedTuple):
    """Mean phase over animals with its interval and tests.

    Attributes
    ----------
    mean : float
        Direction of the mean of the animals' directions, cycles in [0, 1).
    low, high : float
        Interval, cycles; may wrap. NaN with one animal, or where any phase is possible.
    r, circular_sd : float
        How alike the animals' mean phases are: length of the mean of their unit vectors, and
        the standard deviation that follows (cycles).
    rayleigh_z, rayleigh_p : float
        Rayleigh's test of the animals' mean phases, exact.
    moore_r, moore_p : float
        Moore's second-order test, which also uses how alike each animal's phases are.
    n, n_animals : int
        Phases, and animals that count.
    level : float
        Level of the interval.
    note : str
        What the reader must know, else empty.
    """

    mean: float
    low: float
    high: float
    r: float
    circular_sd: float
    rayleigh_z: float
    rayleigh_p: float
    moore_r: float
    moore_p: float
    n: int
    n_animals: int
    level: float
    note: str = ""


def phase_of_animals(
    phases: np.ndarray, animals: Sequence[object], *, level: float = 0.95
) -> AnimalPhase:
    """Compute the mean phase over animals, with an interval made for few animals.

    Each animal counts by its mean phase, as a unit vector. The interval is that of Student's
    t on the sines of the animals' phases about their mean: half its width is
    ``t(k - 1) sd(sin) / (sqrt(k) r)``. It is the whole cycle, and so blank, where half of it is
    half the cycle, or where the animals may well share no direction: where Rayleigh's p of
    their means is above twice 1 - level. Without that, animals that share little of a
    direction show one by chance, with an interval beside the truth. Twice, because of studies
    without any direction the 10 % then pass, and six in ten of these miss: about the 5 % that
    the interval may err.

    Measured over 2000 studies of 5 animals of 10 strides each it holds the truth in 94.5 to
    97.2 %, from phases all alike to a concentration of 0.5 between animals (r 0.24); a plain
    percentile bootstrap has 73-85 %. Blank are 2-18 % of the studies at an r of 0.86 between
    animals, 28-46 % at 0.70, 66-73 % at 0.45 and 83-86 % at 0.24.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,)
        Animal of each.
    level : float
        Level of the interval.

    Returns
    -------
    AnimalPhase
        Mean, interval, spread and tests.

    Raises
    ------
    InputError
        If phases, animals or level cannot be used.
    """
    check_level(level)
    vectors = animal_vectors(phases, animals)
    known = np.isfinite(vectors.means)
    means, lengths = vectors.means[known], vectors.lengths[known]
    n, k = int(vectors.n.sum()), int(known.sum())
    note = "" if known.all() else f"{int((~known).sum())} animals without a mean phase left out"
    if k < 2:
        mean = float(means[0]) if k else math.nan
        notes = "; ".join(part for part in (ONE_ANIMAL if k else NO_MEAN, note) if part)
        return AnimalPhase(mean, *((math.nan,) * 8), n, k, level, notes)
    low, high = interval_of_phases(means, level=level)
    if math.isnan(low):
        note = "; ".join(part for part in (WHOLE_CYCLE, note) if part)
    mean, r, _ = mean_vector(means)
    moore = moore_test(means, lengths)
    return AnimalPhase(
        mean=mean, low=low, high=high, r=r, circular_sd=circular_sd(r),
        rayleigh_z=k * r**2, rayleigh_p=rayleigh_p(k, r),
        moore_r=moore.statistic, moore_p=moore.p, n=n, n_animals=k, level=level, note=note,
    )  # fmt: skip


def interval_of_phases(means: np.ndarray, *, level: float = 0.95) -> tuple[float, float]:
    """Compute the interval of a mean phase from one phase an animal.

    See :func:`phase_of_animals`.

    Parameters
    ----------
    means : ndarray, shape (k,)
        Mean phase of each animal, cycles.
    level : float
        Level of the interval.

    Returns
    -------
    low, high : float
        Ends in [0, 1), in cycles; may wrap. NaN for one animal, and where it is the whole cycle.

    Raises
    ------
    InputError
        If phases or level cannot be used.
    """
    check_level(level)
    mean, r, k = mean_vector(means)
    if k < 2 or not math.isfinite(mean) or rayleigh_p(k, r) > 2.0 * (1.0 - level):
        return math.nan, math.nan
    half = t_quantile(level, k - 1) * phase_standard_error(means)
    return (math.nan, math.nan) if half >= 0.5 else (wrap(mean - half), wrap(mean + half))
