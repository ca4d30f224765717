"""Eight features of each superpixel, normalised, weighted and fused into one score.

Haji Maghsoudi et al. 2019, Eq. 3 to 6. Eq. 4 turns differences into likenesses (1
is best), so the best superpixel has the highest score; the paper's text and its
Algorithm 3 say the lowest. The reference corner of F7 is the bottom corner towards
the direction of travel; the paper's bottom left is that only where the animal faces
left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.superpixels import Look, Superpixels, hue_difference


def compute_features(
    superpixels: Superpixels, initial: Look, previous: Look, *, facing: int
) -> FloatArray:
    """Compute the eight features of Eq. 3; each is a difference, 0 is best.

    Parameters
    ----------
    superpixels : Superpixels
        The n superpixels of a sub-image, whose centre is the predicted position.
    initial : Look
        Colour of the point where it was clicked.
    previous : Look
        Colour of the superpixel chosen in the frame before.
    facing : int
        +1 where the animal faces right in the picture, -1 where it faces left, 0 where
        that is unknown: F7 is then 0 for every superpixel and so separates nothing.

    Returns
    -------
    ndarray, shape (n, 8)
        F1, F2: green (initial, previous); F3, F4: hue, degrees; F5, F6: red; F7: px from
        the bottom corner towards the direction of travel; F8: px from the prediction.
    """
    window = superpixels.window
    to_centre = superpixels.uv - window.centre
    to_corner = superpixels.uv - window.corner(facing)
    return np.stack(
        [
            np.abs(superpixels.green - initial.green),
            np.abs(superpixels.green - previous.green),
            hue_difference(superpixels.hue, initial.hue),
            hue_difference(superpixels.hue, previous.hue),
            np.abs(superpixels.red - initial.red),
            np.abs(superpixels.red - previous.red),
            np.hypot(*to_corner.T) if facing else np.zeros(len(to_corner)),
            np.hypot(*to_centre.T),
        ],
        axis=-1,
    )


def normalise(features: FloatArray) -> FloatArray:
    """Turn differences into likenesses between 0 (worst here) and 1 (best here), Eq. 4.

    Parameters
    ----------
    features : ndarray, shape (n, k)
        Features of n superpixels.

    Returns
    -------
    ndarray, shape (n, k)
        Likenesses. A feature that is the same for all superpixels, such as hue in a grey
        picture, separates nothing: Eq. 4 would divide 0 by 0, and it is 1 for all.
    """
    low, high = features.min(axis=0), features.max(axis=0)
    spread = high - low
    return 1.0 - (features - low) / np.where(spread > 0, spread, 1.0)


def fuse(likenesses: FloatArray, weights: Sequence[float]) -> FloatArray:
    """Return the weighted mean of the likenesses of each superpixel, Eq. 6.

    Parameters
    ----------
    likenesses : ndarray, shape (n, k)
        From :func:`normalise`.
    weights : sequence of k float
        Weights of the features.

    Returns
    -------
    ndarray, shape (n,)
        Scores between 0 and 1; the highest is best.
    """
    w = np.asarray(weights, dtype=float)
    return likenesses @ w / w.sum()


def best_superpixels(scores: FloatArray, *, count: int) -> IntArray:
    """Return the numbers of the best superpixels, best first.

    Parameters
    ----------
    scores : ndarray, shape (n,)
        From :func:`fuse`.
    count : int
        How many; fewer are returned where there are fewer superpixels.

    Returns
    -------
    ndarray of int, shape (min(n, count),)
        Numbers of superpixels; equal scores keep their order.
    """
    return np.argsort(-scores, kind="stable")[:count]
