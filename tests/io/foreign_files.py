"""Small files in other programs' layouts, written without those programs.

Every writer takes the numbers of the frames that get a row. Point k of frame i is at
u = 100 + 10 k + i, v = 50 + k + i / 4 (in space the same, and z = i / 2), so that a point tells
which frame it came from.
"""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import h5py
import numpy as np
import xarray as xr

POINTS = ("FR", "HR")
FPS = 100.0


def place(frame, k, axis):
    """Return one coordinate of point k in a frame."""
    return (100.0 + 10 * k + frame, 50.0 + k + frame / 4, frame / 2)["xyz".index(axis)]


def write_dlc_csv(path: Path, frames) -> Path:
    names = [(p, c) for p in POINTS for c in ("x", "y", "likelihood")]
    rows = [
        ["scorer"] + ["net"] * len(names),
        ["bodyparts"] + [p for p, _ in names],
        ["coords"] + [c for _, c in names],
    ]
    for i in frames:
        rows.append([i] + [v for k in range(2) for v in (place(i, k, "x"), place(i, k, "y"), 0.9)])
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    return path


def write_dlc_h5(path: Path, frames, *, attributes=None) -> Path:
    """The "table" layout of pandas: names of columns are pickles in attributes.

    ``attributes`` replaces attributes of the group or the table by other bytes.
    """
    columns = [("net", p, c) for p in POINTS for c in ("x", "y", "likelihood")]
    table = np.zeros(len(frames), dtype=[("index", "<i8"), ("values_block_0", "<f8", (6,))])
    table["index"] = list(frames)
    for k in range(2):
        for j, axis in enumerate("xy"):
            table["values_block_0"][:, 3 * k + j] = [place(i, k, axis) for i in frames]
        table["values_block_0"][:, 3 * k + 2] = 0.9
    own = {
        "pandas_type": b"frame_table",
        "non_index_axes": pickle.dumps([(1, columns)], protocol=0),
        "values_cols": pickle.dumps(["values_block_0"], protocol=0),
        "info": pickle.dumps({1: {"names": ["scorer", "bodyparts", "coords"]}}, protocol=0),
        "encoding": b"UTF-8",
        "values_block_0_kind": pickle.dumps(columns, protocol=0),
    } | (attributes or {})
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.create_dataset("table", data=table)
        for name, value in own.items():
            item = group["table"] if name.startswith("values_block") else group
            item.attrs[name] = np.bytes_(value)
    return path


def write_slp(path: Path, frames) -> Path:
    frames = list(frames)
    n = len(frames)
    of_frames = np.zeros(n, [("frame_id", "<u8"), ("video", "<u4"), ("frame_idx", "<u8"),
                             ("instance_id_start", "<u8"), ("instance_id_end", "<u8")])  # fmt: skip
    of_frames["frame_id"], of_frames["frame_idx"] = np.arange(n), frames
    instances = np.zeros(n, [("instance_id", "<i8"), ("instance_type", "u1"), ("frame_id", "<u8"),
                             ("skeleton", "<u4"), ("track", "<i4"), ("from_predicted", "<i8"),
                             ("score", "<f4"), ("point_id_start", "<u8"),
                             ("point_id_end", "<u8"), ("tracking_score", "<f4")])  # fmt: skip
    instances["instance_type"] = 1
    instances["frame_id"] = np.arange(n)
    instances["point_id_start"], instances["point_id_end"] = 2 * np.arange(n), 2 * np.arange(n) + 2
    kinds = [("x", "<f8"), ("y", "<f8"), ("visible", "?"), ("complete", "?")]
    points = np.zeros(2 * n, [*kinds, ("score", "<f8")])
    for j, i in enumerate(frames):
        for k in range(2):
            points[2 * j + k] = (place(i, k, "x"), place(i, k, "y"), True, False, 0.9)
    said = {"nodes": [{"name": p} for p in POINTS],
            "skeletons": [{"nodes": [{"id": 0}, {"id": 1}]}]}  # fmt: skip
    with h5py.File(path, "w") as file:
        metadata = file.create_group("metadata")
        metadata.attrs["format_id"] = 1.3
        metadata.attrs["json"] = np.bytes_(json.dumps(said).encode())
        file["tracks_json"] = np.array([b'[0, "mouse"]'])
        file["frames"], file["instances"], file["pred_points"] = of_frames, instances, points
        file["points"] = np.zeros(0, kinds)
    return path


