"""The median of a few numbers, many times."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray


def median(values: FloatArray) -> FloatArray:
    """Return the median along the first axis, which must not be empty.

    What :func:`numpy.median` says, in a tenth of its time where there are few values.
    """
    ordered, n = np.sort(values, axis=0), len(values)
    return np.asarray(0.5 * (ordered[(n - 1) // 2] + ordered[n // 2]))
