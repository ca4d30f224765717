"""What the candidates of the legs are worth, alone and in pairs; the worthless are dropped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.fit.candidates.candidate_kernels import leg_footprint, shared_cost
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.limb_kernels import chains_apart, chains_cross
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior, prior_cost
from pawnb.core.pose.fit.support import body_zone

_Pairs = dict[tuple[int, int], np.ndarray]


@dataclass(frozen=True, eq=False)
class _Weighed:
    """The candidates of a leg that are kept; see :class:`.LegCandidates`.

    Attributes
    ----------
    footprints : list of tuple of ndarray
        Of each, the pixels that it covers and how dark it paints them.
    """

    legs: FloatArray
    joints: FloatArray
    worth: FloatArray
    unlikely: FloatArray
    footprints: list[tuple[IntArray, FloatArray]]


def weighed(
    fitter: FrameFitter, candidates: LegCandidates, *, image_evidence: ImageEvidence, prior: Prior
) -> LegCandidates:
    """Return a frame in which all candidates are weighed, without the worthless.

    Parameters
    ----------
    fitter : FrameFitter
        Fitter of this frame.
    candidates : LegCandidates
        The frame.
    image_evidence : ImageEvidence
        What it shows.
    prior : Prior
        Anatomy, a part of what a candidate costs.

    Returns
    -------
    LegCandidates
        With what candidates are worth alone and in pairs.
    """
    base = body_zone(fitter, candidates.pose, image_evidence).copy()
    of_legs = [
        _weighed_leg(fitter, candidates, leg, image_evidence, prior, base)
        for leg in range(len(candidates.legs))
    ]
    shared, crossed = _weighed_pairs(fitter, of_legs, image_evidence, base)
    return replace(
        candidates,
        legs=tuple(one.legs for one in of_legs),
        joints=tuple(one.joints for one in of_legs),
        worth=tuple(one.worth for one in of_legs),
        unlikely=tuple(one.unlikely for one in of_legs),
        shared=shared,
        crossed=crossed,
    )


def _weighed_leg(
    fitter: FrameFitter,
    candidates: LegCandidates,
    leg: int,
    image_evidence: ImageEvidence,
    prior: Prior,
    base: FloatArray,
) -> _Weighed:
    """Return a leg's candidates worth keeping; ``base`` is the painted body."""
    value, owner, along, joints = fitter.canvas(image_evidence)
    numbers, trial = fitter.index.numbers[leg], candidates.pose.copy()
    worth, marks, improbable = [], [], []
    for candidate in candidates.legs[leg]:
        trial[numbers] = candidate
        pixels, darks, cost = leg_footprint(
            fitter.layout, trial, leg, image_evidence, fitter.blur, fitter.settings.soft_error,
            CANDIDATES.least_shown, base, value, owner, along, joints[leg],
        )  # fmt: skip
        worth.append(cost)
        improbable.append(prior_cost(trial, prior, numbers))
        marks.append((pixels, darks))
    alone, unlikely = np.array(worth), np.array(improbable)
    seen = np.array([len(pixels) for pixels, _ in marks])
    cost = fitter.settings.evidence_share * alone + unlikely
    distinct = _distinct(candidates.joints[leg], cost, int(fitter.layout.n_segments[leg]))
    share = alone / (seen + CANDIDATES.few_pixels)
    keep = _worth_keeping(share, distinct, fitter.settings.candidates)
    return _Weighed(
        candidates.legs[leg][keep], candidates.joints[leg][keep], alone[keep], unlikely[keep],
        [marks[i] for i in keep],
    )  # fmt: skip


def _weighed_pairs(
    fitter: FrameFitter, legs: Sequence[_Weighed], image_evidence: ImageEvidence, base: FloatArray
) -> tuple[_Pairs, _Pairs]:
    """Return what pairs of candidates explain twice, and which neighbours' cross."""
    shared: _Pairs = {}
    crossed: _Pairs = {}
    side, soft = fitter.layout.side, fitter.settings.soft_error
    for a, one in enumerate(legs):
        for b, other in enumerate(legs[a + 1 :], a + 1):
            if len(one.legs) * len(other.legs) < 2:
                continue
            if side[a] != side[b] and not _may_meet(one.joints, other.joints):
                continue
            if b in fitter.index.neighbours[a]:
                crossed[a, b] = np.array(
                    [[legs_cross(fitter, (a, p), (b, q)) for q in other.joints] for p in one.joints]
                )
            shared[a, b] = np.array(
                [
                    [shared_cost(*p, *q, image_evidence, base, soft) for q in other.footprints]
                    for p in one.footprints
                ]
            )
    return shared, crossed


def _may_meet(one: FloatArray, other: FloatArray) -> bool:
    """Return whether the boxes about the joints of all candidates of two legs overlap."""
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


def side_energy(
    candidates: LegCandidates, legs: Sequence[int], share: float, *, others: Mapping[int, int]
) -> FloatArray:
    """Return the cost of every combination of one side's candidates, one axis a leg.

    That of the picture, times ``share`` (neighbouring pixels do not err independently), and that
    of anatomy. What a leg explains that one of the ``others`` explains already, each the leg of
    the other side and its candidate, is not counted again: a leg that reaches under the body to
    the limb of a leg of the other side gains nothing there.

    Parameters
    ----------
    candidates : LegCandidates
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
    shape = [len(candidates.legs[leg]) for leg in legs]
    out = np.zeros(shape)
    for i, leg in enumerate(legs):
        alone = share * candidates.worth[leg] + candidates.unlikely[leg]
        for other, which in others.items():
            if (leg, other) in candidates.shared:
                alone = alone + share * candidates.shared[leg, other][:, which]
            elif (other, leg) in candidates.shared:
                alone = alone + share * candidates.shared[other, leg][which]
        out += alone.reshape([-1 if k == i else 1 for k in range(len(legs))])
        for j in range(i + 1, len(legs)):
            pair = candidates.shared.get((leg, legs[j]))
            if pair is not None:
                pair = share * pair + CANDIDATES.leg_candidates_crossed * candidates.crossed.get(
                    (leg, legs[j]), 0.0
                )
                out += pair.reshape([shape[k] if k in (i, j) else 1 for k in range(len(legs))])
    return out