def write_analysis_h5(path: Path, frames) -> Path:
    n = max(frames) + 1
    tracks = np.full((1, 2, 2, n), np.nan)
    for i in frames:
        for k in range(2):
            tracks[0, :, k, i] = place(i, k, "x"), place(i, k, "y")
    with h5py.File(path, "w") as file:
        file["tracks"] = tracks
        file["point_scores"] = np.full((1, 2, n), 0.9)
        file["node_names"] = np.array([p.encode() for p in POINTS])
        file["track_names"] = np.array([b"mouse"])
    return path


def _write_wide(path: Path, frames, frame_name, endings, more=()) -> Path:
    names = [f"{p}{e}" for p in POINTS for e in (*endings, *more)]
    rows = [",".join([frame_name, *names])]
    for i in frames:
        row = [v for k in range(2) for v in (
            *(place(i, k, e[-1].lower()) for e in endings), *(0.9 for _ in more))]  # fmt: skip
        rows.append(",".join(map(str, [i, *row])))
    path.write_text("\n".join(rows) + "\n")
    return path


def write_anipose(path: Path, frames) -> Path:
    return _write_wide(path, frames, "fnum", ("_x", "_y", "_z"), ("_error", "_ncams", "_score"))


def write_wide(path: Path, frames) -> Path:
    return _write_wide(path, frames, "frame", ("_x", "_y"))


def write_dltdv_space(path: Path, frames) -> Path:
    return _write_wide(path, frames, "frame0", ("_X", "_Y", "_Z"))


def write_dltdv_views(path: Path, frames) -> Path:
    return _write_wide(path, frames, "frame0", ("_cam1_X", "_cam1_Y", "_cam2_X", "_cam2_Y"))


def write_tracks_csv(path: Path, frames) -> Path:
    rows = ["frame,view,point,u,v,confidence,origin"]
    rows += [
        f"{i},cam1,{p},{place(i, k, 'x')},{place(i, k, 'y')},0.9,measured"
        for i in frames
        for k, p in enumerate(POINTS)
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def write_points3d_csv(path: Path, frames) -> Path:
    rows = ["frame,point,x,y,z,residual_px,origin"]
    rows += [
        ",".join(map(str, [i, p, *(place(i, k, a) for a in "xyz"), 0.5, "measured"]))
        for i in frames
        for k, p in enumerate(POINTS)
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def write_movement(path: Path, frames) -> Path:
    frames = list(frames)
    position = np.array(
        [[[[place(i, k, a)] for k in range(2)] for a in "xy"] for i in frames], dtype=float
    )
    xr.Dataset(
        {"position": (("time", "space", "keypoints", "individuals"), position)},
        coords={"time": np.array(frames) / FPS, "space": ["x", "y"], "keypoints": list(POINTS),
                "individuals": ["id_0"]},
        attrs={"ds_type": "poses", "fps": FPS, "time_unit": "seconds"},
    ).to_netcdf(path, engine="h5netcdf")  # fmt: skip
    return path


WRITERS = {
    "deeplabcut csv": ("clipDLC.csv", write_dlc_csv),
    "deeplabcut h5": ("clipDLC.h5", write_dlc_h5),
    "sleap slp": ("clip.slp", write_slp),
    "anipose": ("clip.csv", write_anipose),
    "wide table": ("points.csv", write_wide),
    "dltdv space": ("clip_xyzpts.csv", write_dltdv_space),
    "dltdv views": ("clip_xypts.csv", write_dltdv_views),
    "tracks.csv": ("tracks.csv", write_tracks_csv),
    "points3d.csv": ("points3d.csv", write_points3d_csv),
    "movement": ("clip.nc", write_movement),
}
"""Formats whose rows say which frame they are of."""
