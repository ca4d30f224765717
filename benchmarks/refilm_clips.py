"""Film the real clips in other ways, so that they can be tracked as such.

    python benchmarks/refilm_clips.py FOLDER [--films grey h264-crf33 ...] [--clips NAME ...]
    PAWNB_TEST_DATA=FOLDER/grey python benchmarks/real_clips.py --peers lk

Each film is a folder with ``real-clips``, as real_clips.py looks for them. Marks, clicks,
thresholds and calibrations are those of the clip, in pixels of the new film; a film of every second
frame has the marks of these frames only.

Films: ``as-it-is`` (Motion JPEG, as all that say nothing else), ``grey``, ``h264-crf33`` (as small
as films on the web), ``dark`` (a quarter of the light, and noise of 4 grey levels), ``half`` (half
as many pixels either way), ``small`` (grey, half, and H.264 of crf 28), ``half-rate`` (every second
frame).
"""

from __future__ import annotations

import argparse
import itertools
import shutil
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np
import pandas as pd
import real_clip_marks as real
import tomli_w

from pawnb.synthetic.colour_video import H264VideoWriter, JpegVideoWriter
from pawnb.synthetic.grey_video import GreyVideoWriter


@dataclass(frozen=True)
class Film:
    """How a clip is filmed again; crf None keeps Motion JPEG of good quality."""

    grey: bool = False
    crf: int | None = None
    scale: float = 1.0
    every: int = 1
    light: float = 1.0
    noise: float = 0.0


FILMS = {
    "as-it-is": Film(),
    "grey": Film(grey=True),
    "h264-crf33": Film(crf=33),
    "dark": Film(light=0.25, noise=4.0),
    "half": Film(scale=0.5),
    "small": Film(grey=True, crf=28, scale=0.5),
    "half-rate": Film(every=2),
}


def pictures(path: Path, film: Film) -> Iterator[np.ndarray]:
    """Yield the pictures of a video as a film shows them, RGB."""
    random = np.random.default_rng(0)
    with av.open(str(path)) as container:
        for i, frame in enumerate(container.decode(video=0)):
            if i % film.every:
                continue
            picture = frame.to_ndarray(format="rgb24")
            if film.grey:
                grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
                picture = cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
            if film.scale != 1.0:
                h, w = picture.shape[:2]
                size = round(w * film.scale), round(h * film.scale)
                picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
            if film.noise:
                dark = film.light * picture + random.normal(0.0, film.noise, picture.shape)
                picture = np.clip(dark, 0, 255).astype(np.uint8)
            yield picture


def write_video(source: Path, target: Path, film: Film, fps: float) -> None:
    """Film one video again."""
    shown = pictures(source, film)
    first = next(shown)
    size = first.shape[1], first.shape[0]
    writer: H264VideoWriter | GreyVideoWriter | JpegVideoWriter
    if film.crf is not None:
        writer = H264VideoWriter(target, size=size, fps=fps, crf=film.crf)
    elif film.grey:
        writer = GreyVideoWriter(target, size=size, fps=fps)
    else:
        writer = JpegVideoWriter(target, size=size, fps=fps)
    grey = film.grey and film.crf is None
    with writer:
        for picture in itertools.chain([first], shown):
            writer.write(np.ascontiguousarray(picture[..., 0]) if grey else picture)


def moved(table: pd.DataFrame, film: Film) -> pd.DataFrame:
    """Return clicks or marks of the frames that a film has, in its pixels."""
    kept = table[table["frame"] % film.every == 0].copy()
    kept["frame"] //= film.every
    # centres of pixels have whole coordinates
    kept[["u", "v"]] = ((kept[["u", "v"]] + 0.5) * film.scale - 0.5).round(3)
    return kept


def film_clip(clip: real.Clip, folder: Path, film: Film) -> None:
    """Write a clip as a film shows it."""
    folder.mkdir(parents=True)
    document = tomllib.loads((clip.folder / "trial.toml").read_text())
    trial, meta = document["trial"], tomllib.loads((clip.folder / "meta.toml").read_text())
    trial["fps"] /= film.every
    if "frames" in trial:
        first, last = trial["frames"]
        trial["frames"] = [-(-first // film.every), -(-last // film.every)]
    for view in document["views"]:
        source, target = clip.folder / view["video"], folder / view["video"]
        target = target.with_suffix(".avi" if film.crf is None else ".mp4")
        if not target.exists():
            write_video(source, target, film, trial["fps"])
        view["video"] = target.name
        if "crop" in view:
            view["crop"] = [round(edge * film.scale) for edge in view["crop"]]
    meta["threshold_px"] *= film.scale
    (folder / "trial.toml").write_text(tomli_w.dumps(document))
    (folder / "meta.toml").write_text(tomli_w.dumps(meta))
    marks = moved(pd.read_csv(clip.folder / "marks.csv"), film)
    start = moved(pd.read_csv(clip.folder / "start.csv"), film)
    if start.empty:  # clicked in a frame that the film lacks: one with most marks instead
        seen = marks[marks["visible"] == 1]
        frame = seen.groupby("frame").size().idxmax()
        start = seen.loc[seen["frame"] == frame, start.columns]
    marks.to_csv(folder / "marks.csv", index=False)
    start.to_csv(folder / "start.csv", index=False)
    for rig in clip.folder.glob("DLT*.csv"):
        coefficients = np.loadtxt(rig, delimiter=",", ndmin=2)
        rows = moved_rig(coefficients, film)
        np.savetxt(folder / rig.name, rows, delimiter=",", fmt="%.10g")


def moved_rig(coefficients: np.ndarray, film: Film) -> np.ndarray:
    """Return DLT coefficients (11, views) in the pixels of a film."""
    # s u + (s - 1) / 2, where u is a fraction whose denominator is rows 9 to 11 and 1
    below = np.vstack([coefficients[8:11], np.ones(coefficients.shape[1])])
    rows = coefficients.copy()
    for begin in (0, 4):
        over = coefficients[begin : begin + 4]
        rows[begin : begin + 4] = film.scale * over + 0.5 * (film.scale - 1.0) * below
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where the films are written")
    parser.add_argument("--films", nargs="+", choices=FILMS, default=list(FILMS))
    parser.add_argument("--clips", nargs="+", metavar="NAME", help="(default: all that are there)")
    options = parser.parse_args()
    home = real.clips_folder()
    there = sorted(path.parent.name for path in home.glob("*/marks.csv"))
    if not there:
        sys.exit(f"real clips: not in {home} (set PAWNB_TEST_DATA)")
    for name in options.films:
        for clip in options.clips or there:
            target = options.folder / name / "real-clips" / clip
            if target.exists():
                shutil.rmtree(target)
            film_clip(real.Clip(home / clip), target, FILMS[name])
        print(f"{name}: {options.folder / name}")


if __name__ == "__main__":
    main()
