"""Second-order tests: samples whose members are mean vectors, one an animal.

A mean vector has a direction (the animal's mean phase) and a length (how alike its phases
are). Rayleigh's test of the directions alone
(:func:`pawnb.gait.circular.tests.rayleigh_test` with ``animals=``) ignores the lengths; the
tests here use them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import rankdata

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import MeanVector, check_phases, wrap
from pawnb.gait.circular.rayleigh import resultant_p
from pawnb.gait.inference.checks import as_numbers
from pawnb.gait.inference.circular_sample import ONE_ANIMAL, TINY, CircularTest, animal_codes
from pawnb.schema.arguments import checked_arguments


class AnimalVectors(NamedTuple):
    """Mean vector of each animal.

    Attributes
    ----------
    animals : tuple of str
        Names, sorted.
    means : ndarray, shape (k,)
        Mean phases, cycles in [0, 1); NaN where an animal's phases cancel out.
    lengths : ndarray, shape (k,)
        Lengths r of the mean vectors.
    n : ndarray of int, shape (k,)
        Number of phases.
    """

    animals: tuple[str, ...]
    means: np.ndarray
    lengths: np.ndarray
    n: np.ndarray


@checked_arguments
def animal_vectors(phases: FloatArray, animals: Sequence[object]) -> AnimalVectors:
    """Compute the mean vector of each animal.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.
    animals : sequence, shape (n,)
        Animal of each phase.

    Returns
    -------
    AnimalVectors
        Names, mean phases, lengths and numbers of phases.

    Raises
    ------
    InputError
        If phases or animals cannot be used.
    """
    phases = check_phases(phases)
    codes, k = animal_codes(animals, len(phases))
    n = np.bincount(codes, minlength=k)
    x = np.bincount(codes, np.cos(2.0 * np.pi * phases), k) / n
    y = np.bincount(codes, np.sin(2.0 * np.pi * phases), k) / n
    lengths = np.minimum(np.hypot(x, y), 1.0)
    means = np.where(lengths > 1e-12, np.mod(np.arctan2(y, x) / (2.0 * np.pi), 1.0), np.nan)
    return AnimalVectors(tuple(sorted({str(a) for a in animals})), means, lengths, n)


@checked_arguments
def mean_of_means(means: FloatArray, lengths: FloatArray) -> MeanVector:
    """Compute the mean of mean vectors (Zar 2010, section 26.9, Example 26.8).

    Parameters
    ----------
    means : ndarray, shape (k,)
        Mean phase of each animal, cycles.
    lengths : ndarray, shape (k,)
        Length of each mean vector.

    Returns
    -------
    MeanVector
        Direction (cycles), length, and the number of vectors. NaN where the vectors
        cancel out.

    Raises
    ------
    InputError
        If the vectors cannot be used.
    """
    x, y = _components(means, lengths)
    r = math.hypot(float(x.mean()), float(y.mean()))
    if r < 1e-12:
        return MeanVector(math.nan, 0.0, len(x))
    return MeanVector(wrap(math.atan2(float(y.mean()), float(x.mean())) / (2 * math.pi)), r, len(x))


@checked_arguments
def hotelling_test(
    means: FloatArray,
    lengths: FloatArray,
    *,
    method: str = "rotation",
    n_rotations: int = 9_999,
    seed: int = 0,
) -> CircularTest:
    """Test whether mean vectors have a common direction (Zar 2010, section 27.7).

    Hotelling's one-sample test of the vectors' ends against the origin. The book holds F
    against its distribution with 2 and k - 2 degrees of freedom (``"f"``), which takes the
    ends to be normally distributed. Ends of regular animals whose phases differ at random
    lie on a circle instead, and with 5 animals 11 % of such studies then come out below
    p = 0.05. ``"rotation"`` counts how often F is as large when every vector is turned
    at random, and holds its level.

    Parameters
    ----------
    means : ndarray, shape (k,)
        Mean phase of each animal, cycles.
    lengths : ndarray, shape (k,)
        Length of each mean vector.
    method : {"rotation", "f"}
        How p is found.
    n_rotations, seed : int
        Number and seed of the random rotations.

    Returns
    -------
    CircularTest
        ``statistic`` is F; p NaN, with a note, for fewer than 3 animals or vectors on a line.

    Raises
    ------
    InputError
        If the vectors cannot be used or the method is unknown.
    """
    if method not in ("rotation", "f"):
        raise InputError(f"method is {method!r}; expected 'rotation' or 'f'.")
    x, y = _components(means, lengths)
    k = len(x)
    f = float(_hotelling_f(x[None, :], y[None, :])[0]) if k > 2 else math.nan
    if not math.isfinite(f):
        note = ONE_ANIMAL if k == 1 else "fewer than 3 animals, or vectors on a line: no test"
        return CircularTest("Hotelling F", math.nan, math.nan, k, k, "none", note)
    if method == "f":
        p, how = max(float(fisher.sf(f, 2, k - 2)), TINY), f"F, 2 and {k - 2} df"
    else:
        turned = np.random.default_rng(seed).random((n_rotations, k)) * 2.0 * np.pi
        length = np.hypot(x, y)
        random = _hotelling_f(length * np.cos(turned), length * np.sin(turned))
        p = (1.0 + float((random >= f).sum())) / (1.0 + n_rotations)
        how = f"{n_rotations} random rotations"
    return CircularTest("Hotelling F", f, p, k, k, how)


def _hotelling_f(x: FloatArray, y: FloatArray) -> FloatArray:
    """Compute Hotelling's F of ends in rows; NaN where they lie on a line."""
    k = x.shape[1]
    xb, yb = x.mean(axis=1), y.mean(axis=1)
    dx, dy = x - xb[:, None], y - yb[:, None]
    sxx, syy, sxy = (dx**2).sum(axis=1), (dy**2).sum(axis=1), (dx * dy).sum(axis=1)
    spread = sxx * syy - sxy**2
    flat = spread <= 1e-12 * (x**2 + y**2).sum(axis=1) ** 2
    above = xb**2 * syy - 2.0 * xb * yb * sxy + yb**2 * sxx
    return np.where(flat, np.nan, k * (k - 2) / 2.0 * above / np.where(flat, 1.0, spread))


