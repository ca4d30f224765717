"""Two real animals seen by one camera: where their recordings are, and poses to start from.

``spider-nephila`` and ``flies-topview`` in the folder named by PAWNB_TEST_DATA (default:
../shared/data).
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background, find_background
from pawnb.core.pose.poses import Poses, joint_positions, natural_pose, poses_from_joints
from pawnb.core.pose.species_file import load_species
from pawnb.core.video import open_view
from pawnb.core.video.views import ViewReader
from pawnb.trial import View

SPIDER = View(
    name="front", video="spider_video.mp4", background="background_synth_without_female.png"
)
FLY = View(name="top", video="frame*.png", background="background.png")
DRAWN_FRAME = 600
_SPIDER_PX_PER_UNIT = 2.2
_FLY_PX_PER_UNIT = 30.0
"""So that the species' body is as long as this animal's."""
_FLY_NODES = {
    "L1": "forelegL4", "R1": "forelegR4", "L2": "midlegL4", "R2": "midlegR4",
    "L3": "hindlegL4", "R3": "hindlegR4",
}  # fmt: skip


def data_folder(name: str) -> Path:
    """Return where a recording is, or would be."""
    home = os.environ.get("PAWNB_TEST_DATA", Path(__file__).parents[2] / "shared" / "data")
    return Path(home) / name


@contextmanager
def opened(view: View, folder: Path) -> Iterator[tuple[ViewReader, Background]]:
    """Open a view and find its empty scene."""
    with open_view(view, folder) as reader:
        yield reader, find_background(reader, view, folder=folder)


def disturbed(pose: Poses, seed: int, *, px: float = 5.0, deg: float = 5.0) -> Poses:
    """Return a pose moved by ``px`` in a random direction; heading and joints turned by ``deg``."""
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=2)
    return dataclasses.replace(
        pose,
        xy=pose.xy + px * towards / np.hypot(*towards),
        heading_deg=pose.heading_deg + rng.normal(0.0, deg),
        angles_deg=pose.angles_deg + rng.normal(0.0, deg, pose.angles_deg.shape),
    )


def drawn_legs(folder: Path) -> dict[str, np.ndarray]:
    """Return the legs of the spider as someone drew them in frame 600: (corners, 2), u and v.

    The drawing says L for the left of the picture. The spider hangs head down, so that is her
    right where she is looked at from above, as the tracker takes it.
    """
    table = pd.read_csv(folder / "frame600_manual_polyline.csv")
    other = {"L": "R", "R": "L"}
    return {
        other[str(name)[0]] + str(name)[1]: part[["x", "y"]].to_numpy(dtype=float)
        for name, part in table.groupby("part")
        if str(name)[0] in other and len(str(name)) == 2
    }


def along(line: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the places at some shares of the length of a line of corners (n, 2)."""
    far = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return np.column_stack([np.interp(shares * far[-1], far, line[:, i]) for i in (0, 1)])


def spider_start(folder: Path, *, frame: int) -> tuple[StickAnimal, Poses]:
    """Return the spider, her legs as long as drawn, and the drawn pose as that of a frame."""
    table = pd.read_csv(folder / "frame600_manual_polyline.csv").set_index("part")[["x", "y"]]
    lines, species = drawn_legs(folder), load_species("spider")
    front, rear, middle = (
        table.loc[name].to_numpy(dtype=float)
        for name in ("prosoma_front", "abdomen_tip", "pedicel")
    )
    heading = float(np.degrees(np.arctan2(*(front - rear)[::-1])))
    flat = {leg.name: sum(leg.lengths) * _SPIDER_PX_PER_UNIT for leg in species.legs}
    drawn = {name: np.hypot(*np.diff(line, axis=0).T).sum() for name, line in lines.items()}
    animal = species.resized({name: drawn[name] / flat[name] for name in flat})
    pose = natural_pose(
        animal, frame=frame, xy=(middle[0], middle[1]), heading_deg=heading,
        scale=_SPIDER_PX_PER_UNIT,
    )  # fmt: skip
    return animal, _bent_along(animal, pose, lines)


def _bent_along(animal: StickAnimal, pose: Poses, lines: dict[str, np.ndarray]) -> Poses:
    """Return the pose with each leg laid along a line from its body-coxa joint."""
    places = joint_positions(animal, pose)
    for i, leg in enumerate(animal.legs):
        ends = np.concatenate([[0.0], np.cumsum(leg.lengths)]) / sum(leg.lengths)
        line = np.vstack([places[0, i, :1], lines[leg.name][1:]])
        places[0, i, : len(ends)] = along(line, ends)
    bent = poses_from_joints(
        animal, places, frames=pose.frames, xy=pose.xy, heading_deg=pose.heading_deg,
        scale=pose.scale,
    )  # fmt: skip
    return dataclasses.replace(bent, lengths_px=pose.lengths_px)


def fly_tips(folder: Path) -> pd.DataFrame:
    """Return the tips of the fly's legs as SLEAP found them: frame, leg, u, v, score."""
    table = pd.read_csv(folder / "points.csv")
    legs = {node: leg for leg, node in _FLY_NODES.items()}
    table = table[table["node"].isin(legs)]
    return pd.DataFrame(
        {
            "frame": table["frame"],
            "leg": table["node"].map(legs),
            "u": table["x"],
            "v": table["y"],
            "score": table["score"],
        }
    ).reset_index(drop=True)


def fly_start(folder: Path, *, frame: int = 0) -> tuple[StickAnimal, Poses]:
    """Return the insect, and a start pose as from clicks: the body, and straight legs to tips."""
    animal = load_species("insect")
    table = pd.read_csv(folder / "points.csv")
    body = table[table["frame"] == frame].set_index("node")[["x", "y"]]
    head, rear = (body.loc[name].to_numpy(dtype=float) for name in ("head", "abdomen"))
    ahead = (head - rear) / np.hypot(*(head - rear))
    # SLEAP's head lies at its front edge
    front = max(part.centre[0] + part.length / 2 for part in animal.body)
    at = head - ahead * front * _FLY_PX_PER_UNIT
    pose = natural_pose(
        animal, frame=frame, xy=(at[0], at[1]), scale=_FLY_PX_PER_UNIT,
        heading_deg=float(np.degrees(np.arctan2(ahead[1], ahead[0]))),
    )  # fmt: skip
    lines = {
        leg: np.vstack([at, body.loc[node].to_numpy(dtype=float)])
        for leg, node in _FLY_NODES.items()
    }
    return animal, _bent_along(animal, pose, lines)
