"""How the record of a run calls its inputs: by their places in the folder that holds them all."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
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
        holds them all (other drives), as many names of folders as tell them all apart, and before
        a path that several drives have, its drive: ``e/m1/results/tracks.nc``.
    """
    absolute = {path: path.resolve() for path in paths}
    try:
        base = Path(os.path.commonpath([path.parent for path in absolute.values()]))
    except ValueError:  # other drives, or no input at all
        return _tails(absolute)
    if any(path.parent == base for path in absolute.values()):
        base = base.parent
    return {path: own.relative_to(base).as_posix() for path, own in absolute.items()}


def _tails(absolute: Mapping[Path, Path]) -> dict[Path, str]:
    """Return the shortest ends of the paths, of at least two names, that tell the files apart."""
    files = set(absolute.values())
    most = max((len(own.parts) for own in files), default=0)
    for count in range(2, most):
        told = {own: "/".join(own.parts[1:][-count:]) for own in files}
        if len(set(told.values())) == len(files):
            break
    else:
        told = {own: "/".join((_drive(own), *own.parts[1:])) for own in files}
    return {path: told[own] for path, own in absolute.items()}


def _drive(path: Path) -> str:
    r"""Return a drive as the name of a folder: ``e`` of ``E:``, ``share`` of ``\\pc\share``."""
    return re.split(r"[\\/]", path.drive)[-1].rstrip(":").lower()


def is_labelled(path: Path, label: str) -> bool:
    """Say whether a file may be the input of a label: whether it lies where the label says."""
    parts = path.resolve().parts
    told = Path(label).parts
    return parts[-len(told) :] == told
