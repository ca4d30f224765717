"""The default pose tracker on two real animals: a hanging orb weaver and a walking fly.

python benchmarks/pose_real.py [--seeds 0 1 2] [--only spider fly] [--pictures FOLDER]
    [--starts] [--disturb SEED]

The spider starts in frame 0 from legs that someone drew in frame 600 (she hangs still),
disturbed by 5 px and 5 degrees a joint. The fly starts from SLEAP's points of its first frame, as
if clicked; with --disturb, from these disturbed as the spider's. With --starts only the fit of the
start frame is measured, of the spider, in five frames and from ten starts each.
Recordings: see real_animals.py; what is not there is skipped.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import real_animals as real

import pawnb
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.fit.explanation import fit_to_picture
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import Poses, joint_positions, leg_angles, tip_positions
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video.views import Frame, ViewReader
from pawnb.workflow.evaluation.pose_spread import build_jitter_table

STILL = (0, 1900)
"""Frames in which the spider holds still under an even light."""
EVERY = 20
"""So many frames apart are those whose pictures are compared."""
BEFORE, SHADOW = (1850, 1905), (1905, 1975)
SCORED, SURE = 0.5, 0.7
"""SLEAP's score from which a tip counts, and from which on it is seldom seen to be wrong: below, a
hind leg's tip often lies on a wing."""
FLY_PX, SPIDER_PX = 12.0, 6.0
FLY_FPS = 25.0
START_FRAMES = (0, 200, 400, 570, 600)
_COLOURS = ((0, 0, 255), (0, 160, 0), (255, 0, 0), (0, 150, 255))


def line_errors(animal: StickAnimal, pose: Poses, lines: dict[str, np.ndarray]) -> dict[str, float]:
    """Return, of each leg, how far leg and drawn line are apart at most, px.

    From every place of either to the nearest of the other, the part near the body left out.
    """
    places = joint_positions(animal, pose)[0]
    shares, out = np.linspace(0.1, 1.0, 60), {}
    for i, leg in enumerate(animal.legs):
        one = real.along(places[i, : len(leg.segments) + 1], shares)
        other = real.along(lines[leg.name], shares)
        fine = np.linspace(0.0, 1.0, 400)
        whole = real.along(places[i, : len(leg.segments) + 1], fine)
        line = real.along(lines[leg.name], fine)
        out[leg.name] = float(max(_farthest(one, line), _farthest(other, whole)))
    return out


def _farthest(points: np.ndarray, line: np.ndarray) -> float:
    """Return the greatest distance of a point from the points of a line."""
    return float(np.linalg.norm(points[:, None] - line[None], axis=-1).min(axis=1).max())


def tracked(
    reader: ViewReader, background: object, *, animal: StickAnimal, start: Poses, stop: int
) -> tuple[PoseTrack, float]:
    """Return the track of frames 0 to ``stop`` and ms a frame."""
    began = time.perf_counter()
    track = track_pose(reader, start, animal=animal, background=background, frames=(0, stop))  # type: ignore[arg-type]
    return track, 1000 * (time.perf_counter() - began) / stop


def places_of(animal: StickAnimal, poses: Poses) -> np.ndarray:
    """Return body and all joints and tips, shape (n, places, 2)."""
    joints = joint_positions(animal, poses).reshape(len(poses), -1, 2)
    joints = joints[:, np.isfinite(joints).all(axis=2).any(axis=0)]
    return np.concatenate([poses.xy[:, None], joints], axis=1)


def moved_by_shadow(animal: StickAnimal, poses: Poses) -> tuple[float, float, float]:
    """Return how far the shadow moves body, joints and tips (most), px."""
    before, under = (poses.take(slice(*part)) for part in (BEFORE, SHADOW))
    rest = np.median(places_of(animal, before), axis=0)
    away = np.linalg.norm(places_of(animal, under) - rest, axis=-1)
    tips = np.linalg.norm(
        tip_positions(animal, under) - np.median(tip_positions(animal, before), axis=0), axis=-1
    )
    return float(away[:, 0].max()), float(away.max()), float(tips.max())


