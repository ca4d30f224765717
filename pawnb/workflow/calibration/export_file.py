"""``pawnb calibrate FILE --to PROGRAM``: a calibration as another program reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.io.cameras import Camera, coefs_of_cameras
from pawnb.io.cameras_out import (
    check_mayacam,
    write_cameras,
    write_mayacam,
    write_opencv_cameras,
)
from pawnb.io.coefs import write_coefs
from pawnb.workflow.calibration.calibrate_file import read_calibration
from pawnb.workflow.calibration.program_pixels import COEFFICIENTS, move_coefs
from pawnb.workflow.calibration.written import tell_cameras

CAMERA_FILES = ("anipose", "opencv", "mayacam")
"""Programs whose files hold cameras: Pose2Sim reads Anipose's, XMALab and Autoscoper MayaCam."""

TARGETS = (*CAMERA_FILES, *COEFFICIENTS)
"""What ``--to`` takes."""


@dataclass(frozen=True)
class Exported:
    """Files that were written for another program.

    Parameters
    ----------
    views : tuple of str
        Names of the cameras, in order.
    origin : ndarray, shape (3,)
        Where the origin of coefficients lies in the axes of the cameras.
    paths : tuple of Path
        The files.
    """

    views: tuple[str, ...]
    origin: FloatArray
    paths: tuple[Path, ...]

    def text(self) -> str:
        """Return the cameras, and what was written."""
        told = tell_cameras(self.views, self.origin)
        return "\n".join([*told, *(f"wrote {path}" for path in self.paths)])


def export_calibration(
    path: str | Path,
    *more: str | Path,
    out: str | Path,
    to: str,
    program: str | None = None,
    views: Sequence[str] | None = None,
    heights_px: Sequence[int] | None = None,
) -> Exported:
    """Write a calibration as another program reads it.

    Parameters
    ----------
    path : str or Path
        Cameras or coefficients, as for
        :func:`pawnb.workflow.calibration.calibrate_file.calibrate_from_file`.
    *more : str or Path
        Further files, one a camera.
    out : str or Path
        The file; for MayaCam, which holds one camera, the folder of ``<camera>.txt``.
    to : str
        One of :data:`TARGETS`.
    program : str, optional
        For coefficients, whose they are.
    views : sequence of str, optional
        Cameras to keep, in order; for coefficients the names of the columns.
    heights_px : sequence of int, optional
        Heights of the pictures (one of all, or one a view), for coefficients counted upwards;
        default those that the cameras say.

    Returns
    -------
    Exported
        What was written.

    Raises
    ------
    InputError
        If the program is not known, or heights are needed and not known.
    CalibrationError
        If the program's file cannot hold the calibration, or a file cannot be read.
    """
    if to not in TARGETS:
        raise InputError(
            f"no calibration is written for {to!r}{did_you_mean(to, TARGETS)}; expected --to and "
            f"one of {', '.join(TARGETS)}."
        )
    out, where = Path(out), Path(path).name
    if out.exists() and any(out.samefile(one) for one in (path, *more)):
        raise InputError(f"{out}: that is the calibration itself; name another file with -o.")
    found, names = read_calibration(
        path, *more, program=program, views=views, heights_px=heights_px
    )
    if to in COEFFICIENTS:
        coefs, origin = _straight_coefs(found) if isinstance(found, list) else (found, np.zeros(3))
        known = [c.size[1] for c in found if c.size] if isinstance(found, list) else []
        heights = heights_px or (known if len(known) == len(names) else None)
        moved = move_coefs(coefs, to, heights, where=where)
        return Exported(tuple(names), origin, (write_coefs(moved, out),))
    if not isinstance(found, list):
        raise CalibrationError(
            f"{where}: DLT coefficients say neither lenses nor the size of the pictures, which "
            f"{to} needs; name a file of cameras, or one of {', '.join(COEFFICIENTS)} with --to."
        )
    return Exported(tuple(names), np.zeros(3), _write_cameras(found, out, to))


def _straight_coefs(cameras: Sequence[Camera]) -> tuple[FloatArray, FloatArray]:
    """Return coefficients and their origin; a lens that bends has none."""
    bent = next((camera.name for camera in cameras if not camera.is_straight), None)
    if bent is not None:
        raise CalibrationError(
            f"camera {bent!r}: its lens bends the picture, which DLT coefficients cannot hold; "
            f"write {', '.join(CAMERA_FILES[:2])} with --to, or straighten the pictures first."
        )
    return coefs_of_cameras(cameras)


def _write_cameras(cameras: Sequence[Camera], out: Path, to: str) -> tuple[Path, ...]:
    """Write files of cameras; all of them or none."""
    suffixes = {"anipose": (".toml",), "opencv": (".yaml", ".yml"), "mayacam": ("",)}[to]
    if out.suffix not in suffixes:
        what = f"a file {' or '.join(suffixes)}" if to != "mayacam" else \
            "a folder, for MayaCam has one file a camera"  # fmt: skip
        raise InputError(f"{out}: name {what} with -o for --to {to}.")
    if to == "anipose":
        return (write_cameras(cameras, out),)
    if to == "opencv":
        return (write_opencv_cameras(cameras, out),)
    for camera in cameras:
        check_mayacam(camera)
        if Path(camera.name).name != camera.name:
            raise InputError(
                f"camera {camera.name!r}: its name cannot be one of a file; rename the camera."
            )
    out.mkdir(exist_ok=True)
    return tuple(write_mayacam(camera, out / f"{camera.name}.txt") for camera in cameras)
