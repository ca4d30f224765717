"""Tracks of Anipose: the csv of 3D points."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks

_COLUMN = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")


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
        Tracks in space, points in the order of the file, confidence is Anipose's score. Frames
        without a row are missing, and the provenance says which they are.

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
    return build_tracks(
        read_numbers(cells, "fnum", where=where, whole=True),
        values[:, :3].transpose(2, 0, 1)[:, :, None],
        values[:, 3].T[..., None],
        points=points,
        fps=fps,
        unit=unit,
        program="Anipose",
        where=where,
    )
