"""Animals, not strides: means, phases and slopes with intervals that count animals.

Strides are nested in trials in animals. Two strides of one animal are more alike than two of
different animals, so 50 strides of 5 animals say little more about the species than 5 numbers.
Each animal counts once here, whatever its number of strides, and the intervals are made
for few animals. With one animal there is no interval and no p, and a note says so.

Coverage of the 95 % intervals and false positives of the tests are measured by
``benchmarks/interval_coverage.py``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from pawnb.errors import InputError
from pawnb.gait.circular import as_numbers, circular_sd, mean_vector, rayleigh_p, wrap
from pawnb.gait.circular_describe import difference
from pawnb.gait.circular_sample import NO_MEAN, ONE_ANIMAL, TINY, animal_codes, phase_standard_error
from pawnb.gait.lines import t_quantile
from pawnb.gait.second_order import animal_vectors, moore_test

WHOLE_CYCLE = "the animals do not determine a mean phase: any is possible"


class AnimalEstimate(NamedTuple):
    """Mean or slope over animals; as text it says how many.

    Attributes
    ----------
    estimate : float
        Mean of the animals' means or slopes.
    low, high : float
        Interval; NaN with one animal.
    sd : float
        Standard deviation between animals; NaN with one.
    p : float
        Two-sided, against the expected value; NaN with one animal or where none was given.
    n, n_animals : int
        Values, and animals that count.
    level : float
        Level of the interval.
    method : str
        How interval and p were found.
    note : str
        What the reader must know, else empty.
    """

    estimate: float
    low: float
    high: float
    sd: float
    p: float
    n: int
    n_animals: int
    level: float
    method: str
    note: str = ""

    def __str__(self) -> str:
        """Say the estimate in one line."""
        p = "" if math.isnan(self.p) else f", p = {self.p:.3g}"
        animals = f"{self.n_animals} animal" + ("s" if self.n_animals != 1 else "")
        line = (
            f"{self.estimate:.4g} [{self.low:.4g}, {self.high:.4g}]{p} "
            f"({self.method}), n = {animals}, {self.n} values"
        )
        return f"{line}; {self.note}" if self.note else line


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


def mean_of_animals(
    values: np.ndarray,
    animals: Sequence[object],
    *,
    expected: float | None = None,
    level: float = 0.95,
) -> AnimalEstimate:
    """Compute the mean over animals of their means, for instance of the duty factor.

    Student's t interval of the animals' means, with as many degrees of freedom as animals
    less one: exact for normal means, and for 5 animals within a percent for others.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One value a stride.
    animals : sequence, shape (n,)
        Animal of each.
    expected : float, optional
        Value of the null hypothesis, for p.
    level : float
        Level of the interval.

    Returns
    -------
    AnimalEstimate
        Mean, interval, standard deviation between animals, p.

    Raises
    ------
    InputError
        If values are missing or not finite, or animals or level cannot be used.
    """
    values = check_values(values)
    codes, k = animal_codes(animals, len(values))
    means = np.bincount(codes, values, k) / np.bincount(codes, minlength=k)
    return estimate_of(means, n=len(values), expected=expected, level=level)


def estimate_of(
    units: np.ndarray, *, n: int, expected: float | None = None, level: float = 0.95, note: str = ""
) -> AnimalEstimate:
    """Estimate the mean of one number an animal, by Student's t.

    Parameters
    ----------
    units : ndarray, shape (k,)
        One number an animal.
    n : int
        Number of values they came from.
    expected : float, optional
        Value of the null hypothesis, for p.
    level : float
        Level of the interval.
    note : str
        What the reader must know.

    Returns
    -------
    AnimalEstimate
        Mean, interval, standard deviation, p.

    Raises
    ------
    InputError
        If level is not between 0 and 1.
    """
    k = len(units)
    mean = float(units.mean())
    check_level(level)
    if k < 2:
        note = f"{ONE_ANIMAL}; {note}" if note else ONE_ANIMAL
        blank = (math.nan,) * 4
        return AnimalEstimate(mean, *blank, n, k, level, "none", note)
    sd = float(units.std(ddof=1))
    error = sd / math.sqrt(k)
    half = t_quantile(level, k - 1) * error
    p = math.nan
    if expected is not None:
        away = mean - expected
        t = away / error if error > 0.0 else (0.0 if away == 0.0 else math.inf)
        p = max(float(2.0 * student.sf(abs(t), k - 1)), TINY)
    method = f"t of animals' values, {k - 1} df"
    return AnimalEstimate(mean, mean - half, mean + half, sd, p, n, k, level, method, note)


def phase_of_animals(
    phases: np.ndarray, animals: Sequence[object], *, level: float = 0.95
) -> AnimalPhase:
    """Compute the mean phase over animals, with an interval made for few animals.

    Each animal counts by its mean phase, as a unit vector. The interval is that of Student's
    t on the sines of the animals' phases about their mean: half its width is
    ``t(k - 1) sd(sin) / (sqrt(k) r)``. Measured at 5 animals of 10 strides it covers 93-97 %,
    from phases all alike down to an r of 0.45 between animals and within; a plain
    percentile bootstrap covers 82-85 % there. It is blank where it would be the whole
    cycle: in up to 18 % of the most diffuse of these studies. Where animals share even less
    of a direction no interval of a mean phase covers as it should; Rayleigh's p tells.

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
        Ends in [0, 1), in cycles; may wrap. NaN for one animal, or where half the interval
        is half the cycle or more.

    Raises
    ------
    InputError
        If phases or level cannot be used.
    """
    check_level(level)
    mean, _, k = mean_vector(means)
    if k < 2 or not math.isfinite(mean):
        return math.nan, math.nan
    half = t_quantile(level, k - 1) * phase_standard_error(means)
    return (math.nan, math.nan) if half >= 0.5 else (wrap(mean - half), wrap(mean + half))


def slope_of_animals(
    x: np.ndarray,
    y: np.ndarray,
    animals: Sequence[object],
    *,
    circular: bool = False,
    expected: float = 0.0,
    level: float = 0.95,
) -> AnimalEstimate:
    """Compute the mean slope of y on x within animals, for instance of phase on speed.

    A line is fitted to each animal's own values; the slopes are the units of Student's t.
    This holds its level whether or not animals differ in slope and in their range of x; one
    slope pooled over animals does not, with few animals. Differences between animals play
    no part: for those, fit a line to one point an animal.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One pair a stride.
    animals : sequence, shape (n,)
        Animal of each.
    circular : bool
        Whether y is a phase in cycles: its differences from the animal's mean are then taken
        the short way round. For phases within a quarter of a cycle of it or so.
    expected : float
        Slope of the null hypothesis.
    level : float
        Level of the interval.

    Returns
    -------
    AnimalEstimate
        Mean slope. Animals of fewer than 3 values, or with x all the same, are left out; the
        note says how many.

    Raises
    ------
    InputError
        If values are missing, animals or level cannot be used, or no animal has a slope.
    """
    slopes, note = slopes_by_animal(x, y, animals, circular=circular)
    return estimate_of(slopes, n=np.size(x), expected=expected, level=level, note=note)


def slopes_by_animal(
    x: np.ndarray, y: np.ndarray, animals: Sequence[object], *, circular: bool = False
) -> tuple[np.ndarray, str]:
    """Fit a line to each animal's own values; see :func:`slope_of_animals`.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        One pair a stride.
    animals : sequence, shape (n,)
        Animal of each.
    circular : bool
        Whether y is a phase in cycles.

    Returns
    -------
    slopes : ndarray, shape (k,)
        Slope of each animal that has one.
    note : str
        How many have none, or empty.

    Raises
    ------
    InputError
        If values are missing, animals cannot be used, or no animal has a slope.
    """
    x, y = check_values(x), check_values(y)
    if len(x) != len(y):
        raise InputError(f"slope: found {len(x)} values of x and {len(y)} of y; expected pairs.")
    codes, k = animal_codes(animals, len(x))
    slopes = []
    for i in range(k):
        own_x, own_y = x[codes == i], y[codes == i]
        dx = own_x - own_x.mean()
        if len(own_x) < 3 or float(dx @ dx) <= 1e-24 * float(own_x @ own_x):
            continue
        if circular:
            centre = mean_vector(own_y).mean
            if not math.isfinite(centre):
                continue
            own_y = difference(own_y, centre)
        slopes.append(float(dx @ own_y) / float(dx @ dx))
    if not slopes:
        raise InputError(
            "slope: no animal has 3 values with different x; expected some, or fit a line to one "
            "point an animal."
        )
    left = k - len(slopes)
    return np.array(slopes), f"{left} of {k} animals without a slope left out" if left else ""


def check_values(values: np.ndarray) -> np.ndarray:
    """Return numbers as a flat array of floats.

    Parameters
    ----------
    values : array_like
        Numbers.

    Returns
    -------
    ndarray, shape (n,)
        The same numbers.

    Raises
    ------
    InputError
        If there is none, or one is not finite.
    """
    values = as_numbers(values, "values")
    bad = int((~np.isfinite(values)).sum())
    if len(values) == 0 or bad:
        found = f"{bad} of {len(values)} are not finite" if bad else "none was given"
        raise InputError(
            f"values: {found}; expected finite numbers: leave out what was not measured."
        )
    return values


def check_level(level: float) -> None:
    """Refuse a level that no interval can have.

    Parameters
    ----------
    level : float
        What should be a level.

    Raises
    ------
    InputError
        If it is not between 0 and 1.
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"level is {level}; expected between 0 and 1, for instance 0.95.")
