"""Projection into views, triangulation, and changes of pixels, from DLT coefficients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray, Points2D, Points3D
from pawnb.errors import CalibrationError

MOST_COEF = 1e12
"""Coefficients of cameras in use lie below 1e6, whatever the unit."""

_PARALLEL = 1e-9
"""Smallest over largest singular value below which rays do not cross."""

_LEAST_CONVERGENCE = 0.01
"""Lines of sight that converge by less than this, as a share of the distance, are parallel: how a
view shows depth is then not known."""
_MOST_OBLIQUE = 0.2
"""Cosine of the angle of a picture's axes, and log of their scales, up to which it is of a camera:
pixels are square, and what is beyond is perspective that was fitted to the errors of clicks."""
_LONGEST_FOCAL_PX = 1e6
"""Views of a longer focal length have no perspective that could be distinguished from none."""


class Triangulation(NamedTuple):
    """Points in space and how well they fit; every array has the shape of the input.

    ``xyz`` (..., 3) in the unit of the calibration; ``residual_px`` (...) the RMS distance
    in px between image positions and reprojections over the views used; ``dltres`` (...)
    DLTdv's algebraic residual, sqrt(sum((A x - b)^2) / (2 n_views - 3)); ``n_views`` (...)
    the number of views in which the point is seen. Where fewer than two views see a
    point, or their rays do not cross, ``xyz`` and the residuals are NaN.
    """

    xyz: np.ndarray
    residual_px: np.ndarray
    dltres: np.ndarray
    n_views: np.ndarray


def project(coefs: FloatArray, xyz: FloatArray) -> FloatArray:
    """Project points into every view.

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        DLT coefficients; (11,) is one view.
    xyz : ndarray, shape (..., 3)
        Points in the unit of the calibration; NaN where unknown.

    Returns
    -------
    ndarray, shape (..., n_views, 2)
        u and v in px; NaN where the point is unknown or lies in the plane through the
        camera that has no image.
    """
    coefs = _as_coefs(coefs)
    xyz = np.asarray(xyz, dtype=float)
    weight = xyz @ coefs[8:11] + 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (xyz @ coefs[0:3] + coefs[3]) / weight
        v = (xyz @ coefs[4:7] + coefs[7]) / weight
    uv = np.stack([u, v], axis=-1)
    return np.where(np.isfinite(uv).all(axis=-1, keepdims=True), uv, np.nan)


def reprojection_error(coefs: FloatArray, xyz: Points3D, uv: Points2D) -> FloatArray:
    """Return the distance in px between image positions and reprojected points.

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        DLT coefficients.
    xyz : ndarray, shape (..., 3)
        Points in the unit of the calibration.
    uv : ndarray, shape (..., n_views, 2)
        Where they were seen, in px.

    Returns
    -------
    ndarray, shape (..., n_views)
        Distance in px; NaN where the point was not seen or is unknown.
    """
    return np.hypot(*np.moveaxis(project(coefs, xyz) - np.asarray(uv, dtype=float), -1, 0))


def triangulate(
    coefs: FloatArray, uv: AnyArray, *, refine: bool = False, even: bool = False
) -> Triangulation:
    """Find points in space from where two or more views see them.

    Linear least squares on the DLT equations of all views that see the point, as DLTdv
    does (Hedrick 2008). Equations of views that do not see it are set to zero, so that
    points with any pattern of missing views are solved together.

    The linear solution weighs a view by the inverse of its distance from the origin of
    the calibration, which is harmless where all cameras are about equally far from it.
    Where one is much nearer, or the origin lies outside the filmed space, ``even`` weighs
    all views alike, wherever the origin lies, and ``refine`` goes on to the smallest
    reprojection error (Gauss-Newton).

    Parameters
    ----------
    coefs : ndarray, shape (11, n_views)
        DLT coefficients.
    uv : ndarray, shape (..., n_views, 2)
        Image positions in px, NaN where a view does not see the point.
    refine : bool
        Whether to minimise the reprojection error after the linear solution.
    even : bool
        Whether each view's equations are scaled to the depth in front of its own camera,
        which makes (L9, L10, L11) a unit vector, instead of that of the origin, as Anipose
        and OpenCV do. ``dltres`` is DLTdv's in any case. Views without perspective have no
        such depth: with one among them nothing is scaled.

    Returns
    -------
    Triangulation
        ``xyz``, ``residual_px``, ``dltres`` and ``n_views``. A point seen by fewer than
        two views has NaN for position and residuals.

    Raises
    ------
    CalibrationError
        If the number of views differs between ``coefs`` and ``uv``.
    """
    coefs = _as_coefs(coefs)
    uv = np.asarray(uv, dtype=float)
    n = coefs.shape[1]
    if uv.ndim < 2 or uv.shape[-2:] != (n, 2):
        raise CalibrationError(
            f"image positions have shape {uv.shape}; expected (..., {n}, 2) for the {n} "
            "views of the calibration."
        )
    shape = uv.shape[:-2]
    uv = np.asarray(uv.reshape(-1, n, 2), float)
    seen = np.asarray(np.isfinite(uv).all(axis=-1))
    n_views = seen.sum(axis=-1)
    # (L1 - u L9) X + (L2 - u L10) Y + (L3 - u L11) Z = u - L4, and the same for v
    A = _rows(coefs) - np.where(seen[..., None], uv, 0.0)[..., None] * coefs[8:11].T[:, None]
    b = uv - np.stack([coefs[3], coefs[7]], axis=-1)
    A, b = _blank(A, b, seen)
    scale = np.repeat(_depth_scale(coefs) if even else np.ones(n), 2)
    xyz = _solve(A * scale[:, None], b * scale)
    xyz[n_views < 2] = np.nan
    if refine:
        xyz = _refine_points(coefs, uv, seen, xyz)
    squares = ((np.einsum("pri,pi->pr", A, xyz) - b) ** 2).sum(axis=-1)
    dltres = np.sqrt(squares / np.maximum(2 * n_views - 3, 1))
    residual_px = np.sqrt(_square_error(coefs, uv, seen, xyz) / np.maximum(n_views, 1))
    return Triangulation(
        xyz.reshape(*shape, 3),
        residual_px.reshape(shape),
        dltres.reshape(shape),
        n_views.reshape(shape),
    )


def _depth_scale(coefs: FloatArray) -> FloatArray:
    """Return what makes (L9, L10, L11) of each view a unit vector; 1 where one is none."""
    length = np.linalg.norm(coefs[8:11], axis=0)
    flat = length * _LONGEST_FOCAL_PX < np.linalg.norm(coefs[0:3], axis=0)
    return np.ones(len(length)) if flat.any() else length.mean() / length


def _rows(coefs: FloatArray) -> FloatArray:
    """Return L1..L3 and L5..L7 of every view as (n_views, 2, 3)."""
    return np.stack([coefs[0:3].T, coefs[4:7].T], axis=1)


def _blank(A: FloatArray, b: FloatArray, seen: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Zero the equations of views that do not see a point; return (p, 2n, 3) and (p, 2n)."""
    p, n = seen.shape
    A = np.where(seen[..., None, None], A, 0.0).reshape(p, 2 * n, 3)
    return A, np.where(seen[..., None], b, 0.0).reshape(p, 2 * n)


