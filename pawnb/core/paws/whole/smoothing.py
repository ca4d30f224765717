"""Smoothing of whole tracks: the path of least jerk through what was measured.

For positions x_t, measurements z_t with information (inverse covariance) W_t, and the
variance q_t of the change of acceleration from frame to frame, the sum of
``(x_t - z_t)' W_t (x_t - z_t)`` and ``|x_{t+2} - 3 x_{t+1} + 3 x_t - x_{t-1}|^2 / q_t`` is
lowest at the solution of a banded system, which is the same as a Kalman filter and
smoother of a constant-acceleration model whose first state is unknown. Limbs move about
so (Flash & Hogan 1985), and a gap is bridged with the speeds and accelerations of its
ends. Variances are the diagonal of the inverse (Takahashi's recursion).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

_THIRD = (-1.0, 3.0, -3.0, 1.0)


def smooth(
    information: np.ndarray,
    target: np.ndarray,
    jerk2: np.ndarray,
    *,
    bend: np.ndarray | None = None,
    axes: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Smooth one track.

    Parameters
    ----------
    information : ndarray, shape (n, d, d)
        Information of each frame's measurement; 0 where there is none.
    target : ndarray, shape (n, d)
        ``W_t z_t`` of each frame.
    jerk2 : ndarray, shape (n,) or (n, d)
        Variance of the change of acceleration at each frame, along all axes or along each.
    bend : ndarray, shape (n, d), optional
        What it is on average; default 0.
    axes : ndarray, shape (d, d), optional
        The axes, unit vectors at right angles; default those of the coordinates.

    Returns
    -------
    x : ndarray, shape (n, d)
        Smoothed positions.
    factor : ndarray, shape (3 d + 1, n d)
        Banded Cholesky factor, for :func:`variances`.
    """
    n, d = target.shape
    if axes is not None:
        information, target = axes @ information @ axes.T, target @ axes.T
        bend = None if bend is None else bend @ axes.T
    band = np.zeros((3 * d + 1, n, d))
    for i in range(d):
        for j in range(i + 1):
            # lower form: band[row - column] at the column
            band[i - j, :, j] += information[:, i, j]
    if n > 3:
        w = (1.0 / jerk2[1:-2]).reshape(n - 3, -1)
        for k, own in enumerate(_THIRD):
            for later in range(k, 4):
                band[(later - k) * d, k : n - 3 + k] += own * _THIRD[later] * w
        if bend is not None:
            target = target.copy()
            for k, own in enumerate(_THIRD):
                target[k : n - 3 + k] += own * w * bend[1:-2]
    # a trace of prior keeps tracks with hardly any measurement solvable, or with none at all: a paw
    # that nobody clicked, in so few frames that nothing says how it moves
    band[0] += 1e-9 * (band[0].max() or 1.0)
    factor = cholesky_banded(band.reshape(3 * d + 1, n * d), lower=True)
    x = cho_solve_banded((factor, True), target.ravel()).reshape(n, d)
    return x if axes is None else x @ axes, factor


def variances(factor: np.ndarray, d: int, *, axes: np.ndarray | None = None) -> np.ndarray:
    """Return the variance of every coordinate from factors of :func:`smooth`.

    Parameters
    ----------
    factor : ndarray, shape (..., 3 d + 1, n d)
        Factors of one track or of several.
    d : int
        Number of coordinates.
    axes : ndarray, shape (d, d), optional
        Those of :func:`smooth`.

    Returns
    -------
    ndarray, shape (..., n, d)
        The variances.
    """
    *several, width, size = factor.shape
    n = size // d
    # blocks of the factor below the diagonal, of frames t to t + 3: (..., n, 4 d, d)
    row, column = np.mgrid[: 4 * d, :d]
    at = np.arange(n)[:, None, None] * d + column
    part = row - column
    inside = (part >= 0) & (part < width) & (at - column + row < size)
    block = np.where(inside, factor[..., np.clip(part, 0, width - 1), at], 0.0)
    own = np.linalg.inv(block[..., :d, :])
    gain = block[..., d:, :] @ own
    first = np.swapaxes(own, -1, -2) @ own
    # covariance of the three frames after the one in hand
    after = np.zeros((*several, 3 * d, 3 * d))
    whole = np.zeros((*several, 4 * d, 4 * d))
    found = np.empty((*several, n, d))
    for t in range(n - 1, -1, -1):
        here = gain[..., t, :, :]
        cross = -after @ here
        whole[..., d:, d:] = after
        whole[..., d:, :d] = cross
        whole[..., :d, d:] = np.swapaxes(cross, -1, -2)
        corner = first[..., t, :, :] - np.swapaxes(here, -1, -2) @ cross
        # rounding that is not symmetric would grow from frame to frame
        whole[..., :d, :d] = 0.5 * (corner + np.swapaxes(corner, -1, -2))
        here = whole[..., :d, :d] if axes is None else axes.T @ whole[..., :d, :d] @ axes
        found[..., t, :] = np.diagonal(here, axis1=-2, axis2=-1)
        after = whole[..., : 3 * d, : 3 * d].copy()
    return found
