"""Cameras as a ``.yaml`` of OpenCV's FileStorage, which its other programs read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.errors import CalibrationError
from pawnb.files import write_whole
from pawnb.io.cameras import Camera

_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


def write_opencv_cameras(cameras: Sequence[Camera], path: str | Path) -> Path:
    """Write cameras as matrices ``K_<camera>, dist_<camera>, Rot_<camera>, T_<camera>``.

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


def _matrix(name: str, values: np.ndarray) -> list[str]:
    """Return a matrix in the words of a FileStorage."""
    numbers = ", ".join(repr(float(x)) for x in values.ravel())
    rows, cols = values.shape
    head = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {cols}", "   dt: d"]
    return [*head, f"   data: [ {numbers} ]"]
