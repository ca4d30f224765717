"""Fine steps of colour, for paws that have nearly the colour of what they stand on.

The usual bins are 8 levels of red, green and blue wide. A paw on a belt as brown as it is
differs by less, in how red and how yellow it is, and two such colours share a bin. Here a
picture is turned into three numbers a pixel: brightness in steps of four levels, and how much
red exceeds green and blue their mean in steps of two. Thirty-two steps of each then reach only
as far as colours like the paws': all that is farther counts as the last step.
"""

from __future__ import annotations

import cv2
import numpy as np

_BRIGHTER, _REDDER, _BLUER = (0.30, 0.59, 0.11), (1.0, -1.0, 0.0), (-0.5, -0.5, 1.0)
_STEPS = (2.0, 4.0, 4.0)
"""How much finer than 8 levels the steps of each are."""
_MIDDLE = 127.5
_NOISE = (16.0, 8.0, 8.0)
"""What a colour varies by at least, in what :func:`in_shades` returns: noise of 8 levels of
brightness and 2 of colour."""
_SMOOTH_PX = 0.9
"""Noise is as large as these steps: pictures are smoothed a little more than for the usual ones."""


def shades_about(colours: np.ndarray) -> np.ndarray:
    """Return what turns a colour into fine steps about the middle of some colours.

    Parameters
    ----------
    colours : ndarray, shape (n, 3)
        Red, green and blue of the paws.

    Returns
    -------
    ndarray, shape (3, 4), float32
        Weights of red, green and blue, and what is added.
    """
    weights = np.array([_BRIGHTER, _REDDER, _BLUER]) * np.array(_STEPS)[:, None]
    middle = np.median(colours, axis=0)
    return np.column_stack([weights, _MIDDLE - weights @ middle]).astype(np.float32)


def smooth_shades(pixels: np.ndarray) -> np.ndarray:
    """Return a picture (h, w, 3), uint8, without the noise of single pixels."""
    return np.asarray(cv2.GaussianBlur(pixels, (5, 5), _SMOOTH_PX))


def in_shades(pixels: np.ndarray, shades: np.ndarray) -> np.ndarray:
    """Return a picture (h, w, 3), uint8, in fine steps: 8 levels are one step."""
    return np.asarray(cv2.transform(pixels, shades))


def shades_floor() -> np.ndarray:
    """Return the least covariance (3, 3) of a colour in fine steps."""
    return np.diag(_NOISE) ** 2
