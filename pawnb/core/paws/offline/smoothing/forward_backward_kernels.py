"""The inner loops of :mod:`.smoothing.forward_backward_distance`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.smoothing.smoother_kernels import THIRD_DIFFERENCE


@compiled
def predict(
    information: np.ndarray, target: np.ndarray, jerk2: np.ndarray, jerk_mean: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Tell each frame of several tracks from the frames before it alone.

    Kept is what is known of the last three positions, as information, which can be none at
    all; the change of acceleration joins the next position to them.

    Parameters
    ----------
    information, target : ndarray, shape (n, P, d, d) and (n, P, d)
        What is measured in each frame, along axes of which each changes by itself.
    jerk2, jerk_mean : ndarray, shape (n, P, d)
        Variance and mean of the change of acceleration along them, at frame t from the
        frames t - 1, t and t + 1 to t + 2.

    Returns
    -------
    known, aim : ndarray, shape (n, P, d, d) and (n, P, d)
        Information of each position, and that times the position; 0 in the first three frames.
    """
    n, n_points, d = target.shape
    known, aim = np.zeros(information.shape), np.zeros(target.shape)
    A, b = np.zeros((4 * d, 4 * d)), np.zeros(4 * d)
    B, c = np.zeros((3 * d, 3 * d)), np.zeros(3 * d)
    for p in range(n_points):
        A[:], b[:] = 0.0, 0.0
        for t in range(min(3, n)):
            _add(A, b, t * d, information[t, p], target[t, p])
        for t in range(3, n):
            for i in range(d):
                w = 1.0 / jerk2[t - 2, p, i]
                for j in range(4):
                    b[j * d + i] += THIRD_DIFFERENCE[j] * w * jerk_mean[t - 2, p, i]
                    for k in range(4):
                        A[j * d + i, k * d + i] += THIRD_DIFFERENCE[j] * THIRD_DIFFERENCE[k] * w
            _eliminate(A, b, d)
            _take(A, b, d, B, c)
            _eliminate(B, c, 2 * d)
            _take(B, c, 2 * d, known[t, p], aim[t, p])
            # the last three positions are the first three of the next frame's four
            for j in range(3 * d):
                b[j] = b[j + d]
                for k in range(3 * d):
                    A[j, k] = A[j + d, k + d]
            for i in range(d):
                b[3 * d + i] = 0.0
                for j in range(4 * d):
                    A[3 * d + i, j], A[j, 3 * d + i] = 0.0, 0.0
            _add(A, b, 2 * d, information[t, p], target[t, p])
    return known, aim


@compiled
def _add(A: np.ndarray, b: np.ndarray, at: int, more: np.ndarray, right: np.ndarray) -> None:
    """Add what is known of some unknowns, from ``at`` on, to the equations ``A x = b``."""
    for i in range(len(right)):
        b[at + i] += right[i]
        for j in range(len(right)):
            A[at + i, at + j] += more[i, j]


@compiled
def _take(A: np.ndarray, b: np.ndarray, at: int, B: np.ndarray, c: np.ndarray) -> None:
    """Copy the equations of the unknowns from ``at`` on."""
    for i in range(len(c)):
        c[i] = b[at + i]
        for j in range(len(c)):
            B[i, j] = A[at + i, at + j]


@compiled
def _eliminate(A: np.ndarray, b: np.ndarray, first: int) -> None:
    """Leave what is known of all but the first unknowns of ``A x = b``, A symmetric."""
    size = len(b)
    for j in range(first):
        for row in range(j + 1, size):
            share = A[row, j] / A[j, j]
            if share != 0.0:
                b[row] -= share * b[j]
                for column in range(j + 1, size):
                    A[row, column] -= share * A[j, column]
