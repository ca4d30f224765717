"""A place belongs to one point: what others take is closed to each."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from pawnb.arrays import Float32Array
from pawnb.core.paws.offline.association.parameters import LINKS


def open_to_each(
    posteriors: Mapping[int, Float32Array], radius: float, strength: float
) -> dict[int, Float32Array]:
    """Return how far every place is left open to each point by the others.

    Parameters
    ----------
    posteriors : mapping
        Point to the probability of every place (n, h, w).
    radius : float
        Points are not nearer to each other than this, in places.
    strength : float
        How far a place that is surely another's is closed.

    Returns
    -------
    dict
        Point to factors (n, h, w) from 1 - ``strength`` to 1.
    """
    side = int(LINKS.taken_radii * radius) | 1
    taken = {
        point: np.stack([np.clip(cv2.blur(m, (side, side)) * side**2, 0, 1) for m in posterior])
        for point, posterior in posteriors.items()
    }
    total = sum(taken.values())
    return {point: 1 - strength * np.clip(total - own, 0, 1) for point, own in taken.items()}