def measure_spider(folder: Path, seeds: list[int], pictures: Path | None) -> None:
    """Print the spider's table; the first seed is tracked under the shadow too."""
    lines = real.drawn_legs(folder)
    with real.opened(real.SPIDER, folder) as (reader, background):
        for i, seed in enumerate(seeds):
            animal, drawn = real.spider_start(folder, frame=0)
            stop = SHADOW[1] if i == 0 else real.DRAWN_FRAME + 1
            track, ms = tracked(
                reader, background, animal=animal, start=real.disturbed(drawn, seed), stop=stop
            )
            poses = track.poses
            away = line_errors(animal, poses.at_frame(real.DRAWN_FRAME), lines)
            legs = ", ".join(f"{leg} {px:.1f}" for leg, px in away.items())
            good = sum(px <= SPIDER_PX for px in away.values())
            print(
                f"spider, start {seed}: {good} of {len(away)} legs within {SPIDER_PX:g} px of the "
                f"drawn ones in frame {real.DRAWN_FRAME} ({legs}); {ms:.0f} ms a frame",
                flush=True,
            )
            if pictures:
                draw(reader, animal, poses.at_frame(0), pictures / f"spider{seed}_0.png")
                draw(reader, animal, poses.at_frame(600), pictures / f"spider{seed}_600.png")
            if i == 0:
                print_still(reader, animal, poses)
                if pictures:
                    for frame in range(SHADOW[0], SHADOW[1], 10):
                        name = pictures / f"spider{seed}_{frame}.png"
                        draw(reader, animal, poses.at_frame(frame), name)


def measure_starts(folder: Path) -> None:
    """Print how many legs are fitted rightly in start frames, from many disturbed starts."""
    lines, away = real.drawn_legs(folder), []
    with real.opened(real.SPIDER, folder) as (reader, background):
        for frame in START_FRAMES:
            animal, drawn = real.spider_start(folder, frame=frame)
            for seed in range(10):
                start = real.disturbed(drawn, seed)
                pose, _ = fit_to_picture(
                    reader.frame(frame), start, animal=animal, background=background
                )
                away += line_errors(animal, pose, lines).values()
    good = np.mean(np.array(away) <= SPIDER_PX)
    print(f"spider, starts: {100 * good:.1f} % of {len(away)} legs within {SPIDER_PX:g} px")


def print_still(reader: ViewReader, animal: StickAnimal, poses: Poses) -> None:
    """Print how much the pose of the still spider varies, and what the shadow does to it."""
    still = poses.take(slice(*STILL))
    table = build_jitter_table(animal, still)
    print(f"spider still, frames {STILL[0]} to {STILL[1] - 1} (Table 4.1):")
    print(table.round(3).to_string(index=False))
    noise = [
        np.diff(x, axis=0).std(axis=0) / np.sqrt(2) for x in (still.xy, leg_angles(animal, still))
    ]
    print(
        f"of it, from frame to frame (SD of differences / sqrt 2): body {noise[0].max():.3f} px, "
        f"total leg angle {np.median(noise[1]):.3f} degrees in the middle leg, "
        f"{noise[1].max():.3f} in the worst"
    )
    print_movement(reader, animal, still)
    body, most, tips = moved_by_shadow(animal, poses)
    print(
        f"shadow, frames {SHADOW[0]} to {SHADOW[1] - 1}: body moved by up to {body:.2f} px, "
        f"tips {tips:.2f} px, any joint {most:.2f} px",
        flush=True,
    )


