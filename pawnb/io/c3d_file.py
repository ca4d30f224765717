"""Points in C3D, the format of motion capture, through the library c3d (MIT)."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.errors import InputError
from pawnb.files import read_bytes, write_whole
from pawnb.input_warnings import hide_warnings_of
from pawnb.io.extras import need
from pawnb.io.hdf5 import HDF5_FAULTS
from pawnb.io.lengths import short_unit, tell_no_unit, units_per_unit
from pawnb.io.outgoing import take_space
from pawnb.io.points import build_tracks, by_subject, check_names, tell_rate
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

_EXPECTED = "a C3D file"
_MOST_BYTES = 2**30
_OUTPUTS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
"""Lists of the points that Vicon's models make, and that are no places."""
_FAULTS = (*HDF5_FAULTS, EOFError, ArithmeticError, UnicodeError, struct.error)


@checked_arguments
def read_c3d(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    """Read the points of a C3D file.

    Parameters
    ----------
    path : str or Path
        ``.c3d``.
    fps : float, optional
        Frames per second; default as the file says.
    unit : str, optional
        Unit of length that positions are brought to; default as the file says, else mm.

    Returns
    -------
    xarray.Dataset
        Tracks in space without confidence; frame 1 of the file is frame 0. Points without a label
        are left out, and so are angles, forces and other outputs of models that the file lists as
        such. Labels such as
        ``m07:FR`` (Vicon) are points of the animal m07, one or several. Points whose residual
        is negative were not seen, and neither were those exactly at (0, 0, 0), as some programs
        mark them.

    Raises
    ------
    InputError
        If c3d is not installed (``pip install pawnb[c3d]``), the file is damaged, or its unit
        cannot be brought to that which is given.

    Warns
    -----
    InputWarning
        If the file says another frame rate than is given, or no unit where none is given.

    Examples
    --------
    Needs ``pawnb[c3d]``.

    >>> path = pawnb.io.write_c3d(space, "clip.c3d")
    >>> pawnb.io.read_c3d(path)["keypoint"].values.tolist()
    ['FR', 'HR']
    """
    path = Path(path)
    c3d: Any = need("c3d", "c3d", what=f"to read {path.name}")
    hide_warnings_of("c3d")
    data = read_bytes(path, expected=_EXPECTED, most_bytes=_MOST_BYTES)
    try:
        reader = c3d.Reader(io.BytesIO(data))
        points, outputs = _labels(reader, "LABELS"), _model_outputs(reader)
        # analog channels are not wanted, and c3d cannot read the scale of a single one
        reader.get_analog_transform = lambda: (1.0, 0.0)
        rows = [(number, own.copy()) for number, own, _ in reader.read_frames(copy=True)]
        rate = float(reader.point_rate)
        said = reader.get("POINT:UNITS")
        found = short_unit(said.string_value) if said is not None else ""
    except _FAULTS as error:
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        raise InputError(
            f"{path.name}: damaged or of another kind ({reason}); expected {_EXPECTED}: copy it "
            "again from where it is whole."
        ) from None
    n = rows[0][1].shape[0] if rows else 0
    made = [not {name, name.rpartition(":")[2]}.isdisjoint({"", *outputs}) for name in points[:n]]
    kept = [i for i, left_out in enumerate(made) if not left_out]
    if not kept:
        raise InputError(f"{path.name}: no points in it; expected {_EXPECTED} with labelled ones.")
    points = [points[i] for i in kept]
    values = np.stack([own[kept] for _, own in rows]).astype(float)
    lost = (values[..., 3] < 0) | (values[..., :3] == 0).all(axis=-1)
    place = np.where(lost[..., None], np.nan, values[..., :3])
    if unit is not None and found:
        place = place * units_per_unit(found, unit, where=path.name)
    if not (unit or found):
        tell_no_unit(path.name, stacklevel=2)
    tell_rate(path.name, rate, fps, stacklevel=2)
    check_names(points, what="point", where=path.name)
    points, animals, place = by_subject(points, place)
    return build_tracks(
        [number - 1 for number, _ in rows],
        place,
        points=points,
        fps=fps or rate,
        unit=unit or found or "mm",
        program="C3D",
        where=path.name,
        individuals=animals,
    )


def _labels(reader: Any, name: str) -> list[str]:
    """Return names of points: more than 255 of LABELS go on in LABELS2, LABELS3, ..."""
    labels: list[str] = []
    k = 1
    while (more := reader.get(f"POINT:{name}{k if k > 1 else ''}")) is not None:
        labels, k = [*labels, *more.string_array], k + 1
    return [str(label).strip() for label in labels]


def _model_outputs(reader: Any) -> set[str]:
    """Return the names of what is kept as points, and is none: joint angles, forces and such."""
    return {label for kind in _OUTPUTS for label in _labels(reader, kind)}


@checked_arguments
def write_c3d(tracks: Tracks, path: str | Path) -> Path:
    """Write points in space as C3D.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in space, of one animal.
    path : str or Path
        ``.c3d``.

    Returns
    -------
    Path
        The file, numbers in single precision as C3D has them; a row for every frame from the first
        to the last. C3D counts frames from 1.

    Raises
    ------
    InputError
        If c3d is not installed (``pip install pawnb[c3d]``), there are no points in space, or
        several animals.

    Examples
    --------
    Needs ``pawnb[c3d]``.

    >>> pawnb.io.write_c3d(space, "clip.c3d").name
    'clip.c3d'
    """
    path = Path(path)
    c3d: Any = need("c3d", "c3d", what=f"to write {path.name}")
    hide_warnings_of("c3d")
    own = take_space(tracks)
    own.only_animal("C3D")
    first = int(own.frames[0])
    rows = np.full((int(own.frames[-1]) - first + 1, len(own.points), 5), 0.0)
    rows[..., 3] = -1.0  # not seen
    place = own.place[:, :, 0]
    seen = np.isfinite(place).all(axis=-1)
    rows[own.frames - first, :, :3] = np.where(seen[..., None], place, 0.0)
    rows[own.frames - first, :, 3] = np.where(seen, 0.0, -1.0)
    writer = c3d.Writer(point_rate=own.fps, point_scale=-1.0)
    writer.set_point_labels(own.points)
    writer.set_start_frame(first + 1)
    unit = str(own.attrs.get("units") or "mm")
    writer.point_group.add_str("UNITS", "unit of length", unit.ljust(4), 4)
    writer.add_frames([(row, np.zeros((0, 0))) for row in rows])
    data = io.BytesIO()
    writer.write(data)
    return write_whole(path, data.getvalue())
