"""Every format, both ways, by the libraries of the programs themselves where they are installed.

    python benchmarks/formats.py

One recording of two animals, four points and 60 frames is drawn from formulas, with a gap. Each row
says how far, at most, a coordinate is off: *read* is what pawnb reads of a file that the other
library wrote, *write* what the other library reads of a file that pawnb wrote. Where no library of
the program is at hand, pawnb reads what it wrote itself (own), a file made after the program's
description (described) or as its public source code writes it (source), or files that its authors
published (their files, in the folder $PAWNB_TEST_DATA); which is marked. In px, or mm in space; 0
is exact, 1e-5 is single precision. ``--out docs/accuracy/formats.csv`` writes the
table that docs/guide/formats.md shows.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy.io
import xarray as xr
from format_cameras import aniposelib, coefficients, opencv, pose2sim, xmalab
from format_recording import ANIMALS, FPS, POINTS, N, off, places, recording, tracks_of
from format_sources import (
    argus,
    authors2019,
    authors2019_files,
    dltdv7,
    own,
    xmalab_markers,
    xmalab_points,
)

from pawnb.io.formats import read_any_tracks, write_any_tracks


def need(*names: str) -> list[Any]:
    """Import libraries; raises ModuleNotFoundError where one is not installed."""
    return [importlib.import_module(name) for name in names]


# --- DeepLabCut, by pandas ------------------------------------------------------------------------


def dlc_frame(place: np.ndarray, scorer: str = "net") -> pd.DataFrame:
    """Return a recording as the DataFrame of DeepLabCut."""
    several = place.shape[2] > 1
    who = ANIMALS[: place.shape[2]] if several else [None]
    columns, values = [], []
    for i, one in enumerate(who):
        for k, point in enumerate(POINTS):
            for c, coord in enumerate(("x", "y", "likelihood")):
                columns.append((scorer, *([one] if several else []), point, coord))
                values.append(place[:, k, i, c] if c < 2 else np.full(N, 0.9))
    names = ["scorer", *(["individuals"] if several else []), "bodyparts", "coords"]
    index = pd.MultiIndex.from_tuples(columns, names=names)
    return pd.DataFrame(np.stack(values, axis=1), columns=index)


def of_frame(frame: pd.DataFrame, n_animals: int) -> np.ndarray:
    """Return the positions in a DataFrame of DeepLabCut."""
    values = frame.to_numpy().reshape(N, n_animals, 4, 3)[..., :2]
    return values.transpose(0, 2, 1, 3)


def deeplabcut(folder: Path, ending: str, n_animals: int) -> tuple[str, str]:
    """By pandas, as DeepLabCut reads and writes."""
    true = recording(n_animals)
    path = folder / f"theirs{ending}"
    if ending == ".h5":
        need("tables")
        dlc_frame(true).to_hdf(path, key="df_with_missing", format="table", mode="w")
    else:
        dlc_frame(true).to_csv(path)
    read = off(places(read_any_tracks(path, fps=FPS)), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / f"ours{ending}", program="deeplabcut")
    levels = list(range(3 + (n_animals > 1)))
    frame = pd.read_hdf(ours) if ending == ".h5" else pd.read_csv(ours, header=levels, index_col=0)
    return read, off(of_frame(frame, n_animals), true)


def collected(folder: Path, ending: str) -> tuple[str, str]:
    """By pandas, rows named by pictures."""
    true = recording(1)
    frame = dlc_frame(true, "me").drop(columns="likelihood", level="coords")
    names = [("labeled-data", "clip", f"img{i:03d}.png") for i in range(N)]
    frame.index = pd.MultiIndex.from_tuples(names)
    path = folder / f"CollectedData_me{ending}"
    if ending == ".h5":
        need("tables")
        frame.to_hdf(path, key="df_with_missing", mode="w")
    else:
        frame.to_csv(path)
    tracks = read_any_tracks(path, fps=FPS)
    read = off(places(tracks), true)
    (folder / "ours").mkdir(exist_ok=True)
    (ours,) = write_any_tracks(tracks, folder / "ours" / path.name)
    again = (
        pd.read_hdf(ours)
        if ending == ".h5"
        else pd.read_csv(ours, header=[0, 1, 2], index_col=[0, 1, 2])
    )
    values = again.to_numpy().reshape(N, 4, 1, 2)
    return read, off(values, true) if list(again.index) == names else "names lost"


def lightning_pose(folder: Path) -> tuple[str, str]:
    """By movement's reader of Lightning Pose."""
    true = recording(1)
    (load,) = need("movement.io.load_poses")
    path = folder / "theirs.csv"
    dlc_frame(true, "heatmap_tracker").to_csv(path)
    read = off(places(read_any_tracks(path, fps=FPS)), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / "lp.csv", program="lightning-pose")
    return read, off(of_movement(load.from_lp_file(ours, fps=FPS)), true)


# --- SLEAP, movement, NWB, Anipose, C3D -----------------------------------------------------------


