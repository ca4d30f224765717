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
    """
    path = Path(path)
    with open_hdf5(path, expected=_EXPECTED) as file:
        read = _read_labels if path.suffix == ".slp" else _read_analysis
        frames, points, individuals, places, score = read(file, path.name)
    return build_tracks(
        frames,
        points,
        places,
        score,
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
    expected = (len(data), len(points), len(individuals) or 1)
    if data.shape != (*expected, 2) or score.shape != expected:
        raise InputError(
            f"{where}: damaged, tracks have shape {data.shape} and scores {score.shape}; expected "
            f"{expected[1]} nodes and {expected[2]} tracks, as the file names them."
        )
    return np.arange(len(data)), points, individuals, data, score


def _ordered(
    data: np.ndarray, item: h5py.Dataset, order: tuple[str, ...], wanted: tuple[str, ...], where: str
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
    individuals = [_track_name(text, where) for text in read_texts(file, "tracks_json", where=where)]
    frames, instances, user, predicted = (
        read_array(file, name, where=where, ndim=1)
        for name in ("frames", "instances", "points", "pred_points")
    )
    _check_one(frames, "video", "videos", where)
    _check_one(instances, "skeleton", "skeletons", where)
    numbers = np.sort(frames["frame_idx"].astype(np.int64))
    check_frames(numbers, where=where)
    of_frame = dict(zip(frames["frame_id"].tolist(), frames["frame_idx"].tolist(), strict=True))
    shape = (len(numbers), len(points), len(individuals) or 1)
    places, score = np.full((*shape, 2), np.nan), np.full(shape, np.nan)
    stray = 0
    filled: dict[tuple[int, int], int] = {}
    for row in instances:
        kind, track, first = (
            int(row[name]) for name in ("instance_type", "track", "point_id_start")
        )
        table = user if kind == _USER else predicted
        own = table[first : int(row["point_id_end"])]
        if int(row["frame_id"]) not in of_frame or track >= len(individuals) or first < 0:
            raise InputError(f"{where}: damaged, an instance is of no frame or track of the file.")
        if track < 0 and individuals:
            stray += 1
            continue
        if len(own) != len(points):
            raise InputError(
                f"{where}: damaged, an instance has {len(own)} points; expected {len(points)}."
            )
        frame = of_frame[int(row["frame_id"])]
        at = (int(np.searchsorted(numbers, frame)), max(track, 0))
        before = filled.get(at)
        if before == kind:
            name = individuals[track] if individuals else "animal"
            raise InputError(
                f"{where}: frame {frame} has two instances of {name!r}; tell the animals apart by "
                "tracks in SLEAP, and keep one instance a track."
            )
        if before is not None and kind == _PREDICTED:
            continue  # a person's labels go before predicted ones
        filled[at] = kind
        places[at[0], :, at[1]] = _positions(own, version)
        score[at[0], :, at[1]] = own["score"] if kind == _PREDICTED else np.nan
    if stray:
        warnings.warn(
            f"{where}: {stray} instances belong to no track and are left out; assign them in "
            "SLEAP to keep them.",
            InputWarning,
            stacklevel=3,
        )
    return numbers, points, individuals, places, score


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
        raise InputError(
            f"{where}: damaged, it does not name the nodes of its skeleton."
        ) from None


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
