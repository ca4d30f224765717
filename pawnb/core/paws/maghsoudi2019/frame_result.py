"""What one frame yields: the best superpixels of each sub-image, and the positions."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import FloatArray, IntArray, Points2D
from pawnb.core.paws.superpixels import Superpixels


@dataclass(frozen=True)
class Detection:
    """What was found for one point in one view and frame.

    Parameters
    ----------
    superpixels : Superpixels
        The superpixels of the sub-image.
    best : ndarray of int, shape (k,)
        The best of them, best first.
    scores : ndarray, shape (k,)
        Their fused scores.
    """

    superpixels: Superpixels
    best: IntArray
    scores: FloatArray

    @property
    def places(self) -> FloatArray:
        """Positions of the best superpixels, px, shape (k, 2)."""
        return self.superpixels.uv[self.best]


@dataclass
class FrameResult:
    """What one frame yields, for V views and P points.

    Parameters
    ----------
    uv : ndarray, shape (V, P, 2)
        Image positions, px; NaN where missing.
    image_origin : ndarray of int, shape (V, P)
        Codes of :data:`pawnb.schema.ORIGINS`.
    image_confidence : ndarray, shape (V, P)
        0 to 1.
    position : ndarray, shape (P, d)
        Positions in calibrated space, or in the picture where nothing is calibrated.
    origin : ndarray of int, shape (P,)
        Codes of the positions.
    confidence : ndarray, shape (P,)
        0 to 1.
    residual : ndarray, shape (P,)
        RMS reprojection error over the views used, px.
    """

    uv: Points2D
    image_origin: IntArray
    image_confidence: FloatArray
    position: FloatArray
    origin: IntArray
    confidence: FloatArray
    residual: FloatArray
