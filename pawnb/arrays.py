"""Names for the arrays that travel: what their numbers are and, of points, what the last axis is.

``np.ndarray`` alone stands in compiled loops and inside of modules.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "AnyArray",
    "BoolArray",
    "ByteArray",
    "Float32Array",
    "FloatArray",
    "IntArray",
    "Points2D",
    "Points3D",
]

AnyArray: TypeAlias = NDArray[Any]
"""Numbers of whatever kind is given: they are converted, or handed on as they are."""

FloatArray: TypeAlias = NDArray[np.float64]
"""Numbers; NaN where there is none."""

Float32Array: TypeAlias = NDArray[np.float32]
"""Numbers of half the size, where there are many: pictures, features, optical flow."""

BoolArray: TypeAlias = NDArray[np.bool_]
"""Yes or no: masks, and which of many."""

IntArray: TypeAlias = NDArray[np.integer[Any]]
"""Whole numbers: frames, rows, counts."""

ByteArray: TypeAlias = NDArray[np.uint8]
"""Grey levels or colours, 0 to 255."""

Points2D: TypeAlias = FloatArray
"""Points in a picture: the last axis is (u, v), px."""

Points3D: TypeAlias = FloatArray
"""Points in space: the last axis is (x, y, z), in the unit of the calibration."""
