"""Animals, not strides: means and slopes with intervals that count animals.

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

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.describe import difference
from pawnb.gait.circular.mean import mean_vector
from pawnb.gait.inference.checks import NOTHING_VARIES, check_level, check_values, is_rounding
from pawnb.gait.inference.circular_sample import ONE_ANIMAL, TINY, animal_codes
from pawnb.gait.inference.linear_fit import t_quantile
from pawnb.schema.arguments import checked_arguments


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


@checked_arguments
def mean_of_animals(
    values: FloatArray,
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


@checked_arguments
def estimate_of(
    units: FloatArray, *, n: int, expected: float | None = None, level: float = 0.95, note: str = ""
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
    if is_rounding(error, units):
        note = f"{NOTHING_VARIES}; {note}" if note else NOTHING_VARIES
        return AnimalEstimate(mean, math.nan, math.nan, 0.0, math.nan, n, k, level, "none", note)
    half = t_quantile(level, k - 1) * error
    p = math.nan
    if expected is not None:
        p = max(float(2.0 * student.sf(abs(mean - expected) / error, k - 1)), TINY)
    method = f"t of animals' values, {k - 1} df"
    return AnimalEstimate(mean, mean - half, mean + half, sd, p, n, k, level, method, note)


@checked_arguments
def slope_of_animals(
    x: FloatArray,
    y: FloatArray,
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


@checked_arguments
def slopes_by_animal(
    x: FloatArray, y: FloatArray, animals: Sequence[object], *, circular: bool = False
) -> tuple[FloatArray, str]:
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
