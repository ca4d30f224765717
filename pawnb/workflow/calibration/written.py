"""The files of a calibration: ``DLTcoefs.csv`` and, where a lens bends, ``lenses.toml``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.io.cameras import Camera, coefs_of_cameras
from pawnb.io.cameras_out import write_lenses
from pawnb.io.coefs import write_coefs


@dataclass(frozen=True)
class Written:
    """Files of a calibration.

    Parameters
    ----------
    views : tuple of str
        Names of the cameras, in the order of the columns.
    coefs : ndarray, shape (11, n_views)
        DLT coefficients in pawnb's pixels of the straightened pictures.
    origin : ndarray, shape (3,)
        Where their origin lies in the axes of the cameras.
    out : Path
        The file of coefficients.
    lenses : Path or None
        The file of lenses, where one bends.
    remarks : tuple of str
        What a person should know of the cameras.
    """

    views: tuple[str, ...]
    coefs: np.ndarray
    origin: np.ndarray
    out: Path
    lenses: Path | None
    remarks: tuple[str, ...] = ()

    def text(self) -> str:
        """Return the cameras, what a person should know, and :meth:`lines`."""
        return "\n".join([*tell_cameras(self.views, self.origin), *self.remarks, *self.lines()])

    def files(self) -> list[str]:
        """Return what was written."""
        return [str(path) for path in (self.out, self.lenses) if path is not None]

    def lines(self) -> list[str]:
        """Return what was written, and the lines that name it in ``trial.toml``."""
        lines = [f"wrote {path}" for path in self.files()]
        said = [f'dlt = "{self.out.name}"', 'pixels = "file"']
        if self.lenses is not None:
            said.append(f'lens = "{self.lenses.name}"')
        lines.append(
            f"name them in trial.toml, its views in this order: [calibration] {'; '.join(said)}"
        )
        return lines


def find_copies(cameras: Sequence[Camera]) -> list[tuple[str, str]]:
    """Name pairs of cameras that are one: the same place, direction and lens.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras.

    Returns
    -------
    list of (str, str)
        Their names.
    """
    return [
        (one.name, other.name)
        for i, one in enumerate(cameras)
        for other in cameras[i + 1 :]
        if np.array_equal(one.matrix, other.matrix)
        and np.array_equal(one.rotation, other.rotation)
        and np.array_equal(one.translation, other.translation)
    ]


def write_calibration(cameras: Sequence[Camera], out: str | Path) -> Written:
    """Write cameras as DLT coefficients, and their lenses beside them.

    Parameters
    ----------
    cameras : sequence of Camera
        The cameras, in the order of the trial's views.
    out : str or Path
        The file of coefficients, usually ``DLTcoefs.csv``.

    Returns
    -------
    Written
        What was written.
    """
    out = Path(out)
    coefs, origin = coefs_of_cameras(cameras)
    write_coefs(coefs, out)
    lenses = None
    if not all(camera.is_straight for camera in cameras):
        lenses = write_lenses(cameras, out.with_name("lenses.toml"))
    remarks = tuple(
        f"cameras {a!r} and {b!r} are the same: one is a copy of the other, and shows nothing "
        "where it was filmed; calibrate again, or see which by --board."
        for a, b in find_copies(cameras)
    )
    names = tuple(camera.name for camera in cameras)
    return Written(names, coefs, origin, out, lenses, remarks)


def tell_cameras(views: Sequence[str], origin: FloatArray) -> list[str]:
    """Return lines on the cameras, and on their origin (3,) where coefficients have another one."""
    lines = [f"{len(views)} cameras: {', '.join(views)}"]
    if origin.any():
        x, y, z = origin
        lines.append(f"positions are counted from ({x:g}, {y:g}, {z:g}) of the file: a "
                     "camera that stands at its origin has no DLT coefficients")  # fmt: skip
    return lines