@checked_arguments
def moore_test(means: FloatArray, lengths: FloatArray) -> CircularTest:
    """Test whether mean vectors have a common direction, by ranks (Moore 1980; Zar 2010, 27.8).

    Lengths are replaced by their ranks, ``R' = |sum of rank times unit vector| / k^1.5``. p is
    exact, from the distribution of the resultant of vectors of those lengths in random
    directions (:func:`pawnb.gait.circular.resultant_p`); Zar's table and Monte Carlo agree.
    It needs no shape of distribution; under random phases of animals it is exact. Ranks are
    true ranks, ties averaged (a public MATLAB port uses the order of sorting instead).

    Parameters
    ----------
    means : ndarray, shape (k,)
        Mean phase of each animal, cycles.
    lengths : ndarray, shape (k,)
        Length of each mean vector.

    Returns
    -------
    CircularTest
        ``statistic`` is R'; p NaN, with a note, for one animal.

    Raises
    ------
    InputError
        If the vectors cannot be used.
    """
    x, y = _components(means, lengths)
    k = len(x)
    if k == 1:
        return CircularTest("Moore R'", math.nan, math.nan, 1, 1, "none", ONE_ANIMAL)
    if not np.hypot(x, y).all():
        raise InputError("a mean vector of length 0 has no direction; leave that animal out.")
    ranks = rankdata(np.round(np.hypot(x, y), 12))
    angles = np.arctan2(y, x)
    total = abs(complex((ranks * np.exp(1j * angles)).sum()))
    p = resultant_p(ranks, min(total, float(ranks.sum())))
    return CircularTest("Moore R'", total / k**1.5, p, k, k, "exact")


def _components(means: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the vectors; refuse lengths that no mean vector can have."""
    means, lengths = check_phases(means), as_numbers(lengths, "lengths")
    if len(means) != len(lengths) or not ((lengths >= 0.0) & (lengths <= 1.0)).all():
        raise InputError(
            f"lengths: expected {len(means)} numbers from 0 to 1, the length of each mean vector."
        )
    return lengths * np.cos(2.0 * np.pi * means), lengths * np.sin(2.0 * np.pi * means)
