"""Where a paw may be in a picture from below: the middles of paw-coloured spots.

From below the whole paw is seen, with its digits spread: it has no one end, but it is the
brightest spot of a limb that is otherwise dimmer and farther away. Its middle is the local
maximum of the score, smoothed over about the width of a paw.
"""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import AnyArray, Float32Array, FloatArray
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR


def detect_blobs(score: Float32Array, reach: int, usual: float) -> tuple[FloatArray, Float32Array]:
    """Find the middles of paw-coloured spots.

    Parameters
    ----------
    score : ndarray, shape (h, w)
        Log-likelihood ratio of every pixel.
    reach : int
        See :class:`~pawnb.core.paws.offline.detection.colour.detector.DetectorConfig`.
    usual : float
        Score that clicked paws have: more does not make a spot more like a paw.

    Returns
    -------
    at : ndarray, shape (n, 2)
        u, v of the middles, px of the score.
    likeness : ndarray, shape (n,)
        How much each is like a paw, 0 to 1.
    """
    smooth = _smooth(score, reach)
    around = 2 * round(COLOUR.blob_detection_apart * COLOUR.blob_detection_width * reach) + 1
    highest = cv2.dilate(smooth, np.ones((around, around), np.uint8))
    v, u = np.nonzero((smooth >= highest) & (smooth > COLOUR.blob_detection_least * usual))
    likeness = np.minimum(smooth[v, u] / usual, 1.0)
    padded = np.pad(smooth, 1, mode="edge")
    # the top of a parabola through the maximum and its neighbours, along u and along v
    left = np.stack([padded[v + 1, u], padded[v, u + 1]])
    middle = padded[v + 1, u + 1]
    right = np.stack([padded[v + 1, u + 2], padded[v + 2, u + 1]])
    bend = np.minimum(left - 2.0 * middle + right, -1e-6)
    shift = np.clip(0.5 * (left - right) / bend, -0.5, 0.5)
    return np.column_stack([u, v]) + shift.T, likeness


def peaks_at(score: AnyArray, at: AnyArray, reach: int) -> AnyArray:
    """Return the smoothed score (n,) at some positions (n, 2), px of the score.

    Parameters
    ----------
    score : ndarray, shape (h, w)
        Score of each place.
    at : ndarray, shape (n, 2)
        Positions, px of the score.
    reach : int
        Radius over which the score is smoothed, px of the score.

    Returns
    -------
    ndarray, shape (n,)
        The smoothed score.
    """
    h, w = score.shape
    u, v = np.rint(at).astype(int).T
    return np.asarray(_smooth(score, reach)[np.clip(v, 0, h - 1), np.clip(u, 0, w - 1)])


def _smooth(score: np.ndarray, reach: int) -> np.ndarray:
    """Return what speaks for paws, smoothed over about the width of one."""
    return cv2.GaussianBlur(np.maximum(score, 0.0), (0, 0), COLOUR.blob_detection_width * reach)
