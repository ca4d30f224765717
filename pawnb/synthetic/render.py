"""Pictures of the synthetic mouse, and how much of each paw is seen in them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.synthetic.backdrop import (
    BELT_HALF_WIDTH_MM,
    BELT_TEXEL_MM,
    Backdrop,
    make_backdrop,
    make_belt,
)
from pawnb.synthetic.camera import Camera
from pawnb.synthetic.mouse import EYE, PAW, TWO_SIDED
from pawnb.synthetic.raster import Fragments, barycentric, rasterise
from pawnb.synthetic.scene import LEGS, SceneSettings
from pawnb.synthetic.surfaces import Mesh, unit

SUPERSAMPLE = 2
"""Samples per pixel and direction; colours, edges and visibility are all decided on them."""

_FUR_TEXELS, _FUR_TEXELS_PER_MM = 512, 5.0
_SHADOW_CELL_MM = 1.0
_SHADOW_CELLS = (200, 140)


@dataclass(frozen=True)
class Shadow:
    """Shadow of the animal on the belt: share of the light that is missing, on a grid."""

    grid: np.ndarray
    corner: np.ndarray


@dataclass(frozen=True)
class _Coverage:
    """The animal on the sample grid of one picture: its box (px) and its fragments."""

    box: tuple[int, int, int, int]
    corners: np.ndarray
    fragments: Fragments
    faces: np.ndarray


class ViewRenderer:
    """Renders one view of a scene.

    Parameters
    ----------
    camera : Camera
        The view.
    settings : SceneSettings
        Colours, light, noise.
    number : int
        Place of the view among the views; part of the seed of its noise.
    """

    def __init__(self, camera: Camera, settings: SceneSettings, number: int) -> None:
        self._camera = camera
        self._settings = settings
        self._number = number
        self._backdrop: Backdrop = make_backdrop(camera, settings)
        self._belt = make_belt(settings)
        self._fur = _fur_texture(settings)

    def render(
        self, mesh: Mesh, shadow: Shadow, *, frame: int, time_s: float
    ) -> tuple[np.ndarray, dict[str, float]]:
        """Render one frame.

        Parameters
        ----------
        mesh : Mesh
            The animal.
        shadow : Shadow
            Its shadow, from :func:`cast_shadow`.
        frame : int
            Number of the frame; seeds its noise.
        time_s : float
            Time, for the place of the belt.

        Returns
        -------
        picture : ndarray (h, w, 3) uint8
            RGB.
        fractions : dict
            For each leg the share of its paw that is seen, 0-1; see :func:`paw_fractions`.
        """
        settings, backdrop = self._settings, self._backdrop
        picture = backdrop.picture.copy()
        picture[backdrop.rows] *= self._ground(shadow, time_s)[..., None]
        covered = cover(mesh, self._camera, settings)
        self._paint(picture, mesh, covered)
        picture *= backdrop.glass
        picture += backdrop.reflection
        blur = settings.blur_px * settings.scale
        if blur > 0.15:
            picture = cv2.GaussianBlur(picture, (0, 0), blur)
        return self._expose(picture, frame), paw_fractions(mesh, covered)

    def _ground(self, shadow: Shadow, time_s: float) -> np.ndarray:
        """Return the relative brightness of the ground: marks of the belt times shadow."""
        settings, backdrop = self._settings, self._backdrop
        moved = settings.belt_speed_mm_s * time_s
        length = self._belt.shape[1] * BELT_TEXEL_MM
        along = settings.direction * backdrop.ground_x + np.float32(moved % length)
        across = (backdrop.ground_y + np.float32(BELT_HALF_WIDTH_MM + 4.0)) / BELT_TEXEL_MM
        marks = cv2.remap(
            self._belt,
            along / np.float32(BELT_TEXEL_MM),
            across.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_WRAP,
        )
        u = (backdrop.ground_x - np.float32(shadow.corner[0])) / np.float32(_SHADOW_CELL_MM)
        v = (backdrop.ground_y - np.float32(shadow.corner[1])) / np.float32(_SHADOW_CELL_MM)
        dark = cv2.remap(shadow.grid, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return (1.0 + marks * backdrop.belt) * (1.0 - dark)

    def _paint(self, picture: np.ndarray, mesh: Mesh, covered: _Coverage) -> None:
        """Paint the animal into a picture, in place."""
        u0, v0, u1, v1 = covered.box
        n = SUPERSAMPLE
        wide, high = n * (u1 - u0), n * (v1 - v0)
        if wide <= 0 or high <= 0:
            return
        sample = np.flatnonzero(covered.fragments.winner >= 0)
        triangle = covered.fragments.triangle[covered.fragments.winner[sample]]
        xy = np.stack([sample % wide, sample // wide], axis=1)
        weights = barycentric(covered.corners, triangle, xy).astype(np.float32)
        values = np.concatenate(
            [self._shade(mesh), mesh.surface, mesh.fur[:, None]], axis=1, dtype=np.float32
        )
        corner = covered.faces[triangle]
        mixed = sum(weights[:, [k]] * values[corner[:, k]] for k in range(3))
        texel = (mixed[:, 3:5] * np.float32(_FUR_TEXELS_PER_MM)).astype(np.int32) % _FUR_TEXELS
        hair = 1.0 + mixed[:, 5] * self._fur[texel[:, 1], texel[:, 0]]
        layer = np.zeros((high * wide, 4), dtype=np.float32)
        layer[sample, :3] = mixed[:, :3] * hair[:, None]
        layer[sample, 3] = 1.0
        small = cv2.resize(
            layer.reshape(high, wide, 4), (u1 - u0, v1 - v0), interpolation=cv2.INTER_AREA
        )
        part = picture[v0:v1, u0:u1]
        part *= 1.0 - small[..., 3:]
        part += small[..., :3]

    def _shade(self, mesh: Mesh) -> np.ndarray:
        """Return the colour of each vertex under the lamps (n, 3)."""
        settings = self._settings
        normal, up = mesh.normals, mesh.normals[:, 2]
        lamp = lamp_direction(settings)
        toward = unit(self._camera.centre - mesh.vertices)
        direct = np.maximum(normal @ lamp, 0.0)
        light = 0.48 + 0.20 * up + 0.32 * direct / lamp[2]
        # the side lamps stand with the cameras
        light += 0.12 * np.maximum(np.einsum("ij,ij->i", normal, toward), 0.0)
        # less light reaches what is low under the body
        light *= np.where(up < 0, 1.0 + 0.25 * up, 1.0)
        colour = mesh.colour * light[:, None]
        bounce = np.maximum(-up, 0.0)[:, None] * mesh.colour / 255.0
        colour += 0.30 * bounce * np.array(settings.belt_rgb)
        half = unit(lamp + toward)
        gloss = np.maximum(np.einsum("ij,ij->i", normal, half), 0.0)
        rim = 1.0 - np.abs(np.einsum("ij,ij->i", normal, toward))
        sheen = mesh.fur * (16.0 * gloss**10 + 12.0 * rim**3 * np.maximum(up + 0.3, 0.0))
        colour += sheen[:, None]
        colour[mesh.faces[mesh.part == EYE]] += (
            190.0 * (gloss**60)[mesh.faces[mesh.part == EYE]][..., None]
        )
        return settings.light * colour

    def _expose(self, picture: np.ndarray, frame: int) -> np.ndarray:
        """Add the sensor's noise and round to grey levels."""
        settings = self._settings
        rng = np.random.Generator(np.random.SFC64([settings.seed, 6, self._number, frame]))
        noise = rng.standard_normal(picture.shape, dtype=np.float32)
        variance = picture * np.float32(settings.shot_noise**2 / 255.0)
        variance += np.float32(settings.read_noise**2)
        noise *= np.sqrt(np.maximum(variance, 0.0, out=variance), out=variance)
        noise += picture
        noise += 0.5
        return np.clip(noise, 0.0, 255.0, out=noise).astype(np.uint8)


