"""Points in a plain table: ``frame``, then ``<point>_x, <point>_y`` and perhaps ``<point>_z``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.io.outgoing import take_space, take_view, views_of, word
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers, write_text
from pawnb.schema import Tracks, check_columns
from pawnb.schema.arguments import checked_arguments

_COLUMN = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")
_CONFIDENCE = ("likelihood", "confidence", "score", "visibility", "p")
"""What is called so behind a point is its confidence; SimBA calls it p, MediaPipe visibility."""
_MOST_CONFIDENCE = 2.0
"""Above, confidences are no parts of 1. Set by hand: scores of SLEAP go a little beyond 1."""
_SPELT = re.compile(rf"(?P<point>.+)[_. ](?P<what>[xyz]|{'|'.join(_CONFIDENCE)})", re.IGNORECASE)
_FRAME = re.compile(r"frames?([_ ]?(idx|index|number|num|no\.?))?", re.IGNORECASE)
_SEVERAL = re.compile(r"inst\d+\..+|TRACK_ID")
"""Columns of sleap-io and TrackMate that hold several animals."""
_INDEX = "Unnamed: 0"
"""Column without a name, as pandas writes the numbers of the rows, and SimBA those of frames: so
pandas calls it, also in a file that was read and written again."""


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
    return has_points(names) and ("frame" in _respelt(names) or names[0] in ("", _INDEX))


def has_points(names: Sequence[str]) -> bool:
    """Say whether columns are those of at least one point with x and y, whatever the others.

    Parameters
    ----------
    names : sequence of str
        Columns.

    Returns
    -------
    bool
        True where there is one. Those of sleap-io and TrackMate for several animals are none.
    """
    if any(_SEVERAL.fullmatch(name) for name in names):
        return False
    return _is_point_there(_respelt(names))


def _is_point_there(names: Sequence[str]) -> bool:
    """Say whether a point has x and y among columns spelt as pawnb does."""
    points = {m["point"] for name in names if (m := _COLUMN.fullmatch(name))}
    return any({f"{p}_x", f"{p}_y"} <= set(names) for p in points)


def _respelt(names: Sequence[str]) -> list[str]:
    """Return columns as pawnb spells them: Frame is frame, and, where no point is, FR.X is FR_x."""
    new = list(names)
    if "frame" not in new and (at := [i for i, name in enumerate(new) if _FRAME.fullmatch(name)]):
        new[at[0]] = "frame"
    if _is_point_there(new):
        return new
    found = [_SPELT.fullmatch(name) for name in new]
    return [
        f"{m['point']}_{m['what'].lower()}" if m else name
        for m, name in zip(found, new, strict=True)
    ]


@checked_arguments
def read_wide_table(path: str | Path, *, fps: float, unit: str | None = None) -> Tracks:
    """Read points side by side, as spreadsheets and scripts write them.

    Parameters
    ----------
    path : str or Path
        A csv with columns ``frame`` and ``<point>_x, <point>_y``, in space also ``<point>_z``;
        an empty cell is a point that was not seen. Capital letters, and a point or blank in place
        of the ``_``, are understood, and so are ``frame_idx`` and the like. A first column
        without a name is ``frame``, as SimBA and pandas write it; ``<point>_likelihood``,
        ``_confidence``, ``_score``, ``_visibility`` or ``_p`` is the confidence. Other columns are
        left out.
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

    Warns
    -----
    InputWarning
        If all places lie between 0 and 1, as parts of a picture do, or confidences go beyond 2,
        as percents do.

    Examples
    --------
    >>> table = pd.DataFrame({"frame": [0, 1], "FR_x": [10.0, 11.0], "FR_y": [4.0, 4.0]})
    >>> table.to_csv("points.csv", index=False)
    >>> pawnb.io.read_wide_table("points.csv", fps=250.0)["keypoint"].values.tolist()
    ['FR']
    """
    where = Path(path).name
    cells = _in_our_spelling(read_cells(path, ()), where)
    if "frame" not in cells and next(iter(cells), None) == _INDEX:
        cells = cells.rename(columns={_INDEX: "frame"})
    cells = check_columns(cells, ("frame",), where=where, cells=False)
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
    place = np.column_stack(columns).reshape(len(cells), len(points), 1, len(axes))
    visible = any(f"{point}_visibility" in cells for point in points)
    _tell_parts(place[..., :2] if visible else place, where)
    return build_tracks(
        read_numbers(cells, "frame", where=where, whole=True),
        place,
        _confidence(cells, points, where=where),
        points=points,
        fps=fps,
        unit=unit or ("mm" if len(axes) == 3 else "px"),
        program="table",
        where=where,
    )


def _in_our_spelling(cells: pd.DataFrame, where: str) -> pd.DataFrame:
    """Return a table whose columns are spelt as pawnb does."""
    names = _respelt([str(name) for name in cells])
    twice = next((i for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        first = cells.columns[names.index(names[twice])]
        raise InputError(
            f"{where}: columns {first!r} and {cells.columns[twice]!r} mean the same, "
            f"{names[twice]!r}; keep one of them, or name them differently."
        )
    return cells.set_axis(names, axis="columns")


def _tell_parts(place: FloatArray, where: str) -> None:
    """Warn of places in a plane that are parts of a picture's width and height.

    Of places in space only MediaPipe's x and y come here: others may be less than 1 m apart.
    """
    seen = place[np.isfinite(place)]
    if place.shape[-1] == 2 and seen.size and seen.min() >= 0 and 0 < seen.max() <= 1:
        warn_of_input(
            f"{where}: all places lie between 0 and 1, as MediaPipe writes parts of the picture's "
            "width and height: angles and lengths are wrong then; multiply x by the width and y by "
            "the height in px.",
            InputWarning,
            stacklevel=3,
        )


def _confidence(cells: pd.DataFrame, points: Sequence[str], *, where: str) -> FloatArray | None:
    """Return the confidence of every point (n_rows, n_points, 1), None where none is told."""
    told = np.full((len(cells), len(points), 1), np.nan)
    for k, point in enumerate(points):
        name = next((n for word in _CONFIDENCE if (n := f"{point}_{word}") in cells), None)
        if name is not None:
            told[:, k, 0] = read_numbers(cells, name, where=where, empty=True)
    if np.nanmax(told, initial=0.0) > _MOST_CONFIDENCE:
        warn_of_input(
            f"{where}: confidences are up to {np.nanmax(told):g}, and parts of 1 are expected: a "
            "threshold such as min_confidence=0.6 would leave nothing out; where they are in "
            "percent, divide them by 100.",
            InputWarning,
            stacklevel=3,
        )
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
