"""What stands still about a belt of glass that is seen, and lit, from below."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.synthetic.backdrop import (
    BELT_HALF_WIDTH_MM,
    BOX_HALF_LENGTH_MM,
    BOX_HEIGHT_MM,
    WALL_MM,
    Backdrop,
    Panel,
    fill_quad,
)
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.scene import SceneSettings

_CEILING_MM = 700.0
_CEILING_SHARE = 0.35
"""The ceiling is far from the lamps: so bright beside the curtains."""
_FRAME_MM = 14.0
_LAMP_IMAGES = 3


def make_glass_backdrop(camera: PinholeCamera, settings: SceneSettings) -> Backdrop:
    """Paint one view from below without the animal.

    The belt lies before the animal: ``rows`` are all rows, and ``belt`` is the share of a pixel
    that is seen through it. The lamps shine back from its lower face.
    """
    h, w = settings.height, settings.width
    rays = camera.rays(np.arange(w)[None], np.arange(h)[:, None])
    centre = camera.centre
    ground = centre[:2] - centre[2] / rays[..., 2:] * rays[..., :2]
    ceiling = centre[:2] + (_CEILING_MM - centre[2]) / rays[..., 2:] * rays[..., :2]
    rng = np.random.default_rng([settings.seed, 5, camera.name.encode()[-1]])
    blotch = cv2.resize(
        rng.standard_normal((6, 14)).astype(np.float32), (w, h), interpolation=cv2.INTER_CUBIC
    )
    fall = 1.0 - settings.light_gradient * (np.hypot(*np.moveaxis(ceiling, -1, 0)) / 600.0) ** 2
    shade = _CEILING_SHARE * settings.light * np.clip(fall, 0.3, None) * (1.0 + 0.06 * blotch)
    picture = shade[..., None] * np.array(settings.backdrop_rgb)
    for quad, rgb, opacity in _walls():
        alpha = opacity * fill_quad(camera, quad, (h, w))[..., None]
        picture += alpha * (np.array(rgb) * settings.light - picture)
    x, y = np.abs(np.moveaxis(ground, -1, 0))
    footprint = 0.5 / settings.scale
    belt = np.clip((BELT_HALF_WIDTH_MM - y) / footprint, 0.0, 1.0)
    frame = np.clip((y - WALL_MM) / footprint, 0.0, 1.0)
    frame *= np.clip((WALL_MM + _FRAME_MM - y) / footprint, 0.0, 1.0)
    glass = np.where(belt > 0, 0.90, 1.0) * (1.0 - frame)
    metal = frame * 70.0 * settings.light * (1.0 - 0.2 * (x / 200.0) ** 2)
    shine = 6.0 * belt * settings.light + metal
    for place in _lamp_images(rng):
        away = np.hypot(*np.moveaxis((ground - place) / [26.0, 9.0], -1, 0))
        shine = shine + 42.0 * settings.light * belt * np.exp(-(away**4))
    return Backdrop(
        picture=picture.astype(np.float32),
        rows=slice(0, h),
        ground_x=np.ascontiguousarray(ground[..., 0], dtype=np.float32),
        ground_y=np.ascontiguousarray(ground[..., 1], dtype=np.float32),
        belt=belt.astype(np.float32),
        glass=glass[..., None].astype(np.float32),
        reflection=np.repeat(shine[..., None], 3, axis=2).astype(np.float32),
    )


def _lamp_images(rng: np.random.Generator) -> FloatArray:
    """Return where on the belt the lamps are mirrored, mm: beside the middle, along the sides."""
    x = np.linspace(-120.0, 120.0, _LAMP_IMAGES) + rng.uniform(-15.0, 15.0, _LAMP_IMAGES)
    y = rng.choice([-1.0, 1.0], _LAMP_IMAGES) * rng.uniform(26.0, 44.0, _LAMP_IMAGES)
    return np.column_stack([x, y])


def _walls() -> list[Panel]:
    """Return the walls of the box as they are seen from below: a veil, and a bright lower edge."""
    length, top = BOX_HALF_LENGTH_MM, BOX_HEIGHT_MM
    pale, line = (120.0, 126.0, 120.0), (190.0, 198.0, 186.0)
    panels: list[Panel] = []
    for y in (-WALL_MM, WALL_MM):
        wall = [[-length, y, 0.0], [length, y, 0.0], [length, y, top], [-length, y, top]]
        edge = np.array(wall) * [1.0, 1.0, 0.0] + np.array([[0, -1.0, 0], [0, -1.0, 0],
                                                            [0, 1.0, 0], [0, 1.0, 0]])  # fmt: skip
        panels += [(np.array(wall), pale, 0.12), (edge, line, 0.6)]
    for x in (-length, length):
        end = [[x, -WALL_MM, 0.0], [x, WALL_MM, 0.0], [x, WALL_MM, top], [x, -WALL_MM, top]]
        panels.append((np.array(end), pale, 0.12))
    return panels
