"""Time per frame of all views, and memory: the paw tracker against decoding the same frames.

Run it from the project's root:

    python benchmarks/tracking_speed.py --frames 300 --scale 1     # renders 2048 x 700
    python benchmarks/tracking_speed.py --trial my/trial.toml --memory 100 600

*decoding* is PyAV alone: every frame of every file, planes only, files shared by two
threads of one codec thread each. *reading* is pawnb's own reader, which hands out the same
frames side by side. *tracking* is the whole call on freshly opened files, decoding
included: from clicks to tracks in memory; nothing is taken from an earlier run. The ways
take turns, and the ratio is formed within each turn, so that what else the machine does
falls on all of them; the range over the turns says how much that was. On a busy machine
the clock favours whoever has more threads: then the ratio of processor times, of all
threads, tells more. Memory is the peak of a fresh process.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import av
import numpy as np

from pawnb.core.paws.offline.treadmill import tracker as treadmill_tracker
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.tracker import KeptEvidence
from pawnb.core.video import open_views
from pawnb.io.start import read_start
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.methods import PAW_METHODS, tracker_settings, trial_tracker
from pawnb.workflow.tracking.trial_views import points_by_view, trial_rig, view_facing

STAGES = {"read_scene": "learn from clicks", "scan_video": "detections, decoding included",
          "run_pipeline": "deciding"}  # fmt: skip
"""Steps of method ``pawnb``, by the names they have in its module."""


class Timing(NamedTuple):
    """Milliseconds a frame of all views: by the clock, and of processor time."""

    clock: float
    cpu: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trial", type=Path, help="a trial to use instead of rendering one")
    parser.add_argument("--frames", type=int, default=300, help="frames to use (%(default)s)")
    parser.add_argument("--scale", type=float, default=1.0, help="of 2048 x 700 (%(default)s)")
    parser.add_argument(
        "--method", default=PAW_METHODS[0], choices=PAW_METHODS, help="(%(default)s)"
    )
    parser.add_argument("--repeats", type=int, default=5, help="(%(default)s)")
    parser.add_argument("--memory", type=int, nargs="*", default=[], metavar="FRAMES",
                        help="also print the peak memory of tracking so many frames")  # fmt: skip
    parser.add_argument("--peak-of", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        frames = max([arguments.frames, *arguments.memory])
        path = arguments.trial or render_mouse_trial(folder, frames=frames, scale=arguments.scale)
        if arguments.peak_of:
            run(load_trial(path), arguments.method, arguments.peak_of)
            print(own_peak())
            return
        measure(load_trial(path), arguments.method, arguments.frames, arguments.repeats)
        for n_frames in arguments.memory:
            print(f"  peak memory, {n_frames} frames: "
                  f"{peak_mb(path, arguments.method, n_frames):.0f} MB")  # fmt: skip


def measure(trial: Trial, method: str, n_frames: int, repeats: int) -> None:
    """Measure one trial and print the times."""
    with open_views(trial) as views:
        n_frames = min(n_frames, views.n_frames)
        sizes = {f"{r.width} x {r.height}" for r in views.readers.values()}
    stages: dict[str, list[float]] = {}

    def track() -> None:
        with timed_stages(stages, n_frames):
            run(trial, method, n_frames)

    ways: dict[str, Callable[[], None]] = {
        "decoding": lambda: decode(trial, n_frames),
        "reading": lambda: read(trial, n_frames),
        "tracking": track,
    }
    found: dict[str, list[Timing]] = {name: [] for name in ways}
    for turn in range(repeats):
        for name, work in ways.items():
            found[name].append(timed(work, n_frames))
        ratio = found["tracking"][turn].clock / found["decoding"][turn].clock
        print(f"turn {turn + 1}: {ratio:.2f} x decoding", file=sys.stderr, flush=True)
    print(f"{trial.name}: method {method}, {len(trial.views)} views of {', '.join(sorted(sizes))}, "
          f"{n_frames} frames, {os.cpu_count()} processors, {repeats} turns")  # fmt: skip
    print(f"  import of the tracker in a fresh process: {import_s():.1f} s")
    base = found["decoding"]
    for name, own in found.items():
        ratios = [a.clock / b.clock for a, b in zip(own, base, strict=True)]
        cpu = [a.cpu / b.cpu for a, b in zip(own, base, strict=True)]
        print(
            f"  {name:9s} {statistics.median(t.clock for t in own):6.1f} ms a frame of all views: "
            f"{statistics.median(ratios):.2f} x decoding ({min(ratios):.2f} to {max(ratios):.2f}); "
            f"processor time {statistics.median(t.cpu for t in own):.1f} ms, "
            f"{statistics.median(cpu):.2f} x"
        )
    for name, times in stages.items():
        print(f"    {STAGES[name]:30s} {statistics.median(times):6.2f} ms a frame")


def timed(work: Callable[[], None], n_frames: int) -> Timing:
    """Return the time that some work took, a frame."""
    clock, cpu = time.perf_counter(), time.process_time()
    work()
    clock, cpu = time.perf_counter() - clock, time.process_time() - cpu
    return Timing(1000.0 * clock / n_frames, 1000.0 * cpu / n_frames)


def decode(trial: Trial, n_frames: int) -> None:
    """Decode every file with PyAV: planes only, two threads."""

    def one(path: Path) -> int:
        total = 0
        with av.open(str(path)) as container:
            container.streams.video[0].codec_context.thread_count = 1
            for number, frame in enumerate(container.decode(video=0)):
                total += sum(int(np.frombuffer(plane, np.uint8)[0]) for plane in frame.planes)
                if number == n_frames - 1:
                    break
        return total

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(one, [trial.path(view.video) for view in trial.views]))


def read(trial: Trial, n_frames: int) -> None:
    """Read every frame of every view side by side."""
    with open_views(trial) as views:
        for _ in views.frames(0, n_frames):
            pass


def run(trial: Trial, method: str, n_frames: int) -> None:
    """Track a trial from its clicks."""
    file = trial.start_file()
    if file is None:
        raise SystemExit(f"trial {trial.name!r} has no start points.")
    start = read_start(trial.path(file), trial)
    with open_views(trial) as views:
        rig = trial_rig(trial, views)
        task = TrackingRequest(
            rig=rig,
            frames=(0, min(n_frames, views.n_frames)),
            fps=trial.fps,
            points_by_view=points_by_view(trial, start),
            facing=view_facing(trial, rig),
        )
        settings = tracker_settings(trial, method=method)
        trial_tracker(trial, method).track(
            views, start, task, settings=settings, kept=KeptEvidence()
        )


@contextlib.contextmanager
def timed_stages(stages: dict[str, list[float]], n_frames: int) -> Iterator[None]:
    """Note how long each step of method ``pawnb`` takes while the block runs, ms a frame."""
    plain = {name: getattr(treadmill_tracker, name) for name in STAGES}

    def wrap(name: str) -> Callable[..., object]:
        def step(*args: object, **options: object) -> object:
            begun = time.perf_counter()
            result = plain[name](*args, **options)
            took = 1000.0 * (time.perf_counter() - begun) / n_frames
            stages.setdefault(name, []).append(took)
            return result

        return step

    for name in STAGES:
        setattr(treadmill_tracker, name, wrap(name))
    try:
        yield
    finally:
        for name, function in plain.items():
            setattr(treadmill_tracker, name, function)


def import_s() -> float:
    """Return the time that a fresh process takes to import the tracker."""
    times = []
    for words in ("import pawnb.workflow.tracking.track", "pass"):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", words], check=True)
        times.append(time.perf_counter() - begun)
    return times[0] - times[1]


def peak_mb(path: Path, method: str, n_frames: int) -> float:
    """Return the peak memory of a process that tracks so many frames."""
    words = [sys.executable, __file__, "--trial", str(path), "--method", method]
    done = subprocess.run(
        [*words, "--peak-of", str(n_frames)], check=True, capture_output=True, text=True
    )
    return int(done.stdout) / 2**20


def own_peak() -> int:
    """Return the peak memory of this process in bytes."""
    status = Path("/proc/self/status")
    if status.exists():
        # what the kernel tells of resources counts the process that began this one, too
        peak = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        if peak:
            return int(peak[1]) * 2**10
    usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return usage if sys.platform == "darwin" else usage * 2**10


if __name__ == "__main__":
    main()
