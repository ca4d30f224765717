"""pawnb's own files: ``tracks.nc`` in and out, and its csv exports.

``tracks.nc`` is the record and loses nothing; ``tracks.csv`` and ``points3d.csv`` are
exports for other programs, with rounded numbers (see :mod:`pawnb.io.tables`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pawnb.errors import InputError
from pawnb.files import check_file, write_whole
from pawnb.io.hdf5 import faults_in, open_hdf5
from pawnb.io.movement import from_movement, is_movement, netcdf_bytes
from pawnb.io.points import check_names, tell_rate
from pawnb.io.start import check_start, read_start, write_start
from pawnb.io.tables import write_table, write_text
from pawnb.schema import (
    ORIGIN_CODE,
    ORIGINS,
    POINTS3D_COLUMNS,
    TRACKS_COLUMNS,
    Tracks,
    check_frames,
    check_tracks,
)
from pawnb.schema.arguments import checked_arguments

__all__ = [
    "check_start",
    "points3d_table",
    "read_start",
    "read_tracks",
    "tracks_table",
    "write_start",
    "write_table",
    "write_text",
    "write_tracks",
]

SINGLE_VIEW = "image"
"""Name of the view in ``tracks.csv`` where Tracks in px name none."""

_HDF5, _NETCDF3 = b"\x89HDF", b"CDF"
_EXPECTED = "tracks.nc as pawnb writes it, or netCDF of movement"


@checked_arguments
def write_tracks(tracks: Tracks, path: str | Path) -> Path:
    """Write Tracks as netCDF, whole or not at all.

    Parameters
    ----------
    tracks : xarray.Dataset
        What to write; checked first.
    path : str or Path
        The file, usually ``tracks.nc``.

    Returns
    -------
    Path
        The file. The same Tracks give the same bytes.

    Raises
    ------
    InputError
        If these are not Tracks, if the folder does not exist, if an attribute cannot be stored
        in netCDF, or if the file cannot be written (a full disk, for instance).

    Examples
    --------
    >>> pawnb.io.write_tracks(tracks, "tracks.nc").name
    'tracks.nc'
    """
    path = Path(path)
    check_tracks(tracks)
    if not path.parent.is_dir():
        raise InputError(f"{path.parent}: no such folder; make it, or name another file.")
    for name, value in tracks.attrs.items():
        if not isinstance(value, str | int | float | np.number | np.ndarray) or isinstance(
            value, bool
        ):
            raise InputError(
                f"attribute {name!r} of the tracks is {value!r}; netCDF stores text and numbers."
            )
    # in the order in which they are read: tracks that were read and are written give these bytes
    return write_whole(path, netcdf_bytes(tracks[list(tracks.data_vars)]))


@checked_arguments
def read_tracks(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    """Read Tracks from netCDF: pawnb's own, or a poses dataset that movement saved.

    Parameters
    ----------
    path : str or Path
        The file; it is read whole and closed.
    fps : float, optional
        Frames per second, for a movement file that does not say; pawnb's own files say it.
    unit : str, optional
        Unit of length of positions in space of a movement file, which does not say.

    Returns
    -------
    xarray.Dataset
        Checked Tracks.

    Raises
    ------
    InputError
        If the file is missing, is not netCDF, or does not hold tracks.

    Warns
    -----
    InputWarning
        If the file says another frame rate than is given: its own is used.

    Examples
    --------
    >>> path = pawnb.io.write_tracks(tracks, "tracks.nc")
    >>> pawnb.io.read_tracks(path).equals(tracks)
    True
    """
    path = check_file(path, expected=_EXPECTED)
    with faults_in(path, expected=_EXPECTED):
        with path.open("rb") as file:
            head = file.read(4)
        if not head.startswith((_HDF5, _NETCDF3)):
            raise InputError(f"{path.name}: not a netCDF file; expected {_EXPECTED}.")
        old = head.startswith(_NETCDF3)
        if not old:
            with open_hdf5(path, expected=_EXPECTED):
                pass  # looked through before xarray follows what is in it
        dataset = _plain(xr.load_dataset(path, engine="scipy" if old else "h5netcdf"))
        if is_movement(dataset):
            return from_movement(dataset, fps=fps, unit=unit, where=path.name)
        tracks = _checked(check_tracks(dataset, where=path.name), path.name)
        tell_rate(path.name, float(tracks.attrs["fps"]), fps, kept=True, stacklevel=2)
        return tracks


def _checked(tracks: Tracks, where: str) -> Tracks:
    """Return Tracks whose frames, names and record are what they were when they were written."""
    for dim, what in (("keypoint", "point"), ("individual", "animal"), ("view", "view")):
        if dim in tracks.dims:
            check_names(_names(tracks, dim), what=what, where=where)
    if not tracks.sizes["time"]:
        raise InputError(
            f"{where}: no frames: tracking was stopped before the first; track the trial again."
        )
    check_frames(tracks["frame"].to_numpy(), where=where)
    for name in ("provenance", "trial"):
        try:
            record = json.loads(tracks.attrs.get(name, "{}"))
        except (ValueError, TypeError, RecursionError):
            record = None
        if not isinstance(record, dict):
            raise InputError(f"{where}: damaged, its attribute {name!r} is no JSON; make it again.")
    for name in ("origin", "image_origin"):
        if name in tracks and not np.isin(tracks[name], np.arange(len(ORIGINS))).all():
            raise InputError(f"{where}: damaged, {name!r} holds unknown codes; make it again.")
    for name in ("position", "image_position"):
        if name in tracks and tracks[name].dtype.kind != "f":
            raise InputError(f"{where}: damaged, {name!r} is no array of numbers; make it again.")
    return tracks


def _plain(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset as it was before it was saved: text and numbers of plain types."""
    for name in dataset.coords:
        if dataset[name].dtype.kind in "OT" or isinstance(
            dataset[name].dtype, pd.api.extensions.ExtensionDtype
        ):
            values = [
                v.decode() if isinstance(v, bytes) else str(v) for v in dataset[name].to_numpy()
            ]
            dataset = dataset.assign_coords({name: (dataset[name].dims, np.array(values, str))})
    dataset.attrs = _plain_values(dataset.attrs)
    if "unit" in dataset.attrs:  # the name of the attribute in the first tracks.nc
        dataset.attrs["units"] = dataset.attrs.pop("unit")
    for variable in dataset.variables.values():
        variable.attrs = _plain_values(variable.attrs)
    return dataset.drop_encoding()


