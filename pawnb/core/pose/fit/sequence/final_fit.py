"""The last fit of every frame, with all other frames in mind, and how sure it is.

A leg that lies along another is not seen to end, and can be fitted anywhere on it. Its picture
then says little, and the frames before and after say where it is: the legs of this animal move
evenly, by as much as was learnt from the whole recording. No direction is preferred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.crossed_legs import uncrossed
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.learning.relearn import usual_lengths
from pawnb.core.pose.fit.observation import evidence_of
from pawnb.core.pose.fit.rendering.excluded_parts import counted
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior
from pawnb.core.pose.fit.rendering.uncertainty_kernels import error_ratio, place_sds
from pawnb.core.pose.fit.sequence.leg_motion import first_motion, learn_motion, motion_messages
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.support import leg_supports


@dataclass(frozen=True)
class FinalFit:
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

    pose: FloatArray
    sd: FloatArray
    places_sd: FloatArray
    support: FloatArray


@dataclass(frozen=True)
class _Own:
    """What a frame's own picture says near a pose.

    Attributes
    ----------
    pose : ndarray, shape (n_parameters,)
        The pose.
    precision : ndarray, shape (n_parameters, n_parameters)
        Of picture and anatomy.
    slope : ndarray, shape (n_parameters,)
        How their cost changes with the pose.
    many : float
        So many times are precision and slope less than those of the fit's cost, in which pixels
        err independently.
    image_evidence : ImageEvidence
        What the frame shows, in half precision: that of all frames is kept until the end.
    """

    pose: FloatArray
    precision: FloatArray
    slope: FloatArray
    many: float
    image_evidence: ImageEvidence


@dataclass(frozen=True)
class _Others:
    """What the other frames say of each frame.

    Attributes
    ----------
    around : ndarray, shape (n, n_parameters)
        Its legs' numbers; 0 for the body.
    pulls : list of ndarray, shape (n, d, d)
        Of each leg, how surely: a precision of its d numbers.
    gain : ndarray, shape (n,)
        How much the cost of a leg would fall at most by heeding it.
    """

    around: FloatArray
    pulls: list[FloatArray]
    gain: FloatArray

    def pull(self, fitter: FrameFitter, t: int) -> FloatArray:
        """Return how surely they say it of frame t, a precision of the whole pose."""
        out = np.zeros((fitter.index.n, fitter.index.n))
        for numbers, pull in zip(fitter.index.numbers, self.pulls, strict=True):
            out[np.ix_(numbers, numbers)] = pull[t]
        return out


def fit_all_frames(
    fitter: FrameFitter, found: Sequence[LegCandidates], poses: FloatArray
) -> list[FinalFit]:
    """Fit every frame of a path for good.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    found : sequence of LegCandidates
        The frames, ascending.
    poses : ndarray, shape (n, n_parameters)
        The path.

    Returns
    -------
    list of FinalFit
        One a frame.
    """
    if not found:
        return []
    anatomy = usual_lengths(fitter, poses)
    frames = np.array([one.frame for one in found])
    stretches = np.split(np.arange(len(frames)), np.flatnonzero(np.diff(frames) > 1) + 1)
    alone = partial(_fit_alone, fitter, anatomy=anatomy)
    own = on_threads(lambda t: alone(found[t], poses[t]), range(len(found)))
    motions = [first_motion(len(numbers) // 2) for numbers in fitter.index.numbers]
    motions = _learnt(fitter, own, motions, stretches)
    for _ in range(SEQUENCE.final_fit_sweeps):
        others = _from_others(fitter, own, motions, stretches)
        again = np.flatnonzero(others.gain > SEQUENCE.final_fit_gain).tolist()
        if not again:
            break
        work = partial(_fit_again, fitter, own=own, others=others, anatomy=anatomy)
        fitted = dict(zip(again, on_threads(work, again), strict=True))
        own = [fitted.get(t, one) for t, one in enumerate(own)]
        motions = _learnt(fitter, own, motions, stretches)
    others = _from_others(fitter, own, motions, stretches)
    return on_threads(lambda t: _final_fit(fitter, own[t], others.pull(fitter, t)), range(len(own)))


def _fit_alone(
    fitter: FrameFitter, one: LegCandidates, pose: FloatArray, *, anatomy: Prior
) -> _Own:
    """Return a frame's own fit; the animal's appearance is new to it."""
    image_evidence = counted(fitter, pose, evidence_of(fitter, pose, image=one.grey, box=one.box))
    pose, _ = fitter.fit(
        pose, image_evidence, anatomy, rounds=SEQUENCE.final_fit_first_rounds,
        enough=SEQUENCE.final_fit_enough,
    )  # fmt: skip
    pose = uncrossed(fitter, pose, image_evidence, prior=anatomy)
    return _own_near(fitter, pose, image_evidence, anatomy)


def _from_others(
    fitter: FrameFitter, own: Sequence[_Own], motions: list[np.ndarray], stretches: list[np.ndarray]
) -> _Others:
    """Return what the other frames of its stretch say of each frame; the legs are independent."""

    def of_leg(leg: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        numbers = fitter.index.numbers[leg]
        poses = np.array([one.pose[numbers] for one in own])
        precision = np.array([one.precision[np.ix_(numbers, numbers)] for one in own])
        slope = np.array([one.slope[numbers] for one in own])
        vector = np.einsum("tij,tj->ti", precision, poses) - slope
        around, pull = np.empty_like(poses), np.empty_like(precision)
        for rows in stretches:
            around[rows], pull[rows] = motion_messages(precision[rows], vector[rows], motions[leg])
        down = slope + np.einsum("tij,tj->ti", pull, poses - around)
        step = np.linalg.solve(precision + pull, down[..., None])[..., 0]
        return around, pull, 0.5 * (down * step).sum(axis=1)

    arounds, pulls, gains = zip(*on_threads(of_leg, range(len(motions))), strict=True)
    around = np.zeros((len(own), fitter.index.n))
    for numbers, place in zip(fitter.index.numbers, arounds, strict=True):
        around[:, numbers] = place
    return _Others(around, list(pulls), np.max(gains, axis=0))


def _learnt(
    fitter: FrameFitter, own: Sequence[_Own], motions: list[np.ndarray], stretches: list[np.ndarray]
) -> list[np.ndarray]:
    """Return how each leg moves, that of the other side alike."""
    poses, partner = np.array([one.pose for one in own]), fitter.index.partner
    out = []
    for leg, motion in enumerate(motions):
        alike = {leg, int(partner[leg])}
        parts = [poses[np.ix_(rows, fitter.index.numbers[i])] for rows in stretches for i in alike]
        out.append(learn_motion(parts, motion))
    return out


def _own_near(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, anatomy: Prior
) -> _Own:
    """Return what a frame's picture says near a pose."""
    precision, slope = fitter.equations(pose, image_evidence, anatomy)
    value, owner, _, _ = fitter.canvas(image_evidence)  # the pose is still on it
    many = (
        error_ratio(value, owner, image_evidence, fitter.settings.soft_error) * SEQUENCE.alike_px**2
    )
    half = ImageEvidence(
        image_evidence.seen.astype(np.float16),
        image_evidence.weight.astype(np.float16),
        image_evidence.box,
    )
    return _Own(pose, precision / many, slope / many, many, half)