def _solve(A: FloatArray, b: FloatArray) -> FloatArray:
    """Solve A x = b for many points by least squares; NaN where rays do not cross."""
    U, s, Vt = np.linalg.svd(A, full_matrices=False)
    good = s[:, 2] > _PARALLEL * s[:, 0]
    inverse = np.divide(1.0, s, out=np.full_like(s, np.nan), where=good[:, None])
    return np.einsum("pji,pj->pi", Vt, inverse * np.einsum("pri,pr->pi", U, b))


def _square_error(coefs: FloatArray, uv: Points2D, seen: BoolArray, xyz: Points3D) -> FloatArray:
    """Return the summed square distance in px² of each point; NaN where it is unknown."""
    squares = np.where(seen, reprojection_error(coefs, xyz, uv) ** 2, 0.0).sum(axis=-1)
    return np.where(np.isfinite(xyz).all(axis=-1), squares, np.nan)


def _refine_points(
    coefs: FloatArray, uv: Points2D, seen: BoolArray, xyz: Points3D, steps: int = 10
) -> FloatArray:
    """Lower the reprojection error of triangulated points; a step that raises it is undone."""
    cost = _square_error(coefs, uv, seen, xyz)
    for _ in range(steps):
        uv_now = project(coefs, xyz)
        weight = (xyz @ coefs[8:11] + 1.0)[..., None, None]
        J = (_rows(coefs) - uv_now[..., None] * coefs[8:11].T[:, None]) / weight
        known = seen & np.isfinite(uv_now).all(axis=-1)
        trial = xyz + _solve(*_blank(J, uv - uv_now, known))
        cost_new = _square_error(coefs, uv, seen, trial)
        better = cost_new < cost  # NaN compares false
        if not better.any():
            break
        xyz = np.where(better[:, None], trial, xyz)
        cost = np.where(better, cost_new, cost)
    return xyz


