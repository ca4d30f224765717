"""Forward-backward algorithm over the places of the grid, carried by optical flow."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.core.paws.offline.parameters import AssociationParameters

_TINY = 1e-20


def smooth_posterior(
    likelihood: np.ndarray,
    forward: np.ndarray,
    backward: np.ndarray,
    *,
    prior: np.ndarray,
    parameters: AssociationParameters,
) -> np.ndarray:
    """Return the probability of every place in every frame, given all frames.

    Parameters
    ----------
    likelihood : ndarray of float32, shape (n, h, w)
        Ratios of likelihoods.
    forward, backward : ndarray of float32, shape (n - 1, h, w, 2)
        Optical flow, in places.
    prior : ndarray of float32, shape (h, w)
        Probability of places without any evidence, sum 1.
    parameters : AssociationParameters
        The stage's parameters.

    Returns
    -------
    ndarray of float32, shape (n, h, w)
        Each frame sums to 1.
    """
    n, h, w = likelihood.shape
    x, y = np.meshgrid(np.arange(w, dtype=np.float32), np.arange(h, dtype=np.float32))

    def carried(mass: np.ndarray, flow: np.ndarray) -> np.ndarray:
        moved = cv2.remap(mass, x + flow[..., 0], y + flow[..., 1], cv2.INTER_LINEAR)
        # this border keeps every mass within and is the same forwards and backwards
        near, far = (
            cv2.GaussianBlur(moved, (0, 0), sd, borderType=cv2.BORDER_REFLECT)
            for sd in (parameters.near_sd, parameters.far_sd)
        )
        return (1 - parameters.far) * near + parameters.far * far

    filtered = np.empty_like(likelihood)
    filtered[0] = _normalised(prior * likelihood[0])
    for t in range(1, n):
        mass = _normalised(carried(filtered[t - 1], backward[t - 1]))
        mass = (1 - parameters.lost) * mass + parameters.lost * prior
        filtered[t] = _normalised(mass * likelihood[t])
    to_come = np.full((h, w), 1 / (h * w), np.float32)
    for t in range(n - 2, -1, -1):
        mass = carried(_normalised(to_come * likelihood[t + 1]), forward[t])
        to_come = _normalised(mass) + 10 * parameters.lost / (h * w)
        filtered[t] = _normalised(filtered[t] * to_come)
    return filtered


def _normalised(mass: np.ndarray) -> np.ndarray:
    """Return what sums to 1."""
    return mass / (mass.sum() + _TINY)
