"""The lamps of the synthetic treadmill: where they stand, what they shade, how they flicker."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.synthetic.scene import SceneSettings
from pawnb.synthetic.surfaces import Mesh

_SHADOW_CELL_MM = 1.0
_SHADOW_CELLS = (200, 140)

_FLICKER_HZ, _SAG_HZ = 100.4, 6.3
"""Twice the mains frequency, a little off as it is, and slow changes of the voltage."""
_SAG = 0.25


@dataclass(frozen=True)
class Shadow:
    """Shadow of the animal on the belt: share of the light that is missing, on a grid."""

    grid: Float32Array
    corner: FloatArray

    @property
    def cell_mm(self) -> float:
        """Distance of the grid's points."""
        return _SHADOW_CELL_MM


def lamp_direction(settings: SceneSettings) -> FloatArray:
    """Return the unit vector towards the stronger lamp, 60 degrees above the belt, or below."""
    azimuth, elevation = np.radians(settings.light_azimuth_deg), np.radians(60.0)
    flat, high = np.cos(elevation), np.sin(elevation)
    return np.array(
        [np.cos(azimuth) * flat, np.sin(azimuth) * flat, -high if settings.below else high]
    )


def brightness(settings: SceneSettings, time_s: float) -> float:
    """Return the brightness of the lamps at a time, relative to their mean."""
    wave = (1.0 - _SAG) * np.sin(2 * np.pi * _FLICKER_HZ * time_s)
    wave += _SAG * np.sin(2 * np.pi * _SAG_HZ * time_s)
    return float(1.0 + settings.flicker * wave)


def cast_shadow(mesh: Mesh, settings: SceneSettings) -> Shadow:
    """Find the soft shadow of the animal on the belt.

    The lamps are wide: what is close to the belt casts a sharp shadow under itself,
    what is high a faint, wide one, moved away from the stronger lamp. A belt of glass that is
    lit from below has none.
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
    layers = ((-1, 5, 1.3, 0.50), (5, 13, 4.0, 0.40), (13, 200, 9.0, 0.42))
    for low, top, blur, strength in () if settings.below else layers:
        here = (middle[:, 2] >= low) & (middle[:, 2] < top) & (area > 0)
        shift = 0.7 * lamp[:2] / lamp[2] * middle[here, 2:]
        cell = np.floor((middle[here, :2] - shift - corner) / _SHADOW_CELL_MM).astype(int)
        inside = ((cell >= 0) & (cell < [wide, high])).all(axis=1)
        place = cell[inside, 1] * wide + cell[inside, 0]
        dark = np.bincount(place, weights=area[here][inside], minlength=wide * high)
        dark = np.minimum(dark.reshape(high, wide) / _SHADOW_CELL_MM**2, 1.0).astype(np.float32)
        light *= 1.0 - strength * cv2.GaussianBlur(dark, (0, 0), blur / _SHADOW_CELL_MM)
    return Shadow(grid=1.0 - light, corner=corner + 0.5 * _SHADOW_CELL_MM)
