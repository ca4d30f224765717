"""Smoothing of whole tracks: the path of least jerk through what was measured.

For positions x_t, measurements z_t with information (inverse covariance) W_t, and the
variance q_t of the change of acceleration from frame to frame, the sum of
``(x_t - z_t)' W_t (x_t - z_t)`` and ``|x_{t+2} - 3 x_{t+1} + 3 x_t - x_{t-1}|^2 / q_t`` is
lowest at the solution of a banded system, which is the same as a Kalman filter and
smoother of a constant-acceleration model whose first state is unknown. Limbs move about
so (Flash & Hogan 1985), and a gap is bridged with the speeds and accelerations of its
ends. Covariances are blocks of the inverse (Takahashi's recursion).
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.smoothing import smoother_kernels as loops


def smooth(
    information: FloatArray,
    target: FloatArray,
    jerk2: FloatArray,
    *,
    jerk_mean: FloatArray | None = None,
    axes: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Smooth one track.

    Parameters
    ----------
    information : ndarray, shape (n, d, d)
        Information of each frame's measurement; 0 where there is none.
    target : ndarray, shape (n, d)
        ``W_t z_t`` of each frame.
    jerk2 : ndarray, shape (n,) or (n, d)
        Variance of the change of acceleration at each frame, along all axes or along each.
    jerk_mean : ndarray, shape (n, d), optional
        What it is on average; default 0.
    axes : ndarray, shape (d, d), optional
        The axes, unit vectors at right angles; default those of the coordinates.

    Returns
    -------
    x : ndarray, shape (n, d)
        Smoothed positions.
    factor : ndarray, shape (n d, 3 d + 1)
        Banded Cholesky factor, for :func:`variances`.
    """
    axes = np.eye(target.shape[1]) if axes is None else np.ascontiguousarray(axes, float)
    jerk2 = jerk2 if jerk2.ndim == 2 else jerk2[:, None]
    return loops.smooth(
        np.ascontiguousarray(information, float),
        np.ascontiguousarray(target, float),
        # copied: what is broadcast may not be written, which is another type to compile for
        np.array(np.broadcast_to(jerk2, target.shape), float, order="C"),
        np.zeros(target.shape) if jerk_mean is None else np.ascontiguousarray(jerk_mean @ axes.T),
        axes,
    )


def variances(factor: FloatArray, d: int, *, axes: FloatArray | None = None) -> FloatArray:
    """Return the variance of every coordinate from factors of :func:`smooth`.

    Parameters
    ----------
    factor, d, axes
        As for :func:`covariances`.

    Returns
    -------
    ndarray, shape (..., n, d)
        The variances.
    """
    return diagonals(covariances(factor, d, axes=axes))


def covariances(factor: FloatArray, d: int, *, axes: FloatArray | None = None) -> FloatArray:
    """Return the covariance of every position from factors of :func:`smooth`.

    Parameters
    ----------
    factor : ndarray, shape (..., n d, 3 d + 1)
        Factors of one track or of several.
    d : int
        Number of coordinates.
    axes : ndarray, shape (d, d), optional
        Those of :func:`smooth`.

    Returns
    -------
    ndarray, shape (..., n, d, d)
        The covariances.
    """
    *several, size, width = factor.shape
    axes = np.eye(d) if axes is None else np.ascontiguousarray(axes, float)
    found = [loops.covariances(one, axes) for one in factor.reshape(-1, size, width)]
    return np.reshape(found, (*several, size // d, d, d))


def diagonals(covariance: FloatArray) -> FloatArray:
    """Return the variances (..., d) that covariances (..., d, d) have."""
    return np.ascontiguousarray(np.diagonal(covariance, axis1=-2, axis2=-1))
