"""Tracks: names and dimensions of their variables, empty ones, and checks."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from pawnb.arrays import AnyArray, IntArray
from pawnb.errors import InputError
from pawnb.schema.settings import shown

Tracks = xr.Dataset

ORIGINS: tuple[str, ...] = (
    "missing",
    "measured",
    "predicted",
    "resolved",
    "reprojected",
    "edited",
)
"""Where a point comes from; its place in this tuple is the code stored in a file."""

ORIGIN_CODE: dict[str, int] = {name: code for code, name in enumerate(ORIGINS)}

_KEYPOINT_DIMS = ("time", "keypoint", "individual")
_DIMS: dict[str, tuple[str, ...]] = {
    "position": ("time", "space", "keypoint", "individual"),
    "confidence": _KEYPOINT_DIMS,
    "origin": _KEYPOINT_DIMS,
    "residual": _KEYPOINT_DIMS,
    "sd": ("time", "space", "keypoint", "individual"),
    "revision": _KEYPOINT_DIMS,
    "passes_apart": _KEYPOINT_DIMS,
    "image_position": ("time", "view", "image_space", "keypoint", "individual"),
    "image_confidence": ("time", "view", "keypoint", "individual"),
    "image_origin": ("time", "view", "keypoint", "individual"),
    "image_residual": ("time", "view", "keypoint", "individual"),
    "image_offset": ("time", "view", "image_space", "keypoint", "individual"),
    "image_separation": ("time", "view", "keypoint", "individual"),
    "image_likeness": ("time", "view", "keypoint", "individual"),
    # jointed animals
    "joint_angle": ("time", "joint", "individual"),
    "joint_angle_sd": ("time", "joint", "individual"),
    "segment_length": ("time", "segment", "individual"),
    "heading": ("time", "individual"),
    "heading_sd": ("time", "individual"),
    "scale": ("time", "individual"),
}
_AXES = {"space": ["x", "y", "z"], "image_space": ["u", "v"]}
_RATES_APART = 10.0
"""Times of a recording are its frames' by ``fps``, or the stamps of its film, which are brought to
``fps`` where they are more than three times off; frames or milliseconds are further off."""

_REQUIRED = ("position", "confidence", "origin")
_DTYPES = {"origin": np.int8, "image_origin": np.int8}


def check_fps(fps: float) -> None:
    """Refuse what is no frame rate.

    Parameters
    ----------
    fps : float
        Frames per second.

    Raises
    ------
    InputError
        If it is not a number above 0; text is none, whatever it says.
    """
    is_number = isinstance(fps, int | float | np.number) and not isinstance(fps, bool)
    if not (is_number and 0 < fps < math.inf):
        found = f"{fps:g}" if is_number else shown(fps)
        raise InputError(f"fps is {found}; expected frames per second, a number above 0.")


def make_tracks(
    frames: Sequence[int] | IntArray,
    points: Sequence[str],
    *,
    fps: float,
    views: Sequence[str] = (),
    space: Sequence[str] = ("x", "y", "z"),
    individual: str = "animal",
    unit: str = "px",
    time_s: np.ndarray | None = None,
    source_software: str = "pawnb",
) -> Tracks:
    """Make Tracks in which every point is still missing.

    Parameters
    ----------
    frames : sequence of int
        Frame numbers, counted from the first frame of the file.
    points : sequence of str
        Names of the tracked points (``keypoint``).
    fps : float
        Frames per second.
    views : sequence of str
        Names of the views; without any, there are no image variables.
    space : sequence of str
        ``("x", "y")`` or ``("x", "y", "z")``.
    individual : str
        The animal's id.
    unit : str
        Unit of ``position``: ``"px"`` where nothing is calibrated.
    time_s : ndarray, shape (n_frames,), optional
        Time stamps in seconds; default ``frames / fps``.
    source_software : str
        Who made the tracks.

    Returns
    -------
    xarray.Dataset
        ``position`` (time, space, keypoint, individual), ``confidence``, ``origin``
        and ``residual`` (time, keypoint, individual); with views also
        ``image_position`` (time, view, image_space, keypoint, individual) in px,
        ``image_confidence`` and ``image_origin``. Positions are NaN, origins
        ``missing``, confidences 0.

    Raises
    ------
    InputError
        If ``fps`` is not a number above 0, a frame is no whole number, or two points or two views
        have one name.
    """
    check_fps(fps)
    for what, given in (("point", points), ("view", views)):
        if isinstance(given, str):
            raise InputError(f"{what}s is {given!r}; expected a list of names, as [{given!r}].")
        twice = next((name for i, name in enumerate(given) if name in given[:i]), None)
        if twice is not None:
            raise InputError(f"two {what}s are called {twice!r}; give each its own name.")
    frames = _whole_frames(frames)
    coords: dict[str, Any] = {
        "time": frames / float(fps) if time_s is None else np.asarray(time_s, dtype=float),
        "frame": ("time", frames),
        "space": list(space),
        "keypoint": list(points),
        "individual": [individual],
    }
    names = ["position", "confidence", "origin", "residual"]
    if views:
        coords["view"] = list(views)
        coords["image_space"] = ["u", "v"]
        names += ["image_position", "image_confidence", "image_origin"]
    sizes = {name: len(frames) if name == "time" else len(coords[name]) for name in coords}
    data = {}
    for name in names:
        shape = tuple(sizes[dim] for dim in _DIMS[name])
        fill = np.nan if name in {"position", "image_position", "residual"} else 0
        data[name] = (_DIMS[name], np.full(shape, fill, dtype=_DTYPES.get(name, float)))
    tracks = xr.Dataset(data, coords=coords)
    tracks.attrs = {
        "fps": float(fps),
        "time_unit": "seconds",
        "units": unit,
        "ds_type": "poses",
        "source_software": source_software,
        "provenance": "{}",
    }
    for name in ("origin", "image_origin"):
        if name in tracks:
            tracks[name].attrs = {
                "flag_values": np.arange(len(ORIGINS), dtype=np.int8),
                "flag_meanings": " ".join(ORIGINS),
            }
    tracks["position"].attrs["units"] = unit
    for name in ("residual", "image_position"):
        if name in tracks:
            tracks[name].attrs["units"] = "px"
    return tracks


def check_tracks(tracks: Tracks, *, where: str = "these tracks") -> Tracks:
    """Return ``tracks`` unchanged if they follow the schema, else say all that is wrong.

    Parameters
    ----------
    tracks : xarray.Dataset
        What to check.
    where : str
        How the message names them, for instance the file.

    Returns
    -------
    xarray.Dataset
        The same object.

    Raises
    ------
    InputError
        If variables, dimensions, or the attribute ``fps`` are missing or wrong, if a name is there
        twice or is no text, axes are not in the order x, y, z, times are no seconds, or the
        provenance is no JSON.
    """
    if not isinstance(tracks, xr.Dataset):
        raise InputError(
            f"{where}: expected Tracks (an xarray.Dataset), found {type(tracks).__name__}."
        )
    faults = [f"no variable {name!r}" for name in _REQUIRED if name not in tracks]
    for name, dims in _DIMS.items():
        if name in tracks and tuple(tracks[name].dims) != dims:
            faults.append(f"{name!r} has dimensions {tracks[name].dims} instead of {dims}")
    fps = tracks.attrs.get("fps")
    if not isinstance(fps, int | float | np.number) or not 0 < fps < np.inf:
        faults.append(f"attribute fps is {fps!r} instead of a positive number")
    if "frame" not in tracks.coords:
        faults.append("no coordinate 'frame' along time")
    if not faults:
        faults = [*_faults_of_labels(tracks), *_faults_of_time(tracks), *_faults_of_record(tracks)]
    if faults:
        raise InputError(
            f"{where}: not Tracks as pawnb writes them: " + "; ".join(faults) + ". "
            "Make them with pawnb.schema.make_tracks or a reader of pawnb.io."
        )
    return tracks


def _whole_frames(frames: Sequence[int] | AnyArray) -> IntArray:
    """Return frame numbers as they are; to cut a fraction off would name another frame."""
    given = np.asarray(frames)
    if given.size and given.dtype.kind not in "iuf":
        raise InputError(f"frames are {given.ravel().tolist()[0]!r} ...; expected whole numbers.")
    broken = np.flatnonzero(given != np.rint(given))
    if broken.size:
        raise InputError(f"frames hold {given[broken[0]]:g}; expected whole numbers.")
    return given.astype(np.int64)


def _faults_of_labels(tracks: Tracks) -> list[str]:
    """Return what is wrong with the names along the dimensions."""
    faults = []
    for dim, axes in _AXES.items():
        found = [str(name) for name in tracks[dim].to_numpy()] if dim in tracks.coords else []
        if [name.casefold() for name in found] != axes[: len(found)]:
            faults.append(
                f"{dim!r} is {', '.join(found)} instead of {', '.join(axes[: len(found)])}"
            )
    for dim in ("keypoint", "individual", "view"):
        if dim not in tracks.dims:
            continue
        names = tracks[dim].to_numpy().tolist() if dim in tracks.coords else [None]
        twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
        if not all(isinstance(name, str) for name in names):
            faults.append(f"names along {dim!r} are no text")
        elif twice is not None:
            faults.append(f"{dim} {twice!r} is there twice")
    return faults


def _faults_of_time(tracks: Tracks) -> list[str]:
    """Return what is wrong with the times: every duration and speed follows from them."""
    time, frame = (tracks[name].to_numpy() for name in ("time", "frame"))
    if "time" not in tracks.coords:
        return ["no coordinate 'time' in seconds"]
    if time.dtype.kind not in "iuf":
        return [f"times are of type {time.dtype} instead of numbers, in seconds"]
    if frame.dtype.kind not in "iuf":
        return [f"frames are of type {frame.dtype} instead of whole numbers"]
    if len(time) < 2:
        return []
    step, apart = (float(np.median(np.abs(np.diff(one.astype(float))))) for one in (time, frame))
    fps = float(tracks.attrs["fps"])
    if step > 0 and apart > 0 and not 1 / _RATES_APART <= apart / step / fps <= _RATES_APART:
        rate = f"{apart / step:g} frames a second instead of {fps:g}"
        return [f"times run at {rate}: bring them to seconds"]
    return []


def _faults_of_record(tracks: Tracks) -> list[str]:
    """Return what is wrong with the provenance."""
    try:
        record = json.loads(tracks.attrs.get("provenance", "{}"))
    except (ValueError, TypeError, RecursionError):
        record = None
    return [] if isinstance(record, dict) else ["attribute provenance is no JSON object"]


def add_provenance(tracks: Tracks, **entry: Any) -> Tracks:
    """Return Tracks whose provenance has ``entry`` added as its last step.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; not modified.
    **entry
        What was done: ``step="track", method="paper", settings={...}``. Values must
        be writable as JSON.

    Returns
    -------
    xarray.Dataset
        A shallow copy with the longer provenance.
    """
    record = json.loads(tracks.attrs.get("provenance", "{}"))
    record.setdefault("steps", []).append(entry)
    return tracks.assign_attrs(provenance=json.dumps(record, sort_keys=True))