def print_movement(reader: ViewReader, animal: StickAnimal, poses: Poses) -> None:
    """Print whether what was tracked is movement that the picture shows without any model."""
    poses = poses.take(slice(0, None, EVERY))
    frames = [reader.frame(int(i)) for i in poses.frames]
    shift = picture_shifts(frames, np.median(poses.xy, axis=0), half=30)
    moved = poses.xy - np.median(poses.xy, axis=0)
    of_picture, of_track, apart = (x.std(axis=0).max() for x in (shift, moved, shift - moved))
    print(
        f"her waist's picture, registered without a model, moves by {of_picture:.2f} px (SD), the "
        f"tracked body by {of_track:.2f} px; the two differ by {apart:.2f} px"
    )
    places = joint_positions(animal, poses)
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        along = np.median(places[:, i, n] - places[:, i, n - 2], axis=0)
        across = np.array([-along[1], along[0]]) / np.hypot(*along)
        middle = (places[:, i, n - 1] + places[:, i, n - 2]) / 2
        usual = np.median(middle, axis=0)
        shift, moved = picture_shifts(frames, usual, half=10) @ across, (middle - usual) @ across
        print(
            f"  {leg.name}, outer part, sideways: picture {shift.std():.2f} px, track "
            f"{moved.std():.2f} px, correlation {np.corrcoef(shift, moved)[0, 1]:.2f}"
        )


def picture_shifts(frames: list[Frame], place: np.ndarray, *, half: int) -> np.ndarray:
    """Return how far a square about a place has moved in each frame, px, shape (n, 2).

    By least squares to the median picture and its slopes, brightness and contrast left free.
    """
    u, v = np.round(place).astype(int) - half
    side = 2 * half + 1
    crops = np.array([grey(f.crop(u, v, u + side, v + side)) for f in frames], dtype=float)
    usual = np.median(crops, axis=0)
    down, right = np.gradient(usual)
    known = np.column_stack([right.ravel(), down.ravel(), usual.ravel(), np.ones(usual.size)])
    away = (crops - usual).reshape(len(crops), -1)
    return -np.linalg.lstsq(known, away.T, rcond=None)[0][:2].T


def measure_fly(folder: Path, pictures: Path | None, disturb: int | None) -> None:
    """Print the fly's table; ``disturb`` is the seed of how its start is disturbed, if it is."""
    animal, start = real.fly_start(folder)
    start = start if disturb is None else real.disturbed(start, disturb)
    tips = real.fly_tips(folder)
    with real.opened(real.FLY, folder) as (reader, background):
        track, ms = tracked(reader, background, animal=animal, start=start, stop=reader.n_frames)
        found = tip_positions(animal, track.poses)
        print(f"fly: {int(np.isfinite(found[:, 0, 0]).sum())} frames, {ms:.0f} ms a frame")
        told = pawnb.assess_quality(tracks_from_poses(animal, track, fps=FLY_FPS, view="top"))
        print(f"verdict: {told.verdict}, {100 * told.expected_right:.1f} % expected right")
        tips = tips[tips["score"] > SCORED]
        leg_of = [animal.leg_names.index(leg) for leg in tips["leg"]]
        away = found[tips["frame"], leg_of] - tips[["u", "v"]].to_numpy()
        print_agreement(tips, away, np.radians(track.poses.heading_deg[tips["frame"]]))
        if pictures:
            for frame in range(0, reader.n_frames, 5):
                name = pictures / f"fly_{frame:03d}.png"
                marks = tips.loc[tips["frame"] == frame, ["u", "v"]].to_numpy()
                draw(reader, animal, track.poses.at_frame(frame), name, marks=marks)


