"""Make clips with marks of two courting flies, which the package of SLEAP 1.3.1 brings along.

    python benchmarks/sleap_flies.py FOLDER
    PAWNB_TEST_DATA=FOLDER python benchmarks/real_clips.py --peers lk --clips flyA flyB flyC

The package (64 MB) is fetched with pip. Marks are SLEAP's own predictions that are surer than 0.7
(head, thorax, abdomen and the tips of six legs, in every eighth of 120 frames); they are a few
pixels off themselves, so a track is right within 5 px (a fly is 90 px long). At 15 frames a second
a leg steps within one or two frames. The camera follows the flies, and each is in the way of
the other. Nothing of the tracker was chosen on them.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import av
import pandas as pd
import tomli_w

import pawnb
from pawnb.synthetic.colour_video import H264VideoWriter

SLEAP = "sleap==1.3.1"
FILM = "tests/data/videos/centered_pair_small.mp4"
PREDICTIONS = "tests/data/hdf5_format_v1/centered_pair_predictions.slp"
FPS, FRAMES, EVERY = 15.0, 120, 8
SURE, THRESHOLD_PX, ERROR_PX = 0.7, 5.0, 2.0
CLIPS = {"flyA": ("1", 0), "flyB": ("2", 0), "flyC": ("1", 400)}
"""Of each clip the fly, as SLEAP names it, and the first frame."""
BODY = {point: point for point in ("head", "thorax", "abdomen")}
LEGS = {
    f"{side}{number}": f"{leg}leg{side}3"
    for side in "LR"
    for number, leg in enumerate(("fore", "mid", "hind"), start=1)
}
POINTS = BODY | LEGS


def fetch(folder: Path) -> None:
    """Put the film and the predictions of SLEAP's package into ``folder``."""
    command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", str(folder), SLEAP]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as package:
        package.extract(FILM, folder)
        package.extract(PREDICTIONS, folder)


def marks(predictions: Path, fly: str, first: int) -> pd.DataFrame:
    """Return the sure predictions of one fly: frame, view, point, u, v, visible."""
    tracks = pawnb.load_tracks(predictions, fps=FPS).sel(individual=fly)
    rows = []
    for frame in range(0, FRAMES, EVERY):
        here = tracks.isel(time=first + frame)
        for point, name in POINTS.items():
            if here.confidence.sel(keypoint=name) > SURE:
                u, v = here.position.sel(keypoint=name).to_numpy().round(2)
                rows.append((frame, "top", point, u, v, 1))
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v", "visible"])


def write_film(source: Path, target: Path, first: int) -> None:
    """Write the frames of one clip, hardly compressed."""
    with av.open(str(source)) as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    height, width = pictures[0].shape[:2]
    with H264VideoWriter(target, size=(width, height), fps=FPS, crf=10) as writer:
        for picture in pictures[first : first + FRAMES]:
            writer.write(picture)


def write_clip(folder: Path, own: pd.DataFrame, source: Path, first: int) -> None:
    """Write one clip as real_clips.py expects it."""
    folder.mkdir(parents=True, exist_ok=True)
    write_film(source, folder / "top.mp4", first)
    own.to_csv(folder / "marks.csv", index=False)
    counts = own.groupby("frame").size()
    middle = min(counts[counts == counts.max()].index, key=lambda frame: abs(frame - FRAMES // 2))
    start = own[own["frame"] == middle]
    start.to_csv(folder / "start.csv", index=False)
    settings = {"threshold_px": THRESHOLD_PX, "mark_error_px": ERROR_PX, "marks": "SLEAP"}
    (folder / "meta.toml").write_text(tomli_w.dumps(settings))
    trial = {
        "trial": {"kind": "paws", "name": folder.name, "fps": FPS, "frames": [0, FRAMES - 1]},
        "animal": {"id": folder.name},
        "views": [{"name": "top", "video": "top.mp4", "points": start["point"].tolist()}],
        "start": {"points": "start.csv"},
    }
    (folder / "trial.toml").write_text(tomli_w.dumps(trial))


def main() -> None:
    """Fetch SLEAP's package and write three clips."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder / "real-clips"
    with tempfile.TemporaryDirectory() as fetched:
        fetch(Path(fetched))
        for name, (fly, first) in CLIPS.items():
            own = marks(Path(fetched) / PREDICTIONS, fly, first)
            write_clip(folder / name, own, Path(fetched) / FILM, first)
            print(f"{folder / name}: {len(own)} marks")


if __name__ == "__main__":
    main()
