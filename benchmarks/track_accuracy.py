"""How well the paw tracker tracks: a synthetic scene with exact truth, and a real mouse.

Run it from the project's root:

    python benchmarks/track_accuracy.py --frames 300 --scale 0.5
    python benchmarks/track_accuracy.py --trial my/trial.toml      # with truth/tracks.csv

The rule for major and minor errors is written out in pawnb/workflow/evaluation/errors.py. The
real clip is ``mouse-side-bottom`` in the folder named by PAWNB_TEST_DATA (default:
../shared/data); it is skipped where it is absent.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from real_clip import clip_folder, read_marks, real_clip

from pawnb.core.video import open_views
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.evaluation.corrected_run import track_with_corrections
from pawnb.workflow.evaluation.errors import THRESHOLD_PX, ErrorReport, count_errors
from pawnb.workflow.tracking.methods import PAW_METHODS
from pawnb.workflow.tracking.track import retrack, track

REFERENCE_WIDTH_PX = 2048

CLIP_SETTINGS = {
    # of the 2019 method; method pawnb takes its sizes from the clicks
    # the paws move up to about 22 px a frame, 30 px in the paper's pictures
    "scale": 0.75,
    # the smallest paw covers about 50 px here; a median filter of 3 px
    "min_paw_area_px": 90.0,
    "median_px": 4.0,
}
NEAR_PX = 12.0


def silent(done: int, total: int) -> None:
    """Show no progress."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trial", type=Path, help="a trial with truth/tracks.csv beside it")
    parser.add_argument("--frames", type=int, default=300, help="frames to render (%(default)s)")
    parser.add_argument("--scale", type=float, default=0.5, help="of 2048 x 700 (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the scene (%(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE",
                        help="a setting of the tracker")  # fmt: skip
    parser.add_argument(
        "--method", default=PAW_METHODS[0], choices=PAW_METHODS, help="(%(default)s)"
    )
    parser.add_argument("--corrections", action="store_true",
                        help="also count interventions (tracks again after each)")  # fmt: skip
    arguments = parser.parse_args()
    settings = dict(item.split("=", 1) for item in arguments.set)
    with tempfile.TemporaryDirectory() as folder:
        path = arguments.trial or render_mouse_trial(
            folder, frames=arguments.frames, scale=arguments.scale, seed=arguments.seed
        )
        report_scene(
            load_trial(path), arguments.method, settings, corrections=arguments.corrections
        )
    report_clip(arguments.method, settings)


def report_scene(trial: Trial, method: str, settings: dict[str, str], *, corrections: bool) -> None:
    """Track a trial with exact truth and print its errors."""
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    with open_views(trial) as views:
        width = views.readers[views.names[0]].width
    threshold = THRESHOLD_PX * width / REFERENCE_WIDTH_PX
    points = {view.name: view.points for view in trial.views if view.points}
    limits = {"points_by_view": points or None, "threshold_px": threshold}
    tracks = track(trial, method=method, settings=settings, progress=silent)
    print(f"{trial.name}: method {method}, {width} px wide, wrong beyond {threshold:g} px")
    print_report(count_errors(tracks, truth, hidden_px=threshold / 2, **limits))
    if corrections:
        run = track_with_corrections(
            tracks, truth, lambda t, frame: retrack(trial, t, frame, progress=silent), **limits
        )
        print(f"  corrected: {len(run.interventions)} interventions, "
              f"{run.interventions_per_1000:.1f} per 1000 frames of all views; then")  # fmt: skip
        print_report(count_errors(run.tracks, truth, hidden_px=threshold / 2, **limits))


def print_report(report: ErrorReport) -> None:
    """Print an error report."""
    print(
        f"  {report.n_frames} frames of all views, {report.n_labels} visible labels\n"
        f"  major errors {report.major} ({report.major_per_1000:.1f} per 1000 frames), "
        f"minor {report.minor} ({report.minor_per_1000:.1f} per 1000)\n"
        f"  labels wrong {100 * report.share_wrong:.1f} %, without position "
        f"{100 * report.share_missing:.1f} %\n"
        f"  distance px: median {report.median_px:.1f}, 95th percentile {report.p95_px:.1f}; "
        f"constant offsets removed: {report.median_px_centred:.1f}, {report.p95_px_centred:.1f}\n"
        f"  hidden labels within {report.hidden_px:g} px: "
        f"{100 * report.share_hidden_bridged:.1f} % of {report.n_hidden}"
    )


def report_clip(method: str, settings: dict[str, str]) -> None:
    """Track the real clip from its hand-marked first frame and compare later marks."""
    folder = clip_folder()
    if not folder.exists():
        print(f"real clip: not in {folder.parent} (set PAWNB_TEST_DATA)")
        return
    marks = read_marks(folder / "manual_paws.csv")
    chosen = {**({} if method == "pawnb" else CLIP_SETTINGS), **settings}
    tracks = track(
        real_clip(folder),
        method=method,
        settings=chosen,
        start=marks[marks["frame"] == 0],
        progress=silent,
    )
    print(
        f"real clip {folder.name}: method {method}, {tracks.sizes['time']} frames, settings "
        f"{json.dumps(chosen)}"
    )
    for (frame, view), rows in marks[marks["frame"] > 0].groupby(["frame", "view"]):
        away = {row.point: distance(tracks, row) for row in rows.itertuples(index=False)}
        near = sum(px <= NEAR_PX for px in away.values())
        each = ", ".join(f"{point} {px:.0f}" for point, px in away.items())
        print(f"  frame {frame} {view}: {near} of {len(away)} within {NEAR_PX:g} px ({each})")


def distance(tracks: Tracks, mark: tuple) -> float:
    """Return the distance of a mark from the tracked position, px."""
    rows = tracks["frame"].to_numpy() == mark.frame
    found = tracks["image_position"].sel(view=mark.view, keypoint=mark.point)[rows, :, 0]
    return float(np.linalg.norm(found.to_numpy()[0] - [mark.u, mark.v]))


if __name__ == "__main__":
    main()
