"""Permutation of the legs of strides within trials: how large F becomes if legs do not matter."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.gait.inference.permutations import shuffle_in_blocks

_MOST_LEG_ORDERS = 20_000
PERMUTATION_ROUNDING = 1e-9
_LEGS_AT_ONCE = 20_000


class Block(NamedTuple):
    """Strides whose legs may be exchanged: those of one trial.

    Attributes
    ----------
    animal : int
        Number of the animal, from 0.
    legs : ndarray of int, shape (m,)
        Leg of each stride, from 0.
    values : ndarray, shape (m,)
        Value of each stride.
    """

    animal: int
    legs: np.ndarray
    values: np.ndarray


def mean_squares(means: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute the mean squares of legs that are repeated over animals.

    Parameters
    ----------
    means : ndarray, shape (..., animals, legs)
        Mean of each leg of each animal.

    Returns
    -------
    between, error : ndarray, shape (...)
        Mean squares of legs, and of legs by animals.
    """
    k, n = means.shape[-2:]
    of_legs = means.mean(axis=-2)
    whole = of_legs.mean(axis=-1, keepdims=True)
    between = k * ((of_legs - whole) ** 2).sum(axis=-1) / (n - 1)
    rest = means - of_legs[..., None, :] - means.mean(axis=-1, keepdims=True) + whole[..., None]
    return between, (rest**2).sum(axis=(-2, -1)) / ((n - 1) * (k - 1))


def permute_legs(
    blocks: list[Block], n_animals: int, n_legs: int, *, n_permutations: int, seed: int
) -> tuple[float, float, str]:
    """Exchange the legs of strides within every block, and see how large F becomes.

    If legs do not matter, the strides of a trial could have been those of any of its legs. F is
    that of the animals' means, the differences between legs over those that animals do not share:
    so many strides of an animal with one odd leg are no evidence about the others. Of one
    animal it is that of its strides.

    Parameters
    ----------
    blocks : list of Block
        The strides; every animal has every leg.
    n_animals, n_legs : int
        Their numbers.
    n_permutations, seed : int
        Number and seed of random permutations, used where there are more than 20,000
        arrangements.

    Returns
    -------
    p : float
        Share of the arrangements, that of the data among them, whose F is as large or larger.
    smallest_p : float
        Least p that is possible for these counts.
    method : str
        How many arrangements there were.
    """
    counts = np.zeros((n_animals, n_legs))
    for block in blocks:
        np.add.at(counts[block.animal], block.legs, 1.0)

    squares = sum(float(b.values @ b.values) for b in blocks)

    def f(sums: FloatArray) -> FloatArray:
        """Compute F for sums of each block, shape (arrangements, blocks, legs)."""
        whole = np.zeros((len(sums), n_animals, n_legs))
        for i, block in enumerate(blocks):
            whole[:, block.animal] += sums[:, i]
        if n_animals == 1:  # the total is the same for all arrangements
            between = (whole[:, 0] ** 2 / counts[0]).sum(axis=-1)
            mean = whole[0].sum() ** 2 / counts.sum()
            return (between - mean) / np.maximum(squares - between, 1e-24 * squares)
        between, error = mean_squares(whole / counts)
        return between / np.maximum(error, 1e-24 * squares / counts.sum())

    given = np.stack([_leg_sums(b.legs[None, :], b.values, n_legs)[0] for b in blocks])
    observed = float(f(given[None])[0]) * (1.0 - PERMUTATION_ROUNDING)
    number = math.prod(_multinomial(b.legs) for b in blocks)
    if number <= _MOST_LEG_ORDERS:
        every = np.concatenate([f(sums) for sums in _all_sums(blocks, n_legs)])
        least = float((every >= every.max() * (1.0 - PERMUTATION_ROUNDING)).mean())
        return float((every >= observed).mean()), least, "all permutations"
    shuffles = [
        np.concatenate([
            _leg_sums(legs, b.values, n_legs)
            for legs in shuffle_in_blocks(b.legs, n_permutations, seed=[seed, i])
        ])
        for i, b in enumerate(blocks)
    ]  # fmt: skip
    every = f(np.stack(shuffles, axis=1))
    p = (1.0 + float((every >= observed).sum())) / (1.0 + n_permutations)
    return p, 1.0 / (1.0 + n_permutations), f"{n_permutations} permutations"


def _leg_sums(legs: IntArray, values: FloatArray, n_legs: int) -> FloatArray:
    """Return the sum of the values of each leg for rows of legs."""
    cells = legs + n_legs * np.arange(len(legs))[:, None]
    weights = np.broadcast_to(values, legs.shape).ravel()
    sums = np.bincount(cells.ravel(), weights, len(legs) * n_legs)
    return np.asarray(sums.reshape(len(legs), n_legs))


def _multinomial(legs: IntArray) -> int:
    """Return how many arrangements of these legs there are."""
    counts = np.bincount(legs)
    return math.factorial(len(legs)) // math.prod(math.factorial(int(c)) for c in counts)


def _arrangements(counts: list[int]) -> Iterator[list[int]]:
    """Yield every order of as many legs of each number."""
    if not any(counts):
        yield []
    for leg, count in enumerate(counts):
        if count:
            rest = [c - (i == leg) for i, c in enumerate(counts)]
            yield from ([leg, *others] for others in _arrangements(rest))


def _all_sums(blocks: list[Block], n_legs: int) -> Iterator[np.ndarray]:
    """Yield the sums of every arrangement of all blocks together."""
    each = [
        _leg_sums(np.array(list(_arrangements(np.bincount(b.legs).tolist()))), b.values, n_legs)
        for b in blocks
    ]
    choices = itertools.product(*(range(len(sums)) for sums in each))
    while chosen := list(itertools.islice(choices, _LEGS_AT_ONCE)):
        picked = np.array(chosen)
        yield np.stack([sums[picked[:, i]] for i, sums in enumerate(each)], axis=1)
