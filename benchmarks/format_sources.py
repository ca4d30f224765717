"""Formats without a library: files as their programs write them. See ``formats.py``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from format_programs import argus_reads, argus_writes, dltdv7_reads, dltdv7_writes
from format_recording import FPS, POINTS, N, off, places, recording, tracks_of

from pawnb.io.authors2019 import read_authors_trial, trial_stamp
from pawnb.io.authors2019_out import write_authors_trial
from pawnb.io.formats import read_any_tracks, write_any_tracks


def own(folder: Path, program: str, name: str, **more: Any) -> tuple[str, str]:
    """Of programs that have no library: pawnb reads what it wrote."""
    space = program.endswith("3d")
    true = recording(1, space=space)
    points = [f"pt{k + 1}" for k in range(4)] if program.startswith("dltdv") else POINTS
    tracks = tracks_of(true, views=0 if space else 2).assign_coords(keypoint=points)
    (ours,) = write_any_tracks(tracks, folder / name, program=program, **more)
    found = read_any_tracks(ours, fps=FPS, **more)
    if program.startswith("dltdv"):
        found = found.assign_coords(keypoint=POINTS)
    said = off(places(found), true)
    return f"{said} (own)", f"{said} (own)"


def authors2019(folder: Path) -> tuple[str, str]:
    """Four files in the layout of the 2019 authors: Y before X, cameras 3 and 4 mirrored."""
    true = recording(1)[:, :, 0]
    stamp, worst = "2020-01-02_03_04_05", []
    for cam, side in ((1, "L"), (3, "R")):
        for part, n in (("f", 3), ("h", 5)):
            foot = true[:, POINTS.index(f"{part.upper()}{side}")]
            u = foot[:, 0] if cam == 1 else 2047.0 - foot[:, 0]
            names = [f"cam{cam}/frame{i:05d}.png" for i in range(N)]
            columns = {"Frames": np.arange(N), "First Camera Frames Name": names,
                       "Second Camera Frames Name": names}  # fmt: skip
            for k, letter in enumerate("MNOPQ"[:n]):  # the foot is the last marker of a leg
                for second in ("", "2"):
                    still = np.full(N, 100.0)
                    columns[f"Y Coordinate {letter}{second}"] = foot[:, 1] if k == n - 1 else still
                    columns[f"X Coordinate {letter}{second}"] = u if k == n - 1 else still
            text = "setting\n" * 5 + pd.DataFrame(columns).to_csv(index=False)
            (folder / f"cam{cam}.{part}.rat.walk.{stamp}.csv").write_text(text)
    tracks = read_any_tracks(folder / f"cam1.f.rat.walk.{stamp}.csv", fps=FPS)
    views = {"L": ("cam1", "cam2"), "R": ("cam3", "cam4")}
    for k, name in enumerate(POINTS):
        for view in views[name[-1]]:
            own = tracks["image_position"].sel(view=view, keypoint=name).isel(individual=0)
            worst.append(off(own.transpose("time", "image_space").to_numpy(), true[:, k]))
    (folder / "ours").mkdir()
    write_any_tracks(tracks, folder / "ours" / f"cam1.f.rat.walk.{stamp}.csv",
                     program="authors2019")  # fmt: skip
    write = _columns_differ(folder, folder / "ours")
    return ("0" if set(worst) == {"0"} else max(worst)) + " (described)", f"{write} (described)"


def _columns_differ(theirs: Path, ours: Path) -> str:
    """Return by how much columns of coordinates of the 2019 authors differ from ours at most."""
    worst = 0.0
    for path in sorted(ours.glob("cam*.csv")):
        one, other = (pd.read_csv(folder / path.name, skiprows=5) for folder in (theirs, ours))
        if list(one) != list(other) or not one["Frames"].equals(other["Frames"]):
            return "columns lost"
        columns = [name for name in one if "Coordinate" in name]
        a, b = (table[columns].to_numpy(dtype=float) for table in (one, other))
        # where one axis is missing, the point is
        pairs = np.isnan(a).reshape(len(a), -1, 2).any(axis=2).repeat(2, axis=1)
        if not np.array_equal(np.isnan(b), pairs):
            return "gap lost"
        worst = max(worst, float(np.nanmax(np.abs(a - b))))
    return f"{worst:.1g}"


def authors2019_files(folder: Path) -> tuple[str, str]:
    """Read the trials that the 2019 authors published, against their columns, and write them.

    Their own programs take u = X, or 2048 - X of cameras 3 and 4, whose pictures they mirrored:
    2047 - X from the centre of the first pixel.
    """
    data = Path(os.environ.get("PAWNB_TEST_DATA", "-")) / "rat-4cam-tracks"
    if not data.is_dir():
        raise ModuleNotFoundError("no files of the authors", name="files")
    worst = 0.0
    for path in sorted(data.glob("cam1.f.*.csv")):
        tracks = read_any_tracks(path, fps=FPS)["image_position"].isel(individual=0)
        for cam, part, point, letter in ((1, "f", "FL", "O"), (1, "h", "HL", "Q"),
                                         (3, "f", "FR", "O"), (3, "h", "HR", "Q")):  # fmt: skip
            name = path.name.replace("cam1.f", f"cam{cam}.{part}")
            theirs = pd.read_csv(data / name, skiprows=5)
            frames = theirs["First Camera Frames Name"].str.extract(r"(\d+)\.\w+$")[0].astype(int)
            for view, second in ((f"cam{cam}", ""), (f"cam{cam + 1}", "2")):
                x, y = (theirs[f"{axis} Coordinate {letter}{second}"] for axis in "XY")
                own = tracks.sel(view=view, keypoint=point)
                own = own.transpose("time", "image_space").to_numpy()[frames - frames.min()]
                expected = np.column_stack([x if cam == 1 else 2047.0 - x, y])
                if np.isfinite(own).mean() < 0.9:
                    return "gap lost (their files)", "-"
                worst = max(worst, float(np.nanmax(np.abs(own - expected))))
    names = [path.name for path in data.glob("cam1.f.*.csv")]
    for name in names:
        stamp = trial_stamp(name)
        write_authors_trial(read_authors_trial(data, stamp, row_px=None), folder / name)
    return f"{worst:.1g} (their files)", f"{_columns_differ(data, folder)} (their files)"


def dltdv7(folder: Path, ending: str, *, space: bool = False) -> tuple[str, str]:
    """By DLTdv 7 in Octave: it counts from 1, Y upwards, and writes six decimals."""
    sparse = ending == ".tsv"
    true, xyz = recording(1)[:, :, 0], recording(1, space=True)[:, :, 0]
    theirs = np.stack([true + np.array([1.0, 0.0])] * 2, axis=2)
    theirs[..., 1] = 480.0 - theirs[..., 1]
    path = dltdv7_writes(theirs, xyz, folder, sparse=sparse)
    if space:
        path = path.with_name(path.name.replace("xypts", "xyzpts"))
        tracks, expected = read_any_tracks(path, fps=FPS), xyz
    else:
        tracks, expected = read_any_tracks(path, fps=FPS, heights_px=[480, 480]), true
    points = [f"pt{k + 1}" for k in range(4)]
    read = off(places(tracks.assign_coords(keypoint=POINTS))[:, :, 0], expected)
    ours = tracks_of(recording(1), views=2).assign_coords(keypoint=points)
    (path,) = write_any_tracks(ours, folder / f"a_xypts{ending}", heights_px=[480, 480])
    if space:
        ours = tracks_of(recording(1, space=True)).assign_coords(keypoint=points)
        write_any_tracks(ours, folder / f"a_xyzpts{ending}")
    xy, found = dltdv7_reads(path)
    return read, off(found, xyz) if space else off(xy, theirs)


def argus(folder: Path, *, space: bool = False) -> tuple[str, str]:
    """By Argus, which keeps what it opens in half precision and opens no points in space."""
    true = recording(1)[:, :, 0]
    theirs = np.stack([true, true + np.array([5.0, 0.0])], axis=2)
    theirs[..., 1] = 480.0 - theirs[..., 1]
    coefs = np.array([[9.0, 0, 0, 320, 0, 9, 0, 240, 0, 0, 0.001],
                      [0.0, 0, 9, 320, 0, 9, 0, 240, -0.001, 0, 0]])  # fmt: skip
    path, xyz = argus_writes(theirs, folder / "theirs", coefs if space else None)
    if space:
        tracks = read_any_tracks(folder / "theirs-xyzpts.csv", fps=FPS)
        return off(places(tracks.assign_coords(keypoint=POINTS))[:, :, 0], xyz), own(
            folder, "argus-3d", "a-xyzpts.csv"
        )[1]
    tracks = read_any_tracks(path, fps=FPS, heights_px=[480])
    read = off(places(tracks.assign_coords(keypoint=POINTS))[:, :, 0], true)
    ours = tracks_of(recording(1), views=2)  # FR, HR, FL, HL: not as Argus sorts them
    (path,) = write_any_tracks(ours, folder / "a-xypts.csv", heights_px=[480])
    shown = argus_reads(path, 2)
    found = np.stack([shown[point][:, 0] for point in POINTS], axis=1)
    return read, off(found, theirs[:, :, 0])


def xmalab_markers(folder: Path) -> tuple[str, str]:
    """Markers in space, laid out as save3dPoints of XMALab's source does it: frames 1 to N.

    Of XMALab, which takes no points in space, 12 digits are read; what is written is read again by
    that layout, with all its digits.
    """
    true = recording(1, space=True)[:, :, 0]
    lines = ["Frame," + ",".join(f"{point}_{axis}" for point in POINTS for axis in "XYZ")]
    for i, row in enumerate(true.reshape(N, -1)):
        lines.append(",".join([str(i + 1), *("NaN" if np.isnan(x) else f"{x:.12g}" for x in row)]))
    (folder / "markers.csv").write_text("\n".join(lines) + "\n")
    tracks = read_any_tracks(folder / "markers.csv", fps=FPS)
    if tracks["frame"].to_numpy().tolist() != list(range(N)):
        return "frames lost (source)", "-"
    (ours,) = write_any_tracks(tracks_of(recording(1, space=True)), folder / "ours.csv",
                               program="xmalab-3d")  # fmt: skip
    table = pd.read_csv(ours)
    same = table["Frame"].tolist() == list(range(1, N + 1)) and ",".join(table) == lines[0]
    found = table.to_numpy()[:, 1:].reshape(true.shape)
    write = off(found, true) if same else "frames lost"
    return f"{off(places(tracks)[:, :, 0], true)} (source)", f"{write} (source)"


def xmalab_points(folder: Path) -> tuple[str, str]:
    """Points in the views, as save2dPoints of XMALab's source writes and load2dPoints reads them.

    Both with a header, pixels from 1 and the y axis down; 12 digits, cells apart by `` , ``.
    """
    true = recording(1)[:, :, 0]
    theirs = np.stack([true, true + np.array([5.0, 0.0])], axis=2)
    lines = [" , ".join(f"{p}_cam{n}_{axis}" for p in POINTS for n in (1, 2) for axis in "XY")]
    for row in theirs.reshape(N, -1):
        lines.append(" , ".join("NaN" if np.isnan(x) else f"{x + 1:.12g}" for x in row))
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    tracks = read_any_tracks(folder / "points.csv", fps=FPS)
    read = off(places(tracks)[:, :, 0], true)
    exact = tracks_of(recording(1), views=2)
    (ours,) = write_any_tracks(exact, folder / "ours.csv", program="xmalab")
    header, *rows = ours.read_text().splitlines()
    cells = [line.split(",") for line in rows]
    found = np.array(cells, dtype=float).reshape(theirs.shape) - 1.0
    names = [header.split(",")[4 * k].replace("_cam1_X", "") for k in range(len(POINTS))]
    write = off(found, np.stack([true, true], axis=2)) if names == POINTS else "names lost"
    return f"{read} (source)", f"{write} (source)"
