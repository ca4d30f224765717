"""Tracks of SLEAP: ``.slp`` or the analysis ``.h5``."""

from __future__ import annotations

from pathlib import Path

from pawnb.io.movement import from_movement, load_with_movement
from pawnb.schema import Tracks


def read_sleap(path: str | Path, *, fps: float) -> Tracks:
    """Read tracks of SLEAP (movement does the reading).

    Parameters
    ----------
    path : str or Path
        Predictions as ``.slp``, or SLEAP's analysis export ``.h5``.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in px with one individual for each of SLEAP's tracks, confidence is the point's
        score. Pixels are taken as they are.

    Raises
    ------
    InputError
        If the file is missing or is not of SLEAP.
    """
    dataset = load_with_movement("from_sleap_file", path, fps=fps, program="SLEAP")
    return from_movement(dataset, fps=fps, where=Path(path).name)
