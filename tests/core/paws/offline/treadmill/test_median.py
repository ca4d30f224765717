"""The median of few values against numpy's."""

import numpy as np
import pytest

from pawnb.core.paws.offline.treadmill.median import median


@pytest.mark.parametrize("n", [1, 2, 3, 8, 9])
def test_it_is_the_median_along_the_first_axis(n):
    values = np.random.default_rng(n).normal(size=(n, 3))
    np.testing.assert_array_equal(median(values), np.median(values, axis=0))
    np.testing.assert_array_equal(median(values[:, 0]), np.median(values[:, 0]))
