"""Where hairs and spines stand out from legs, learnt from the recording.

A leg is painted alike on both sides. What stands out on one of them would draw it to that side,
its pale end most: it is left out of account.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.leg_clutter_kernels import add_differences, disregard_cells
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, paint_some
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint


def find_leg_clutter(
    fitter: FrameFitter, frames: Sequence[tuple[FloatArray, ImageEvidence]]
) -> BoolArray | None:
    """Return where hairs stand out from legs.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    frames : sequence of (ndarray, ImageEvidence)
        Frames whose pose is known.

    Returns
    -------
    ndarray of bool, shape (legs, segments, along, across), or None
        Cells of every segment; those across are half a working pixel wide by default, the middle
        one lies on the axis. None of too few frames.
    """
    if len(frames) < LEARNING.leg_clutter_few:
        return None
    seen = np.array([_differences(fitter, pose, image_evidence) for pose, image_evidence in frames])
    seen[:, np.isnan(seen).all(axis=0)] = 0.0  # where no pixel ever lies, it is as painted
    darker = np.nanmedian(seen, axis=0)
    leg_clutter = (darker > LEARNING.leg_clutter_hairy) & (
        darker - darker[..., ::-1] > LEARNING.leg_clutter_hairy
    )
    grown = leg_clutter.copy()  # the blur spreads a hair by a cell
    grown[..., 1:] |= leg_clutter[..., :-1]
    grown[..., :-1] |= leg_clutter[..., 1:]
    return grown


def _differences(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> FloatArray:
    """Return what is seen less what is painted in the cells of the legs; NaN where nothing is."""
    layout = fitter.layout
    canvas = make_canvas(len(image_evidence.seen), image_evidence.seen.shape[1], layout)
    paint(layout, pose, fitter.blur, image_evidence.box, *canvas)
    in_px = LEARNING.leg_clutter_in_px
    across = 2 * in_px * int(np.ceil(layout.radius.max() + fitter.blur)) + 1
    total, count = np.zeros((2, *layout.length.shape, LEARNING.leg_clutter_along, across))
    add_differences(canvas, image_evidence.seen, image_evidence.box, in_px, total, count)
    return np.where(count > 0.0, total, np.nan) / np.maximum(count, 1.0)


def without_leg_clutter(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> ImageEvidence:
    """Return evidence in which the hairs of legs have no weight; the animal is at ``pose``.

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
        The same without the hairs.
    """
    if fitter.clutter.legs is None:
        return image_evidence
    canvas, shown = fitter.canvas(image_evidence), fitter.index.all_shown
    paint_some(fitter.layout, pose, fitter.blur, image_evidence.box, shown, *canvas)
    weight = image_evidence.weight.copy()
    in_px = LEARNING.leg_clutter_in_px
    disregard_cells(canvas, image_evidence.box, fitter.clutter.legs, in_px, weight)
    return image_evidence._replace(weight=weight)
