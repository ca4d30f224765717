"""Forward-backward algorithm over the places of the grid, carried by optical flow."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.parameters import AssociationParameters

_TINY_CHANCE = 1e-20
"""Guard: against division by zero."""


@dataclass(frozen=True)
class Posterior:
    """What is known of one point in n frames.

    Parameters
    ----------
    mass : ndarray of float32, shape (n, h, w)
        Probability of every place given all frames; each frame sums to 1.
    agreement : ndarray, shape (n,)
        How far what came before a frame and what comes after it (each with the frame itself) put
        the point in one place: 1 where they agree, 0 where they exclude each other
        (Bhattacharyya coefficient after a blur of half a paw).
    name_share : ndarray, shape (n,), optional
        How surely the tracklet that was given to the point there is its own (:mod:`.joint`): 0
        where none was, None where names were not decided jointly.
    """

    mass: np.ndarray
    agreement: np.ndarray
    name_share: np.ndarray | None = None


def smooth_posterior(
    likelihood: Float32Array,
    forward: Float32Array,
    backward: Float32Array,
    *,
    prior: Float32Array,
    parameters: AssociationParameters,
    compared: bool = True,
) -> Posterior:
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
    compared : bool
        Whether the agreement is worked out; it is 1 throughout otherwise.

    Returns
    -------
    Posterior
        Of the n frames.
    """
    n, h, w = likelihood.shape
    grid = np.stack(np.meshgrid(np.arange(w), np.arange(h)), axis=-1).astype(np.float32)
    prior = np.asarray(prior, np.float32)

    def carried(mass: np.ndarray, flow: np.ndarray) -> np.ndarray:
        moved = cv2.remap(mass, grid + flow, None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
        # this border keeps every mass within and is the same forwards and backwards
        near, far = (
            cv2.GaussianBlur(moved, (0, 0), sd, borderType=cv2.BORDER_REFLECT)
            for sd in (parameters.near_sd, parameters.far_sd)
        )
        return cv2.addWeighted(near, 1 - parameters.far, far, parameters.far, 0)

    filtered = np.empty_like(likelihood)
    filtered[0] = _normalised(prior * likelihood[0])
    for t in range(1, n):
        mass = carried(filtered[t - 1], backward[t - 1])
        kept = (1 - parameters.lost) / (_total(mass) + _TINY_CHANCE)
        mass = cv2.addWeighted(mass, kept, prior, parameters.lost, 0)
        filtered[t] = _normalised(cv2.multiply(mass, likelihood[t], dst=mass))
    to_come = np.full((h, w), 1 / (h * w), np.float32)
    agreement = np.ones(n)
    for t in range(n - 2, -1, -1):
        mass = carried(_normalised(to_come * likelihood[t + 1]), forward[t])
        to_come = _normalised(mass) + LINKS.to_come_even * parameters.lost / (h * w)
        if compared:
            agreement[t] = _overlap(filtered[t], _normalised(to_come * likelihood[t]))
        filtered[t] = _normalised(cv2.multiply(to_come, filtered[t]))
    return Posterior(filtered, agreement)


def _overlap(before: np.ndarray, after: np.ndarray) -> float:
    """Return the Bhattacharyya coefficient of two distributions, blurred."""
    before, after = (cv2.GaussianBlur(mass, (0, 0), LINKS.compare_blur) for mass in (before, after))
    return _total(cv2.sqrt(cv2.multiply(before, after)))


def _normalised(mass: np.ndarray) -> np.ndarray:
    """Return float32 that sums to 1; ``mass`` is changed."""
    mass *= np.float32(1 / (_total(mass) + _TINY_CHANCE))
    return mass


def _total(mass: np.ndarray) -> float:
    """Return the sum; the last digits of cv2.sumElems differ with where an array lies in memory."""
    return float(mass.sum(dtype=float))
