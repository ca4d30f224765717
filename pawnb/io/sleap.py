"""Tracks of SLEAP: the analysis ``.h5``, or the labels ``.slp``."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pawnb.errors import InputError, InputWarning
from pawnb.io.hdf5 import open_hdf5, read_array, read_attribute, read_texts
from pawnb.io.points import build_tracks
from pawnb.schema import Tracks, check_frames

_EXPECTED = "the .slp or analysis .h5 that SLEAP writes"
_ORDER = ("track", "xy", "node", "frame")
"""Order of the dimensions of ``tracks`` where the file does not say."""

_ONE = "id_0"
_USER, _PREDICTED = 0, 1
_CENTRED = 1.1
"""Since this version of .slp (0, 0) is the centre of a pixel; before, it was its corner."""

_NEWEST = 3.0


def read_sleap(path: str | Path, *, fps: float) -> Tracks:
    """Read tracks of SLEAP.

    Parameters
    ----------
    path : str or Path
        Predictions as ``.slp``, or SLEAP's analysis export ``.h5``.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in px with one individual for each of SLEAP's tracks, confidence is the point's
        score (NaN where a person put it). Pixels are taken as they are; those of ``.slp`` files
        before version 1.1, counted from the corner of the first pixel, are moved by half a pixel.
        Of a person's and a predicted instance of one track, the person's is taken. Frames
        without a label are missing, and the provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing, damaged or not of SLEAP, holds several videos or skeletons, has a
        frame twice, or several animals that no track tells apart.

    Examples
    --------
    A file as SLEAP exports it for analysis: one animal, two points, three frames.

    >>> import h5py
    >>> with h5py.File("clip.analysis.h5", "w") as file:
    ...     file["tracks"] = np.arange(12.0).reshape(1, 2, 2, 3)  # animal, axis, point, frame
    ...     file["node_names"] = [b"FR", b"HR"]
    ...     file["track_names"] = [b"mouse"]
    >>> tracks = pawnb.io.read_sleap("clip.analysis.h5", fps=200.0)
    >>> tracks["keypoint"].values.tolist(), tracks.sizes["time"]
    (['FR', 'HR'], 3)
    """
    path = Path(path)
    with open_hdf5(path, expected=_EXPECTED) as file:
        read = _read_labels if path.suffix == ".slp" else _read_analysis
        frames, points, individuals, places, score = read(file, path.name)
    return build_tracks(
        frames,
        places,
        score,
        points=points,
        fps=fps,
        unit="px",
        program="SLEAP",
        where=path.name,
        individuals=individuals or [_ONE],
    )


_Read = tuple[np.ndarray, list[str], list[str], np.ndarray, np.ndarray]


def _read_analysis(file: h5py.File, where: str) -> _Read:
    """Read the analysis export; row i is frame i."""
    data = read_array(file, "tracks", where=where, ndim=4).astype(float)
    points = read_texts(file, "node_names", where=where)
    individuals = read_texts(file, "track_names", where=where) if "track_names" in file else []
    data = _ordered(data, file["tracks"], _ORDER, ("frame", "node", "track", "xy"), where)
    score = np.full(data.shape[:3], np.nan)
    if "point_scores" in file:
        scores = read_array(file, "point_scores", where=where, ndim=3).astype(float)
        order = tuple(name for name in _ORDER if name != "xy")
        score = _ordered(scores, file["point_scores"], order, ("frame", "node", "track"), where)
    n_points, n_tracks = len(points), len(individuals) or 1
    expected = [len(data), n_points, n_tracks]
    if list(data.shape) != [*expected, 2] or list(score.shape) != expected:
        raise InputError(
            f"{where}: damaged, tracks have shape {data.shape} and scores {score.shape}; expected "
            f"{n_points} nodes and {n_tracks} tracks, as the file names them."
        )
    return np.arange(len(data)), points, individuals, data, score


def _ordered(
    data: np.ndarray,
    item: h5py.Dataset,
    order: tuple[str, ...],
    wanted: tuple[str, ...],
    where: str,
) -> np.ndarray:
    """Bring dimensions into the wanted order: newer files say theirs in an attribute."""
    if "dims" in item.attrs:
        said = _from_json(read_attribute(item, "dims", where=where), where)
        if not isinstance(said, list) or sorted(map(str, said)) != sorted(wanted):
            raise InputError(f"{where}: dimensions of {item.name} are {said!r}; expected {wanted}.")
        order = tuple(said)
    return data.transpose([order.index(name) for name in wanted])


def _read_labels(file: h5py.File, where: str) -> _Read:
    """Read a .slp: tables of frames, instances and points."""
    points, version = _skeleton(file, where)
    names = read_texts(file, "tracks_json", where=where)
    individuals = [_track_name(text, where) for text in names]
    frames, instances, user, predicted = (
        read_array(file, name, where=where, ndim=1)
        for name in ("frames", "instances", "points", "pred_points")
    )
    _check_one(frames, "video", "videos", where)
    _check_one(instances, "skeleton", "skeletons", where)
    # labels are kept in the order in which they were made
    numbers = check_frames(np.sort(frames["frame_idx"]), where=where)
    of_frame = dict(zip(frames["frame_id"].tolist(), frames["frame_idx"].tolist(), strict=True))
    shape = (len(numbers), len(points), len(individuals) or 1)
    places, score = np.full((*shape, 2), np.nan), np.full(shape, np.nan)
    for (frame_id, track), row in _chosen(instances, individuals, of_frame, where).items():
        table = predicted if row["instance_type"] == _PREDICTED else user
        own = table[int(row["point_id_start"]) : int(row["point_id_end"])]
        if len(own) != len(points):
            raise InputError(
                f"{where}: damaged, an instance has {len(own)} points; expected {len(points)}."
            )
        at = np.searchsorted(numbers, of_frame[frame_id])
        places[at, :, track] = _positions(own, version)
        score[at, :, track] = own["score"] if row["instance_type"] == _PREDICTED else np.nan
    return numbers, points, individuals, places, score


def _chosen(
    instances: np.ndarray, individuals: list[str], of_frame: dict[int, int], where: str
) -> dict[tuple[int, int], np.void]:
    """Return one instance for each frame and track: a person's, else the predicted one."""
    chosen: dict[tuple[int, int], np.void] = {}
    stray = 0
    for row in instances:
        frame_id, track = int(row["frame_id"]), int(row["track"])
        if frame_id not in of_frame or track >= len(individuals):
            raise InputError(f"{where}: damaged, an instance is of no frame or track of the file.")
        if track < 0 and individuals:
            stray += 1
            continue
        at = (frame_id, max(track, 0))
        before = chosen.get(at)
        if before is not None and before["instance_type"] == row["instance_type"]:
            name = individuals[track] if individuals else "the animal"
            raise InputError(
                f"{where}: frame {of_frame[frame_id]} has two instances of {name}; tell "
                "the animals apart by tracks in SLEAP, and keep one instance a track."
            )
        if before is None or row["instance_type"] == _USER:
            chosen[at] = row
    if stray:
        warnings.warn(
            f"{where}: {stray} instances belong to no track and are left out; assign them in "
            "SLEAP to keep them.",
            InputWarning,
            stacklevel=4,
        )
    return chosen


