"""What stands still around the synthetic spider: the light panel and the glass arena.

The arena of Pullar 2009, §2.2: glass walls 10 cm apart on three arrays of LEDs whose light
is scattered by paper, with a printed 1 cm grid. The picture shows its middle 26 cm.
"""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import Float32Array
from pawnb.synthetic.spider_scene import ARENA_WIDTH_MM, SpiderScene

_GLASS_MM = 2.6
_PANEL_MARGIN_MM = 13.0
_GRID_LINE_MM = 0.35
_LED_SPACING_MM = 10.0
_ARRAY_MM = 96.0
_DARK = 22.0
"""Grey level of the table beside the panel."""

_SHADOW_MM = 45.0
_SHADOW_EDGE_MM = 18.0
_SHADOW_SPEED_MM_S = 110.0


def wall_rows(scene: SpiderScene) -> tuple[float, float]:
    """Return the rows, px, of the inner faces of the upper and the lower wall."""
    middle = (scene.height - 1) / 2.0
    half = ARENA_WIDTH_MM / 2.0 * scene.px_per_mm
    return middle - half, middle + half


def paint_panel(scene: SpiderScene) -> Float32Array:
    """Paint the arena without the animal.

    Parameters
    ----------
    scene : SpiderScene
        The scene.

    Returns
    -------
    ndarray (h, w) float32
        Grey levels before noise.
    """
    rng = scene.rng(4)
    u, v = np.meshgrid(np.arange(scene.width), np.arange(scene.height))
    x = (u + 0.5).astype(np.float32) / scene.px_per_mm
    y = (v + 0.5).astype(np.float32) / scene.px_per_mm
    x -= scene.width / scene.px_per_mm / 2.0
    y -= scene.height / scene.px_per_mm / 2.0
    picture = _lamps(scene, (x, y), rng)
    picture *= _grid(scene, (x, y), rng)
    picture *= _debris(scene, rng)
    edge = ARENA_WIDTH_MM / 2.0
    lit = np.clip((edge + _PANEL_MARGIN_MM - np.abs(y)) / 1.2, 0.0, 1.0)
    # beside the arena the paper lets less light through
    lit *= np.where(np.abs(y) > edge + _GLASS_MM, 0.72, 1.0)
    table = _DARK + 6.0 * np.exp(-((np.abs(y) - edge - _PANEL_MARGIN_MM) / 12.0))
    picture = lit * picture + (1.0 - lit) * np.minimum(table, 34.0)
    picture *= _walls(np.abs(y) - edge)
    falling = 1.0 - scene.vignetting * (x**2 + y**2) / np.float32(168.0**2)
    picture *= falling
    blurred = cv2.GaussianBlur(
        picture.astype(np.float32), (0, 0), max(0.3, scene.blur_px * scene.scale)
    )
    return np.asarray(blurred, dtype=np.float32)


def _lamps(
    scene: SpiderScene, place: tuple[Float32Array, Float32Array], rng: np.random.Generator
) -> Float32Array:
    """Return the light of the three arrays behind the paper."""
    x, y = place
    offset = rng.uniform(0, _LED_SPACING_MM, 2)
    wave = 2 * np.pi / _LED_SPACING_MM
    light = 1.0 + 0.010 * (np.cos(wave * (x + offset[0])) + np.cos(wave * (y + offset[1])))
    shift = rng.uniform(-12, 12)
    for number, share in enumerate(1.0 + 0.03 * rng.standard_normal(3)):
        middle = shift + (number - 1) * _ARRAY_MM
        inside = 0.5 * (
            np.tanh((x - middle + _ARRAY_MM / 2) / 3.0)
            - np.tanh((x - middle - _ARRAY_MM / 2) / 3.0)
        )
        light = light + (share - 1.0) * inside
        light -= 0.02 * np.exp(-(((x - middle - _ARRAY_MM / 2) / 2.5) ** 2))  # seam of the arrays
    blotches = rng.standard_normal((9, 12)).astype(np.float32)
    light += 0.012 * cv2.resize(
        blotches, (scene.width, scene.height), interpolation=cv2.INTER_CUBIC
    )
    return np.asarray(scene.light * light, dtype=np.float32)


