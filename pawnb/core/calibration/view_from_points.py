"""One view calibrated by points of known position, with or without a lens that bends."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.linalg import rq

from pawnb.arrays import BoolArray, FloatArray, Points2D, Points3D
from pawnb.core import dlt
from pawnb.core.calibration.bundle import KnownPoints, ViewObservations, adjust
from pawnb.core.calibration.optics import (
    OPTICS_COLUMNS,
    POSE,
    camera_of_row,
    show_points,
)
from pawnb.errors import CalibrationError
from pawnb.io.cameras import Camera, coefs_of_cameras

FEWEST_FOR_LENS = 8
"""Sixteen equations for eight numbers of a camera whose lens bends: focal length, k1, place."""


@dataclass(frozen=True, kw_only=True)
class ViewFit:
    """A view that known points determine.

    Parameters
    ----------
    coefs : ndarray, shape (11,)
        DLT coefficients of the straightened picture.
    camera : Camera or None
        The camera whose lens bends; None where lines are taken to be straight.
    inside : ndarray, shape (3,)
        A place before the camera: the middle of the points.
    residual_px : ndarray, shape (n_points,)
        How far each click is from where the view shows its point.
    """

    coefs: FloatArray
    camera: Camera | None
    inside: BoolArray
    residual_px: FloatArray

    def show(self, xyz: Points3D) -> Points2D:
        """Return where the picture as filmed shows points.

        Parameters
        ----------
        xyz : ndarray, shape (n, 3)
            Points in space.

        Returns
        -------
        ndarray, shape (n, 2)
            u and v, px; NaN behind the camera.
        """
        if self.camera is not None:
            return show_points(self.camera, xyz)
        depth = xyz @ self.coefs[8:11] + 1.0
        before = depth * (self.inside @ self.coefs[8:11] + 1.0) > 0
        return np.where(before[:, None], dlt.project(self.coefs, xyz)[:, 0], np.nan)


def fit_view(xyz: Points3D, uv: Points2D, *, size: tuple[int, int], bends: bool = False) -> ViewFit:
    """Calibrate a view by points of known position.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        Known positions, six or more, not in one plane; eight for a lens that bends.
    uv : ndarray, shape (n_points, 2)
        Where the view sees them, px of the picture as filmed.
    size : tuple of int
        Width and height of the picture, px.
    bends : bool
        Whether the lens bends straight lines: then focal length, k1 and the place of a camera with
        square pixels and its centre in that of the picture are adjusted, instead of eleven
        coefficients.

    Returns
    -------
    ViewFit
        The view.

    Raises
    ------
    CalibrationError
        If the points do not determine it.
    """
    linear = dlt.fit_dlt(xyz, uv)
    inside = xyz.mean(axis=0)
    if not bends:
        return ViewFit(
            coefs=linear.coefs, camera=None, inside=inside, residual_px=linear.residual_px
        )
    if len(xyz) < FEWEST_FOR_LENS:
        raise CalibrationError(
            f"{len(xyz)} calibration points; at least {FEWEST_FOR_LENS} are needed for a lens that "
            "bends."
        )
    if dlt.handedness(linear.coefs, xyz)[0] < 0:
        raise CalibrationError(
            "the view shows the points mirrored: the axes of their positions are left-handed, or "
            "the picture is that of a mirror, and no lens is found for either."
        )
    row = _begin(linear.coefs, xyz, uv, size)
    is_free = np.zeros((1, len(OPTICS_COLUMNS)), bool)
    is_free[0, [OPTICS_COLUMNS.index("f"), OPTICS_COLUMNS.index("k1")]] = True
    is_free[0, POSE] = True
    n = len(xyz)
    seen = ViewObservations(np.zeros(n, int), np.arange(n), uv)
    found = adjust(seen, row[None], KnownPoints(xyz), is_free=is_free)
    camera = camera_of_row(found.cameras[0], name="view", size=size)
    coefs, origin = coefs_of_cameras([camera])
    if origin.any():
        raise CalibrationError(
            "the origin of the points' coordinates lies beside the camera, where DLT coefficients "
            "do not exist; move the origin into the filmed space."
        )
    return ViewFit(coefs=coefs[:, 0], camera=camera, inside=inside, residual_px=found.errors(seen))


def _begin(coefs: np.ndarray, xyz: np.ndarray, uv: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a camera with the focal length of the coefficients, where it sees the points best."""
    K, _ = rq(dlt.to_matrix(coefs)[:, :3])
    f = float(np.mean(np.abs(np.diag(K)[:2] / K[2, 2])))
    centre = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    matrix = np.array([[f, 0.0, centre[0]], [0.0, f, centre[1]], [0.0, 0.0, 1.0]])
    found, rvec, tvec = cv2.solvePnP(xyz, uv, matrix, None, flags=cv2.SOLVEPNP_SQPNP)
    if not found:
        raise CalibrationError("no camera sees the points so; check that each click is on its own.")
    row = np.zeros(len(OPTICS_COLUMNS))
    row[:4] = 1.0, f, *centre
    row[POSE] = np.r_[rvec.ravel(), tvec.ravel()]
    return row
