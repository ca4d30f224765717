"""Points in a plain table: ``frame``, then ``<point>_x, <point>_y`` and perhaps ``<point>_z``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.io.outgoing import take_space, take_view, views_of, word
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers, write_text
from pawnb.schema import Tracks, check_columns

_COLUMN = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")
_CONFIDENCE = ("likelihood", "confidence", "score", "p")
"""What is called so behind a point is its confidence; SimBA calls it p."""
_INDEX = "Unnamed: 0"
"""Column without a name, as pandas writes the numbers of the rows, and SimBA those of frames."""


def is_wide_table(names: Sequence[str]) -> bool:
    """Say whether the columns of a table are those of points side by side.

    Parameters
    ----------
    names : sequence of str
        Columns.

    Returns
    -------
    bool
        True for ``frame`` (or a first column without a name) and at least one point with x and y.
    """
    points = {m["point"] for name in names if (m := _COLUMN.fullmatch(name))}
    return ("frame" in names or list(names[:1]) == [""]) and any(
        {f"{p}_x", f"{p}_y"} <= set(names) for p in points
    )


def read_wide_table(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    """Read points side by side, as spreadsheets and scripts write them.

    Parameters
    ----------
    path : str or Path
        A csv with columns ``frame`` and ``<point>_x, <point>_y``, in space also ``<point>_z``;
        an empty cell is a point that was not seen. A first column without a name is ``frame``,
        as SimBA and pandas write it; ``<point>_likelihood``, ``_confidence``, ``_score`` or
        ``_p`` is the confidence. Other columns are left out.
    fps : float
        Frames per second of the recording.
    unit : str, optional
        Unit of length; default mm in space and px in a plane.

    Returns
    -------
    xarray.Dataset
        Tracks; where the table gives no confidence, that of a point that was seen is NaN. Frames
        without a row are missing, and the provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing or of another layout, a point lacks a column, or frames do not
        rise.

    Examples
    --------
    >>> table = pd.DataFrame({"frame": [0, 1], "FR_x": [10.0, 11.0], "FR_y": [4.0, 4.0]})
    >>> table.to_csv("points.csv", index=False)
    >>> pawnb.io.read_wide_table("points.csv", fps=250.0)["keypoint"].values.tolist()
    ['FR']
    """
    where = Path(path).name
    cells = read_cells(path, ())
    if "frame" not in cells and next(iter(cells), None) == _INDEX:
        cells = cells.rename(columns={_INDEX: "frame"})
    cells = check_columns(cells, ("frame",), where=where)
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
    columns = [
        read_numbers(cells, f"{point}_{axis}", where=where, empty=True)
        for point in points
        for axis in axes
    ]
    return build_tracks(
        read_numbers(cells, "frame", where=where, whole=True),
        np.column_stack(columns).reshape(len(cells), len(points), 1, len(axes)),
        _confidence(cells, points, where=where),
        points=points,
        fps=fps,
        unit=unit or ("mm" if len(axes) == 3 else "px"),
        program="table",
        where=where,
    )


def _confidence(cells: pd.DataFrame, points: Sequence[str], *, where: str) -> FloatArray | None:
    """Return the confidence of every point (n_rows, n_points, 1), None where none is told."""
    told = np.full((len(cells), len(points), 1), np.nan)
    for k, point in enumerate(points):
        name = next((n for word in _CONFIDENCE if (n := f"{point}_{word}") in cells), None)
        if name is not None:
            told[:, k, 0] = read_numbers(cells, name, where=where, empty=True)
    return told if np.isfinite(told).any() else None


def write_wide_table(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write points side by side, as spreadsheets take them.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one animal: points in a view, or in space where there are no others.
    path : str or Path
        ``.csv``.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file: ``frame``, then x, y (and z) of each point; an empty cell is a missing one.

    Raises
    ------
    InputError
        If there are no points, or several animals.
    """
    own = take_view(tracks, view) if views_of(tracks) else take_space(tracks)
    own.only_animal("a table of points side by side")
    axes = "xyz"[: own.place.shape[-1]]
    rows = [",".join(["frame", *(f"{point}_{axis}" for point in own.points for axis in axes)])]
    for frame, row in zip(own.frames, own.place.reshape(len(own.frames), -1), strict=True):
        rows.append(",".join([str(int(frame)), *map(word, row)]))
    return write_text("\n".join(rows) + "\n", path)
