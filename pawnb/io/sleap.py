"""Tracks of SLEAP: the analysis ``.h5`` or ``.csv``, or the labels ``.slp``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.io.hdf5 import open_hdf5, read_array, read_attribute, read_texts
from pawnb.io.points import build_tracks
from pawnb.io.tables import read_cells, read_numbers
from pawnb.schema import Tracks, check_frames
from pawnb.schema.arguments import checked_arguments

INSTANCE_SCORE = "instance_score"
"""Variable of Tracks (time, individual): SLEAP's score of an instance as a whole."""

VIDEO_AND_EDGES = "sleap_labels"
"""Attribute of Tracks of a ``.slp`` or analysis ``.h5``: a JSON of its ``video`` and of the
``edges`` of its skeleton."""

_EXPECTED = "the .slp or analysis .h5 that SLEAP writes"
_ORDER = ("track", "xy", "node", "frame")
"""Order of the dimensions of ``tracks`` where the file does not say."""

_VIDEO = "video_path"
"""Column of sleap-io's csv of instances where the labels are of several videos."""

_FRAMES_WITHOUT_ROW = 20
"""From so many on, a csv of sleap-io may go on in another video. Set by hand: an animal that left
the picture has no rows either, so it is said and not refused."""

_ONE = "id_0"
_USER, _PREDICTED = 0, 1
_CENTRED = 1.1
"""Since this version of .slp (0, 0) is the centre of a pixel; before, it was its corner."""

_NEWEST = 3.0