def cover(mesh: Mesh, camera: Camera, settings: SceneSettings) -> _Coverage:
    """Find which triangles of the animal cover which samples of a view."""
    n = SUPERSAMPLE
    uv, depth = camera.project(mesh.vertices)
    low = np.floor(uv.min(axis=0)).astype(int) - 1
    high = np.ceil(uv.max(axis=0)).astype(int) + 2
    size = np.array([settings.width, settings.height])
    u0, v0 = np.clip(low, 0, size)
    u1, v1 = np.clip(high, 0, size)
    # sample j lies at (j + 0.5) / n - 0.5 px, so that a pixel holds n x n of them
    samples = n * (uv - [u0, v0] + 0.5) - 0.5
    corners = samples[mesh.faces]
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turned = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    facing = np.flatnonzero((turned < 0) | np.isin(mesh.part, TWO_SIDED))
    fragments = rasterise(
        corners[facing],
        1.0 / depth[mesh.faces[facing]],
        width=max(n * int(u1 - u0), 0),
        height=max(n * int(v1 - v0), 0),
    )
    fragments = Fragments(
        triangle=facing[fragments.triangle], pixel=fragments.pixel, winner=fragments.winner
    )
    box = (int(u0), int(v0), int(u1), int(v1))
    return _Coverage(box=box, corners=corners, fragments=fragments, faces=mesh.faces)


