"""What another program's predictions gain: their errors before, and after pawnb took them in.

python benchmarks/predictions.py [--frames 120] [--scale 0.25] [--seeds 0 1] [--trial FOLDER]

Renders the demo with four views and makes of its truth predictions as DeepLabCut writes them:
noise of 2 px along each axis, 5 % gaps, stretches of 5 to 30 frames (10 % of the time) in which
left and right are swapped, 3 % outliers anywhere about the animal. Half of the errors have a low
likelihood, the others one as high as what is right. Then prints the visible labels, in frames that
were not clicked, that are wrong (beyond 20 px of 2048, as in pawnb/workflow/evaluation/errors.py)
or missing: in the predictions, in pawnb's tracks without them, and with them.
"""

from __future__ import annotations

import argparse
import dataclasses
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.video import open_views
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.errors import REFERENCE_WIDTH_PX, THRESHOLD_PX
from pawnb.workflow.tracking.track import track

NOISE_PX = 2.0
GAPS, SWAPPED, OUTLIERS, SAID = 0.05, 0.10, 0.03, 0.5
STRETCH = (5, 30)
NETWORK = "DLC_resnet50_benchmark"
KEYS = ["frame", "view", "point"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=120, help="frames (%(default)s)")
    parser.add_argument("--scale", type=float, default=0.25, help="of 2048 x 700 (%(default)s)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1], help="of the errors")
    parser.add_argument("--trial", type=Path, help="a rendered demo, instead of rendering one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made) / "trial"
        if arguments.trial is None:
            render_mouse_trial(folder, frames=arguments.frames, scale=arguments.scale)
        else:
            shutil.copytree(arguments.trial, folder)
        trial = load_trial(folder)
        limit = threshold_px(trial)
        labels = visible_labels(trial)
        print(f"{trial.name}: {len(labels)} labels, wrong beyond {limit:g} px")
        print(say("pawnb alone", labels, tracks_table(track(trial, progress=silent)), limit))
        for seed in arguments.seeds:
            predicted = write_predictions(trial, seed=seed)
            files = {view.name: f"{view.name}DLC.csv" for view in trial.views}
            helped = dataclasses.replace(trial, detections=files)
            tracks = tracks_table(track(helped, progress=silent))
            print(say(f"predictions, seed {seed}", labels, predicted, limit))
            print(say("pawnb with these", labels, tracks, limit))


def silent(done: int, total: int) -> None:
    """Show no progress."""


def threshold_px(trial: Trial) -> float:
    """Return from which distance on a label is wrong."""
    with open_views(trial) as views:
        return THRESHOLD_PX * views.readers[views.names[0]].width / REFERENCE_WIDTH_PX


def visible_labels(trial: Trial) -> pd.DataFrame:
    """Return the true places of visible points that a view tracks, without the clicked frames."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    clicked = pd.read_csv(trial.path(trial.start_file() or ""))["frame"].unique()
    own = pd.DataFrame(
        [(view.name, point) for view in trial.views for point in view.points],
        columns=["view", "point"],
    )
    shown = truth[(truth["visible"] == 1) & ~truth["frame"].isin(clicked)]
    return shown.merge(own)[[*KEYS, "u", "v"]]


def tracks_table(tracks: Tracks) -> pd.DataFrame:
    """Return places in the views as a table."""
    table = tracks["image_position"].isel(individual=0).to_dataset("image_space").to_dataframe()
    table = table.reset_index().rename(columns={"keypoint": "point"})
    return table[[*KEYS, "u", "v"]]


def say(name: str, labels: pd.DataFrame, found: pd.DataFrame, limit: float) -> str:
    """Say how many labels are wrong or missing."""
    both = labels.merge(found, on=KEYS, how="left", suffixes=("", "_found"))
    apart = np.hypot(both["u"] - both["u_found"], both["v"] - both["v_found"])
    wrong, missing = float((apart > limit).mean()), float(apart.isna().mean())
    return (
        f"  {name:22s} wrong {100 * wrong:5.1f} %, missing {100 * missing:4.1f} %, together "
        f"{100 * (wrong + missing):5.1f} %; median {np.nanmedian(apart):.1f} px"
    )


def write_predictions(trial: Trial, *, seed: int) -> pd.DataFrame:
    """Write a DeepLabCut csv for each view, with errors, and return what is in them."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    rng = np.random.default_rng(seed)
    parts = []
    for view in trial.views:
        own = truth[truth["view"] == view.name]
        points = list(dict.fromkeys(own["point"]))
        wide = own.pivot_table(index="frame", columns="point", values=["u", "v"])
        uv = np.stack([wide[axis][points].to_numpy() for axis in "uv"], axis=2)
        uv, likelihood = predict(rng, uv, points)
        write_deeplabcut(trial.folder / f"{view.name}DLC.csv", points, uv, likelihood)
        for i, point in enumerate(points):
            place = pd.DataFrame({"frame": np.arange(len(uv)), "u": uv[:, i, 0], "v": uv[:, i, 1]})
            parts.append(place.assign(view=view.name, point=point))
    return pd.concat(parts)


def predict(
    rng: np.random.Generator, uv: np.ndarray, points: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (n, P, 2) and likelihoods (n, P) with errors, of true places."""
    n, n_points = uv.shape[:2]
    found = uv + NOISE_PX * rng.standard_normal(uv.shape)
    wrong = np.zeros((n, n_points), bool)
    said = np.zeros((n, n_points), bool)
    for end in "FH":
        pair = [points.index(f"{end}{side}") for side in "LR"]
        for begin, stop in stretches(rng, n):
            found[begin:stop, pair] = found[begin:stop, pair[::-1]]
            wrong[begin:stop, pair] = True
            said[begin:stop, pair] = rng.uniform() < SAID
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    thrown = rng.uniform(size=wrong.shape) < OUTLIERS
    found[thrown] = rng.uniform(low - 20, high + 20, (thrown.sum(), 2))
    said[thrown] = rng.uniform(size=thrown.sum()) < SAID
    likelihood = 1 - np.abs(0.03 * rng.standard_normal(wrong.shape))
    low_there = (wrong | thrown) & said
    likelihood[low_there] = rng.uniform(0.05, 0.6, low_there.sum())
    gap = rng.uniform(size=wrong.shape) < GAPS
    found[gap], likelihood[gap] = np.nan, np.nan
    return found, likelihood


def stretches(rng: np.random.Generator, n: int) -> list[tuple[int, int]]:
    """Return stretches of frames that do not meet, about ``SWAPPED`` of them all."""
    free = 1 / SWAPPED * np.mean(STRETCH) - np.mean(STRETCH)
    found, t = [], int(rng.exponential(free))
    while t < n:
        stop = min(n, t + int(rng.integers(STRETCH[0], STRETCH[1] + 1)))
        found.append((t, stop))
        t = stop + 1 + int(rng.exponential(free))
    return found


def write_deeplabcut(path: Path, points: list[str], uv: np.ndarray, sure: np.ndarray) -> None:
    """Write a csv as DeepLabCut does."""
    columns = {}
    for i, point in enumerate(points):
        columns[NETWORK, point, "x"] = uv[:, i, 0]
        columns[NETWORK, point, "y"] = uv[:, i, 1]
        columns[NETWORK, point, "likelihood"] = sure[:, i]
    table = pd.DataFrame(columns).round(4)
    table.columns = table.columns.set_names(["scorer", "bodyparts", "coords"])
    path.write_text(table.to_csv(lineterminator="\n"))


if __name__ == "__main__":
    main()
