"""Whether "expected errors left" is true: what a review states, against what is left by the truth.

python benchmarks/errors_left.py [TRIAL ...] [--clips NAME ...] [--questions 40] [--cache FOLDER]

Every trial (a folder with ``truth/tracks.csv``; without any, scenes are rendered) is tracked, and
the questions of TrackReviewer are answered by the truth, one after the other: right, none, or
which other point it is. Before the first, and after every tenth, stands what the review states
(``reviewer.expected_errors_left``) beside the number of labels that are wrong: further from the
truth than 20 px of a picture 2048 px wide (half a hind paw), hidden ones among them. Of real clips
(``--clips``; see real_clip_marks.py) marks are too few to answer by: there the labels that have a
mark are counted, and what was stated of the same labels.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import real_clip_marks as real
from real_clips import write_trial

from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.io import read_tracks
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.widgets import TrackReviewer
from pawnb.workflow.evaluation.errors import THRESHOLD_PX
from pawnb.workflow.reviewing.quality import clicks_of_tracks
from pawnb.workflow.tracking.track import track

REFERENCE_WIDTH_PX = 2048
EVERY = 10


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("trials", nargs="*", type=Path, metavar="TRIAL")
    parser.add_argument("--clips", nargs="*", default=None, metavar="NAME", help="real clips")
    parser.add_argument("--clicks", type=int, default=2, help="clicked frames of a real clip")
    parser.add_argument("--questions", type=int, default=40, help="to answer (%(default)s)")
    parser.add_argument("--cache", type=Path, help="keeps the tracks")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder, cache = Path(made), options.cache or Path(made)
        cache.mkdir(parents=True, exist_ok=True)
        if options.clips is None:
            for path in options.trials or render(folder):
                reviewed(load_trial(path), cache, options.questions)
        else:
            home = real.clips_folder()
            names = options.clips or sorted(p.parent.name for p in home.glob("*/marks.csv"))
            marked = [stated_of_marks(real.Clip(home / n), options.clicks, cache) for n in names]
            total = np.sum([one for one in marked if one is not None], axis=0)
            print(f"all clips: {total[0]} marks, stated {total[1]:.0f} wrong, {total[2]:.0f} wrong")


def render(folder: Path) -> Iterator[Path]:
    """Render a scene of each difficulty, one at a time."""
    for difficulty in ("easy", "normal", "hard"):
        yield render_mouse_trial(
            folder / difficulty, frames=150, scale=0.5, seed=7, difficulty=difficulty
        )


def tracked(trial: Trial, file: Path, **settings: str) -> Tracks:
    """Track a trial, or read what was tracked before."""
    if file.exists():
        return read_tracks(file)
    tracks = track(trial, settings=settings or None, progress=lambda *_: None)
    tracks.to_netcdf(file)
    return tracks


class Oracle:
    """What is true of a rendered trial: it counts wrong labels, and answers questions."""

    def __init__(self, trial: Trial, tracks: Tracks, limit_px: float) -> None:
        frames, views, points = (tracks[n].to_numpy() for n in ("frame", "view", "keypoint"))
        self.limit_px = limit_px
        self.names = [str(point) for point in points]
        truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
        index = pd.MultiIndex.from_product([frames, views, points])
        table = truth.set_index(["frame", "view", "point"])[["u", "v"]].reindex(index)
        self.uv = table.to_numpy().reshape(len(frames), len(views), len(points), 2)

    def off(self, tracks: Tracks) -> np.ndarray:
        """Return how far each label is from the truth, px, (n, V, P)."""
        uv = np.moveaxis(tracks["image_position"].to_numpy()[..., 0], 2, 3)
        return np.asarray(np.linalg.norm(uv - self.uv, axis=-1))

    def wrong(self, tracks: Tracks) -> int:
        """Return how many labels are wrong, of those that were tracked."""
        origin = tracks["image_origin"].to_numpy()[..., 0]
        counted = ~np.isin(origin, [ORIGIN_CODE["missing"], ORIGIN_CODE["reprojected"]])
        return int((self.off(tracks)[counted] > self.limit_px).sum())

    def answer(self, tracks: Tracks, frame: int, view: str, point: str) -> str:
        """Return what a person who knows the truth would answer."""
        row = int(np.flatnonzero(tracks["frame"].to_numpy() == frame)[0])
        v = [str(name) for name in tracks["view"].to_numpy()].index(view)
        uv = tracks["image_position"].to_numpy()[row, v, :, self.names.index(point), 0]
        off = np.linalg.norm(self.uv[row, v] - uv, axis=-1)
        if off[self.names.index(point)] <= self.limit_px:
            return "answer right"
        other = int(np.nanargmin(off))
        return f"answer is {self.names[other]}" if off[other] <= self.limit_px else "answer none"


def reviewed(trial: Trial, cache: Path, questions: int) -> None:
    """Answer questions by the truth, and print what is stated beside what is so."""
    tracks = tracked(trial, cache / f"{trial.folder.name}.nc")
    with tempfile.TemporaryDirectory() as folder:
        widget = TrackReviewer(trial, tracks, edits=Path(folder) / "edits.jsonl")
        width = max(stage["width"] for stage in widget.stages)
        oracle = Oracle(trial, tracks, THRESHOLD_PX * width / REFERENCE_WIDTH_PX)
        n = int(np.isfinite(oracle.off(tracks)).sum())
        said: list[str] = []
        asked = widget.edit("action", {"action": "ask", "frame": 0})
        for k in range(questions + 1):
            if k % EVERY == 0 or asked is None:
                now = widget.session.present
                said.append(f"{k}: {widget.expected_errors_left:.0f} / {oracle.wrong(now)}")
            if asked is None or widget._question is None:
                break
            word = oracle.answer(widget.session.present, *widget._question)
            asked = widget.edit("action", {"action": word, "frame": asked})
        widget.close()
    print(
        f"{trial.folder.name}: {n} labels; answers: stated / wrong: {'; '.join(said)}", flush=True
    )


def stated_of_marks(clip: real.Clip, n: int, cache: Path) -> tuple[int, float, float] | None:
    """Return how many labels of a real clip have a mark, how many are stated wrong, and are."""
    clicks = clip.clicks(n)
    if clicks is None:
        return None
    with tempfile.TemporaryDirectory() as made:
        trial = load_trial(write_trial(clip, clicks, Path(made)))
        tracks = tracked(trial, cache / f"{clip.name}-{n}.nc")
    chance = label_chances(tracks, clicks=clicks_of_tracks(tracks))
    frames, views, points = (tracks[k].to_numpy().tolist() for k in ("frame", "view", "keypoint"))
    grid = pd.MultiIndex.from_product([frames, views, points], names=["frame", "view", "point"])
    uv = np.moveaxis(tracks["image_position"].to_numpy()[..., 0], 2, 3).reshape(-1, 2)
    table = pd.DataFrame({"u": uv[:, 0], "v": uv[:, 1], "chance": chance.ravel()}, index=grid)
    marks = clip.marks[~clip.marks["frame"].isin(clicks["frame"])]
    found = marks.merge(table.dropna().reset_index(), on=grid.names, suffixes=("", "_track"))
    off = np.hypot(found["u"] - found["u_track"], found["v"] - found["v_track"])
    wrong, stated = float((off > clip.threshold_px).sum()), float((1 - found["chance"]).sum())
    print(
        f"{clip.name}: {len(found)} marks, stated {stated:.1f} wrong, {wrong:.0f} wrong", flush=True
    )
    return len(found), stated, wrong


if __name__ == "__main__":
    main()
