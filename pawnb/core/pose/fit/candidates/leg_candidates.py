"""The poses that each leg might have in a frame, and what they are worth together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.fit.candidates.candidate_kernels import (
    free_of_others,
    leg_footprint,
    shared_cost,
)
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.limb_kernels import (
    LimbSearch,
    chains_apart,
    chains_cross,
    find_limbs,
)
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.rendering.blur import part_of
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import (
    ImageEvidence,
    Prior,
    paint_some,
    prior_cost,
)
from pawnb.core.pose.fit.rendering.paint_kernels import leg_chain
from pawnb.core.pose.fit.support import body_zone


def limb_candidates(
    fitter: FrameFitter, pose: FloatArray, leg: int, *, image_evidence: ImageEvidence, prior: Prior
) -> list[np.ndarray]:
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
    rounds: int = 4,
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
    rounds : int
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
    fitted, _ = fitter.fit(trial, part, prior, active=numbers, shown=shown, rounds=rounds)
    return fitted[numbers]


def part_about(
    fitter: FrameFitter,
    image_evidence: ImageEvidence,
    pose: FloatArray,
    *,
    leg: int,
    guesses: Sequence[np.ndarray],
) -> ImageEvidence:
    """Return the part of a sight about some places of a leg, each its part of the pose vector.

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


def part_near(image_evidence: ImageEvidence, legs: Sequence[np.ndarray]) -> ImageEvidence:
    """Return the part of a sight about legs that are fitted alone; joints (n, 2), NaN beyond."""
    joints = np.concatenate(legs)
    low, high = np.nanmin(joints, axis=0), np.nanmax(joints, axis=0)
    return part_of(image_evidence, low - CANDIDATES.room_px, high + CANDIDATES.room_px)


def add_candidates(
    fitter: FrameFitter,
    choices: LegCandidates,
    extra: dict[int, list[np.ndarray]],
    *,
    image_evidence: ImageEvidence,
    prior: Prior,
) -> None:
    """Add poses of legs, and weigh all of them.

    A pose nearly where another is that was added before may still be much the better one: what a
    frame alone offers often has its joints at odd places along the limb, and what is found from the
    frames after it has not.

    Parameters
    ----------
    fitter : FrameFitter
        Fitter of this frame.
    choices : LegCandidates
        Changed in place; candidates that explain little are dropped, and so is, of one added
        before and one added now on the same limb, the one that costs more.
    extra : dict
        Of some legs, further parts of the pose vector; of those on the same limb only the first
        counts.
    image_evidence : ImageEvidence
        The frame.
    prior : Prior
        Anatomy, a part of what a candidate costs.
    """
    for leg, more in extra.items():
        n, before = fitter.layout.n_segments[leg], len(choices.joints[leg])
        for numbers in more:
            joints = _joints(fitter, choices.pose, leg, numbers)
            others = (choices.joints[leg][0], *choices.joints[leg][before:])
            if all(chains_apart(joints, known, n) > CANDIDATES.same_px for known in others):
                choices.legs[leg] = np.concatenate([choices.legs[leg], numbers[None]])
                choices.joints[leg] = np.concatenate([choices.joints[leg], joints[None]])
    if choices.is_open:
        _weigh(fitter, choices, image_evidence, prior)


def _weigh(
    fitter: FrameFitter, choices: LegCandidates, image_evidence: ImageEvidence, prior: Prior
) -> None:
    """Fill in what candidates are worth alone and in pairs, and drop the worthless."""
    value, owner, along, joints = fitter.canvas(image_evidence)
    base = body_zone(fitter, choices.pose, image_evidence).copy()
    soft = fitter.settings.soft_error
    prints: list[list[tuple[np.ndarray, np.ndarray]]] = []
    for leg, numbers in enumerate(fitter.index.numbers):
        trial, worth, marks, unlikely = choices.pose.copy(), [], [], []
        for candidate in choices.legs[leg]:
            trial[numbers] = candidate
            pixels, darks, cost = leg_footprint(
                fitter.layout,
                trial,
                leg,
                image_evidence,
                fitter.blur,
                soft,
                CANDIDATES.least_shown,
                base,
                value,
                owner,
                along,
                joints[leg],
            )
            worth.append(cost)
            unlikely.append(prior_cost(trial, prior, numbers))
            marks.append((pixels, darks))
        alone = np.array(worth)
        seen = np.array([len(pixels) for pixels, _ in marks])
        cost = fitter.settings.evidence_share * alone + np.array(unlikely)
        distinct = _distinct(choices.joints[leg], cost, int(fitter.layout.n_segments[leg]))
        keep = _worth_keeping(
            alone / (seen + CANDIDATES.few_pixels), distinct, fitter.settings.candidates
        )
        choices.worth[leg] = alone[keep]
        choices.unlikely[leg] = np.array(unlikely)[keep]
        choices.legs[leg] = choices.legs[leg][keep]
        choices.joints[leg] = choices.joints[leg][keep]
        prints.append([marks[i] for i in keep])
    choices.shared, choices.crossed = {}, {}
    side = fitter.layout.side
    for a in range(len(prints)):
        for b in range(a + 1, len(prints)):
            if len(prints[a]) * len(prints[b]) < 2:
                continue
            if side[a] != side[b] and not _may_meet(choices.joints[a], choices.joints[b]):
                continue
            if b in fitter.index.neighbours[a]:
                choices.crossed[a, b] = np.array(
                    [
                        [legs_cross(fitter, (a, p), (b, q)) for q in choices.joints[b]]
                        for p in choices.joints[a]
                    ]
                )
            choices.shared[a, b] = np.array(
                [
                    [shared_cost(*p, *q, image_evidence, base, soft) for q in prints[b]]
                    for p in prints[a]
                ]
            )