def transform_image(coefs: FloatArray, homography: FloatArray) -> FloatArray:
    """Return coefficients for image positions that went through a homography.

    Parameters
    ----------
    coefs : ndarray, shape (11,)
        DLT coefficients of one view.
    homography : ndarray, shape (3, 3)
        Maps (u, v, 1) before to (u, v, 1) after, up to scale; for instance a crop or a
        mirror.

    Returns
    -------
    ndarray, shape (11,)
        Coefficients whose projection is the homography of the former projection.

    Raises
    ------
    CalibrationError
        If the result cannot be written with L12 = 1.
    """
    P = np.asarray(homography, dtype=float) @ to_matrix(coefs)
    if not np.isfinite(P).all() or abs(P[2, 3]) < 1e-12 * np.abs(P[2]).max():
        raise CalibrationError(
            "this change of pixels leaves no DLT coefficients with L12 = 1; check the coefficients."
        )
    return (P / P[2, 3]).ravel()[:11]


def check_coefs(coefs: FloatArray, *, where: str) -> None:
    """Refuse coefficients that are those of no camera.

    Parameters
    ----------
    coefs : ndarray, shape (11,)
        DLT coefficients of one view.
    where : str
        Whose they are, for the message.

    Raises
    ------
    CalibrationError
        If one is not a finite number or far too large, or if u and v do not change in two
        different directions of space.
    """
    large = np.flatnonzero(~(np.abs(coefs) <= MOST_COEF))
    if len(large):
        k = int(large[0])
        raise CalibrationError(
            f"{where}: the coefficient L{k + 1} is {coefs[k]:g}, which is that of no camera; "
            "calibrate again."
        )
    # seen from where L9 X + L10 Y + L11 Z = 0, as at the origin
    singular = np.linalg.svd(np.stack([coefs[0:3], coefs[4:7]]), compute_uv=False)
    if not singular[1] > _PARALLEL * singular[0]:
        raise CalibrationError(
            f"{where}: the coefficients L1 to L3 and L5 to L7 are those of no camera: u and v do "
            "not change in two directions of space; calibrate again."
        )


def handedness(coefs: FloatArray, xyz: Points3D) -> IntArray:
    """Tell whether views show space as it is or mirrored.

    A camera that is not mirrored has ``det(R) = 1`` (Hartley & Zisserman 2004, section 6.2), so
    that the determinant of its first three columns is positive where points lie before it. It is
    negative where space has left-handed axes or the picture is that of a mirror.

    Parameters
    ----------
    coefs : ndarray, shape (11, V)
        DLT coefficients, v down.
    xyz : ndarray, shape (n, 3)
        Points that the views see, two or more.

    Returns
    -------
    ndarray of int, shape (V,)
        1 as it is, -1 mirrored, 0 where it cannot be told: lines of sight are parallel, or so
        nearly that what the coefficients say of perspective is that of no camera.
    """
    coefs = _as_coefs(coefs)
    xyz = np.asarray(xyz, dtype=float)
    depth = np.median(1.0 + xyz @ coefs[8:11], axis=0)
    size = np.linalg.norm(np.ptp(xyz, axis=0))
    converge = np.linalg.norm(coefs[8:11], axis=0) * size / np.abs(depth)
    matrix = np.stack([coefs[0:3], coefs[4:7], coefs[8:11]]).transpose(2, 0, 1)
    sign = np.sign(np.linalg.det(matrix)) * np.sign(depth)
    told = (converge >= _LEAST_CONVERGENCE) & [_has_square_pixels(one) for one in matrix]
    return np.where(told, sign, 0).astype(int)


def _has_square_pixels(matrix: FloatArray) -> bool:
    """Say whether a view's first three columns (3, 3) are nearly those of square pixels."""
    u, v, axis = matrix
    depth = np.linalg.norm(axis)
    if depth == 0:
        return False
    axis = axis / depth
    across_u, across_v = u - (u @ axis) * axis, v - (v @ axis) * axis
    wide, high = np.linalg.norm(across_u), np.linalg.norm(across_v)
    if not (wide > 0 and high > 0):
        return False
    oblique = abs(across_u @ across_v) / (wide * high)
    return bool(oblique < _MOST_OBLIQUE and abs(np.log(wide / high)) < _MOST_OBLIQUE)


def to_matrix(coefs: FloatArray) -> FloatArray:
    """Return the 3 × 4 projection matrix of one view's 11 coefficients (L12 = 1)."""
    return np.append(np.asarray(coefs, dtype=float), 1.0).reshape(3, 4)


def _as_coefs(coefs: FloatArray) -> FloatArray:
    """Return coefficients as (11, n_views)."""
    coefs = np.asarray(coefs, dtype=float)
    coefs = coefs[:, None] if coefs.ndim == 1 else coefs
    if coefs.ndim != 2 or coefs.shape[0] != 11:
        raise CalibrationError(
            f"DLT coefficients have shape {coefs.shape}; expected 11 rows, one column a view."
        )
    return coefs
