"""Tracks of DeepLabCut: csv or h5, one animal or several."""

from __future__ import annotations

from pathlib import Path

from pawnb.io.movement import from_movement, load_with_movement
from pawnb.schema import Tracks


def read_deeplabcut(path: str | Path, *, fps: float) -> Tracks:
    """Read tracks of DeepLabCut (movement does the reading).

    Parameters
    ----------
    path : str or Path
        The csv (header lines scorer, individuals for several animals, bodyparts, coords) or
        the h5 of the same video.
    fps : float
        Frames per second of the recording; the file does not say.

    Returns
    -------
    xarray.Dataset
        Tracks in px, confidence is DeepLabCut's likelihood. Pixels are taken as they are.

    Raises
    ------
    InputError
        If the file is missing or is not of DeepLabCut.
    """
    dataset = load_with_movement("from_dlc_file", path, fps=fps, program="DeepLabCut")
    return from_movement(dataset, fps=fps, where=Path(path).name)
