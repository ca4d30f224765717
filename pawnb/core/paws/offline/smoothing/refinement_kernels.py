"""The inner loops of :mod:`pawnb.core.paws.offline.smoothing.refinement`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def take_nearest(
    uv: np.ndarray,
    near: np.ndarray,
    at: np.ndarray,
    detection_probability: np.ndarray,
    is_there: np.ndarray,
    paw_width_px: np.ndarray,
    negative_log_odds: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Give detections to points, the cheapest pair first, each only once.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Where each point is expected, px.
    near : ndarray, shape (n, P)
        How far from there a detection may lie, in paw widths.
    at, detection_probability, is_there : ndarray
        See :class:`~pawnb.core.paws.offline.detection.colour.observations.Observations`.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.
    negative_log_odds : ndarray, shape (n, P, V, C)
        How much nearer each must be for what speaks against it, in paw widths.

    Returns
    -------
    measured, detection_probability : ndarray, shape (n, P, V, 2) and (n, P, V)
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
                        away = np.sqrt(du * du + dv * dv) / paw_width_px[v]
                        away += negative_log_odds[t, p, v, i]
                        if away <= near[t, p]:
                            cost[p, i] = away + 0.5 * (1.0 - detection_probability[t, v, i])
            for _ in range(min(n_points, most)):
                p, i = _least(cost)
                if cost[p, i] == np.inf:
                    break
                for c in range(2):
                    measured[t, p, v, c] = at[t, p, v, i, c]
                good[t, p, v] = detection_probability[t, v, i]
                cost[p, :] = np.inf
                cost[:, i] = np.inf
    return measured, good


@compiled
def _least(cost: np.ndarray) -> tuple[int, int]:
    """Return row and column of the least number, the first of those that are equal."""
    row, column = 0, 0
    for q in range(cost.shape[0]):
        for j in range(cost.shape[1]):
            if cost[q, j] < cost[row, column]:
                row, column = q, j
    return row, column


@compiled
def normal_equations(
    x: np.ndarray, measured: np.ndarray, weight: np.ndarray, table: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return information (n, P, d, d) and target (n, P, d) of measurements.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Where points are thought to be: image positions are taken as linear about it.
    measured : ndarray, shape (n, P, V, 2)
        Image positions, px.
    weight : ndarray, shape (n, P, V)
        Weights, px^-2; 0 where nothing was measured.
    table : ndarray, shape (V, 11)
        DLT coefficients of the views.
    """
    n, n_points, n_views = weight.shape
    d = x.shape[2]
    W, z = np.zeros((n, n_points, d, d)), np.zeros((n, n_points, d))
    J = np.empty(d)
    for t in range(n):
        for p in range(n_points):
            for v in range(n_views):
                if weight[t, p, v] == 0.0:
                    continue
                L = table[v]
                below = 1.0
                for i in range(d):
                    below += L[8 + i] * x[t, p, i]
                for c in range(2):
                    top = L[4 * c + 3]
                    for i in range(d):
                        top += L[4 * c + i] * x[t, p, i]
                    wanted = measured[t, p, v, c] - top / below
                    for i in range(d):
                        J[i] = (L[4 * c + i] - top / below * L[8 + i]) / below
                        wanted += J[i] * x[t, p, i]
                    add_equation(W[t, p], z[t, p], J, wanted, weight[t, p, v])
    return W, z


@compiled
def add_equation(W: np.ndarray, z: np.ndarray, J: np.ndarray, wanted: float, weight: float) -> None:
    """Add the equation ``J x = wanted`` to information (d, d) and target (d,)."""
    for i in range(len(J)):
        tracked_in_view = weight * J[i]
        z[i] += tracked_in_view * wanted
        for j in range(len(J)):
            W[i, j] += tracked_in_view * J[j]
