"""From what happens to a grey video: panel, shadow, reflections, animal, sensor."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array
from pawnb.synthetic.grey_video import GreyVideoWriter
from pawnb.synthetic.spider_paint import Shade, SpiderPainter
from pawnb.synthetic.spider_panel import DriftingShade, paint_panel, wall_rows
from pawnb.synthetic.spider_recording import SpiderRecording
from pawnb.synthetic.spider_scene import FPS, SpiderScene
from pawnb.synthetic.spider_side import SideView

Progress = Callable[[int, int], None]

_REFLECTION_MM = 11.0
_REACH_MM = 16.0
"""How far from the wall its mirror image fades to a third, and where it ends."""


def render_video(
    path: Path, recording: SpiderRecording, *, views: int, progress: Progress | None
) -> None:
    """Paint all frames in order and write them to a video.

    Parameters
    ----------
    path : Path
        The video.
    recording : SpiderRecording
        What happens.
    views : int
        2 paints the side view too.
    progress : callable, optional
        Called with (frames done, frames in all).
    """
    scene = recording.scene
    painter = SpiderPainter(scene, recording.individual)
    side = SideView(recording) if views == 2 else None
    panel, shadow = paint_panel(scene), DriftingShade(scene)
    if side is not None:
        side.paint_backdrop(panel)
    sensor = _Sensor(scene)
    row_of = {int(frame): row for row, frame in enumerate(recording.poses.frames)}
    held: list[Shade] = []
    with GreyVideoWriter(path, size=(scene.width, scene.height), fps=FPS) as writer:
        for frame in range(recording.n_frames):
            picture = panel * shadow.light(frame / FPS)
            row = row_of.get(frame)
            if row is not None:
                shades = held or [painter.paint(recording.joints_px[row], recording.bodies[row])]
                if side is not None and not held:
                    shades.append(side.paint(row))
                held = shades if scene.motion == "still" else []
                _reflect(picture, shades[0], scene)
                for shade in shades:
                    _put(picture, shade)
            writer.write(sensor.expose(picture))
            if progress is not None:
                progress(frame + 1, recording.n_frames)


def _put(picture: Float32Array, shade: Shade) -> None:
    """Put the animal in the picture, in place."""
    height, width = picture.shape
    rows = slice(max(shade.v0, 0), min(shade.v0 + shade.through.shape[0], height))
    columns = slice(max(shade.u0, 0), min(shade.u0 + shade.through.shape[1], width))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        return
    part = (
        slice(rows.start - shade.v0, rows.stop - shade.v0),
        slice(columns.start - shade.u0, columns.stop - shade.u0),
    )
    picture[rows, columns] = picture[rows, columns] * shade.through[part] + shade.own[part]


def _reflect(picture: Float32Array, shade: Shade, scene: SpiderScene) -> None:
    """Add the animal's mirror images in the glass walls, in place: fainter further from them."""
    width = shade.through.shape[1]
    for wall, beyond in zip(wall_rows(scene), (-1, 1), strict=True):
        reach = int(_REACH_MM * scene.px_per_mm)
        v0 = int(np.ceil(wall)) if beyond > 0 else int(np.floor(wall)) - reach + 1
        rows = np.arange(v0, v0 + reach)
        # row v of the mirror image shows row 2 wall - v of the animal
        matrix = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 2 * wall - v0 - shade.v0]])
        stopped = cv2.warpAffine(
            1.0 - shade.through, matrix, (width, reach), flags=cv2.INTER_LINEAR
        )
        fade = np.exp(-np.abs(rows - wall) / (_REFLECTION_MM * scene.px_per_mm))
        image = 1.0 - scene.reflection * fade[:, None] * stopped
        mirrored = Shade(shade.u0, v0, image.astype(np.float32), np.zeros_like(stopped))
        _put(picture, mirrored)


class _Sensor:
    """Light to grey levels of 8 bits."""

    def __init__(self, scene: SpiderScene) -> None:
        self._scene = scene
        self._rng = scene.rng(10)
        size = (scene.height, scene.width)
        # each pixel's own offset, which does not change
        self._offset = (0.3 * scene.read_noise * self._rng.standard_normal(size)).astype(np.float32)

    def expose(self, picture: Float32Array) -> ByteArray:
        """Return one frame (h, w) uint8."""
        scene = self._scene
        lamp = 1.0 + scene.flicker * self._rng.standard_normal()
        light = np.float32(lamp) * picture.astype(np.float32)
        noise = self._rng.standard_normal(light.shape, dtype=np.float32)
        spread = np.sqrt(scene.read_noise**2 + scene.shot_noise**2 / 255.0 * np.maximum(light, 0))
        grey = light + self._offset + spread.astype(np.float32) * noise
        return np.clip(np.rint(grey), 0, 255).astype(np.uint8)
