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
    information: np.ndarray, target: np.ndarray, jerk2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Smooth one track.

    Parameters
    ----------
    information : ndarray, shape (n, d, d)
        Information of each frame's measurement; 0 where there is none.
    target : ndarray, shape (n, d)
        ``W_t z_t`` of each frame.
    jerk2 : ndarray, shape (n,)
        Variance of the change of acceleration at each frame.

    Returns
    -------
    x : ndarray, shape (n, d)
        Smoothed positions.
    factor : ndarray, shape (3 d + 1, n d)
        Banded Cholesky factor, for :func:`variances`.
    """
    n, d = target.shape
    band = np.zeros((3 * d + 1, n, d))
    for i in range(d):
        for j in range(i + 1):
            # lower form: band[row - column] at the column
            band[i - j, :, j] += information[:, i, j]
    if n > 3:
        w = (1.0 / jerk2[1:-2])[:, None]
        for k, own in enumerate(_THIRD):
            for later in range(k, 4):
                band[(later - k) * d, k : n - 3 + k] += own * _THIRD[later] * w
    # a trace of prior keeps tracks with hardly any measurement solvable
    band[0] += 1e-9 * band[0].max()
    factor = cholesky_banded(band.reshape(3 * d + 1, n * d), lower=True)
    x = cho_solve_banded((factor, True), target.ravel()).reshape(n, d)
    return x, factor


def variances(factor: np.ndarray, d: int) -> np.ndarray:
    """Return the variance (n, d) of every coordinate from the factor of :func:`smooth`."""
    width, size = factor.shape
    w = width - 1
    inverse = np.zeros((size, width))  # inverse[i, k] = Z[i + k, i]
    for i in range(size - 1, -1, -1):
        m = min(w, size - 1 - i)
        column = factor[1 : m + 1, i] / factor[0, i]
        block = np.empty((m, m))
        for a in range(m):
            block[a:, a] = inverse[i + 1 + a, : m - a]
            block[a, a:] = inverse[i + 1 + a, : m - a]
        z = -block @ column
        inverse[i, 1 : m + 1] = z
        inverse[i, 0] = 1.0 / factor[0, i] ** 2 - column @ z
    return inverse[:, 0].reshape(-1, d)
