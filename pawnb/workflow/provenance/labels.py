"""How the record of a run calls its inputs: by their places in the folder that holds them all."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path


def label_inputs(paths: Sequence[Path]) -> dict[Path, str]:
    """Name the inputs of a run without any absolute path.

    Parameters
    ----------
    paths : sequence of Path
        The files.

    Returns
    -------
    dict
        Each file to its path from the folder that holds them all, which is at least its own
        folder's name and its own, with ``/`` between: ``m1/results/tracks.nc``. Where no folder
        holds them all (other drives), only these two.
    """
    absolute = {path: path.resolve() for path in paths}
    try:
        base = Path(os.path.commonpath([path.parent for path in absolute.values()]))
    except ValueError:  # other drives, or no input at all
        return {path: f"{own.parent.name}/{own.name}" for path, own in absolute.items()}
    if any(path.parent == base for path in absolute.values()):
        base = base.parent
    return {path: own.relative_to(base).as_posix() for path, own in absolute.items()}


def is_labelled(path: Path, label: str) -> bool:
    """Say whether a file may be the input of a label: whether it lies where the label says."""
    parts = path.resolve().parts
    told = Path(label).parts
    return parts[-len(told) :] == told
