"""The poses that each leg might have in a frame, and what they are worth together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.candidate_kernels import (
    free_of_others,
)
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.limb_kernels import (
    LimbSearch,
    chains_apart,
    find_limbs,
)
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.weighing import weighed
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.rendering.blur import part_of
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import (
    ImageEvidence,
    Prior,
    paint_some,
)
from pawnb.core.pose.fit.rendering.paint_kernels import leg_chain
from pawnb.core.pose.fit.support import body_zone


def limb_candidates(
    fitter: FrameFitter, pose: FloatArray, leg: int, *, image_evidence: ImageEvidence, prior: Prior
) -> list[FloatArray]:
    """Return poses of a leg that the silhouette offers, each fitted.

    Limbs are looked for among what no other leg explains, and then where a neighbour now lies,
    among what no other leg, the leg itself included, explains. Under what is explained a leg
    finds neither support nor hindrance. Poses that the leg is known to have are tried, too.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    pose : ndarray
        The pose vector.
    leg : int
        Number of the leg.
    image_evidence : ImageEvidence
        What the frame shows.
    prior : Prior
        What is expected of the pose.

    Returns
    -------
    list of ndarray
        Each the leg's part of a pose vector.
    """
    neutral = CANDIDATES.leg_candidates_neutral * float(np.median(fitter.layout.dark[leg]))
    found: list[np.ndarray] = []
    canvas = fitter.canvas(image_evidence)
    near_body = body_zone(fitter, pose, image_evidence) > 0.0
    open_to = np.empty_like(image_evidence.seen)
    for absent in (leg, *fitter.index.neighbours[leg]):
        shown = fitter.index.all_shown.copy()
        shown[absent] = False
        paint_some(fitter.layout, pose, fitter.blur, image_evidence.box, shown, *canvas)
        free_of_others(image_evidence, near_body, canvas[1], neutral, open_to)
        most = 2 if absent == leg else 1
        numbers, _ = find_limbs(
            fitter.layout,
            pose,
            leg,
            open_to,
            image_evidence.box,
            prior,
            limb_search(),
            most,
            2 * CANDIDATES.same_px,
        )
        found.extend(numbers)
    found.extend(fitter.usual_poses[leg])
    return [
        fit_leg(fitter, pose, leg, guess=guess, image_evidence=image_evidence, prior=prior)
        for guess in found
    ]


def limb_search() -> LimbSearch:
    """Return how limbs are searched for, by the parameters that are in force."""
    return LimbSearch(
        CANDIDATES.leg_candidates_beam,
        np.arange(CANDIDATES.limb_turns) / (CANDIDATES.limb_turns - 1),
        np.array(CANDIDATES.limb_shorter),
        -CANDIDATES.limb_shorter_cost,
        CANDIDATES.limb_hidden,
        CANDIDATES.limb_step_px,
        CANDIDATES.limb_least_dark,
        CANDIDATES.limb_direction_rad,
    )


def fit_leg(
    fitter: FrameFitter,
    pose: FloatArray,
    leg: int,
    *,
    guess: FloatArray,
    image_evidence: ImageEvidence,
    prior: Prior,
    rounds: int | None = None,
) -> FloatArray:
    """Return one leg's part of the pose vector, fitted with the body as it is.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    pose : ndarray
        The pose vector, whose body stays as it is.
    leg : int
        Number of the leg.
    guess : ndarray
        The leg's part of the pose vector to begin with.
    image_evidence : ImageEvidence
        What the frame shows.
    prior : Prior
        What is expected of the pose.
    rounds : int, optional
        Steps at most.

    Returns
    -------
    ndarray
        The leg's part of the pose vector.
    """
    trial, numbers = pose.copy(), fitter.index.numbers[leg]
    trial[numbers] = guess
    part = part_about(fitter, image_evidence, pose, leg=leg, guesses=[guess])
    shown = fitter.index.only[leg]
    steps = CANDIDATES.rounds_leg if rounds is None else rounds
    fitted, _ = fitter.fit(trial, part, prior, active=numbers, shown=shown, rounds=steps)
    return fitted[numbers]


def part_about(
    fitter: FrameFitter,
    image_evidence: ImageEvidence,
    pose: FloatArray,
    *,
    leg: int,
    guesses: Sequence[FloatArray],
) -> ImageEvidence:
    """Return the part of the evidence about some places of a leg, each its part of the pose vector.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    image_evidence : ImageEvidence
        What the frame shows.
    pose : ndarray
        The pose vector.
    leg : int
        Number of the leg.
    guesses : sequence of ndarray
        Places of the leg.

    Returns
    -------
    ImageEvidence
        The part that holds all of them.
    """
    return part_near(image_evidence, [_joints(fitter, pose, leg, guess) for guess in guesses])


def part_near(image_evidence: ImageEvidence, legs: Sequence[FloatArray]) -> ImageEvidence:
    """Return the part of the evidence about legs fitted alone; joints (n, 2), NaN beyond."""
    joints = np.concatenate(legs)
    low, high = np.nanmin(joints, axis=0), np.nanmax(joints, axis=0)
    return part_of(image_evidence, low - CANDIDATES.room_px, high + CANDIDATES.room_px)


def with_candidates(
    fitter: FrameFitter,
    candidates: LegCandidates,
    extra: dict[int, list[FloatArray]],
    *,
    image_evidence: ImageEvidence,
    prior: Prior,
) -> LegCandidates:
    """Return a frame with further poses of legs, all of them weighed.

    A pose nearly where another is that was added before may still be much the better one: what a
    frame alone offers often has its joints at odd places along the limb, and what is found from the
    frames after it has not.

    Parameters
    ----------
    fitter : FrameFitter
        Fitter of this frame.
    candidates : LegCandidates
        The frame as known so far.
    extra : dict
        Of some legs, further parts of the pose vector; of those on the same limb only the first
        counts.
    image_evidence : ImageEvidence
        The frame.
    prior : Prior
        Anatomy, a part of what a candidate costs.

    Returns
    -------
    LegCandidates
        Without candidates that explain little, and, of one added before and one added now on the
        same limb, without the one that costs more.
    """
    legs, joints = list(candidates.legs), list(candidates.joints)
    for leg, more in extra.items():
        n, before = fitter.layout.n_segments[leg], len(joints[leg])
        for numbers in more:
            places = _joints(fitter, candidates.pose, leg, numbers)
            others = (joints[leg][0], *joints[leg][before:])
            if all(chains_apart(places, known, n) > CANDIDATES.same_px for known in others):
                legs[leg] = np.concatenate([legs[leg], numbers[None]])
                joints[leg] = np.concatenate([joints[leg], places[None]])
    candidates = replace(candidates, legs=tuple(legs), joints=tuple(joints))
    if not candidates.is_open:
        return candidates
    return weighed(fitter, candidates, image_evidence=image_evidence, prior=prior)


def _joints(fitter: FrameFitter, pose: FloatArray, leg: int, numbers: FloatArray) -> FloatArray:
    """Return where one leg's part of the pose vector puts its joints."""
    trial = pose.copy()
    trial[fitter.index.numbers[leg]] = numbers
    joints = np.full((fitter.layout.radius.shape[1], 2), np.nan)
    leg_chain(fitter.layout, trial, leg, joints)
    return joints
