"""Cost of calling a pixel background or subject, from its grey value alone.

Pullar 2009, §3.2.1: Eq. 3.4, 3.5, 3.8, 3.9 and Fig. 3.4.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from pawnb.arrays import AnyArray, Float32Array, IntArray
from pawnb.core.compiled import compiled
from pawnb.errors import InputError


class EmptyScene(Protocol):
    """The empty scene: grey values and their standard deviation, shape (H, W)."""

    @property
    def mean(self) -> AnyArray:
        """Mean grey value of every pixel."""

    @property
    def sd(self) -> AnyArray:
        """Its standard deviation."""


def background_cost(
    picture: AnyArray, background: EmptyScene, *, sd_floor_grey: float
) -> Float32Array:
    """Return the cost of calling each pixel background.

    Parameters
    ----------
    picture : ndarray, shape (H, W)
        Grey values.
    background : Background
        The empty scene.
    sd_floor_grey : float
        Least standard deviation of a pixel, grey values.

    Returns
    -------
    ndarray of float32, shape (H, W)
        (y - mean)² / (2 sd²) + log sd: the negative logarithm of the Gaussian of Eq. 3.4, less
        the constant log sqrt(2 pi). The thesis prints Eq. 3.4 without the factor 2 and drops
        log sd, which varies from pixel to pixel.
    """
    grey = np.ascontiguousarray(picture, dtype=np.float32)
    mean = np.ascontiguousarray(background.mean, dtype=np.float32)
    sd = np.ascontiguousarray(background.sd, dtype=np.float32)
    return _gaussian_cost(grey, mean, sd, sd_floor_grey)


def subject_cost(picture: IntArray, *, mean: float, sd: float) -> Float32Array:
    """Return the cost of calling each pixel subject under one Gaussian for the whole subject.

    Parameters
    ----------
    picture : ndarray, shape (H, W)
        Grey values.
    mean, sd : float
        Of the subject's grey values (Eq. 3.8, 3.9).

    Returns
    -------
    ndarray of float32, shape (H, W)
        (y - mean)² / (2 sd²) + log sd, on the scale of :func:`background_cost`.
    """
    away = (np.asarray(picture, dtype=np.float32) - np.float32(mean)) / np.float32(sd)
    return (0.5 * away**2 + np.float32(math.log(sd))).astype(np.float32)


def subject_box(cost: Float32Array, *, box_share: float = 1.0) -> tuple[int, int, int, int]:
    """Return the box of the subject (Fig. 3.4a-c).

    Parameters
    ----------
    cost : ndarray, shape (H, W)
        The background's cost.
    box_share : float
        Rows and columns whose sum exceeds so many times the mean sum hold the subject.

    Returns
    -------
    tuple of int
        u0, v0, u1, v1, half open: from the first to the last row and column that do.

    Raises
    ------
    InputError
        If no row or column does.
    """
    edges = []
    for axis in (0, 1):
        sums = cost.sum(axis=axis, dtype=float)
        over = np.flatnonzero(sums > box_share * sums.mean())
        if not len(over):
            raise InputError(
                "nothing stands out of the background in the start frame; choose a frame that "
                "shows the animal, or lower box_share."
            )
        edges.append((int(over[0]), int(over[-1]) + 1))
    (u0, u1), (v0, v1) = edges
    return u0, v0, u1, v1


def subject_statistics(
    picture: AnyArray, cost: AnyArray, *, box_share: float = 1.0
) -> tuple[float, float, tuple[int, int, int, int]]:
    """Return mean and standard deviation of the subject's grey values, and its box.

    Parameters
    ----------
    picture : ndarray, shape (H, W)
        Grey values.
    cost : ndarray, shape (H, W)
        The background's cost.
    box_share : float
        Threshold of :func:`subject_box`, and, times the mean cost in the box, of a pixel.

    Returns
    -------
    mean, sd : float
        Eq. 3.8 and 3.9, of the pixels in the box whose cost exceeds the threshold (Fig. 3.4d).
    box : tuple of int
        u0, v0, u1, v1.

    Raises
    ------
    InputError
        If fewer than two pixels stand out of the background.
    """
    box = u0, v0, u1, v1 = subject_box(cost, box_share=box_share)
    inside = cost[v0:v1, u0:u1]
    values = picture[v0:v1, u0:u1][inside > box_share * inside.mean(dtype=float)]
    if len(values) < 2:
        raise InputError(
            "fewer than two pixels stand out of the background in the start frame; choose a "
            "frame that shows the animal, or lower box_share."
        )
    # a subject of one grey value still has the noise of rounding
    sd = max(float(values.std(ddof=1, dtype=float)), 1 / math.sqrt(12))
    return float(values.mean(dtype=float)), sd, box


@compiled
def _gaussian_cost(grey: np.ndarray, mean: np.ndarray, sd: np.ndarray, floor: float) -> np.ndarray:
    """Return (y - mean)² / (2 sd²) + log sd of every pixel."""
    out = np.empty_like(grey)
    height, width = grey.shape
    half = np.float32(0.5)
    for v in range(height):
        for u in range(width):
            s = max(sd[v, u], np.float32(floor))
            z = (grey[v, u] - mean[v, u]) / s
            out[v, u] = half * z * z + np.float32(math.log(s))
    return out
