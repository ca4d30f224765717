"""What becomes of paws that the pictures do not show for a while: detections are taken away.

Run it from the project's root:

    python benchmarks/unseen_paws.py --render scenes --vary --seeds 41 42 --films covered-lift-off

Rendered scenes are tracked by colour. Then what was detected is thinned out, and decided on again:
every detection is left out with a chance (``--left-out``), or a paw is not seen by any camera from
a frame before it lifts off (``--lift-off`` frames long; all paws). Printed are, for each way, how
many of 1000 visible labels are wrong, and in how many frames a point lies within a paw width of
where another is in truth, and more than two and a half from where it is itself.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
from whole_accuracy import REFERENCE_WIDTH_PX, add_scene_arguments, silent, trials

from pawnb.core.parameters import parameters_set, read_parameters
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.treadmill import tracker
from pawnb.core.paws.offline.treadmill.output import as_tracks, empty_result
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.errors import THRESHOLD_PX, count_errors
from pawnb.workflow.tracking.track import track

Seen = list[list[ColourDetections]]
BEFORE = 1
"""Frames before it lifts off in which a paw is not seen any more."""
OWN_WIDTHS, TAKEN_WIDTHS, AWAY_WIDTHS = 1.5, 1.0, 2.5
"""Paw widths: a detection so near to a paw is its own; a point is on another's place, and is away
from its own."""


@dataclass(frozen=True)
class Recording:
    """A scene, what was detected in it, and the truth; n frames, P points, V views."""

    trial: Trial
    asked: dict[str, Any]  # what the decision is given besides the detections
    seen: Seen
    uv: np.ndarray  # (n, V, P, 2)
    x: np.ndarray  # (n, P, 3)

    @property
    def points(self) -> list[str]:
        """Names of the points."""
        return list(self.asked["asked"].layout.points)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_scene_arguments(parser)
    parser.add_argument("--left-out", type=float, nargs="*", default=[0.2, 0.3], metavar="SHARE")
    parser.add_argument("--lift-off", type=int, nargs="*", default=[5, 10], metavar="FRAMES")
    parser.add_argument("--set", nargs="*", default=[], metavar="STAGE.NAME=VALUE",
                        help="parameters of stages, for the decision on what is left")  # fmt: skip
    parser.add_argument("--draws", type=int, default=1, help="of what is left out (%(default)s)")
    arguments = parser.parse_args()
    ways: dict[str, Callable[[Recording, int], Seen]] = {"all are seen": as_they_are}
    for share in arguments.left_out:
        ways[f"{share:.0%} left out"] = partial(thinned, share=share)
    for frames in arguments.lift_off:
        ways[f"{frames} frames at lift-off"] = partial(unseen_at_lift_off, frames=frames)
    values = dict(word.split("=", 1) for word in arguments.set)
    set_ = read_parameters(values, ["gap_closing", "smoothing", "stride"], where="--set")
    with tempfile.TemporaryDirectory() as folder, parameters_set(set_):
        paths = trials(arguments, arguments.render or Path(folder))
        rows = [row for path in paths for row in judge(record(load_trial(path)), ways, arguments)]
    table = pd.DataFrame(rows).groupby("way", sort=False).sum(numeric_only=True)
    for way, row in table.iterrows():
        print(f"{way:24s} wrong of 1000: {1000 * row['wrong'] / row['labels']:5.1f}; "
              f"frames on another's place: {row['taken']:.0f} of {row['frames']:.0f}")  # fmt: skip


def record(trial: Trial) -> Recording:
    """Track a scene by colour and keep what the decision was given."""
    given: dict[str, Any] = {}

    def solve(seen: Any, scene: Any, asked: Any, **more: Any) -> SmoothedTracks:
        given.update(seen=seen, scene=scene, asked=asked, **more)
        return decide(seen, scene, asked, **more)

    decide = tracker.solve
    with mock.patch.object(tracker, "solve", solve):
        track(trial, settings={"evidence": "colour"}, progress=silent)
    seen, layout = given.pop("seen"), given["asked"].layout
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv").set_index(["frame", "view", "point"])
    index = pd.MultiIndex.from_product([range(len(seen)), layout.views, layout.points])
    uv = truth.loc[index, ["u", "v"]].to_numpy()
    space = pd.read_csv(trial.folder / "truth" / "points3d.csv").set_index(["frame", "point"])
    x = space.loc[pd.MultiIndex.from_product([range(len(seen)), layout.points]), ["x", "y", "z"]]
    shape = (len(seen), len(layout.views), len(layout.points), 2)
    return Recording(
        trial, given, seen, uv.reshape(shape), x.to_numpy().reshape(len(seen), -1, 3)
    )  # fmt: skip


def as_they_are(recording: Recording, _seed: int) -> Seen:
    """Leave out nothing."""
    return recording.seen


def thinned(recording: Recording, seed: int, *, share: float) -> Seen:
    """Leave out a share of all detections, but for those of clicked frames."""
    rng = np.random.default_rng(seed)
    clicked = set(recording.asked["asked"].clicks)
    return [
        [one if t in clicked else one.take(rng.random(len(one)) >= share) for one in here]
        for t, here in enumerate(recording.seen)
    ]


def unseen_at_lift_off(recording: Recording, _seed: int, *, frames: int) -> Seen:
    """Leave out what is nearest to each paw about its lift-off."""
    seen = [list(here) for here in recording.seen]
    events = pd.read_csv(recording.trial.folder / "truth" / "events.csv")
    width = OWN_WIDTHS * recording.asked["scene"].paw_width_px
    lifts = events[events["event"] == "LO"]
    for leg, at in zip(lifts["leg"].tolist(), lifts["frame"].tolist(), strict=True):
        p, begin = recording.points.index(leg), round(at) - BEFORE
        for t in range(max(1, begin), min(len(seen), begin + frames)):
            for v, found in enumerate(seen[t]):
                away = np.linalg.norm(found.uv[:, None] - recording.uv[t, v], axis=-1)
                own = (away[:, p] < width[v]) & (away.argmin(axis=1) == p)
                seen[t][v] = found.take(~own)
    return seen


def judge(
    recording: Recording,
    ways: dict[str, Callable[[Recording, int], Seen]],
    arguments: argparse.Namespace,
) -> list[dict[str, Any]]:
    """Decide on detections that were thinned out in each way, and count what is wrong."""
    rows = []
    for way, leave_out in ways.items():
        for draw in range(arguments.draws):
            found = tracker.solve(leave_out(recording, draw), **recording.asked)
            rows.append({"way": way, **count(recording, found)})
    return rows


def count(recording: Recording, found: SmoothedTracks) -> dict[str, float]:
    """Compare tracks with the truth."""
    asked, n = recording.asked["asked"], len(recording.seen)
    every = np.ones(len(recording.points), bool)
    result = empty_result(n, asked.layout).with_points(every, found)
    tracks = as_tracks(result, asked.layout, recording.asked["task"], placed=asked.inside(n))
    width = max(size[0] for size in asked.layout.sizes)
    report = count_errors(
        tracks,
        pd.read_csv(recording.trial.folder / "truth" / "tracks.csv"),
        threshold_px=THRESHOLD_PX * width / REFERENCE_WIDTH_PX,
        points_by_view={view.name: view.points for view in recording.trial.views if view.points},
    )
    away = np.linalg.norm(found.x[:, :, None] - recording.x[:, None], axis=-1)
    away /= recording.asked["scene"].paw_width
    own = np.arange(len(recording.points))
    off = away[:, own, own].copy()
    away[:, own, own] = np.inf
    taken = (away.min(axis=2) < TAKEN_WIDTHS) & (off > AWAY_WIDTHS)
    return {
        "wrong": report.share_wrong * report.n_labels, "labels": report.n_labels,
        "taken": int(taken.sum()), "frames": taken.size,
    }  # fmt: skip


if __name__ == "__main__":
    main()
