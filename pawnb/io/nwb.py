"""Tracks in NWB by the extension ndx-pose: read by h5py alone, written by pynwb."""

from __future__ import annotations

import importlib
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError, InputWarning
from pawnb.files import whole_file
from pawnb.input_warnings import warn_of_input
from pawnb.io.extras import need
from pawnb.io.hdf5 import open_hdf5, read_array, read_texts
from pawnb.io.lengths import short_unit, units_per_unit
from pawnb.io.outgoing import take_space, take_view, views_of
from pawnb.io.points import SLOWEST_FILM_HZ, build_tracks, plain_name, tell_rate
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments

_EXPECTED = "NWB with poses of ndx-pose"
_POSE, _SERIES = "PoseEstimation", "PoseEstimationSeries"
_PIXELS = ("pixels", "pixel", "px", "")
_FRAME_OF_PIXELS = "(0, 0) is the centre of the top-left pixel, y down"
_OFF_FRAME = 0.01
"""A first time further than this part of a frame from a whole frame is that of another clock."""
_OFF_STEP = 0.25
"""Steps of time further than this part of a frame from whole frames are none; clocks jitter."""
_DECIMALS_S = 6
"""Decimals of the seconds in which times of several points are one frame's."""
_TRACK, _NO_TRACK = "track=", "untracked"
"""How sleap-io calls the poses of each of its tracks, and those of none."""
_BY_MOVEMENT = (
    ". Of one make a file in Python: from movement.io import load_poses; "
    'poses = load_poses.from_nwb_file(FILE, pose_estimation_key="{0}"); '
    'pawnb.io.write_tracks(pawnb.io.from_movement(poses), "{0}.nc")'
)
"""The way to a file of each view."""


def is_nwb(file: h5py.File) -> bool:
    """Say whether an open HDF5 file is one of NWB."""
    return "nwb_version" in file.attrs or file.attrs.get("neurodata_type") == "NWBFile"


@checked_arguments
def read_nwb(path: str | Path, *, fps: float | None = None, unit: str | None = None) -> Tracks:
    """Read poses of ndx-pose.

    Parameters
    ----------
    path : str or Path
        ``.nwb`` with one ``PoseEstimation`` in a processing module, or one for each of the
        tracks of a video, as sleap-io writes them.
    fps : float, optional
        Frames per second; default as its time stamps say. Needed where they are a second or more
        apart: these count frames, as sleap-io and movement write where they know no rate.
    unit : str, optional
        Unit of length that positions are brought to; default as the file says. Pixels stay pixels.

    Returns
    -------
    xarray.Dataset
        Tracks of the file's subject (of sleap-io: of its tracks), points in the order of its
        skeleton; a point without a row at the time of others is missing there. Units as the file
        says (pixels: px), its ``conversion`` and ``offset`` applied. Where time does not begin
        with a whole frame, as that of a session's clock, the first row is frame 0.

    Raises
    ------
    InputError
        If the file is damaged, holds no poses or several, time stamps are no frames, or the unit
        cannot be brought to that which is given.

    Warns
    -----
    InputWarning
        If places in space are said to be in pixels, which are taken to be in mm or in the unit
        given, or the file says another frame rate than is given.

    Examples
    --------
    Needs ``pawnb[nwb]``.

    >>> path = pawnb.io.write_nwb(tracks, "clip.nwb")
    >>> pawnb.io.read_nwb(path).sizes["keypoint"] == tracks.sizes["keypoint"]
    True
    """
    where = Path(path).name
    with open_hdf5(path, expected=_EXPECTED) as file:
        poses = _find_poses(file, where)
        nodes = _skeleton_nodes(file, where)
        series = [_series_of(group, nodes, where) for group in poses.values()]
        every = [one for own in series for one in own.values()]
        values = [_places(one, where) for one in every]
        scores = [_scores(one, len(v), where) for one, v in zip(every, values, strict=True)]
        rate, frames, rows = _times(every, [len(v) for v in values], fps, where)
        said = str(every[0]["data"].attrs.get("unit", "pixels")).strip()
        animals = _animals(list(poses), _text(file.get("general/subject/subject_id")))
        notes = _text(file.get("general/notes"))
        program = _text(next(iter(poses.values())).get("source_software"))
    n_axes, *others = {v.shape[1] for v in values}
    if others or n_axes not in (2, 3):
        raise InputError(f"{where}: points have {n_axes} axes or several; expected 2 or 3 of all.")
    own, factor = _unit(said, unit, n_axes, where)
    points = list(dict.fromkeys(name for one in series for name in one))
    place = np.full((len(frames), len(points), len(animals), n_axes), np.nan)
    score = np.full(place.shape[:-1], np.nan)
    names = [(points.index(name), k) for k, one in enumerate(series) for name in one]
    for (point, animal), row, v, s in zip(names, rows, values, scores, strict=True):
        place[row, point, animal], score[row, point, animal] = factor * v, s
    tracks = build_tracks(
        frames,
        place,
        score,
        points=[plain_name(name) for name in points],
        fps=rate,
        unit=own,
        program=program or "NWB",
        where=where,
        individuals=animals,
    )
    return _with_notes(tracks, notes)


