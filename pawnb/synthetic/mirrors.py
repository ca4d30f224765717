"""Pictures of the synthetic mouse in what shines: the walls of its box, and the belt."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import Float32Array
from pawnb.synthetic.backdrop import (
    BELT_HALF_WIDTH_MM,
    BOX_HALF_LENGTH_MM,
    BOX_HEIGHT_MM,
    WALL_MM,
    fill_quad,
)
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.scene import SceneSettings
from pawnb.synthetic.surfaces import Mesh

_WALL_SHARE = 0.7
"""Walls are seen more steeply than the belt, and reflect less."""


@dataclass(frozen=True)
class Mirror:
    """A plane that shines, in one view.

    Attributes
    ----------
    axis, place : int, float
        It stands across that axis, so many mm from the origin.
    share : ndarray (h, w) float32
        How much of what is seen at each pixel is what it reflects, if it reflects the animal.
    """

    axis: int
    place: float
    share: Float32Array

    def image(self, mesh: Mesh) -> Mesh:
        """Return an animal as it seems to be behind the mirror."""
        vertices, normals = mesh.vertices.copy(), mesh.normals.copy()
        vertices[:, self.axis] = 2.0 * self.place - vertices[:, self.axis]
        normals[:, self.axis] *= -1.0
        # corners run the other way round in a mirror
        faces = np.ascontiguousarray(mesh.faces[:, ::-1])
        return dataclasses.replace(mesh, vertices=vertices, normals=normals, faces=faces)


def find_mirrors(camera: PinholeCamera, settings: SceneSettings) -> list[Mirror]:
    """Return what a camera beside the treadmill sees the animal in: the far wall, and the belt."""
    if settings.reflections == 0.0:
        return []
    x, y, top = BOX_HALF_LENGTH_MM, BELT_HALF_WIDTH_MM, BOX_HEIGHT_MM
    far = -camera.side * WALL_MM
    wall = [[-x, far, 0.0], [x, far, 0.0], [x, far, top], [-x, far, top]]
    belt = [[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
    mirrors = []
    for axis, place, share, quad in ((1, far, _WALL_SHARE, wall), (2, 0.0, 1.0, belt)):
        seen = fill_quad(camera, np.array(quad), (settings.height, settings.width))
        mirrors.append(Mirror(axis, place, np.float32(share * settings.reflections) * seen))
    return mirrors
