"""What stands still around the synthetic mouse, and the belt that does not.

The treadmill of the 2019 paper, simplified: a green belt inside a box of plexiglass, a
green deck around it, grey curtains behind. Each pixel is found on these planes by its
ray; edges of plexiglass are drawn as quadrilaterals in 3D.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.scene import SceneSettings

BELT_HALF_WIDTH_MM = 60.0
BOX_HALF_LENGTH_MM = 185.0
WALL_MM = BELT_HALF_WIDTH_MM + 2.0
BOX_HEIGHT_MM = 150.0
_DECK_HALF_LENGTH_MM = 290.0
_DECK_HALF_WIDTH_MM = 210.0
_CURTAIN_MM = 420.0

BELT_TEXEL_MM = 0.5
_BELT_LENGTH_MM = 720.0
"""Length after which the marks on the belt repeat."""

Quad = np.ndarray
Panel = tuple[Quad, tuple[float, float, float], float]


@dataclass(frozen=True)
class Backdrop:
    """One view without the animal.

    Attributes
    ----------
    picture : ndarray (h, w, 3) float32
        Everything behind the animal, the belt without its marks.
    rows : slice
        Rows that hold ground the animal can stand on or shade.
    ground_x, ground_y : ndarray (rows, w) float32
        Point of the belt's plane under each of these pixels, mm.
    belt : ndarray (rows, w) float32
        Share of the pixel that is belt.
    glass : ndarray (h, w, 1) float32
        Share of the light that the near wall lets through.
    reflection : ndarray (h, w, 3) float32
        What the near wall adds.
    """

    picture: Float32Array
    rows: slice
    ground_x: Float32Array
    ground_y: Float32Array
    belt: Float32Array
    glass: Float32Array
    reflection: Float32Array


def make_belt(settings: SceneSettings) -> Float32Array:
    """Paint the marks of the belt: relative brightness about 0, periodic along the belt.

    Returns
    -------
    ndarray (across, along) float32
        One value every BELT_TEXEL_MM; row 0 is at -BELT_HALF_WIDTH_MM - 4 mm.
    """
    rng = np.random.default_rng([settings.seed, 4])
    n_along = round(_BELT_LENGTH_MM / BELT_TEXEL_MM)
    n_across = round(2 * (BELT_HALF_WIDTH_MM + 4.0) / BELT_TEXEL_MM)
    marks = np.zeros((n_across, n_along), dtype=np.float32)
    for strength, across, along in ((0.020, 1.0, 8.0), (0.022, 10.0, 24.0), (0.012, 0.8, 0.8)):
        grain = _periodic_blur(rng.standard_normal(marks.shape), across, along)
        marks += (strength * grain / grain.std()).astype(np.float32)
    stains = np.zeros_like(marks)
    for _ in range(60):
        centre = (int(rng.uniform(0, n_along)), int(rng.uniform(0, n_across)))
        axes = (int(rng.uniform(1, 9)), int(rng.uniform(1, 4)))
        cv2.ellipse(stains, centre, axes, rng.uniform(-15, 15), 0, 360, rng.uniform(0.3, 1.0), -1)
    marks -= 0.13 * _periodic_blur(stains, 1.2, 2.0).astype(np.float32)
    return settings.belt_marks * marks


def _periodic_blur(image: np.ndarray, across: float, along: float) -> FloatArray:
    """Blur with Gaussians (standard deviations in texels), periodic in both directions."""
    fy = np.fft.fftfreq(image.shape[0])[:, None]
    fx = np.fft.rfftfreq(image.shape[1])[None]
    damp = np.exp(-2.0 * np.pi**2 * ((across * fy) ** 2 + (along * fx) ** 2))
    return np.fft.irfft2(np.fft.rfft2(image) * damp, s=image.shape)


def make_backdrop(camera: PinholeCamera, settings: SceneSettings) -> Backdrop:
    """Paint one view without the animal.

    Parameters
    ----------
    camera : PinholeCamera
        The view.
    settings : SceneSettings
        Size, colours, light.

    Returns
    -------
    Backdrop
        float32 pictures in grey levels 0-255.
    """
    h, w = settings.height, settings.width
    rays = camera.rays(np.arange(w)[None], np.arange(h)[:, None]).astype(np.float32)
    centre = camera.centre.astype(np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, -centre[2] / rays[..., 2], np.float32(np.inf))
        ground = centre[:2] + depth[..., None] * rays[..., :2]
    rng = np.random.default_rng([settings.seed, 5, camera.name.encode()[-1]])
    picture = _curtain(camera, rays, settings, rng)
    deck, belt = _ground_masks(ground, footprint=0.5 / settings.scale)
    picture += deck[..., None] * (_deck_colour(ground, camera.side, settings, rng) - picture)
    belt_colour = np.array(settings.belt_rgb) * _lamp(ground, settings)[..., None]
    picture += belt[..., None] * (belt_colour - picture)
    far, near = _box_edges(camera.side)
    for quad, rgb, opacity in far:
        alpha = opacity * fill_quad(camera, quad, (h, w))[..., None]
        picture += alpha * (np.array(rgb) * settings.light - picture)
    glass = np.full((h, w, 1), 0.95, dtype=np.float32)
    reflection = np.full((h, w, 3), 5.0 * settings.light, dtype=np.float32)
    for quad, rgb, opacity in near:
        alpha = opacity * fill_quad(camera, quad, (h, w))[..., None]
        glass *= 1.0 - alpha
        reflection += alpha * (np.array(rgb, dtype=np.float32) * settings.light - reflection)
    reach = np.abs(ground[..., 1]) < BELT_HALF_WIDTH_MM + 60.0
    rows = np.flatnonzero((reach & (deck > 0)).any(axis=1))
    band = slice(int(rows[0]), int(rows[-1]) + 1)
    safe = np.nan_to_num(ground[band], nan=1e6, posinf=1e6, neginf=-1e6).astype(np.float32)
    return Backdrop(
        picture=picture.astype(np.float32),
        rows=band,
        ground_x=np.ascontiguousarray(safe[..., 0]),
        ground_y=np.ascontiguousarray(safe[..., 1]),
        belt=belt[band].astype(np.float32),
        glass=glass,
        reflection=reflection,
    )


def _lamp(ground: np.ndarray, settings: SceneSettings) -> FloatArray:
    """Return the brightness of the ground: the lamps are brightest over the middle."""
    x = np.clip(np.nan_to_num(ground[..., 0]) / 200.0, -1.5, 1.5)
    y = np.clip(np.nan_to_num(ground[..., 1]) / 200.0, -1.5, 1.5)
    tilt = np.radians(settings.light_azimuth_deg)
    slope = 0.15 * (np.cos(tilt) * x + np.sin(tilt) * y)
    return settings.light * (1.0 + settings.light_gradient * (slope - 0.5 * x**2 - 0.3 * y**2))


def _ground_masks(ground: np.ndarray, *, footprint: float) -> tuple[Float32Array, Float32Array]:
    """Return the shares of deck and of belt in each pixel, softened over a footprint in mm."""
    x, y = np.abs(np.nan_to_num(ground, nan=1e9, posinf=1e9, neginf=1e9)).transpose(2, 0, 1)
    deck = np.clip((_DECK_HALF_LENGTH_MM - x) / footprint, 0.0, 1.0)
    deck *= np.clip((_DECK_HALF_WIDTH_MM - y) / (4 * footprint), 0.0, 1.0)
    belt = np.clip((BELT_HALF_WIDTH_MM - y) / footprint, 0.0, 1.0)
    belt *= np.clip((BOX_HALF_LENGTH_MM + 60.0 - x) / footprint, 0.0, 1.0)
    return deck, belt


def _deck_colour(
    ground: np.ndarray, side: int, settings: SceneSettings, rng: np.random.Generator
) -> FloatArray:
    """Colour the painted deck: paler towards the cameras, with a bluish strip by the wall."""
    away = -side * np.nan_to_num(ground[..., 1])  # distance from the middle, away from the camera
    colour = np.array(settings.belt_rgb) * np.array([0.94, 0.97, 0.95])
    shade = _lamp(ground, settings) * np.interp(away, [-200, -60, 60, 210], [1.0, 0.96, 1.0, 0.9])
    blotch = cv2.resize(
        rng.standard_normal((12, 30)).astype(np.float32),
        ground.shape[1::-1],
        interpolation=cv2.INTER_CUBIC,
    )
    shade = shade * (1.0 + 0.015 * blotch)
    strip = np.exp(-0.5 * ((away - 84.0) / 11.0) ** 4)
    strip += 0.7 * (away < -72.0)
    bluish = np.array([-6.0, 10.0, 16.0])
    return shade[..., None] * (colour + strip[..., None] * bluish)


def _curtain(
    camera: PinholeCamera, rays: Float32Array, settings: SceneSettings, rng: np.random.Generator
) -> FloatArray:
    """Paint the curtains: soft vertical folds, a few dark gaps, darker towards the floor."""
    plane = -camera.side * _CURTAIN_MM
    depth = (plane - camera.centre[1]) / rays[..., 1]
    x = camera.centre[0] + depth * rays[..., 0]
    z = camera.centre[2] + depth * rays[..., 2]
    brightness = np.ones_like(x)
    for wavelength, strength in ((95.0, 0.05), (41.0, 0.04), (23.0, 0.02)):
        lean = rng.normal(0.0, 0.04)
        phase = rng.uniform(0.0, 2 * np.pi)
        brightness += strength * np.sin(2 * np.pi * (x + lean * z) / wavelength + phase)
    for _ in range(4):
        place, wide = rng.uniform(-420, 420), rng.uniform(8, 28)
        lean = rng.normal(0.0, 0.08)
        gap = np.exp(-(((x + lean * z - place) / wide) ** 4))
        brightness *= 1.0 - rng.uniform(0.25, 0.6) * gap
    brightness *= np.interp(z, [-260.0, -80.0, 60.0], [0.55, 0.85, 1.0])
    return settings.light * brightness[..., None] * np.array(settings.backdrop_rgb)


def _box_edges(side: int) -> tuple[list[Panel], list[Panel]]:
    """Return (quad, rgb, opacity) of the plexiglass behind the animal and before it."""
    length, width, top = BOX_HALF_LENGTH_MM, WALL_MM, BOX_HEIGHT_MM
    pale, line, shade = (150.0, 160.0, 150.0), (205.0, 214.0, 200.0), (70.0, 92.0, 72.0)
    far: list[Panel] = []
    near: list[Panel] = []
    for where, wall in ((far, -side), (near, side)):
        y = wall * width
        for end in (-1, 1):
            x = end * length
            # the thickness of the wall, seen at its upright edge, with one bright border
            where.append((_upright(x, y, 5.5, top), pale, 0.45))
            where.append((_upright(x + end * 2.4, y, 0.7, top), line, 0.45))
        foot = [[-length, y, 0.2], [length, y, 0.2], [length, y, 1.6], [-length, y, 1.6]]
        where.append((np.array(foot), line, 0.75))
        slot = np.array(foot) + np.array([0.0, wall * 1.5, 0.0])
        slot[:, 2] = [-0.6, -0.6, 0.2, 0.2]
        where.append((slot, shade, 0.6))
    for end in (-1, 1):  # the end walls: a bright line on the belt and a slight veil
        x = end * length
        line_on_belt = [[x, -width, 0.3], [x, width, 0.3], [x, width, 1.7], [x, -width, 1.7]]
        far.append((np.array(line_on_belt), line, 0.5))
        veil = [[x, -width, 0.0], [x, width, 0.0], [x, width, top], [x, -width, top]]
        far.append((np.array(veil), (120.0, 126.0, 120.0), 0.10))
    return far, near


def _upright(x: float, y: float, thickness: float, top: float) -> Quad:
    """Return an upright strip facing the cameras."""
    a, b = x - thickness / 2, x + thickness / 2
    return np.array([[a, y, 0.0], [b, y, 0.0], [b, y, top], [a, y, top]])


def fill_quad(camera: PinholeCamera, quad: Quad, shape: tuple[int, int]) -> Float32Array:
    """Return the share of each pixel of a picture (h, w) that a quadrilateral in 3D covers.

    Parameters
    ----------
    camera : PinholeCamera
        The camera.
    quad : Quad
        Four corners in space, mm.
    shape : tuple of int
        Height and width of the picture, px.

    Returns
    -------
    ndarray, shape (h, w)
        Shares from 0 to 1.
    """
    uv, _ = camera.project(quad)
    mask = np.zeros(shape, dtype=np.uint8)
    points = np.round(np.clip(uv, -8000, 8000) * 16).astype(np.int32)
    cv2.fillConvexPoly(mask, points, 255, lineType=cv2.LINE_AA, shift=4)
    return mask.astype(np.float32) / 255.0
