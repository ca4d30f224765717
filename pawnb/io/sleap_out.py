"""Tracks for SLEAP: analysis ``.h5`` and ``.csv``, and through sleap-io the labels ``.slp``."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.files import whole_file, write_whole
from pawnb.io.extras import need
from pawnb.io.outgoing import Outgoing, take_view, word
from pawnb.io.sleap import INSTANCE_SCORE, VIDEO_AND_EDGES
from pawnb.io.tables import write_text
from pawnb.schema import Tracks
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def write_sleap(tracks: Tracks, path: str | Path, *, view: str = "") -> Path:
    """Write tracks for SLEAP, one of its tracks an animal.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with points in pictures.
    path : str or Path
        ``.h5`` (analysis export) or ``.csv``: by pawnb alone; ``.slp`` (labels): through sleap-io,
        which ``pip install pawnb[sleap]`` brings.
    view : str
        The view, where there are several.

    Returns
    -------
    Path
        The file. The analysis export has a row for every frame from 0 on.

    Raises
    ------
    InputError
        If there are no points in pictures, or sleap-io is needed and not there.

    Examples
    --------
    >>> path = pawnb.io.write_sleap(tracks, "clip.analysis.h5")
    >>> pawnb.io.read_sleap(path, fps=200.0).sizes["keypoint"] == tracks.sizes["keypoint"]
    True
    """
    path = Path(path)
    own = take_view(tracks, view)
    if path.suffix == ".slp":
        return _write_labels(own, path)
    if path.suffix == ".csv":
        return _write_csv(own, path)
    return write_whole(path, _analysis_bytes(own))


def _video_and_edges(own: Outgoing) -> tuple[str, list[list[str]]]:
    """Return the film, and the edges of the skeleton, of the file that tracks came from."""
    said = json.loads(own.attrs.get(VIDEO_AND_EDGES, "{}"))
    edges = [edge for edge in said.get("edges", []) if {*edge} <= {*own.points}]
    return str(said.get("video") or ""), edges


def _instance_scores(own: Outgoing) -> FloatArray:
    """Return scores (n_frames, n_individuals) of instances; NaN where they are not known."""
    if INSTANCE_SCORE in own.tracks:
        scores = own.tracks[INSTANCE_SCORE].transpose("time", "individual").to_numpy()
        return np.asarray(scores, dtype=float)
    return np.full((len(own.frames), len(own.individuals)), np.nan)


def _write_csv(own: Outgoing, path: Path) -> Path:
    """Write a row for each frame and animal that has a point."""
    scores = _instance_scores(own)
    names = [f"{point}.{part}" for point in own.points for part in ("x", "y", "score")]
    rows = [",".join(["track", "frame_idx", "instance.score", *map(_cell, names)])]
    seen = np.isfinite(own.place).all(axis=-1).any(axis=1)
    for t, frame in enumerate(own.frames):
        for k, who in enumerate(own.individuals):
            if not seen[t, k]:
                continue
            parts = np.column_stack([own.place[t, :, k], own.confidence[t, :, k]]).ravel()
            cells = [_cell(who), str(int(frame)), word(scores[t, k]), *map(word, parts)]
            rows.append(",".join(cells))
    return write_text("\n".join(rows) + "\n", path)


def _cell(name: str) -> str:
    """Return a name as a cell of a csv."""
    return f'"{name}"' if "," in name else name


def _analysis_bytes(own: Outgoing) -> bytes:
    """Return SLEAP's analysis export: arrays in the order of MATLAB, which the file says."""
    place = own.whole(own.place).transpose(2, 3, 1, 0)
    confidence = own.whole(own.confidence).transpose(2, 1, 0)
    scores = own.whole(_instance_scores(own)).T
    occupied = np.any(np.isfinite(place).all(axis=1), axis=1).T.astype(np.uint8)
    data: dict[str, tuple[np.ndarray, list[str]]] = {
        "tracks": (place, ["track", "xy", "node", "frame"]),
        "track_occupancy": (occupied, ["frame", "track"]),
        "point_scores": (confidence, ["track", "node", "frame"]),
        "instance_scores": (scores, ["track", "frame"]),
        "tracking_scores": (np.full_like(scores, np.nan), ["track", "frame"]),
    }
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        for name, (values, dims) in data.items():
            item = file.create_dataset(name, data=values, compression="gzip", track_times=False)
            item.attrs["dims"] = json.dumps(dims)
        for name, words in (("node_names", own.points), ("track_names", own.individuals)):
            file.create_dataset(name, data=np.array([w.encode() for w in words]), track_times=False)
        video, edges = _video_and_edges(own)
        named = np.array([[word.encode() for word in edge] for edge in edges], dtype="S")
        file["edge_names"] = named.reshape(-1, 2)
        file["edge_inds"] = np.array(
            [[own.points.index(word) for word in edge] for edge in edges], dtype=int
        ).reshape(-1, 2)
        file["labels_path"], file["video_path"] = "", video
        file["provenance"], file["video_ind"] = "{}", 0
        file.attrs["format"], file.attrs["preset"] = "analysis", "matlab"
    return buffer.getvalue()


def _write_labels(own: Outgoing, path: Path) -> Path:
    """Write predicted instances by sleap-io."""
    sio: Any = need("sleap_io", "sleap", what=f"to write {path.name}")
    name, edges = _video_and_edges(own)
    skeleton = sio.Skeleton(nodes=list(own.points), edges=edges)
    animals = [sio.Track(name=who) for who in own.individuals]
    video = sio.Video(filename=name or "video.mp4", open_backend=False)
    scores = _instance_scores(own)
    labelled = []
    for t, frame in enumerate(own.frames):
        found = []
        for k, animal in enumerate(animals):
            if not np.isfinite(own.place[t, :, k]).any():
                continue
            found.append(
                sio.PredictedInstance.from_numpy(
                    own.place[t, :, k],
                    skeleton=skeleton,
                    point_scores=own.confidence[t, :, k],
                    score=float(np.nan_to_num(scores[t, k])),
                    track=animal,
                )
            )
        if found:
            labelled.append(sio.LabeledFrame(video=video, frame_idx=int(frame), instances=found))
    if not labelled:
        raise InputError(f"{path.name}: no point in any frame; SLEAP keeps only frames with some.")
    labels = sio.Labels(
        labeled_frames=labelled, videos=[video], skeletons=[skeleton], tracks=animals
    )
    with whole_file(path) as part:
        sio.save_slp(labels, str(part), embed=False, verbose=False)
    return path
