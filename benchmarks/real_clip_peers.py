"""Two general trackers of points, for benchmarks/real_clips.py: Lucas-Kanade and CSRT.

python benchmarks/real_clip_peers.py {lk,csrt} TRIAL CLICKS.csv TRACKS.csv --threshold-px PX

Every click is followed both ways in time, and between two clicks of a point the one nearer in
time decides. LK is OpenCV's pyramidal one, with windows of 21 px, 15 px in pictures up to 500 px;
CSRT starts with a box of two thresholds about the click. Needs no pawnb, so that it runs in an
environment that has opencv-contrib-python-headless, which alone has CSRT.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tomllib
from pathlib import Path

import cv2
import numpy as np
import pandas as pd

Pictures = dict[int, np.ndarray]
PEERS = ("lk", "csrt")
VERSION = 2
"""Results that were kept are taken again only by the same: raise it with whatever changes them."""
LARGE_PX = 500
LARGE_WINDOW_PX, WINDOW_PX = 21, 15
PYRAMID_LEVELS = 3


def read_pictures(
    path: Path,
    crop: list[int] | None,
    frames: tuple[int, int] | None,
    *,
    grey: bool,
    lens: tuple[np.ndarray, np.ndarray] | None = None,
) -> dict[int, np.ndarray]:
    """Return the pictures of a half-open range of frames, by number.

    What comes before is read, too: seeking is not exact in OpenCV.
    """
    u0, v0, u1, v1 = crop or (0, 0, None, None)
    first, stop = frames or (0, sys.maxsize)
    video, pictures = cv2.VideoCapture(str(path)), {}
    for frame in range(stop):
        there, picture = video.read()
        if not there:
            break
        if frame >= first:
            if lens is not None:
                picture = cv2.undistort(picture, *lens)
            picture = picture[v0:v1, u0:u1].copy()
            pictures[frame] = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if grey else picture
    return pictures


def lens_of(folder: Path, trial: dict, view: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return matrix and distortion of a view's lens, by Anipose's file or lenses.toml."""
    calibration = trial.get("calibration", {})
    name = calibration.get("anipose") or calibration.get("lens")
    if name is None:
        return None
    for key, section in tomllib.loads((folder / name).read_text()).items():
        if section.get("name", key) == view:
            bent = section.get("distortions", section.get("distortion"))
            return np.array(section["matrix"]), np.array(bent)
    return None


def follow_lk(pictures: Pictures, frames: range, click: np.ndarray, _px: float) -> dict:
    """Follow a click by optical flow through frames of which the first is the clicked one.

    Where the flow is lost the point stays where it was.
    """
    window = LARGE_WINDOW_PX if max(pictures[frames[0]].shape) > LARGE_PX else WINDOW_PX
    at, places = click.astype(np.float32).reshape(1, 1, 2), {frames[0]: click}
    for before, now in itertools.pairwise(frames):
        found, status, _ = cv2.calcOpticalFlowPyrLK(
            pictures[before], pictures[now], at, None,
            winSize=(window, window), maxLevel=PYRAMID_LEVELS,
        )  # fmt: skip
        at = found if status[0, 0] else at
        places[now] = at[0, 0]
    return places


def follow_csrt(pictures: Pictures, frames: range, click: np.ndarray, px: float) -> dict:
    """Follow a box about a click; where the tracker says that it is lost there is no place."""
    height, width = pictures[frames[0]].shape[:2]
    low = np.clip(np.round(click - px).astype(int), 0, None)
    high = np.clip(np.round(click + px).astype(int), None, [width, height])
    tracker = cv2.TrackerCSRT_create()
    tracker.init(pictures[frames[0]], (*low.tolist(), *(high - low).tolist()))
    offset, places = click - (low + high) / 2, {frames[0]: click}
    for now in frames[1:]:
        found, (u, v, w, h) = tracker.update(pictures[now])
        places[now] = np.array([u + w / 2, v + h / 2]) + offset if found else np.full(2, np.nan)
    return places


FOLLOW = {"lk": follow_lk, "csrt": follow_csrt}


def track_view(peer: str, pictures: Pictures, clicks: pd.DataFrame, *, px: float) -> pd.DataFrame:
    """Return point, frame, u, v of the clicked points of one view in all its pictures."""
    first, stop = min(pictures), max(pictures) + 1
    rows = []
    for point, own in clicks.sort_values("frame").groupby("point"):
        clicked = own["frame"].tolist()
        # the frame half way between two clicks is the earlier one's
        ends = [(a + b) // 2 + 1 for a, b in itertools.pairwise(clicked)]
        for frame, begin, end, click in zip(
            clicked, [first, *ends], [*ends, stop], own[["u", "v"]].to_numpy(float), strict=True
        ):
            onwards = FOLLOW[peer](pictures, range(frame, end), click, px)
            back = FOLLOW[peer](pictures, range(frame, begin - 1, -1), click, px)
            rows += [(point, k, *uv) for k, uv in sorted({**back, **onwards}.items())]
    return pd.DataFrame(rows, columns=["point", "frame", "u", "v"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("peer", choices=PEERS)
    parser.add_argument("trial", type=Path, help="folder with trial.toml")
    parser.add_argument("clicks", type=Path, help="csv: frame, view, point, u, v")
    parser.add_argument("out", type=Path, help="csv to write: view, point, frame, u, v")
    parser.add_argument("--threshold-px", type=float, required=True)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    trial = tomllib.loads((options.trial / "trial.toml").read_text())
    clicks, frames = pd.read_csv(options.clicks), trial["trial"].get("frames")
    parts = []
    for view in trial["views"]:
        path = options.trial / view["video"]
        lens = lens_of(options.trial, trial, view["name"])
        pictures = read_pictures(
            path, view.get("crop"), frames, grey=options.peer == "lk", lens=lens
        )
        own = clicks[clicks["view"] == view["name"]]
        part = track_view(options.peer, pictures, own, px=options.threshold_px)
        parts.append(part.assign(view=view["name"]))
    table = pd.concat(parts)[["view", "point", "frame", "u", "v"]]
    table.round(2).to_csv(options.out, index=False)


if __name__ == "__main__":
    main()
