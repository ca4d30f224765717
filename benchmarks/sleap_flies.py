"""Make clips with marks of walking and courting flies, which the package of SLEAP 1.3.1 has.

    python benchmarks/sleap_flies.py FOLDER
    PAWNB_TEST_DATA=FOLDER python benchmarks/real_clips.py --peers lk [--clips NAME ...]

The package (64 MB) is fetched with pip. Marks are head, thorax, abdomen and the tips of six legs of
one fly, in every eighth of 120 frames. Those of female and male a person proofread. The others are
SLEAP's own predictions that are surer than 0.7; they are a few pixels off themselves (on a grid of
4 px in the arenas). A track is right within 5 px (flyA, flyB, flyC) or 6 px; a fly is 90 to 110 px
long. At 15 and 25 frames a second a leg steps within one or two frames. The camera follows flyA,
flyB and flyC, in the other films it stands still, and a second fly is there in all. Nothing of the
tracker was chosen on them.
"""

from __future__ import annotations

import argparse
import itertools
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
import pandas as pd
import tomli_w

import pawnb
from pawnb.synthetic.colour_video import H264VideoWriter

SLEAP = "sleap==1.3.1"
FRAMES, EVERY = 120, 8
SURE, ERROR_PX = 0.7, 2.0


@dataclass(frozen=True)
class Recording:
    """A film and the points of flies in it, as the package has them."""

    film: str
    points: str
    fps: float
    threshold_px: float
    claw: int
    """The number of the segment of a leg that its tip has in the names of points."""


PAIR = Recording(
    "tests/data/videos/centered_pair_small.mp4",
    "tests/data/hdf5_format_v1/centered_pair_predictions.slp",
    fps=15.0, threshold_px=5.0, claw=3,
)  # fmt: skip
COURTSHIP = Recording(
    "tests/data/tracks/clip.mp4", "tests/data/tracks/clip.slp", fps=25.0, threshold_px=6.0, claw=4
)
ARENA = Recording(
    "docs/notebooks/analysis_example/20190128_113421.120s.mp4",
    "docs/notebooks/analysis_example/predictions.slp",
    fps=25.0, threshold_px=6.0, claw=4,
)  # fmt: skip
CLIPS = {
    "flyA": (PAIR, "1", 0), "flyB": (PAIR, "2", 0), "flyC": (PAIR, "1", 400),
    "female": (COURTSHIP, "female", 1080), "male": (COURTSHIP, "male", 1080),
    "arenaA": (ARENA, "track_1", 2060), "arenaB": (ARENA, "track_0", 1480),
}  # fmt: skip
"""Of each clip the recording, the fly as SLEAP names it, and the first frame."""


def fetch(folder: Path) -> None:
    """Put the films and the points of SLEAP's package into ``folder``."""
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(folder), SLEAP]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as package:
        for recording in (PAIR, COURTSHIP, ARENA):
            package.extract(recording.film, folder)
            package.extract(recording.points, folder)


def names_of_points(recording: Recording) -> dict[str, str]:
    """Return SLEAP's name of each point."""
    legs = {
        f"{side}{number}": f"{leg}leg{side}{recording.claw}"
        for side in "LR"
        for number, leg in enumerate(("fore", "mid", "hind"), start=1)
    }
    return {point: point for point in ("head", "thorax", "abdomen")} | legs


def marks(fetched: Path, recording: Recording, fly: str, first: int) -> pd.DataFrame:
    """Return the sure points of one fly: frame, view, point, u, v, visible.

    What a person proofread has no confidence.
    """
    tracks = pawnb.load_tracks(fetched / recording.points, fps=recording.fps).sel(individual=fly)
    rows = []
    for frame in range(0, FRAMES, EVERY):
        here = tracks.isel(time=first + frame)
        for point, name in names_of_points(recording).items():
            u, v = here.position.sel(keypoint=name).to_numpy().round(2)
            if np.isfinite(u) and not here.confidence.sel(keypoint=name) <= SURE:
                rows.append((frame, "top", point, u, v, 1))
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v", "visible"])


def write_film(source: Path, target: Path, *, fps: float, first: int) -> None:
    """Write the frames of one clip, hardly compressed."""
    with av.open(str(source)) as film:
        frames = itertools.islice(film.decode(video=0), first, first + FRAMES)
        pictures = [frame.to_ndarray(format="rgb24") for frame in frames]
    height, width = pictures[0].shape[:2]
    with H264VideoWriter(target, size=(width, height), fps=fps, crf=10) as writer:
        for picture in pictures:
            writer.write(picture)


def write_clip(folder: Path, own: pd.DataFrame, recording: Recording) -> None:
    """Write all of one clip but its film as real_clips.py expects it."""
    own.to_csv(folder / "marks.csv", index=False)
    counts = own.groupby("frame").size()
    middle = min(counts[counts == counts.max()].index, key=lambda frame: abs(frame - FRAMES // 2))
    start = own[own["frame"] == middle]
    start.to_csv(folder / "start.csv", index=False)
    settings = {
        "recording": Path(recording.film).stem,
        "threshold_px": recording.threshold_px,
        "mark_error_px": ERROR_PX,
        "marks": "SLEAP",
    }
    (folder / "meta.toml").write_text(tomli_w.dumps(settings))
    named = {"kind": "paws", "name": folder.name, "fps": recording.fps, "frames": [0, FRAMES - 1]}
    trial = {
        "trial": named,
        "animal": {"id": folder.name},
        "views": [{"name": "top", "video": "top.mp4", "points": start["point"].tolist()}],
        "start": {"points": "start.csv"},
    }
    (folder / "trial.toml").write_text(tomli_w.dumps(trial))


def main() -> None:
    """Fetch SLEAP's package and write the clips."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    home = parser.parse_args().folder / "real-clips"
    with tempfile.TemporaryDirectory() as made:
        fetched = Path(made)
        fetch(fetched)
        for name, (recording, fly, first) in CLIPS.items():
            own, folder = marks(fetched, recording, fly, first), home / name
            folder.mkdir(parents=True, exist_ok=True)
            film = fetched / recording.film
            write_film(film, folder / "top.mp4", fps=recording.fps, first=first)
            write_clip(folder, own, recording)
            print(f"{folder}: {len(own)} marks")


if __name__ == "__main__":
    main()
