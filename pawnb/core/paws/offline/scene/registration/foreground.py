"""What differs from the scene without the animal, and the blob of it that holds the clicks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, FloatArray
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration.camera_motion import CameraMotion


@dataclass(frozen=True)
class Blob:
    """The foreground blob that holds the animal, for each of n frames; NaN where there is none.

    Parameters
    ----------
    centre : ndarray, shape (n, 2)
        Centroid, px of the small pictures.
    angle : ndarray, shape (n,)
        Direction of the longer axis, rad, modulo pi.
    elongation : ndarray, shape (n,)
        0 for a disc, 1 for a line.
    difference : ndarray, shape (n, H, W)
        Distance from the background, in thresholds, at most 3.
    """

    centre: FloatArray
    angle: FloatArray
    elongation: FloatArray
    difference: Float32Array


def find_blob(
    pictures: ByteArray, camera: CameraMotion, *, clicks: Mapping[int, FloatArray], extent: float
) -> Blob:
    """Follow the foreground blob that holds the clicks, both ways from the nearest of them.

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
    Blob
        The animal's.
    """
    n = len(pictures)
    side = max(3, int(CAMERA.blob_blur * extent) | 1)
    apart = np.empty(pictures.shape, np.float32)
    for own, difference in zip(apart, _differences(pictures, camera), strict=True):
        cv2.blur(difference, (side, side), dst=own)
    first = min(clicks)
    threshold = _threshold(apart, clicks[first], first, extent)
    kernel = cv2.getStructuringElement(
        cv2.MORPH_ELLIPSE, (max(3, int(CAMERA.blob_open * extent) | 1),) * 2
    )
    centre = np.full((n, 2), np.nan)
    angle, elongation = np.full(n, np.nan), np.full(n, np.nan)
    for row, rows in _both_ways(sorted(clicks), n):
        clicked = rows.step > 0 or np.isnan(centre[row, 0])
        last = clicks[row].mean(axis=0) if clicked else centre[row]
        unseen = 0
        for t in rows:
            leap = CAMERA.blob_leap * extent * float(np.sqrt(1 + unseen))
            found = _blob_near(apart[t] > threshold, kernel, last, extent=extent, leap=leap)
            unseen += 1
            if found is not None:
                centre[t], angle[t], elongation[t] = found
                last, unseen = centre[t], 0
    apart /= threshold  # in place: new memory of that size costs more than the quotients
    return Blob(centre, angle, elongation, np.minimum(apart, CAMERA.blob_most, out=apart))


def _both_ways(clicked: Sequence[int], n: int) -> Iterator[tuple[int, range]]:
    """Yield clicked rows, and those to which they are the nearest: from each on, then before it."""
    for i, row in enumerate(clicked):
        begin = (clicked[i - 1] + row) // 2 if i else -1
        end = (row + clicked[i + 1]) // 2 if i + 1 < len(clicked) else n - 1
        yield row, range(row, end + 1)
        yield row, range(row - 1, begin, -1)


def _differences(pictures: ByteArray, camera: CameraMotion) -> Iterator[np.ndarray]:
    """Yield the distance of every picture from the temporal median, float32."""
    n, height, width = pictures.shape
    if not camera.pans:
        rows = np.unique(np.linspace(0, n - 1, min(n, CAMERA.background_frames)).astype(int))
        background = np.median(pictures[rows], axis=0).astype(np.float32)
        for picture in pictures:
            yield np.abs(picture.astype(np.float32) - background)
        return
    around = np.array(CAMERA.background_around)
    for t, picture in enumerate(pictures):
        rows = np.unique(np.clip(t + around, 0, n - 1))
        warped = []
        for k in rows[np.abs(rows - t) >= CAMERA.background_apart]:
            # 1 more than grey, so that 0 is outside
            one = cv2.warpPerspective(
                pictures[k].astype(np.float32) + 1, camera.between(k, t), (width, height)
            )
            warped.append(np.where(one < 0.5, np.nan, one - 1))
        if not warped:
            yield np.zeros((height, width), np.float32)
            continue
        others = np.stack(warped)
        unseen = np.isnan(others).all(axis=0)  # by any neighbour: nothing differs there
        others[0, unseen] = picture[unseen]
        yield np.abs(picture - np.nanmedian(others, axis=0)).astype(np.float32)


def _threshold(apart: np.ndarray, clicked: np.ndarray, row: int, extent: float) -> float:
    """Return the difference from which on a pixel is foreground: half that about the clicks."""
    noise = float(
        np.median(np.median(apart[:: max(1, len(apart) // CAMERA.noise_frames)], axis=(1, 2)))
    )
    hull: np.ndarray = np.zeros(apart.shape[1:], np.uint8)
    cv2.fillConvexPoly(hull, cv2.convexHull(clicked.astype(np.float32)).astype(np.int32), 1)
    hull = cv2.dilate(hull, np.ones((int(CAMERA.blob_hull * extent) | 1,) * 2, np.uint8))
    about = apart[row][hull > 0]
    times, more = CAMERA.blob_noise
    clear = CAMERA.blob_share * float(np.median(about)) if len(about) else 0.0
    return max(times * noise + more, clear)


def _blob_near(
    mask: np.ndarray, kernel: np.ndarray, last: np.ndarray, *, extent: float, leap: float
) -> tuple[np.ndarray, float, float] | None:
    """Return centre, angle and elongation of the large blob near a place; None beyond a leap.

    Parameters
    ----------
    mask : ndarray of bool, shape (H, W)
        The foreground.
    kernel : ndarray
        What closes and opens it.
    last : ndarray, shape (2,)
        Where the animal was last, px.
    extent : float
        Its size, px.
    leap : float
        How far it may have got, px.
    """
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel)
    opened = cv2.morphologyEx(closed, cv2.MORPH_OPEN, kernel)  # takes tails and limbs away
    n, labels, stats, centres = cv2.connectedComponentsWithStats(opened)
    if n < 2:
        return None
    away = np.linalg.norm(centres[1:] - last, axis=1) / (CAMERA.blob_reach * extent)
    best = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA] / (1 + away**2)))
    if np.linalg.norm(centres[best] - last) > leap:
        return None  # another one that is larger, where the animal itself is not seen
    moments = cv2.moments((labels == best).astype(np.uint8), binaryImage=True)
    across, along = 2 * moments["mu11"], moments["mu20"] - moments["mu02"]
    size = moments["mu20"] + moments["mu02"] + 1e-9
    return centres[best], 0.5 * np.arctan2(across, along), float(np.hypot(across, along) / size)
