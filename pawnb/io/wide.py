"""Points in a plain table: ``frame``, then ``<point>_x, <point>_y`` and perhaps ``<point>_z``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import ORIGIN_CODE, Tracks, make_tracks

_COLUMN = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")


def is_wide_table(names: Sequence[str]) -> bool:
    """Say whether the columns of a table are those of points side by side.

    Parameters
    ----------
    names : sequence of str
        Columns.

    Returns
    -------
    bool
        True for ``frame`` and at least one point with x and y.
    """
    points = {m["point"] for name in names if (m := _COLUMN.fullmatch(name))}
    return "frame" in names and any({f"{p}_x", f"{p}_y"} <= set(names) for p in points)


def read_wide_table(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    """Read points side by side, as spreadsheets and scripts write them.

    Parameters
    ----------
    path : str or Path
        A csv with columns ``frame`` and ``<point>_x, <point>_y``, in space also ``<point>_z``;
        an empty cell is a point that was not seen. Other columns are left out.
    fps : float
        Frames per second of the recording.
    unit : str, optional
        Unit of length; default mm in space and px in a plane.

    Returns
    -------
    xarray.Dataset
        Tracks; the table gives no confidence, so that of a point that was seen is NaN.

    Raises
    ------
    InputError
        If the file is missing or of another layout, or a point lacks a column.
    """
    where = Path(path).name
    cells = read_cells(path, ("frame",))
    found = [m for name in map(str, cells) if (m := _COLUMN.fullmatch(name))]
    points = list(dict.fromkeys(m["point"] for m in found))
    axes = "xyz" if any(m["axis"] == "z" for m in found) else "xy"
    for point in points:
        missing = [f"{point}_{axis}" for axis in axes if f"{point}_{axis}" not in cells]
        if missing:
            raise InputError(
                f"{where}: column {missing[0]!r} is missing; expected {', '.join(axes)} of every "
                "point."
            )
    if not points:
        raise InputError(f"{where}: no point; expected columns <point>_x, <point>_y.")
    cells = cells.mask(cells.apply(lambda column: column.str.lower() == "nan"), "")
    frames = read_numbers(cells, "frame", where=where, whole=True)
    columns = [
        read_numbers(cells, f"{point}_{axis}", where=where, empty=True)
        for point in points
        for axis in axes
    ]
    places = np.column_stack(columns).reshape(len(frames), len(points), len(axes))
    tracks = make_tracks(
        frames, points, fps=fps, space=tuple(axes), unit=unit or ("mm" if len(axes) == 3 else "px"),
        source_software="table",
    )  # fmt: skip
    tracks["position"].to_numpy()[:] = places.transpose(0, 2, 1)[..., None]
    known = np.isfinite(places).all(axis=2)[..., None]
    tracks["origin"].to_numpy()[known] = ORIGIN_CODE["measured"]
    tracks["confidence"].to_numpy()[known] = np.nan
    return tracks
