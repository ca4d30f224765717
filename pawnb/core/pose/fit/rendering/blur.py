"""A frame blurred for the coarse steps of a fit, and parts of it."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.core.pose.fit.rendering.gauss_newton_kernels import Sight


def blurred(sight: Sight, half_width: float) -> Sight:
    """Return the sight blurred by a Gaussian as wide as a parabolic kernel of that half width."""
    sd = half_width / np.sqrt(5.0)
    return sight._replace(seen=cv2.GaussianBlur(sight.seen, (0, 0), sd))


def part_of(sight: Sight, low: np.ndarray, high: np.ndarray) -> Sight:
    """Return the part of a sight between two places, working px, as far as it has it.

    Parameters
    ----------
    sight : Sight
        What a frame shows.
    low, high : ndarray, shape (2,)
        Two opposite corners (u, v), working px.

    Returns
    -------
    Sight
        The part.
    """
    height, width = sight.seen.shape
    first = np.floor(low - sight.box).astype(int)
    last = np.ceil(high - sight.box).astype(int)
    u0, v0 = (int(x) for x in np.clip(first, 0, (width - 2, height - 2)))
    u1, v1 = max(u0 + 2, min(int(last[0]), width)), max(v0 + 2, min(int(last[1]), height))
    return Sight(
        np.ascontiguousarray(sight.seen[v0:v1, u0:u1]),
        np.ascontiguousarray(sight.weight[v0:v1, u0:u1]),
        sight.box + np.array([float(u0), float(v0)]),
    )
