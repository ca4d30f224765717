"""Pictures of the synthetic mouse, and how much of each paw is seen in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.synthetic.backdrop import (
    BELT_HALF_WIDTH_MM,
    BELT_TEXEL_MM,
    Backdrop,
    make_backdrop,
    make_belt,
)
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.glass_belt import make_glass_backdrop
from pawnb.synthetic.lamps import Shadow, brightness, lamp_direction
from pawnb.synthetic.mirrors import find_mirrors
from pawnb.synthetic.mouse import EYE, PAW, TWO_SIDED
from pawnb.synthetic.raster import Fragments, barycentric, rasterise
from pawnb.synthetic.scene import LEGS, SceneSettings
from pawnb.synthetic.surfaces import Mesh, unit

SUPERSAMPLE = 2
"""Samples per pixel and direction; colours, edges and visibility are all decided on them."""

_FUR_TEXELS, _FUR_TEXELS_PER_MM = 512, 5.0


Moment = tuple[Mesh, Shadow, float]
"""The animal, its shadow and the time, s."""


@dataclass(frozen=True)
class _Coverage:
    """The animal on the sample grid of one picture: its box (px) and its fragments."""

    box: tuple[int, int, int, int]
    corners: FloatArray
    fragments: Fragments
    faces: IntArray


class ViewRenderer:
    """Renders one view of a scene.

    Parameters
    ----------
    camera : PinholeCamera
        The view.
    settings : SceneSettings
        Colours, light, noise.
    number : int
        Place of the view among the views; part of the seed of its noise.
    """

    def __init__(self, camera: PinholeCamera, settings: SceneSettings, number: int) -> None:
        self._camera = camera
        self._settings = settings
        self._number = number
        make = make_glass_backdrop if settings.below else make_backdrop
        self._backdrop: Backdrop = make(camera, settings)
        self._mirrors = find_mirrors(camera, settings)
        self._belt = make_belt(settings)
        self._fur = _fur_texture(settings)

    def render(
        self,
        mesh: Mesh,
        shadow: Shadow,
        *,
        frame: int,
        time_s: float,
        others: Sequence[Moment] = (),
    ) -> tuple[np.ndarray, dict[str, float]]:
        """Render one frame.

        Parameters
        ----------
        mesh : Mesh
            The animal.
        shadow : Shadow
            Its shadow, from :func:`pawnb.synthetic.lamps.cast_shadow`.
        frame : int
            Number of the frame; seeds its noise.
        time_s : float
            Time, for the place of the belt.
        others : sequence of tuple
            Mesh, shadow and time at further moments for which the shutter is open.

        Returns
        -------
        picture : ndarray (h, w, 3) uint8
            RGB.
        fractions : dict
            For each leg the share of its paw that is seen, 0-1; see :func:`paw_fractions`.
        """
        settings = self._settings
        covered = cover(mesh, self._camera, settings)
        picture = self._see(mesh, shadow, covered, time_s)
        for other, its_shadow, its_time_s in others:
            there = cover(other, self._camera, settings)
            picture += self._see(other, its_shadow, there, its_time_s)
        if others:
            picture /= np.float32(1 + len(others))
        blur = settings.blur_px * settings.scale
        if blur > 0.15:
            picture = cv2.GaussianBlur(picture, (0, 0), blur)
        return self._expose(picture, frame), paw_fractions(mesh, covered)

    def _see(self, mesh: Mesh, shadow: Shadow, covered: _Coverage, time_s: float) -> np.ndarray:
        """Return what a moment looks like (h, w, 3) float32, without the camera's faults."""
        settings, backdrop = self._settings, self._backdrop
        picture = backdrop.picture.copy()
        ground = self._ground(shadow, time_s)[..., None]
        if not settings.below:
            picture[backdrop.rows] *= ground
        colour = self._shade(mesh)
        for mirror in self._mirrors:
            image = mirror.image(mesh)
            there = cover(image, self._camera, settings)
            self._paint(picture, image, there, colour, share=mirror.share)
        self._paint(picture, mesh, covered, colour)
        if settings.below:
            picture[backdrop.rows] *= ground  # the belt lies before the animal
        picture *= backdrop.glass
        picture += backdrop.reflection
        if settings.flicker:
            picture *= np.float32(brightness(settings, time_s))
        return picture

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
        u = (backdrop.ground_x - np.float32(shadow.corner[0])) / np.float32(shadow.cell_mm)
        v = (backdrop.ground_y - np.float32(shadow.corner[1])) / np.float32(shadow.cell_mm)
        dark = cv2.remap(shadow.grid, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return (1.0 + marks * backdrop.belt) * (1.0 - dark)

    def _paint(
        self,
        picture: np.ndarray,
        mesh: Mesh,
        covered: _Coverage,
        colour: np.ndarray,
        *,
        share: np.ndarray | None = None,
    ) -> None:
        """Paint the animal, of colour (n, 3) at its vertices, into a picture, in place.

        ``share`` (h, w) is how much of what is seen at each pixel is the animal, where it is;
        default all.
        """
        u0, v0, u1, v1 = covered.box
        n = SUPERSAMPLE
        wide, high = n * (u1 - u0), n * (v1 - v0)
        if wide <= 0 or high <= 0:
            return
        sample = np.flatnonzero(covered.fragments.winner >= 0)
        triangle = covered.fragments.triangle[covered.fragments.winner[sample]]
        xy = np.stack([sample % wide, sample // wide], axis=1)
        weights = barycentric(covered.corners, triangle, xy).astype(np.float32)
        values = np.concatenate([colour, mesh.surface, mesh.fur[:, None]], axis=1, dtype=np.float32)
        corner = covered.faces[triangle]
        mixed = np.asarray(sum(weights[:, [k]] * values[corner[:, k]] for k in range(3)))
        texel = (mixed[:, 3:5] * np.float32(_FUR_TEXELS_PER_MM)).astype(np.int32) % _FUR_TEXELS
        hair = 1.0 + mixed[:, 5] * self._fur[texel[:, 1], texel[:, 0]]
        layer = np.zeros((high * wide, 4), dtype=np.float32)
        layer[sample, :3] = mixed[:, :3] * hair[:, None]
        layer[sample, 3] = 1.0
        small = cv2.resize(
            layer.reshape(high, wide, 4), (u1 - u0, v1 - v0), interpolation=cv2.INTER_AREA
        )
        if share is not None:
            small = small * share[v0:v1, u0:u1, None]
        part = picture[v0:v1, u0:u1]
        part *= 1.0 - small[..., 3:]
        part += small[..., :3]

    def _shade(self, mesh: Mesh) -> np.ndarray:
        """Return the colour of each vertex under the lamps (n, 3)."""
        settings = self._settings
        lamp = lamp_direction(settings)
        # towards the lamps, which stand below a belt of glass
        normal, up = mesh.normals, mesh.normals[:, 2] * np.sign(lamp[2])
        toward = unit(self._camera.centre - mesh.vertices)
        direct = np.maximum(normal @ lamp, 0.0)
        light = 0.48 + 0.20 * up + 0.32 * direct / abs(lamp[2])
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


def cover(mesh: Mesh, camera: PinholeCamera, settings: SceneSettings) -> _Coverage:
    """Find which triangles of the animal cover which samples of a view.

    Parameters
    ----------
    mesh : Mesh
        The animal.
    camera : PinholeCamera
        The view.
    settings : SceneSettings
        The scene, for the number of samples.

    Returns
    -------
    _Coverage
        Triangle and depth of every sample.
    """
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
