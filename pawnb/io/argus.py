"""Points digitised with Argus: ``...-xyzpts.csv`` in space, ``...-xypts.csv`` in the views.

Argus counts v upwards from the lower edge of the picture: v is the height less its y. It opens a
table by the order of its columns, which it expects sorted by name, and takes what comes before the
first ``_`` of a column for the name of its track; tables are written so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.io.outgoing import take_space, take_view, views_of, word
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers, write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

IMAGE = re.compile(r"(?P<point>.+)_cam_(?P<view>\d+)_(?P<axis>[xy])")
SPACE = re.compile(r"(?P<point>.+)_(?P<axis>[xyz])")


@checked_arguments
def read_argus_points(
    path: str | Path, *, fps: float, heights_px: Sequence[int] | None = None
) -> Tracks:
    """Read points in the views of Argus.

    Parameters
    ----------
    path : str or Path
        ``...-xypts.csv`` with columns ``<track>_cam_<n>_x, _y``, a row a frame.
    fps : float
        Frames per second of the recording.
    heights_px : sequence of int
        Height of each camera's picture. A height of 0 leaves v at -y, which is enough for
        triangulation with coefficients that are moved alike.

    Returns
    -------
    xarray.Dataset
        Tracks with ``image_position`` in px of the views ``cam1``, ``cam2``, ...; Argus gives no
        confidence.

    Raises
    ------
    InputError
        If the file is of another layout, or heights are missing or do not fit the cameras.

    Examples
    --------
    >>> path = pawnb.io.write_argus_points(tracks, "clip-xypts.csv", heights_px=[480])
    >>> again = pawnb.io.read_argus_points(path, fps=200.0, heights_px=[480])
    >>> again.sizes["keypoint"] == tracks.sizes["keypoint"]
    True
    """
    where = Path(path).name
    names, table = _read(path)
    found = [m for name in names if (m := IMAGE.fullmatch(name))]
    points = list(dict.fromkeys(m["point"] for m in found))
    numbers = sorted({int(m["view"]) for m in found})
    if heights_px is None or len(heights_px) not in (1, len(numbers)):
        raise InputError(
            f"{where}: Argus counts v upwards from the lower edge; give the height of the pictures "
            f"of its {len(numbers)} cameras in px (heights_px of load_tracks, --heights of pawnb "
            "convert, which writes tracks for pawnb gait), or name the videos in a trial.toml."
        )
    wanted = [f"{p}_cam_{n}_{axis}" for p in points for n in numbers for axis in "xy"]
    values = _columns(table, wanted, where).reshape(-1, len(points), len(numbers), 2)
    values[..., 1] = np.asarray(heights_px, dtype=float) - values[..., 1]
    return build_tracks(
        np.arange(len(values)),
        values.transpose(0, 2, 1, 3)[:, :, :, None],
        points=points,
        fps=fps,
        unit="px",
        program="Argus",
        where=where,
        views=[f"cam{n}" for n in numbers],
    )


@checked_arguments
def read_argus_points3d(path: str | Path, *, fps: float, unit: str = "mm") -> Tracks:
    """Read 3D points of Argus.

    Parameters
    ----------
    path : str or Path
        ``...-xyzpts.csv`` with columns ``<track>_x, _y, _z``, a row a frame.
    fps : float
        Frames per second of the recording.
    unit : str
        Unit of length of the calibration.

    Returns
    -------
    xarray.Dataset
        Tracks in space; Argus gives no confidence.

    Raises
    ------
    InputError
        If the file is of another layout.

    Examples
    --------
    >>> path = pawnb.io.write_argus_points3d(space, "clip-xyzpts.csv")
    >>> pawnb.io.read_argus_points3d(path, fps=250.0)["keypoint"].values.tolist()
    ['FR', 'HR']
    """
    where = Path(path).name
    names, table = _read(path)
    points = list(dict.fromkeys(m["point"] for name in names if (m := SPACE.fullmatch(name))))
    wanted = [f"{point}_{axis}" for point in points for axis in "xyz"]
    values = _columns(table, wanted, where).reshape(-1, len(points), 1, 3)
    return build_tracks(
        np.arange(len(values)), values, points=points, fps=fps, unit=unit, program="Argus",
        where=where,
    )  # fmt: skip


@checked_arguments
def write_argus_points(
    tracks: Tracks, path: str | Path, *, heights_px: Sequence[int] | None = None
) -> Path:
    """Write points in the views as Argus does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures, of one animal.
    path : str or Path
        ``.csv``.
    heights_px : sequence of int
        Height of each view's picture, or one of all.

    Returns
    -------
    Path
        The file: a row for every frame from 0 on, cameras numbered in the order of the views,
        points sorted by name, and ``-`` for ``_`` in their names.

    Raises
    ------
    InputError
        If there are no points in pictures, several animals, heights are missing, or two points
        would get one name.

    Examples
    --------
    >>> pawnb.io.write_argus_points(tracks, "clip-xypts.csv", heights_px=[480]).name
    'clip-xypts.csv'
    """
    views = views_of(tracks)
    if heights_px is None or len(heights_px) not in (1, len(views)):
        raise InputError(
            f"{Path(path).name}: Argus counts v upwards from the lower edge; give the height of "
            f"the pictures of the {len(views)} views in px (--heights on the command line)."
        )
    heights = [*heights_px] * (len(views) if len(heights_px) == 1 else 1)
    parts, points = [], []
    for view, height in zip(views, heights, strict=True):
        own = take_view(tracks, view)
        own.only_animal("Argus")
        place = own.whole(own.place[:, :, 0])
        place[..., 1] = height - place[..., 1]
        parts.append(place)
        points = own.points
    called = _track_names(points, Path(path).name)
    order = sorted(range(len(points)), key=called.__getitem__)
    names = [f"{called[k]}_cam_{n}_{axis}" for k in order for n in range(1, len(views) + 1)
             for axis in "xy"]  # fmt: skip
    values = np.stack(parts, axis=2)[:, order]
    return _write(path, names, values.reshape(len(values), -1))


@checked_arguments
def write_argus_points3d(tracks: Tracks, path: str | Path) -> Path:
    """Write points in space as Argus does.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in space, of one animal.
    path : str or Path
        ``.csv``.

    Returns
    -------
    Path
        The file: a row for every frame from 0 on, points sorted by name, and ``-`` for ``_`` in
        their names.

    Raises
    ------
    InputError
        If there are no points in space, several animals, or two points would get one name.

    Examples
    --------
    >>> pawnb.io.write_argus_points3d(space, "clip-xyzpts.csv").name
    'clip-xyzpts.csv'
    """
    own = take_space(tracks)
    own.only_animal("Argus")
    called = _track_names(own.points, Path(path).name)
    order = sorted(range(len(called)), key=called.__getitem__)
    names = [f"{called[k]}_{axis}" for k in order for axis in "xyz"]
    values = own.whole(own.place[:, order, 0])
    return _write(path, names, values.reshape(len(values), -1))


def _track_names(points: Sequence[str], where: str) -> list[str]:
    """Return names that Argus can read again: none has the ``_`` at which it cuts them off."""
    called = [point.replace("_", "-") for point in points]
    twice = {name for name in called if called.count(name) > 1}
    if twice:
        both = ", ".join(repr(p) for p, name in zip(points, called, strict=True) if name in twice)
        raise InputError(
            f"{where}: Argus has no _ in the names of tracks, and without it {both} are one name; "
            "give one of them another."
        )
    return called


def _read(path: str | Path) -> tuple[list[str], dict[str, np.ndarray]]:
    """Return the names of the columns, and numbers by them; NaN where nothing was digitised."""
    cells = read_cells(path, ())
    cells = cells.mask(cells.apply(lambda column: column.str.lower() == "nan"), "")
    names = [str(name) for name in cells]
    where = Path(path).name
    return names, {name: read_numbers(cells, name, where=where, empty=True) for name in names}


def _columns(table: dict[str, np.ndarray], wanted: Sequence[str], where: str) -> FloatArray:
    """Return the wanted columns side by side."""
    missing = [name for name in wanted if name not in table]
    if missing or not wanted:
        what = f"column {missing[0]!r} is missing" if missing else "no column of a track"
        raise InputError(f"{where}: {what}; Argus writes x and y (and z) of every track.")
    return np.column_stack([table[name] for name in wanted])


def _write(path: str | Path, names: Sequence[str], values: FloatArray) -> Path:
    """Write a table without frame numbers."""
    rows = [",".join(names), *(",".join(word(x) or "NaN" for x in row) for row in values)]
    return write_text("\n".join(rows) + "\n", path)