def _whole(image_evidence: ImageEvidence) -> ImageEvidence:
    """Return evidence in full precision."""
    return ImageEvidence(
        image_evidence.seen.astype(float), image_evidence.weight.astype(float), image_evidence.box
    )


def _fit_again(
    fitter: FrameFitter,
    t: int,
    *,
    own: Sequence[_Own],
    others: _Others,
    anatomy: Prior,
) -> _Own:
    """Return frame t's own fit after one with the others in mind."""
    pose, pull = own[t].pose, own[t].many * others.pull(fitter, t)
    prior = anatomy._replace(around=others.around[t], pull=pull)
    image_evidence = _whole(own[t].image_evidence)
    pose, _ = fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.final_fit_rounds)
    return _own_near(fitter, pose, image_evidence, anatomy)


def _final_fit(fitter: FrameFitter, own: _Own, pull: FloatArray) -> FinalFit:
    """Return a frame's last fit with its uncertainty, by its picture and all others."""
    covariance = np.linalg.inv(own.precision + pull)
    places = np.full((*fitter.layout.radius.shape, 2), np.nan)
    place_sds(fitter.layout, own.pose, covariance, np.zeros_like(places), places)
    return FinalFit(
        pose=own.pose,
        sd=np.sqrt(np.maximum(np.diag(covariance), 0.0)),
        places_sd=np.hypot(places, SEQUENCE.model_sd * fitter.blur),
        support=leg_supports(fitter, own.pose, _whole(own.image_evidence)),
    )