def _positions(own: np.ndarray, version: float) -> np.ndarray:
    """Return the places of the points of an instance, NaN where they are not visible."""
    uv = np.stack([own["x"], own["y"]], axis=-1).astype(float)
    uv[~own["visible"].astype(bool)] = np.nan
    return uv if version >= _CENTRED else uv - 0.5


def _skeleton(file: h5py.File, where: str) -> tuple[list[str], float]:
    """Return the names of the nodes in their order, and the version of the file."""
    group = file.get("metadata")
    if not isinstance(group, h5py.Group):
        raise InputError(f"{where}: no metadata; expected {_EXPECTED}.")
    version = float(group.attrs["format_id"]) if "format_id" in group.attrs else _CENTRED
    if not version < _NEWEST:
        raise InputError(
            f"{where}: version {version:g} of SLEAP's format, newer than is read here; export the "
            "analysis .h5."
        )
    said = _from_json(read_attribute(group, "json", where=where), where)
    try:
        nodes = [str(node["name"]) for node in said["nodes"]]
        own = said["skeletons"][-1]["nodes"]
        return [nodes[int(node["id"])] for node in own], version
    except (KeyError, TypeError, IndexError, ValueError):
        raise InputError(f"{where}: damaged, it does not name the nodes of its skeleton.") from None


def _track_name(text: str, where: str) -> str:
    """Return the name of a track."""
    said = _from_json(text, where)
    if isinstance(said, list) and len(said) == 2:
        return str(said[1])
    raise InputError(f"{where}: damaged, {text[:40]!r} is no track.")


def _check_one(table: np.ndarray, field: str, what: str, where: str) -> None:
    """Refuse a file of several videos or skeletons."""
    found = np.unique(table[field])
    if len(found) > 1:
        raise InputError(
            f"{where}: labels of {len(found)} {what}; export the analysis .h5 of each video."
        )


def _from_json(text: str | bytes, where: str) -> Any:
    """Return what a text in JSON says."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"{where}: damaged, a part of it is no JSON; copy it again.") from None
