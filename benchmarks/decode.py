"""Time to decode the views of a trial: planes only, crops in RGB, whole frames in RGB.

Without files, four MJPEG clips of 2048 x 700 px are written into a temporary folder.
The ways are timed in turn, frame ranges interleaved, so that their ratios hold on a
machine that others use, too.

    python benchmarks/decode.py [--frames N] [--views V] [--repeats R] [VIDEO ...]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import av
import numpy as np

from pawnb.core.video import Frame, open_views
from pawnb.trial import Animal, Trial, View

CROP_PX = (140, 80)
"""Size of the paw tracker's sub-image."""
CROPS_PER_VIEW = 2
WIDTH, HEIGHT = 2048, 700

Work = Callable[[Frame], object]


class Timing(NamedTuple):
    """Seconds a frame of all views took: by the clock, and of processor time."""

    clock_s: float
    cpu_s: float


def write_clips(
    folder: Path, *, views: int = 4, frames: int = 100, width: int = WIDTH, height: int = HEIGHT
) -> list[Path]:
    """Write MJPEG clips of a green, noisy, moving scene, and return their paths."""
    rng = np.random.default_rng(0)
    noise = rng.normal(0, 5, (height, width, 3))
    v, u = np.mgrid[:height, :width]
    paths = []
    for view in range(views):
        path = folder / f"cam{view + 1}.avi"
        with av.open(str(path), "w") as container:
            stream = container.add_stream("mjpeg", rate=250, options={"qmin": "3", "qmax": "3"})
            stream.width, stream.height, stream.pix_fmt = width, height, "yuvj420p"
            for number in range(frames):
                wave = 60 * np.sin((u + 3 * number) / 40 + view) * np.cos(v / 60)
                scene = np.stack([70 + 0.2 * wave, 130 + wave, 80 + 0.3 * wave], axis=-1)
                scene += np.roll(noise, (37 * number % height, 91 * number % width), (0, 1))
                rgb = np.clip(scene, 0, 255).astype(np.uint8)
                frame = av.VideoFrame.from_ndarray(rgb, format="rgb24")
                frame.pts, frame.time_base = number, Fraction(1, 250)
                for packet in stream.encode(frame):
                    container.mux(packet)
            for packet in stream.encode():
                container.mux(packet)
        paths.append(path)
    return paths


def trial_of(paths: Sequence[Path]) -> Trial:
    """Return a trial whose views are these files."""
    views = tuple(View(name=f"cam{k}", video=str(p.resolve())) for k, p in enumerate(paths, 1))
    return Trial(kind="paws", name="benchmark", fps=250.0, animal=Animal(id="none"), views=views)


def crops(frame: Frame) -> None:
    """Convert the sub-images that a paw tracker looks at."""
    width, height = min(CROP_PX[0], frame.width), min(CROP_PX[1], frame.height)
    for k in range(CROPS_PER_VIEW):
        u0 = (frame.width - width) * (k + 1) // (CROPS_PER_VIEW + 1)
        v0 = (frame.height - height) * 2 // 3
        frame.crop(u0, v0, u0 + width, v0 + height)


def nothing(_: Frame) -> None:
    """Leave the planes as decoded."""


WAYS: dict[str, Work] = {
    "planes only": nothing,
    f"planes + {CROPS_PER_VIEW} crops {CROP_PX[0]} x {CROP_PX[1]} a view in RGB": crops,
    "planes + whole frames in RGB": Frame.image,
}


def time_decoding(
    paths: Sequence[Path],
    *,
    ways: Mapping[str, Work] = WAYS,
    frames: int | None = None,
    repeats: int = 5,
) -> dict[str, list[Timing]]:
    """Read the views side by side and time each way of using them.

    Parameters
    ----------
    paths : sequence of Path
        One file a view.
    ways : mapping of str to callable
        What is done with every frame of every view.
    frames : int, optional
        How many frames to read; default all that the views have in common.
    repeats : int
        How often each way is timed; the ways take turns.

    Returns
    -------
    dict of str to list of Timing
        Seconds per frame of all views, one Timing a repeat.
    """
    seconds: dict[str, list[Timing]] = {name: [] for name in ways}
    with open_views(trial_of(paths)) as views:
        stop = views.n_frames if frames is None else min(frames, views.n_frames)
        for _ in range(repeats):
            for name, work in ways.items():
                views.frame(0)  # each way begins where the last one did
                clock, cpu = time.perf_counter(), time.process_time()
                for _, found in views.frames(0, stop):
                    for frame in found.values():
                        work(frame)
                spent = time.perf_counter() - clock, time.process_time() - cpu
                seconds[name].append(Timing(*(t / stop for t in spent)))
    return seconds


def print_times(timings: Mapping[str, Sequence[Timing]], *, views: int) -> None:
    """Print the shortest times of each way and their ratios to the first way.

    Processor time is the fairer one where other programs run at the same time.
    """
    print(
        f"{'':44s}{'ms per frame':>14s}{'pictures/s':>12s}{'ratio':>7s}{'cpu ms':>9s}{'ratio':>7s}"
    )
    first: Timing | None = None
    for name, times in timings.items():
        best = Timing(*(min(column) for column in zip(*times, strict=True)))
        first = first or best
        print(
            f"{name:44s}{best.clock_s * 1e3:14.2f}{views / best.clock_s:12.0f}"
            f"{best.clock_s / first.clock_s:7.2f}{best.cpu_s * 1e3:9.2f}"
            f"{best.cpu_s / first.cpu_s:7.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("videos", nargs="*", type=Path, help="one file a view")
    parser.add_argument("--frames", type=int, default=100, help="frames to read (100)")
    parser.add_argument("--views", type=int, default=4, help="clips to write without files (4)")
    parser.add_argument("--repeats", type=int, default=5, help="times each way is timed (5)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        paths = options.videos
        if not paths:
            paths = write_clips(Path(folder), views=options.views, frames=options.frames)
        size = sum(path.stat().st_size for path in paths) / len(paths) / 1e6
        print(f"{len(paths)} views, {options.frames} frames, {size:.1f} MB a file")
        seconds = time_decoding(paths, frames=options.frames, repeats=options.repeats)
    print_times(seconds, views=len(paths))


if __name__ == "__main__":
    main()
