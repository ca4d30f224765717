"""Multiple hypothesis tracking through a gap, compiled: frame after frame, then back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import (
    HypothesisBank,
    ProcessNoise,
    allocate,
    cell,
    copy,
    initialise,
    predict,
    update_with_expectation,
    update_with_position,
)
from pawnb.core.paws.offline.gap_closing.mht_parameters import MHTParameters
from pawnb.core.paws.offline.gap_closing.update_kernels import Cameras, allocate_pairs, associate
from pawnb.core.paws.offline.gap_closing.usual_region import UsualRegion, add_region_cost
from pawnb.core.paws.offline.stride.plausibility_kernels import KinematicPrior, add_kinematic_cost


class GapEvidence(NamedTuple):
    """What the frames of a stretch show; certain frames follow those that show detections.

    Parameters
    ----------
    number : ndarray of int, shape (f, V)
        Detections of each frame and view.
    at : ndarray, shape (f, V, c, 2)
        Where each says the point is, px.
    negative_log_odds : ndarray, shape (2, f, V, c)
        What speaks against each: a poor look, or that another point explains it; and the same
        for a paw that has just lifted off.
    covered : ndarray of bool, shape (f,)
        Whether another paw covers the point in all views that track it, if it stands.
    certain : ndarray, shape (a, d)
        Certain places in the frames that follow.
    lifting : ndarray, shape (f + a,)
        Cost of lifting off before each frame.
    """

    number: np.ndarray
    at: np.ndarray
    negative_log_odds: np.ndarray
    covered: np.ndarray
    certain: np.ndarray
    lifting: np.ndarray


class ExpectedPositions(NamedTuple):
    """Where a point is expected in the frames of a stretch and those that follow.

    Parameters
    ----------
    at, variance : ndarray, shape (k, f + a, d)
        The places, by each of some reasons, NaN where there is none, and their variances
        along the axes.
    axes : ndarray, shape (k, d, d)
        Unit vectors.
    most : ndarray, shape (k,)
        Largest cost of being elsewhere.
    """

    at: np.ndarray
    variance: np.ndarray
    axes: np.ndarray
    most: np.ndarray


class TargetModel(NamedTuple):
    """The model of the target.

    Parameters
    ----------
    cameras : Cameras
        What sees it.
    process_noise, kinematic_prior : ProcessNoise, KinematicPrior
        How it moves.
    parameters : MHTParameters
        The parameters.
    """

    cameras: Cameras
    process_noise: ProcessNoise
    kinematic_prior: KinematicPrior
    parameters: MHTParameters


class History(NamedTuple):
    """What the hypotheses were at the end of each frame.

    Parameters
    ----------
    origin : ndarray of int, shape (f, b)
        Which of the hypotheses of the frame before each was.
    taken : ndarray of int, shape (f, V, b)
        Detections that each took, -1 where none.
    standing : ndarray of bool, shape (f, b)
        Whether it stood.
    """

    origin: np.ndarray
    taken: np.ndarray
    standing: np.ndarray


@compiled
def run_mht(
    state: np.ndarray,
    covariance: np.ndarray,
    place: np.ndarray,
    evidence: GapEvidence,
    expected: ExpectedPositions,
    region: UsualRegion,
    target: TargetModel,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Find what a point did in a gap.

    Parameters
    ----------
    state, covariance : ndarray, shape (3, d) and (3, 3)
        Position, speed and acceleration before the first frame, and their covariance, the same
        along each axis.
    place : ndarray, shape (d,)
        Where it stands, NaN where it does not: it goes on standing until it lifts off.
    evidence : GapEvidence
        What the frames show.
    expected : ExpectedPositions
        Where the point is expected.
    region : UsualRegion
        Where it may be at all.
    target : TargetModel
        The model of the target.

    Returns
    -------
    taken : ndarray of int, shape (f, V)
        The detections that the likeliest hypothesis took, -1 where none.
    stood : ndarray of bool, shape (f,)
        Whether the point stands in it.
    cost : float
        Minus the logarithm of how likely that is.
    """
    parameters, (frames, views) = target.parameters, evidence.number.shape
    every = frames + len(evidence.certain)
    room = max(2 * parameters.most, parameters.most_within)
    now, then = allocate(room, len(place), views), allocate(room, len(place), views)
    pairs = allocate_pairs(room * evidence.at.shape[2])
    history = History(
        np.empty((every, parameters.most), np.int64),
        np.empty((every, views, parameters.most), np.int64),
        np.empty((every, parameters.most), np.bool_),
    )
    n = initialise(now, state, covariance, place, target.process_noise)
    for t in range(every):
        n = predict(
            now, n, then, target.process_noise, parameters.impulse_cost, evidence.lifting[t]
        )
        now, then = then, now
        if t >= frames:
            update_with_position(now, n, evidence.certain[t - frames], parameters.noise**2)
        else:
            for v in range(views):
                c = evidence.number[t, v]
                now, then, n = associate(
                    now,
                    n,
                    then,
                    v,
                    target.cameras,
                    evidence.at[t, v, :c],
                    evidence.negative_log_odds[:, t, v, :c],
                    parameters,
                    pairs,
                )
        for k in range(len(expected.at)):
            at, variance = expected.at[k, t], expected.variance[k, t]
            if not np.isnan(at[0]):
                update_with_expectation(now, n, at, expected.axes[k], variance, expected.most[k])
        add_motion_cost(now, n, state[0], target, t >= frames, t < frames and evidence.covered[t])
        add_region_cost(now.mean[: len(place), :n], region, t, now.cost[:n])
        n = prune_and_merge(now, n, then, parameters)
        now, then = then, now
        for b in range(n):
            history.origin[t, b], history.standing[t, b] = now.origin[b], now.standing[b]
            for v in range(views):
                history.taken[t, v, b] = now.taken[v, b]
    taken, stood = _read(history, frames)
    return taken, stood, now.cost[0]


