"""Time of tracking by learnt evidence: a run, a correction, and a click that is added.

Run it from the project's root:

    python benchmarks/points_speed.py --frames 300 --scale 1      # four grey views of 2048 x 700
    python benchmarks/points_speed.py --clip mouse_below_grey     # of the real clips
    python benchmarks/points_speed.py --trial my/trial.toml
    python benchmarks/points_speed.py --evidence strides          # calibrated views, strides known
    python benchmarks/points_speed.py --out docs/accuracy/speed.csv    # and put it into this table

*all kinds* is the whole of a first run with motion, appearance and correlation, against decoding
the same frames (as in tracking_speed.py). *again after a correction* is :func:`pawnb.retrack` of a
point that was put in place by hand, ``--again`` frames before its next click. *a click added* is
:func:`pawnb.track` (``quick=True``) with clicks in one frame more: they are the marks of
``marks.csv`` beside the trial in the marked frame that is nearest, else where the first run put the
points, which is enough to take time. Both go on from what the run before has learnt, with the
pictures and flow kept in the session where these show the new clicks; *read anew* is said where
nothing of that run serves. By colour and strides all frames are decided upon again, but none is
decoded; a click that is added there is a first run.

The clock tells what a person waits for; where other programs run, processor time tells more.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from real_clip_marks import clips_folder
from tracking_speed import decode

from pawnb.core.edits.log import EditLog, Move, Retrack
from pawnb.core.paws.offline.reuse.kept_evidence import GONE_ON_FROM
from pawnb.core.paws.offline.reuse.retracking import after_correction
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.io.start import read_start
from pawnb.schema import START_COLUMNS, Tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking.placed import clicks_of_frame
from pawnb.workflow.tracking.track import retrack, track

FOUND_BY = {
    "learnt": "what is learnt in the recording",
    "strides": "strides and a look that is learnt",
    "colour": "their colour, strides and stance",
}


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


class Measured(NamedTuple):
    """What was measured on a trial; ms are processor times of a frame of all views."""

    trial: Trial
    frames: int
    evidence: str
    decoding_ms: float
    run_ms: float
    added: Took | None
    gone_on: bool
    again: Took
    frames_again: int

    @property
    def ratio(self) -> float:
        """Processor time of a first run over that of decoding."""
        return self.run_ms / self.decoding_ms

    def row(self, command: str) -> dict[str, str]:
        """Return a row of docs/accuracy/speed.csv."""
        with open_views(self.trial) as views:
            sizes = {f"{r.width} x {r.height}" for r in views.readers.values()}
        n, anew = len(self.trial.views), "" if self.gone_on else " (pictures were read anew)"
        what = (
            f"time, {n} {'view' if n == 1 else 'views'} of {', '.join(sorted(sizes))} px "
            f"({self.trial.name}), {self.frames} frames, points found by {FOUND_BY[self.evidence]} "
            f"(`evidence = {self.evidence}`)"
        )
        added = self.added and (
            f"With a click added (`quick=True`), until points are shown: {self.added.cpu:.1f} s "
            f"of processor time{anew}. "
        )
        result = (
            f"{self.ratio:.3g} times what decoding alone takes, by processor time "
            f"({self.run_ms:.0f} ms a frame of all views, decoding {self.decoding_ms:.1f}). "
            f"{added or ''}Tracked again after a correction, {self.frames_again} "
            f"frames: {self.again.cpu:.1f} s of processor time"
        )
        return {"what": what, "result": result, "command": f"`{command}`"}


def further_clicks(trial: Trial, tracks: Tracks, start: pd.DataFrame, frame: int) -> pd.DataFrame:
    """Return clicks in a further frame near one: marks, or where the points were found."""
    marked = trial.folder / "marks.csv"
    if not marked.exists():
        return clicks_of_frame(trial, tracks, frame)
    marks = pd.read_csv(marked).query("visible == 1")
    marks = marks[marks["frame"].isin(tracks["frame"].to_numpy())]
    left = np.array(sorted(set(marks["frame"]) - set(start["frame"])))
    nearest = left[np.abs(left - frame).argmin()]
    return marks.loc[marks["frame"] == nearest, list(START_COLUMNS)]


def measure(trial: Trial, n_frames: int, n_again: int, evidence: str) -> Measured:
    """Return what was measured on one trial, and print it."""
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

    def run(clicks: pd.DataFrame, *, quick: bool = False) -> Tracks:
        return track(
            trial, start=clicks, frames=frames, settings={"evidence": evidence}, quick=quick,
            progress=quiet,
        )  # fmt: skip

    _, decoding = timed(lambda: decode(trial, frames[1]))
    tracks, took = timed(lambda: run(start))
    print(f"{trial.name}: {len(trial.views)} views, {n} frames, clicks in frame {clicked}")
    print(f"  decoding: {1000 * decoding.clock / frames[1]:.1f} ms a frame of all views")
    print(f"  {evidence}: {took}, {took.cpu / n / (decoding.cpu / frames[1]):.1f} x decoding by "
          "processor time")  # fmt: skip
    assert tracks is not None  # noqa: S101 (what a run gives)
    corrected = min(clicked + 1, frames[1] - 2)
    after = min(corrected + n_again - 1, frames[1] - 1)
    more = pd.concat([start, further_clicks(trial, tracks, start, after)])
    added, gone_on = None, True
    if evidence == "learnt":
        tracks, added = timed(lambda: run(more, quick=True))
        assert tracks is not None  # noqa: S101
        gone_on = GONE_ON_FROM in provenance_steps(tracks)[-1]
        print(f"  a click added in frame {more['frame'].iloc[-1]}, until shown, {n} frames: {added}"
              f"{'' if gone_on else ', read anew'}")  # fmt: skip
    found = clicks_of_frame(trial, tracks, corrected)
    at = found[found["point"].isin(more["point"].iloc[len(start) :])].iloc[0]
    log = EditLog(
        tracks, rig=load_rig(trial),
        retrack=lambda t, f, **given: retrack(trial, t, f, progress=quiet, **given),
    )  # fmt: skip
    place = {"u": float(at["u"]) + 2.0, "v": float(at["v"])}
    log.apply(Move(frame=corrected, view=at["view"], point=at["point"], **place))
    if evidence == "learnt":
        n_again = len(range(*after_correction(log.tracks, corrected, [at["point"]]).frames))
    else:
        n_again = n
    _, again = timed(lambda: log.apply(Retrack(frame=corrected)))
    print(f"  again after a correction, {n_again} frames: {again}")
    per_frame = 1000 * decoding.cpu / frames[1], 1000 * took.cpu / n
    return Measured(trial, n, evidence, *per_frame, added, gone_on, again, n_again)


def put_into(path: Path, row: dict[str, str]) -> None:
    """Put a row into a table, in the place of that of the same command; the others stay."""
    table = pd.read_csv(path)
    here = table.index[table["command"] == row["command"]]
    table.loc[here[0] if len(here) else len(table)] = row
    table.to_csv(path, index=False)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--trial", type=Path, help="a trial to use instead of rendering one")
    parser.add_argument("--clip", help="a real clip to use, see real_clip_marks.py")
    parser.add_argument("--frames", type=int, default=300, help="frames to use (%(default)s)")
    parser.add_argument("--again", type=int, default=100, help="tracked again (%(default)s)")
    parser.add_argument("--evidence", choices=FOUND_BY, default="learnt", help="%(default)s")
    parser.add_argument("--scale", type=float, default=1.0, help="of 2048 x 700 (%(default)s)")
    parser.add_argument("--out", type=Path, metavar="SPEED.csv", help="put it into this table")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = clips_folder() / options.clip if options.clip else options.trial
        path = path or render_mouse_trial(
            folder, frames=options.frames, scale=options.scale, variants=("grey",)
        )
        measured = measure(load_trial(path), options.frames, options.again, options.evidence)
        given = f"--trial {options.trial}" if options.trial else f"--scale {options.scale:g}"
        given = f"--clip {options.clip}" if options.clip else given
        if options.evidence != "learnt":
            given += f" --evidence {options.evidence}"
        command = f"python benchmarks/points_speed.py --frames {options.frames} {given}"
        if options.out:
            put_into(options.out, measured.row(command))


if __name__ == "__main__":
    main()
