"""Small films of which the truth is known."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from pawnb.core.compiled import Compiled
from pawnb.core.paws.offline.scene.registration.body_frame import ViewBodyFrame
from pawnb.core.paws.offline.scene.stack import BodyStack

PACKAGE = "pawnb.core.paws.offline."


def texture(height, width, *, seed, low, high):
    """Smooth noise between two levels."""
    noise = np.random.default_rng(seed).normal(size=(height, width))
    noise = cv2.GaussianBlur(noise, (0, 0), 1.5)
    return (low + high) / 2 + np.clip(noise / noise.std() / 2, -1, 1) * (high - low) / 2


@pytest.fixture(scope="session")
def make_texture():
    """Return a function that makes a picture of smooth noise, uint8."""

    def make(height, width, *, seed=0, low=40, high=220):
        return texture(height, width, seed=seed, low=low, high=high).astype(np.uint8)

    return make


@pytest.fixture(scope="session")
def film_animal():
    """Return a function that films a bright textured ellipse over a dark textured ground.

    ``centre`` (n, 2) in px, ``angle`` (n,) in rad from +u to +v; ``camera`` (n, 2) is how far
    the ground has been displaced in the picture. Gives uint8 (n, H, W).
    """

    def film(centre, angle, *, size=(160, 120), axes=(30, 13), camera=None, seed=0):
        n = len(centre)
        moved = np.zeros((n, 2)) if camera is None else np.asarray(camera, float)
        low, high = np.floor(moved.min(axis=0)), np.ceil(moved.max(axis=0))
        wide, tall = (np.array(size) + high - low).astype(int)
        ground = texture(tall, wide, seed=seed, low=20, high=80)
        side = 2 * max(axes) + 9
        coat = texture(side, side, seed=seed + 1, low=140, high=240)
        y, x = np.mgrid[:side, :side] - side // 2
        # falls from 1 to 0 over about a px
        inside = np.clip((1 - np.hypot(x / axes[0], y / axes[1])) * min(axes), 0, 1)
        pictures = np.empty((n, size[1], size[0]), np.uint8)
        for t in range(n):
            here = np.array(
                [[1, 0, *(moved[t, :1] - high[:1])], [0, 1, *(moved[t, 1:] - high[1:])]]
            )
            picture = cv2.warpAffine(ground, here, size)
            c, s = np.cos(angle[t]), np.sin(angle[t])
            A = np.array([[c, -s], [s, c]])
            put = np.hstack([A, (centre[t] - A @ [side // 2, side // 2])[:, None]])
            share = cv2.warpAffine(inside, put, size)
            picture = picture * (1 - share) + cv2.warpAffine(coat, put, size) * share
            pictures[t] = np.round(picture)
        return pictures

    return film


@dataclass
class ArrayViews:
    """Opened views that are arrays: name to pictures (n, H, W) or (n, H, W, 3)."""

    films: dict[str, np.ndarray]

    @property
    def names(self):
        return tuple(self.films)

    @property
    def n_frames(self):
        return min(map(len, self.films.values()))

    @property
    def readers(self):
        return {
            name: SimpleNamespace(width=film.shape[2], height=film.shape[1])
            for name, film in self.films.items()
        }

    def frame(self, i):
        return {
            name: SimpleNamespace(image=lambda film=film: film[i].copy())
            for name, film in self.films.items()
        }

    def frames(self, start, stop, *, step=1, partly=False):
        for i in range(start, stop, step):
            yield i, self.frame(i)


@pytest.fixture(scope="session")
def array_views():
    """Return the class of views that are arrays."""
    return ArrayViews


@pytest.fixture(scope="session")
def make_stack():
    """Return a function that makes a stack whose frame stays: working px are those of the view.

    Without flow unless it is given: one (x, y), in places, for every place and frame.
    """

    def make(grey, *, colour=None, spacing=3, flow=(0.0, 0.0)):
        n, height, width = grey.shape
        h, w = height // spacing, width // spacing
        forward = np.broadcast_to(np.float32(flow), (max(n - 1, 0), h, w, 2))
        body = ViewBodyFrame(np.zeros((n, 2)), np.zeros(n), "stays", pans=False)
        to_body = np.tile(np.eye(3)[:2], (n, 1, 1))
        return BodyStack(grey, colour, to_body, forward, -forward, spacing, body, 1.0, 60.0)

    return make


@pytest.fixture(params=["as written", pytest.param("compiled", marks=pytest.mark.slow)])
def steps_of_loops(request, monkeypatch):
    """Let Python run loops that only compiled code calls; slow tests compile them, too.

    By themselves they take seconds to compile; as parts of what calls them they are compiled
    in any case, and tested so.
    """
    if request.param == "compiled":
        return
    modules = [module for name, module in sys.modules.items() if name.startswith(PACKAGE)]
    for module in (*modules, request.module):
        for name, value in list(vars(module).items()):
            if isinstance(value, Compiled):
                monkeypatch.setattr(module, name, value.__wrapped__)
