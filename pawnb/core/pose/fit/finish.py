"""The last fit of every frame, with its neighbours in time on both sides, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.core.pose.fit.choices import Choices
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.paint_loops import paint
from pawnb.core.pose.fit.priors import about
from pawnb.core.pose.fit.uncertainty_loops import error_ratio, place_sds

_ANGLE_SD_DEG = 4.0
_LENGTH_SD = 0.06
_ALIKE_PX = 3.0
"""Errors of pixels nearer than this go together: so many pixels count as one in each direction."""


@dataclass(frozen=True)
class Settled:
    """A frame's last fit; working pixels and radians.

    Attributes
    ----------
    pose, sd : ndarray, shape (n_parameters,)
        The pose and its standard deviations.
    places_sd : ndarray, shape (legs, segments + 1, 2)
        Standard deviations of joints and tips.
    support : ndarray, shape (legs, 2)
        How dark each leg and its outer third are relative to what is expected.
    """

    pose: np.ndarray
    sd: np.ndarray
    places_sd: np.ndarray
    support: np.ndarray


def settle(
    fitter: FrameFitter, choices: Choices, pose: np.ndarray, *, expected: np.ndarray
) -> Settled:
    """Fit one frame for good.

    Parameters
    ----------
    fitter : FrameFitter
        Fitter of this thread; its anatomy has the recording's mean foreshortening.
    choices : Choices
        The frame's pixels.
    pose : ndarray
        The pose that the path goes through.
    expected : ndarray
        Middle of the poses of the frames before and after.

    Returns
    -------
    Settled
        The pose and its uncertainty.
    """
    sight = fitter.sight(choices.image.astype(float), choices.box, pose)
    sd = np.full(fitter.n, np.inf)
    sd[fitter.angles] = np.radians(_ANGLE_SD_DEG)
    sd[fitter.lengths] = _LENGTH_SD
    prior = about(fitter.anatomy, expected, sd)
    pose, _ = fitter.fit(pose, sight, prior, rounds=5)
    information = fitter.information(pose, sight, prior)
    canvas = fitter.canvas(sight)
    paint(fitter.layout, pose, fitter.blur, sight.box, *canvas)
    ratio = error_ratio(canvas[0], canvas[1], sight, fitter.settings.soft_error)
    covariance = np.linalg.inv(information) * (ratio * _ALIKE_PX**2)
    places = np.full((*fitter.layout.radius.shape, 2), np.nan)
    place_sds(fitter.layout, pose, covariance, canvas[3], places)
    return Settled(
        pose=pose,
        sd=np.sqrt(np.maximum(np.diag(covariance), 0.0)),
        places_sd=places,
        support=fitter.support(pose, sight),
    )


def expected_between(poses: np.ndarray) -> np.ndarray:
    """Return, for each frame of a path, the middle of the poses before and after.

    At the ends the line through the nearest frames is continued.
    """
    if len(poses) < 3:
        return poses.copy()
    out = poses.copy()
    out[1:-1] = (poses[:-2] + poses[2:]) / 2
    out[0] = 2 * poses[1] - poses[2]
    out[-1] = 2 * poses[-2] - poses[-3]
    return out
