"""DLT coefficients of one view, fitted to points of known position."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, Points2D, Points3D
from pawnb.core.dlt.projection import reprojection_error
from pawnb.errors import CalibrationError

MIN_POINTS = 6
"""Six points give twelve equations for the eleven coefficients."""

FLAT_SHARE = 1e-3
"""A point set is called flat if its depth is below this fraction of its length."""

_UNDETERMINED = 1e-4
"""Second smallest over largest singular value of the normalised equations below which
more than one camera fits; a calibration frame of ordinary shape has 0.05 or more."""


class DltFit(NamedTuple):
    """A fitted view: ``coefs`` (11,) and ``residual_px`` (n_points,), in px."""

    coefs: FloatArray
    residual_px: FloatArray


def fit_dlt(xyz: Points3D, uv: Points2D, *, refine: bool = True) -> DltFit:
    """Fit the coefficients of one view to points of known position.

    World and image coordinates are centred and scaled first (Hartley & Zisserman 2004,
    Alg. 7.1), so that the result does not depend on the unit or origin of the world. The
    linear solution minimises an algebraic error; ``refine`` then minimises the
    reprojection error in px by Gauss-Newton steps (Levenberg-Marquardt damping), which
    is the maximum-likelihood fit for equal noise in u and v.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Known positions, at least six and not all in one plane.
    uv : ndarray, shape (n_points, 2)
        Where the view sees them, in px.
    refine : bool
        Whether to minimise the reprojection error after the linear solution.

    Returns
    -------
    DltFit
        ``coefs`` (11,) and the reprojection error ``residual_px`` (n_points,) in px.

    Raises
    ------
    CalibrationError
        If the points do not determine the view, with the reason: too few, duplicated,
        not a number, on one line, in one plane, or otherwise undetermined.
    """
    xyz, uv = np.asarray(xyz, dtype=float), np.asarray(uv, dtype=float)
    _check_points(xyz, uv)
    to_world, world = _normalise(xyz)
    to_image, image = _normalise(uv)
    P = _solve_linear(world, image)
    if refine:
        P = _refine(P, world, image)
    depth = np.c_[world, np.ones(len(world))] @ P[2]
    if depth.min() * depth.max() <= 0:
        raise CalibrationError(
            "the points do not fit any view (some would lie behind the camera); check that "
            "each click belongs to its point, and give more points, spread in depth."
        )
    P = np.linalg.solve(to_image, P @ to_world)
    # L12 is the depth of the world's origin: compare it with that of the points
    depths = np.abs(np.c_[xyz, np.ones(len(xyz))] @ P[2])
    if abs(P[2, 3]) < 1e-9 * depths.max():
        raise CalibrationError(
            "the origin of the points' coordinates lies beside the camera, where DLT "
            "coefficients do not exist; move the origin into the filmed space."
        )
    coefs = (P / P[2, 3]).ravel()[:11]
    return DltFit(coefs, reprojection_error(coefs, xyz, uv[:, None, :])[:, 0])


def _check_points(xyz: Points3D, uv: Points2D) -> None:
    """Refuse point sets that cannot determine a view, saying why."""
    if xyz.ndim != 2 or xyz.shape[1:] != (3,) or uv.shape != (len(xyz), 2):
        raise CalibrationError(
            f"points have shape {xyz.shape} and image positions {uv.shape}; expected (n, 3) "
            "and (n, 2)."
        )
    bad = np.flatnonzero(~(np.isfinite(xyz).all(axis=1) & np.isfinite(uv).all(axis=1)))
    if bad.size:
        raise CalibrationError(
            f"calibration point {bad[0] + 1} has a coordinate that is not a number; leave out "
            "points that are not seen."
        )
    if len(xyz) < MIN_POINTS:
        raise CalibrationError(
            f"{len(xyz)} calibration points; at least {MIN_POINTS} are needed, not all in one "
            "plane."
        )
    different = len(np.unique(xyz, axis=0))
    if different < MIN_POINTS:
        raise CalibrationError(
            f"{len(xyz)} calibration points, but only {different} different positions (the "
            f"others are duplicated); at least {MIN_POINTS} different ones are needed."
        )
    depth = np.linalg.svd(xyz - xyz.mean(axis=0), compute_uv=False)
    if depth[1] <= FLAT_SHARE * depth[0]:
        raise CalibrationError(
            "the calibration points lie on one line; use points spread in all three directions."
        )
    if _is_flat(xyz):
        raise CalibrationError(
            "the calibration points lie in one plane; add points in front of or behind it."
        )
    if any(_is_flat(np.delete(xyz, i, axis=0)) for i in range(len(xyz))):
        raise CalibrationError(
            "all calibration points but one lie in one plane; add points in front of or behind it."
        )
    spread = np.linalg.svd(uv - uv.mean(axis=0), compute_uv=False)
    if spread[1] <= FLAT_SHARE * spread[0]:
        raise CalibrationError(
            "the clicks of the calibration points lie on one line in the picture; check them, "
            "or use points spread over the picture."
        )


def _is_flat(xyz: Points3D) -> bool:
    """Say whether points lie in one plane."""
    depth = np.linalg.svd(xyz - xyz.mean(axis=0), compute_uv=False)
    return bool(depth[2] <= FLAT_SHARE * depth[0])


def _normalise(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the similarity that centres points and scales them to unit RMS, and its result."""
    n, d = points.shape
    centre = points.mean(axis=0)
    scale = 1.0 / np.sqrt(((points - centre) ** 2).sum() / (n * d))
    T = np.eye(d + 1)
    T[:d, :d] *= scale
    T[:d, d] = -scale * centre
    return T, (points - centre) * scale


