"""The inner loops of :mod:`.network_flow.triangulation`, compiled."""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled

_VANISHING_SQUARE = 40.0
"""Mathematics: beyond that square the exponential function adds nothing to a number: exp(-40) is
4e-18."""


@compiled
def triangulate(L: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Triangulate by the normal equations: quick, for hypotheses only.

    Parameters
    ----------
    L : ndarray, shape (V, 11)
        DLT coefficients of the views.
    uv : ndarray, shape (k, V, 2)
        Where each point is seen, px.

    Returns
    -------
    ndarray, shape (k, 3)
        The points; far away where rays hardly cross.
    """
    n, n_views = uv.shape[:2]
    xyz = np.empty((n, 3))
    N, z, row = np.empty((3, 3)), np.empty(3), np.empty(3)
    for k in range(n):
        N[:], z[:] = 0.0, 0.0
        for v in range(n_views):
            for c in range(2):
                for i in range(3):
                    row[i] = L[v, 4 * c + i] - uv[k, v, c] * L[v, 8 + i]
                right = uv[k, v, c] - L[v, 4 * c + 3]
                for i in range(3):
                    z[i] += row[i] * right
                    for j in range(3):
                        N[i, j] += row[i] * row[j]
        trace = N[0, 0] + N[1, 1] + N[2, 2]
        for i in range(3):
            N[i, i] += 1e-12 * trace
        _solve(N, z, xyz[k])
    return xyz


@compiled
def _solve(N: np.ndarray, z: np.ndarray, x: np.ndarray) -> None:
    """Solve three equations into ``x``; the matrix is positive, so pivots are not needed."""
    for i in range(3):
        for j in range(i + 1, 3):
            share = N[j, i] / N[i, i]
            z[j] -= share * z[i]
            for m in range(i, 3):
                N[j, m] -= share * N[i, m]
    for i in range(2, -1, -1):
        for j in range(i + 1, 3):
            z[i] -= N[i, j] * x[j]
        x[i] = z[i] / N[i, i]


@compiled
def support(
    frame: np.ndarray,
    uv: np.ndarray,
    at: np.ndarray,
    good: np.ndarray,
    is_there: np.ndarray,
    scale: np.ndarray,
) -> np.ndarray:
    """Return how much a detection of each view lies at each point (k, V), 0 to 1.

    Parameters
    ----------
    frame : ndarray of int, shape (k,)
        Frame of each point.
    uv : ndarray, shape (k, V, 2)
        Its image positions, px.
    at : ndarray, shape (n, V, C, 2)
        Detections of every frame, px.
    good, is_there : ndarray, shape (n, V, C)
        How good each is, 0 to 1, and whether it is there.
    scale : ndarray, shape (V,)
        Distance, px, at which a detection hardly counts any more.
    """
    seen = np.zeros(uv.shape[:2])
    for k in range(len(frame)):
        t = frame[k]
        for v in range(uv.shape[1]):
            best = 0.0
            for i in range(at.shape[2]):
                if is_there[t, v, i]:
                    du = (uv[k, v, 0] - at[t, v, i, 0]) / scale[v]
                    dv = (uv[k, v, 1] - at[t, v, i, 1]) / scale[v]
                    square = du * du + dv * dv
                    if square < _VANISHING_SQUARE:
                        best = max(best, good[t, v, i] * np.exp(-square))
            seen[k, v] = best
    return seen


@compiled
def distinct(xyz: np.ndarray, first: np.ndarray, apart: float, most: int) -> np.ndarray:
    """Tell which hypotheses are kept: in order, those that lie apart from the kept ones.

    Parameters
    ----------
    xyz : ndarray, shape (k, 3)
        The hypotheses, those of one frame after those of another, the best first.
    first : ndarray of int, shape (n + 1,)
        Where each frame begins.
    apart : float
        Least distance.
    most : int
        Hypotheses kept in one frame.
    """
    keep = np.zeros(len(xyz), np.bool_)
    kept = np.empty(most, np.int64)
    for t in range(len(first) - 1):
        count = 0
        for k in range(first[t], first[t + 1]):
            is_new = count < most
            for o in range(count):
                square = 0.0
                for i in range(3):
                    square += (xyz[k, i] - xyz[kept[o], i]) ** 2
                if square < apart * apart:
                    is_new = False
                    break
            if is_new:
                keep[k], kept[count] = True, k
                count += 1
    return keep
