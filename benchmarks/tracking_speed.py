"""Time per frame of all views: the paw tracker against decoding the same frames.

Run it from the project's root:

    python benchmarks/tracking_speed.py --frames 40 --scale 1     # renders 2048 x 700
    python benchmarks/tracking_speed.py --trial my/trial.toml

"decoded" reads every frame of every view and leaves the pixels alone; "tracked" is the
whole tracker on the same views, decoding included; "tracker alone" works on frames that
are decoded already. Each is the median of its repetitions.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pawnb.core.video import open_views
from pawnb.io.native import read_start
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import Trial, load_trial
from pawnb.workflow.track import (
    METHODS,
    points_by_view,
    run_tracker,
    tracker_settings,
    trial_rig,
)


class Decoded:
    """Views whose frames are held in memory."""

    def __init__(self, views: Any, n_frames: int) -> None:
        self.names, self.readers, self.n_frames = views.names, views.readers, n_frames
        self._held = [pictures for _, pictures in views.frames(0, n_frames)]

    def frame(self, i: int) -> Mapping[str, Any]:
        """Return one frame of every view."""
        return self._held[i]

    def frames(self, start: int, stop: int) -> Iterator[tuple[int, Mapping[str, Any]]]:
        """Go through frames of every view."""
        return ((i, self._held[i]) for i in range(start, stop))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trial", type=Path, help="a trial to use instead of rendering one")
    parser.add_argument("--frames", type=int, default=40, help="frames to use (%(default)s)")
    parser.add_argument("--scale", type=float, default=1.0, help="of 2048 x 700 (%(default)s)")
    parser.add_argument("--method", default=METHODS[0], choices=METHODS, help="(%(default)s)")
    parser.add_argument("--repeats", type=int, default=5, help="(%(default)s)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = arguments.trial or render_mouse_trial(
            folder, frames=arguments.frames, scale=arguments.scale
        )
        measure(load_trial(path), arguments.method, arguments.frames, arguments.repeats)


def measure(trial: Trial, method: str, n_frames: int, repeats: int) -> None:
    """Measure one trial and print the times."""
    start = read_start(trial.path(trial.start_points), trial)
    settings = tracker_settings(trial, method=method)
    with open_views(trial) as views:
        n_frames = min(n_frames, views.n_frames)
        rig = trial_rig(trial, views)
        held = Decoded(views, n_frames)

        def decode() -> None:
            for _ in views.frames(0, n_frames):
                pass

        def run(source: Any) -> None:
            run_tracker(
                method,
                source,
                start,
                rig=rig,
                settings=settings,
                frames=(0, n_frames),
                fps=trial.fps,
                points_by_view=points_by_view(trial, start),
            )

        times = {
            "decoded": median_ms(decode, n_frames, repeats),
            "tracked": median_ms(lambda: run(views), n_frames, repeats),
            "tracker alone": median_ms(lambda: run(held), n_frames, repeats),
        }
        sizes = {f"{r.width} x {r.height}" for r in views.readers.values()}
    print(
        f"{trial.name}: method {method}, {len(views.names)} views of "
        f"{', '.join(sorted(sizes))}, {n_frames} frames"
    )
    for name, ms in times.items():
        ratio = ms / times["decoded"]
        print(f"  {name:14s} {ms:7.1f} ms a frame of all views, {ratio:.1f} x decoding")


def median_ms(work: Callable[[], None], n_frames: int, repeats: int) -> float:
    """Return the median time of some work, ms a frame; a first run is not counted."""
    work()
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        times.append(1000.0 * (time.perf_counter() - begun) / n_frames)
    return statistics.median(times)


if __name__ == "__main__":
    main()
