"""``pawnb calibrate FILE``: another program's calibration as DLT coefficients and lenses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.core.dlt import transform_image
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.files import read_text
from pawnb.io.cameras import Camera, read_cameras
from pawnb.io.coefs import read_coefs, write_coefs
from pawnb.workflow.calibration.written import Written, write_calibration

COEFFICIENTS = ("dltdv", "dltdv7", "easywand", "argus", "xmalab")
"""Programs that write DLT coefficients: DLTdv 8 counts pixels down from 1, DLTdv 7 and older,
easyWand and XMALab up from 1, Argus up from 0."""


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
        For coefficients, one of :data:`COEFFICIENTS`.
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
    if _is_coefs(Path(path)):
        coefs, names = _moved_coefs(Path(path), program, views, heights_px)
        write_coefs(coefs, out)
        return Written(tuple(names), coefs, np.zeros(3), out, None)
    if program is not None:
        raise InputError(
            f"{Path(path).name} holds cameras, which say themselves whose they are; --from is for "
            "DLT coefficients."
        )
    return write_calibration(_chosen(read_cameras(path, *more), views), out)


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
) -> tuple[np.ndarray, list[str]]:
    """Return coefficients moved to pawnb's pixels, and the names of their views."""
    if program not in COEFFICIENTS:
        near = did_you_mean(program, COEFFICIENTS) if program else ""
        raise InputError(
            f"{path.name}: DLT coefficients do not say in whose pixels they are; say whose with "
            f"--from {', '.join(COEFFICIENTS)}{near}."
        )
    n = len(read_text(path).lstrip().split("\n")[0].split(","))
    names = list(views or [f"cam{i + 1}" for i in range(n)])
    coefs = read_coefs(path, names)
    if program != "dltdv" and (heights_px is None or len(heights_px) not in (1, n)):
        raise InputError(
            f"{path.name}: {program} counts v upwards from the lower edge; give the height of the "
            f"pictures of its {n} cameras in px (--heights)."
        )
    columns = []
    for i, column in enumerate(coefs.T):
        first = 0.0 if program == "argus" else 1.0
        H = np.array([[1.0, 0.0, -first], [0.0, 1.0, -first], [0.0, 0.0, 1.0]])
        if program != "dltdv" and heights_px is not None:
            H[1] = [0.0, -1.0, heights_px[i if len(heights_px) > 1 else 0]]
        columns.append(transform_image(column, H))
    return np.stack(columns, axis=1), names


def _chosen(cameras: list[Camera], views: Sequence[str] | None) -> list[Camera]:
    """Return the cameras that are named, in that order."""
    found = {camera.name: camera for camera in cameras}
    for name in views or ():
        if name not in found:
            raise InputError(
                f"no camera {name!r}{did_you_mean(name, found)}; there are {', '.join(found)}."
            )
    return cameras if views is None else [found[name] for name in views]
