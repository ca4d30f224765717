"""Where legs leave the body: what is seen there is darker than either of them is painted.

A pixel on the edge of both a leg and the body is covered by both, and the painted animal has it as
dark as the darker of the two. As legs leave the two sides at different places, these corners
would turn the body: they are left out of account.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.rendering.blur import part_of
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, paint_some
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING
from pawnb.core.pose.fit.rendering.parameters import RENDERING


def without_leg_attachments(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> ImageEvidence:
    """Return evidence in which corners have no weight; the animal is at ``pose``.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ImageEvidence
        The same without the corners.
    """
    reach = fitter.body_radius + fitter.blur
    near = part_of(image_evidence, pose[:2] - reach, pose[:2] + reach)
    body, darkest = fitter.index.body_shown, fitter.layout.ellipse[:, 4].max()
    of_body = _painted(fitter, pose, near, body) / darkest
    of_legs = _painted(fitter, pose, near, ~body)
    left, top = (near.box - image_evidence.box).astype(int)
    height, width = near.seen.shape
    weight = image_evidence.weight.copy()
    part = weight[top : top + height, left : left + width]
    part[
        (of_legs > RENDERING.leg_attachments_some)
        & (of_body > RENDERING.leg_attachments_some)
        & (of_body < RENDERING.leg_attachments_whole)
    ] = 0.0
    return image_evidence._replace(weight=weight)


def _painted(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, shown: BoolArray
) -> FloatArray:
    """Return how dark some parts of the animal are painted."""
    canvas = fitter.canvas(image_evidence)
    paint_some(fitter.layout, pose, fitter.blur, image_evidence.box, shown, *canvas)
    return np.where(canvas[1] != NOTHING, canvas[0], 0.0)
