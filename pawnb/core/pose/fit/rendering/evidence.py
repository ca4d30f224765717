"""What a frame shows of the animal: darkness relative to the background's light, on a crop.

The light of the scene may change slowly over the picture and from frame to frame (a shadow that
passes, a flickering lamp): a gain is estimated in blocks from pixels that the expected animal
does not cover, and smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.fit.rendering.evidence_kernels import (
    behind_filter,
    block_gains,
    darkness,
    in_levels,
    smooth_gains,
)
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.parameters import RENDERING
from pawnb.core.video.views import Frame

_LEVELS = 200.0
"""Layout: steps of darkness, so that the opening works on bytes."""


class BackgroundPicture(Protocol):
    """The empty scene: grey values and their standard deviation, shape (H, W)."""

    @property
    def mean(self) -> AnyArray:
        """Mean grey values."""

    @property
    def sd(self) -> AnyArray:
        """Their standard deviation."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """Turns frames into :class:`ImageEvidence`; :func:`make_evidence` makes one.

    Parameters
    ----------
    mean, sd : ndarray, shape (H, W)
        The empty scene and its noise, grey working pixels.
    factor : int
        View pixels along each side of a working pixel.
    light : float
        0 for an animal darker than the background, else its grey value.
    spread : float
        Standard deviation of what a well fitted animal leaves unexplained, relative darkness.
    """

    mean: FloatArray
    sd: FloatArray
    factor: int
    light: float
    spread: float

    @property
    def height(self) -> int:
        """Height of the picture, working px."""
        return self.mean.shape[0]

    @property
    def width(self) -> int:
        """Width of the picture, working px."""
        return self.mean.shape[1]

    def crop_box(self, centre: FloatArray, reach: float) -> tuple[int, int, int, int]:
        """Return the crop about a place, cut at the picture's edges, working pixels."""
        u0, v0 = (int(max(0, np.floor(c - reach))) for c in centre)
        u1 = int(min(self.width, np.ceil(centre[0] + reach) + 1))
        v1 = int(min(self.height, np.ceil(centre[1] + reach) + 1))
        u0, v0 = min(u0, self.width - 2), min(v0, self.height - 2)
        return u0, v0, max(u1, u0 + 2), max(v1, v0 + 2)

    def pixels(self, frame: Frame, box: tuple[int, int, int, int]) -> FloatArray:
        """Return the crop of a frame as grey working pixels."""
        f = self.factor
        u0, v0, u1, v1 = (f * edge for edge in box)
        return grey(frame.reduced(u0, v0, u1, v1, factor=f), np.float64)

    def image_evidence(
        self, image: FloatArray, box: tuple[int, int, int, int], covered: IntArray
    ) -> ImageEvidence:
        """Return what a crop shows.

        Parameters
        ----------
        image : ndarray, shape (H, W), float
            Grey working pixels (:meth:`pixels`).
        box : tuple of int
            Where they lie.
        covered : ndarray, shape (H, W), int
            -1 where the animal is not expected.

        Returns
        -------
        ImageEvidence
            Darkness and its weight.
        """
        u0, v0, u1, v1 = box
        mean, sd = self.mean[v0:v1, u0:u1], self.sd[v0:v1, u0:u1]
        block = max(RENDERING.least_block_px, int(max(image.shape) / RENDERING.blocks_across))
        gains, counts = block_gains(image, mean, covered, block, RENDERING.black_level)
        gains = smooth_gains(gains, counts, RENDERING.light_spread)
        seen, weight = np.empty(image.shape), np.empty(image.shape)
        limits = (*RENDERING.darkness_limits, RENDERING.least_contrast)
        darkness(image, mean, sd, gains, block, self.light, self.spread, limits, seen, weight)
        return ImageEvidence(seen, weight, np.array([float(u0), float(v0)]))


def make_evidence(
    background: BackgroundPicture, *, factor: int, light: float, spread: float
) -> Evidence:
    """Return what turns frames of a scene into evidence.

    Parameters
    ----------
    background : Background
        The empty scene, in pixels of the view.
    factor, light, spread
        As :class:`Evidence` has them.

    Returns
    -------
    Evidence
        With the scene in working pixels.
    """
    sd = np.nan_to_num(np.asarray(background.sd, dtype=float), nan=0.0)
    return Evidence(
        mean=reduced(background.mean, factor),
        # noise of neighbours is taken as independent
        sd=np.sqrt(reduced(sd**2, factor)) / factor,
        factor=factor,
        light=light,
        spread=spread,
    )


def without_wide(image_evidence: ImageEvidence, body: BoolArray, *, size: int) -> ImageEvidence:
    """Return evidence in which only the body and what is as thin as a leg is dark.

    Wings, the shadow of someone who passes, a lump of debris that a leg touches: whatever holds a
    disc wider than the thickest leg is no leg. It is taken as a filter before which legs are
    seen, as far as it is not black.

    Parameters
    ----------
    image_evidence : ImageEvidence
        What the crop shows.
    body : ndarray of bool, shape (H, W)
        Where the body may be, which is wide itself: it stays as it is.
    size : int
        Diameter of the disc, working px.

    Returns
    -------
    ImageEvidence
        Darkness relative to the light that is left, and its weight.

    Notes
    -----
    The filter is the grey opening by the disc (Serra 1982), and what is left the top hat of the
    picture, divided by the light that the filter lets through.
    """
    whole = np.empty(image_evidence.seen.shape, np.uint8)
    in_levels(image_evidence.seen, _LEVELS, whole)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    wide = cv2.morphologyEx(whole, cv2.MORPH_OPEN, disc)
    seen, weight = image_evidence.seen.copy(), image_evidence.weight.copy()
    behind_filter(
        wide, 1.0 / _LEVELS, RENDERING.evidence_uneven, RENDERING.evidence_black, body, seen, weight
    )
    return ImageEvidence(seen, weight, image_evidence.box)


def reduced(picture: AnyArray, factor: int) -> FloatArray:
    """Return the mean of squares of ``factor`` pixels; a rest at right and bottom is left out."""
    height, width = (n // factor for n in picture.shape)
    whole = np.asarray(picture, dtype=float)[: height * factor, : width * factor]
    return whole.reshape(height, factor, width, factor).mean(axis=(1, 3))
