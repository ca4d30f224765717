"""Speed of the pose tracker beside that of decoding alone, on a rendered spider at full size.

python benchmarks/pose_speed.py --folder scenes [--frames 120] [--scale 1.0]

The recording is tracked twice; the first time, which may compile, does not count.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.pose.background import find_background
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.video import open_view
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--scale", type=float, default=1.0)
    args = parser.parse_args()
    folder = args.folder / f"speed-{args.frames}-{args.scale:g}"
    if not (folder / "trial.toml").exists():
        render_spider_trial(folder, frames=args.frames, scale=args.scale, seed=1)
    trial = load_trial(folder / "trial.toml")
    species = load_species(str(trial.animal.species), folder=folder)
    animal, start = read_start_pose(folder / "start_pose.csv", species)
    reader = open_view(trial.views[0], folder)
    background = find_background(reader, trial.views[0], folder=folder)
    began = time.perf_counter()
    for i in range(reader.n_frames):
        reader.frame(i)
    decode_s = (time.perf_counter() - began) / reader.n_frames
    marks: list[float] = []
    for _ in range(2):
        began, cpu = time.perf_counter(), time.process_time()
        marks.clear()
        track = track_pose(
            reader, start, animal=animal, background=background, frames=(0, reader.n_frames),
            progress=lambda *_: marks.append(time.perf_counter()),
        )  # fmt: skip
        took, cpu = time.perf_counter() - began, time.process_time() - cpu
    n = int(np.isfinite(track.poses.xy[:, 0]).sum())
    table = pd.Series(
        {
            "frames with the animal": n,
            "decoding, ms a frame": 1000 * decode_s,
            "tracking, ms a frame": 1000 * took / n,
            "processor time, ms a frame": 1000 * cpu / n,
            "start frame, ms": 1000 * (marks[0] - began),
            "following, ms a frame": 1000 * (marks[n - 1] - marks[0]) / n,
            "frames a second": n / took,
            "ratio to decoding": took / n / decode_s,
        }
    )
    print(f"{reader.width} x {reader.height} px")
    print(table.round(1).to_string())


if __name__ == "__main__":
    main()
