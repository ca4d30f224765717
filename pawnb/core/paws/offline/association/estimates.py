"""From probabilities of places to a position, how likely it is, and its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.association.parameters import LINKS


@dataclass(frozen=True)
class Estimates:
    """Where a point is in n frames of a view.

    Parameters
    ----------
    place : ndarray, shape (n, 2)
        Places of the grid (x, y), between its nodes.
    probability : ndarray, shape (n,)
        Probability that the point is within the radius of it.
    sd : ndarray, shape (n,)
        Standard deviation of the whole distribution about it, in places, as the root of the
        mean of its two variances.
    """

    place: FloatArray
    probability: FloatArray
    sd: FloatArray


def estimate(posterior: Float32Array, radius: float) -> Estimates:
    """Return the mean of the highest mode of every frame.

    Parameters
    ----------
    posterior : ndarray of float32, shape (n, h, w)
        Probability of every place.
    radius : float
        How far the mode reaches, in places.

    Returns
    -------
    Estimates
        Of the n frames.
    """
    reach = int(np.ceil(radius))
    y, x = np.ogrid[: posterior.shape[1], : posterior.shape[2]]

    def one(mass: Float32Array) -> tuple[float, float, float, float]:
        mode = np.unravel_index(
            cv2.GaussianBlur(mass, (0, 0), LINKS.mode_blur).argmax(), mass.shape
        )
        rows, columns = (slice(max(0, int(m) - reach), int(m) + reach + 1) for m in mode)
        near = mass[rows, columns] + 1e-20
        within = near.sum()
        at_x = (near * x[:, columns]).sum() / within
        at_y = (near * y[rows]).sum() / within
        total = float(mass.sum())
        off = mass.sum(axis=0) @ (x[0] - at_x) ** 2 + mass.sum(axis=1) @ (y[:, 0] - at_y) ** 2
        spread = off / max(total, 1e-20)
        return at_x, at_y, float(within / (total + 1e-20)), float(np.sqrt(spread / 2))

    table = np.array(in_parts(one, posterior)).reshape(-1, 4)
    return Estimates(table[:, :2], np.clip(table[:, 2], 0, 1), table[:, 3])


def modes(mass: Float32Array, radius: float, count: int) -> list[tuple[FloatArray, float]]:
    """Return the highest modes of one frame and their probabilities.

    Parameters
    ----------
    mass : ndarray, shape (h, w)
        Probability of every place.
    radius : float
        How far a mode reaches, in places.
    count : int
        How many at most.

    Returns
    -------
    list of (ndarray (2,), float)
        Place (x, y) and probability, the likeliest first; none below 0.02.
    """
    left, found = mass.copy(), []
    reach = int(np.ceil(radius))
    for _ in range(count):
        y, x = np.unravel_index(left.argmax(), left.shape)
        part = (slice(max(0, y - reach), y + reach + 1), slice(max(0, x - reach), x + reach + 1))
        within = float(left[part].sum())
        if within < LINKS.least_mode:
            break
        found.append((np.array([x, y], float), within))
        left[part] = 0
    return found
