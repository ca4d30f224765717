"""Where the animal is and how large, and from that what is searched of each view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.detection.colour.scan import ROI
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.parameters import MOVEMENT


@dataclass(frozen=True)
class SearchRegion:
    """Where the animal is and how large.

    Parameters
    ----------
    middle : ndarray, shape (d,)
        The middle of the placed points.
    forward, up : ndarray, shape (d,)
        Unit vectors.
    substrate : float
        Height of what it stands on.
    body_scale : float
        Distance of front from hind paws.
    height : float
        Height in which paws are searched, in distances of front from hind paws.
    """

    middle: FloatArray
    forward: FloatArray
    up: FloatArray
    substrate: float
    body_scale: float
    height: float

    def limb_direction(self, projection: Projection, paw_width: float) -> list[tuple[float, float]]:
        """Return the direction in each picture in which limbs tend to end."""
        tip = self.middle + (self.forward - self.up) * paw_width
        step = projection.project(tip) - projection.project(self.middle)
        step = step / np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-9)
        return [(float(a), float(b)) for a, b in step]

    def search(
        self, projection: Projection, sizes: Sequence[tuple[int, int]], from_below: BoolArray
    ) -> tuple[list[ROI], list[FloatArray]]:
        """Return the region of each view, and the limits within which paws can be.

        Parameters
        ----------
        projection : Projection
            The views.
        sizes : sequence of (int, int)
            Width and height of each, px.
        from_below : ndarray of bool, shape (V,)
            Which of them are from below.

        Returns
        -------
        rois : list of ROI
            Where each is searched in the first frame.
        hulls : list of ndarray, shape (m, 3)
            Lines within which paws can be.
        """
        rois, hulls = [], []
        for v, size in enumerate(sizes):
            # what is far to the side is not occluded from below
            broad = MOVEMENT.broad_below if from_below[v] else MOVEMENT.treadmill_broad
            corners = projection.project(self._box(MOVEMENT.treadmill_long, broad))[:, v]
            low, high = corners.min(axis=0), corners.max(axis=0)
            rois.append(ROI((low + high) / 2, (high - low) / 2, size))
            hulls.append(_hull(projection.project(self._box(MOVEMENT.hull_long, broad))[:, v]))
        return rois, hulls

    def _box(self, long: float, broad: float) -> FloatArray:
        """Return the corners of the box in which paws are searched."""
        base = self.middle + (self.substrate - self.middle @ self.up) * self.up
        sides = [np.zeros_like(self.up)]
        if len(self.up) == 3:
            across = broad * self.body_scale * np.cross(self.up, self.forward)
            sides = [across, -across]
        return np.stack(
            [
                base + a * long * self.body_scale * self.forward + s + c * self.body_scale * self.up
                for a in (-1.0, 1.0) for s in sides
                for c in (-MOVEMENT.treadmill_below, self.height)
            ]
        )  # fmt: skip


def _hull(corners: FloatArray) -> FloatArray:
    """Return the lines (m, 3) of the convex hull of points, positive inside."""
    hull = cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float)
    edge = np.roll(hull, -1, axis=0) - hull
    normal = np.column_stack([-edge[:, 1], edge[:, 0]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    lines = np.column_stack([normal, -(normal * hull).sum(axis=1)])
    inside = lines[:, :2] @ hull.mean(axis=0) + lines[:, 2]
    return np.asarray(lines * np.sign(inside)[:, None])
