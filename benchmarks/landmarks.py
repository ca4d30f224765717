"""How well nose, ears and tail are tracked: rendered scenes with exact truth.

Run it from the project's root; scenes are those of whole_accuracy.py:

    python benchmarks/landmarks.py --render scenes --vary --frames 200 --seeds 31 32 33
    python benchmarks/landmarks.py --render scenes --methods pawnb paper

Every landmark that is inside the picture of two views or more at the start is clicked where
it truly is, the paws as in the scene. Distances are in space, mm; the animal is 87 mm from the nose
to the base of the tail. *missing* is the share of frames in which the landmark was given no
place, *inside* that of coordinates whose truth lies in the stated 95 % interval.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from whole_accuracy import add_scene_arguments, silent, trials

from pawnb.core.rig import Rig, load_rig
from pawnb.core.video import open_views
from pawnb.schema import START_COLUMNS, Tracks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.methods import PAW_METHODS
from pawnb.workflow.tracking.track import track


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_scene_arguments(parser)
    parser.add_argument("--methods", nargs="*", choices=PAW_METHODS, default=["pawnb"])
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for path in trials(arguments, arguments.render or Path(folder)):
            for method in arguments.methods:
                found = measure(load_trial(path), method)
                print(found.to_string(index=False, float_format="%.2f"), flush=True)
                rows.append(found)
    every = pd.concat(rows)
    print("\nMedian over scenes:")
    columns = ["median_mm", "p95_mm", "missing", "inside"]
    print(every.groupby(["method", "landmark"])[columns].median().to_string(float_format="%.2f"))


def measure(trial: Trial, method: str) -> pd.DataFrame:
    """Track the landmarks of one trial beside its paws, and compare them with their truth."""
    truth = pd.read_csv(trial.folder / "truth" / "landmarks3d.csv")
    rig = load_rig(trial)
    if rig is None:
        raise SystemExit(f"{trial.name} has no calibration; landmarks are compared in space.")
    clicks = click(trial, rig, truth)
    views = tuple(
        dataclasses.replace(
            view, points=(*view.points, *clicks.loc[clicks["view"] == view.name, "point"])
        )
        for view in trial.views
    )
    start = pd.concat([pd.read_csv(trial.folder / "start.csv"), clicks])
    trial = dataclasses.replace(trial, views=views)
    tracks = track(trial, method=method, start=start, progress=silent)
    return pd.DataFrame([
        {"trial": trial.name, "method": method, "landmark": point,
         **compare(tracks, truth[truth["point"] == point], point)}
        for point in dict.fromkeys(clicks["point"])
    ])  # fmt: skip


def click(trial: Trial, rig: Rig, truth: pd.DataFrame) -> pd.DataFrame:
    """Return clicks on every landmark that two views or more see at the start."""
    rows = []
    with open_views(trial) as views:
        for mark in truth[truth["frame"] == 0].itertuples():
            for name, (u, v) in zip(
                rig.names, rig.project(np.array([mark.x, mark.y, mark.z])), strict=True
            ):
                width, height = views.readers[name].width, views.readers[name].height
                # an ear is hidden from the other side by the head
                other = (
                    mark.point.startswith("ear")
                    and f"H{mark.point[-1]}" not in trial.view(name).points
                )
                if 0 <= u <= width - 1 and 0 <= v <= height - 1 and not other:
                    rows.append((0, name, mark.point, u, v))
    clicks = pd.DataFrame(rows, columns=list(START_COLUMNS))
    return clicks[clicks.groupby("point")["view"].transform("size") >= 2]


def compare(tracks: Tracks, truth: pd.DataFrame, point: str) -> dict[str, float]:
    """Return distances from the truth, mm, what is missing, and what the intervals hold."""
    own = tracks.sel(keypoint=point).isel(individual=0)
    xyz = truth.set_index("frame").loc[own["frame"].to_numpy(), ["x", "y", "z"]].to_numpy()
    off = own["position"].transpose("time", "space").to_numpy() - xyz
    away = np.linalg.norm(off, axis=1)
    known = np.isfinite(away)
    inside = np.nan
    if "sd" in own:
        sd = own["sd"].transpose("time", "space").to_numpy()[known]
        inside = float((np.abs(off[known]) <= 1.96 * sd).mean())
    return {
        "median_mm": float(np.median(away[known])), "p95_mm": float(np.quantile(away[known], 0.95)),
        "missing": float(1 - known.mean()), "inside": inside,
    }  # fmt: skip


if __name__ == "__main__":
    main()
