"""Compiled functions give what Python gives, also where compiled code cannot be kept."""

import importlib
import math
import sys
import time

import numba
import numpy as np
import pytest

from pawnb.core.compiled import compiled, compiled_inside, compiled_loosely, time_compiling


def total_of_squares(n):
    total = 0
    for i in range(n + 1):
        total += i * i
    return total


@pytest.mark.parametrize("how", [compiled, compiled_loosely, compiled_inside])
@pytest.mark.parametrize("kept", [True, False])
def test_it_computes_what_python_does(monkeypatch, kept, how):
    njit = numba.njit

    def cannot_keep(**options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return njit(**options)

    if not kept:
        monkeypatch.setattr(numba, "njit", cannot_keep)
    fast = how(total_of_squares)
    # n (n + 1) (2 n + 1) / 6
    assert fast(10) == 385
    assert fast.signatures, "it was not compiled"


MODULE = """
from typing import NamedTuple

from pawnb.core.compiled import compiled


class {name}(NamedTuple):
    a: float
    b: float


@compiled
def total(pair):
    return {said}
"""


def test_code_kept_for_a_type_that_was_renamed_since_is_made_anew(tmp_path, monkeypatch):
    """As after an update: numba finds the old list by the function's name and line."""
    monkeypatch.syspath_prepend(str(tmp_path))
    path = tmp_path / "kept_loops.py"
    for name, said, expected in (("Pair", "pair.a + pair.b", 5.0), ("Two", "pair.a * pair.b", 6.0)):
        path.write_text(MODULE.format(name=name, said=said), encoding="utf-8")
        monkeypatch.delitem(sys.modules, "kept_loops", raising=False)
        importlib.invalidate_caches()
        module = importlib.import_module("kept_loops")
        assert module.total(getattr(module, name)(2.0, 3.0)) == expected
        assert module.total.is_kept
    monkeypatch.delitem(sys.modules, "kept_loops")


def largest_known(values):
    most = -np.inf
    for value in values:
        if not math.isnan(value):
            most = max(most, value)
    return most


def test_loose_sums_still_know_what_is_not_a_number():
    values = np.array([3.0, np.nan, 7.0, -np.inf])
    assert compiled_loosely(largest_known)(values) == 7.0
    assert compiled_loosely(largest_known)(values[1:2]) == -np.inf


def test_compiling_is_timed_and_running_is_not():
    fast = numba.njit(total_of_squares)
    with time_compiling() as seconds:
        assert seconds() == 0.0
        begun = time.perf_counter()
        fast(10)
        took = time.perf_counter() - begun
        # nearly all of the first call is compiling
        compiling = seconds()
        assert 0.5 * took < compiling <= took
        fast(11)
        time.sleep(0.05)
        assert seconds() == compiling
