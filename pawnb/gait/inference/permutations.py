"""Random permutations in blocks, and what few values allow at most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pawnb.arrays import IntArray

_BLOCK_OF_VALUES = 4_000_000
"""Numbers in one block of permutations: 32 MB."""


def shuffle_in_blocks(
    items: IntArray, count: int, *, seed: int | Sequence[int]
) -> Iterator[IntArray]:
    """Shuffle items many times, without holding more than a block of the results at once.

    Parameters
    ----------
    items : ndarray, shape (n,)
        What is shuffled.
    count : int
        Number of permutations.
    seed : int or sequence of int
        Seed.

    Yields
    ------
    ndarray, shape (m, n)
        Permutations, a row each; the same whatever the size of the blocks.
    """
    rng = np.random.default_rng(seed)
    rows = max(1, _BLOCK_OF_VALUES // max(len(items), 1))
    for done in range(0, count, rows):
        yield rng.permuted(np.tile(items, (min(rows, count - done), 1)), axis=1)


def bound_note(smallest_p: float, counted: str) -> str:
    """Say that a test cannot reject, where it cannot.

    Parameters
    ----------
    smallest_p : float
        Least p that these counts allow.
    counted : str
        What was counted: ``"3 animals"``.

    Returns
    -------
    str
        Empty where p may fall to 0.05 or below.
    """
    if not smallest_p > 0.05:
        return ""
    return f"with {counted} no p below {smallest_p:.2g} is possible"