def sleap(folder: Path, ending: str) -> tuple[str, str]:
    """By sleap-io."""
    true = recording()
    (sio,) = need("sleap_io")
    skeleton = sio.Skeleton(nodes=list(POINTS))
    animals = [sio.Track(name=who) for who in ANIMALS]
    video = sio.Video(filename="clip.mp4", open_backend=False)
    frames = [
        sio.LabeledFrame(
            video=video, frame_idx=t,
            instances=[
                sio.PredictedInstance.from_numpy(
                    true[t, :, k], skeleton=skeleton, point_scores=np.full(4, 0.9), score=0.9,
                    track=animals[k],
                )
                for k in range(2)
            ],
        )
        for t in range(N)
    ]  # fmt: skip
    labels = sio.Labels(frames, videos=[video], skeletons=[skeleton], tracks=animals)
    path = folder / f"theirs{ending}"
    if ending == ".slp":
        sio.save_slp(labels, str(path), verbose=False)
    elif ending == ".csv":
        sio.save_csv(labels, str(path), format="sleap")
    else:
        sio.save_analysis_h5(labels, str(path))
    read = off(places(read_any_tracks(path, fps=FPS)), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / f"ours{ending}", program="sleap")
    found = sio.load_csv(str(ours)) if ending == ".csv" else sio.load_file(str(ours))
    order = [[node.name for node in found.skeleton.nodes].index(point) for point in POINTS]
    return read, off(found.numpy()[:, :, order].transpose(0, 2, 1, 3), true)


def of_movement(dataset: xr.Dataset) -> np.ndarray:
    """Return the positions in a dataset of movement."""
    own = dataset["position"].sel(keypoints=POINTS)
    return own.transpose("time", "keypoints", "individuals", "space").to_numpy()


def movement(folder: Path) -> tuple[str, str]:
    """By movement, and through its exporter to DeepLabCut."""
    true = recording()
    load, save = need("movement.io.load_poses", "movement.io.save_poses")
    theirs = load.from_numpy(
        true.transpose(0, 3, 1, 2), np.full((N, 4, 2), 0.9), individual_names=ANIMALS,
        keypoint_names=POINTS, fps=FPS, source_software="benchmark",
    )  # fmt: skip
    theirs.to_netcdf(folder / "theirs.nc", engine="h5netcdf")
    read = off(places(read_any_tracks(folder / "theirs.nc")), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / "ours.nc", program="movement")
    dataset = xr.load_dataset(ours, engine="h5netcdf")
    save.to_dlc_file(dataset, folder / "through.csv", split_individuals=False)
    again = load.from_dlc_file(folder / "through.csv", fps=FPS)
    return read, off(of_movement(again), true)


def nwb(folder: Path) -> tuple[str, str]:
    """By movement's exporter to pynwb and ndx-pose, and its reader."""
    true = recording(1)
    load, save, pynwb = need("movement.io.load_poses", "movement.io.save_poses", "pynwb")
    theirs = load.from_numpy(
        true.transpose(0, 3, 1, 2), np.full((N, 4, 1), 0.9), individual_names=["m1"],
        keypoint_names=POINTS, fps=FPS, source_software="benchmark",
    )  # fmt: skip
    with pynwb.NWBHDF5IO(str(folder / "theirs.nwb"), "w") as io:
        io.write(save.to_nwb_file(theirs))
    read = off(places(read_any_tracks(folder / "theirs.nwb")), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / "ours.nwb")
    return read, off(of_movement(load.from_nwb_file(str(ours))), true)


def anipose(folder: Path) -> tuple[str, str]:
    """By movement's reader of Anipose; it writes none, so that pawnb reads its own."""
    true = recording(1, space=True)
    (load,) = need("movement.io.load_poses")
    (ours,) = write_any_tracks(tracks_of(true), folder / "ours.csv", program="anipose")
    read = off(places(read_any_tracks(ours, fps=FPS)), true)
    return f"{read} (own)", off(of_movement(load.from_anipose_file(ours, fps=FPS)), true)


def c3d(folder: Path) -> tuple[str, str]:
    """By ezc3d; pawnb itself goes through the library c3d."""
    true = recording(1, space=True)
    ezc3d, _ = need("ezc3d", "c3d")
    theirs = ezc3d.c3d()
    for name, value in (("LABELS", POINTS), ("RATE", [FPS]), ("UNITS", ["mm"])):
        theirs["parameters"]["POINT"][name]["value"] = value
    theirs["data"]["points"] = np.concatenate(
        [true[:, :, 0].transpose(2, 1, 0), np.ones((1, 4, N))], axis=0
    )
    theirs.write(str(folder / "theirs.c3d"))
    read = off(places(read_any_tracks(folder / "theirs.c3d")), true)
    (ours,) = write_any_tracks(tracks_of(true), folder / "ours.c3d")
    found = ezc3d.c3d(str(ours))["data"]["points"][:3].transpose(2, 1, 0)[:, :, None]
    return read, off(found, true)


# --- LocoMouse ------------------------------------------------------------------------------------


