"""Sorting and medians for compiled loops: numba's own take longer to compile than to run."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def nth(values: np.ndarray, n: int) -> float:
    """Return the value that would come at place ``n`` if they were sorted; they are moved about.

    Hoare 1961, Commun. ACM 4: 321-322.
    """
    low, high = 0, len(values) - 1
    while low < high:
        middle = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < middle:
                i += 1
            while middle < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if n <= j:
            high = j
        elif n >= i:
            low = i
        else:
            break
    return values[n]


@compiled
def median(values: np.ndarray) -> float:
    """Return the median of some values, at least one; they are moved about."""
    n = len(values)
    upper = nth(values, n // 2)
    if n % 2:
        return upper
    return (nth(values, n // 2 - 1) + upper) / 2


@compiled
def ascending(values: np.ndarray) -> np.ndarray:
    """Return the order (n,) that sorts values (n,), equal ones as they come: by merging."""
    n = len(values)
    order, other = np.arange(n), np.empty(n, np.int64)
    width = 1
    while width < n:
        for low in range(0, n, 2 * width):
            middle, high = min(low + width, n), min(low + 2 * width, n)
            i, j = low, middle
            for k in range(low, high):
                if i < middle and (j >= high or not values[order[j]] < values[order[i]]):
                    other[k] = order[i]
                    i += 1
                else:
                    other[k] = order[j]
                    j += 1
        order, other = other, order
        width *= 2
    return order
