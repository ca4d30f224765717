"""Learn how likely labels of tracks by colour are wrong: what "expected errors left" adds up.

python benchmarks/learn_errors_left.py TRIAL ... --others TRIAL ... [--cache FOLDER]

Every trial (a folder with ``truth/tracks.csv``, rendered by ``pawnb.synthetic.render_mouse_trial``
and filmed anew by ``benchmarks/refilm.py``) is tracked by colour, also where another method would
be taken: how tracks look that have failed is learnt from them, too. A logistic regression on the
chances of the verdict gives the numbers of ``pawnb/core/suspects/expected.py``; every recording
weighs the same. What is stated of the trials after ``--others`` is printed beside what is so.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from errors_left import REFERENCE_WIDTH_PX, Oracle, tracked
from scipy.optimize import minimize
from scipy.special import expit, logit

from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.core.suspects.expected import calibrated_anew
from pawnb.core.video import open_views
from pawnb.schema import ORIGIN_CODE
from pawnb.trial import load_trial
from pawnb.workflow.evaluation.errors import THRESHOLD_PX
from pawnb.workflow.reviewing.quality import clicks_of_tracks

LEAST_CHANCE = 1e-3
"""Chances nearer to 0 or 1 tell no more."""
RIDGE = 1e-3
"""Cost of a slope of one: it holds a slope back only where nothing is wrong."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("trials", nargs="+", type=Path, metavar="TRIAL", help="to learn from")
    parser.add_argument("--others", nargs="*", default=[], type=Path, metavar="TRIAL")
    parser.add_argument("--cache", type=Path, help="keeps the tracks")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        cache = options.cache or Path(made)
        cache.mkdir(parents=True, exist_ok=True)
        labels = pd.concat([measure(path, cache) for path in options.trials])
        offset, slope, doubted = learn(labels)
        print(
            f"offset {offset:.2f}, slope {slope:.2f}, doubted {doubted:.1f}; {len(labels)} labels"
        )
        report("learnt from", labels)
        if options.others:
            report("others", pd.concat([measure(path, cache) for path in options.others]))


def measure(path: Path, cache: Path) -> pd.DataFrame:
    """Track a trial by colour; return chance, share that is doubted and truth of each label."""
    trial = load_trial(path)
    tracks = tracked(trial, cache / f"{path.name}+colour.nc", evidence="colour")
    with open_views(trial) as views:
        width = max(reader.width for reader in views.readers.values())
    oracle = Oracle(trial, tracks, THRESHOLD_PX * width / REFERENCE_WIDTH_PX)
    off, chance = oracle.off(tracks), label_chances(tracks, clicks=clicks_of_tracks(tracks))
    origin = tracks["image_origin"].to_numpy()[..., 0]
    known = np.isfinite(off) & np.isfinite(chance)
    known &= ~np.isin(origin, [ORIGIN_CODE[w] for w in ("missing", "reprojected", "edited")])
    wrong = 1.0 - chance
    return pd.DataFrame({
        "trial": path.name, "verdict": wrong[known], "wrong": off[known] > oracle.limit_px,
        "odds": logit(np.clip(wrong[known], LEAST_CHANCE, 1 - LEAST_CHANCE)),
        "doubted": float((wrong[known] > 0.5).mean()), "anew": calibrated_anew(wrong, known)[known],
    })  # fmt: skip


def learn(labels: pd.DataFrame) -> tuple[float, float, float]:
    """Return the offset, and the slopes on log-odds and on the share that is doubted."""
    x = np.column_stack([np.ones(len(labels)), labels["odds"], labels["doubted"]])
    y = labels["wrong"].to_numpy(float)
    weight = 1.0 / labels.groupby("trial")["wrong"].transform("size").to_numpy()
    scale = np.array([1.0, 1.0, 10.0])  # a share of a tenth is much

    def cost(b: np.ndarray) -> tuple[float, np.ndarray]:
        odds = x @ (scale * b)
        loss = weight @ (np.logaddexp(0, odds) - y * odds) + RIDGE * b[1:] @ b[1:]
        slope = scale * (x.T @ (weight * (expit(odds) - y)))
        return float(loss), slope + np.concatenate([[0.0], 2 * RIDGE * b[1:]])

    offset, slope, doubted = scale * minimize(cost, np.zeros(3), jac=True).x
    return float(offset), float(slope), float(doubted)


def report(title: str, labels: pd.DataFrame) -> None:
    """Print for each trial what the verdict states, what the package states now, and what is so."""
    print(f"{title}: trial, labels, stated by the verdict, stated, wrong")
    off = []
    for name, own in labels.groupby("trial"):
        was, now, wrong = own["verdict"].sum(), own["anew"].sum(), own["wrong"].sum()
        print(f"  {name}: {len(own)}, {was:.0f}, {now:.0f}, {wrong}")
        off.append([abs(was - wrong) / len(own), abs(now - wrong) / len(own)])
    was, now = 100 * np.mean(off, axis=0)
    n, total = len(labels), labels["wrong"].sum()
    print(f"  off by {was:.1f} labels in a hundred by the verdict, by {now:.1f} as stated")
    print(f"  all: {n}, {labels['verdict'].sum():.0f}, {labels['anew'].sum():.0f}, {total}")


if __name__ == "__main__":
    main()
