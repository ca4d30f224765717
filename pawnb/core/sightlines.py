"""Lines of sight of calibrated views: where cameras look, and epipolar lines."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, Points2D
from pawnb.core import dlt


def find_look_point(coefs: FloatArray) -> AnyArray:
    """Return the point nearest in least squares to the optical axes of all views.

    The optical axis of a view is the line through its principal point: along
    (L9, L10, L11), or for an affine view, which has no centre, along the normal of both
    image directions. A weak pull towards the origin decides where axes are parallel.

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        DLT coefficients.

    Returns
    -------
    ndarray, shape (3,)
        The point, in the unit of the calibration.
    """
    A, b = np.zeros((3, 3)), np.zeros(3)
    for L in coefs.T:
        axis = L[8:11]
        size = axis @ axis
        if size < 1e-18 * (L[0:3] @ L[0:3] + L[4:7] @ L[4:7]):
            continue  # affine: u changes alike everywhere
        centre_uv = np.array([L[0:3] @ axis, L[4:7] @ axis]) / size
        planes = np.stack([L[0:3] - centre_uv[0] * axis, L[4:7] - centre_uv[1] * axis])
        on_axis = np.linalg.lstsq(planes, centre_uv - L[[3, 7]], rcond=None)[0]
        across = np.eye(3) - np.outer(axis, axis) / size
        A += across
        b += across @ on_axis
    return np.linalg.solve(A + 1e-6 * np.eye(3), b)


def find_epipolar_line(
    L_from: FloatArray, uv: Points2D, L_to: FloatArray, *, size: tuple[int, int]
) -> FloatArray:
    """Return the ends of the line in one view on which a point seen in another must lie.

    Parameters
    ----------
    L_from, L_to : ndarray, shape (11,)
        DLT coefficients of the view in which the point was seen, and of the other.
    uv : ndarray, shape (2,)
        Where it was seen, px.
    size : tuple of int
        Width and height in px of the other picture.

    Returns
    -------
    ndarray, shape (2, 2)
        Two ends (u, v) within the picture, NaN where the line misses it or there is none.
    """
    P_from, P_to = dlt.to_matrix(L_from), dlt.to_matrix(L_to)
    u, v = np.asarray(uv, dtype=float)
    planes = _sight_planes(P_from, u, v)
    along = np.cross(planes[0, :3], planes[1, :3])
    near = np.linalg.lstsq(planes[:, :3], -planes[:, 3], rcond=None)[0]
    ends = np.stack([P_to @ np.append(near, 1.0), P_to @ np.append(along, 0.0)])
    ends /= np.linalg.norm(ends, axis=1, keepdims=True)
    return _clip_line(np.cross(*ends), size)


def find_nearest_on_sight_line(L: FloatArray, uv: Points2D, xyz: FloatArray) -> AnyArray:
    """Return the point of a line of sight that is nearest to a point in space.

    Parameters
    ----------
    L : ndarray, shape (11,)
        DLT coefficients of the view.
    uv : ndarray, shape (2,)
        Where the line is seen in it, px.
    xyz : ndarray, shape (3,)
        The point in space, in the unit of the calibration.

    Returns
    -------
    ndarray, shape (3,)
        The nearest point, which the view sees at ``uv``.
    """
    planes = _sight_planes(dlt.to_matrix(L), *np.asarray(uv, dtype=float))
    off = planes @ np.append(xyz, 1.0)
    return np.asarray(xyz, dtype=float) - np.linalg.lstsq(planes[:, :3], off, rcond=None)[0]


def _sight_planes(P: FloatArray, u: float, v: float) -> FloatArray:
    """Return the planes (2, 4) through a camera that give u and v: they meet in the line."""
    return np.stack([P[0] - u * P[2], P[1] - v * P[2]])


def find_fundamental_matrix(P_from: FloatArray, P_to: FloatArray) -> FloatArray:
    """Return the matrix that takes a place in one view to its epipolar line in another.

    Parameters
    ----------
    P_from, P_to : ndarray, shape (3, 4)
        Projection matrices of the view in which a point was seen, and of the other; the first
        may be affine.

    Returns
    -------
    ndarray, shape (3, 3)
        F of norm 1: the line a u + b v + c = 0 has (a, b, c) = F (u, v, 1) of the other view
        (Hartley & Zisserman 2004, equation 9.1).
    """
    _, _, Vt = np.linalg.svd(P_from)
    e = P_to @ Vt[3]
    cross = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    F = cross @ P_to @ np.linalg.pinv(P_from)
    return np.asarray(F / np.linalg.norm(F))


def _clip_line(line: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return the ends within a picture of the line a u + b v + c = 0, or NaN."""
    a, b, c = line
    nothing = np.full((2, 2), np.nan)
    scale = np.hypot(a, b)
    if not np.isfinite(line).all() or scale <= 1e-12 * abs(c):
        return nothing
    low, high = np.array([-0.5, -0.5]), np.array([size[0] - 0.5, size[1] - 0.5])
    foot = -c * np.array([a, b]) / scale**2
    along = np.array([-b, a]) / scale
    start, end = -np.inf, np.inf
    for i in range(2):
        if along[i] == 0:
            if not low[i] <= foot[i] <= high[i]:
                return nothing
            continue
        ends = sorted([(low[i] - foot[i]) / along[i], (high[i] - foot[i]) / along[i]])
        start, end = max(start, ends[0]), min(end, ends[1])
    return np.stack([foot + start * along, foot + end * along]) if start < end else nothing
