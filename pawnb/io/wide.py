"""Points in a plain table: ``frame``, then ``<point>_x, <point>_y`` and perhaps ``<point>_z``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.io.outgoing import take_space, take_view, views_of, word
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers, write_text
from pawnb.schema import Tracks

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
        Tracks; the table gives no confidence, so that of a point that was seen is NaN. Frames
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
    columns = [
        read_numbers(cells, f"{point}_{axis}", where=where, empty=True)
        for point in points
        for axis in axes
    ]
    return build_tracks(
        read_numbers(cells, "frame", where=where, whole=True),
        np.column_stack(columns).reshape(len(cells), len(points), 1, len(axes)),
        points=points,
        fps=fps,
        unit=unit or ("mm" if len(axes) == 3 else "px"),
        program="table",
        where=where,
    )


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
