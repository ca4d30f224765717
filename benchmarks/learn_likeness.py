"""Learn what paws look like among candidates: the curves of `whole/likeness.py`.

Run it from the project's root, on scenes whose truth is known:

    python benchmarks/learn_likeness.py --trials my/a/trial.toml my/b/trial.toml
    python benchmarks/learn_likeness.py --render scenes --seeds 51 52 53 54

Candidates of every scene are found as the tracker finds them. A candidate is a paw if a paw
of which more than 30 % is seen is within 0.6 of the limit of a wrong label (20 px in a picture
2048 px wide), and none if no paw, seen or hidden, is within 1.2 of it; those between are left
out. A logistic regression on linear splines (knots as in `whole/likeness.py`) gives the
curves. Every scene weighs the same. Each scene is then judged by curves learnt from
scenes of other seeds: the chance that a paw is ranked above another candidate (area under
the curve), for the plain rule, for the curves and for the geometric mean of both that is used.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import log_odds
import numpy as np
import pandas as pd
from scipy.stats import rankdata
from whole_accuracy import add_scene_arguments, scene_seed, trials

from pawnb.core.paws.layout import make_layout, read_start
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
    measures,
    score_at_clicks,
)
from pawnb.core.paws.offline.detection.colour.likelihood import curves as own_curves
from pawnb.core.paws.offline.detection.colour.scan import scan_video
from pawnb.core.paws.offline.scene.treadmill import read_scene
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.video import open_views
from pawnb.io.start import read_start as read_clicks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.errors import THRESHOLD_PX
from pawnb.workflow.tracking.trial_views import points_by_view, trial_rig, view_facing

REFERENCE_WIDTH_PX = 2048
VISIBLE_FROM = 0.3
PAW, NO_PAW = 0.6, 1.2
"""Shares of the limit of a wrong label."""
CURVES = own_curves()
"""Those of the package: their knots stay."""
EVERY = 3
"""Frames are alike: every third is enough."""
RIDGE = 1.0
"""Weight of small values, where a scene weighs a thousand."""


@dataclass(frozen=True)
class Sample:
    """Candidates of one scene: whether each is a paw, its measures, and the plain rule's word."""

    name: str
    is_paw: np.ndarray
    measured: dict[str, np.ndarray]
    plain: np.ndarray


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_scene_arguments(parser)
    parser.set_defaults(seeds=[51, 52, 53, 54], vary=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = list(trials(arguments, arguments.render or Path(folder)))
        samples = [one for one in map(sample, map(load_trial, paths)) if one is not None]
    report(samples)
    print(f"\nlearnt from {len(samples)} scenes:")
    log_odds.print_curves(learn(samples), CURVES, decimals=1)


def sample(trial: Trial) -> Sample | None:
    """Find the candidates of a trial and tell by its truth which are paws."""
    clicks = read_clicks(trial.folder / "start.csv", trial)
    with open_views(trial) as views:
        sizes = {name: (r.width, r.height) for name, r in views.readers.items()}
        rig = trial_rig(trial, views)
        task = TrackingRequest(
            frames=(0, views.n_frames), fps=trial.fps, rig=rig,
            points_by_view=points_by_view(trial, clicks), facing=view_facing(trial, rig),
        )  # fmt: skip
        layout = make_layout(views, clicks, task, settings=Maghsoudi2019Settings())
        placed = read_start(clicks, layout, task.frames)
        scene = read_scene(views, layout, placed, anchors=placed, settings=OfflineSettings())
        found = scan_video(
            views, task.frames, detectors=scene.detectors, rois=scene.rois, home=scene.home
        )
    uv = np.full((1, len(layout.points), len(layout.views), 2), np.nan)
    first = min(placed)
    for place in placed[first]:
        uv[0, place.point, place.view] = place.uv
    likelihood = AppearanceLikelihood(scene.limb_direction, scene.paw_width_px)
    score = score_at_clicks(uv, {first: found[first]}, likelihood)
    if score is None or scene.geometry.from_below.any():
        return None
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv").groupby(["frame", "view"])
    limit = THRESHOLD_PX * max(width for width, _ in sizes.values()) / REFERENCE_WIDTH_PX
    is_paw, measured, plain = [], [], []
    for t in range(0, len(found), EVERY):
        for v, name in enumerate(layout.views):
            here, rows = truth.get_group((t, name)), found[t][v]
            if not len(rows):
                continue
            away = np.linalg.norm(rows.uv[:, None] - here[["u", "v"]].to_numpy(), axis=-1)
            seen = here["visible_fraction"].to_numpy() > VISIBLE_FROM
            paw = np.where(seen, away, np.inf).min(axis=1) < PAW * limit
            keep = paw | (away.min(axis=1) > NO_PAW * limit)
            is_paw.append(paw[keep])
            plain.append(endpoint_score(rows.take(keep), scene.limb_direction[v]))
            measured.append(measures(rows.take(keep), scene.limb_direction[v], score=score,
                                     paw_width_px=scene.paw_width_px[v]))  # fmt: skip
    return Sample(
        trial.folder.name, np.concatenate(is_paw),
        {name: np.concatenate([one[name] for one in measured]) for name in CURVES},
        np.concatenate(plain),
    )  # fmt: skip


def learn(samples: list[Sample]) -> dict[str, np.ndarray]:
    """Fit the curves."""
    X = np.concatenate([log_odds.design(one.measured, CURVES) for one in samples])
    y = np.concatenate([one.is_paw for one in samples]).astype(float)
    weight = np.concatenate([np.full(len(s.is_paw), 1000.0 / len(s.is_paw)) for s in samples])
    values = log_odds.fit(X, y, weight, ridge=RIDGE * np.eye(X.shape[1]))
    return log_odds.split(values, CURVES)


def report(samples: list[Sample]) -> None:
    """Print how well each scene's paws are told by curves from scenes of other seeds."""
    print("scene                     candidates   plain rule   curves   both")
    learnt: dict[str, dict[str, np.ndarray]] = {}
    for one in samples:
        own = scene_seed(one.name)
        rest = [other for other in samples if scene_seed(other.name) != own]
        if not rest:
            continue
        if own not in learnt:
            learnt[own] = learn(rest)
        curves = learnt[own]
        odds = sum(np.interp(one.measured[k], CURVES[k][0], v) for k, v in curves.items())
        both = one.plain / (1.0 + np.exp(-odds))
        areas = [area(one.is_paw, value) for value in (one.plain, odds, both)]
        print(f"{one.name:25s} {len(one.is_paw):10d} " + "".join(f"{a:10.3f}" for a in areas))


def area(is_paw: np.ndarray, value: np.ndarray) -> float:
    """Return the chance that a paw has a higher value than another candidate."""
    rank = rankdata(value)
    hits, misses = int(is_paw.sum()), int((~is_paw).sum())
    return float((rank[is_paw].sum() - hits * (hits + 1) / 2) / (hits * misses))


if __name__ == "__main__":
    main()
