"""Learn how many errors what is measured of tracks foretells: the curves of `suspect_rates.py`.

Run it from the project's root, on scenes whose truth is known:

    python benchmarks/learn_suspects.py --trials my/a/trial.toml my/b/trial.toml
    python benchmarks/learn_suspects.py --render scenes --seeds 51 52 53 54 --clicked 0.5 0.99

Every scene is tracked, and its errors are counted by the rule of
:mod:`pawnb.workflow.evaluation.errors`. A row is a point in a frame; it is positive within an
error, and all rows of one error together weigh as much as one row without any, so that the rates
that are learnt count errors, not wrong frames. A logistic regression on linear splines (knots as in
`suspect_rates.py`) gives the curves, and goes on from those that stand there: errors are rare, and
what a few scenes do not tell stays as it was. Each scene is then judged by curves learnt from
scenes of other seeds: how many errors are found by looking at the first 2 % of the list
(:mod:`suspects` says how that is counted), and whether as many are found as the scores say. With
``--clicked`` each scene is tracked again from the truth of frames so far into it, which goes wrong
elsewhere: scenes are slow to render.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import log_odds
import numpy as np
import pandas as pd
from suspects import SHARES, count, found, most
from whole_accuracy import add_scene_arguments, clicks_at, scene_seed, silent, trials

from pawnb.core.rig import load_rig
from pawnb.core.suspects.rates import CURVES, INTERCEPT, WRONG_AROUND_FRAMES, choose_looks
from pawnb.core.suspects.uncertainty import collect_doubts
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.track import track

STEPS = 5.0
"""What it costs that steps between neighbouring knots change: smoothly, where little is known."""
SMALL = 1.0
"""What it costs that values change."""
LOST = 0.1
"""Recordings in which points are wrong in a larger share of frames are not learnt from: whoever
opens them sees it, and what was lost for long says nothing of how brief errors begin."""
SCORES = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8, np.inf)


@dataclass(frozen=True)
class Sample:
    """One tracked scene: n frames, P points."""

    name: str
    frames: np.ndarray
    measured: dict[str, np.ndarray]  # (n, P) each
    share: np.ndarray  # (n, P): of an error, 0 where all is right
    errors: pd.DataFrame


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_scene_arguments(parser)
    parser.add_argument("--clicked", type=float, nargs="*", default=[], metavar="SHARE",
                        help="also clicks so far into it (0 to 1), by the truth")  # fmt: skip
    parser.set_defaults(seeds=[51, 52, 53, 54, 55, 56, 57, 58], vary=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = list(trials(arguments, arguments.render or Path(folder)))
        samples = [
            sample(load_trial(path), clicked=clicked)
            for path in paths for clicked in (None, *arguments.clicked)
        ]  # fmt: skip
    report(samples)
    intercept, curves = learn(samples)
    print(f"\nINTERCEPT = {intercept:.2f}")
    log_odds.print_curves(curves, CURVES, decimals=2)


def sample(trial: Trial, *, clicked: float | None = None) -> Sample:
    """Track a scene, measure the tracks, and tell by its truth where they are wrong."""
    start, name = None, trial.folder.name
    if clicked is not None:
        truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
        start, name = clicks_at(trial, truth, clicked), f"{name} clicked {clicked:g}"
    tracks = track(trial, start=start, progress=silent)
    doubts = collect_doubts(tracks, rig=load_rig(trial), other=None, paw_px=None)
    frames = tracks["frame"].to_numpy()
    points = tracks["keypoint"].to_numpy().tolist()
    errors = count(trial, tracks)
    share = np.zeros((len(frames), len(points)))
    for error in errors.itertuples():
        rows = (frames >= error.first_frame) & (frames <= error.last_frame)
        share[rows, points.index(error.point)] = 1.0 / rows.sum()
    measured = {name: one for doubt in doubts for name, one in doubt.measures.items()}
    return Sample(name, frames, measured, share, errors)


def learn(samples: Sequence[Sample]) -> tuple[float, dict[str, np.ndarray]]:
    """Fit intercept and curves; each curve is 0 on average."""
    samples = [one for one in samples if (one.share > 0).mean() <= LOST] or samples
    X = np.concatenate([design(one) for one in samples])
    share = np.concatenate([one.share.ravel() for one in samples])
    middle = np.concatenate([[0.0], X[:, 1:].mean(axis=0)])
    bad = share > 0
    before = np.concatenate([[INTERCEPT], *(values for _, values in CURVES.values())])
    b = log_odds.fit(
        X, bad.astype(float), np.where(bad, share, 1.0), ridge=ridge(), before=before
    )  # fmt: skip
    curves = log_odds.split(b[1:], CURVES)
    for name, weights in log_odds.split(middle[1:], CURVES).items():
        usual = float(weights @ curves[name] / weights.sum())
        curves[name] = curves[name] - usual
        b[0] += usual
    return float(b[0]), curves


def design(one: Sample) -> np.ndarray:
    """Return the rows of a scene: 1, and what each knot weighs."""
    measured = {name: values.ravel() for name, values in one.measured.items()}
    return np.column_stack([np.ones(one.share.size), log_odds.design(measured, CURVES)])


def ridge() -> np.ndarray:
    """Return what it costs that values at the knots change."""
    sizes = [len(knots) for knots, _ in CURVES.values()]
    cost = np.zeros((1 + sum(sizes), 1 + sum(sizes)))
    begin = 1
    for size in sizes:
        steps = np.diff(np.eye(size), axis=0)
        part = slice(begin, begin + size)
        cost[part, part] = STEPS * steps.T @ steps + SMALL * np.eye(size)
        begin += size
    cost[0, 0] = 1e-6
    return cost


def report(samples: Sequence[Sample]) -> None:
    """Print what curves from scenes of other seeds find in each scene."""
    looks = {}
    for own in sorted({scene_seed(one.name) for one in samples}):
        rest = [other for other in samples if scene_seed(other.name) != own]
        if rest:
            learnt = learn(rest)
            same = [one for one in samples if scene_seed(one.name) == own]
            looks |= {one.name: (one, judge(one, *learnt)) for one in same}
    if not looks:
        return
    n_errors = sum(len(one.errors) for one, _ in looks.values())
    for share in SHARES:
        each = limit = together = 0
        least = score_of_share([(one.frames, list_) for one, list_ in looks.values()], share)
        for one, list_ in looks.values():
            k = max(1, round(share * len(one.frames)))
            each += found([frame for frame, _ in list_[:k]], one.errors)
            limit += most(one.frames, one.errors, k)
            together += found([frame for frame, score in list_ if score >= least], one.errors)
        print(f"{share:.0%} of each scene: {each} of {n_errors} errors found (at most {limit}); "
              f"of all scenes together: {together}")  # fmt: skip
    calibration([(score, new) for one, list_ in looks.values() for score, new in news(one, list_)])


def judge(one: Sample, intercept: float, curves: dict[str, np.ndarray]) -> list[tuple[int, float]]:
    """Return the frames to look at and their scores."""
    odds = design(one) @ np.concatenate([[intercept], *curves.values()])
    rates = 1.0 / (1.0 + np.exp(-odds.reshape(one.share.shape)))
    looks = choose_looks(rates, one.frames, around=WRONG_AROUND_FRAMES, least=SCORES[0])
    return [(int(one.frames[t]), score) for t, score, *_ in looks]


def score_of_share(lists: list[tuple[np.ndarray, list[tuple[int, float]]]], share: float) -> float:
    """Return the score of the last frame when a share of all frames is looked at."""
    scores = sorted((score for _, list_ in lists for _, score in list_), reverse=True)
    k = max(1, round(share * sum(len(frames) for frames, _ in lists)))
    return scores[min(k, len(scores)) - 1]


def news(one: Sample, looks: list[tuple[int, float]]) -> list[tuple[float, int]]:
    """Return score and errors found by each look that earlier ones have not found."""
    left, told = one.errors, []
    for frame, score in looks:
        near = (left["first_frame"] - WRONG_AROUND_FRAMES <= frame) & (
            frame <= left["last_frame"] + WRONG_AROUND_FRAMES
        )
        told.append((score, int(near.sum())))
        left = left[~near]
    return told


def calibration(looks: list[tuple[float, int]]) -> None:
    """Print how many errors looks of alike scores find."""
    print("score               looks   mean score   errors found a look")
    for low, high in pairwise(SCORES):
        here = [(score, new) for score, new in looks if low <= score < high]
        if here:
            mean, new = np.mean(here, axis=0)
            print(f"{low:5.2f} to {high:5.2f} {len(here):10d} {mean:12.3f} {new:12.3f}")


if __name__ == "__main__":
    main()
