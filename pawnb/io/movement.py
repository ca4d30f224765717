"""To and from datasets of movement (https://movement.neuroinformatics.dev).

movement's releases differ in how they name two dimensions: ``keypoints`` and
``individuals`` in some, ``keypoint`` and ``individual`` in others. Both are read, and
either can be made. movement itself is not needed for that.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Literal

import h5netcdf
import numpy as np
import xarray as xr
from xarray.backends import H5NetCDFStore

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.files import write_whole
from pawnb.io.lengths import tell_no_unit, units_per_unit
from pawnb.io.outgoing import take_space, take_view, views_of
from pawnb.io.points import check_finite, check_names, plain_name, tell_rate
from pawnb.schema import (
    ORIGIN_CODE,
    Tracks,
    check_frames,
    check_tracks,
    every_frame,
    make_tracks,
    note_absent,
)
from pawnb.schema.arguments import checked_arguments

_PLURAL = {"keypoint": "keypoints", "individual": "individuals"}
_SINGULAR = {plural: singular for singular, plural in _PLURAL.items()}

_OFF_FRAME = 0.01
"""Times further than this part of a frame from a whole frame are no frame numbers."""


def is_movement(dataset: xr.Dataset) -> bool:
    """Say whether a dataset follows movement's schema rather than pawnb's own.

    Parameters
    ----------
    dataset : xarray.Dataset
        Anything with named dimensions.

    Returns
    -------
    bool
        True for poses with movement's plural dimensions, or without pawnb's ``origin`` and
        ``frame``.
    """
    if "position" not in dataset:
        return False
    if any(name in dataset.dims for name in _SINGULAR):
        return True
    return "origin" not in dataset and "frame" not in dataset.coords


@checked_arguments
def to_movement(tracks: Tracks, *, dims: Literal["plural", "singular"] = "plural") -> xr.Dataset:
    """Return Tracks as a poses dataset that movement takes.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; not modified.
    dims : {"plural", "singular"}
        How the movement release at hand names keypoints and individuals: ``keypoints`` and
        ``individuals`` (up to at least 0.15), or ``keypoint`` and ``individual``.

    Returns
    -------
    xarray.Dataset
        ``position`` (time, space, keypoints, individuals) and ``confidence`` (time,
        keypoints, individuals) with time in seconds, and everything else that the Tracks
        hold, which movement leaves alone.

    Raises
    ------
    InputError
        If these are no Tracks, or ``dims`` is neither of the two.

    Examples
    --------
    >>> pawnb.io.to_movement(tracks).attrs["ds_type"]
    'poses'
    """
    check_tracks(tracks)
    if dims not in ("plural", "singular"):
        raise InputError(f"dims is {dims!r}; expected 'plural' or 'singular'.")
    dataset = tracks.rename(_PLURAL) if dims == "plural" else tracks.copy()
    dataset.attrs = {**tracks.attrs, "ds_type": "poses", "time_unit": "seconds"}
    return dataset


@checked_arguments
def write_movement(
    tracks: Tracks,
    path: str | Path,
    *,
    view: str = "",
    dims: Literal["plural", "singular"] = "plural",
) -> Path:
    """Write a poses dataset of movement as netCDF, with nothing that movement does not know.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks: points in a view, or in space where there are no others.
    path : str or Path
        ``.nc``.
    view : str
        The view, where there are several.
    dims : {"plural", "singular"}
        As for :func:`to_movement`.

    Returns
    -------
    Path
        The file. Frames without a row keep theirs, as movement takes times to be regular.

    Raises
    ------
    InputError
        If there are no points.

    Examples
    --------
    >>> pawnb.io.write_movement(tracks, "poses.nc").name
    'poses.nc'
    """
    own = take_view(tracks, view) if views_of(tracks) else take_space(tracks)
    names = ("keypoints", "individuals") if dims == "plural" else ("keypoint", "individual")
    every = every_frame(own.frames)
    rows = np.searchsorted(every, own.frames)
    place = np.full((len(every), *own.place.shape[1:]), np.nan)
    place[rows] = own.place
    confidence = np.full(place.shape[:-1], np.nan)
    confidence[rows] = own.confidence
    dataset = xr.Dataset(
        {
            "position": (("time", "space", *names), place.transpose(0, 3, 1, 2)),
            "confidence": (("time", *names), confidence),
        },
        coords={
            "time": every / own.fps,
            "space": list("xyz")[: place.shape[-1]],
            names[0]: own.points,
            names[1]: own.individuals,
        },
        attrs={
            "fps": own.fps,
            "time_unit": "seconds",
            "ds_type": "poses",
            "source_software": str(own.attrs.get("source_software") or "pawnb"),
            "units": "px" if place.shape[-1] == 2 else str(own.attrs.get("units") or "mm"),
        },
    )
    return write_whole(path, netcdf_bytes(dataset))


def netcdf_bytes(dataset: xr.Dataset) -> bytes:
    """Return what a netCDF file of a dataset holds.

    The library makes it in memory: writing to a disk that fills up it crashes the process.

    Parameters
    ----------
    dataset : xarray.Dataset
        What to write.

    Returns
    -------
    bytes
        The file.
    """
    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file))
    return buffer.getvalue()


@checked_arguments
def from_movement(
    dataset: xr.Dataset,
    *,
    fps: float | None = None,
    unit: str | None = None,
    where: str = "this dataset",
) -> Tracks:
    """Make Tracks from a poses dataset of movement, whatever its loader.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``position`` with dimensions time, space, keypoint(s), individual(s) (which may lack, as
        where one was selected), and for several views also view; ``confidence`` where there is
        one.
    fps : float, optional
        Frames per second. Needed for a dataset that does not say (its time counts frames then);
        where it says others, as a film that plays slowed down does, its times are brought to these.
    unit : str, optional
        Unit of length that positions in space are brought to; default as the dataset says, which
        movement's own do not: mm then.
    where : str
        How messages name the dataset, for instance the file.

    Returns
    -------
    xarray.Dataset
        Tracks. Points with a position are ``measured``, others ``missing``; frames are
        counted from the times (from 0 where these do not begin with a whole frame, as those of
        a session's clock), and those that lack are missing. A dataset with a view
        dimension gives image positions, its positions in space are missing. Confidence stays
        NaN where it was not given.

    Raises
    ------
    InputError
        If it holds no poses, has no frame rate, or its times fall between frames, do not
        rise, or are neither seconds nor frames.

    Warns
    -----
    InputWarning
        If positions in space have no unit, or the dataset says another frame rate than is given.

    Examples
    --------
    >>> again = pawnb.io.from_movement(pawnb.io.to_movement(tracks))
    >>> again.sizes["keypoint"] == tracks.sizes["keypoint"]
    True
    """
    names = {name: new for name, new in _SINGULAR.items() if name in dataset.dims}
    dataset = dataset.rename(names)
    dataset = _in_our_order(dataset, where)
    needed = {"time", "space", "keypoint", "individual"}
    if dataset.attrs.get("ds_type", "poses") != "poses" or "position" not in dataset:
        raise InputError(
            f"{where}: not a poses dataset of movement; bounding boxes have no points."
        )
    found = set(dataset["position"].dims)
    if not needed <= found or found - needed - {"view"}:
        raise InputError(
            f"{where}: position has dimensions {tuple(dataset['position'].dims)}; expected time, "
            "space, keypoint(s), individual(s), and view where there are several."
        )
    if "origin" in dataset and "frame" in dataset.coords:
        return check_tracks(dataset, where=where)  # Tracks that went through movement
    own_rate = _said_rate(dataset)
    rate = _frame_rate(own_rate, fps, where)
    frames = check_frames(_frames(dataset, own_rate or rate, where), where=where)
    every = every_frame(frames)
    views = [str(v) for v in dataset["view"].to_numpy()] if "view" in found else []
    space = [str(s) for s in dataset["space"].to_numpy()]
    points = [plain_name(str(k)) for k in dataset["keypoint"].to_numpy()]
    animals = [str(i) for i in dataset["individual"].to_numpy()]
    for labels, what in ((points, "point"), (animals, "animal"), (views, "view")):
        check_names(labels, what=what, where=where)
    tracks = make_tracks(
        every,
        points,
        fps=rate,
        views=views,
        space=("x", "y", "z") if views else space,
        source_software=str(dataset.attrs.get("source_software") or "movement"),
        unit="px" if views else _unit(dataset, unit, where),
    )
    if len(animals) != 1:
        tracks = tracks.isel(individual=np.zeros(len(animals), dtype=int)).copy(deep=True)
    tracks = tracks.assign_coords(individual=np.array(animals, dtype=str))
    _enter(tracks, dataset, np.searchsorted(every, frames), where)
    said = str(dataset.attrs.get("units") or "")
    if said and tracks.attrs["units"] not in ("px", said):
        factor = units_per_unit(said, str(tracks.attrs["units"]), where=where)
        tracks["position"].to_numpy()[:] *= factor
    if "log" in dataset.attrs:
        steps = [{"step": "movement", "log": dataset.attrs["log"]}]
        tracks.attrs["provenance"] = json.dumps({"steps": steps}, sort_keys=True)
    return check_tracks(note_absent(tracks, frames, file=where), where=where)


def _enter(tracks: Tracks, dataset: xr.Dataset, rows: IntArray, where: str) -> None:
    """Copy positions and confidences, into the views where there are several."""
    prefix = "image_" if "view" in tracks.dims else ""
    place = tracks[f"{prefix}position"]
    order = ["space" if dim == "image_space" else dim for dim in map(str, place.dims)]
    values = dataset["position"].transpose(*order).to_numpy()
    if values.shape[1:] != place.shape[1:]:
        raise InputError(
            f"{where}: views hold u and v, but position has {dataset.sizes['space']} values for "
            "each point."
        )
    check_finite(
        np.moveaxis(values, order.index("space"), -1),
        frames=rows, points=[str(k) for k in dataset["keypoint"].to_numpy()], where=where,
    )  # fmt: skip
    place.to_numpy()[rows] = values
    known = np.isfinite(values).all(axis=order.index("space"))
    dims = [dim for dim in order if dim != "space"]
    confidence = np.full(known.shape, np.nan)
    if "confidence" in dataset:
        confidence = dataset["confidence"].transpose(*dims).to_numpy()
    tracks[f"{prefix}confidence"].to_numpy()[rows] = np.where(known, confidence, 0.0)
    tracks[f"{prefix}origin"].to_numpy()[rows] = np.where(
        known, ORIGIN_CODE["measured"], ORIGIN_CODE["missing"]
    )


def _in_our_order(dataset: xr.Dataset, where: str) -> xr.Dataset:
    """Return a dataset with an animal, where one was selected, and coordinates in order."""
    if "position" not in dataset:
        return dataset
    if "individual" not in dataset["position"].dims:
        own = dataset.coords.get("individual", dataset.coords.get("individuals"))
        name = "animal" if own is None or own.ndim else str(own.item())
        dataset = dataset.drop_vars(["individual", "individuals"], errors="ignore")
        dataset = dataset.expand_dims(individual=[name])
    if "space" in dataset.coords:
        space = [str(s).lower() for s in dataset["space"].to_numpy()]
        if sorted(space) in (["x", "y"], ["x", "y", "z"]):
            return dataset.assign_coords(space=space).sel(space=sorted(space))
        if dataset["space"].dtype.kind in "UO":  # x and z alone are no picture: there v points down
            raise InputError(
                f"{where}: axes are {', '.join(space)}; expected x and y of a picture, or x, y and "
                "z of space: save all three, or rename them."
            )
    return dataset


def _unit(dataset: xr.Dataset, given: str | None, where: str) -> str:
    """Return the unit of positions: px in a picture; in space as given, or as the dataset says."""
    said = str(dataset.attrs.get("units") or "")
    if dataset.sizes["space"] == 2:
        return said or "px"
    if not (given or said):
        tell_no_unit(where, "as movement stores none", stacklevel=2)
    return given or said or "mm"


def _said_rate(dataset: xr.Dataset) -> float | None:
    """Return the frame rate that the dataset says."""
    stored = dataset.attrs.get("fps")
    try:
        rate = None if stored is None else float(np.asarray(stored).item())
    except (TypeError, ValueError):
        return None
    return rate if rate is not None and 0 < rate < np.inf else None


def _frame_rate(said: float | None, fps: float | None, where: str) -> float:
    """Return the frame rate: the caller's, or that which the dataset says."""
    rate = said if fps is None else fps
    if rate is None or not 0 < rate < np.inf:
        raise InputError(
            f"{where}: no frame rate; give fps, the frames per second of the recording (--fps on "
            "the command line)."
        )
    if said is not None:
        tell_rate(where, said, rate, stacklevel=3)
    return rate


def _frames(dataset: xr.Dataset, fps: float, where: str) -> FloatArray:
    """Return frame numbers from the time coordinate, in frames or in seconds."""
    if "time" not in dataset.coords or dataset["time"].dtype.kind not in "iuf":
        raise InputError(f"{where}: times are no numbers; expected seconds, or frames.")
    time = np.asarray(dataset["time"].to_numpy(), dtype=float)
    # attributes are lost in many a step of xarray's: whole numbers are frames then
    counted = "seconds" if dataset["time"].dtype.kind == "f" else "frames"
    unit = str(dataset.attrs.get("time_unit") or counted)
    if unit not in ("seconds", "frames"):
        raise InputError(
            f"{where}: time_unit is {unit!r}; expected 'seconds' or 'frames', the two of movement: "
            "bring its times to one of them."
        )
    exact = time if unit == "frames" else time * fps
    if unit == "seconds" and exact.size and abs(exact[0] - np.rint(exact[0])) > _OFF_FRAME:
        exact = exact - exact[0]  # the clock of a session
    frames = np.rint(exact)
    off = np.abs(exact - frames)
    if off.size and not off.max() <= _OFF_FRAME:
        raise InputError(
            f"{where}: times fall between frames at {fps:g} frames per second (the first at "
            f"{time[np.argmax(off)]:g}); give the fps of the recording."
        )
    return frames
