"""Tracks of Anipose: the csv of 3D points."""

from __future__ import annotations

from pathlib import Path

from pawnb.io.movement import from_movement, load_with_movement
from pawnb.schema import Tracks

_INDIVIDUAL = "animal"


def read_anipose(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read 3D points of Anipose (movement does the reading).

    Parameters
    ----------
    path : str or Path
        A csv of ``pose-3d`` with columns ``<point>_x, _y, _z, _error, _ncams, _score`` and
        ``fnum``.
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of length of Anipose's calibration.

    Returns
    -------
    xarray.Dataset
        Tracks in space, confidence is Anipose's score.

    Raises
    ------
    InputError
        If the file is missing or is not of Anipose.
    """
    dataset = load_with_movement(
        "from_anipose_file", path, fps=fps, program="Anipose", individual_name=_INDIVIDUAL
    )
    dataset.attrs["units"] = unit
    return from_movement(dataset, fps=fps, where=Path(path).name)
