"""Marked parts of a picture: masks about positions, widened, and grown from seeds."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import BoolArray, FloatArray


def disk_mask(shape: tuple[int, ...], uv: FloatArray, reach: int) -> BoolArray:
    """Mark the pixels within ``reach`` of some positions.

    Parameters
    ----------
    shape : tuple of int
        Of the picture.
    uv : ndarray, shape (n, 2)
        Positions, px.
    reach : int
        Radius, px.

    Returns
    -------
    ndarray of bool, shape (h, w)
        True within that radius.
    """
    mark = np.zeros(shape[:2], bool)
    for u, v in np.round(np.atleast_2d(uv)).astype(int):
        mark[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1] = True
    return mark


def dilate(mask: BoolArray) -> BoolArray:
    """Widen a mask by two pixels: edges of a paw are neither paw nor surroundings."""
    return cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0


def region_grow(mask: BoolArray, seed: BoolArray) -> BoolArray:
    """Return the connected parts of a mask that touch a seed."""
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    touched = np.unique(labels[seed & mask])
    return np.isin(labels, touched[touched > 0])
