"""Sorting and medians of compiled loops give what NumPy gives."""

import numpy as np
import pytest

from pawnb.core.sorting_kernels import ascending, median, nth

SIZES = [1, 2, 3, 4, 7, 16, 33, 100]


@pytest.mark.parametrize("n", SIZES)
def test_equal_values_stay_in_their_order(n):
    values = np.random.default_rng(n).integers(0, 5, n).astype(float)
    np.testing.assert_array_equal(ascending(values), np.argsort(values, kind="stable"))
    values[n // 2 :] = np.inf
    np.testing.assert_array_equal(ascending(values), np.argsort(values, kind="stable"))


@pytest.mark.parametrize("n", SIZES)
def test_medians_and_order_statistics(n):
    values = np.random.default_rng(n).normal(size=n)
    assert median(values.copy()) == np.median(values)
    for k in range(n):
        assert nth(values.copy(), k) == np.sort(values)[k]


def test_nothing_is_in_order():
    assert len(ascending(np.empty(0))) == 0