def print_agreement(tips: pd.DataFrame, away: np.ndarray, heading: np.ndarray) -> None:
    """Print how near to SLEAP's tips ours are, and by how much they differ throughout.

    Of each of the ``tips``, ``away`` is how far ours lies from it, px, shape (n, 2), and
    ``heading`` that of the body, radians.
    """
    px = np.nan_to_num(np.hypot(*away.T), nan=np.inf)
    side = np.where(tips["leg"].str.startswith("R"), 1.0, -1.0)
    ahead = away[:, 0] * np.cos(heading) + away[:, 1] * np.sin(heading)
    out = side * (-away[:, 0] * np.sin(heading) + away[:, 1] * np.cos(heading))
    for leg in sorted(set(tips["leg"])):
        own = (tips["leg"] == leg).to_numpy()
        print(
            f"  {leg}: {100 * np.mean(px[own] <= FLY_PX):.0f} % of {own.sum()} tips within "
            f"{FLY_PX:g} px of SLEAP's, median {np.median(px[own]):.1f} px; on the whole "
            f"{np.nanmedian(ahead[own]):+.1f} px ahead, {np.nanmedian(out[own]):+.1f} px outwards"
        )
    for least in (SCORED, SURE):
        own = (tips["score"] > least).to_numpy()
        print(
            f"  all with a score above {least:g}: {100 * np.mean(px[own] <= FLY_PX):.0f} % "
            f"of {own.sum()}",
            flush=True,
        )


def draw(
    reader: ViewReader, animal: StickAnimal, pose: Poses, path: Path, *,
    marks: np.ndarray | None = None, zoom: int = 4,
) -> None:  # fmt: skip
    """Save a picture of a pose and of marks."""
    if np.isnan(pose.xy).any():
        return
    places = joint_positions(animal, pose)[0]
    low = np.nanmin(places, axis=(0, 1)) - 30
    high = np.nanmax(places, axis=(0, 1)) + 30
    u0, v0 = (int(max(0, x)) for x in low)
    u1, v1 = int(min(reader.width, high[0])), int(min(reader.height, high[1]))
    crop = reader.frame(int(pose.frames[0])).crop(u0, v0, u1, v1)
    crop = np.repeat(crop[..., None], 3, axis=2) if crop.ndim == 2 else crop[..., ::-1]
    picture = cv2.resize(
        np.ascontiguousarray(crop), None, fx=zoom, fy=zoom, interpolation=cv2.INTER_CUBIC
    )

    def at(points: np.ndarray) -> np.ndarray:
        return np.round((points - [u0, v0] + 0.5) * zoom).astype(int)

    for i, leg in enumerate(animal.legs):
        corners = at(places[i, : len(leg.segments) + 1])
        colour = _COLOURS[i % len(_COLOURS)]
        cv2.polylines(picture, [corners.reshape(-1, 1, 2)], False, colour, 1, cv2.LINE_AA)
        for corner in corners:
            cv2.circle(picture, (int(corner[0]), int(corner[1])), 2, colour, -1)
        end = (int(corners[-1, 0]), int(corners[-1, 1]))
        cv2.putText(picture, leg.name, end, cv2.FONT_HERSHEY_SIMPLEX, 0.5, colour, 1)
    body = at(pose.xy)[0]
    cv2.circle(picture, (int(body[0]), int(body[1])), 4, (255, 0, 255), -1)
    for mark in at(marks) if marks is not None else ():
        cv2.circle(picture, (int(mark[0]), int(mark[1])), 6, (0, 0, 0), 1)
    cv2.imwrite(str(path), picture)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
    parser.add_argument("--only", nargs="+", choices=["spider", "fly"], default=["spider", "fly"])
    parser.add_argument("--pictures", type=Path, help="folder for pictures with the pose drawn")
    parser.add_argument("--starts", action="store_true", help="only the spider's start frames")
    parser.add_argument("--disturb", type=int, help="seed of a disturbed start of the fly")
    args = parser.parse_args()
    if args.pictures:
        args.pictures.mkdir(parents=True, exist_ok=True)
    spider = real.data_folder("spider-nephila")
    fly = real.data_folder("flies-topview") / "clip_inverted"
    for name, folder in (("spider", spider), ("fly", fly)):
        if name not in args.only:
            continue
        if not folder.exists():
            print(f"{name} left out: {folder} is not there (set PAWNB_TEST_DATA).")
        elif args.starts:
            if name == "spider":
                measure_starts(folder)
        elif name == "spider":
            measure_spider(folder, args.seeds, args.pictures)
        else:
            measure_fly(folder, args.pictures, args.disturb)


if __name__ == "__main__":
    main()
