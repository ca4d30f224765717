"""Compiled functions give what Python gives, also where compiled code cannot be kept."""

import numba
import pytest

from pawnb.core.compiled import compiled


def total_of_squares(n):
    total = 0
    for i in range(n + 1):
        total += i * i
    return total


@pytest.mark.parametrize("kept", [True, False])
def test_it_computes_what_python_does(monkeypatch, kept):
    njit = numba.njit

    def cannot_keep(**options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return njit(**options)

    if not kept:
        monkeypatch.setattr(numba, "njit", cannot_keep)
    fast = compiled(total_of_squares)
    # n (n + 1) (2 n + 1) / 6
    assert fast(10) == 385
    assert fast.signatures, "it was not compiled"
