"""The inner loops of :mod:`pawnb.core.paws.whole.refine`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def take_nearest(
    uv: np.ndarray,
    gate: np.ndarray,
    at: np.ndarray,
    quality: np.ndarray,
    is_there: np.ndarray,
    thickness_px: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Give candidates to points, the cheapest pair first, each only once.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Where each point is expected, px.
    gate : ndarray, shape (n, P)
        How far from there a candidate may lie, in thicknesses.
    at, quality, is_there : ndarray
        See :class:`~pawnb.core.paws.whole.sights.Sights`.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.

    Returns
    -------
    measured, quality : ndarray, shape (n, P, V, 2) and (n, P, V)
        What each point was given; NaN and 0 where nothing.
    """
    n, n_points, n_views, most = at.shape[:4]
    measured = np.full((n, n_points, n_views, 2), np.nan)
    good = np.zeros((n, n_points, n_views))
    cost = np.empty((n_points, most))
    for t in range(n):
        for v in range(n_views):
            for p in range(n_points):
                for i in range(most):
                    cost[p, i] = np.inf
                    if is_there[t, v, i]:
                        du = at[t, p, v, i, 0] - uv[t, p, v, 0]
                        dv = at[t, p, v, i, 1] - uv[t, p, v, 1]
                        away = np.sqrt(du * du + dv * dv) / thickness_px[v]
                        if away <= gate[t, p]:
                            cost[p, i] = away + 0.5 * (1.0 - quality[t, v, i])
            for _ in range(min(n_points, most)):
                p, i = divmod(int(np.argmin(cost)), most)
                if cost[p, i] == np.inf:
                    break
                measured[t, p, v] = at[t, p, v, i]
                good[t, p, v] = quality[t, v, i]
                cost[p, :] = np.inf
                cost[:, i] = np.inf
    return measured, good


@compiled
def normal_equations(
    J: np.ndarray, wanted: np.ndarray, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return information (n, P, d, d) and target (n, P, d) of measurements.

    Parameters
    ----------
    J : ndarray, shape (n, P, V, 2, d)
        Derivatives of image positions.
    wanted : ndarray, shape (n, P, V, 2)
        What ``J x`` should be.
    weight : ndarray, shape (n, P, V)
        Weights, px^-2; 0 where nothing was measured.
    """
    n, n_points, n_views, _, d = J.shape
    W, z = np.zeros((n, n_points, d, d)), np.zeros((n, n_points, d))
    for t in range(n):
        for p in range(n_points):
            for v in range(n_views):
                w = weight[t, p, v]
                if w == 0.0:
                    continue
                for c in range(2):
                    for i in range(d):
                        own = w * J[t, p, v, c, i]
                        z[t, p, i] += own * wanted[t, p, v, c]
                        for j in range(d):
                            W[t, p, i, j] += own * J[t, p, v, c, j]
    return W, z
