"""Tracks for XMALab: markers in the views, which it imports, and in space, as it exports them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pawnb.errors import InputError
from pawnb.io.dltdv_out import view_columns
from pawnb.io.outgoing import take_space, word
from pawnb.io.tables import write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def write_xmalab_points(
    tracks: Tracks, path: str | Path, *, heights_px: Sequence[int] | None = None
) -> Path:
    """Write points in the views as XMALab imports and exports its markers ("2D points").

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures, of one animal.
    path : str or Path
        ``.csv``.
    heights_px : sequence of int, optional
        Height of each view's picture (or one of all): Y then counts upwards from the lower edge.

    Returns
    -------
    Path
        The file: a row for every frame from 0 on, cameras numbered in the order of the views. In
        XMALab's window of import choose a header row, no columns of offsets, and pixels from 1;
        with heights also the inverted y axis.

    Raises
    ------
    InputError
        If there are no points in pictures, several animals, heights that do not fit the views, or
        a name with a comma.

    Examples
    --------
    >>> pawnb.io.write_xmalab_points(tracks, "markers_xy.csv").name
    'markers_xy.csv'
    """
    names, values, own = view_columns(tracks, "XMALab", heights_px)
    _check_names(own.points, path)
    # an empty cell would be 0 to XMALab
    rows = [",".join(names), *(",".join(word(x) or "NaN" for x in row) for row in values)]
    return write_text("\n".join(rows) + "\n", path)


@checked_arguments
def write_xmalab_points3d(tracks: Tracks, path: str | Path) -> Path:
    """Write points in space as XMALab exports its markers ("3D points"), with their frames.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in space, of one animal.
    path : str or Path
        ``.csv``.

    Returns
    -------
    Path
        The file: ``Frame`` counts from 1, a row for every frame from the first to the last.

    Raises
    ------
    InputError
        If there are no points in space, several animals, or a name has a comma.

    Examples
    --------
    >>> pawnb.io.write_xmalab_points3d(space, "markers_xyz.csv").name
    'markers_xyz.csv'
    """
    own = take_space(tracks)
    own.only_animal("XMALab")
    _check_names(own.points, path)
    first = int(own.frames[0]) if len(own.frames) else 0
    values = own.whole(own.place[:, :, 0])[first:]
    rows = [",".join(["Frame", *(f"{point}_{axis}" for point in own.points for axis in "XYZ")])]
    for i, row in enumerate(values.reshape(len(values), -1)):
        rows.append(",".join([str(first + i + 1), *(word(x) or "NaN" for x in row)]))
    return write_text("\n".join(rows) + "\n", path)


def _check_names(points: Sequence[str], path: str | Path) -> None:
    """Refuse names at which XMALab would cut a line into other columns."""
    cut = next((point for point in points if "," in point), None)
    if cut is not None:
        raise InputError(
            f"{Path(path).name}: XMALab takes no comma in a name, and a point is called {cut!r}; "
            "give it another name."
        )