def _solve_linear(world: FloatArray, image: FloatArray) -> np.ndarray:
    """Solve the homogeneous DLT equations of normalised points for the 3 × 4 matrix."""
    n = len(world)
    X = np.c_[world, np.ones(n)]
    A = np.zeros((2 * n, 12))
    A[0::2, 0:4] = X
    A[1::2, 4:8] = X
    A[0::2, 8:12] = -image[:, :1] * X
    A[1::2, 8:12] = -image[:, 1:] * X
    _, s, Vt = np.linalg.svd(A)
    if s[10] < _UNDETERMINED * s[0]:
        raise CalibrationError(
            "the calibration points do not determine the view (more than one camera would see "
            "them so); add points, spread in all three directions."
        )
    return Vt[11].reshape(3, 4)


def _refine(P: np.ndarray, world: np.ndarray, image: np.ndarray, steps: int = 30) -> np.ndarray:
    """Minimise the reprojection error of normalised points from a linear solution."""
    X = np.c_[world, np.ones(len(world))]
    p = (P / np.linalg.norm(P)).ravel()
    damping = 1e-3
    error, J = _residual_and_jacobian(p, X, image)
    cost = error @ error
    for _ in range(steps):
        H = J.T @ J
        # the scale of p has no effect on the image: hold it by the last row
        A = np.r_[H + damping * np.diag(np.diag(H) + 1e-12), [p]]
        step = np.linalg.lstsq(A, np.r_[-J.T @ error, 0.0], rcond=None)[0]
        trial = (p + step) / np.linalg.norm(p + step)
        error_new, J_new = _residual_and_jacobian(trial, X, image)
        cost_new = error_new @ error_new
        if np.isfinite(cost_new) and cost_new <= cost:
            done = cost - cost_new <= 1e-14 * max(cost, 1e-30) or np.abs(step).max() < 1e-13
            p, error, J, cost = trial, error_new, J_new, cost_new
            damping = max(damping / 10, 1e-12)
            if done:
                break
        else:
            damping *= 10
    return p.reshape(3, 4)


def _residual_and_jacobian(
    p: np.ndarray, X: np.ndarray, image: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return reprojection residuals (2n,) and their derivative (2n, 12) at matrix p."""
    P = p.reshape(3, 4)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / (X @ P[2])
        predicted = (X @ P[:2].T) * inverse[:, None]
        scaled = X * inverse[:, None]
    J = np.zeros((2 * len(X), 12))
    J[0::2, 0:4] = scaled
    J[1::2, 4:8] = scaled
    J[0::2, 8:12] = -predicted[:, :1] * scaled
    J[1::2, 8:12] = -predicted[:, 1:] * scaled
    return (predicted - image).ravel(), J
