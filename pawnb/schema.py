"""What travels between the parts of pawnb: Tracks, the gait tables, and settings.

``Tracks`` is an :class:`xarray.Dataset`; whoever knows movement knows it. This
module holds its names, makes empty ones, and checks them. The columns of the
gait tables are listed here once, so that every writer and reader agrees.
"""

from __future__ import annotations

import dataclasses
import json
import math
import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from pawnb.errors import InputError, did_you_mean

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

START_COLUMNS = ("frame", "view", "point", "u", "v")
TRACKS_COLUMNS = ("frame", "view", "point", "u", "v", "confidence", "origin")
POINTS3D_COLUMNS = ("frame", "point", "x", "y", "z", "residual_px", "origin")
EVENTS_COLUMNS = ("animal", "trial", "leg", "event", "frame", "time_s", "method")
STRIDES_COLUMNS = (
    "animal",
    "trial",
    "leg",
    "stride",
    "start_s",
    "period_s",
    "frequency_hz",
    "stance_s",
    "swing_s",
    "duty_factor",
    "stride_length",
    "speed",
)
PHASES_COLUMNS = ("animal", "trial", "leg", "reference", "stride", "phase")
_PHASE_STATISTICS = (
    "mean",
    "ci_low",
    "ci_high",
    "r",
    "circular_sd",
    "rayleigh_z",
    "rayleigh_p",
    "pattern",
)
PHASE_SUMMARY_COLUMNS = (
    "leg",
    "reference",
    "n",
    "n_animals",
    *_PHASE_STATISTICS,
    *(f"{name}_strides" for name in _PHASE_STATISTICS),
    "moore_r",
    "moore_p",
    "note",
)
DROPPED_COLUMNS = ("animal", "trial", "leg", "start_s", "end_s", "what", "why")
SUSPECTS_COLUMNS = ("frame", "view", "point", "reason", "score")

_KEYPOINT_DIMS = ("time", "keypoint", "individual")
_DIMS: dict[str, tuple[str, ...]] = {
    "position": ("time", "space", "keypoint", "individual"),
    "confidence": _KEYPOINT_DIMS,
    "origin": _KEYPOINT_DIMS,
    "residual": _KEYPOINT_DIMS,
    "sd": ("time", "space", "keypoint", "individual"),
    "revision": _KEYPOINT_DIMS,
    "image_position": ("time", "view", "image_space", "keypoint", "individual"),
    "image_confidence": ("time", "view", "keypoint", "individual"),
    "image_origin": ("time", "view", "keypoint", "individual"),
    "image_residual": ("time", "view", "keypoint", "individual"),
    # jointed animals
    "joint_angle": ("time", "joint", "individual"),
    "joint_angle_sd": ("time", "joint", "individual"),
    "segment_length": ("time", "segment", "individual"),
    "heading": ("time", "individual"),
    "heading_sd": ("time", "individual"),
    "scale": ("time", "individual"),
}
_REQUIRED = ("position", "confidence", "origin")
_DTYPES = {"origin": np.int8, "image_origin": np.int8}


