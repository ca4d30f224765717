"""Calibrated cameras written: for Anipose, OpenCV, XMALab, and as lenses of a trial's views."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from scipy.spatial.transform import Rotation

from pawnb.errors import CalibrationError
from pawnb.files import write_whole
from pawnb.io.cameras import Camera
from pawnb.schema.arguments import checked_arguments

_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
"""Names that a FileStorage of OpenCV takes."""


@checked_arguments
def write_cameras(cameras: Sequence[Camera], path: str | Path) -> Path:
    """Write cameras as ``calibration.toml`` of Anipose, lens distortion included.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras.
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file; reading it gives the same numbers, but for the last digit of a rotation.

    Examples
    --------
    >>> pawnb.io.write_cameras(cameras, "calibration.toml").name
    'calibration.toml'
    """
    document: dict[str, Any] = {}
    for i, camera in enumerate(cameras):
        section: dict[str, Any] = {"name": camera.name}
        if camera.size is not None:
            section["size"] = list(camera.size)
        straight = camera.distortion or (0.0,) * 5
        section |= {
            "matrix": camera.matrix.tolist(),
            "distortions": list(straight),
            "rotation": Rotation.from_matrix(camera.rotation).as_rotvec().tolist(),
            "translation": camera.translation.tolist(),
        }
        document[f"cam_{i}"] = section
    document["metadata"] = {}
    return write_whole(path, tomli_w.dumps(document).encode())


@checked_arguments
def write_lenses(cameras: Sequence[Camera], path: str | Path) -> Path:
    """Write ``lenses.toml``: matrix and distortion of each view, and the size of its pictures.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras.
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file, which ``[calibration] lens`` names.

    Examples
    --------
    >>> pawnb.io.write_lenses(cameras, "lenses.toml").name
    'lenses.toml'
    """
    document: Mapping[str, Any] = {
        camera.name: {
            "matrix": camera.matrix.tolist(),
            "distortion": list(camera.distortion or (0.0,) * 5),
            **({} if camera.size is None else {"size": list(camera.size)}),
        }
        for camera in cameras
    }
    return write_whole(path, tomli_w.dumps(document).encode())


@checked_arguments
def write_opencv_cameras(cameras: Sequence[Camera], path: str | Path) -> Path:
    """Write cameras as OpenCV: matrices ``K_<camera>, dist_<camera>, Rot_<camera>, T_<camera>``.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras.
    path : str or Path
        The file, ``.yaml`` or ``.yml``.

    Returns
    -------
    Path
        The file; ``cv2.FileStorage`` and :func:`pawnb.io.read_cameras` give the same numbers.

    Raises
    ------
    CalibrationError
        If a camera's name cannot be one in such a file.

    Examples
    --------
    >>> path = pawnb.io.write_opencv_cameras(cameras, "cameras.yaml")
    >>> [camera.name for camera in pawnb.io.read_cameras(path)]
    ['cam1', 'cam2']
    """
    lines = ["%YAML:1.0", "---"]
    for camera in cameras:
        if not _KEY.fullmatch(camera.name):
            raise CalibrationError(
                f"camera {camera.name!r}: OpenCV's files take names of letters, digits, - and _ "
                "only; rename the view."
            )
        parts = {
            "K": camera.matrix,
            "dist": np.array([camera.distortion or (0.0,) * 5]),
            "Rot": camera.rotation,
            "T": camera.translation.reshape(3, 1),
        }
        for word, values in parts.items():
            lines += _matrix(f"{word}_{camera.name}", np.asarray(values, dtype=float))
    return write_whole(path, ("\n".join(lines) + "\n").encode())


@checked_arguments
def write_mayacam(camera: Camera, path: str | Path) -> Path:
    """Write a camera as MayaCam 2.0, as XMALab exports it and Autoscoper reads it.

    Parameters
    ----------
    camera : Camera
        The camera.
    path : str or Path
        The file, ``.txt``; reading it takes its name for the camera's.

    Returns
    -------
    Path
        The file; reading it gives the same numbers.

    Raises
    ------
    CalibrationError
        If the lens bends, which the file cannot hold, or the size of the picture is not known.

    Examples
    --------
    >>> straight = pawnb.io.Camera(name="cam1", matrix=matrix, distortion=(), rotation=np.eye(3),
    ...                            translation=np.array([0.0, 0.0, 500.0]), size=(640, 480))
    >>> pawnb.io.write_mayacam(straight, "cam1.txt").name
    'cam1.txt'
    """
    check_mayacam(camera)
    width, height = camera.size or (0, 0)
    # Autoscoper counts the lines: one empty line between the parts, no more
    parts = {
        "image size": [f"{width},{height}"],
        "camera matrix": [_row(row) for row in camera.matrix],
        "rotation": [_row(row) for row in camera.rotation],
        "translation": [_row([x]) for x in camera.translation],
    }
    text = "\n".join("\n".join([head, *rows, ""]) for head, rows in parts.items())
    return write_whole(path, text.encode())


def check_mayacam(camera: Camera) -> None:
    """Refuse a camera that MayaCam 2.0 cannot hold.

    Parameters
    ----------
    camera : Camera
        The camera.

    Raises
    ------
    CalibrationError
        If its lens bends, or the size of its picture is not known.
    """
    if not camera.is_straight:
        raise CalibrationError(
            f"camera {camera.name!r}: its lens bends the picture, which MayaCam 2.0 cannot hold "
            "(XMALab takes pictures that are straight); write Anipose's or OpenCV's file instead."
        )
    if camera.size is None:
        raise CalibrationError(
            f"camera {camera.name!r}: MayaCam 2.0 says the size of the picture, and this "
            "calibration does not; take one that does (Anipose, Pose2Sim, XMALab)."
        )


def _row(values: Iterable[float]) -> str:
    """Return numbers with as few digits as give them back exactly."""
    return ",".join(repr(float(x)) for x in values)


def _matrix(name: str, values: np.ndarray) -> list[str]:
    """Return a matrix in the words of a FileStorage."""
    numbers = ", ".join(repr(float(x)) for x in values.ravel())
    rows, cols = values.shape
    head = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {cols}", "   dt: d"]
    return [*head, f"   data: [ {numbers} ]"]
