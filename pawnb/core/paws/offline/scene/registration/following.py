"""Following an animal by the motion of its own features, where it passes a camera."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration.camera_motion import CameraMotion


def follow_animal(
    pictures: ByteArray, camera: CameraMotion, *, begin: int, centre: FloatArray, extent: float
) -> FloatArray:
    """Follow the animal from a clicked frame both ways, by the median of what moves about it.

    Legs swing and stand about the median; the median is the body's. What moves with it,
    such as its shadow or a person who leads it, does little harm; in a blob of foreground it does.

    Parameters
    ----------
    pictures : ndarray of uint8, shape (n, H, W)
        Small grey pictures.
    camera : CameraMotion
        Their motion.
    begin : int
        The clicked frame.
    centre : ndarray, shape (2,)
        The middle of its clicks, px of the small pictures.
    extent : float
        Size of the animal in them, px.

    Returns
    -------
    ndarray, shape (n, 2)
        A place that goes with the body, px of the small pictures.
    """
    n = len(pictures)
    way = np.empty((n, 2))
    way[begin] = centre
    for end in (n - 1, 0):
        step = 1 if end > begin else -1
        t = begin
        while t != end:
            to = t + step * min(CAMERA.follow_rows, abs(end - t))
            moved = _displacement(pictures, camera, t, to, way[t], extent)
            share = np.arange(1, abs(to - t) + 1) / abs(to - t)
            way[np.arange(t + step, to + step, step)] = way[t] + share[:, None] * moved
            t = to
    return way


def _displacement(
    pictures: np.ndarray,
    camera: CameraMotion,
    source: int,
    target: int,
    centre: np.ndarray,
    extent: float,
) -> np.ndarray:
    """Return how far the animal gets from one frame to another."""
    similarity = camera.between(source, target)

    def by_camera(at: np.ndarray) -> FloatArray:
        return np.asarray(at @ similarity[:2, :2].T + similarity[:2, 2])

    panned = by_camera(centre) - centre
    mask: np.ndarray = np.zeros(pictures.shape[1:], np.uint8)
    low = np.maximum(centre - CAMERA.follow_reach * extent, 0).astype(int)
    high = np.maximum(centre + CAMERA.follow_reach * extent, 0).astype(int)
    mask[low[1] : high[1], low[0] : high[0]] = 1
    corners = cv2.goodFeaturesToTrack(
        pictures[source],
        CAMERA.follow_corners,
        CAMERA.corner_quality,
        CAMERA.follow_apart_px,
        mask=mask,
    )
    if corners is None or len(corners) < CAMERA.follow_fewest:
        return panned
    here, kept = corners, np.ones(len(corners), bool)
    step = 1 if target > source else -1
    for t in range(source, target, step):
        there, found, _ = _flow(pictures[t], pictures[t + step], here)
        back, returned, _ = _flow(pictures[t + step], pictures[t], there)
        near = np.linalg.norm((back - here)[:, 0], axis=1) < CAMERA.follow_return_px
        kept &= (found[:, 0] > 0) & (returned[:, 0] > 0) & near
        here = there
    own = here[:, 0] - by_camera(corners[:, 0])
    moving = kept & (np.linalg.norm(own, axis=1) > CAMERA.follow_moved_px * abs(target - source))
    return (
        panned + np.median(own[moving], axis=0) if moving.sum() >= CAMERA.follow_fewest else panned
    )


def _flow(
    source: np.ndarray, target: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where features are in another frame, whether they were found, and errors."""
    moved, found, error = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload]
        source,
        target,
        at,
        None,
        winSize=(CAMERA.follow_window_px,) * 2,
        maxLevel=CAMERA.feature_levels,
    )
    return moved, found, error
