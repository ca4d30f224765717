"""What the tests of phases share: what is counted, and the result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import check_phases, mean_vector
from pawnb.gait.inference.permutations import bound_note

ONE_ANIMAL = "one animal: nothing can be said of animals"
TINY = float(np.finfo(float).tiny)  # no p is 0
NO_MEAN = "the phases cancel out: no mean exists"
AS_INDEPENDENT = "p as if the phases were independent; give animals= to count animals"


class CircularTest(NamedTuple):
    """Result of a test on phases; as text it says what was counted.

    Attributes
    ----------
    test : str
        Its name.
    statistic : float
        Its statistic, of the kind the function names.
    p : float
        Two-sided unless the function says otherwise; NaN where nothing can be said.
    n : int
        Number of phases given.
    n_animals : int or None
        Number of animals that p counts; None where phases were taken as independent.
    method : str
        How p was found.
    note : str
        What the reader must know, else empty.
    smallest_p : float
        Least p that is possible for these counts, whatever the phases; NaN where any is.
    """

    test: str
    statistic: float
    p: float
    n: int
    n_animals: int | None
    method: str
    note: str = ""
    smallest_p: float = math.nan

    def __str__(self) -> str:
        """Say the result in one line."""
        k = self.n_animals
        who = "animals not counted" if k is None else "1 animal" if k == 1 else f"{k} animals"
        line = (
            f"{self.test}: {self.statistic:.4g}, p = {self.p:.3g} ({self.method}), "
            f"n = {self.n} phases, {who}"
        )
        return f"{line}; {self.note}" if self.note else line


def animal_sample(
    phases: FloatArray, animals: Sequence[object] | None
) -> tuple[FloatArray, int | None]:
    """Return what a test counts: the phases, or one mean phase an animal.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,), or None
        Animal of each phase.

    Returns
    -------
    sample : ndarray
        Phases, or mean phases in the order of the sorted animals. An animal whose phases
        have no mean is left out.
    n_animals : int or None
        Their number; None without animals.

    Raises
    ------
    InputError
        If phases or animals cannot be used.
    """
    phases = check_phases(phases)
    if animals is None:
        return phases, None
    codes, k = animal_codes(animals, len(phases))
    vectors = np.bincount(codes, np.cos(2 * np.pi * phases), k) + 1j * np.bincount(
        codes, np.sin(2 * np.pi * phases), k
    )
    vectors = vectors[np.abs(vectors) / np.bincount(codes, minlength=k) > 1e-12]
    if len(vectors) == 0:
        raise InputError("phases: no animal has a mean phase; each one's phases cancel out.")
    return np.mod(np.angle(vectors) / (2.0 * np.pi), 1.0), len(vectors)


def animal_codes(animals: Sequence[object], n: int) -> tuple[IntArray, int]:
    """Give the animals numbers from 0 in the order of their names.

    Parameters
    ----------
    animals : sequence, shape (n,)
        Animal of each value.
    n : int
        Number of values.

    Returns
    -------
    codes : ndarray of int, shape (n,)
        Number of each value's animal.
    k : int
        How many animals there are.

    Raises
    ------
    InputError
        If there is not one animal a value.
    """
    given = list(animals)
    missing = sum(a is None or a != a for a in given)  # NaN is not equal to itself
    if missing:
        raise InputError(f"animals: {missing} of {len(given)} have no name; expected one each.")
    names = [str(a) for a in given]
    if len(names) != n:
        raise InputError(f"animals: found {len(names)} names for {n} values; expected one a value.")
    found, codes = np.unique(names, return_inverse=True)
    return codes, len(found)


def phase_standard_error(phases: FloatArray) -> float:
    """Compute the standard error of a mean phase from the sines about it, in cycles.

    ``sd(sin) / (sqrt(n) rho)``: the standard deviation of the parts of the unit vectors that
    stand across the mean direction, over the length along it (Fisher 1993, section 4.4,
    with n - 1 in place of n). Fisher's length is r, which is too long for few phases: ``rho² =
    (n r² - 1) / (n - 1)``, whose mean over samples is the square of the population's length.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Two phases or more that have a mean, cycles.

    Returns
    -------
    float
        Cycles; infinite where the phases are as scattered as phases at random (n r² of 1 or
        less).
    """
    mean, r, n = mean_vector(phases)
    square = (n * r**2 - 1.0) / (n - 1)
    if square <= 1e-12:
        return math.inf
    across = np.sin(2.0 * np.pi * (np.asarray(phases) - mean))
    return float(across.std(ddof=1)) / math.sqrt(n * square) / (2.0 * math.pi)


def make_result(
    test: str,
    statistic: float,
    p: float,
    *,
    counts: tuple[int, int | None, str],
    smallest_p: float = math.nan,
    sizes: Sequence[int] = (),
) -> CircularTest:
    """Put a result together; one animal has no p, independent phases have a note.

    Parameters
    ----------
    test : str
        Name of the test.
    statistic, p : float
        What was found.
    counts : tuple of (int, int or None, str)
        Number of phases, number of animals, and how p was found.
    smallest_p : float
        Least p that is possible for these counts; the note says so where it is above 0.05.
    sizes : sequence of int
        Sizes of the groups, where there are several.

    Returns
    -------
    CircularTest
        The result.
    """
    n, n_animals, method = counts
    if n_animals == 1:
        return CircularTest(test, statistic, math.nan, n, 1, method, ONE_ANIMAL)
    counted = " and ".join(str(size) for size in sizes or [n if n_animals is None else n_animals])
    bound = bound_note(smallest_p, f"{counted} {'phases' if n_animals is None else 'animals'}")
    notes = [AS_INDEPENDENT if n_animals is None else "", bound]
    note = "; ".join(filter(None, notes))
    return CircularTest(test, statistic, p, n, n_animals, method, note, smallest_p)
