"""Bundle adjustment: cameras and what they saw, made to agree in px.

A robust least squares (scipy, trust region) over the cameras and the structure: boards that moved
as rigid bodies, points of a wand that are a known distance apart, or points that are known. The
Jacobian is sparse: an observation depends on its camera and on its own board or point only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix, lil_matrix

from pawnb.arrays import BoolArray, FloatArray, IntArray, Points3D
from pawnb.core.calibration.optics import project_distorted, rotate

_ROBUST_PX = 1.0
"""Residuals above it weigh less (soft L1). Corners of a board are found to 0.1 to 0.5 px (measured
on mouse-4cam-cage), so that only what does not belong is above."""

_CONVERGED = 1e-6
"""Relative change of the cost and of the numbers at which it ends: on mouse-4cam-cage cameras then
move by less than 0.01 mm to where 1e-8 ends, in an eighth of the time."""
_MOST_BUNDLE_STEPS = 200


@dataclass(frozen=True)
class ViewObservations:
    """What was seen.

    Parameters
    ----------
    view : ndarray of int, shape (n,)
        The view.
    place : ndarray of int, shape (n,)
        The point of the structure.
    uv : ndarray, shape (n, 2)
        Where, px of the picture as filmed.
    """

    view: IntArray
    place: IntArray
    uv: FloatArray


class Structure(Protocol):
    """What the cameras look at, described by a vector of free numbers."""

    def start(self) -> FloatArray:
        """Return the free numbers to begin with."""

    def points(self, free: FloatArray) -> Points3D:
        """Return where all points are, shape (n_points, 3)."""

    def columns(self, place: IntArray) -> IntArray:
        """Return which free numbers each point depends on, shape (n, k)."""

    def beside(self, xyz: Points3D) -> FloatArray:
        """Return residuals that come with the points themselves, px."""

    def beside_columns(self) -> IntArray:
        """Return which free numbers each of those depends on, shape (m, k)."""


@dataclass(frozen=True)
class Boards:
    """Boards that moved as rigid bodies: a rotation vector and a translation each.

    Parameters
    ----------
    poses : ndarray, shape (n_shots, 6)
        Where they are at first.
    corners : ndarray, shape (n_corners, 3)
        Corners on the board. Point ``shot * n_corners + corner`` is that corner in that shot.
    """

    poses: FloatArray
    corners: FloatArray

    def start(self) -> FloatArray:
        """Return the poses."""
        return self.poses.ravel()

    def points(self, free: FloatArray) -> FloatArray:
        """Return where the corners of all shots are."""
        poses = np.repeat(free.reshape(-1, 6), len(self.corners), axis=0)
        corners = np.tile(self.corners, (len(free) // 6, 1))
        return rotate(poses[:, :3], corners) + poses[:, 3:]

    def columns(self, place: IntArray) -> IntArray:
        """Return the pose of the shot of each point."""
        return 6 * (place // len(self.corners))[:, None] + np.arange(6)

    def beside(self, xyz: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return nothing: rigid boards have no residual of their own."""
        return np.zeros(0)

    def beside_columns(self) -> IntArray:
        """Return nothing."""
        return np.zeros((0, 6), int)


@dataclass(frozen=True)
class KnownPoints:
    """Points of known position.

    Parameters
    ----------
    xyz : ndarray, shape (n_points, 3)
        The positions.
    """

    xyz: Points3D

    def start(self) -> FloatArray:
        """Return nothing: no number is free."""
        return np.zeros(0)

    def points(self, free: FloatArray) -> Points3D:  # noqa: ARG002
        """Return the positions."""
        return self.xyz

    def columns(self, place: IntArray) -> IntArray:
        """Return nothing."""
        return np.zeros((len(place), 0), int)

    def beside(self, xyz: Points3D) -> FloatArray:  # noqa: ARG002
        """Return nothing."""
        return np.zeros(0)

    def beside_columns(self) -> IntArray:
        """Return nothing."""
        return np.zeros((0, 0), int)


@dataclass(frozen=True)
class Adjusted:
    """What agrees best.

    Parameters
    ----------
    cameras : ndarray, shape (n_views, 15)
        The cameras.
    free : ndarray
        The free numbers of the structure.
    xyz : ndarray, shape (n_points, 3)
        Its points.
    """

    cameras: FloatArray
    free: FloatArray
    xyz: FloatArray

    def errors(self, seen: ViewObservations) -> FloatArray:
        """Return how far, px, each observation is from where its camera shows its point."""
        shown = project_distorted(self.cameras[seen.view], self.xyz[seen.place])
        return np.hypot(*(shown - seen.uv).T)


def adjust(
    seen: ViewObservations, cameras: FloatArray, structure: Structure, *, is_free: BoolArray
) -> Adjusted:
    """Adjust cameras and structure to each other.

    Parameters
    ----------
    seen : ViewObservations
        What was seen.
    cameras : ndarray, shape (n_views, 15)
        Cameras to begin with.
    structure : Structure
        What they look at.
    is_free : ndarray of bool, shape (n_views, 15)
        Which numbers of the cameras may change.

    Returns
    -------
    Adjusted
        Cameras and structure of the least robust error.
    """
    n_free = int(is_free.sum())

    def parts(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        rows = cameras.copy()
        rows[is_free] = vector[:n_free]
        return rows, structure.points(vector[n_free:])

    def residuals(vector: FloatArray) -> FloatArray:
        rows, xyz = parts(vector)
        off = project_distorted(rows[seen.view], xyz[seen.place]) - seen.uv
        return np.r_[off.ravel(), structure.beside(xyz)]

    start = np.r_[cameras[is_free], structure.start()]
    if len(start):
        start = least_squares(
            residuals,
            start,
            jac_sparsity=_sparsity(seen, structure, is_free, len(start)),
            x_scale="jac",
            loss="soft_l1",
            f_scale=_ROBUST_PX,
            max_nfev=_MOST_BUNDLE_STEPS,
            ftol=_CONVERGED,
            xtol=_CONVERGED,
        ).x
    rows, xyz = parts(start)
    return Adjusted(rows, start[n_free:], xyz)


def _sparsity(
    seen: ViewObservations, structure: Structure, is_free: BoolArray, n: int
) -> csr_matrix:
    """Return where the Jacobian is not zero."""
    number = np.full(is_free.shape, -1)
    number[is_free] = np.arange(is_free.sum())
    beside = structure.beside_columns()
    depends = lil_matrix((2 * len(seen.view) + len(beside), n), dtype=np.int8)
    own = np.hstack([number[seen.view], is_free.sum() + structure.columns(seen.place)])
    rows = np.repeat(np.arange(len(own)), own.shape[1]).reshape(own.shape)
    filled = own >= 0
    for axis in (0, 1):
        depends[2 * rows[filled] + axis, own[filled]] = 1
    for i, columns in enumerate(beside):
        depends[2 * len(seen.view) + i, is_free.sum() + columns] = 1
    return depends.tocsr()
