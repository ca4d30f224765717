"""A walking spider painted from known poses, and a reader of its frames, without a video."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pawnb.core.pixels.colour import GreyPicture
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.species_file import load_species
from pawnb.core.video.views import Frame

PX_PER_MM = 2.1
NOISE = 3.0


class PaintedReader:
    """Frames from arrays, with the face of a ViewReader."""

    def __init__(self, images: list[np.ndarray]) -> None:
        self.images = images
        self.n_frames = len(images)
        self.height, self.width = images[0].shape

    def frame(self, index: int) -> Frame:
        picture = GreyPicture(self.images[index])
        return Frame(index, picture, (0, 0, self.width, self.height))

    def again(self) -> PaintedReader:
        return type(self)(self.images)

    def close(self) -> None:
        pass


def walking_poses(animal: StickAnimal, n: int) -> Poses:
    """Eight legs swing in alternation; raised legs are shorter in the picture."""
    t = np.arange(n)
    angles = np.tile(animal.natural_deg, (n, 1))
    lengths = np.tile(animal.lengths * PX_PER_MM, (n, 1))
    for i, leg in enumerate(animal.legs):
        swing = 2 * np.pi * (t / 18 + (i % 2) / 2 + (leg.side > 0) / 2)
        j = 5 * i
        angles[:, j] += 0.25 * leg.range_deg[0] * np.sin(swing)
        angles[:, j + 1] += 8 * np.sin(swing + 0.5)
        angles[:, j + 4] += 10 * np.sin(swing)
        lengths[:, 7 * i : 7 * i + 7] *= (1 - 0.15 * np.clip(np.cos(swing), 0, 1))[:, None]
    return Poses(
        frames=t,
        xy=np.column_stack([120 + 4.0 * t, 130 + 5 * np.sin(t / 9)]),
        heading_deg=4 * np.sin(t / 11),
        scale=np.full(n, PX_PER_MM),
        angles_deg=angles,
        lengths_px=lengths,
    )


def painted_walk(
    n: int = 12, *, seed: int = 0, poses: Poses | None = None
) -> tuple[StickAnimal, Poses, PaintedReader, SimpleNamespace]:
    """Return the animal, its true poses (or those given), its frames and the background."""
    animal = load_species("dolomedes")
    poses = walking_poses(animal, n) if poses is None else poses
    rng = np.random.default_rng(seed)
    height, width = 270, 240 + 4 * n
    layout = make_layout(animal, px_per_unit=PX_PER_MM, dark=0.75)
    v, u = np.mgrid[:height, :width]
    empty = 210 - 60 * (((u - width / 2) / width) ** 2 + ((v - height / 2) / height) ** 2)
    canvas = make_canvas(height, width, layout)
    images = []
    for pose in pose_vectors(animal, poses):
        paint(layout, pose, 1.8, np.zeros(2), *canvas)
        seen = empty * (1 - canvas[0]) + rng.normal(0, NOISE, empty.shape)
        images.append(np.clip(seen, 0, 255).astype(np.uint8))
    background = SimpleNamespace(
        mean=empty.astype(np.float32), sd=np.full(empty.shape, NOISE, np.float32)
    )
    return animal, poses, PaintedReader(images), background
