"""Whether the frame that suggest_frames names is worth a further click more than others are.

python benchmarks/second_click.py [--clips NAME ...] [--clicked {1,2}] [--runs FOLDER]
    [--draws 1000] [--out ROWS.csv]

Of each clip some marked frames in which all points can be seen (FRAMES) are clicked one by one, and
in each pair. Every frame is once what was clicked before, and the others are candidates for the
second click; with --clicked 2 the first two frames are clicked before, and the others are
candidates for the third. Of each candidate the rows have how many marks are right after it (% of
those in frames that were not clicked, of points that were clicked before as well), and what was
known before: scores by which it could have been chosen.

    gain          pawnb.suggest_frames
    doubt         labels expected to be wrong in the frame itself
    time          frames to the nearest clicked one (k-centre in time)
    medians       by how much all frames come nearer to a clicked one (k-medians in time)
    doubt medians the same, frames weighted by the labels expected to be wrong in them
    pose          how far the points, about their mean, are from where they were clicked (k-centre)
    pose medians  by how much the poses of all frames come nearer to a clicked one
    seen          points that were found in the picture

Printed by clip: % right before the click, after it in the candidate of the largest gain, as mean
and in the best of the candidates. By score: rank correlation with the % right within one set of
candidates, and by how much the candidate chosen is better than their mean, points; both as mean
over clips, with its standard error and the probability of one as large where frames of a clip are
exchanged among each other (Mantel 1967, Cancer Research 27, 209: one-sided).
--runs keeps what was tracked, and takes what is there.
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import real_clip_marks as real
import real_clips
import xarray as xr
from scipy.stats import rankdata

from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.io.native import read_tracks
from pawnb.schema import ORIGIN_CODE
from pawnb.trial import load_trial
from pawnb.workflow.reviewing.quality import clicks_of_tracks
from pawnb.workflow.reviewing.suggest import gain_by_frame

FRAMES = {
    "horse_walk": (135, 100, 110, 150, 165, 180),
    "camel_walk": (19, 2, 38, 55, 80),
    "dog_indoors": (86, 24, 258, 280),
    "fly_ball_left": (0, 3, 7, 11, 14),
    "walk_side": (114, 82, 98, 134, 158, 178),
}
"""Frames by clip, its own start first. Left out are clips in which one click has 95 % or more."""

SCORES = ("gain", "doubt", "time", "medians", "doubt medians", "pose", "pose medians", "seen")


def track(clip: real.Clip, frames: tuple[int, ...], home: Path) -> Path:
    """Track a clip from its marks in some frames; the clip's own start where it is one of them."""
    folder = home / f"{clip.name}-{'+'.join(map(str, frames))}"
    if not (folder / "results" / "tracks.nc").exists():
        own = clip.start["frame"].iloc[0]
        clicks = [clip.start if f == own else clip.marks[clip.marks["frame"] == f] for f in frames]
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        real_clips.write_trial(clip, pd.concat(clicks, ignore_index=True), folder)
        words = [sys.executable, "-m", "pawnb", "track", str(folder)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode not in real_clips.FINISHED:
            sys.exit(done.stderr)
    return folder


def judge(clip: real.Clip, folder: Path) -> pd.DataFrame:
    """Return the marks that count, and which are right."""
    clicks = pd.read_csv(folder / "start.csv")
    tracks = pd.read_csv(folder / "results" / "tracks.csv")
    return real.compare(clip.marks, clicks, tracks, clip.threshold_px)


def known_before(folder: Path) -> pd.DataFrame:
    """Return the scores of all frames of tracks, by frame."""
    tracks = read_tracks(folder / "results" / "tracks.nc")
    clicks = clicks_of_tracks(tracks)
    frames = tracks["frame"].to_numpy()
    wrong = np.nansum(1.0 - label_chances(tracks, clicks=clicks), axis=(1, 2))
    clicked = np.flatnonzero(np.isin(frames, clicks["frame"]))
    apart = np.abs(frames[:, None] - frames).astype(float)
    poses = _pose_distances(tracks)
    origin = tracks["image_origin"].to_numpy().reshape(len(frames), -1)
    return pd.DataFrame({
        "gain": gain_by_frame(load_trial(folder), tracks),
        "doubt": wrong,
        "time": apart[:, clicked].min(axis=1),
        "medians": _nearer(apart, clicked).sum(axis=1),
        "doubt medians": _nearer(apart, clicked) @ wrong,
        "pose": poses[:, clicked].min(axis=1),
        "pose medians": _nearer(poses, clicked).sum(axis=1),
        "seen": (origin == ORIGIN_CODE["measured"]).sum(axis=1),
    }, index=frames)  # fmt: skip


def _nearer(distance: np.ndarray, clicked: np.ndarray) -> np.ndarray:
    """Return by how much a click in each frame (row) brings every frame nearer to a click."""
    return np.maximum(distance[:, clicked].min(axis=1) - distance, 0.0)


def _pose_distances(tracks: xr.Dataset) -> np.ndarray:
    """Return the distance of the pose in each frame from that in each other, sizes of the pose."""
    order = ("time", "view", "keypoint", "image_space")
    places = tracks["image_position"].isel(individual=0).transpose(*order).to_numpy()
    about = places - np.nanmean(places, axis=2, keepdims=True)
    size = np.nanmedian(np.sqrt(np.nanmean((about**2).sum(axis=-1), axis=2)), axis=0)
    about /= size[:, None, None]
    away = np.stack([((about - one) ** 2).sum(axis=-1) for one in about])
    distance = np.sqrt(np.nanmean(away, axis=(2, 3)))
    return np.nan_to_num(distance, nan=np.nanmedian(distance))


def measure(clip: real.Clip, n_clicked: int, home: Path) -> pd.DataFrame:
    """Return a row for each candidate beside each frame or pair that was clicked before."""
    frames = FRAMES[clip.name]
    firsts = itertools.combinations(frames, 1) if n_clicked == 1 else (frames[:2],)
    rows = []
    for first in (tuple(sorted(first)) for first in firsts):
        before = track(clip, first, home)
        scores, found = known_before(before), judge(clip, before)
        for frame in (frame for frame in frames if frame not in first):
            keys = ["frame", "view", "point"]
            then = judge(clip, track(clip, tuple(sorted((*first, frame))), home))
            both = found.merge(then, on=keys, suffixes=("_before", ""))
            rows.append({
                "clip": clip.name, "clicked": "+".join(map(str, first)), "frame": frame,
                "marks": len(both), "before": 100 * both["ok_before"].mean(),
                "after": 100 * both["ok"].mean(), **scores.loc[frame],
            })  # fmt: skip
        print(f"{clip.name} {first}: {len(rows)} done", file=sys.stderr, flush=True)
    return pd.DataFrame(rows)


def correlation_and_lift(score: np.ndarray, right: np.ndarray) -> tuple[float, float]:
    """Return the mean rank correlation of rows of candidates, and what choosing by score gains."""
    x, y = (rankdata(of, axis=1) for of in (score, right))
    x -= x.mean(axis=1, keepdims=True)
    y -= y.mean(axis=1, keepdims=True)
    size = np.sqrt((x**2).sum(axis=1) * (y**2).sum(axis=1))
    both = np.where(size > 0.0, (x * y).sum(axis=1) / np.maximum(size, 1e-9), 0.0)
    chosen = score == score.max(axis=1, keepdims=True)
    lift = (chosen * right).sum(axis=1) / chosen.sum(axis=1) - right.mean(axis=1)
    return float(both.mean()), float(lift.mean())


def exchanged(own: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Return the rows of a clip with its frames exchanged in what was found, not in the scores."""
    frames = own["frame"].unique()
    new = dict(zip(frames, rng.permutation(frames), strict=True))
    names = {str(frame): str(other) for frame, other in new.items()}
    if own["clicked"].str.contains("+", regex=False).any():  # of pairs only the candidates
        mixed = own.groupby("clicked")["after"].transform(rng.permutation)
        return own.assign(after=mixed)
    right = own.set_index(["clicked", "frame"])["after"]
    keys = list(zip(own["clicked"].map(names), own["frame"].map(new), strict=True))
    return own.assign(after=right.loc[keys].to_numpy())


def over_clips(rows: pd.DataFrame) -> np.ndarray:
    """Return rank correlation and lift (clip, score, 2)."""
    out = []
    for _, own in rows.groupby("clip"):
        n_sets = own["clicked"].nunique()
        right = own["after"].to_numpy().reshape(n_sets, -1)
        out.append([correlation_and_lift(own[s].to_numpy().reshape(n_sets, -1), right)
                    for s in SCORES])  # fmt: skip
    return np.array(out)


def by_score(rows: pd.DataFrame, draws: int) -> pd.DataFrame:
    """Return the second table."""
    rng = np.random.default_rng(1)
    clips = [own for _, own in rows.groupby("clip")]
    chance = np.stack([
        over_clips(pd.concat([exchanged(own, rng) for own in clips])).mean(axis=0)
        for _ in range(draws)
    ])  # fmt: skip
    found = over_clips(rows)
    mean, error = found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(len(found))
    p = (1 + (chance >= mean - 1e-9).sum(axis=0)) / (1 + draws)
    table = [
        [score, f"{mean[k, 0]:.2f}", f"{error[k, 0]:.2f}", f"{p[k, 0]:.3f}",
         f"{mean[k, 1]:.1f}", f"{error[k, 1]:.1f}", f"{p[k, 1]:.3f}"]
        for k, score in enumerate(SCORES)
    ]  # fmt: skip
    names = ["score", "rank correlation", "error", "p", "points gained", "error of it", "p of it"]
    return pd.DataFrame(table, columns=names)


def by_clip(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the first table: % right, means over what was clicked before."""
    out = []
    for (name, _), own in rows.groupby(["clip", "clicked"]):
        chosen = own.loc[own["gain"] == own["gain"].max(), "after"].mean()
        out.append([name, own["before"].mean(), chosen, own["after"].mean(), own["after"].max()])
    columns = ["clip", "before", "named", "all candidates", "best"]
    means = pd.DataFrame(out, columns=columns).groupby("clip", as_index=False).mean()
    total = pd.DataFrame([["mean", *means[columns[1:]].mean()]], columns=columns)
    return pd.concat([means, total]).round(0).astype(dict.fromkeys(columns[1:], int)).astype(str)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", nargs="+", choices=FRAMES, metavar="NAME")
    parser.add_argument("--clicked", type=int, choices=(1, 2), default=1)
    parser.add_argument("--runs", type=Path, metavar="FOLDER", help="keeps what was tracked")
    parser.add_argument("--draws", type=int, default=1000)
    parser.add_argument("--out", type=Path, metavar="ROWS.csv")
    options = parser.parse_args()
    home = real.clips_folder()
    there = [name for name in options.clips or FRAMES if (home / name / "marks.csv").exists()]
    if not there:
        print(f"real clips: not in {home} (set PAWNB_TEST_DATA)")
        return
    with tempfile.TemporaryDirectory() as made:
        runs = options.runs or Path(made)
        rows = pd.concat(
            [measure(real.Clip(home / name), options.clicked, runs) for name in there],
            ignore_index=True,
        )
    if options.out:
        rows.to_csv(options.out, index=False)
    print(real_clips.markdown(by_clip(rows)) + "\n")
    print(real_clips.markdown(by_score(rows, options.draws)))


if __name__ == "__main__":
    main()