def _find_poses(file: h5py.File, where: str) -> dict[str, h5py.Group]:
    """Return the group of poses, or of each animal that sleap-io keeps in one module."""
    found: list[str] = []

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Group) and _kind(item) == _POSE:
            found.append(name)

    if isinstance(file.get("processing"), h5py.Group):
        file["processing"].visititems(note)
    apart = [name.rpartition("/") for name in found]
    animals = len({module for module, _, _ in apart}) == 1 and all(
        name.startswith(_TRACK) for _, _, name in apart
    )
    if not found or (len(found) > 1 and not animals):
        way = _BY_MOVEMENT.format(apart[-1][2]) if found else ""
        raise InputError(
            f"{where}: {len(found)} pose estimations ({', '.join(found) or 'none'}); expected "
            f"{_EXPECTED}, those of one view a file{way}."
        )
    return {name: file["processing"][name] for name in found}


def _animals(poses: Sequence[str], subject: str) -> list[str]:
    """Return the animals' ids: the subject, or the tracks of sleap-io."""
    names = [name.rpartition("/")[2] for name in poses]
    tracks = [name.removeprefix(_TRACK) for name in names if name.startswith(_TRACK)]
    if len(poses) > 1:
        return tracks
    return [subject or next((name for name in tracks if name != _NO_TRACK), "animal")]


def _series_of(group: h5py.Group, nodes: list[str], where: str) -> dict[str, h5py.Group]:
    """Return the points of a group of poses, in the order of the skeleton."""
    series = {
        name: item
        for name, item in group.items()
        if isinstance(item, h5py.Group) and _kind(item) == _SERIES
    }
    if not series:
        raise InputError(f"{where}: no {_SERIES} in {group.name}; expected {_EXPECTED}.")
    return {name: series[name] for name in _in_order(list(series), nodes)}


def _kind(item: h5py.Group) -> str:
    """Return the type that NWB gives a group."""
    return str(item.attrs.get("neurodata_type", ""))


def _skeleton_nodes(file: h5py.File, where: str) -> list[str]:
    """Return the names of the nodes of the first skeleton, in their order."""
    found: list[str] = []

    def note(_: str, item: Any) -> None:
        known = isinstance(item, h5py.Group) and _kind(item) == "Skeleton" and "nodes" in item
        if known and not found:
            found.extend(read_texts(item, "nodes", where=where))

    file["processing"].visititems(note)
    return found


def _in_order(names: list[str], nodes: list[str]) -> list[str]:
    """Return names in the order of the skeleton, if it names all of them."""
    plain = {plain_name(name): name for name in names}
    order = [plain_name(node) for node in nodes]
    return [plain[name] for name in order] if sorted(order) == sorted(plain) else names


def _places(series: h5py.Group, where: str) -> FloatArray:
    """Return the places of a point in the unit that the file says: NWB keeps them scaled."""
    data = read_array(series, "data", where=where, ndim=2).astype(float)
    told = series["data"].attrs
    return data * float(told.get("conversion", 1.0)) + float(told.get("offset", 0.0))


