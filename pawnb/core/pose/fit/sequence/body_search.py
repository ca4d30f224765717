"""Where the body is, if it is not where it was expected."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.rendering.blur import blurred, part_of
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence


def find_body(
    fitter: FrameFitter, expected: FloatArray, image_evidence: ImageEvidence
) -> FloatArray:
    """Return the expected pose, moved as a whole onto the body where that is elsewhere.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    expected : ndarray, shape (n_parameters,)
        The pose vector that is expected.
    image_evidence : ImageEvidence
        What the frame shows.

    Returns
    -------
    ndarray, shape (n_parameters,)
        The array given where the body is in its place, as it is in most frames.
    """
    pose, radius = expected, fitter.body_radius
    reach = 2.0 * radius + max(FITTING.body_blurs)  # further away it is not felt
    image_evidence = part_of(image_evidence, expected[:2] - reach, expected[:2] + reach)
    for blur, surely in zip(FITTING.body_blurs, FITTING.body_surely_px, strict=True):
        pose, _ = fitter.fit(
            pose, blurred(image_evidence, blur), fitter.anatomy,
            active=fitter.index.body, shown=fitter.index.body_shown, blur=fitter.blur + blur,
            enough=FITTING.enough_of_body,
        )  # fmt: skip
        turned = radius * abs(pose[2] - expected[2])
        if np.hypot(*(pose[:2] - expected[:2])) + turned <= surely:
            return expected
    return pose
