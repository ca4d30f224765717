"""From pixels to the bins of a table: the usual ones, and fine steps of colour.

The usual bins are 8 levels of red, green and blue wide (in a grey picture: of brightness, and of
what it exceeds the background and the surroundings by). A paw on a belt as brown as it is differs
by less, in how red and how yellow it is, and two such colours share a bin. For such paws a picture
is turned into three numbers a pixel: brightness in steps of four levels, and how much red exceeds
green and blue their mean in steps of two. Thirty-two steps of each then reach only as far as
colours like the paws': all that is farther counts as the last step.

Where paws are hardly distinguished from their surroundings even so, the noise of a camera is larger
than what is between them. Pictures are then smoothed over about a third of a paw, and a place
counts by how much its score exceeds what is usual about it: a shadow that passes for a paw here and
there does so all over.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from pawnb.arrays import AnyArray, ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR

_BRIGHTER, _REDDER, _BLUER = (0.30, 0.59, 0.11), (1.0, -1.0, 0.0), (-0.5, -0.5, 1.0)
"""Definition: axes of colour: luminance (ITU-R BT.601), red against green, and blue against
both."""
_MIDDLE = 127.5
"""Mathematics: the middle of 256 levels."""
_BINS = 32
"""Layout: steps of each channel in a table of colours."""
_BITS_DROPPED = 3
"""Layout: bits by which 256 levels are reduced to these steps."""


@dataclass(frozen=True)
class FineColours:
    """What turns a colour into fine steps.

    Parameters
    ----------
    weights : ndarray, shape (3, 4), float32
        Weights of red, green and blue, and what is added.
    is_faint : bool
        Whether paws are hardly distinguished from their surroundings: pictures are smoothed more,
        and scores are compared with those about them.
    """

    weights: Float32Array
    is_faint: bool = False

    def of(self, pixels: ByteArray) -> ByteArray:
        """Return a picture (h, w, 3), uint8, smoothed and in fine steps: 8 levels are one step."""
        return np.asarray(cv2.transform(smooth_fine_colours(pixels, self.is_faint), self.weights))

    def stand_out(self, score: Float32Array) -> Float32Array:
        """Return the score (h, w) of places by which they differ from what is about them."""
        if not self.is_faint:
            return score
        about = cv2.blur(np.maximum(score, 0.0), (COLOUR.about_px, COLOUR.about_px))
        return np.asarray(score - np.float32(COLOUR.colour_quantisation_less) * about)


def fine_colours_near(colours: AnyArray, *, is_faint: bool = False) -> FineColours:
    """Return what turns a colour into fine steps about the middle of some colours.

    Parameters
    ----------
    colours : ndarray, shape (n, 3)
        Red, green and blue of the paws.
    is_faint : bool
        See :class:`FineColours`.

    Returns
    -------
    FineColours
        Steps with the middle of these colours in their middle.
    """
    weights = (
        np.array([_BRIGHTER, _REDDER, _BLUER]) * np.array(COLOUR.colour_quantisation_steps)[:, None]
    )
    middle = np.median(colours, axis=0)
    added = _MIDDLE - weights @ middle
    return FineColours(np.column_stack([weights, added]).astype(np.float32), is_faint)


def smooth_fine_colours(pixels: ByteArray, is_faint: bool) -> ByteArray:
    """Return a picture (h, w, 3), uint8, without the noise of single pixels."""
    side, px = COLOUR.smooth_much if is_faint else COLOUR.colour_quantisation_smooth
    return np.asarray(cv2.GaussianBlur(pixels, (side, side), px))


def fine_colours_floor() -> FloatArray:
    """Return the least covariance (3, 3) of a colour in fine steps."""
    return np.diag(COLOUR.colour_quantisation_noise) ** 2


def bin_numbers(
    pixels: AnyArray,
    around_px: int,
    background: AnyArray | None = None,
    *,
    fine_colours: FineColours | None = None,
) -> AnyArray:
    """Return the bin (h, w) of each pixel of an RGB or a grey picture.

    Parameters
    ----------
    pixels : ndarray, shape (h, w, 3) or (h, w)
        A picture.
    around_px : int
        Side of what a grey pixel is compared with, px.
    background : ndarray, optional
        The empty scene, of the same shape.
    fine_colours : FineColours, optional
        Finer steps of colour.

    Returns
    -------
    ndarray of int, shape (h, w)
        Numbers of bins.
    """
    pixels = (
        cv2.GaussianBlur(pixels, (3, 3), COLOUR.fine_blur_px)
        if fine_colours is None
        else fine_colours.of(pixels)
    )
    if pixels.ndim == 2:
        p = pixels.astype(np.int32)
        over_around = _over(p, cv2.blur(pixels, (around_px, around_px)))
        # the same where nothing is known to stand still: it then says nothing
        over_still = np.zeros_like(p) if background is None else _over(p, background)
        return ((p >> _BITS_DROPPED) << 10) | (over_still << 5) | over_around
    # five bits of each channel in one number
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR555).view(np.uint16)[..., 0]


def _over(pixels: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return by how many steps of 8 grey levels pixels exceed others, from -8 as 0 to 31."""
    return np.asarray(
        np.clip((pixels - base + (8 << _BITS_DROPPED)) >> _BITS_DROPPED, 0, _BINS - 1)
    )


def features_of_bins(is_colour: bool, fine_colours: FineColours | None) -> FloatArray:
    """Return the features of the middle of every bin: CIE Lab, three grey levels, or shades."""
    n = np.arange(_BINS**3)
    levels = np.stack([n >> 10, (n >> 5) & 31, n & 31], axis=1) * (1 << _BITS_DROPPED)
    levels = levels + 0.5 * ((1 << _BITS_DROPPED) - 1)
    if not is_colour or fine_colours is not None:
        return levels
    lab = cv2.cvtColor((levels[None] / 255.0).astype(np.float32), cv2.COLOR_RGB2LAB)
    return lab[0].astype(float)


def histogram_of_bins(numbers: IntArray) -> FloatArray:
    """Return the smoothed frequency of each bin."""
    count = np.bincount(numbers, minlength=_BINS**3).astype(float)
    count = gaussian_filter(count.reshape(_BINS, _BINS, _BINS), COLOUR.histogram_blur).ravel()
    even = COLOUR.histogram_even
    return count / count.sum() * (1.0 - even) + even / _BINS**3
