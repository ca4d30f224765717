"""What the frames before make expected of a pose, and the pose near that which fits best."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.anatomy import about
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE


def usual_anatomy(fitter: FrameFitter, middle: FloatArray) -> Prior:
    """Return anatomy with the usual foreshortening of links.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    middle : ndarray, shape (links of all legs,)
        Logarithms of foreshortening.

    Returns
    -------
    Prior
        A new one.
    """
    whole = fitter.anatomy.middle.copy()
    whole[fitter.index.lengths] = middle
    return fitter.anatomy._replace(middle=whole)


def expectation(fitter: FrameFitter, anatomy: Prior, expected: FloatArray) -> Prior:
    """Return anatomy and the pose that is expected.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    anatomy : Prior
        As :func:`usual_anatomy` returns it.
    expected : ndarray, shape (n_parameters,)
        The pose vector that is expected.

    Returns
    -------
    Prior
        The product of both.
    """
    sd = np.full(fitter.index.n, np.inf)
    sd[fitter.index.angles] = np.radians(fitter.settings.angle_step_deg)
    sd[fitter.index.lengths] = fitter.settings.foreshortening_sd
    return about(anatomy, expected, sd)


def fit_expected(
    fitter: FrameFitter, expected: FloatArray, *, image_evidence: ImageEvidence, prior: Prior
) -> FloatArray:
    """Return the pose near the expected one that fits best: first blurred, then sharp.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    expected : ndarray
        The pose vector that is expected.
    image_evidence : ImageEvidence
        What the frame shows.
    prior : Prior
        As :func:`expectation` returns it.

    Returns
    -------
    ndarray
        The pose vector.
    """
    soft = blurred(image_evidence, SEQUENCE.coarse_blur)
    blur = fitter.blur + SEQUENCE.coarse_blur
    pose, _ = fitter.fit(expected, soft, prior, blur=blur, rounds=SEQUENCE.rounds_coarse)
    return fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.rounds_next)[0]