def paw_fractions(mesh: Mesh, covered: _Coverage) -> dict[str, float]:
    """Return for each leg the share of its paw that is seen, from 0 to 1.

    The denominator counts the samples that the paw would cover alone, the numerator
    those of them where nothing of the animal is before it. A paw outside the
    picture has 0. The plexiglass counts as clear.
    """
    fragments = covered.fragments
    part = mesh.part[fragments.triangle]
    front = np.full(len(fragments.winner), -1)
    seen = fragments.winner >= 0
    front[seen] = part[fragments.winner[seen]]
    fractions = {}
    for leg in LEGS:
        alone = np.unique(fragments.pixel[part == PAW[leg]])
        shown = np.count_nonzero(front[alone] == PAW[leg])
        fractions[leg] = shown / len(alone) if len(alone) else 0.0
    return fractions


def lamp_direction(settings: SceneSettings) -> np.ndarray:
    """Return the unit vector towards the stronger lamp, 60 degrees above the belt."""
    azimuth, elevation = np.radians(settings.light_azimuth_deg), np.radians(60.0)
    flat = np.cos(elevation)
    return np.array([np.cos(azimuth) * flat, np.sin(azimuth) * flat, np.sin(elevation)])


def cast_shadow(mesh: Mesh, settings: SceneSettings) -> Shadow:
    """Find the soft shadow of the animal on the belt.

    The lamps are wide: what is close to the belt casts a sharp shadow under itself,
    what is high a faint, wide one, moved away from the stronger lamp.
    """
    corners = mesh.vertices[mesh.faces]
    middle = corners.mean(axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.maximum(cross[:, 2], 0.0)  # seen from above
    wide, high = _SHADOW_CELLS
    centre = np.median(mesh.vertices[:, :2], axis=0)
    corner = centre - 0.5 * _SHADOW_CELL_MM * np.array([wide, high])
    lamp = lamp_direction(settings)
    light = np.ones((high, wide), dtype=np.float32)
    for low, top, blur, strength in ((-1, 5, 1.3, 0.50), (5, 13, 4.0, 0.40), (13, 200, 9.0, 0.42)):
        here = (middle[:, 2] >= low) & (middle[:, 2] < top) & (area > 0)
        shift = 0.7 * lamp[:2] / lamp[2] * middle[here, 2:]
        cell = np.floor((middle[here, :2] - shift - corner) / _SHADOW_CELL_MM).astype(int)
        inside = ((cell >= 0) & (cell < [wide, high])).all(axis=1)
        place = cell[inside, 1] * wide + cell[inside, 0]
        dark = np.bincount(place, weights=area[here][inside], minlength=wide * high)
        dark = np.minimum(dark.reshape(high, wide) / _SHADOW_CELL_MM**2, 1.0).astype(np.float32)
        light *= 1.0 - strength * cv2.GaussianBlur(dark, (0, 0), blur / _SHADOW_CELL_MM)
    return Shadow(grid=1.0 - light, corner=corner + 0.5 * _SHADOW_CELL_MM)


def _fur_texture(settings: SceneSettings) -> np.ndarray:
    """Paint the fur: relative brightness, streaked along the body, periodic."""
    rng = np.random.default_rng([settings.seed, 7])
    streaks = np.zeros((_FUR_TEXELS, _FUR_TEXELS), dtype=np.float32)
    for along, across, strength in ((7.0, 0.8, 0.10), (25.0, 6.0, 0.05)):
        noise = rng.standard_normal(streaks.shape)
        f = np.fft.fftfreq(_FUR_TEXELS)
        damp = np.exp(-2 * np.pi**2 * ((across * f[:, None]) ** 2 + (along * f[None]) ** 2))
        grain = np.fft.ifft2(np.fft.fft2(noise) * damp).real
        streaks += (strength * grain / grain.std()).astype(np.float32)
    return np.clip(streaks, -0.6, 0.8)
