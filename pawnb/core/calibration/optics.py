"""Cameras as rows of numbers: pinhole, radial and tangential distortion, and where each stands.

The model is OpenCV's (Brown-Conrady, k1, k2, p1, p2, k3), for many observations at once.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from pawnb.arrays import FloatArray, Points2D, Points3D
from pawnb.errors import CalibrationError
from pawnb.io.cameras import Camera

OPTICS_COLUMNS = (
    "aspect", "f", "cx", "cy", "k1", "k2", "p1", "p2", "k3",
    "rx", "ry", "rz", "tx", "ty", "tz",
)  # fmt: skip
"""``aspect`` is fy / fx; f, cx, cy in px; r a rotation vector; t in the unit of the board."""

LENS = slice(0, 9)
POSE = slice(9, 15)


def project_distorted(cameras: FloatArray, xyz: FloatArray) -> FloatArray:
    """Project points through lenses that bend, each by its own camera.

    Parameters
    ----------
    cameras : ndarray, shape (n, 15)
        A camera an observation, columns as :data:`OPTICS_COLUMNS`.
    xyz : ndarray, shape (n, 3)
        Its point.

    Returns
    -------
    ndarray, shape (n, 2)
        u and v of the picture as filmed, px.
    """
    X = rotate(cameras[:, 9:12], xyz) + cameras[:, 12:15]
    depth = np.where(np.abs(X[:, 2]) < 1e-9, 1e-9, X[:, 2])
    x, y = X[:, 0] / depth, X[:, 1] / depth
    aspect, f, cx, cy, k1, k2, p1, p2, k3 = cameras[:, LENS].T
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    bent_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    bent_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return np.stack([f * bent_x + cx, f * aspect * bent_y + cy], axis=1)


def show_points(camera: Camera, xyz: Points3D) -> Points2D:
    """Return where a camera, as filmed, shows points, and only those that it can show.

    Parameters
    ----------
    camera : Camera
        A camera whose lens has at most k1, k2, p1, p2, k3.
    xyz : ndarray, shape (n, 3)
        Points in space.

    Returns
    -------
    ndarray, shape (n, 2)
        u and v, px; NaN behind the camera, and so far aside that the lens would turn back: there
        its coefficients, found within the picture, say nothing.
    """
    row = row_of_camera(camera)
    X = xyz @ camera.rotation.T + camera.translation
    before = X[:, 2] > 0
    r2 = (X[:, :2] ** 2).sum(axis=1) / np.where(before, X[:, 2], 1.0) ** 2
    k1, k2, _, _, k3 = row[4:9]
    turns = np.roots([7.0 * k3, 5.0 * k2, 3.0 * k1, 1.0])  # of r (1 + k1 r^2 + ...), over r^2
    real = turns.real[(np.abs(turns.imag) < 1e-9) & (turns.real > 0)]
    shown = project_distorted(np.tile(row, (len(xyz), 1)), xyz)
    return np.where((before & (r2 < real.min(initial=np.inf)))[:, None], shown, np.nan)


def rotate(rotvec: FloatArray, xyz: FloatArray) -> FloatArray:
    """Turn points (n, 3), each by its own rotation vector (n, 3)."""
    angle = np.linalg.norm(rotvec, axis=1, keepdims=True)
    axis = rotvec / np.where(angle > 0, angle, 1.0)
    along = (axis * xyz).sum(axis=1, keepdims=True)
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * xyz + sin * np.cross(axis, xyz) + (1.0 - cos) * along * axis


def row_of_camera(camera: Camera) -> FloatArray:
    """Return a camera as a row of numbers.

    Parameters
    ----------
    camera : Camera
        A camera whose lens has at most k1, k2, p1, p2, k3.

    Returns
    -------
    ndarray, shape (15,)
        Columns as :data:`OPTICS_COLUMNS`.

    Raises
    ------
    CalibrationError
        If the lens has further coefficients, or the picture is sheared.
    """
    if any(camera.distortion[5:]) or camera.matrix[0, 1]:
        raise CalibrationError(
            f"camera {camera.name!r} has a lens of more than k1, k2, p1, p2, k3, or sheared "
            "pixels; calibrate again with the five usual coefficients."
        )
    K = camera.matrix
    bent = np.zeros(5)
    bent[: len(camera.distortion)] = camera.distortion[:5]
    rotvec = Rotation.from_matrix(camera.rotation).as_rotvec()
    return np.r_[K[1, 1] / K[0, 0], K[0, 0], K[0, 2], K[1, 2], bent, rotvec, camera.translation]


def camera_of_row(row: FloatArray, *, name: str, size: tuple[int, int]) -> Camera:
    """Return the camera that a row of numbers is.

    Parameters
    ----------
    row : ndarray, shape (15,)
        Columns as :data:`OPTICS_COLUMNS`.
    name : str
        Its name.
    size : tuple of int
        Width and height of its picture, px.

    Returns
    -------
    Camera
        The camera.
    """
    return Camera(
        name=name,
        matrix=np.array([[row[1], 0.0, row[2]], [0.0, row[0] * row[1], row[3]], [0.0, 0.0, 1.0]]),
        distortion=tuple(float(x) for x in row[4:9]) if row[4:9].any() else (),
        rotation=Rotation.from_rotvec(row[9:12]).as_matrix(),
        translation=np.array(row[12:15]),
        size=size,
    )


def moved(row: FloatArray, rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """Return a camera as it stands in other axes.

    Parameters
    ----------
    row : ndarray, shape (15,)
        The camera.
    rotation : ndarray, shape (3, 3)
    translation : ndarray, shape (3,)
        Old positions are ``rotation @ new + translation``.

    Returns
    -------
    ndarray, shape (15,)
        The same camera in the new axes.
    """
    R = Rotation.from_rotvec(row[9:12]).as_matrix()
    out = row.copy()
    out[9:12] = Rotation.from_matrix(R @ rotation).as_rotvec()
    out[12:15] = R @ translation + row[12:15]
    return out