def _scores(series: h5py.Group, n: int, where: str) -> FloatArray:
    """Return the confidence of a point in each row, NaN where there is none."""
    if "confidence" not in series:
        return np.full(n, np.nan)
    told = read_array(series, "confidence", where=where, ndim=1).astype(float)
    if len(told) != n:
        raise InputError(f"{where}: {series.name} has {n} places and {len(told)} confidences.")
    return told


def _unit(said: str, wanted: str | None, n_axes: int, where: str) -> tuple[str, float]:
    """Return the unit of positions, and by what they are multiplied to be in it."""
    if said.lower() in _PIXELS:
        if n_axes == 2:
            return "px", 1.0
        warn_of_input(
            f"{where}: positions in space that are said to be in pixels: lengths are taken to be "
            f"in {wanted or 'mm'}. Where they are in another unit, name the file in a trial.toml "
            "of kind 'tracks' with its unit below [calibration].",
            InputWarning,
            stacklevel=3,
        )
        return wanted or "mm", 1.0
    own = short_unit(said)
    return wanted or own, 1.0 if wanted is None else units_per_unit(own, wanted, where=where)


def _times(
    series: Sequence[h5py.Group], lengths: Sequence[int], fps: float | None, where: str
) -> tuple[float, IntArray, list[IntArray]]:
    """Return the frame rate, the number of each frame, and in which rows each point has a place.

    Points may have rows of their own: sleap-io leaves out where a point was not seen.
    """
    step_s = _step_of(series, where)
    stamps = [_stamps(one, n, step_s, where) for one, n in zip(series, lengths, strict=True)]
    own = [np.round(times, _DECIMALS_S) for times, _ in stamps]
    times = np.unique(np.concatenate(own))
    told = {rate for _, rate in stamps}
    fixed = len(told) == 1 and np.isfinite(next(iter(told)))
    said = next(iter(told)) if fixed else _rate_of(np.diff(times))
    counted = said <= SLOWEST_FILM_HZ  # then these are numbers of frames, and no seconds
    rate = fps or (np.nan if counted else said)
    if counted and fps is None:
        raise InputError(
            f"{where}: its time stamps are {1 / said:g} s apart, as sleap-io and movement count "
            "frames where no frame rate was told; give fps, the frames per second of the recording "
            "(--fps on the command line)."
        )
    if not 0 < rate < np.inf:
        raise InputError(f"{where}: no frame rate; give fps, the frames per second.")
    clock = said if counted or fixed else rate
    steps = np.diff(times) * clock
    counts = np.rint(steps)
    falls = any((np.diff(one) <= 0).any() for one in own)
    if falls or not (np.abs(steps - counts) <= _OFF_STEP).all() or (counts < 1).any():
        raise InputError(
            f"{where}: times fall between frames at {clock:g} frames per second, or do not rise; "
            "give the fps of the recording."
        )
    if not counted and said > 0:
        tell_rate(where, said, fps, stacklevel=3)
    first = times[:1] * clock
    first = np.where(np.abs(first - np.rint(first)) <= _OFF_FRAME, np.rint(first), 0.0)
    frames = np.concatenate([first, first + np.cumsum(counts)]).astype(np.int64)[: len(times)]
    return rate, frames, [np.searchsorted(times, one) for one in own]


def _step_of(series: Sequence[h5py.Group], where: str) -> float:
    """Return the usual step of time stamps, 1 where there are none.

    sleap-io, told a rate where it takes a period, steps by as many seconds, and says a rate of 0.
    """
    stamped = [one for one in series if "timestamps" in one]
    steps = [np.diff(read_array(one, "timestamps", where=where, ndim=1)) for one in stamped]
    every = np.concatenate([*steps, np.zeros(0)])
    return float(np.median(every)) if len(every) else 1.0


def _stamps(series: h5py.Group, n: int, step_s: float, where: str) -> tuple[FloatArray, float]:
    """Return the time of each row of a point, and the rate where the file says one."""
    if "timestamps" in series:
        times = read_array(series, "timestamps", where=where, ndim=1).astype(float)
        if len(times) != n:
            raise InputError(f"{where}: {series.name} has {n} places and {len(times)} times.")
        return times, np.nan
    start = series.get("starting_time")
    if not isinstance(start, h5py.Dataset) or start.shape != ():
        raise InputError(f"{where}: points have no time stamps; expected {_EXPECTED}.")
    rate = float(start.attrs.get("rate", np.nan))
    rate = rate if rate > 0 else 1.0 / step_s
    return float(start[()]) + np.arange(n) / rate, rate


