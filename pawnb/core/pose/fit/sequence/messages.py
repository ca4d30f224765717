"""What the frames before and after say about a leg: messages along the recording.

A leg's numbers move evenly but for accelerations: their second differences are normal about zero.
With a parabola about each frame's own fit this is a chain whose exact posterior is found by one
pass forwards and one backwards (a Kalman smoother in information form, on pairs of frames).
Not compiled: that would take longer than most recordings.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from pawnb.arrays import FloatArray


def _without(
    matrix: FloatArray, vector: FloatArray, gone: slice, left: slice
) -> tuple[FloatArray, FloatArray]:
    """Return precision and vector of the numbers ``left`` where those ``gone`` are not known."""
    *_, solved, fault = dgesv(matrix[gone, gone], matrix[gone, left])
    if fault:
        raise np.linalg.LinAlgError("a leg's precision is singular")
    precision = matrix[left, left] - matrix[gone, left].T @ solved
    precision = 0.5 * (precision + precision.T)  # errors of symmetry would grow from frame to frame
    return precision, vector[left] - solved.T @ vector[gone]


def from_neighbours(
    precision: FloatArray, vector: FloatArray, steady: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what all other frames say about each frame.

    Parameters
    ----------
    precision : ndarray, shape (n, d, d)
        Of each frame's own picture.
    vector : ndarray, shape (n, d)
        The precision times the numbers that the picture has.
    steady : ndarray, shape (d, d)
        Precision of the second differences.

    Returns
    -------
    precision, vector : ndarray
        Of what the other frames say, shapes as given; zero where there are fewer than three
        frames.
    """
    n, d = vector.shape
    out, out_vector = np.zeros((n, d, d)), np.zeros((n, d))
    if n < 3:
        return out, out_vector
    smooth = np.empty((3 * d, 3 * d))  # of (x - 2 y + z) for the numbers of three frames
    share = np.array([1.0, -2.0, 1.0])
    for i in range(3):
        for j in range(3):
            smooth[i * d : (i + 1) * d, j * d : (j + 1) * d] = share[i] * share[j] * steady
    before, now, after = slice(0, d), slice(d, 2 * d), slice(2 * d, 3 * d)
    first, second = slice(0, 2 * d), slice(d, 3 * d)
    ahead, ahead_vector = np.zeros((n, 2 * d, 2 * d)), np.zeros((n, 2 * d))
    ahead[1, :d, :d], ahead[1, d:, d:] = precision[0], precision[1]
    ahead_vector[1, :d], ahead_vector[1, d:] = vector[0], vector[1]
    for t in range(2, n):
        matrix, row = smooth.copy(), np.zeros(3 * d)
        matrix[first, first] += ahead[t - 1]
        row[first] = ahead_vector[t - 1]
        ahead[t], ahead_vector[t] = _without(matrix, row, before, second)
        ahead[t, d:, d:] += precision[t]
        ahead_vector[t, d:] += vector[t]
    back, back_vector = np.zeros((2 * d, 2 * d)), np.zeros(2 * d)
    for t in range(n - 1, 0, -1):  # back: of frames t - 1 and t, by those after t
        whole, row = ahead[t] + back, ahead_vector[t] + back_vector
        out[t], out_vector[t] = _without(whole, row, before, now)
        out[t] -= precision[t]
        out_vector[t] -= vector[t]
        if t == 1:
            out[0], out_vector[0] = _without(whole, row, now, before)
            out[0] -= precision[0]
            out_vector[0] -= vector[0]
            break
        matrix, row = smooth.copy(), np.zeros(3 * d)
        matrix[second, second] += back
        row[second] = back_vector
        matrix[after, after] += precision[t]
        row[after] += vector[t]
        back, back_vector = _without(matrix, row, after, first)
    return out, out_vector
