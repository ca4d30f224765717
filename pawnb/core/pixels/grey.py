"""Grey values of pixels, for everything that looks at brightness alone."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import AnyArray, ByteArray

_LUMA = np.array([0.299, 0.587, 0.114])
"""Shares of red, green and blue (ITU-R BT.601)."""

_TINT = 8
"""Channels of a grey picture saved in colour differ by no more than this: a compressed film has its
two colour differences one or two steps off, which is 8 (mathematics). Measured: 5 and 6 in real
grey films (one mouse from below, four cameras about a cage), from 45 in those in colour."""


def has_colour(pixels: ByteArray) -> bool:
    """Tell whether any pixel is coloured: grey recordings are often stored as colour video.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3) or (H, W)
        The pixels.

    Returns
    -------
    bool
        Whether channels differ by more than rounding; hue is nothing but noise where not.
    """
    if pixels.ndim == 2:
        return False
    red, green, blue = cv2.split(pixels)
    most, least = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    return int(cv2.subtract(most, least).max()) > _TINT


def grey(pixels: AnyArray, dtype: type[np.floating] = np.float32) -> AnyArray:
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