def make_tracks(
    frames: Sequence[int] | np.ndarray,
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
    """
    frames = np.asarray(frames, dtype=np.int64)
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
        If variables, dimensions, or the attribute ``fps`` are missing or wrong.
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
    if fps is None or not np.isfinite(fps) or fps <= 0:
        faults.append(f"attribute fps is {fps!r} instead of a positive number")
    if "frame" not in tracks.coords:
        faults.append("no coordinate 'frame' along time")
    if faults:
        raise InputError(
            f"{where}: not Tracks as pawnb writes them: " + "; ".join(faults) + ". "
            "Make them with pawnb.schema.make_tracks or a reader of pawnb.io."
        )
    return tracks


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


def check_columns(table: pd.DataFrame, expected: Sequence[str], *, where: str) -> pd.DataFrame:
    """Return ``table`` if it has every expected column; further columns are welcome.

    Parameters
    ----------
    table : pandas.DataFrame
        A table as it was read.
    expected : sequence of str
        Names of the columns it must have.
    where : str
        File name for the message.

    Returns
    -------
    pandas.DataFrame
        The same table.

    Raises
    ------
    InputError
        If a column is missing; a near name is suggested.
    """
    missing = [name for name in expected if name not in table.columns]
    if missing:
        found = [str(name) for name in table.columns]
        spare = [name for name in found if name not in expected]
        hint = did_you_mean(missing[0], spare).replace("did you mean", "is it in column")
        raise InputError(
            f"{where}: column {missing[0]!r} is missing{hint}; "
            f"expected {', '.join(expected)}, found {', '.join(found)}."
        )
    return table


SettingsT = TypeVar("SettingsT")


def build_settings(cls: type[SettingsT], values: Mapping[str, Any], *, where: str) -> SettingsT:
    """Make a frozen settings dataclass from plain values; refuse what it does not know.

    Parameters
    ----------
    cls : type
        A dataclass whose fields all have defaults.
    values : mapping
        Field names to values; text (as from ``--set``) is read as JSON where it can be.
    where : str
        Where the values come from, for the message.

    Returns
    -------
    cls
        The settings.

    Raises
    ------
    InputError
        For an unknown name (a near one is suggested) or a value of the wrong type.
    """
    fields = {f.name for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    hints = typing.get_type_hints(cls)
    clean: dict[str, Any] = {}
    for name, value in values.items():
        if name not in fields:
            raise InputError(
                f"{where}: unknown name {name!r}{did_you_mean(name, fields)}; "
                f"known are {', '.join(sorted(fields))}."
            )
        clean[name] = _convert(value, hints[name], f"{where}: {name}")
    return cls(**clean)


def check_ranges(
    settings: Any, *, above_0: Sequence[str] = (), least_0: Sequence[str] = ()
) -> None:
    """Refuse settings that are not above 0, or below it; None (work it out) is welcome.

    Parameters
    ----------
    settings : dataclass
        The settings.
    above_0, least_0 : sequence of str
        Names of those that must be above 0, and of those that may be 0 too.

    Raises
    ------
    InputError
        For the first number that is out of range, infinite or not a number.
    """
    for name in (*above_0, *least_0):
        value = getattr(settings, name)
        if value is None or (
            math.isfinite(value) and (value > 0 or (value == 0 and name in least_0))
        ):
            continue
        words = "a number, 0 or more" if name in least_0 else "a number above 0"
        raise InputError(f"setting {name!r} is {value}; expected {words}.")


def _options(hint: Any) -> tuple[Any, ...]:
    """Return the members of a union, or the single type."""
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        return typing.get_args(hint)
    return (hint,)


def _convert(value: Any, hint: Any, what: str) -> Any:
    """Convert one plain value to the annotated type, or say what was expected."""
    options = _options(hint)
    if (
        isinstance(value, str)
        and str not in options
        and not any(typing.get_origin(option) is typing.Literal for option in options)
    ):
        try:
            value = json.loads(value.lower() if value in {"True", "False", "None"} else value)
        except json.JSONDecodeError:
            raise InputError(f"{what} is {value!r}; expected {_describe(hint)}.") from None
    if value is None and type(None) in options:
        return None
    for option in options:
        origin, args = typing.get_origin(option), typing.get_args(option)
        if origin is typing.Literal and value in args:
            return value
        if origin is tuple and isinstance(value, list | tuple):
            inner = args[:1] * len(value) if len(args) == 2 and args[1] is ... else args
            if len(inner) == len(value):
                return tuple(_convert(v, t, what) for v, t in zip(value, inner, strict=True))
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if option is float and number:
            return float(value)
        if option is int and number and float(value).is_integer():
            return int(value)
        if option in (bool, str) and isinstance(value, option):
            return value
    raise InputError(f"{what} is {value!r}; expected {_describe(hint)}.")


def _describe(hint: Any) -> str:
    """Say in words what a type annotation allows."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if len(_options(hint)) > 1:
        return " or ".join(_describe(option) for option in args if option is not type(None))
    if origin is typing.Literal:
        return "one of " + ", ".join(repr(a) for a in args)
    if origin is tuple:
        if len(args) == 2 and args[1] is ...:
            return f"a list, each item {_describe(args[0])}"
        return f"a list of {len(args)}, each {_describe(args[0])}"
    words = {
        float: "a number",
        int: "a whole number",
        bool: "true or false",
        str: "text",
    }
    return words.get(hint, str(hint))
