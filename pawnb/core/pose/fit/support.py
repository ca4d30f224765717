"""What a pose explains of a frame: how dark its legs and body are, and what it leaves over."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.candidate_kernels import (
    cover_painted,
    leg_support,
    paint_base,
    unexplained,
)
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, paint_some


def leg_supports(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> FloatArray:
    """Return how much of each leg, and of its outer third, is dark.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout, and the canvas that is painted on.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ndarray, shape (legs, 2)
        0 to 1. What lies on the body does not count; NaN where nothing is left.
    """
    joints, body = fitter.joints(pose), body_zone(fitter, pose, image_evidence)
    limits = (FITTING.outer_share, FITTING.support_least_dark, FITTING.support_as_dark)
    return np.array(
        [
            leg_support(fitter.layout, joints[leg], leg, image_evidence, fitter.blur, limits, body)
            for leg in range(len(joints))
        ]
    )


def body_support(fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence) -> float:
    """Return how dark the body's place is relative to what is expected.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout, and the canvas that is painted on.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    float
        0 if it is out of sight.
    """
    value, owner, along, joints = fitter.canvas(image_evidence)
    paint_some(
        fitter.layout,
        pose,
        fitter.blur,
        image_evidence.box,
        fitter.index.body_shown,
        value,
        owner,
        along,
        joints,
    )
    inside = owner != -1
    total = float(value[inside].sum())
    if total == 0.0:
        return 0.0
    return float(np.minimum(image_evidence.seen[inside], value[inside]).sum()) / total


def body_zone(fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence) -> FloatArray:
    """Return the painted body, and more than black where its edge may be.

    A body is no perfect egg: what is dark beside it is as well more of it as a leg that
    lies along its edge.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout, and the canvas that is painted on.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ndarray, shape (h, w)
        The fitter's canvas: it does not last.
    """
    value, owner, _, _ = fitter.canvas(image_evidence)
    layout, ellipse = fitter.layout, fitter.layout.ellipse.copy()
    ellipse[:, 2:4] += FITTING.body_margin_px
    paint_base(layout._replace(ellipse=ellipse), pose, fitter.blur, image_evidence, value, owner)
    cover_painted(value, owner, FITTING.no_leg)
    return value


def count_unexplained(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence
) -> FloatArray:
    """Count the dark working pixels near the animal that it does not cover.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout, and the canvas that is painted on.
    pose : ndarray
        The pose vector.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ndarray, shape (2,)
        Those on the animal's left, and on its right.
    """
    value, owner, along, joints = fitter.canvas(image_evidence)
    paint_some(
        fitter.layout, pose, fitter.blur + 2.0, image_evidence.box, fitter.index.all_shown,
        value, owner, along, joints,
    )  # fmt: skip
    dark = 0.5 * float(np.median(fitter.layout.dark))
    return unexplained(owner, image_evidence, dark, fitter.reach, pose)