def locomouse(folder: Path) -> tuple[str, str]:
    """By scipy, as MATLAB writes them: pixels from 1, bottom and side view share x."""
    true = recording(1)[:, :, 0]  # HR is lost for a while
    points = true[:, [POINTS.index(name) for name in ("FR", "HR", "FL", "HL")]]
    side = points[..., 1] - 150.0
    xyz = np.stack([points[..., 0], points[..., 1], side]) + 1.0
    snout = np.full((3, N, 1), 50.0)
    scipy.io.savemat(
        folder / "clip.mat",
        {"final_tracks": np.concatenate([xyz, snout], axis=2).transpose(0, 2, 1)},
    )
    tracks = read_any_tracks(folder / "clip.mat", fps=FPS)
    bottom = tracks["image_position"].sel(view="bottom", keypoint=POINTS).isel(individual=0)
    read = off(bottom.transpose("time", "keypoint", "image_space").to_numpy(), true)
    (ours,) = write_any_tracks(tracks, folder / "ours.mat")
    again = scipy.io.loadmat(ours)["final_tracks"][:2, :4].transpose(2, 1, 0) - 1.0
    return read, off(again[:, [("FR", "HR", "FL", "HL").index(p) for p in POINTS]], true)


ROWS: list[tuple[str, str, Callable[[Path], tuple[str, str]]]] = [
    ("DeepLabCut csv", "pandas", lambda f: deeplabcut(f, ".csv", 1)),
    ("DeepLabCut h5", "pandas, PyTables", lambda f: deeplabcut(f, ".h5", 1)),
    ("DeepLabCut csv, 2 animals", "pandas", lambda f: deeplabcut(f, ".csv", 2)),
    ("DeepLabCut h5, 2 animals", "pandas, PyTables", lambda f: deeplabcut(f, ".h5", 2)),
    ("CollectedData csv", "pandas", lambda f: collected(f, ".csv")),
    ("CollectedData h5", "pandas, PyTables", lambda f: collected(f, ".h5")),
    ("Lightning Pose csv", "movement", lightning_pose),
    ("SLEAP slp", "sleap-io", lambda f: sleap(f, ".slp")),
    ("SLEAP analysis h5", "sleap-io", lambda f: sleap(f, ".h5")),
    ("SLEAP csv", "sleap-io", lambda f: sleap(f, ".csv")),
    ("movement netCDF", "movement", movement),
    ("NWB ndx-pose", "movement, pynwb", nwb),
    ("Anipose 3D csv", "movement", anipose),
    ("C3D", "ezc3d", c3d),
    ("DLTdv 7 xypts", "DLTdv 7, Octave", lambda f: dltdv7(f, ".csv")),
    ("DLTdv 7, 8 xypts sparse", "DLTdv 7, Octave", lambda f: dltdv7(f, ".tsv")),
    ("DLTdv 7, 8 xyzpts", "DLTdv 7, Octave", lambda f: dltdv7(f, ".csv", space=True)),
    ("DLTdv 7, 8 xyzpts sparse", "DLTdv 7, Octave", lambda f: dltdv7(f, ".tsv", space=True)),
    ("DLTdv 8 xypts", "none", lambda f: own(f, "dltdv", "a_xypts.csv")),
    ("XMALab 2D points csv", "none", xmalab_points),
    ("XMALab 3D points csv", "none", xmalab_markers),
    ("Argus xypts", "Argus", argus),
    ("Argus xyzpts", "Argus", lambda f: argus(f, space=True)),
    ("LocoMouse mat", "scipy", locomouse),
    ("2019 authors' csv", "none", authors2019),
    ("2019 authors' trials", "none", authors2019_files),
    ("Anipose calibration.toml", "aniposelib", aniposelib),
    ("OpenCV yaml", "OpenCV", opencv),
    ("Pose2Sim toml", "Pose2Sim", pose2sim),
    ("XMALab MayaCam txt", "OpenCV", xmalab),
    (
        "XMALab DLT csv",
        "OpenCV",
        lambda f: coefficients(f, "xmalab", digits=12, known_from="source"),
    ),
    (
        "DLTdv 8 DLTcoefs",
        "OpenCV",
        lambda f: coefficients(f, "dltdv", digits=5, known_from="source"),
    ),
    ("easyWand, DLTdv 7 DLTcoefs", "OpenCV", lambda f: coefficients(f, "easywand")),
    ("Argus DLTcoefs", "Argus", lambda f: coefficients(f, "argus", known_from="")),
]


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", help="rows whose name has this word")
    parser.add_argument("--out", type=Path, help="csv to write the table to, too")
    asked = parser.parse_args()
    only = (asked.only or "").lower()
    warnings.simplefilter("ignore")
    rows = []
    print(f"{'format':28}{'library':20}{'read':>18}{'write':>12}   largest error, px or mm")
    for name, library, check in ROWS:
        if only not in name.lower():
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                read, write = check(Path(folder))
            except ModuleNotFoundError as error:
                read = write = f"no {error.name}"
        print(f"{name:28}{library:20}{read:>18}{write:>12}", flush=True)
        rows.append((name, library, read, write))
    if asked.out is not None:
        table = pd.DataFrame(rows, columns=["format", "library", "read", "written"])
        table.to_csv(asked.out, index=False, lineterminator="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
