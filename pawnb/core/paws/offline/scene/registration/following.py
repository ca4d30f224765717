"""Following an animal by the motion of its own features, where it passes a camera."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration.camera_motion import CameraMotion

_LEAST_PX = 1e-6
"""Guard: ways that both arrive count alike."""


def follow_animal(
    pictures: ByteArray, camera: CameraMotion, *, clicks: Mapping[int, FloatArray], extent: float
) -> FloatArray:
    """Follow the animal from the first clicked frame both ways, by the median of what moves.

    Legs swing and stand about the median; the median is the body's. What moves with it,
    such as its shadow or a person who leads it, does little harm; in a blob of foreground it does.
    Where a later clicked frame has the animal elsewhere it was lost on the way: that is followed
    backwards from there as well, and from there on anew.

    Parameters
    ----------
    pictures : ndarray of uint8, shape (n, H, W)
        Small grey pictures.
    camera : CameraMotion
        Their motion.
    clicks : mapping
        Row to clicked places (k, 2), px of the small pictures.
    extent : float
        Size of the animal in them, px.

    Returns
    -------
    ndarray, shape (n, 2)
        A place that goes with the body, px of the small pictures.
    """

    def follow(begin: int, end: int, centre: FloatArray) -> FloatArray:
        return _follow(pictures, camera, begin=begin, end=end, centre=centre, extent=extent)

    middles = {row: clicks[row].mean(axis=0) for row in sorted(clicks)}
    row, *later = middles
    way = np.empty((len(pictures), 2))
    way[: row + 1] = follow(row, 0, middles[row])[::-1]
    way[row:] = follow(row, len(pictures) - 1, middles[row])
    for to in later:
        if np.linalg.norm(way[to] - middles[to]) > CAMERA.follow_lost * extent:
            back = follow(to, row, middles[to])[::-1]
            way[row : to + 1] = between_two_ways(way[row : to + 1], back)
            way[to:] = follow(to, len(pictures) - 1, middles[to])
        row = to
    return way


def _follow(
    pictures: ByteArray,
    camera: CameraMotion,
    *,
    begin: int,
    end: int,
    centre: FloatArray,
    extent: float,
) -> FloatArray:
    """Follow the animal from one frame to another; places in this order, both included."""
    way = [centre]
    t, step = begin, 1 if end > begin else -1
    while t != end:
        to = t + step * min(CAMERA.follow_rows, abs(end - t))
        moved = _displacement(pictures, camera, t, to, way[-1], extent)
        share = np.arange(1, abs(to - t) + 1) / abs(to - t)
        way += list(way[-1] + share[:, None] * moved)
        t = to
    return np.array(way)


def between_two_ways(there: FloatArray, back: FloatArray) -> FloatArray:
    """Return a way (n, 2) from where one begins to where the other ends, between the two.

    What each is off at the other's certain end is taken off along it; the one that is off by less
    counts more.
    """
    share = np.linspace(0.0, 1.0, len(there))[:, None]
    off_there, off_back = back[-1] - there[-1], there[0] - back[0]
    weight_there = (1.0 - share) * (np.linalg.norm(off_back) + _LEAST_PX)
    weight_back = share * (np.linalg.norm(off_there) + _LEAST_PX)
    along_there, along_back = there + share * off_there, back + (1.0 - share) * off_back
    both = weight_there * along_there + weight_back * along_back
    return np.asarray(both / (weight_there + weight_back))


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
