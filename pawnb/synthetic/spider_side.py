"""The synthetic spider from the side, through a mirror at 45 degrees, in the same picture.

A mirror along the lower wall shows the arena from the side in the dark rows below it: u is X
as from above, v falls with the height. Both views are without perspective, so their DLT
coefficients are exact (Pullar 2009, §5.1.3 and Eq. 5.1, wishes for such a mirror).
"""

from __future__ import annotations

import cv2
import numpy as np
import pandas as pd

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.schema import POINTS3D_COLUMNS
from pawnb.synthetic.spider_cuticle import BODY_DENSITY, DENSITY_STEP
from pawnb.synthetic.spider_paint import Shade, SpiderPainter
from pawnb.synthetic.spider_recording import SpiderRecording
from pawnb.synthetic.spider_scene import FULL_HEIGHT, PX_PER_MM, Individual, SpiderScene

_SHIFT = 4
_SPLIT_MM, _TOP_MM, _GROUND_MM, _END_MM = 67.0, 70.0, 97.0, 101.0
"""Rows of the strip, mm below the middle of the picture: where its view begins, where the
backdrop begins, the ground, where the backdrop ends."""

_BACKDROP = 0.75
_THICK = {"cephalothorax": 5.5, "abdomen": 8.5}
"""Height of the parts of the body, units of the species file."""


def split_row(scene: SpiderScene) -> int:
    """Return the first row, px, that belongs to the side view."""
    return round((FULL_HEIGHT / PX_PER_MM / 2.0 + _SPLIT_MM) * scene.px_per_mm)


def _ground_row(scene: SpiderScene) -> float:
    """Return the row of the whole picture on which the ground is seen from the side."""
    return (FULL_HEIGHT / PX_PER_MM / 2.0 + _GROUND_MM) * scene.px_per_mm - 0.5


def to_side(scene: SpiderScene, u: FloatArray, height_mm: FloatArray) -> FloatArray:
    """Return places (..., 2) in the whole picture of points seen from the side.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    u : ndarray
        Column of the point seen from above, px.
    height_mm : ndarray
        Its height above the panel.

    Returns
    -------
    ndarray, shape (..., 2)
        Places, px.
    """
    v = _ground_row(scene) - scene.px_per_mm * height_mm
    return np.stack([u, np.broadcast_to(v, np.shape(u))], axis=-1)


def dlt_coefs(scene: SpiderScene) -> FloatArray:
    """Return the DLT coefficients (11, 2) of the two cropped views, top and side.

    Space is in mm: x along u, y against v of the top view from its lower edge, z up.
    """
    k = scene.px_per_mm
    top = [k, 0, 0, -0.5, 0, -k, 0, scene.height - 0.5, 0, 0, 0]
    side = [k, 0, 0, -0.5, 0, 0, -k, _ground_row(scene) - split_row(scene), 0, 0, 0]
    return np.array([top, side], dtype=float).T


def points3d_truth(
    recording: SpiderRecording, names: tuple[str, ...], *, points: FloatArray, heights: FloatArray
) -> pd.DataFrame:
    """Return the columns of points3d.csv in the space of :func:`dlt_coefs`.

    Parameters
    ----------
    recording : SpiderRecording
        What is filmed.
    names : tuple of str
        Points.
    points : ndarray (n, points, 2)
        Their places from above, px.
    heights : ndarray (n, points)
        Their heights, mm.

    Returns
    -------
    pandas.DataFrame
        One row a frame and point; positions in mm.
    """
    scene = recording.scene
    n, m = heights.shape
    x = (points[..., 0] + 0.5) / scene.px_per_mm
    y = (scene.height - 0.5 - points[..., 1]) / scene.px_per_mm
    table = pd.DataFrame(
        {
            "frame": np.repeat(recording.poses.frames, m),
            "point": np.tile(np.array(names, dtype=object), n),
            "x": x.ravel(),
            "y": y.ravel(),
            "z": heights.ravel(),
            "residual_px": 0.0,
            "origin": "measured",
        }
    )
    return table[list(POINTS3D_COLUMNS)]


class SideView:
    """Paints the strip below the arena.

    Parameters
    ----------
    recording : SpiderRecording
        What happens.
    """

    def __init__(self, recording: SpiderRecording) -> None:
        scene = recording.scene
        self._recording, self._scene = recording, scene
        body = SideBody(scene, recording.individual)
        self._painter = SpiderPainter(scene, recording.individual, body=body)

    def paint_backdrop(self, panel: Float32Array) -> None:
        """Paint the mirror's image of the lit far wall into the panel, in place."""
        scene = self._scene
        middle = FULL_HEIGHT / PX_PER_MM / 2.0
        below = (np.arange(scene.height) + 0.5) / scene.px_per_mm - middle
        inside = np.clip((below - _TOP_MM) / 0.5, 0, 1) * np.clip((_END_MM - below) / 0.5, 0, 1)
        level = _BACKDROP * scene.light * np.interp(below, [_TOP_MM, _GROUND_MM], [0.85, 1.0])
        level[below > _GROUND_MM] *= 0.8
        level *= 1.0 - 0.3 * np.exp(-(((below - _GROUND_MM) / 0.35) ** 2))
        across = np.linspace(-1.0, 1.0, scene.width) ** 2
        light = level[:, None] * (1.0 - 0.5 * scene.vignetting * across)
        panel[:] = inside[:, None] * light + (1.0 - inside[:, None]) * panel

    def paint(self, row: int) -> Shade:
        """Return the animal of one frame of the recording in the whole picture."""
        recording, scene = self._recording, self._scene
        joints = to_side(scene, recording.joints_px[row, ..., 0], recording.heights_mm[row])
        bodies = recording.bodies[row]
        place = to_side(scene, bodies[:, 0], recording.body_heights_mm[row])
        return self._painter.paint(joints, np.column_stack([place, bodies[:, 2]]))


class SideBody:
    """The body seen from the side.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    individual : Individual
        The animal.
    """

    def __init__(self, scene: SpiderScene, individual: Individual) -> None:
        self._individual = individual
        ends = [abs(part.centre[0]) + part.length / 2 for part in individual.animal.body]
        self.extent_px = max(ends) * individual.size * scene.px_per_mm

    def paint(
        self,
        density: ByteArray,
        grey: Float32Array,  # noqa: ARG002  the flank is as dark as the legs
        body: tuple[FloatArray, float],
        *,
        fine_px_per_mm: float,
    ) -> None:
        """Paint the body over a fine picture: see :meth:`BodyTexture.paint`.

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
        at, heading = body
        unit = self._individual.size * fine_px_per_mm
        cos, sin = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        level = round(BODY_DENSITY * DENSITY_STEP)
        for part in self._individual.animal.body:
            centre = at + unit * np.array([cos * part.centre[0], 0.0])
            # outline of the turned ellipse
            half = 0.5 * unit * np.hypot(cos * part.length, sin * part.width)
            high = 0.5 * unit * _THICK.get(part.name, 0.5 * part.width)
            cv2.ellipse(
                density,
                (round(centre[0] * 2**_SHIFT), round(centre[1] * 2**_SHIFT)),
                (round(half * 2**_SHIFT), round(high * 2**_SHIFT)),
                0.0, 0.0, 360.0, level, -1, cv2.LINE_8, _SHIFT,
            )  # fmt: skip
