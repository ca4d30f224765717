"""Whether the camera moves, and how: the similarity that most corner features follow."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.paws.offline.scene.parameters import CAMERA


@dataclass(frozen=True)
class CameraMotion:
    """Where the pictures of a view lie beside each other.

    Parameters
    ----------
    to_first : ndarray, shape (n, 3, 3)
        Similarity from each picture to the first.
    pans : bool
        Whether the camera moves at all.
    """

    to_first: FloatArray
    pans: bool

    def between(self, source: int, target: int) -> FloatArray:
        """Return the similarity (3, 3) from one picture to another."""
        return np.linalg.solve(self.to_first[target], self.to_first[source])


def find_camera_motion(pictures: ByteArray) -> CameraMotion:
    """Find the camera's motion.

    Parameters
    ----------
    pictures : ndarray of uint8, shape (n, H, W)
        Small grey pictures.

    Returns
    -------
    CameraMotion
        Identity throughout where two fifths of the features stay, or no motion is shared by
        half of them.
    """
    n = len(pictures)
    to_first = np.tile(np.eye(3), (n, 1, 1))
    tried = np.linspace(0, n - 2, min(n - 1, CAMERA.camera_tried)).round().astype(int)
    if (
        n < 2
        or np.median([_step(*pictures[t : t + 2])[0] for t in tried]) > CAMERA.camera_most_still
    ):
        return CameraMotion(to_first, pans=False)
    still, shared, steps = [], [], []
    for before, after in itertools.pairwise(pictures):
        stays, share, step = _step(before, after)
        still.append(stays)
        shared.append(share)
        steps.append(step)
    if np.median(still) > CAMERA.camera_most_still or np.median(shared) < CAMERA.camera_shared:
        return CameraMotion(to_first, pans=False)
    for t, step in enumerate(steps):
        to_first[t + 1] = to_first[t] @ step
    return CameraMotion(to_first, pans=True)


def _step(before: ByteArray, after: ByteArray) -> tuple[float, float, FloatArray]:
    """Return the share of features that stay, that follow one similarity, and this, backwards."""
    nothing = (1.0, 0.0, np.eye(3))
    corners = cv2.goodFeaturesToTrack(
        before, CAMERA.camera_corners, CAMERA.corner_quality, CAMERA.camera_apart_px
    )
    if corners is None or len(corners) < CAMERA.camera_fewest:
        return nothing
    moved, status, _ = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload]
        before,
        after,
        corners,
        None,
        winSize=(CAMERA.camera_window_px,) * 2,
        maxLevel=CAMERA.feature_levels,
    )
    found = status[:, 0] > 0
    if found.sum() < CAMERA.camera_fewest:
        return nothing
    stays = float(
        (np.linalg.norm((moved - corners)[found, 0], axis=1) < CAMERA.camera_still_px).mean()
    )
    similarity, inliers = cv2.estimateAffinePartial2D(
        moved[found], corners[found], ransacReprojThreshold=CAMERA.camera_ransac_px
    )
    if similarity is None:
        return stays, 0.0, np.eye(3)
    return stays, float(inliers.mean()), np.vstack([similarity, [0.0, 0.0, 1.0]])
