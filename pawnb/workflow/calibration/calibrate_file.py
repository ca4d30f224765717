"""``pawnb calibrate FILE``: another program's calibration as DLT coefficients and lenses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.files import read_text
from pawnb.io.cameras import Camera, read_cameras
from pawnb.io.coefs import read_coefs, write_coefs
from pawnb.workflow.calibration.program_pixels import check_program, move_coefs
from pawnb.workflow.calibration.written import Written, write_calibration


def calibrate_from_file(
    path: str | Path,
    *more: str | Path,
    out: str | Path,
    program: str | None = None,
    views: Sequence[str] | None = None,
    heights_px: Sequence[int] | None = None,
) -> Written:
    """Take over the calibration of another program.

    Parameters
    ----------
    path : str or Path
        Cameras of Anipose, Pose2Sim, OpenCV or XMALab (:func:`pawnb.io.cameras.read_cameras`),
        or a csv of 11 rows of DLT coefficients, whose program is named.
    *more : str or Path
        Further files, one a camera.
    out : str or Path
        The file to write, usually ``DLTcoefs.csv``. Where a lens bends, ``lenses.toml`` is
        written beside it.
    program : str, optional
        For coefficients, one of
        :data:`pawnb.workflow.calibration.program_pixels.COEFFICIENTS`.
    views : sequence of str, optional
        Cameras to keep, in the order of the trial's views; for coefficients the names of the
        columns.
    heights_px : sequence of int, optional
        Heights of the pictures (one of all, or one a view), for coefficients counted upwards.

    Returns
    -------
    Written
        What was taken over. Coefficients belong to the whole picture, not cropped or mirrored,
        in pixels from the centre of the top-left one.

    Raises
    ------
    InputError
        If the program or the heights are needed and not given.
    CalibrationError
        If a file cannot be read.
    """
    out = Path(out)
    found, names = read_calibration(
        path, *more, program=program, views=views, heights_px=heights_px
    )
    if isinstance(found, list):
        return write_calibration(found, out)
    write_coefs(found, out)
    return Written(tuple(names), found, np.zeros(3), out, None)


def read_calibration(
    path: str | Path,
    *more: str | Path,
    program: str | None = None,
    views: Sequence[str] | None = None,
    heights_px: Sequence[int] | None = None,
) -> tuple[list[Camera] | FloatArray, list[str]]:
    """Read another program's cameras, or its coefficients in pawnb's pixels.

    Parameters
    ----------
    path, *more, program, views, heights_px
        As for :func:`calibrate_from_file`.

    Returns
    -------
    found : list of Camera, or ndarray of shape (11, n_views)
        What the files hold.
    names : list of str
        Names of the views.

    Raises
    ------
    InputError
        If the program or the heights are needed and not given.
    CalibrationError
        If a file cannot be read.
    """
    if _is_coefs(Path(path)):
        return _moved_coefs(Path(path), program, views, heights_px)
    if program is not None:
        raise InputError(
            f"{Path(path).name} holds cameras, which say themselves whose they are; --from is for "
            "DLT coefficients."
        )
    cameras = _chosen(read_cameras(path, *more), views)
    return cameras, [camera.name for camera in cameras]


def _is_coefs(path: Path) -> bool:
    """Say whether a file is a table of 11 rows of numbers."""
    if path.suffix.lower() not in (".csv", ".txt"):
        return False
    text = read_text(path, expected="a calibration", most_bytes=2**24, error=CalibrationError)
    rows = [line for line in text.split("\n") if line.strip()]
    try:
        return len(rows) == 11 and all([float(x) for x in row.split(",")] for row in rows)
    except ValueError:
        return False


def _moved_coefs(
    path: Path,
    program: str | None,
    views: Sequence[str] | None,
    heights_px: Sequence[int] | None,
) -> tuple[FloatArray, list[str]]:
    """Return coefficients moved to pawnb's pixels, and the names of their views."""
    program = check_program(program, where=path.name, option="--from")
    n = len(read_text(path).lstrip().split("\n")[0].split(","))
    names = list(views or [f"cam{i + 1}" for i in range(n)])
    coefs = read_coefs(path, names)
    return move_coefs(coefs, program, heights_px, back=True, where=path.name), names


def _chosen(cameras: list[Camera], views: Sequence[str] | None) -> list[Camera]:
    """Return the cameras that are named, in that order."""
    found = {camera.name: camera for camera in cameras}
    for name in views or ():
        if name not in found:
            raise InputError(
                f"no camera {name!r}{did_you_mean(name, found)}; there are {', '.join(found)}."
            )
    return cameras if views is None else [found[name] for name in views]
