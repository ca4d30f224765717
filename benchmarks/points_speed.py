"""Time of tracking by learnt evidence: a run, a correction, and a click that is added.

Run it from the project's root:

    python benchmarks/points_speed.py --frames 300 --scale 1      # four grey views of 2048 x 700
    python benchmarks/points_speed.py --trial my/trial.toml

*all kinds* is the whole of a first run with motion, appearance and correlation, against decoding
the same frames (as in tracking_speed.py). *again after a correction* is :func:`pawnb.retrack` of a
point that was put in place by hand, ``--again`` frames before its next click. *a click added* is a
whole run with clicks in one frame more. Both find pictures and flow kept in the session. Clicks
that are added are where the first run put the points: that is enough to take time.

The clock tells what a person waits for; where other programs run, processor time tells more.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from tracking_speed import decode

from pawnb.core.edits.log import EditLog, Move, Retrack
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.io.start import read_start
from pawnb.schema import Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.placed import clicks_of_frame
from pawnb.workflow.tracking.track import retrack, track

LEARNT = {"evidence": "learnt"}


class Took(NamedTuple):
    """Seconds by the clock, and of processor time."""

    clock: float
    cpu: float

    def __str__(self) -> str:
        return f"{self.clock:.2f} s ({self.cpu:.2f} s of processor time)"


def timed(work: Callable[[], Tracks | None]) -> tuple[Tracks | None, Took]:
    """Return what some work gives, and how long it took."""
    clock, cpu = time.perf_counter(), time.process_time()
    given = work()
    return given, Took(time.perf_counter() - clock, time.process_time() - cpu)


def quiet(_done: int, _total: int) -> None:
    """No bar."""


def measure(trial: Trial, n_frames: int, n_again: int) -> None:
    """Print the three figures of one trial."""
    file = trial.start_file()
    if file is None:
        raise SystemExit(f"trial {trial.name!r} has no start points.")
    start = read_start(trial.path(file), trial)
    clicked = int(start["frame"].iloc[0])
    with open_views(trial) as views:
        first, last = trial.frames or (0, views.n_frames)
    begin = max(first, min(clicked, last - n_frames))
    frames = (begin, min(last, begin + n_frames))
    n = frames[1] - frames[0]

    def run(clicks: pd.DataFrame) -> Tracks:
        return track(trial, start=clicks, frames=frames, settings=LEARNT, progress=quiet)

    _, decoding = timed(lambda: decode(trial, frames[1]))
    tracks, took = timed(lambda: run(start))
    per_frame = [decoding.clock / frames[1], decoding.cpu / frames[1]]
    ratios = [took.clock / n / per_frame[0], took.cpu / n / per_frame[1]]
    print(f"{trial.name}: {len(trial.views)} views, {n} frames, clicks in frame {clicked}")
    print(f"  decoding: {1000 * per_frame[0]:.1f} ms a frame of all views")
    print(f"  all kinds: {took}, {ratios[0]:.1f} x decoding ({ratios[1]:.1f} x by processor time)")
    assert tracks is not None  # noqa: S101 (what a run gives)
    corrected = min(clicked + n_again // 2, frames[1] - 2)
    after = min(corrected + n_again - 1, frames[1] - 1)
    more = pd.concat([start, clicks_of_frame(trial, tracks, after)])
    tracks, took = timed(lambda: run(more))
    print(f"  a click added, until shown, {n} frames: {took}")
    assert tracks is not None  # noqa: S101
    at = clicks_of_frame(trial, tracks, corrected).iloc[0]
    log = EditLog(
        tracks, rig=load_rig(trial),
        retrack=lambda t, f, **given: retrack(trial, t, f, progress=quiet, **given),
    )  # fmt: skip
    place = {"u": float(at["u"]) + 2.0, "v": float(at["v"])}
    log.apply(Move(frame=corrected, view=at["view"], point=at["point"], **place))
    _, took = timed(lambda: log.apply(Retrack(frame=corrected)))
    print(f"  again after a correction, {after + 1 - corrected} frames: {took}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--trial", type=Path, help="a trial to use instead of rendering one")
    parser.add_argument("--frames", type=int, default=300, help="frames to use (%(default)s)")
    parser.add_argument("--again", type=int, default=100, help="tracked again (%(default)s)")
    parser.add_argument("--scale", type=float, default=1.0, help="of 2048 x 700 (%(default)s)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = options.trial or render_mouse_trial(
            folder, frames=options.frames, scale=options.scale, variants=("grey",)
        )
        measure(load_trial(path), options.frames, options.again)


if __name__ == "__main__":
    main()
