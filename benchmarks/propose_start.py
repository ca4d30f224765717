"""How often a person would change nothing of a proposed start.

Scenes are rendered (small, short) as rigs vary: seed, direction, colours, two to four views,
speed; or trials with ``truth/tracks.csv`` are given. A proposal needs no change if every
visible paw is there in every view that tracks it and no point is farther from the
truth than half a paw: 20 px in a picture 2048 px wide.

    python benchmarks/propose_start.py [TRIAL ...] [--difficulty NAME] [--scenes N] [--scale S]
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.video import open_views
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.start.propose import StartProposal, propose_paws

HALF_PAW_PX = 20.0
REFERENCE_WIDTH_PX = 2048
VARIED: tuple[dict[str, Any], ...] = (
    {},
    {"direction": -1},
    {"n_views": 2},
    {"belt_rgb": (90, 110, 150), "fur_rgb": (140, 120, 100), "paw_rgb": (200, 150, 140)},
    {"n_views": 3, "direction": -1},
    {"fps": 150.0, "belt_speed_mm_s": 400.0},
    {"belt_rgb": (60, 60, 62), "fur_rgb": (200, 198, 192), "paw_rgb": (205, 150, 140)},
    {"light": 0.6, "light_gradient": 0.4},
    {"n_views": 2, "direction": -1, "belt_rgb": (150, 150, 140)},
    {"size": 0.8, "belt_speed_mm_s": 200.0},
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("trials", nargs="*", type=Path, metavar="TRIAL")
    parser.add_argument("--difficulty", default="normal")
    parser.add_argument("--scenes", type=int, default=len(VARIED), help="to render (%(default)s)")
    parser.add_argument("--first-seed", type=int, default=100)
    parser.add_argument("--frames", type=int, default=60, help="of each scene (%(default)s)")
    parser.add_argument("--scale", type=float, default=0.4, help="of 2048 x 700 (%(default)s)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        trials = options.trials or render(Path(folder), options)
        good = [judge(load_trial(path)) for path in trials]
    print(f"nothing to change in {sum(good)} of {len(good)} scenes")


def render(folder: Path, options: argparse.Namespace) -> Iterator[Path]:
    """Render the scenes one after the other."""
    for k in range(options.scenes):
        changes = VARIED[k % len(VARIED)]
        print(f"{options.difficulty} {changes}", flush=True)
        yield render_mouse_trial(
            folder / f"scene{k}", frames=options.frames, scale=options.scale,
            seed=options.first_seed + k, difficulty=options.difficulty, settings=changes,
        )  # fmt: skip


def judge(trial: Trial) -> bool:
    """Propose a start, print how far off it is, and say whether it needs no change."""
    with open_views(trial) as views:
        width = views.readers[views.names[0]].width
    proposal = propose_paws(trial, progress=lambda *_: None)
    off = distances(trial, proposal, width=width)
    worst = float(off["px"].max())
    good = bool(off["px"].notna().all() and worst <= HALF_PAW_PX)
    each = ", ".join(f"{p} {d:.0f}" for p, d in off.groupby("point")["px"].max().items())
    print(
        f"  {trial.name}: frame {proposal.frame}, {proposal.words} ({proposal.sure:.2f}); px of a "
        f"picture 2048 wide from the truth: {each}; {'good' if good else 'TO CHANGE'}",
        flush=True,
    )
    return good


def distances(trial: Trial, proposal: StartProposal, *, width: int) -> pd.DataFrame:
    """Return point and px (2048 wide) from the truth; NaN where a visible paw was not proposed."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    points = {view.name: view.points for view in trial.views}
    truth = truth[truth["frame"] == proposal.frame]
    tracked = [p in points[v] for v, p in zip(truth["view"], truth["point"], strict=True)]
    both = truth[tracked].merge(
        proposal.start, on=["frame", "view", "point"], how="left", suffixes=("_true", "")
    )
    both = both[(both["visible"] == 1) | both["u"].notna()]
    away = np.hypot(both["u"] - both["u_true"], both["v"] - both["v_true"])
    return both.assign(px=away * REFERENCE_WIDTH_PX / width)


if __name__ == "__main__":
    main()
