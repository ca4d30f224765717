"""A dark stick animal painted on a light panel: pictures whose pose is known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions

SUBPIXEL = 8  # fractional bits of cv2's drawing


@dataclass
class PaintedFrame:
    """One picture, as far as the code asks for it."""

    picture: np.ndarray

    @property
    def width(self):
        return self.picture.shape[1]

    @property
    def height(self):
        return self.picture.shape[0]

    def image(self):
        return self.picture.copy()

    def crop(self, u0, v0, u1, v1):
        return self.picture[v0:v1, u0:u1].copy()


class PaintedReader:
    """Pictures in memory with the face of a ``ViewReader``."""

    name = "top"
    is_colour = False

    def __init__(self, pictures):
        self.pictures = pictures
        self.n_frames = len(pictures)
        self.height, self.width = pictures[0].shape[:2]

    def frame(self, index):
        return PaintedFrame(self.pictures[index])

    def again(self):
        return type(self)(self.pictures)

    def close(self):
        pass


def panel(size, *, light=200.0):
    """Return an empty light panel, darker towards its corners: (H, W) float, (width, height)."""
    width, height = size
    v, u = np.mgrid[:height, :width]
    r2 = ((u - width / 2) ** 2 + (v - height / 2) ** 2) / (width**2 + height**2)
    return light * (1 - 0.6 * r2)


def random_pose(animal: StickAnimal, rng, *, frame, xy, heading_deg, scale, share=0.5):
    """Return a pose: joints within a share of their ranges, legs raised by up to 15 %."""
    turn = rng.uniform(-0.5, 0.5, len(animal.range_deg)) * share * animal.range_deg
    return Poses(
        frames=np.array([frame]),
        xy=np.array([xy], dtype=float),
        heading_deg=np.array([heading_deg], dtype=float),
        scale=np.array([scale], dtype=float),
        angles_deg=(animal.natural_deg + turn)[None],
        lengths_px=(scale * animal.lengths * rng.uniform(0.85, 1.0, len(animal.lengths)))[None],
    )


def coverage(animal: StickAnimal, pose: Poses, size, *, fade=0.5):
    """Return how dark each pixel is, 0 to 1: 1 in the body, paler towards the tips."""
    width, height = size
    dark = np.zeros((height * 2, width * 2), np.float32)

    def point(uv):  # pixel centres of the finer picture
        return tuple(np.round((2 * np.asarray(uv) + 0.5) * 2**SUBPIXEL).astype(int))

    places = joint_positions(animal, pose)[0]
    scale = float(pose.scale[0])
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        for j in reversed(range(n)):  # the pale tip first, the dark root over it
            shade = 1.0 - fade * (j + 1) / n
            thick = max(1, round(scale * (leg.widths[j] + leg.widths[j + 1])))
            cv2.line(dark, point(places[i, j]), point(places[i, j + 1]), shade, thick,
                     cv2.LINE_AA, SUBPIXEL)  # fmt: skip
    turn = np.radians(float(pose.heading_deg[0]))
    for part in animal.body:
        x, y = part.centre
        centre = pose.xy[0] + scale * np.array(
            [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)]
        )
        axes = tuple(
            np.round(scale * np.array([part.length, part.width]) * 2**SUBPIXEL).astype(int)
        )
        cv2.ellipse(dark, point(centre), axes, float(pose.heading_deg[0]), 0, 360, 1.0, -1,
                    cv2.LINE_AA, SUBPIXEL)  # fmt: skip
    return cv2.resize(dark, (width, height), interpolation=cv2.INTER_AREA)


def paint(animal, pose, size, rng, *, noise=3.0, dark=45.0, empty=None):
    """Return one grey picture, uint8; ``pose`` None paints the empty panel."""
    picture = panel(size) if empty is None else empty.copy()
    if pose is not None:
        share = coverage(animal, pose, size)
        picture = picture * (1 - share) + dark * share
    return np.clip(picture + rng.normal(0, noise, picture.shape), 0, 255).round().astype(np.uint8)
