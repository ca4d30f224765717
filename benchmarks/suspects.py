"""How many of a tracker's errors are in the frames that the suspects point at.

Every trial (a folder with ``truth/tracks.csv`` beside its videos; without any, scenes are
rendered) is tracked with the given method. Errors are runs of wrong frames of one point by the
rule of :mod:`pawnb.workflow.evaluation.errors`. A look is one frame, whatever is wrong in it: of
the list, the first frames that are different, as many as 2 % or 5 % of the frames of the recording.
An error counts as found if one of these frames lies within its run or at most 5 frames before or
after it, whichever point was doubted there. The list may be shorter than 5 %. Beside the suspects
stand frames drawn at random, and the most that any choice of as many frames could find (each time
the frame with the most errors not found yet), which is the limit where a trial has more errors than
frames may be looked at. *Together* is what is found when the frames of all trials make one list, by
their scores: a recording with many errors is then looked at more often than one with few.

    python benchmarks/suspects.py [TRIAL ...] [--method NAME] [--frames N] [--scale S] [--seeds K]
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.rig import load_rig
from pawnb.core.suspects.frames import find_suspects
from pawnb.core.suspects.rates import WRONG_AROUND_FRAMES
from pawnb.core.video import open_views
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.errors import THRESHOLD_PX, count_errors
from pawnb.workflow.tracking.track import track

SHARES = (0.02, 0.05)
DRAWS = 50
REFERENCE_WIDTH_PX = 2048
COLUMNS = ("errors", "found", "major", "major_found", "random", "limit")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("trials", nargs="*", type=Path, metavar="TRIAL")
    parser.add_argument("--method", default="pawnb", help="%(default)s")
    parser.add_argument("--frames", type=int, default=300, help="to render (%(default)s)")
    parser.add_argument("--scale", type=float, default=0.5, help="of 2048 x 700 (%(default)s)")
    parser.add_argument("--seeds", type=int, default=2, help="scenes of each kind (%(default)s)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        trials = options.trials or render(Path(folder), options)
        lists = [listed(load_trial(path), options.method) for path in trials]
    measured = pd.concat([measure(one) for one in lists])
    total = measured.groupby("looked_at")[list(COLUMNS)].sum()
    for share, row in total.iterrows():
        together, major = found_together(lists, float(share))
        print(
            f"all trials, {share:.0%} of frames: {row.found:.0f} of {row.errors:.0f} errors found "
            f"({percent(row.found, row.errors)}), major {row.major_found:.0f} of {row.major:.0f} "
            f"({percent(row.major_found, row.major)}); at random "
            f"{percent(row.random, row.errors)}, the most that can be found "
            f"{percent(row.limit, row.errors)}; together {together} "
            f"({percent(together, row.errors)}), major {major}"
        )


def percent(part: float, whole: float) -> str:
    """Write a share, also of nothing."""
    return f"{part / whole:.0%}" if whole else "none"


def render(folder: Path, options: argparse.Namespace) -> Iterator[Path]:
    """Render scenes of each difficulty, one at a time."""
    for difficulty in ("easy", "normal", "hard"):
        for seed in range(options.seeds):
            yield render_mouse_trial(
                folder / f"{difficulty}{seed}", frames=options.frames, scale=options.scale,
                seed=seed, difficulty=difficulty,
            )  # fmt: skip


@dataclass(frozen=True)
class Listed:
    """A tracked trial: its frames, its errors, and the suspects, one row a listed frame."""

    name: str
    frames: np.ndarray
    errors: pd.DataFrame
    suspects: pd.DataFrame


def listed(trial: Trial, method: str) -> Listed:
    """Track one trial, count its errors, and list its suspects."""
    tracks = track(trial, method=method, progress=lambda *_: None)
    suspects = find_suspects(tracks, rig=load_rig(trial)).drop_duplicates("frame")
    return Listed(trial.name, tracks["frame"].to_numpy(), count(trial, tracks), suspects)


def count(trial: Trial, tracks: Tracks) -> pd.DataFrame:
    """List the errors of tracks by the trial's truth."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    with open_views(trial) as views:
        width = max(reader.width for reader in views.readers.values())
    return count_errors(
        tracks, truth, threshold_px=THRESHOLD_PX * width / REFERENCE_WIDTH_PX,
        points_by_view={view.name: view.points for view in trial.views},
    ).errors  # fmt: skip


def measure(one: Listed) -> pd.DataFrame:
    """Count errors, all and found, for each share of frames."""
    order, frames, errors = one.suspects["frame"].tolist(), one.frames, one.errors
    major = errors[errors["kind"] == "major"]
    rng = np.random.default_rng(0)
    rows = []
    for share in SHARES:
        k = max(1, round(share * len(frames)))
        drawn = [found(rng.choice(frames, k, replace=False), errors) for _ in range(DRAWS)]
        by_chance = float(np.mean(drawn))
        rows.append((one.name, share, len(errors), found(order[:k], errors), len(major),
                     found(order[:k], major), by_chance, most(frames, errors, k)))  # fmt: skip
        print(dict(zip(("trial", "looked_at", *COLUMNS), rows[-1], strict=True)), flush=True)
    return pd.DataFrame(rows, columns=["trial", "looked_at", *COLUMNS])


def found_together(lists: list[Listed], share: float) -> tuple[int, int]:
    """Return how many errors, and major ones, the highest scores of all trials find."""
    k = max(1, round(share * sum(len(one.frames) for one in lists)))
    rows = pd.concat([one.suspects.assign(trial=i) for i, one in enumerate(lists)])
    looks = rows.sort_values("score", ascending=False, kind="stable").head(k)
    total = total_major = 0
    for i, one in enumerate(lists):
        frames = looks.loc[looks["trial"] == i, "frame"].tolist()
        total += found(frames, one.errors)
        total_major += found(frames, one.errors[one.errors["kind"] == "major"])
    return total, total_major


def found(frames: Collection[int], errors: pd.DataFrame) -> int:
    """Return how many errors lie at, or near, one of the frames."""
    return sum(
        any(
            e.first_frame - WRONG_AROUND_FRAMES <= f <= e.last_frame + WRONG_AROUND_FRAMES
            for f in frames
        )
        for e in errors.itertuples()
    )


def most(frames: np.ndarray, errors: pd.DataFrame, k: int) -> int:
    """Return how many errors k frames can find when each is chosen by the truth."""
    first, last = errors["first_frame"].to_numpy(), errors["last_frame"].to_numpy()
    near = (first - WRONG_AROUND_FRAMES <= frames[:, None]) & (
        frames[:, None] <= last + WRONG_AROUND_FRAMES
    )
    left = np.ones(len(errors), dtype=bool)
    for _ in range(k):
        left &= ~near[(near & left).sum(axis=1).argmax()]
    return int((~left).sum())


if __name__ == "__main__":
    main()
