"""Tracks of Anipose: the csv of 3D points, in and out."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.io.outgoing import take_space, word
from pawnb.io.points import build_tracks, plain_name
from pawnb.io.tables import read_cells, read_numbers, write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

VIEWS_USED = "n_views"
"""Variable of Tracks: how many views a point in space was found from."""

AXES = "anipose_axes"
"""Attribute of Tracks: how Anipose turned and moved its points (M and center), as JSON."""

_COLUMN = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")
_MATRIX = [f"M_{i}{j}" for i in range(3) for j in range(3)]
_CENTER = [f"center_{i}" for i in range(3)]


@checked_arguments
def read_anipose(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read 3D points of Anipose.

    Parameters
    ----------
    path : str or Path
        A csv of ``pose-3d`` with columns ``<point>_x, _y, _z, _error, _ncams, _score`` and
        ``fnum``, the number of the frame.
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of length of Anipose's calibration.

    Returns
    -------
    xarray.Dataset
        Tracks in space, points in the order of the file, confidence is Anipose's score,
        ``residual`` its error (px, the mean over the views, where pawnb's own is their root mean
        square) and ``n_views`` its number of cameras. Frames without a row are missing, and the
        provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing or is not of Anipose, a cell is no number, or frames do not rise.

    Examples
    --------
    >>> table = pd.DataFrame({"FR_x": [1.0, 2.0], "FR_y": 0.0, "FR_z": [5.0, 5.5],
    ...                       "FR_error": 0.4, "FR_ncams": 2, "FR_score": 0.9, "fnum": [0, 1]})
    >>> table.to_csv("clip.csv", index=False)
    >>> tracks = pawnb.io.read_anipose("clip.csv", fps=250.0)
    >>> tracks["position"].sel(space="z").values.ravel().tolist()
    [5.0, 5.5]
    """
    where = Path(path).name
    cells = read_cells(path, ("fnum",))
    found = [m for name in map(str, cells) if (m := _COLUMN.fullmatch(name))]
    points = list(dict.fromkeys(m["point"] for m in found))
    wanted = [[f"{point}_{part}" for part in ("x", "y", "z", "score")] for point in points]
    for name in (name for names in wanted for name in names):
        if name not in cells:
            raise InputError(
                f"{where}: column {name!r} is missing; Anipose writes _x, _y, _z and _score of "
                "every point."
            )
    cells = cells.mask(cells.apply(lambda column: column.str.lower() == "nan"), "")
    values = np.array(
        [[read_numbers(cells, n, where=where, empty=True) for n in names] for names in wanted]
    ).reshape(len(points), 4, len(cells))
    frames = read_numbers(cells, "fnum", where=where, whole=True)
    tracks = build_tracks(
        frames,
        values[:, :3].transpose(2, 0, 1)[:, :, None],
        values[:, 3].T[..., None],
        points=[plain_name(point) for point in points],
        fps=fps,
        unit=unit,
        program="Anipose",
        where=where,
    )
    return _with_extras(tracks, cells, frames, points, where=where)


def _with_extras(
    tracks: Tracks, cells: pd.DataFrame, frames: IntArray, points: list[str], *, where: str
) -> Tracks:
    """Add errors, numbers of cameras and the axes."""

    def filled(part: str) -> FloatArray:
        values = np.full((tracks.sizes["time"], len(points), 1), np.nan)
        rows = np.searchsorted(tracks["frame"].to_numpy(), frames)
        for k, point in enumerate(points):
            if f"{point}_{part}" in cells:
                values[rows, k, 0] = read_numbers(cells, f"{point}_{part}", where=where, empty=True)
        return values

    dims = ("time", "keypoint", "individual")
    tracks["residual"] = (dims, filled("error"), {"units": "px"})
    cameras = filled("ncams")
    if np.isfinite(cameras).any():
        tracks[VIEWS_USED] = (dims, cameras)
    if all(name in cells for name in (*_MATRIX, *_CENTER)) and len(cells):
        axes = np.stack(
            [read_numbers(cells, name, where=where, empty=True) for name in (*_MATRIX, *_CENTER)]
        )
        if np.isfinite(axes).all() and (axes == axes[:, :1]).all():
            said = {"M": axes[:9, 0].tolist(), "center": axes[9:, 0].tolist()}
            tracks.attrs[AXES] = json.dumps(said)
    return tracks


@checked_arguments
def write_anipose(tracks: Tracks, path: str | Path) -> Path:
    """Write 3D points as Anipose's ``pose-3d`` does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in space, of one animal.
    path : str or Path
        ``.csv``.

    Returns
    -------
    Path
        The file: ``_error`` is ``residual``, ``_ncams`` the number of views where it is known,
        ``_score`` the confidence; axes are those that were read, else unchanged.

    Raises
    ------
    InputError
        If there are no points in space, or several animals.

    Examples
    --------
    >>> pawnb.io.write_anipose(space, "pose-3d.csv").name
    'pose-3d.csv'
    """
    own = take_space(tracks)
    own.only_animal("Anipose")
    n, k = own.confidence.shape[:2]
    blank = np.full((n, k), np.nan)
    error = own.tracks["residual"].to_numpy()[..., 0] if "residual" in own.tracks else blank
    cameras = own.tracks[VIEWS_USED].to_numpy()[..., 0] if VIEWS_USED in own.tracks else blank
    place, score = own.place[:, :, 0], own.confidence[..., 0]
    parts = np.concatenate([place, np.stack([error, cameras, score], axis=-1)], axis=-1)
    axes = json.loads(str(own.attrs.get(AXES) or '{"M": [1, 0, 0, 0, 1, 0, 0, 0, 1]}'))
    last = [repr(float(x)) for x in (*axes["M"], *axes.get("center", [0, 0, 0]))]
    ends = ("x", "y", "z", "error", "ncams", "score")
    names = [f"{point}_{end}" for point in own.points for end in ends]
    rows = [",".join([*names, *_MATRIX, *_CENTER, "fnum"])]
    for frame, row in zip(own.frames, parts.reshape(n, -1), strict=True):
        rows.append(",".join([*map(word, row), *last, str(int(frame))]))
    return write_text("\n".join(rows) + "\n", path)