def _may_meet(one: FloatArray, other: FloatArray) -> bool:
    """Return whether the boxes about all candidates of two legs, joints as in Choices, overlap."""
    low = np.fmax(np.nanmin(one, axis=(0, 1)), np.nanmin(other, axis=(0, 1)))
    high = np.fmin(np.nanmax(one, axis=(0, 1)), np.nanmax(other, axis=(0, 1)))
    return bool(np.all(high - low > -CANDIDATES.beside_px))


def legs_cross(
    fitter: FrameFitter, one: tuple[int, FloatArray], other: tuple[int, FloatArray]
) -> bool:
    """Return whether two legs, each given by its number and its joints, cross.

    Parameters
    ----------
    fitter : FrameFitter
        What poses are fitted with.
    one, other : tuple of (int, ndarray)
        Number of a leg and its joints, shape (joints, 2).

    Returns
    -------
    bool
        True if they cross.
    """
    n = fitter.layout.n_segments
    return bool(chains_cross(one[1], n[one[0]], other[1], n[other[0]]))


def _distinct(joints: FloatArray, cost: FloatArray, n: int) -> list[int]:
    """Return the first candidate of a leg and the cheapest of those on each other limb."""
    kept = [0]
    for i in np.argsort(cost[1:], kind="stable") + 1:
        if all(chains_apart(joints[i], joints[k], n) > CANDIDATES.same_px for k in kept):
            kept.append(int(i))
    return kept


def _worth_keeping(alone: FloatArray, distinct: list[int], most: int) -> IntArray:
    """Return the candidates to keep: always the first, the other distinct ones by worth."""
    others = sorted(distinct[1:], key=lambda i: float(alone[i]))
    good = [i for i in others if alone[i] < CANDIDATES.leg_candidates_worthless * alone.min()]
    return np.array([0, *good[: most - 1]])


def _joints(fitter: FrameFitter, pose: FloatArray, leg: int, numbers: FloatArray) -> FloatArray:
    """Return where one leg's part of the pose vector puts its joints."""
    trial = pose.copy()
    trial[fitter.index.numbers[leg]] = numbers
    joints = np.full((fitter.layout.radius.shape[1], 2), np.nan)
    leg_chain(fitter.layout, trial, leg, joints)
    return joints


def sides_of(side: FloatArray) -> list[list[int]]:
    """Return the legs of each side."""
    return [[i for i, s in enumerate(side) if s == which] for which in np.unique(side)]


def side_energy(
    choices: LegCandidates, legs: Sequence[int], share: float, *, others: Mapping[int, int]
) -> FloatArray:
    """Return the cost of every combination of one side's candidates, one axis a leg.

    That of the picture, times ``share`` (neighbouring pixels do not err independently), and that
    of anatomy. What a leg explains that one of the ``others`` explains already, each the leg of
    the other side and its candidate, is not counted again: a leg that reaches under the body to
    the limb of a leg of the other side gains nothing there.

    Parameters
    ----------
    choices : LegCandidates
        The frame.
    legs : sequence of int
        Legs of the side.
    share : float
        Weight of what the picture says.
    others : mapping of int to int
        Leg of the other side to its chosen candidate.

    Returns
    -------
    ndarray
        Cost, one axis a leg.
    """
    shape = [len(choices.legs[leg]) for leg in legs]
    out = np.zeros(shape)
    for i, leg in enumerate(legs):
        alone = share * choices.worth[leg] + choices.unlikely[leg]
        for other, which in others.items():
            if (leg, other) in choices.shared:
                alone = alone + share * choices.shared[leg, other][:, which]
            elif (other, leg) in choices.shared:
                alone = alone + share * choices.shared[other, leg][which]
        out += alone.reshape([-1 if k == i else 1 for k in range(len(legs))])
        for j in range(i + 1, len(legs)):
            pair = choices.shared.get((leg, legs[j]))
            if pair is not None:
                pair = share * pair + CANDIDATES.leg_candidates_crossed * choices.crossed.get(
                    (leg, legs[j]), 0.0
                )
                out += pair.reshape([shape[k] if k in (i, j) else 1 for k in range(len(legs))])
    return out
