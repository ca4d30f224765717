"""How well the whole-recording tracker tracks: rendered scenes with exact truth.

Run it from the project's root:

    python benchmarks/whole_accuracy.py --frames 300 --seeds 0 1 2 3 4
    python benchmarks/whole_accuracy.py --trials my/a/trial.toml my/b/trial.toml

Each scene is tracked once from its start clicks, without corrections. Rates are per 1000
frames of all views together, with the upper end of the exact 95 % interval of a Poisson
count (Garwood 1936). Distances are px of the picture as it is; the limit of a wrong label
is 20 px in a picture 2048 px wide, and hidden labels are bridged within half of that. The
rule for errors is in pawnb/workflow/evaluation.py. Time is of the whole call, decoding
included, beside that of decoding alone.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import chi2

from pawnb.core.paws.whole import WholeSettings, track_whole
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation import THRESHOLD_PX, count_errors

REFERENCE_WIDTH_PX = 2048


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trials", type=Path, nargs="*", help="trials with truth/ beside them")
    parser.add_argument("--difficulty", nargs="*", default=["easy", "normal", "hard"])
    parser.add_argument("--seeds", type=int, nargs="*", default=[0, 1, 2])
    parser.add_argument("--frames", type=int, default=300, help="(%(default)s)")
    parser.add_argument("--scale", type=float, default=0.5, help="of 2048 x 700 (%(default)s)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [measure(load_trial(path)) for path in trials(arguments, Path(folder))]
    table = pd.DataFrame(rows)
    print(table.to_string(index=False, float_format="%.2f"))
    print(summary(table).to_string(float_format="%.2f"))


def trials(arguments: argparse.Namespace, folder: Path) -> Iterator[Path]:
    """Yield trial files: those given, else rendered ones."""
    if arguments.trials:
        yield from arguments.trials
        return
    for difficulty in arguments.difficulty:
        for seed in arguments.seeds:
            yield render_mouse_trial(
                folder / f"{difficulty}{seed}", frames=arguments.frames, scale=arguments.scale,
                seed=seed, difficulty=difficulty,
            )  # fmt: skip


def measure(trial: Trial) -> dict[str, object]:
    """Track one trial and compare it with its truth."""
    start = pd.read_csv(trial.folder / "start.csv")
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    points = {view.name: view.points for view in trial.views}
    with open_views(trial) as views:
        n, width = views.n_frames, views.readers[views.names[0]].width
        began = time.perf_counter()
        for _ in views.frames(0, n):
            pass
        decoded = time.perf_counter() - began
        began = time.perf_counter()
        tracks = track_whole(
            views, start, rig=load_rig(trial), settings=WholeSettings(), points_by_view=points,
            frames=(0, n), fps=trial.fps,
        )  # fmt: skip
        tracked = time.perf_counter() - began
    threshold = THRESHOLD_PX * width / REFERENCE_WIDTH_PX
    report = count_errors(
        tracks, truth, points_by_view=points, threshold_px=threshold, hidden_px=threshold / 2
    )
    return {
        "trial": trial.name, "width": width, "frames": report.n_frames, "major": report.major,
        "minor": report.minor, "wrong_%": 100 * report.share_wrong, "median": report.median_px,
        "p95": report.p95_px, "centred": report.median_px_centred,
        "bridged_%": 100 * report.share_hidden_bridged, "hidden": report.n_hidden,
        "inside_95_%": 100 * share_inside(tracks, trial), "ms": 1000 * tracked / n,
        "ratio": tracked / decoded,
    }  # fmt: skip


def share_inside(tracks: Tracks, trial: Trial) -> float:
    """Return the share of true coordinates inside the stated 95 % intervals."""
    truth = pd.read_csv(trial.folder / "truth" / "points3d.csv")
    inside = []
    for point in tracks["keypoint"].to_numpy().tolist():
        own = truth[truth["point"] == point].set_index("frame")
        true = own.loc[tracks["frame"].to_numpy(), ["x", "y", "z"]].to_numpy()
        here = tracks.sel(keypoint=point).isel(individual=0)
        away = np.abs(here["position"].to_numpy() - true)
        inside.append(away < 1.96 * here["sd"].to_numpy())
    return float(np.mean(inside))


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Return rates by difficulty, with their upper bounds."""
    kind = table["trial"].str.extract(r"synthetic-(\w+)-", expand=False).fillna("other")
    rows = {}
    for name, part in table.groupby(kind):
        frames = part["frames"].sum()
        row = {"frames": float(frames)}
        for error in ("major", "minor"):
            count = int(part[error].sum())
            row[error] = float(count)
            row[f"{error}_per_1000"] = 1000 * count / frames
            row[f"{error}_upper"] = 1000 * float(chi2.ppf(0.975, 2 * count + 2)) / 2 / frames
        row["bridged_%"] = float(np.average(part["bridged_%"], weights=part["hidden"]))
        rows[str(name)] = row
    return pd.DataFrame(rows).T


if __name__ == "__main__":
    main()
