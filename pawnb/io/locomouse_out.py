"""Tracks for LocoMouse: ``final_tracks`` and ``tracks_tail`` of a ``.mat``."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
from scipy.io import savemat

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.files import write_whole
from pawnb.io.locomouse import POINTS, VIEWS
from pawnb.io.outgoing import take_view, views_of
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

_HEAD = b"MATLAB 5.0 MAT-file, written by pawnb in the layout of LocoMouse".ljust(116)
"""In place of a time of day, so that the same tracks are the same bytes."""

_SAME_PX = 0.01
"""How far the two views may disagree on x and still be one number: what tables round to."""

_TAIL = re.compile(r"tail_(\d+)")


@checked_arguments
def write_locomouse(tracks: Tracks, path: str | Path) -> Path:
    """Write tracks as LocoMouse does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one animal in the views ``bottom`` and ``side``, which share the axis along the
        corridor: FR, HR, FL, HL and snout, of which any may be absent, and ``tail_1`` and so on.
    path : str or Path
        ``.mat``.

    Returns
    -------
    Path
        The file: x, y of the bottom and z of the side view, px from 1, of every frame from 0 on.

    Raises
    ------
    InputError
        If there are other views or points, or the views do not share their first axis.

    Examples
    --------
    >>> from scipy.io import savemat
    >>> savemat("clip.mat", {"final_tracks": np.arange(45.0).reshape(3, 5, 3)})
    >>> tracks = pawnb.io.read_locomouse("clip.mat", fps=400.0)
    >>> pawnb.io.write_locomouse(tracks, "copy.mat").name
    'copy.mat'
    """
    path = Path(path)
    if set(views_of(tracks)) != set(VIEWS):
        raise InputError(
            f"{path.name}: LocoMouse has the views bottom and side, and these tracks have "
            f"{', '.join(views_of(tracks)) or 'none'}; choose another format."
        )
    bottom, side = (take_view(tracks, view) for view in VIEWS)
    bottom.only_animal("LocoMouse")
    x = _shared_axis(bottom.place[:, :, 0, 0], side.place[:, :, 0, 0], path.name)
    values = np.stack([x, bottom.place[:, :, 0, 1], side.place[:, :, 0, 1]], axis=-1)
    rows = bottom.whole(values).transpose(2, 1, 0) + 1.0  # axis, point, frame
    tail = sorted((m for p in bottom.points if (m := _TAIL.fullmatch(p))), key=lambda m: int(m[1]))
    other = set(bottom.points) - {*POINTS, *(m[0] for m in tail)}
    if other:
        raise InputError(
            f"{path.name}: LocoMouse has no point {sorted(other)[0]!r}; it has "
            f"{', '.join(POINTS)} and tail_1, tail_2, ..."
        )
    arrays = {"final_tracks": _of_points(rows, bottom.points, POINTS)}
    if tail:
        names = [f"tail_{k + 1}" for k in range(int(tail[-1][1]))]
        arrays["tracks_tail"] = _of_points(rows, bottom.points, names)
    file = io.BytesIO()
    savemat(file, arrays, do_compression=True)
    return write_whole(path, _HEAD + file.getvalue()[len(_HEAD) :])


def _shared_axis(bottom: FloatArray, side: FloatArray, where: str) -> FloatArray:
    """Return x, of the view that has it; both must agree where both have."""
    apart = np.abs(bottom - side)
    if np.nanmax(apart, initial=0.0) > _SAME_PX:
        raise InputError(
            f"{where}: LocoMouse's bottom and side view share x, and here they are up to "
            f"{np.nanmax(apart):.3g} px apart; choose a format that holds views by themselves."
        )
    return np.where(np.isnan(bottom), side, bottom)


def _of_points(
    rows: FloatArray, points: list[str], wanted: tuple[str, ...] | list[str]
) -> FloatArray:
    """Return the wanted points in their order; NaN of those that are not there."""
    lost = np.full((3, rows.shape[2]), np.nan)
    return np.stack([rows[:, points.index(p)] if p in points else lost for p in wanted], axis=1)
