"""Light that changes over a recording: pictures are made as bright as at the clicks.

Lamps warm up, cameras adapt their exposure and their white balance, mains flicker. What is
about the animal is mostly what stands still, and it changes with the light as the paws do:
the mean of the searched part of a picture, by colour, tells how much.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR


def mean_illumination(pixels: ByteArray) -> tuple[float, ...]:
    """Return the mean of each channel of a picture (h, w, 3) or (h, w), uint8."""
    return cv2.mean(pixels)[: 1 if pixels.ndim == 2 else 3]


def normalise_illumination(pixels: ByteArray, illumination: tuple[float, ...] | None) -> ByteArray:
    """Return a picture as it would be in another light.

    Parameters
    ----------
    pixels : ndarray, shape (h, w, 3) or (h, w)
        RGB or grey, uint8.
    illumination : tuple of float, optional
        :func:`mean_illumination` of the same part of the view in that light; None: as it is.

    Returns
    -------
    ndarray, shape as ``pixels``
        Each channel times one factor; ``pixels`` itself where the light is the same.
    """
    if illumination is None:
        return pixels
    gains = [
        min(max(max(then, 1.0) / max(now, 1.0), 1.0 / COLOUR.most_change), COLOUR.most_change)
        for then, now in zip(illumination, mean_illumination(pixels), strict=True)
    ]
    if max(abs(math.log(gain)) for gain in gains) < COLOUR.least_change:
        return pixels
    levels = np.clip(np.arange(256.0)[:, None] * np.array(gains) + 0.5, 0, 255).astype(np.uint8)
    return np.asarray(cv2.LUT(pixels, levels[None] if pixels.ndim == 3 else levels[:, 0]))
