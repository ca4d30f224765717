"""A frame blurred for the coarse steps of a fit, and parts of it."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence

SQRT5 = float(np.sqrt(5.0))
"""Mathematics: half width of a parabolic kernel, in its standard deviations."""


def blurred(image_evidence: ImageEvidence, half_width: float) -> ImageEvidence:
    """Return evidence blurred by a Gaussian as wide as a parabolic kernel of that half width."""
    sd = half_width / SQRT5
    return image_evidence._replace(seen=cv2.GaussianBlur(image_evidence.seen, (0, 0), sd))


def part_of(image_evidence: ImageEvidence, low: FloatArray, high: FloatArray) -> ImageEvidence:
    """Return the part of the evidence between two places, working px, as far as it has it.

    Parameters
    ----------
    image_evidence : ImageEvidence
        What a frame shows.
    low, high : ndarray, shape (2,)
        Two opposite corners (u, v), working px.

    Returns
    -------
    ImageEvidence
        The part.
    """
    height, width = image_evidence.seen.shape
    first = np.floor(low - image_evidence.box).astype(int)
    last = np.ceil(high - image_evidence.box).astype(int)
    u0, v0 = (int(x) for x in np.clip(first, 0, (width - 2, height - 2)))
    u1, v1 = max(u0 + 2, min(int(last[0]), width)), max(v0 + 2, min(int(last[1]), height))
    return ImageEvidence(
        np.ascontiguousarray(image_evidence.seen[v0:v1, u0:u1]),
        np.ascontiguousarray(image_evidence.weight[v0:v1, u0:u1]),
        image_evidence.box + np.array([float(u0), float(v0)]),
    )
