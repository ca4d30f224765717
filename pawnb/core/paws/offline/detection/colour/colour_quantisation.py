"""Fine steps of colour, for paws that have nearly the colour of what they stand on.

The usual bins are 8 levels of red, green and blue wide. A paw on a belt as brown as it is
differs by less, in how red and how yellow it is, and two such colours share a bin. Here a
picture is turned into three numbers a pixel: brightness in steps of four levels, and how much
red exceeds green and blue their mean in steps of two. Thirty-two steps of each then reach only
as far as colours like the paws': all that is farther counts as the last step.

Where paws are hardly distinguished from their surroundings even so, the noise of a camera is larger
than what is between them. Pictures are then smoothed over about a third of a paw, and a place
counts by how much its score exceeds what is usual about it: a shadow that passes for a paw here and
there does so all over.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.core.paws.offline.detection.parameters import COLOUR

_BRIGHTER, _REDDER, _BLUER = (0.30, 0.59, 0.11), (1.0, -1.0, 0.0), (-0.5, -0.5, 1.0)
"""Definition: axes of colour: luminance (ITU-R BT.601), red against green, and blue against
both."""
_MIDDLE = 127.5
"""Mathematics: the middle of 256 levels."""


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

    weights: np.ndarray
    is_faint: bool = False

    def of(self, pixels: np.ndarray) -> np.ndarray:
        """Return a picture (h, w, 3), uint8, smoothed and in fine steps: 8 levels are one step."""
        return np.asarray(cv2.transform(smooth_fine_colours(pixels, self.is_faint), self.weights))

    def stand_out(self, score: np.ndarray) -> np.ndarray:
        """Return the score (h, w) of places by which they differ from what is about them."""
        if not self.is_faint:
            return score
        about = cv2.blur(np.maximum(score, 0.0), (COLOUR.about_px, COLOUR.about_px))
        return np.asarray(score - np.float32(COLOUR.colour_quantisation_less) * about)


def fine_colours_near(colours: np.ndarray, *, is_faint: bool = False) -> FineColours:
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


def smooth_fine_colours(pixels: np.ndarray, is_faint: bool) -> np.ndarray:
    """Return a picture (h, w, 3), uint8, without the noise of single pixels."""
    side, px = COLOUR.smooth_much if is_faint else COLOUR.colour_quantisation_smooth
    return np.asarray(cv2.GaussianBlur(pixels, (side, side), px))


def fine_colours_floor() -> np.ndarray:
    """Return the least covariance (3, 3) of a colour in fine steps."""
    return np.diag(COLOUR.colour_quantisation_noise) ** 2
