"""The inner loops of :mod:`pawnb.core.paws.offline.smoothing.smoother`, compiled.

Of symmetric banded matrices the lower triangle is kept, column after column: ``band[j, k]`` is
what stands in column j and row j + k.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled

THIRD_DIFFERENCE = (-1.0, 3.0, -3.0, 1.0)
"""Mathematics: weights of the third difference."""


@compiled
def smooth(
    information: np.ndarray,
    target: np.ndarray,
    jerk2: np.ndarray,
    jerk_mean: np.ndarray,
    axes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Smooth one track; see :func:`pawnb.core.paws.offline.smoothing.smoother.smooth`.

    Parameters
    ----------
    information, target : ndarray, shape (n, d, d) and (n, d)
        What is measured.
    jerk2, jerk_mean : ndarray, shape (n, d)
        Variance and mean of the change of acceleration, along the axes.
    axes : ndarray, shape (d, d)
        The axes.

    Returns
    -------
    x : ndarray, shape (n, d)
        Smoothed positions.
    factor : ndarray, shape (n d, 3 d + 1)
        Banded Cholesky factor.
    """
    n, d = target.shape
    band, x = np.zeros((n * d, 3 * d + 1)), np.zeros((n, d))
    _measured(information, target, axes, band, x)
    for t in range(1, n - 2):
        for i in range(d):
            w = 1.0 / jerk2[t, i]
            for k in range(4):
                x[t - 1 + k, i] += THIRD_DIFFERENCE[k] * w * jerk_mean[t, i]
                for later in range(k, 4):
                    band[(t - 1 + k) * d + i, (later - k) * d] += (
                        THIRD_DIFFERENCE[k] * THIRD_DIFFERENCE[later] * w
                    )
    largest = 0.0
    for j in range(n * d):
        largest = max(largest, band[j, 0])
    for j in range(n * d):
        # a trace of prior keeps tracks with hardly any measurement solvable, or with none at all:
        # a paw that nobody clicked, in so few frames that nothing says how it moves
        band[j, 0] += 1e-9 * (largest if largest > 0.0 else 1.0)
    factorize(band)
    solve(band, x.reshape(-1))
    turned = np.zeros((n, d))
    for t in range(n):
        for i in range(d):
            for j in range(d):
                turned[t, i] += x[t, j] * axes[j, i]
    return turned, band


@compiled
def _measured(
    information: np.ndarray,
    target: np.ndarray,
    axes: np.ndarray,
    band: np.ndarray,
    right: np.ndarray,
) -> None:
    """Add measurements to a band and to its right side (n, d), along the axes."""
    n, d = target.shape
    half = np.empty((d, d))
    for t in range(n):
        for i in range(d):
            for j in range(d):
                right[t, i] += axes[i, j] * target[t, j]
                half[i, j] = 0.0
                for k in range(d):
                    half[i, j] += axes[i, k] * information[t, k, j]
        for i in range(d):
            for j in range(i + 1):
                for k in range(d):
                    band[t * d + j, i - j] += half[i, k] * axes[j, k]


@compiled
def factorize(band: np.ndarray) -> None:
    """Replace a positive definite band by its Cholesky factor."""
    size, width = band.shape
    for j in range(size):
        if not band[j, 0] > 0.0:
            raise ValueError("the matrix is not positive definite")
        rows = min(width, size - j)
        scale = 1.0 / np.sqrt(band[j, 0])
        for k in range(rows):
            band[j, k] *= scale
        for k in range(1, rows):
            tracked_in_view = band[j, k]
            for i in range(k, rows):
                band[j + k, i - k] -= tracked_in_view * band[j, i]


@compiled
def solve(factor: np.ndarray, right: np.ndarray) -> None:
    """Replace the right side of equations by their solution, given the factor of their band."""
    size, width = factor.shape
    for j in range(size):
        right[j] /= factor[j, 0]
        for k in range(1, min(width, size - j)):
            right[j + k] -= factor[j, k] * right[j]
    for j in range(size - 1, -1, -1):
        for k in range(1, min(width, size - j)):
            right[j] -= factor[j, k] * right[j + k]
        right[j] /= factor[j, 0]


@compiled
def covariances(factor: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the covariance (n, d, d) of every position, given the factor of a smoothed track.

    What the inverse has within the band tells itself, from the last column to the first.
    """
    (size, width), d = factor.shape, len(axes)
    band = np.zeros((size, width))
    for j in range(size - 1, -1, -1):
        rows = min(width, size - j)
        for i in range(1, rows):
            for k in range(1, rows):
                inner = band[j + k, i - k] if i >= k else band[j + i, k - i]
                band[j, i] -= factor[j, k] * inner
            band[j, i] /= factor[j, 0]
        band[j, 0] = 1.0 / factor[j, 0]
        for k in range(1, rows):
            band[j, 0] -= factor[j, k] * band[j, k]
        band[j, 0] /= factor[j, 0]
    found = np.zeros((size // d, d, d))
    for t in range(size // d):
        for c in range(d):
            for e in range(d):
                for i in range(d):
                    for j in range(d):
                        low, high = min(i, j), max(i, j)
                        inner = band[t * d + low, high - low]
                        found[t, c, e] += axes[i, c] * inner * axes[j, e]
    return found
