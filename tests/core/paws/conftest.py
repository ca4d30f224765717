"""A small scene of coloured discs that move in space before two, three or more cameras."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import pytest

from pawnb.core.rig import Rig

WIDTH, HEIGHT = 320, 160
PINK, GREEN, FUR = (225, 130, 150), (40, 120, 60), (70, 60, 50)


@functools.cache
def noise(frame, view):
    """Noise of one picture, in whole grey levels, the same in every scene."""
    levels = np.random.default_rng([frame, view]).normal(0, 3, (HEIGHT, WIDTH, 3))
    return np.floor(levels).astype(np.int8)


class Picture:
    """A frame as the tracker needs it; refuses crops outside, as real ones do."""

    def __init__(self, pixels):
        self.pixels = pixels
        self.height, self.width = pixels.shape[:2]

    def crop(self, u0, v0, u1, v1):
        assert 0 <= u0 < u1 <= self.width
        assert 0 <= v0 < v1 <= self.height
        return self.pixels[v0:v1, u0:u1]


@dataclass
class DiscScene:
    """Discs of 6 px radius; each moves along x and swings in z, none meets another.

    ``xyz`` (n_frames, n_points, 3) in mm; ``uv`` (n_frames, n_views, n_points, 2) in px.
    """

    names: tuple[str, ...]
    points: tuple[str, ...]
    rig: Rig
    xyz: np.ndarray
    uv: np.ndarray
    colours: np.ndarray
    grey: bool = False
    hidden: set = field(default_factory=set)  # (frame, view, point) not drawn
    asked: list = field(default_factory=list)

    @property
    def n_frames(self):
        return len(self.xyz)

    @property
    def readers(self):
        return {name: Picture(np.zeros((HEIGHT, WIDTH))) for name in self.names}

    def frame(self, i):
        return {name: Picture(self._draw(i, v)) for v, name in enumerate(self.names)}

    def frames(self, start, stop, *, step=1, partly=False):
        for i in range(start, stop, step):
            self.asked.append(i)
            yield i, self.frame(i)

    def _draw(self, i, view):
        pixels = np.empty((HEIGHT, WIDTH, 3), np.int16)
        pixels[:] = GREEN
        pixels[: HEIGHT // 6] = FUR
        for p, (name, colour) in enumerate(zip(self.points, self.colours, strict=True)):
            if (i, self.names[view], name) not in self.hidden:
                u, v = self.uv[i, view, p]
                part = tuple(slice(max(0, round(at) - 7), max(0, round(at) + 8)) for at in (v, u))
                row, column = np.ogrid[:HEIGHT, :WIDTH]
                near = np.hypot(column[:, part[1]] - u, row[part[0]] - v) < 6
                pixels[part][near] = colour
        pixels = np.clip(pixels + noise(i, view), 0, 255).astype(np.uint8)
        return (pixels @ [0.3, 0.6, 0.1]).astype(np.uint8) if self.grey else pixels

    def clicks(self, frame=0, *, leave_out=()):
        rows = [
            (frame, view, point, *self.uv[frame, v, p])
            for v, view in enumerate(self.names)
            for p, point in enumerate(self.points)
            if (view, point) not in leave_out
        ]
        return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


def camera(angle_deg, *, affine=False):
    """Coefficients of a camera that looks at the origin from the side, 400 mm away."""
    a = np.radians(angle_deg)
    right = np.array([np.cos(a), np.sin(a), 0.0])
    forth = np.array([-np.sin(a), np.cos(a), 0.0])
    away, focal = 400.0, 800.0
    depth = np.append(forth / away, 1.0)  # X -> depth / away, 1 at the origin
    scale = focal / away
    if affine:
        depth = np.array([0.0, 0.0, 0.0, 1.0])
    u = scale * np.append(right, 0.0) + WIDTH / 2 * depth
    v = scale * np.array([0.0, 0.0, -1.0, 0.0]) + HEIGHT / 2 * depth
    return np.concatenate([u, v, depth[:3]])


@pytest.fixture
def make_scene():
    """Return a function that makes a scene: points move 0.8 mm (about 1.6 px) a frame."""

    def make(
        points=("FR", "HR"), *, angles=(-20, 20), n_frames=25, grey=False, affine=False, speed=0.8
    ):
        names = tuple(f"cam{k + 1}" for k in range(len(angles)))
        coefs = np.stack([camera(a, affine=affine) for a in angles], axis=-1)
        rig = Rig(names=names, coefs=coefs, unit="mm")
        t = np.arange(n_frames)[:, None]
        place = np.linspace(-45, 25, len(points)) if len(points) > 1 else np.array([-10.0])
        xyz = np.stack(
            [
                place + speed * t,
                np.broadcast_to(np.linspace(-8, 8, len(points)), (n_frames, len(points))),
                -5 + 8 * np.sin(2 * np.pi * t / 20 + np.arange(len(points))),
            ],
            axis=-1,
        )
        uv = np.swapaxes(rig.project(xyz), 1, 2)
        colours = np.tile(PINK, (len(points), 1))
        return DiscScene(names, tuple(points), rig, xyz, uv, colours, grey=grey)

    return make