@compiled
def add_motion_cost(
    hypotheses: HypothesisBank,
    n: int,
    home: np.ndarray,
    target: TargetModel,
    certain: bool,
    covered: bool,
) -> None:
    """Let hypotheses pay for what is unlikely of them in a frame, and note which are occluded.

    Parameters
    ----------
    hypotheses : HypothesisBank
        The hypotheses, and
    n : int
        how many there are.
    home : ndarray, shape (d,)
        Where the point was when they began.
    target : TargetModel
        The parameters.
    certain : bool
        Whether the frame had a certain place, so that nothing is occluded.
    covered : bool
        Whether another paw covers the point in all views that track it, if it stands.
    """
    d, parameters = len(home), target.parameters
    recent = np.empty(n, np.bool_)
    for b in range(n):
        square = 0.0
        for i in range(d):
            square += (hypotheses.mean[i, b] - home[i]) ** 2
        if square > parameters.reach * parameters.reach:
            hypotheses.cost[b] += parameters.out_of_reach_cost
        recent[b] = 0 < hypotheses.since[b] <= parameters.swinging
        if certain:
            hypotheses.occluded[b] = False
        else:
            hypotheses.cost[b] += _occlusion_cost(
                hypotheses, b, target.cameras.tracked_in_view, parameters, covered
            )
    add_kinematic_cost(
        hypotheses.mean[:d, :n],
        hypotheses.mean[d : 2 * d, :n],
        recent,
        target.kinematic_prior,
        hypotheses.cost[:n],
    )


@compiled
def _occlusion_cost(
    hypotheses: HypothesisBank,
    b: int,
    tracked_in_view: np.ndarray,
    parameters: MHTParameters,
    covered: bool,
) -> float:
    """Return what being seen or occluded costs a hypothesis, and note whether it is occluded."""
    views, was = 0, hypotheses.occluded[b]
    for v in range(len(tracked_in_view)):
        views += tracked_in_view[v] and hypotheses.taken[v, b] >= 0
    hypotheses.occluded[b] = views == 0
    if views > 0:
        return parameters.reappearance_cost if was else 0.0
    if covered and hypotheses.standing[b]:
        return parameters.covered
    return parameters.occlusion_frame_cost if was else parameters.occlusion_onset_cost


@compiled
def prune_and_merge(
    now: HypothesisBank, n: int, then: HypothesisBank, parameters: MHTParameters
) -> int:
    """End the frame: prune unlikely hypotheses and merge those that are the same.

    Parameters
    ----------
    now, then : HypothesisBank
        The hypotheses, and where those go that are left, the likeliest first.
    n : int
        How many there are.
    parameters : MHTParameters
        The parameters.

    Returns
    -------
    int
        How many are left.
    """
    size = len(now.mean) // 3 * 2
    grain = np.empty((size, n))
    for i in range(size):
        for b in range(n):
            # rounding may take a variance below nothing
            spread = np.sqrt(max(now.covariance[cell(i, i), b], 0.0))
            grain[i, b] = 0.5 * parameters.noise + parameters.alike * spread
    kept, left = np.empty(parameters.most, np.int64), np.empty(n)
    count, limit = 0, np.inf
    for b in range(n):
        left[b] = now.cost[b]
        limit = min(limit, left[b] + parameters.pruning_cost)
    while count < parameters.most:
        best = 0
        for b in range(n):
            if left[b] < left[best]:
                best = b
        if left[best] >= limit:
            break
        kept[count] = best
        count += 1
        for b in range(n):
            if left[b] < limit and _is_same(now, b, best, grain):
                left[b] = np.inf
    copy(now, kept[:count], then)
    return count


@compiled
def _is_same(hypotheses: HypothesisBank, a: int, b: int, grain: np.ndarray) -> bool:
    """Tell whether two hypotheses are the same, given differences (2 d, b) that are none."""
    if hypotheses.standing[a] != hypotheses.standing[b]:
        return False
    for i in range(len(grain)):
        apart = abs(hypotheses.mean[i, a] - hypotheses.mean[i, b])
        if apart > min(grain[i, a], grain[i, b]):
            return False
    return True


@compiled
def _read(history: History, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what the likeliest hypothesis took in the first frames, and whether it stood.

    It is read backwards; the likeliest is the first of the last frame.
    """
    every, views, _ = history.taken.shape
    taken, stood = np.empty((frames, views), np.int64), np.empty(frames, np.bool_)
    at = 0
    for t in range(every - 1, -1, -1):
        if t < frames:
            stood[t] = history.standing[t, at]
            for v in range(views):
                taken[t, v] = history.taken[t, v, at]
        at = history.origin[t, at]
    return taken, stood
