"""Where a paw may be in one picture: the ends of paw-coloured parts.

Pixels whose colour is likelier on a paw make a mask. At the end of a limb the share of
mask in a square about a pixel is about half of what it is further along, whatever the
limb's direction, so ends are the mask's local minima of that share. The position is
the centre of the mask's pixels near the end, and the direction in which the limb ends is
that from the centre of a wider neighbourhood to it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from pawnb.arrays import AnyArray, Float32Array, FloatArray
from pawnb.core.paws.offline.detection.colour import detector_kernels as loops
from pawnb.core.paws.offline.detection.colour.blob_detection import detect_blobs
from pawnb.core.paws.offline.detection.colour.colour_model import Appearance
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.photometry.illumination import normalise_illumination
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR

_NO_LIMITS = np.empty((0, 3))
"""Layout: no line bounds where detections lie."""


@dataclass(frozen=True)
class DetectorConfig:
    """How the pictures of one view are searched.

    Parameters
    ----------
    appearance : Appearance
        What paws look like.
    shrink : int
        Pictures are reduced by this factor first.
    reach : int
        Half the side of the square, in reduced pixels, in which an end is looked for.
    limb_direction : tuple of float
        Unit vector in the picture in which limbs tend to end: forward and down.
    limits : ndarray, shape (m, 3), optional
        Lines with ``a u + b v + c >= 0`` on the side where paws can be.
    is_below : bool
        Whether the view is from below: paws are spots there, not ends of limbs.
    finds_blobs : bool
        Whether the score is learnt, and high at the paws' points themselves: spots, too.
    illumination : tuple of float, optional
        Mean of each channel of the searched part at the clicks; see
        :func:`~pawnb.core.paws.offline.detection.colour.photometry.illumination.normalise_illumination`.
    most : int
        Detections kept in one picture.
    """

    appearance: Appearance
    shrink: int
    reach: int
    limb_direction: tuple[float, float] = (0.0, 1.0)
    limits: FloatArray | None = None
    is_below: bool = False
    finds_blobs: bool = False
    illumination: tuple[float, ...] | None = None
    most: int = field(default_factory=lambda: COLOUR.most_found)


def detect(pixels: AnyArray, origin: tuple[int, int], detector: DetectorConfig) -> ColourDetections:
    """Find the ends of paw-coloured parts.

    Parameters
    ----------
    pixels : ndarray
        Part of a view, RGB or grey, uint8, reduced by ``detector.shrink``.
    origin : tuple of int
        Its left and top in the view, px.
    detector : DetectorConfig
        How to search.

    Returns
    -------
    ColourDetections
        The likeliest ends.
    """
    pixels = normalise_illumination(pixels, detector.illumination)
    score = detector.appearance.score(pixels, origin, shrink=detector.shrink)
    if detector.is_below or detector.finds_blobs:
        return _blobs(score, origin, detector)
    score = cv2.GaussianBlur(score, (3, 3), COLOUR.score_blur_px)
    weight = loops.weigh(score)
    r = detector.reach
    v, u, share = loops.find_ends(score, weight, r, r // 2)
    # specks are not ends: there must be mask behind
    order = np.argsort(share)
    order = order[share[order] * (2 * r + 1) ** 2 > COLOUR.least_behind * r * r]
    pixels, share = np.array([u[order], v[order]]), share[order]
    near = loops.centres(weight, pixels[0], pixels[1], r)
    if len(share) > COLOUR.looked_at:
        # edges of all sorts have thin ends: those that look most like paws are kept, in order
        promise = _likeness(loops.mean_score(score, near), share)
        best = np.sort(np.argsort(-promise, kind="stable")[: COLOUR.looked_at])
        pixels, share, near = np.ascontiguousarray(pixels[:, best]), share[best], near[best]
    limits = _NO_LIMITS if detector.limits is None else np.asarray(detector.limits, float)
    grid = (*origin, detector.shrink)
    found = ColourDetections(
        loops.describe(score, weight, pixels, share, near, r, COLOUR.ends_apart, limits, grid)
    )
    best = np.argsort(-endpoint_score(found, detector.limb_direction), kind="stable")
    return ColourDetections(found.table[best[: detector.most]].astype(np.float32))


def _blobs(
    score: Float32Array, origin: tuple[int, int], detector: DetectorConfig
) -> ColourDetections:
    """Return the detections of a view from below: each points where limbs tend to end."""
    at, likeness = detect_blobs(score, detector.reach, detector.appearance.usual)
    at = (at + 0.5) * detector.shrink - 0.5 + origin
    if detector.limits is not None:
        inside = (at @ detector.limits[:, :2].T + detector.limits[:, 2] >= 0).all(axis=1)
        at, likeness = at[inside], likeness[inside]
    direction = np.broadcast_to(
        np.asarray(detector.limb_direction) * detector.reach * detector.shrink, at.shape
    )
    # endpoint_score() is their likeness
    found = ColourDetections.of(
        at, direction=direction, coverage=np.zeros(len(at)), score=0.5 + 2.0 * likeness, tip=at
    )
    return found.take(np.argsort(-likeness, kind="stable")[: detector.most])


def endpoint_score(found: ColourDetections, limb_direction: tuple[float, float]) -> FloatArray:
    """Return how much each detection of one view looks like the end of a paw, 0 to 1."""
    length = np.hypot(found.direction[:, 0], found.direction[:, 1])
    cosine = (found.direction @ np.asarray(limb_direction)) / np.maximum(length, 1e-6)
    # an end that points back or up is a heel, an elbow or the tail's
    ahead = np.clip(
        COLOUR.direction_usual + COLOUR.direction_gain * cosine, COLOUR.least_likeness, 1.0
    )
    return np.asarray(_likeness(found.score, found.coverage) * ahead)


def _likeness(score: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return how much a place looks like the end of a paw, wherever it points, 0 to 1."""
    # further along a limb the share is twice that at its end
    end = 1.0 / (1.0 + np.exp((share - COLOUR.detector_share) / COLOUR.share_spread))
    return np.asarray(np.clip(0.5 * (score - 0.5), COLOUR.least_likeness, 1.0) * end)
