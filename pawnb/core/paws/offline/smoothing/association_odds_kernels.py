"""The inner loop of :mod:`pawnb.core.paws.offline.smoothing.association_odds`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def gaps(
    measured: np.ndarray,
    uv: np.ndarray,
    spread: np.ndarray,
    at: np.ndarray,
    is_there: np.ndarray,
    sigma: np.ndarray,
    negative_log_odds: np.ndarray,
    apart: np.ndarray,
    most: float,
) -> np.ndarray:
    """Return how far each detection taken is ahead of the next best (n, P, V).

    Parameters
    ----------
    measured : ndarray, shape (n, P, V, 2)
        Detections taken, px, NaN where none.
    uv, spread : ndarray, shape (n, P, V, 2) and (n, P, V, 2, 2)
        Where the points are expected, px, and with what covariance.
    at : ndarray, shape (n, P, V, C, 2)
        Where each detection says that each point is, px.
    is_there : ndarray of bool, shape (n, V, C)
        False where a picture has fewer detections.
    sigma : ndarray, shape (n, V, C)
        Standard deviation of each detection, px.
    negative_log_odds : ndarray, shape (n, P, V, C)
        What else speaks against each, minus a logarithm of odds.
    apart : ndarray, shape (V,)
        Detections nearer to each other than this say the same, px.
    most : float
        Whatever costs so much more is no detection.
    """
    n, n_points, n_views, n_candidates = negative_log_odds.shape
    found = np.full((n, n_points, n_views), np.nan)
    for t in range(n):
        for p in range(n_points):
            for v in range(n_views):
                u0, v0 = measured[t, p, v, 0], measured[t, p, v, 1]
                if np.isnan(u0):
                    continue
                taken, other = np.inf, np.inf
                for i in range(n_candidates):
                    if not is_there[t, v, i]:
                        continue
                    s2 = sigma[t, v, i] ** 2
                    a = spread[t, p, v, 0, 0] + s2
                    b = spread[t, p, v, 0, 1]
                    c = spread[t, p, v, 1, 1] + s2
                    det = a * c - b * b
                    du, dv = at[t, p, v, i, 0] - uv[t, p, v, 0], at[t, p, v, i, 1] - uv[t, p, v, 1]
                    square = (c * du * du - 2.0 * b * du * dv + a * dv * dv) / det
                    cost = negative_log_odds[t, p, v, i] + 0.5 * (square + np.log(det))
                    away = np.hypot(at[t, p, v, i, 0] - u0, at[t, p, v, i, 1] - v0)
                    if away == 0.0:
                        taken = min(taken, cost)
                    elif away >= apart[v]:
                        other = min(other, cost)
                # what was placed by hand is no detection
                if taken < np.inf:
                    found[t, p, v] = min(max(other - taken, -most), most)
    return found