@checked_arguments
def read_sleap(path: str | Path, *, fps: float) -> Tracks:
    """Read tracks of SLEAP.

    Parameters
    ----------
    path : str or Path
        Predictions as ``.slp``, or SLEAP's analysis export, ``.h5`` or ``.csv``.
    fps : float
        Frames per second of the recording.

    Returns
    -------
    xarray.Dataset
        Tracks in px with one individual for each of SLEAP's tracks, confidence is the point's
        score (NaN where a person put it). Pixels are taken as they are; those of ``.slp`` files
        before version 1.1, counted from the corner of the first pixel, are moved by half a pixel.
        Scores of whole instances are kept as ``instance_score`` (time, individual).
        Of a person's and a predicted instance of one track, the person's is taken. Frames
        without a label are missing, and the provenance says which they are.

    Raises
    ------
    InputError
        If the file is missing, damaged or not of SLEAP, holds several videos or skeletons, has a
        frame twice, or several animals that no track tells apart.

    Warns
    -----
    InputWarning
        If instances belong to no track, or a csv of sleap-io may be of several videos.

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
    kept: dict[str, str] = {}
    if path.suffix == ".csv":
        found = _read_table(path)
    else:
        with open_hdf5(path, expected=_EXPECTED) as file:
            labels = "instances" in file
            found = (_read_labels if labels else _read_analysis)(file, path.name)
            said = _video_and_edges(file, path.name) if labels else _of_analysis(file)
            kept = {VIDEO_AND_EDGES: json.dumps(said)}
    frames, points, individuals, places, score, whole = found
    tracks = build_tracks(
        frames,
        places,
        score,
        points=points,
        fps=fps,
        unit="px",
        program="SLEAP",
        where=path.name,
        individuals=individuals or [_ONE],
    ).assign_attrs(kept)
    if not np.isfinite(whole).any():
        return tracks
    scores = np.full((tracks.sizes["time"], tracks.sizes["individual"]), np.nan)
    scores[np.searchsorted(tracks["frame"].to_numpy(), frames)] = whole
    return tracks.assign({INSTANCE_SCORE: (("time", "individual"), scores)})


_Read = tuple[np.ndarray, list[str], list[str], np.ndarray, np.ndarray, np.ndarray]
"""Frames, points, animals, places, scores of points, scores of instances."""


def _read_table(path: Path) -> _Read:
    """Read the analysis export as csv: a row for each frame and instance."""
    where = path.name
    cells = read_cells(path, ("track", "frame_idx"))
    names = [str(name) for name in cells]
    points = [name.removesuffix(".x") for name in names if name.endswith(".x")]
    missing = [f"{p}.{axis}" for p in points for axis in "xy" if f"{p}.{axis}" not in names]
    if missing or not points or cells.empty:
        what = f"column {missing[0]} is missing" if missing else "no point, or no row"
        raise InputError(f"{where}: {what}; SLEAP writes <node>.x, <node>.y and <node>.score.")
    videos = list(dict.fromkeys(cells[_VIDEO])) if _VIDEO in names else []
    if len(videos) > 1:
        raise InputError(
            f"{where}: rows of {len(videos)} videos, {', '.join(map(str, videos[:3]))}"
            f"{' ...' * (len(videos) > 3)}, whose frames are numbered alike; export a file of each "
            "video."
        )
    at = read_numbers(cells, "frame_idx", where=where, whole=True)
    if (np.diff(at) < 0).any():
        raise InputError(
            f"{where}: frames do not rise; sort the rows by frame_idx, or export a file of each "
            "video where these are of several."
        )
    frames, row = np.unique(at, return_inverse=True)
    if f"{points[0]}.score" in names[: names.index(f"{points[0]}.x")]:  # in alphabetical order
        _tell_other_video(frames, where)
    individuals = sorted(set(cells["track"])) if (cells["track"] != "").any() else []
    if "" in individuals:
        raise InputError(f"{where}: some rows have a track and some have none; name all of them.")
    who = cells["track"].map({name: k for k, name in enumerate(individuals)} or {"": 0}).to_numpy()
    twice = cells.duplicated(["frame_idx", "track"])
    if twice.any():
        raise InputError(
            f"{where}: frame {at[twice.to_numpy()][0]} has two instances of one track, or of none; "
            "tell the animals apart by tracks in SLEAP."
        )

    def column(name: str) -> FloatArray:
        if name not in names:
            return np.full(len(cells), np.nan)
        return read_numbers(cells, name, where=where, empty=True)

    n = len(individuals) or 1
    parts = np.full((len(frames), len(points), n, 3), np.nan)
    for k, point in enumerate(points):
        parts[row, k, who] = np.column_stack([column(f"{point}.{p}") for p in ("x", "y", "score")])
    whole = np.full((len(frames), n), np.nan)
    whole[row, who] = column("instance.score")
    return frames, points, individuals, parts[..., :2], parts[..., 2], whole


def _tell_other_video(frames: np.ndarray, where: str) -> None:
    """Say where rows of sleap-io may go on in another video, of which its csv says nothing."""
    gaps = np.diff(frames) - 1
    if not (gaps >= _FRAMES_WITHOUT_ROW).any():
        return
    at = int(np.argmax(gaps))
    warn_of_input(
        f"{where}: no row from frame {frames[at] + 1:g} to {frames[at + 1] - 1:g}. sleap-io writes "
        "labels of several videos into one such csv without a word: where these are of several, "
        "save one of each (save_csv with video=0, 1, ...), else they count as one recording.",
        InputWarning,
        stacklevel=4,
    )


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
    whole = np.full((len(data), n_tracks), np.nan)
    if "instance_scores" in file:
        said = read_array(file, "instance_scores", where=where, ndim=2).astype(float)
        said = _ordered(
            said, file["instance_scores"], ("track", "frame"), ("frame", "track"), where
        )
        whole = said if said.shape == whole.shape else whole
    return np.arange(len(data)), points, individuals, data, score, whole


def _ordered(
    data: FloatArray,
    item: h5py.Dataset,
    order: tuple[str, ...],
    wanted: tuple[str, ...],
    where: str,
) -> FloatArray:
    """Bring dimensions into the wanted order: newer files say theirs in an attribute."""
    if "dims" in item.attrs:
        said = _from_json(read_attribute(item, "dims", where=where), where)
        if not isinstance(said, list) or sorted(map(str, said)) != sorted(wanted):
            raise InputError(f"{where}: dimensions of {item.name} are {said!r}; expected {wanted}.")
        order = tuple(said)
    return data.transpose([order.index(name) for name in wanted])


def _read_labels(file: h5py.File, where: str) -> _Read:
    """Read a .slp: tables of frames, instances and points."""
    names = read_texts(file, "tracks_json", where=where)
    individuals = [_track_name(text, where) for text in names]
    frames, instances, user, predicted = (
        read_array(file, name, where=where, ndim=1)
        for name in ("frames", "instances", "points", "pred_points")
    )
    _check_one(frames, "video", "videos; export the analysis .h5 of each video", where)
    _check_one(instances, "skeleton", "skeletons; keep those of one in SLEAP", where)
    points, version = _skeleton(file, _own_skeleton(instances), where)
    # labels are kept in the order in which they were made
    numbers = check_frames(np.sort(frames["frame_idx"]), where=where)
    of_frame = dict(zip(frames["frame_id"].tolist(), frames["frame_idx"].tolist(), strict=True))
    shape = (len(numbers), len(points), len(individuals) or 1)
    places, score = np.full((*shape, 2), np.nan), np.full(shape, np.nan)
    whole = np.full((shape[0], shape[2]), np.nan)
    for (frame_id, track), row in _chosen(instances, individuals, of_frame, where).items():
        table = predicted if row["instance_type"] == _PREDICTED else user
        own = table[int(row["point_id_start"]) : int(row["point_id_end"])]
        if len(own) != len(points):
            raise InputError(
                f"{where}: damaged, an instance has {len(own)} points; expected {len(points)}."
            )
        at = np.searchsorted(numbers, of_frame[frame_id])
        places[at, :, track] = _positions(own, version)
        if row["instance_type"] == _PREDICTED:
            score[at, :, track], whole[at, track] = own["score"], row["score"]
    return numbers, points, individuals, places, score, whole


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
        warn_of_input(
            f"{where}: {stray} instances belong to no track and are left out; assign them in "
            "SLEAP to keep them.",
            InputWarning,
            stacklevel=4,
        )
    return chosen


def _positions(own: np.ndarray, version: float) -> FloatArray:
    """Return the places of the points of an instance, NaN where they are not visible."""
    uv = np.stack([own["x"], own["y"]], axis=-1).astype(float)
    uv[~own["visible"].astype(bool)] = np.nan
    return uv if version >= _CENTRED else uv - 0.5


def _own_skeleton(instances: np.ndarray) -> int:
    """Return which skeleton of the file its instances are of: a project may hold others."""
    return int(instances["skeleton"][0]) if len(instances) else 0


def _skeleton(file: h5py.File, own: int, where: str) -> tuple[list[str], float]:
    """Return the names of the nodes of a skeleton in their order, and the version of the file."""
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
        listed = said["skeletons"][own]["nodes"]
        return [nodes[int(node["id"])] for node in listed], version
    except (KeyError, TypeError, IndexError, ValueError):
        raise InputError(f"{where}: damaged, it does not name the nodes of its skeleton.") from None


def _video_and_edges(file: h5py.File, where: str) -> dict[str, Any]:
    """Return what a .slp says beside tracks, for one that is written of them; nothing if damaged.

    The video is that of its labels, or no text where its pictures are in the file itself.
    """
    try:
        said = _from_json(read_attribute(file["metadata"], "json", where=where), where)
        nodes = [str(node["name"]) for node in said["nodes"]]
        skeleton = said["skeletons"][_own_skeleton(file["instances"][:])]
        links = skeleton.get("links", [])
        edges = [[nodes[int(link["source"])], nodes[int(link["target"])]] for link in links]
        videos = [_from_json(text, where) for text in read_texts(file, "videos_json", where=where)]
        own = videos[int(file["frames"]["video"][0])] if len(videos) > 1 else videos[0]
        video = str(own.get("filename") or own["backend"]["filename"])
    except (InputError, KeyError, TypeError, IndexError, ValueError, AttributeError):
        return {"video": "", "edges": []}
    return {"video": "" if video == "." else video, "edges": edges}


def _of_analysis(file: h5py.File) -> dict[str, Any]:
    """Return the video and edges that an analysis export says."""
    edges, video = file.get("edge_names"), file.get("video_path")
    known = isinstance(edges, h5py.Dataset) and edges.ndim == 2 and edges.shape[1] == 2
    video = video[()] if isinstance(video, h5py.Dataset) and video.shape == () else b""
    return {
        "video": video.decode("utf-8", "replace") if isinstance(video, bytes) else "",
        "edges": [[_word(a), _word(b)] for a, b in edges[()]] if known else [],
    }


def _word(value: Any) -> str:
    """Return a text of HDF5."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


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
        raise InputError(f"{where}: labels of {len(found)} {what}.")


def _from_json(text: str | bytes, where: str) -> Any:
    """Return what a text in JSON says."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"{where}: damaged, a part of it is no JSON; copy it again.") from None
