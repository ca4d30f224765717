"""What steps between candidates of two frames cost: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def step_costs(expected: np.ndarray, now: np.ndarray, jump_px: float, most: float) -> np.ndarray:
    """Return the cost of each step, shape (candidates before, candidates now).

    Parameters
    ----------
    expected, now : ndarray, shape (candidates, joints, 2)
        Where the candidates before are expected to have their joints, and where those now have
        them; NaN beyond the tip of a short leg.
    jump_px : float
        Standard deviation of a joint's way from its expected place.
    most : float
        Cost of the longest leap.
    """
    out = np.empty((expected.shape[0], now.shape[0]))
    for a in range(expected.shape[0]):
        for b in range(now.shape[0]):
            total, n = 0.0, 0
            for k in range(now.shape[1]):
                du, dv = now[b, k, 0] - expected[a, k, 0], now[b, k, 1] - expected[a, k, 1]
                square = du * du + dv * dv
                if not math.isnan(square):
                    total += square
                    n += 1
            out[a, b] = min(0.5 * total / (max(n, 1) * jump_px**2), most)
    return out