def _plain_values(attrs: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes with numbers of Python's own types."""
    return {k: v.item() if isinstance(v, np.generic) else v for k, v in attrs.items()}


@checked_arguments
def tracks_table(tracks: Tracks) -> pd.DataFrame:
    """Return image positions as a table, the columns of ``tracks.csv``.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; without views, positions in px are taken to be those of one view, "image".

    Returns
    -------
    pandas.DataFrame
        ``frame, view, point, u, v, confidence, origin``: a row for every frame, view and
        point that the view tracks anywhere. Where a point is missing u and v are NaN and
        ``origin`` says ``missing``. With several individuals, ``individual`` is added on
        the right. Rows are ordered by frame, then view, then point.

    Examples
    --------
    >>> table = pawnb.io.tracks_table(tracks)
    >>> table[["frame", "view", "point", "u", "v"]].shape[1]
    5
    """
    check_tracks(tracks)
    if "image_position" in tracks:
        order: tuple[str, ...] = ("time", "view", "individual", "keypoint")
        uv = tracks["image_position"].transpose(*order, "image_space").to_numpy()
        confidence = tracks["image_confidence"].transpose(*order).to_numpy()
        origin = tracks["image_origin"].transpose(*order).to_numpy()
        views = _names(tracks, "view")
    elif tracks.sizes["space"] == 2:
        order = ("time", "individual", "keypoint")
        uv = tracks["position"].transpose(*order, "space").to_numpy()[:, None]
        confidence = tracks["confidence"].transpose(*order).to_numpy()[:, None]
        origin = tracks["origin"].transpose(*order).to_numpy()[:, None]
        views = [SINGLE_VIEW]
    else:
        return pd.DataFrame(columns=list(TRACKS_COLUMNS))
    tracked = (origin != ORIGIN_CODE["missing"]).any(axis=0)  # view, individual, point
    places = np.argwhere(tracked)
    frame = tracks["frame"].to_numpy()
    n, m = len(frame), len(places)
    pick = (slice(None), *places.T)
    table = pd.DataFrame(
        {
            "frame": np.repeat(frame, m),
            "view": np.tile(np.array(views, dtype=object)[places[:, 0]], n),
            "point": np.tile(np.array(_names(tracks, "keypoint"), dtype=object)[places[:, 2]], n),
            "u": uv[pick][..., 0].ravel(),
            "v": uv[pick][..., 1].ravel(),
            "confidence": confidence[pick].ravel(),
            "origin": np.array(ORIGINS, dtype=object)[origin[pick].ravel()],
        }
    )
    if tracks.sizes["individual"] > 1:
        who = np.array(_names(tracks, "individual"), dtype=object)
        table["individual"] = np.tile(who[places[:, 1]], n)
    return table


@checked_arguments
def points3d_table(tracks: Tracks) -> pd.DataFrame:
    """Return positions in space as a table, the columns of ``points3d.csv``.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with space x, y, z.

    Returns
    -------
    pandas.DataFrame
        ``frame, point, x, y, z, residual_px, origin``: a row for every frame and point, by
        frame and then point; NaN where the position is unknown. With several individuals,
        ``individual`` is added on the right.

    Raises
    ------
    InputError
        If positions have two dimensions only.

    Examples
    --------
    >>> space = pawnb.schema.make_tracks([0, 1], ["FR"], fps=250.0, unit="mm")
    >>> space["position"].loc[{"keypoint": "FR"}] = 1.5
    >>> pawnb.io.points3d_table(space)["z"].tolist()
    [1.5, 1.5]
    """
    check_tracks(tracks)
    if tracks.sizes["space"] != 3:
        raise InputError("these tracks have no z: points in space need a calibrated rig.")
    order = ("time", "individual", "keypoint")
    xyz = tracks["position"].transpose(*order, "space").to_numpy().reshape(-1, 3)
    origin = tracks["origin"].transpose(*order).to_numpy().ravel()
    n, k, m = (tracks.sizes[dim] for dim in order)
    residual = np.full(n * k * m, np.nan)
    if "residual" in tracks:
        residual = tracks["residual"].transpose(*order).to_numpy().ravel()
    table = pd.DataFrame(
        {
            "frame": np.repeat(tracks["frame"].to_numpy(), k * m),
            "point": np.tile(np.array(_names(tracks, "keypoint"), dtype=object), n * k),
            **{axis: xyz[:, i] for i, axis in enumerate("xyz")},
            "residual_px": residual,
            "origin": np.array(ORIGINS, dtype=object)[origin],
        },
        columns=list(POINTS3D_COLUMNS),
    )
    if k > 1:
        who = np.repeat(np.array(_names(tracks, "individual"), dtype=object), m)
        table["individual"] = np.tile(who, n)
    return table


def _names(tracks: Tracks, dim: str) -> list[str]:
    """Return the labels of a dimension as text."""
    return [str(name) for name in tracks[dim].to_numpy()]
