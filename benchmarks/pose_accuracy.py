"""Accuracy of the pose trackers on rendered spiders: the table of README, scene by scene.

python benchmarks/pose_accuracy.py --folder scenes [--difficulties easy normal hard]
    [--seeds 0 1 2 3 4] [--frames 120] [--scale 0.5] [--method pawnb] [--no-path] [--reverse]
    [--still]

Scenes are rendered where the folder lacks them. Each is tracked from its start pose disturbed at
random: 5 px in a random direction, and 5 degrees (standard deviation) of heading and each joint.
Frames that show the whole animal count.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import chi2

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background, find_background
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.pose_table import poses_from_table, read_start_pose
from pawnb.core.pose.poses import Poses, joint_positions, leg_angles, tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video import open_view
from pawnb.core.video.views import ViewReader
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial

DISTURB_PX, DISTURB_DEG = 5.0, 5.0
SWAP_SHARE = 0.05
"""A leg is swapped in a frame where its tip is further than this share of the leg span from its
own true tip and nearer to another leg's."""
EVENT_REACH = 4
"""An event is looked for so many frames about its true time."""


@dataclass
class Scene:
    """A rendered scene that is open."""

    folder: Path
    animal: StickAnimal
    start: Poses
    truth: Poses
    reader: ViewReader
    background: Background

    @property
    def whole(self) -> np.ndarray:
        """Return the frames that show the whole animal."""
        places = joint_positions(self.animal, self.truth)
        size = np.array([self.reader.width, self.reader.height])
        inside = ((places > 0) & (places < size - 1)).all(axis=(1, 2, 3))
        return self.truth.frames[inside]


def open_scene(folder: Path, options: dict[str, object]) -> Scene:
    """Open a scene, rendered first if it is not there."""
    if not (folder / "trial.toml").exists():
        render_spider_trial(folder, **options)  # type: ignore[arg-type]
    trial = load_trial(folder / "trial.toml")
    species = load_species(str(trial.animal.species), folder=folder)
    animal, start = read_start_pose(folder / "start_pose.csv", species)
    _, truth = poses_from_table(pd.read_csv(folder / "truth" / "pose.csv"), species)
    reader = open_view(trial.views[0], folder)
    background = find_background(reader, trial.views[0], folder=folder)
    return Scene(folder, animal, start, truth, reader, background)


def disturbed(pose: Poses, seed: int) -> Poses:
    """Return a pose moved and bent at random."""
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=2)
    return dataclasses.replace(
        pose,
        xy=pose.xy + DISTURB_PX * towards / np.hypot(*towards),
        heading_deg=pose.heading_deg + rng.normal(0.0, DISTURB_DEG),
        angles_deg=pose.angles_deg + rng.normal(0.0, DISTURB_DEG, pose.angles_deg.shape),
    )


def tracked(scene: Scene, start: Poses, *, choose_path: bool) -> tuple[PoseTrack, float]:
    """Return the track of a scene and the seconds it took."""
    began = time.perf_counter()
    track = track_pose(
        scene.reader, start, animal=scene.animal, background=scene.background,
        settings=PoseSettings(choose_path=choose_path), frames=(0, scene.reader.n_frames),
    )  # fmt: skip
    return track, time.perf_counter() - began


def errors(scene: Scene, track: PoseTrack) -> dict[str, np.ndarray]:
    """Return the errors in the frames with the whole animal; see the printed table."""
    frames = scene.whole
    true = scene.truth.take(np.searchsorted(scene.truth.frames, frames))
    rows = np.searchsorted(track.poses.frames, frames)
    found, animal = track.poses.take(rows), scene.animal
    span = animal.span * true.scale[0]
    tips, true_tips = tip_positions(animal, found), tip_positions(animal, true)
    away = np.linalg.norm(tips - true_tips, axis=-1)
    nearest = np.linalg.norm(tips[:, :, None] - true_tips[:, None], axis=-1).argmin(axis=2)
    elsewhere = nearest != np.arange(len(animal.legs))
    last = [len(leg.segments) for leg in animal.legs]
    sd = track.places_sd_px[rows][:, np.arange(len(last)), last]
    return {
        "body_px": np.hypot(*(found.xy - true.xy).T),
        "tip_percent": 100 * away / span,
        "leg_deg": leg_angles(animal, found) - leg_angles(animal, true),
        "joint_deg": found.angles_deg - true.angles_deg,
        "swapped": elsewhere & (away > SWAP_SHARE * span),
        "within": np.abs(tips - true_tips) < 1.96 * sd,
        "event_frames": event_errors(scene, track),
    }


def event_errors(scene: Scene, track: PoseTrack) -> np.ndarray:
    """Return how many frames the leg angle's extremes lie from true AEP and PEP."""
    events = pd.read_csv(scene.folder / "truth" / "events.csv")
    angles = leg_angles(scene.animal, track.poses)
    out = []
    for row in events.itertuples():
        leg = scene.animal.leg_names.index(row.leg)
        first = round(row.frame) - EVENT_REACH - int(track.poses.frames[0])
        part = angles[max(first, 0) : first + 2 * EVENT_REACH + 1, leg]
        if first < 0 or len(part) < 2 * EVENT_REACH + 1 or np.isnan(part).any():
            continue
        part = part if row.event == "AEP" else -part
        k = int(np.clip(np.argmax(part), 1, len(part) - 2))
        bend = part[k - 1] - 2 * part[k] + part[k + 1]
        shift = 0.5 * (part[k - 1] - part[k + 1]) / bend if bend < 0 else 0.0
        at = first + int(track.poses.frames[0]) + k + np.clip(shift, -1, 1)
        out.append(abs(at - row.frame))
    return np.array(out)


