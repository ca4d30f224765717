"""Lens distortion: read ``lenses.toml``, straighten the region asked for.

The model is OpenCV's (Brown-Conrady: radial k1, k2, k3..k6, tangential p1, p2, thin
prism, tilt). The straightened picture keeps the camera matrix and the size.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.pixels.colour import Picture
from pawnb.errors import CalibrationError, InputError, VideoError, did_you_mean
from pawnb.files import read_toml
from pawnb.io.cameras import Camera, read_cameras
from pawnb.trial import Trial

_FIELDS = ("matrix", "distortion", "size")
_COUNTS = (4, 5, 8, 12, 14)
_INT16 = (-(2**15), 2**15 - 1)


@dataclass(frozen=True, kw_only=True)
class Lens:
    """Matrix and distortion of one camera.

    Parameters
    ----------
    matrix : tuple of tuple of float
        3 x 3 camera matrix in px of the whole, unmirrored picture.
    distortion : tuple of float
        4, 5, 8, 12 or 14 coefficients in OpenCV's order k1, k2, p1, p2, k3, ...
    size : tuple of int, optional
        Width and height of the pictures that it was measured with, px.
    """

    matrix: tuple[tuple[float, ...], ...]
    distortion: tuple[float, ...]
    size: tuple[int, int] | None = None

    def straighten(self, uv: FloatArray) -> FloatArray:
        """Return where positions (..., 2) of the filmed picture lie in the straightened one."""
        uv = np.asarray(uv, float)
        matrix = np.array(self.matrix)
        flat = uv.reshape(-1, 1, 2)
        straight = np.full_like(flat, np.nan)
        known = np.isfinite(flat).all(axis=(1, 2))
        if known.any():  # OpenCV refuses an empty list
            straight[known] = cv2.undistortPoints(
                flat[known], matrix, np.array(self.distortion), P=matrix
            )
        return straight.reshape(uv.shape)


def load_lenses(path: str | Path) -> dict[str, Lens]:
    """Read ``lenses.toml``: a section per view with ``matrix``, ``distortion`` and ``size``.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    dict of str to Lens
        One lens a view.

    Raises
    ------
    InputError
        If the file is missing, is not TOML, holds cameras of another program, or a section is
        not a lens.
    """
    path = Path(path)
    document = read_toml(path, expected="the lenses.toml that [calibration] lens names")
    if any(isinstance(section, dict) and "rotation" in section for section in document.values()):
        raise InputError(
            f"{path.name}: holds whole cameras, as Anipose writes them; expected lenses alone. In "
            f'a trial such a file is named by anipose = "{path.name}" instead of dlt and lens.'
        )
    return {name: _lens(section, f"{path.name}: [{name}]") for name, section in document.items()}


def cameras_of_views(trial: Trial, names: Sequence[str]) -> dict[str, Camera]:
    """Return the cameras of another program's calibration, by the views of a trial.

    Parameters
    ----------
    trial : Trial
        Its ``[calibration] anipose`` or ``opencv`` names the file.
    names : sequence of str
        Views.

    Returns
    -------
    dict of str to Camera
        A camera a view, in that order.

    Raises
    ------
    CalibrationError
        If the file cannot be read, or no camera is called as a view is.
    """
    file = trial.calibration.cameras if trial.calibration is not None else None
    found = {camera.name: camera for camera in read_cameras(trial.path(file or ""))}
    for name in names:
        if name not in found:
            raise CalibrationError(
                f"{file}: no camera {name!r}{did_you_mean(name, found)}; it has "
                f"{', '.join(found)}: call the views so, or the cameras as the views."
            )
    return {name: found[name] for name in names}


def lenses_of_views(trial: Trial, names: Sequence[str]) -> dict[str, Lens]:
    """Return the lenses of views: of ``lenses.toml``, or of another program's calibration.

    Parameters
    ----------
    trial : Trial
        The trial.
    names : sequence of str
        Its views.

    Returns
    -------
    dict of str to Lens
        One a view; without those that bend nothing where the calibration is another program's;
        empty where the trial names neither.

    Raises
    ------
    InputError
        If the file cannot be read, or lacks a view.
    """
    calibration = trial.calibration
    if calibration is None:
        return {}
    if calibration.cameras is not None:
        return {
            name: Lens(
                matrix=tuple(tuple(float(x) for x in row) for row in camera.matrix),
                distortion=camera.distortion,
                size=camera.size,
            )
            for name, camera in cameras_of_views(trial, names).items()
            if not camera.is_straight
        }
    if calibration.lens is None:
        return {}
    lenses = load_lenses(trial.path(calibration.lens))
    for name in names:
        if name not in lenses:
            raise VideoError(
                f"{calibration.lens}: no section [{name}]{did_you_mean(name, lenses)}; expected "
                "one for each view."
            )
    return lenses


def _lens(section: Any, where: str) -> Lens:
    """Check one section."""
    if not isinstance(section, dict):
        raise InputError(f"{where}: expected a section with matrix and distortion.")
    for name in section:
        if name not in _FIELDS:
            raise InputError(
                f"{where}: unknown field {name!r}{did_you_mean(name, _FIELDS)}; known are "
                f"{', '.join(_FIELDS)}."
            )
    matrix = _numbers(section.get("matrix"))
    if matrix is None or matrix.shape != (3, 3):
        raise InputError(f"{where}: matrix is {section.get('matrix')!r}; expected 3 rows of 3.")
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0 and (matrix[2] == (0, 0, 1)).all()):
        raise InputError(
            f"{where}: matrix is {section['matrix']!r}; expected "
            "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above 0."
        )
    distortion = _numbers(section.get("distortion"))
    if distortion is None or distortion.ndim != 1 or len(distortion) not in _COUNTS:
        raise InputError(
            f"{where}: distortion is {section.get('distortion')!r}; expected "
            f"{', '.join(map(str, _COUNTS[:-1]))} or {_COUNTS[-1]} numbers."
        )
    rows = tuple(tuple(float(x) for x in row) for row in matrix)
    size = section.get("size")
    if size is not None and not (
        isinstance(size, list) and len(size) == 2 and all(type(x) is int and x > 0 for x in size)
    ):
        raise InputError(f"{where}: size is {size!r}; expected width and height in px, or nothing.")
    return Lens(
        matrix=rows,
        distortion=tuple(float(x) for x in distortion),
        size=None if size is None else (size[0], size[1]),
    )


def _numbers(value: Any) -> np.ndarray | None:
    """Return finite numbers as an array, or None where the value is anything else."""
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None
    return numbers if numbers.ndim and np.isfinite(numbers).all() else None


class StraightPicture:
    """A picture without its lens distortion (bilinear; black where nothing was filmed).

    Parameters
    ----------
    picture : Picture
        The picture as filmed.
    lens : Lens
        Its lens.
    """

    def __init__(self, picture: Picture, lens: Lens) -> None:
        self._picture = picture
        self._maps = _maps(lens, picture.width, picture.height)
        self.width, self.height = picture.width, picture.height
        self.is_colour = picture.is_colour

    def region(self, u0: int, v0: int, u1: int, v1: int) -> AnyArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """
        whole, fraction = (m[v0:v1, u0:u1] for m in self._maps)
        # only what the region draws upon is converted; whole-pixel shifts keep it exact
        left, right = _span(whole[..., 0], self.width)
        top, bottom = _span(whole[..., 1], self.height)
        shifted = np.clip(whole - np.array([left, top]), *_INT16).astype(np.int16)
        return cv2.remap(
            self._picture.region(left, top, right, bottom),
            shifted,
            np.ascontiguousarray(fraction),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=0,
        )


def _span(positions: np.ndarray, size: int) -> tuple[int, int]:
    """Return the half-open span of source pixels, inside the picture and not empty."""
    low = min(max(int(positions.min()), 0), size - 1)
    return low, max(min(int(positions.max()) + 2, size), low + 1)


@functools.lru_cache(maxsize=16)
def _maps(lens: Lens, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where each straight pixel lies in the filmed picture, in fixed point."""
    matrix = np.array(lens.matrix)
    whole, fraction = cv2.initUndistortRectifyMap(
        matrix, np.array(lens.distortion), None, matrix, (width, height), cv2.CV_16SC2
    )
    return whole, fraction
