"""Generalised cross-validation of linear smoothers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize_scalar


def effective_parameters(
    smooth: Callable[[np.ndarray], np.ndarray], n: int, *, reach: int
) -> float:
    """Count the parameters a linear smoother spends on a run: the trace of its matrix.

    Each diagonal element is what a pulse leaves at its own place. It is computed near one end
    and taken to be the same near the other; further in than ``reach`` it is the same everywhere.

    Parameters
    ----------
    smooth : callable
        Takes and returns an ndarray of shape (m, k): k runs side by side.
    n : int
        Length of the run.
    reach : int
        Distance, in samples, at which a pulse no longer feels the end of the run.

    Returns
    -------
    float
        Trace of the smoother's matrix, between 0 and n.
    """
    m = min(n, 2 * reach + 1)
    share = np.diag(smooth(np.eye(m, (m + 1) // 2)))
    ends = 2.0 * share.sum() - (share[-1] if m % 2 else 0.0)
    return float(ends + (n - m) * share[-1])


def gcv_score(square_sum: float, *, spent: float, n: int) -> float:
    """Compute the generalised cross-validation score of a smoother (Craven & Wahba 1979).

    ``(square_sum / n) / (1 - spent / n)^2``. Where noise is white its minimum estimates the
    smoothing with the smallest error. Noise that is correlated in time, as a tracker's often
    is, looks like signal to it: then it smooths too little.

    Parameters
    ----------
    square_sum : float
        Sum of the squared differences between the samples and the smoothed ones.
    spent : float
        Parameters spent; see :func:`effective_parameters`.
    n : int
        Number of samples.

    Returns
    -------
    float
        The score; infinite where as many parameters are spent as there are samples.
    """
    left = n - spent
    return square_sum * n / left**2 if left > 1e-9 * n else float("inf")


def find_lowest(score: Callable[[float], float], low_hz: float, high_hz: float) -> float:
    """Find the cut-off with the lowest score: along a logarithmic grid, then between its steps.

    Parameters
    ----------
    score : callable
        Score of a cut-off in Hz.
    low_hz, high_hz : float
        Ends of the search, in Hz.

    Returns
    -------
    float
        The cut-off, in Hz, to about a thousandth of itself; an end of the search where the
        score falls all the way to it.
    """
    grid = np.geomspace(low_hz, high_hz, 60)
    scores = np.array([score(float(cutoff)) for cutoff in grid])
    best = int(np.argmin(scores))
    if best in (0, len(grid) - 1):
        return float(grid[best])
    found = minimize_scalar(
        lambda logarithm: score(float(np.exp(logarithm))),
        bounds=(np.log(grid[best - 1]), np.log(grid[best + 1])),
        method="bounded",
        options={"xatol": 1e-3},
    )
    return float(np.exp(found.x)) if found.fun <= scores[best] else float(grid[best])