def _grid(
    scene: SpiderScene, place: tuple[Float32Array, Float32Array], rng: np.random.Generator
) -> Float32Array:
    """Return the share of light that the printed 1 cm grid lets through."""
    turn = np.radians(rng.uniform(-0.6, 0.6))
    x = np.cos(turn) * place[0] + np.sin(turn) * place[1] + rng.uniform(0, 10)
    y = np.cos(turn) * place[1] - np.sin(turn) * place[0] + rng.uniform(0, 10)
    line = np.zeros_like(x)
    pixel = 1.0 / scene.px_per_mm
    for across in (x, y):
        from_line = np.abs((across + 5.0) % 10.0 - 5.0)
        # exact share of the pixel that the line covers
        covered = np.clip((_GRID_LINE_MM / 2 + pixel / 2 - from_line) / pixel, 0.0, 1.0)
        line = np.maximum(line, covered * min(1.0, _GRID_LINE_MM / pixel))
    inside = np.abs(place[1]) < ARENA_WIDTH_MM / 2.0
    return np.asarray(1.0 - scene.grid * line * inside, dtype=np.float32)


def _debris(scene: SpiderScene, rng: np.random.Generator) -> Float32Array:
    """Return the share of light that specks, fibres and droplets on the panel let through."""
    fine = 4
    size = (scene.width * fine, scene.height * fine)
    dirt = np.zeros(size[::-1], dtype=np.uint8)
    px = scene.px_per_mm * fine
    for _ in range(scene.specks):
        at = (rng.uniform(0, size[0]), size[1] / 2 + rng.uniform(-48, 48) * px)
        centre = (round(at[0]), round(at[1]))
        dark = int(rng.uniform(60, 200))
        if rng.random() < 0.25:  # a fibre
            towards = rng.uniform(0, np.pi)
            reach = rng.uniform(1.0, 3.0) * px
            bend = rng.uniform(-0.6, 0.6)
            s = np.linspace(-1, 1, 9)
            path = np.array(at) + reach * np.stack(
                [np.cos(towards + bend * s) * s, np.sin(towards + bend * s) * s], axis=1
            )
            line = np.round(path).astype(np.int32)[:, None]
            cv2.polylines(dirt, [line], False, dark, max(1, round(0.1 * px)))
        else:
            radius = rng.uniform(0.1, 0.45, 2) * px
            axes = (max(1, round(radius[0])), max(1, round(radius[1])))
            cv2.ellipse(dirt, centre, axes, rng.uniform(0, 180), 0, 360, dark, -1)
    share = cv2.resize(dirt, (scene.width, scene.height), interpolation=cv2.INTER_AREA)
    return 1.0 - share.astype(np.float32) / 255.0


def _walls(beyond: Float32Array) -> Float32Array:
    """Return the share of light past the glass walls; ``beyond`` is mm past the inner face."""
    dark = 0.55 * np.exp(-(((beyond - 0.3) / 0.4) ** 2))
    dark += 0.4 * np.exp(-(((beyond - _GLASS_MM) / 0.45) ** 2))
    bright = 0.18 * np.exp(-(((beyond - 0.55 * _GLASS_MM) / 0.5) ** 2))
    return np.asarray(1.0 - dark + bright, dtype=np.float32)


class DriftingShade:
    """A soft band of shade that drifts over the panel.

    Parameters
    ----------
    scene : SpiderScene
        Its ``shadow`` says how dark it is; 0 casts none.
    """

    def __init__(self, scene: SpiderScene) -> None:
        rng = scene.rng(5)
        turn = rng.uniform(-0.5, 0.5)
        self._speed = _SHADOW_SPEED_MM_S * rng.uniform(0.7, 1.3) * (1 if rng.random() < 0.5 else -1)
        start = rng.uniform(-60.0, 20.0) * np.sign(self._speed)
        u, v = np.meshgrid(np.arange(scene.width), np.arange(scene.height))
        x = (u - scene.width / 2) / scene.px_per_mm
        y = (v - scene.height / 2) / scene.px_per_mm
        self._across = (np.cos(turn) * x + np.sin(turn) * y - start).astype(np.float32)
        self._dark = scene.shadow

    def light(self, time_s: float) -> np.ndarray | float:
        """Return the share of light that it leaves, (h, w) float32, or 1 without a shadow."""
        if self._dark == 0:
            return 1.0
        at = self._across - np.float32(self._speed * time_s)
        edge = np.float32(_SHADOW_EDGE_MM)
        band = np.tanh((at + _SHADOW_MM) / edge) - np.tanh((at - _SHADOW_MM) / edge)
        return np.asarray(1.0 - np.float32(0.5 * self._dark) * band)