def rate_interval(count: int, total: int) -> tuple[float, float]:
    """Return the exact 95 % limits of a Poisson count per 1000."""
    low = chi2.ppf(0.025, 2 * count) / 2 if count else 0.0
    return 1000 * low / total, 1000 * chi2.ppf(0.975, 2 * count + 2) / 2 / total


def print_errors(name: str, parts: list[dict[str, np.ndarray]]) -> None:
    """Print one line of the table."""
    joined = {key: np.concatenate([p[key] for p in parts]) for key in parts[0]}
    rmse = {k: np.sqrt(np.nanmean(joined[k] ** 2)) for k in ("leg_deg", "joint_deg")}
    swaps, total = int(joined["swapped"].any(axis=1).sum()), len(joined["swapped"])
    low, high = rate_interval(swaps, total)
    event = np.median(joined["event_frames"]) if len(joined["event_frames"]) else np.nan
    lost = int(np.isnan(joined["body_px"]).sum())
    body_median, body_95 = np.nanpercentile(joined["body_px"], (50, 95))
    print(
        f"{name:12s} frames {total:5d} lost {lost:3d} | body "
        f"{body_median:.2f} px (95 % {body_95:.2f})"
        f" | tip % {np.nanmedian(joined['tip_percent']):.2f} "
        f"(95 % {np.nanpercentile(joined['tip_percent'], 95):.2f}) | leg deg {rmse['leg_deg']:.2f} "
        f"| joint deg {rmse['joint_deg']:.2f} | swaps/1000 {1000 * swaps / total:.1f} "
        f"({low:.1f} to {high:.1f}) | AEP/PEP {event:.2f} | tips within 95 % limits "
        f"{100 * np.mean(joined['within']):.0f} %",
        flush=True,
    )


def print_reverse(name: str, scenes: Iterable[Scene]) -> None:
    """Print how far tracks from the first and the last whole frame differ."""
    parts = []
    for scene in scenes:
        frames = scene.whole
        ends = [scene.truth.at_frame(int(frames[0])), scene.truth.at_frame(int(frames[-1]))]
        ways = [
            tracked(scene, disturbed(end, 100 + i), choose_path=True)[0].poses
            for i, end in enumerate(ends)
        ]
        one, other = (leg_angles(scene.animal, way.take(frames)) for way in ways)
        parts.append(one - other)
    apart = np.concatenate(parts)
    print(
        f"{name:12s} forward against reverse: leg angle RMS {np.sqrt(np.nanmean(apart**2)):.2f} "
        f"deg, median {np.nanmedian(np.abs(apart)):.3f}, within 0.5 deg "
        f"{100 * np.mean(np.abs(apart) < 0.5):.1f} %",
        flush=True,
    )


def print_still(name: str, scene: Scene) -> None:
    """Print error and spread on an animal that holds its posture."""
    track, _ = tracked(scene, disturbed(scene.start, 0), choose_path=True)
    frames = scene.whole
    true = scene.truth.take(np.searchsorted(scene.truth.frames, frames))
    found = track.poses.take(frames)
    away = found.xy - true.xy
    legs = leg_angles(scene.animal, found) - leg_angles(scene.animal, true)
    print(
        f"{name:12s} frames {len(frames)} body: mean error {np.hypot(*away.mean(axis=0)):.3f} px, "
        f"SD {away.std(axis=0).max():.4f} px | leg angle: median error "
        f"{np.median(np.abs(legs.mean(axis=0))):.3f} deg, SD median "
        f"{np.median(legs.std(axis=0)):.3f}, greatest {legs.std(axis=0).max():.3f} deg | drift "
        f"found {np.polyfit(frames, np.hypot(*(found.xy - found.xy[0]).T), 1)[0]:.4f} px a frame",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--difficulties", nargs="+", default=["easy", "normal", "hard"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2, 3, 4])
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--scale", type=float, default=0.5)
    parser.add_argument("--no-path", action="store_true", help="each frame from the one before")
    parser.add_argument("--reverse", action="store_true", help="forward against reverse")
    parser.add_argument("--still", action="store_true", help="still and drifting animals")
    args = parser.parse_args()
    options: dict[str, object] = {"frames": args.frames, "scale": args.scale}
    if args.still:
        for seed, motion in itertools.product(args.seeds, ("still", "drift")):
            more = {**options, "seed": seed, "difficulty": "normal", "motion": motion}
            scene = open_scene(args.folder / f"normal{seed}-{motion}", more)
            print_still(f"{motion} {seed}", scene)
        return
    for difficulty in args.difficulties:
        scenes = [
            open_scene(
                args.folder / f"{difficulty}{seed}",
                {**options, "seed": seed, "difficulty": difficulty},
            )
            for seed in args.seeds
        ]
        if args.reverse:
            print_reverse(difficulty, scenes)
            continue
        parts = []
        for seed, scene in zip(args.seeds, scenes, strict=True):
            track, _ = tracked(scene, disturbed(scene.start, seed), choose_path=not args.no_path)
            parts.append(errors(scene, track))
            print_errors(f"{difficulty} {seed}", parts[-1:])
        print_errors(f"{difficulty} all", parts)


if __name__ == "__main__":
    main()