def _rate_of(steps_s: FloatArray) -> float:
    """Return the frames per second of time stamps that may jitter, and leave frames out."""
    step = float(np.median(steps_s)) if len(steps_s) else np.nan
    if not 0 < step < np.inf:
        return np.nan
    n = np.rint(steps_s / step).sum()
    return round(float(n / steps_s.sum()), 6) if n > 0 else np.nan


def _text(item: Any) -> str:
    """Return what a dataset of one text says, or nothing."""
    if not isinstance(item, h5py.Dataset) or item.shape != ():
        return ""
    value = item[()]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _with_notes(tracks: Tracks, notes: str) -> Tracks:
    """Put the provenance that pawnb wrote as notes before what was done in reading."""
    try:
        said = json.loads(notes)
        own = json.loads(tracks.attrs["provenance"])
        steps = [*said["steps"], *own.get("steps", [])]
    except (ValueError, TypeError, KeyError, RecursionError):
        return tracks
    record = {**said, **own, "steps": steps}
    return tracks.assign_attrs(provenance=json.dumps(record, sort_keys=True))


@checked_arguments
def write_nwb(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write poses as NWB with ndx-pose.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one animal: points in a view, or in space where there are no others.
    path : str or Path
        ``.nwb``.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file: subject, frame rate, points with confidence, the provenance as notes. NWB asks
        for a date of the session, which tracks do not know: it is 1 January 1970.

    Raises
    ------
    InputError
        If pynwb or ndx-pose is not installed (``pip install pawnb[nwb]``), or there are several
        animals.

    Examples
    --------
    Needs ``pawnb[nwb]``.

    >>> pawnb.io.write_nwb(tracks, "clip.nwb").name
    'clip.nwb'
    """
    path = Path(path)
    pynwb: Any = need("pynwb", "nwb", what=f"to write {path.name}")
    ndx: Any = need("ndx_pose", "nwb", what=f"to write {path.name}")
    own = take_view(tracks, view) if views_of(tracks) else take_space(tracks)
    own.only_animal("NWB")
    unit = "px" if views_of(tracks) else str(own.attrs.get("units") or "mm")
    unit = "pixels" if unit == "px" else unit
    subject = importlib.import_module("pynwb.file").Subject(subject_id=own.individuals[0])
    nwb = pynwb.NWBFile(
        session_description="animal tracked from video",
        identifier=f"{own.individuals[0]}-{path.stem}",
        session_start_time=datetime(1970, 1, 1, tzinfo=UTC),
        subject=subject,
        notes=str(own.attrs.get("provenance") or "{}"),
    )
    skeleton = ndx.Skeleton(name="skeleton", nodes=own.points, subject=subject)
    # a row for each frame, those without points among them: one rate says all times
    series = [
        ndx.PoseEstimationSeries(
            name=point,
            description=f"{point}, {view or 'tracked'}",
            data=own.place[:, k, 0],
            unit=unit,
            reference_frame=_FRAME_OF_PIXELS if unit == "pixels" else "calibrated space",
            timestamps=own.frames / own.fps,
            confidence=own.confidence[:, k, 0],
            confidence_definition="likelihood of the point",
        )
        for k, point in enumerate(own.points)
    ]
    pose = ndx.PoseEstimation(
        name=_POSE,
        pose_estimation_series=series,
        description=f"view {view}" if view else "tracks",
        source_software=str(own.attrs.get("source_software") or "pawnb"),
        skeleton=skeleton,
    )
    module = nwb.create_processing_module(name="behavior", description="tracked points")
    module.add(ndx.Skeletons(skeletons=[skeleton]))
    module.add(pose)
    with whole_file(path) as part, pynwb.NWBHDF5IO(str(part), "w") as io:
        io.write(nwb)
    return path
