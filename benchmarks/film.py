"""A film of a recording with its tracks drawn over it, to be looked at by a person.

Run it from the project's root:

    python benchmarks/film.py film.avi                       # the real grey clip, all frames
    python benchmarks/film.py film.avi --trial my/trial.toml --tracks my/results/tracks.nc
    python benchmarks/film.py sheet.png --frames 0:1000:40   # frames side by side in a picture

Views are put below each other. A disc is a candidate that was measured in that view, a
ring is where the other views or times say that the point is. Front paws are green (right)
and yellow (left), hind paws red (right) and blue (left); a tail of the last frames follows
each. The real clip is ``mouse-side-bottom`` in the folder named by PAWNB_TEST_DATA; it
starts from its hand marks in frame 0.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import av
import cv2
import numpy as np
from real_clip import clip_folder, read_marks, real_clip

from pawnb.core.video import open_views
from pawnb.io.native import read_tracks
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.trial import Trial, load_trial
from pawnb.workflow.tracking.methods import PAW_METHODS
from pawnb.workflow.tracking.track import track

COLOURS = {"FR": (60, 220, 60), "FL": (250, 230, 40), "HR": (250, 70, 60), "HL": (80, 140, 255)}
OTHER = (240, 120, 240)
TAIL = 12
SHEET_COLUMNS = 4


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("out", type=Path, help="film (.avi, .mp4) or sheet of frames (.png)")
    parser.add_argument("--trial", type=Path, help="a trial; default: the real grey clip")
    parser.add_argument("--tracks", type=Path, help="tracks.nc; default: track it now")
    parser.add_argument(
        "--method", default=PAW_METHODS[0], choices=PAW_METHODS, help="(%(default)s)"
    )
    parser.add_argument("--frames", default="", help="first:stop:step, as in Python")
    parser.add_argument("--zoom", type=float, default=2.0, help="(%(default)s)")
    parser.add_argument("--fps", type=int, default=25, help="of the film (%(default)s)")
    arguments = parser.parse_args()
    trial, tracks = described(arguments)
    wanted = [int(part) if part else None for part in arguments.frames.split(":")]
    frames = tracks["frame"].to_numpy()[slice(*wanted) if arguments.frames else slice(None)]
    pictures = drawn(trial, tracks, frames.tolist(), arguments.zoom)
    if arguments.out.suffix == ".png":
        write_sheet(arguments.out, list(pictures))
    else:
        write_film(arguments.out, pictures, arguments.fps)
    print(f"{arguments.out}: {len(frames)} frames")


def described(arguments: argparse.Namespace) -> tuple[Trial, Tracks]:
    """Return the trial and its tracks."""
    start = None
    if arguments.trial:
        trial = load_trial(arguments.trial)
    else:
        folder = clip_folder()
        if not folder.exists():
            raise SystemExit(f"{folder} is not there; set PAWNB_TEST_DATA or give --trial.")
        trial = real_clip(folder)
        marks = read_marks(folder / "manual_paws.csv")
        start = marks[marks["frame"] == 0]
    if arguments.tracks:
        return trial, read_tracks(arguments.tracks)
    return trial, track(trial, method=arguments.method, start=start)


def drawn(trial: Trial, tracks: Tracks, frames: list[int], zoom: float) -> Iterator[np.ndarray]:
    """Yield RGB pictures of frames with the tracks drawn over all views."""
    row_of = {int(frame): row for row, frame in enumerate(tracks["frame"].to_numpy())}
    with open_views(trial) as views:
        for frame in frames:
            opened = views.frame(frame)
            parts = []
            for name in views.names:
                pixels = opened[name].image()
                if pixels.ndim == 2:
                    pixels = np.repeat(pixels[..., None], 3, axis=2)
                picture = cv2.resize(pixels, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_CUBIC)
                draw_points(picture, tracks.sel(view=name), row_of[frame], zoom)
                parts.append(picture)
            width = max(part.shape[1] for part in parts)
            parts = [
                cv2.copyMakeBorder(part, 0, 0, 0, width - part.shape[1], cv2.BORDER_CONSTANT)
                for part in parts
            ]
            whole = np.concatenate(parts)
            cv2.putText(whole, str(frame), (6, 22), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (255,) * 3, 1)
            # most coders want even sizes
            yield np.ascontiguousarray(whole[: len(whole) // 2 * 2, : width // 2 * 2])


def draw_points(picture: np.ndarray, tracks: Tracks, row: int, zoom: float) -> None:
    """Draw the points of one view in one frame, with their tails."""
    for point in tracks["keypoint"].to_numpy().tolist():
        colour = COLOURS.get(point, OTHER)
        own = tracks.sel(keypoint=point).isel(individual=0)
        uv = own["image_position"].isel(time=slice(max(0, row - TAIL), row + 1)).to_numpy()
        at = (uv + 0.5) * zoom - 0.5
        if not np.isfinite(at[-1]).all():
            continue
        tail = np.round(at[np.isfinite(at).all(axis=1)]).astype(np.int32)
        cv2.polylines(picture, [tail], False, colour, 1, cv2.LINE_AA)
        u, v = tail[-1].tolist()
        origin = int(own["image_origin"].isel(time=row))
        measured = origin in (ORIGIN_CODE["measured"], ORIGIN_CODE["edited"])
        cv2.circle(picture, (u, v), 5, colour, -1 if measured else 2, cv2.LINE_AA)
        cv2.putText(picture, point, (u + 7, v - 5), cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1)


def write_film(path: Path, pictures: Iterator[np.ndarray], fps: int) -> None:
    """Write pictures as a film."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg" if path.suffix == ".avi" else "mpeg4", rate=fps)
        stream.pix_fmt = "yuvj420p" if path.suffix == ".avi" else "yuv420p"
        stream.bit_rate = 8_000_000
        for number, picture in enumerate(pictures):
            if number == 0:
                stream.height, stream.width = picture.shape[:2]
            for packet in stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)


def write_sheet(path: Path, pictures: list[np.ndarray]) -> None:
    """Write pictures side by side in one."""
    blank = np.zeros_like(pictures[0])
    pictures = pictures + [blank] * (-len(pictures) % SHEET_COLUMNS)
    rows = [
        np.hstack(pictures[i : i + SHEET_COLUMNS]) for i in range(0, len(pictures), SHEET_COLUMNS)
    ]
    cv2.imwrite(str(path), cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR))


if __name__ == "__main__":
    main()
