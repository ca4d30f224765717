"""What a frame shows near an expected pose, as evidence that a fitter fits to."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.attached_clutter_kernels import hide
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.rendering.evidence import without_wide
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, paint_some
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING
from pawnb.core.video.views import Frame

Box = tuple[int, int, int, int]
"""u0, v0, u1, v1 of a crop, half open, working px."""
_SUBPIXEL = 4
"""Layout: bits of places between pixels, as OpenCV draws them."""


def crop_box(fitter: FrameFitter, expected: FloatArray) -> Box:
    """Return the crop that holds the expected animal."""
    return fitter.evidence.crop_box(expected[:2], fitter.reach)


def observe(
    fitter: FrameFitter, frame: Frame, expected: FloatArray, *, margin: float | None = None
) -> tuple[ImageEvidence, FloatArray, Box]:
    """Return what a frame shows about the expected pose, its grey pixels and their box.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    frame : Frame
        The frame.
    expected : ndarray
        The pose vector that is expected.
    margin : float, optional
        Room about its body, working px; default the parameter ``body_margin_px``.

    Returns
    -------
    tuple
        What the frame shows (ImageEvidence), its grey pixels (H, W), and their box.
    """
    box = crop_box(fitter, expected)
    image = fitter.evidence.pixels(frame, box)
    return evidence_of(fitter, expected, image=image, box=box, margin=margin), image, box


def evidence_of(
    fitter: FrameFitter,
    expected: FloatArray,
    *,
    image: FloatArray,
    box: Box,
    margin: float | None = None,
) -> ImageEvidence:
    """Return what grey pixels show, the expected animal left out of the light.

    What is wider than a leg and further than ``margin`` (working px) from the expected body
    does not count as dark; see :func:`.evidence.without_wide`.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    expected : ndarray
        The pose vector that is expected.
    image : ndarray, shape (H, W)
        Grey pixels.
    box : tuple of int
        Their place in the picture, px.
    margin : float, optional
        Room about its body, working px; default the parameter ``body_margin_px``. Infinite:
        nothing is too wide.

    Returns
    -------
    ImageEvidence
        What they show.
    """
    empty = ImageEvidence(image, image, np.array([float(box[0]), float(box[1])]))
    seen = fitter.evidence.image_evidence(image, box, _cover(fitter, expected, empty))
    return seen if margin == np.inf else narrowed(fitter, seen, expected, margin=margin)


def _cover(fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence) -> IntArray:
    """Return where the animal and what is beside it may be: not -1; it does not last."""
    canvas = fitter.canvas(image_evidence)
    body = fitter.index.body_shown
    paint_some(fitter.layout, pose, FITTING.cover_px, image_evidence.box, body, *canvas)
    owner = canvas[1]
    for places, radius in zip(fitter.joints(pose), fitter.layout.radius, strict=True):
        known = places[np.isfinite(places[:, 0])] - image_evidence.box
        ends = np.round(known * (1 << _SUBPIXEL)).astype(np.int32)
        wide = round(2.0 * (float(radius.max()) + FITTING.cover_px))
        cv2.polylines(owner, [ends], False, 0, wide, cv2.LINE_8, _SUBPIXEL)
    return owner


def narrowed(
    fitter: FrameFitter,
    image_evidence: ImageEvidence,
    expected: FloatArray,
    *,
    margin: float | None = None,
) -> ImageEvidence:
    """Return evidence in which what is wider than a leg, but for the body, is not dark.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with, and what is known to be fixed to the body.
    image_evidence : ImageEvidence
        What a frame shows.
    expected : ndarray
        The pose vector that is expected.
    margin : float
        Room about the body, working px.

    Returns
    -------
    ImageEvidence
        The same without what is wide.
    """
    body = near_body(fitter, expected, image_evidence, margin=margin)
    attached = fitter.clutter.attached
    if attached is not None:
        seen, weight = image_evidence.seen.copy(), image_evidence.weight.copy()
        hide(attached, expected, body, image_evidence.box, seen, weight)
        image_evidence = image_evidence._replace(seen=seen, weight=weight)
    return without_wide(image_evidence, body, size=disc_px(fitter))


def near_body(
    fitter: FrameFitter,
    pose: FloatArray,
    image_evidence: ImageEvidence,
    *,
    margin: float | None = None,
) -> BoolArray:
    """Return where the body is, and what is nearer to it than ``margin``: bool, (H, W).

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.
    margin : float
        How near, working px.

    Returns
    -------
    ndarray of bool, shape (H, W)
        True at and about the body.
    """
    canvas = fitter.canvas(image_evidence)
    margin = FITTING.body_margin_px if margin is None else margin
    shown = fitter.index.body_shown
    paint_some(fitter.layout, pose, margin, image_evidence.box, shown, *canvas)
    return np.asarray(canvas[1] != NOTHING)


def disc_px(fitter: FrameFitter) -> int:
    """Return the diameter of a disc that fits into no leg, working px, an odd number."""
    radius = min(fitter.layout.radius.max(), fitter.initial.radius.max())
    thickest = 2.0 * float(radius) + fitter.blur
    return 2 * round(FITTING.fitter_wider * thickest / 2) + 1
