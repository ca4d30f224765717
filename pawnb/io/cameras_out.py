"""Calibrated cameras written: for Anipose, for OpenCV, and as lenses of the views of a trial."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from scipy.spatial.transform import Rotation

from pawnb.errors import CalibrationError
from pawnb.files import write_whole
from pawnb.io.cameras import Camera

_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
"""Names that a FileStorage of OpenCV takes."""


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


def write_lenses(cameras: Sequence[Camera], path: str | Path) -> Path:
    """Write ``lenses.toml``: matrix and distortion of each view.

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
        }
        for camera in cameras
    }
    return write_whole(path, tomli_w.dumps(document).encode())


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


def _matrix(name: str, values: np.ndarray) -> list[str]:
    """Return a matrix in the words of a FileStorage."""
    numbers = ", ".join(repr(float(x)) for x in values.ravel())
    rows, cols = values.shape
    head = [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {cols}", "   dt: d"]
    return [*head, f"   data: [ {numbers} ]"]
