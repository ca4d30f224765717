"""Grey values of pixels, for everything that looks at brightness alone."""

from __future__ import annotations

import numpy as np

_LUMA = np.array([0.299, 0.587, 0.114])
"""Shares of red, green and blue (ITU-R BT.601)."""


def grey(pixels: np.ndarray, dtype: type[np.floating] = np.float32) -> np.ndarray:
    """Return the grey values of RGB or grey pixels.

    Parameters
    ----------
    pixels : ndarray, shape (H, W, 3) or (H, W)
        The pixels.
    dtype : type
        Of the result.

    Returns
    -------
    ndarray, shape (H, W)
        Grey values, in the range of the pixels.
    """
    return (pixels @ _LUMA if pixels.ndim == 3 else pixels).astype(dtype)
