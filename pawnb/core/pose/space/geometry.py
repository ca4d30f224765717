"""Sight lines of one view, met at heights along its direction of view."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, Points2D, Points3D
from pawnb.core import dlt
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.errors import CalibrationError


def view_slope(coefs: FloatArray, xyz: Points3D) -> FloatArray:
    """Return how a view's u and v change with a point.

    Parameters
    ----------
    coefs : ndarray, shape (11,)
        DLT coefficients.
    xyz : ndarray, shape (..., 3)
        Points.

    Returns
    -------
    ndarray, shape (..., 2, 3)
        px per unit of the calibration.
    """
    weight = xyz @ coefs[8:11] + 1.0
    uv = dlt.project(coefs, xyz)[..., 0, :]
    rows = np.stack([coefs[0:3], coefs[4:7]])
    return np.asarray((rows - uv[..., None] * coefs[8:11]) / weight[..., None, None])


def px_per_unit(coefs: FloatArray, xyz: Points3D) -> float:
    """Return how many px of a view one unit at a point has, across the line of sight."""
    return float(np.linalg.norm(view_slope(coefs, xyz)) / np.sqrt(2.0))


class SightLines:
    """Where in space what one view sees may be: one place for every height.

    A height is the distance from ``about`` along the view's direction at ``about``.

    Parameters
    ----------
    coefs : ndarray, shape (11,)
        DLT coefficients of the view.
    about : ndarray, shape (3,)
        A point near the animal; heights count from it.
    up : ndarray, shape (3,)
        Heights grow towards it where the view looks along it more or less.

    Attributes
    ----------
    axis : ndarray, shape (3,)
        Unit vector along which heights are counted.
    """

    def __init__(self, coefs: FloatArray, about: FloatArray, up: FloatArray) -> None:
        self.coefs, self.about = np.asarray(coefs, dtype=float), np.asarray(about, dtype=float)
        slope = view_slope(self.coefs, self.about)
        axis = np.cross(slope[0], slope[1])
        axis /= np.linalg.norm(axis)
        self.axis = axis if axis @ np.asarray(up) >= 0 else -axis

    def lines(self, uv: AnyArray) -> tuple[FloatArray, FloatArray]:
        """Return the point at height 0 and the change with height of each sight line.

        Parameters
        ----------
        uv : ndarray, shape (..., 2)
            Image positions, px; NaN where unknown.

        Returns
        -------
        start, direction : ndarray, shape (..., 3)
            The point at height h is ``start + h * direction``.
        """
        uv = np.asarray(uv, dtype=float)
        L = self.coefs
        planes = np.stack([L[0:3], L[4:7]]) - uv[..., None] * L[8:11]
        known = np.asarray(np.isfinite(uv).all(axis=-1))
        rows = np.concatenate([planes, np.broadcast_to(self.axis, (*uv.shape[:-1], 1, 3))], axis=-2)
        rows = np.where(known[..., None, None], rows, np.eye(3))
        right = np.zeros((*uv.shape[:-1], 3, 2))
        right[..., :2, 0] = uv - L[[3, 7]]
        right[..., 2, 0] = self.axis @ self.about
        right[..., 2, 1] = 1.0
        both = np.linalg.solve(rows, right)
        both = np.where(known[..., None, None], both, np.nan)
        return both[..., 0], both[..., 1]

    def at(self, uv: Points2D, height: FloatArray | float) -> FloatArray:
        """Return the points (..., 3) on the sight lines of ``uv`` (..., 2) at heights (...)."""
        start, direction = self.lines(uv)
        return np.asarray(start + np.asarray(height)[..., None] * direction)

    def height(self, xyz: Points3D) -> FloatArray:
        """Return the heights (...) of points (..., 3)."""
        return np.asarray((xyz - self.about) @ self.axis)


def check_second_view(lines: SightLines, coefs: FloatArray, names: tuple[str, str]) -> None:
    """Refuse a second view that does not show heights.

    Parameters
    ----------
    lines : SightLines
        Those of the first view.
    coefs : ndarray, shape (11,)
        DLT coefficients of the second view.
    names : tuple of str
        The first view and the second, for the message.

    Raises
    ------
    CalibrationError
        If both look in nearly the same direction.
    """
    slope = view_slope(np.asarray(coefs, dtype=float), lines.about)
    most = np.linalg.svd(slope, compute_uv=False)[0]
    share = float(np.linalg.norm(slope @ lines.axis) / most)
    if not share >= IN_SPACE.least_change:
        raise CalibrationError(
            f"views {names[0]!r} and {names[1]!r} look in nearly the same direction "
            f"({np.degrees(np.arcsin(min(share, 1.0))):.0f} degrees apart), so heights cannot be "
            "told; use views at least 12 degrees apart, best 90, or calibrate again."
        )
