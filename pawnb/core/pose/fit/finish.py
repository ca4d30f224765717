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
_MET_PX = 5.0
"""Tips of two legs nearer than this have met, working px."""
_MET_FRAMES = 8
"""Legs that have met for longer are not held."""
_HELD_ANGLE_SD_DEG, _HELD_LENGTH_SD = 1.0, 0.01
_ALIKE_PX = 4.5
"""Errors of pixels nearer than this go together: so many pixels count as one in each direction."""
_MODEL_SD_PX = 0.5
"""What the painted shape errs by itself, alike in all frames (hairs, shadow, bends), working px;
set, as the line above, on rendered spiders."""


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
    fitter: FrameFitter,
    choices: Choices,
    pose: np.ndarray,
    *,
    expected: np.ndarray,
    held: np.ndarray,
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
    held : ndarray of bool, shape (legs,)
        Legs that the picture does not show apart, see :func:`hold_met`: they stay close to
        ``expected``.

    Returns
    -------
    Settled
        The pose and its uncertainty.
    """
    sight = fitter.sight(choices.image.astype(float), choices.box, pose)
    sd = np.full(fitter.n, np.inf)
    sd[fitter.angles] = np.radians(_ANGLE_SD_DEG)
    sd[fitter.lengths] = _LENGTH_SD
    for leg in np.flatnonzero(held):
        angles, lengths = np.split(fitter.numbers[leg], 2)
        sd[angles], sd[lengths] = np.radians(_HELD_ANGLE_SD_DEG), _HELD_LENGTH_SD
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
        places_sd=np.hypot(places, _MODEL_SD_PX),
        support=fitter.support(pose, sight),
    )


def hold_met(fitter: FrameFitter, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return poses in which legs whose tips meet for a few frames go straight on, and where.

    A leg that lies along a longer one is easily taken to be as long: nothing shows its tip. Its
    angles and lengths are those between the frames before and after.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    poses : ndarray, shape (n, n_parameters)
        The path.

    Returns
    -------
    poses : ndarray, shape (n, n_parameters)
        The path, such legs replaced.
    held : ndarray of bool, shape (n, legs)
        Where.
    """
    n_legs = len(fitter.numbers)
    n_segments = fitter.layout.n_segments
    tips = np.array([fitter.joints(pose)[np.arange(n_legs), n_segments] for pose in poses])
    apart = np.hypot(*np.moveaxis(tips[:, :, None] - tips[:, None], -1, 0))
    apart[:, np.arange(n_legs), np.arange(n_legs)] = np.inf
    met = apart.min(axis=2) < _MET_PX
    out, held = poses.copy(), np.zeros_like(met)
    for leg, numbers in enumerate(fitter.numbers):
        edges = np.diff(np.concatenate([[0], met[:, leg].astype(int), [0]]))
        for first, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
            before, after = first - 1, end
            if before < 0 or after >= len(poses) or end - first > _MET_FRAMES:
                continue
            share = (np.arange(first, end) - before)[:, None] / (after - before)
            ends = poses[before, numbers], poses[after, numbers]
            out[first:end, numbers] = (1 - share) * ends[0] + share * ends[1]
            held[first:end, leg] = True
    return out, held


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
