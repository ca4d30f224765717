"""Paints the synthetic spider: how much light it stops, and what it shows of itself.

The animal is drawn several times as fine as the picture, at several moments while the
shutter is open. Each part has an optical density: the body stops the panel's light, a leg's
tip lets some of it through, and where legs cross their densities add up. What is not stopped
is the panel; what is stopped is replaced by the grey of the cuticle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.synthetic.spider_cuticle import DENSITY_STEP, BodyTexture, Hair, leg_hairs
from pawnb.synthetic.spider_scene import Individual, SpiderScene

_SHIFT = 4  # fractional bits of OpenCV's drawing
_ROOT_DENSITY = 3.2
_MARGIN_MM = 3.0
_PIECES = 4
_HAIR_WIDTH = 0.13


@dataclass(frozen=True)
class Shade:
    """The animal in one picture, in a crop that holds all of it.

    Attributes
    ----------
    u0, v0 : int
        The crop's first pixel in the picture.
    through : ndarray (h, w) float32
        Share of the light behind that comes through.
    own : ndarray (h, w) float32
        Grey levels of the animal itself.
    """

    u0: int
    v0: int
    through: Float32Array
    own: Float32Array


class Body(Protocol):
    """Paints the body of the animal; the methods are those of :class:`BodyTexture`."""

    extent_px: float

    def paint(
        self,
        density: np.ndarray,
        grey: np.ndarray,
        body: tuple[np.ndarray, float],
        *,
        fine_px_per_mm: float,
    ) -> None:
        """Paint the body over a fine picture.

        Parameters
        ----------
        density : ndarray, shape (H, W)
            How much light is stopped; changed in place.
        grey : ndarray, shape (H, W)
            What is shown of the animal itself; changed in place.
        body : tuple of (ndarray, float)
            Place (u, v), fine px, and heading, degrees, of the body.
        fine_px_per_mm : float
            Scale of the fine picture.
        """


class SpiderPainter:
    """Paints one individual.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    individual : Individual
        The animal.
    body : object, optional
        Paints the body; default a :class:`BodyTexture`, the body from above.
    """

    def __init__(
        self, scene: SpiderScene, individual: Individual, *, body: Body | None = None
    ) -> None:
        self._scene, self._individual = scene, individual
        self._fine = 4 if scene.scale > 0.7 else 6
        self._body = body or BodyTexture(scene, individual)
        rng = scene.rng(6)
        self._hairs = [leg_hairs(leg, rng) for leg in individual.animal.legs]
        self._bands = rng.uniform(0.04, 0.14)
        levels = np.arange(256) / DENSITY_STEP
        self._through = np.exp(-levels).astype(np.float32)

    def paint(self, joints_px: FloatArray, body: FloatArray) -> Shade:
        """Paint the animal at several moments and average them.

        Parameters
        ----------
        joints_px : ndarray (moments, legs, joints, 2)
            Joints and tips in the picture, px.
        body : ndarray (moments, 3)
            u, v in px and heading in degrees of the cephalothorax-abdomen joint.

        Returns
        -------
        Shade
            Blurred by the optics too.
        """
        scene, fine = self._scene, self._fine
        extent = self._body.extent_px
        points = np.concatenate(
            [joints_px.reshape(-1, 2), body[:, :2] - extent, body[:, :2] + extent]
        )
        margin = _MARGIN_MM * scene.px_per_mm + 4.0
        u0, v0 = np.floor(points.min(0) - margin).astype(int)
        u1, v1 = np.ceil(points.max(0) + margin).astype(int)
        size = (int(u1 - u0), int(v1 - v0))
        through = np.zeros(size[::-1], dtype=np.float32)
        own = np.zeros_like(through)
        for joints, (u, v, heading) in zip(joints_px, body, strict=True):
            # centres of the fine picture's pixels
            places = (joints - (u0, v0) + 0.5) * fine - 0.5
            at = (np.array([u, v]) - (u0, v0) + 0.5) * fine - 0.5
            density, grey = self._fine_picture(
                places, (at, heading), (size[0] * fine, size[1] * fine)
            )
            passed = self._through[density]
            through += cv2.resize(passed, size, interpolation=cv2.INTER_AREA)
            own += cv2.resize((1.0 - passed) * grey, size, interpolation=cv2.INTER_AREA)
        blur = max(0.3, scene.blur_px * scene.scale)
        n = len(body)
        return Shade(
            int(u0),
            int(v0),
            np.asarray(
                cv2.GaussianBlur(through / n, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)
            ),
            np.asarray(cv2.GaussianBlur(own / n, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)),
        )

    def _fine_picture(
        self, places: FloatArray, body: tuple[FloatArray, float], size: tuple[int, int]
    ) -> tuple[ByteArray, Float32Array]:
        """Return density (units of 1/DENSITY_STEP) and grey of the animal in the fine picture."""
        density = np.zeros(size[::-1], dtype=np.uint8)
        for number in range(len(places)):
            low = np.maximum(np.floor(places[number].min(0)).astype(int) - 60, 0)
            high = np.ceil(places[number].max(0)).astype(int) + 60
            part = density[low[1] : high[1], low[0] : high[0]]
            leg = np.zeros_like(part)
            self._paint_leg(leg, number, places[number] - low)
            cv2.add(part, leg, dst=part)
        grey = np.full(size[::-1], self._individual.grey + 6.0, dtype=np.float32)
        self._body.paint(density, grey, body, fine_px_per_mm=self._fine * self._scene.px_per_mm)
        return density, grey

    def _paint_leg(self, out: ByteArray, number: int, places: FloatArray) -> None:
        """Paint one leg from its tip to its root, so that the darker part lies on top."""
        leg, individual = self._individual.animal.legs[number], self._individual
        unit = individual.size * self._scene.px_per_mm * self._fine
        widths = individual.thickness * unit * np.array(leg.widths)
        nominal = np.concatenate([[0.0], np.cumsum(leg.lengths)])
        tip = self._scene.tip_density
        for hair in self._hairs[number]:
            _paint_hair(out, hair, places, unit)
        for j in reversed(range(len(leg.segments))):
            along = np.linspace(0.0, 1.0, _PIECES + 1)
            share = (nominal[j] + along * leg.lengths[j]) / nominal[-1]
            # paler outwards, most of it past the patella; faint rings along the leg
            dark = tip + (_ROOT_DENSITY - tip) * (1.0 - share**2.2)
            dark *= 1.0 + self._bands * np.cos(2 * np.pi * (along - 0.1)) * (j >= 2)
            radius = 0.5 * (widths[j] + along * (widths[j + 1] - widths[j]))
            swell = 0.12 * np.exp(-(((np.minimum(along, 1 - along)) / 0.1) ** 2))
            belly = 0.10 * np.sin(np.pi * along) * (leg.segments[j] == "Fe")
            last = j == len(leg.segments) - 1
            radius *= 1.0 + belly + swell * (np.ones(_PIECES + 1) if not last else along < 0.5)
            _paint_segment(out, places[j : j + 2], radius, dark, round_end=not last)


def _paint_segment(
    out: ByteArray, ends: FloatArray, radius: FloatArray, dark: FloatArray, *, round_end: bool
) -> None:
    """Paint one tapered segment in pieces, outermost first."""
    step = ends[1] - ends[0]
    length = float(np.hypot(*step))
    across = np.array([-step[1], step[0]]) / max(length, 1e-9)
    along = np.linspace(0.0, 1.0, len(radius))[:, None]
    # OpenCV fills the border of a polygon too, half a pixel on either side
    half = np.maximum(radius - 0.5, 0.3)[:, None] * across
    middle = ends[0] + along * step
    left, right = middle + half, middle - half
    if round_end:
        _circle(out, ends[1], radius[-1], dark[-1])
    for k in reversed(range(len(radius) - 1)):
        quad = np.array([left[k], left[k + 1], right[k + 1], right[k]])
        level = _level(0.5 * (dark[k] + dark[k + 1]))
        cv2.fillConvexPoly(
            out, np.round(quad * 2**_SHIFT).astype(np.int32), level, cv2.LINE_8, _SHIFT
        )
    _circle(out, ends[0], radius[0], dark[0])


def _circle(out: ByteArray, centre: FloatArray, radius: float, dark: float) -> None:
    at = np.round(centre * 2**_SHIFT).astype(int)
    size = max(1, round((radius - 0.5) * 2**_SHIFT))
    cv2.circle(out, (int(at[0]), int(at[1])), size, _level(dark), -1, cv2.LINE_8, _SHIFT)


def _paint_hair(out: ByteArray, hair: Hair, places: FloatArray, unit: float) -> None:
    """Paint one hair of a segment; ``unit`` is px per unit of the species file."""
    start, end = places[hair.segment], places[hair.segment + 1]
    step = end - start
    towards = np.arctan2(step[1], step[0]) + hair.side * hair.angle
    root = start + hair.along * step
    tip = root + hair.length * unit * np.array([np.cos(towards), np.sin(towards)])
    a, b = (np.round(p * 2**_SHIFT).astype(int) for p in (root, tip))
    cv2.line(
        out, (int(a[0]), int(a[1])), (int(b[0]), int(b[1])), _level(hair.density),
        max(1, round(_HAIR_WIDTH * unit)),
        cv2.LINE_8, _SHIFT,
    )  # fmt: skip


def _level(density: float) -> int:
    """Return a density in the units of the buffers."""
    return int(min(255, round(density * DENSITY_STEP)))
