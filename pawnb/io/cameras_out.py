"""Calibrated cameras written: for Anipose, and as lenses of the views of a trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w
from scipy.spatial.transform import Rotation

from pawnb.files import write_whole
from pawnb.io.cameras import Camera


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
