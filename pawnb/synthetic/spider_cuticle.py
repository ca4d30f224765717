"""The look of the synthetic spider: outline and pattern of its body, hairs of its legs."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.core.pose.animal import Leg
from pawnb.synthetic.spider_scene import Individual, SpiderScene

_TEXELS = 16.0  # per unit of the species file
_HALF_LENGTH, _HALF_WIDTH = 22.0, 9.0  # of the texture, units of the species file
BODY_DENSITY = 4.5
DENSITY_STEP = 40.0
"""Units of the 8-bit buffers of density in an optical density of 1."""


@dataclass(frozen=True)
class Hair:
    """A hair or spine of a leg.

    Attributes
    ----------
    segment : int
        Segment that it grows from.
    along : float
        Where, from 0 at the segment's inner end to 1.
    side : int
        1 or -1.
    angle : float
        From the segment's direction, rad.
    length : float
        Units of the species file.
    density : float
        Optical density.
    """

    segment: int
    along: float
    side: int
    angle: float
    length: float
    density: float


def leg_hairs(leg: Leg, rng: np.random.Generator) -> list[Hair]:
    """Draw the hairs of one leg: spines on femur to metatarsus, short ones on the tarsus.

    None reaches beyond the tip: it is where the leg ends.
    """
    hairs = []
    for segment, name in enumerate(leg.segments):
        spines = {"Fe": 5, "Pa": 2, "Ti": 7, "Me": 6, "Ta": 4}.get(name, 0)
        for _ in range(spines):
            long = rng.uniform(1.6, 2.6) if name in ("Ti", "Me") else rng.uniform(0.8, 1.6)
            hairs.append(
                Hair(
                    segment=segment,
                    along=float(rng.uniform(0.1, 0.6 if name == "Ta" else 0.9)),
                    side=1 if rng.random() < 0.5 else -1,
                    angle=float(rng.uniform(0.4, 0.9)),
                    length=float(long),
                    density=float(rng.uniform(0.5, 1.3)),
                )
            )
    return hairs


class BodyTexture:
    """The body seen from above, painted once and turned to its place in every picture.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    individual : Individual
        The animal.
    """

    def __init__(self, scene: SpiderScene, individual: Individual) -> None:
        rng = scene.rng(7)
        self._size = individual.size
        shape = (round(2 * _HALF_WIDTH * _TEXELS), round(2 * _HALF_LENGTH * _TEXELS))
        self._density = np.zeros(shape, dtype=np.float32)
        self._grey = np.full(shape, individual.grey, dtype=np.float32)
        self._paint_outline(individual, rng)
        self._paint_pattern(individual, rng)
        self._density[:] = cv2.GaussianBlur(self._density, (0, 0), 1.5)
        self._grey[:] = cv2.GaussianBlur(self._grey, (0, 0), 2.0)
        self.extent_px = _HALF_LENGTH * individual.size * scene.px_per_mm

    def paint(
        self,
        density: ByteArray,
        grey: Float32Array,
        body: tuple[FloatArray, float],
        *,
        fine_px_per_mm: float,
    ) -> None:
        """Paint the body over a fine picture.

        Parameters
        ----------
        density : ndarray (h, w) uint8
            Optical density, changed in place.
        grey : ndarray (h, w) float32
            Grey of the cuticle, changed in place.
        body : tuple
            Place (2,) in pixels of the fine picture, and heading in degrees.
        fine_px_per_mm : float
            Scale of the fine picture.
        """
        at, heading = body
        factor = self._size * fine_px_per_mm / _TEXELS
        turn = np.radians(heading)
        cos, sin = factor * np.cos(turn), factor * np.sin(turn)
        middle = (_HALF_LENGTH * _TEXELS - 0.5, _HALF_WIDTH * _TEXELS - 0.5)
        matrix = np.array(
            [
                [cos, -sin, at[0] - cos * middle[0] + sin * middle[1]],
                [sin, cos, at[1] - sin * middle[0] - cos * middle[1]],
            ]
        )
        corners = np.array([[x, y] for x in (-0.5, 2 * middle[0]) for y in (-0.5, 2 * middle[1])])
        box = corners @ matrix[:, :2].T + matrix[:, 2]
        u0, v0 = np.maximum(np.floor(box.min(axis=0)).astype(int) - 1, 0)
        u1, v1 = np.ceil(box.max(axis=0)).astype(int) + 2
        density, grey = density[v0:v1, u0:u1], grey[v0:v1, u0:u1]
        matrix[:, 2] -= (u0, v0)
        size = density.shape[1::-1]
        cover = cv2.warpAffine(self._density, matrix, size, flags=cv2.INTER_LINEAR)
        pattern = cv2.warpAffine(
            self._grey, matrix, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        np.copyto(grey, pattern, where=cover > 0.3 * BODY_DENSITY)
        np.maximum(density, (cover * DENSITY_STEP).astype(np.uint8), out=density)

    def _fill(self, outline: FloatArray, value: float, *, what: Float32Array) -> None:
        """Fill a polygon given in the body's frame (forward, right)."""
        texel = (outline + np.array([_HALF_LENGTH, _HALF_WIDTH])) * _TEXELS - 0.5
        cv2.fillPoly(what, [np.round(texel * 16).astype(np.int32)], value, cv2.LINE_8, 4)

    def _paint_outline(self, individual: Individual, rng: np.random.Generator) -> None:
        """Paint carapace, abdomen, the stalk between, palps and spinnerets."""
        for part in individual.animal.body:
            wide = part.width * individual.girth
            middle = part.centre[0]
            # the carapace is broadest behind its middle, the abdomen before its end
            skew = 0.16 if middle > 0 else 0.12
            self._fill(_egg((middle, part.length, wide), skew), BODY_DENSITY, what=self._density)
        stalk = np.array([[-1.5, -1.3], [1.5, -1.3], [1.5, 1.3], [-1.5, 1.3]])
        self._fill(stalk, BODY_DENSITY, what=self._density)
        front = max(p.centre[0] + p.length / 2 for p in individual.animal.body)
        rear = min(p.centre[0] - p.length / 2 for p in individual.animal.body)
        self._fill(_egg((rear - 0.1, 1.6, 1.6), 0.0), 2.5, what=self._density)
        for side in (-1, 1):
            fang = _egg((front - 0.3, 2.6, 1.9), 0.0, right=side * 1.2)
            self._fill(fang, 3.6, what=self._density)
            turn = rng.uniform(0.15, 0.45)
            palp = _egg((2.2, 4.6, 1.1), 0.1) @ np.array(
                [[np.cos(turn), side * np.sin(turn)], [-side * np.sin(turn), np.cos(turn)]]
            )
            self._fill(palp + np.array([front - 1.2, side * 2.4]), 2.0, what=self._density)

    def _paint_pattern(self, individual: Individual, rng: np.random.Generator) -> None:
        """Paint the pale margins of the carapace and the spots of the abdomen."""
        grey = individual.grey
        head, abdomen = individual.animal.body[0], individual.animal.body[-1]
        centre = head.centre[0]
        self._fill(
            _egg((centre, 0.88 * head.length, 0.80 * head.width), 0.16),
            grey + 16.0,
            what=self._grey,
        )
        self._fill(
            _egg((centre, 0.80 * head.length, 0.62 * head.width), 0.16), grey + 2.0, what=self._grey
        )
        self._fill(
            _egg((centre - 1.0, 0.5 * head.length, 0.10 * head.width), 0.0), grey + 18.0,
            what=self._grey,
        )  # fmt: skip
        along = np.linspace(0.30, -0.32, 4) * abdomen.length + abdomen.centre[0]
        for number, x in enumerate(along):
            size = 1.5 - 0.2 * number
            for side in (-1, 1):
                right = side * (0.22 - 0.03 * number) * abdomen.width
                spot = _egg((x, size, 0.8 * size), 0.0, right=right)
                self._fill(spot, grey + 26.0 + rng.uniform(-6, 6), what=self._grey)
        mark = _egg((abdomen.centre[0] + 0.2 * abdomen.length, 0.5 * abdomen.length, 1.5), 0.3)
        self._fill(mark, grey - 8.0, what=self._grey)
        grain = rng.standard_normal(self._grey.shape).astype(np.float32)
        self._grey += 14.0 * cv2.GaussianBlur(grain, (0, 0), 4.0)


def _egg(shape: tuple[float, float, float], skew: float, *, right: float = 0.0) -> FloatArray:
    """Return an egg (64, 2): centre along the body, length, width; broader behind by ``skew``."""
    centre, length, width = shape
    a = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    x, y = np.cos(a), np.sin(a) * (1.0 - skew * np.cos(a))
    y = y / np.abs(y).max()
    return np.stack([centre + length / 2 * x, right + width / 2 * y], axis=1)
