"""Where the body is not as it is painted (jaws, palps, spinnerets), learnt from the recording.

Its parts are painted as eggs. What sticks out of them would draw their outline, and with it the
place of the body: it is left out of account.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.attached_clutter_kernels import disregard, in_body_frame
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.observation import near_body
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint


def find_body_clutter(
    fitter: FrameFitter, frames: Sequence[tuple[FloatArray, ImageEvidence]]
) -> FloatArray | None:
    """Return how much each place of the body's frame counts.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    frames : sequence of (ndarray, ImageEvidence)
        Frames whose pose is known.

    Returns
    -------
    ndarray, shape (side, side), or None
        0 where the median of the frames shows something else than is painted, else 1; working
        pixels, the body looks along the rows, its origin is the middle. None of too few frames,
        and where so much is odd that too little would be left.
    """
    if len(frames) < LEARNING.body_clutter_few:
        return None
    side = 2 * int(np.ceil(fitter.body_radius + LEARNING.beyond_px)) + 1
    stack = np.array(
        [_difference(fitter, pose, image_evidence, side) for pose, image_evidence in frames]
    )
    stack[:, np.isnan(stack).all(axis=0)] = 0.0
    away = np.abs(np.nanmedian(stack, axis=0))
    pose, empty = np.zeros(fitter.index.n), np.zeros((side, side))
    middle = np.array([-(side // 2), -(side // 2)], dtype=float)
    body = near_body(fitter, pose, ImageEvidence(empty, empty, middle), margin=fitter.blur)
    odd = away > LEARNING.body_clutter_odd * float(fitter.layout.ellipse[:, 4].max())
    if odd[body].mean() > LEARNING.body_clutter_most:
        return None
    disc = np.ones((2 * LEARNING.grows_px + 1, 2 * LEARNING.grows_px + 1), np.uint8)
    return 1.0 - cv2.dilate(odd.astype(np.uint8), disc).astype(float)


def _difference(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, side: int
) -> FloatArray:
    """Return what is seen less what is painted, in the body's frame; NaN where a leg is."""
    canvas = make_canvas(len(image_evidence.seen), image_evidence.seen.shape[1], fitter.layout)
    paint(fitter.layout, pose, fitter.blur, image_evidence.box, *canvas)
    away, leg = np.empty((side, side)), np.empty((side, side))
    in_body_frame(image_evidence.seen - canvas[0], image_evidence.box, pose, away)
    in_body_frame((canvas[1] >= 0).astype(float), image_evidence.box, pose, leg)
    away[leg > LEARNING.body_clutter_leg] = np.nan
    return away


def without_body_clutter(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> ImageEvidence:
    """Return evidence in which the fitter's odd places have no weight; the body is at ``pose``.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with, and its odd places.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ImageEvidence
        The same without them.
    """
    if fitter.clutter.body is None:
        return image_evidence
    weight = image_evidence.weight.copy()
    disregard(fitter.clutter.body, pose, image_evidence.box, weight)
    return image_evidence._replace(weight=weight)
