"""Fitting a pose to a picture by damped Gauss-Newton steps: compiled loops.

The cost is that of the painted picture (:mod:`.paint_kernels`) and of the prior: a parabola about
a middle for every number of the pose, and steeper ones beyond its limits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled_loosely
from pawnb.core.pose.fit.layout import N_BODY, PoseLayout
from pawnb.core.pose.fit.rendering.normal_equation_kernels import normal_equations
from pawnb.core.pose.fit.rendering.paint_kernels import (
    clear,
    leg_chain,
    paint_body,
    paint_leg,
    picture_cost,
)

_FIT_DAMPING, _FIT_EASIER, _FIT_HARDER, _FIT_LEAST, _TRIES = 1e-3, 0.2, 8.0, 1e-6, 6
"""Numerics: the schedule of damping of a Levenberg-Marquardt descent (Marquardt 1963): first,
after a step that helps, after one that does not, at least, and steps that are tried. It tells how
steps are found, not where the bottom is."""


class Prior(NamedTuple):
    """What is known of a pose before its picture is seen; all arrays (n_parameters,).

    Attributes
    ----------
    middle, precision : ndarray
        Where each number is expected, and one over its variance.
    low, high, wall : ndarray
        Limits, and the precision of going beyond them.
    group : ndarray of int
        Numbers that are likely to stray together from their middles, as the lengths of one leg's
        links do where it is raised, share a group from 0 up; others have -1.
    together : ndarray, shape (1,)
        How little it costs when a whole group strays alike: 0, all of it; 1, nothing.
    around, pull : ndarray, shape (n_parameters,) and (n_parameters, n_parameters)
        Where the frames before and after have the pose, and the precision of that; shape (0, 0)
        where they say nothing.
    """

    middle: np.ndarray
    precision: np.ndarray
    low: np.ndarray
    high: np.ndarray
    wall: np.ndarray
    group: np.ndarray
    together: np.ndarray
    around: np.ndarray
    pull: np.ndarray


class ImageEvidence(NamedTuple):
    """A crop of a frame as the fit sees it.

    Attributes
    ----------
    seen : ndarray, shape (H, W)
        Darkness relative to the background: 0 there, 1 where nothing is left of its light.
    weight : ndarray, shape (H, W)
        One over the variance of ``seen``.
    box : ndarray, shape (2,)
        Left and top of the crop, working pixels.
    """

    seen: np.ndarray
    weight: np.ndarray
    box: np.ndarray


@compiled_loosely
def group_sums(pose: np.ndarray, prior: Prior, active: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the precision of each group, and its errors weighted with their precision."""
    most = 0
    for g in prior.group:
        most = max(most, g + 1)
    weights, errors = np.zeros(most + 1), np.zeros(most + 1)
    for i in active:
        g = prior.group[i]
        if g >= 0:
            weights[g] += prior.precision[i]
            errors[g] += prior.precision[i] * (pose[i] - prior.middle[i])
    return weights, errors


@compiled_loosely
def prior_cost(pose: np.ndarray, prior: Prior, active: np.ndarray) -> float:
    """Return the cost of the prior for the numbers listed in ``active``."""
    total = 0.0
    for i in active:
        away = pose[i] - prior.middle[i]
        total += 0.5 * prior.precision[i] * away * away
        over = max(pose[i] - prior.high[i], prior.low[i] - pose[i], 0.0)
        total += 0.5 * prior.wall[i] * over * over
    weights, errors = group_sums(pose, prior, active)
    for g in range(weights.shape[0]):
        if weights[g] > 0.0:
            total -= 0.5 * prior.together[0] * errors[g] ** 2 / weights[g]
    if prior.pull.shape[0]:
        for i in active:
            for j in active:
                if prior.pull[i, j] != 0.0:
                    away = (pose[i] - prior.around[i]) * (pose[j] - prior.around[j])
                    total += 0.5 * prior.pull[i, j] * away
    return total


@compiled_loosely
def add_prior(
    pose: np.ndarray, prior: Prior, active: np.ndarray, matrix: np.ndarray, vector: np.ndarray
) -> None:
    """Add the prior to the Gauss-Newton matrix and gradient."""
    weights, errors = group_sums(pose, prior, active)
    share = prior.together[0]
    for i in active:
        matrix[i, i] += prior.precision[i]
        vector[i] += prior.precision[i] * (pose[i] - prior.middle[i])
        if pose[i] > prior.high[i]:
            matrix[i, i] += prior.wall[i]
            vector[i] += prior.wall[i] * (pose[i] - prior.high[i])
        elif pose[i] < prior.low[i]:
            matrix[i, i] += prior.wall[i]
            vector[i] += prior.wall[i] * (pose[i] - prior.low[i])
        g = prior.group[i]
        if g >= 0 and weights[g] > 0.0:
            part = share * prior.precision[i] / weights[g]
            vector[i] -= part * errors[g]
            for j in active:
                if j <= i and prior.group[j] == g:
                    matrix[i, j] -= part * prior.precision[j]
    if prior.pull.shape[0]:
        for i in active:
            for j in active:
                vector[i] += prior.pull[i, j] * (pose[j] - prior.around[j])
                if j <= i:
                    matrix[i, j] += prior.pull[i, j]


@compiled_loosely
def paint_some(
    layout: PoseLayout, pose: np.ndarray, blur: float, box: np.ndarray, shown: np.ndarray,
    value: np.ndarray, owner: np.ndarray, along: np.ndarray, joints: np.ndarray,
) -> None:  # fmt: skip
    """Paint some legs, and the body where ``shown[-1]``; ``shown`` is (legs + 1,) bool."""
    clear(value, owner)
    paint_more(layout, pose, blur, box, shown, value, owner, along, joints)


@compiled_loosely
def paint_more(
    layout: PoseLayout, pose: np.ndarray, blur: float, box: np.ndarray, shown: np.ndarray,
    value: np.ndarray, owner: np.ndarray, along: np.ndarray, joints: np.ndarray,
) -> None:  # fmt: skip
    """Paint as :func:`paint_some`, over what is painted already."""
    if shown[-1]:
        paint_body(layout, pose, blur, box, value, owner)
    for leg in range(layout.side.shape[0]):
        if shown[leg]:
            leg_chain(layout, pose, leg, joints[leg])
            paint_leg(layout, joints[leg], leg, blur, box, value, owner, along)


@compiled_loosely
def what_moves(layout: PoseLayout, active: np.ndarray) -> np.ndarray:
    """Return which legs, and last the body, move with the ``active`` numbers of the pose."""
    legs = layout.side.shape[0]
    moves = np.zeros(legs + 1, np.bool_)
    for i in active:
        if i < N_BODY:
            moves[:] = True
        for leg in range(legs):
            if layout.first[leg] <= i < layout.first[leg] + 2 * layout.n_links[leg]:
                moves[leg] = True
    return moves


@compiled_loosely
def normal_matrix(
    layout: PoseLayout,
    pose: np.ndarray,
    image_evidence: ImageEvidence,
    prior: Prior,
    active: np.ndarray,
    moves: np.ndarray,
    blur: float,
    soft: float,
    value: np.ndarray,
    owner: np.ndarray,
    along: np.ndarray,
    joints: np.ndarray,
    matrix: np.ndarray,
    vector: np.ndarray,
) -> float:
    """Return cost; fill the Gauss-Newton matrix and gradient of picture and prior.

    The pose has been painted (:func:`paint_some`); ``moves`` is :func:`what_moves` with the
    ``active`` numbers.
    """
    matrix[:] = 0.0
    vector[:] = 0.0
    cost = normal_equations(
        layout,
        pose,
        blur,
        image_evidence.box,
        value,
        owner,
        along,
        joints,
        image_evidence.seen,
        image_evidence.weight,
        soft,
        moves,
        matrix,
        vector,
    )
    add_prior(pose, prior, active, matrix, vector)
    return cost + prior_cost(pose, prior, active)


@compiled_loosely
def solve_in_place(matrix: np.ndarray, vector: np.ndarray) -> bool:
    """Solve matrix x = vector by Cholesky into ``vector``; False if not positive definite.

    Only the lower triangle is read; it is overwritten with the factor. What a row has of zeros
    before its first other number stays zero, and costs nothing.
    """
    n = vector.shape[0]
    starts = np.zeros(n, np.int64)
    for i in range(n):
        while starts[i] < i and matrix[i, starts[i]] == 0.0:
            starts[i] += 1
        for j in range(starts[i], i + 1):
            total = matrix[i, j]
            for k in range(max(starts[i], starts[j]), j):
                total -= matrix[i, k] * matrix[j, k]
            if i != j:
                matrix[i, j] = total / matrix[j, j]
            elif total <= 0.0:
                return False
            else:
                matrix[i, i] = np.sqrt(total)
    for i in range(n):
        for k in range(starts[i], i):
            vector[i] -= matrix[i, k] * vector[k]
        vector[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            vector[i] -= matrix[k, i] * vector[k]
        vector[i] /= matrix[i, i]
    return True


@compiled_loosely
def damped_step(
    matrix: np.ndarray, vector: np.ndarray, active: np.ndarray, damping: float,
    part: np.ndarray, step: np.ndarray,
) -> bool:  # fmt: skip
    """Write the step of the active numbers, last to first; False where there is none.

    ``part`` (n active, n active) is room to work in. Legs meet only in the body, whose numbers
    are the first: with them last, the equations of each leg are solved by themselves.
    """
    m = active.shape[0]
    for i in range(m):
        p = active[m - 1 - i]
        step[i] = -vector[p]
        for j in range(i + 1):
            part[i, j] = matrix[active[m - 1 - j], p]
        part[i, i] *= 1.0 + damping
        part[i, i] += 1e-9
    return solve_in_place(part, step)


@compiled_loosely
def bring_back(
    still: tuple[np.ndarray, np.ndarray, np.ndarray],
    value: np.ndarray, owner: np.ndarray, along: np.ndarray,
) -> None:  # fmt: skip
    """Put back what was on the canvas."""
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            value[v, u], owner[v, u], along[v, u] = still[0][v, u], still[1][v, u], still[2][v, u]


@compiled_loosely
def fit_pose(
    layout: PoseLayout,
    pose: np.ndarray,
    image_evidence: ImageEvidence,
    prior: Prior,
    active: np.ndarray,
    shown: np.ndarray,
    blur: float,
    soft: float,
    rounds: int,
    enough: float,
    value: np.ndarray,
    owner: np.ndarray,
    along: np.ndarray,
    joints: np.ndarray,
) -> tuple[np.ndarray, float]:
    """Return the pose nearby that fits best, and its cost.

    Parameters
    ----------
    layout, pose, image_evidence, prior
        Animal, first guess, picture, prior.
    active : ndarray of int
        Numbers of the pose that may change, ascending.
    shown : ndarray of bool, shape (legs + 1,)
        Legs, and last the body, that are painted.
    blur, soft : float
        Half width of the blur, px; error beyond which a pixel counts less.
    rounds : int
        Most steps.
    enough : float
        The fit ends when a step lowers the cost by less.
    value, owner, along, joints : ndarray
        Canvas to paint on.

    Returns
    -------
    pose, cost
        The pose is a fresh array.
    """
    n = pose.shape[0]
    matrix, vector = np.zeros((n, n)), np.zeros(n)
    m = active.shape[0]
    part, step = np.zeros((m, m)), np.zeros(m)
    pose = pose.copy()
    cost, damping = 0.0, _FIT_DAMPING
    moves, rest = what_moves(layout, active), np.zeros(shown.shape[0], np.bool_)
    some_rest = False
    for i in range(shown.shape[0]):
        rest[i], moves[i] = shown[i] and not moves[i], shown[i] and moves[i]
        some_rest = some_rest or rest[i]
    paint_some(layout, pose, blur, image_evidence.box, rest, value, owner, along, joints)
    still = (value.copy(), owner.copy(), along.copy()) if some_rest else (value, owner, along)
    paint_more(layout, pose, blur, image_evidence.box, moves, value, owner, along, joints)
    for _ in range(rounds):  # the pose is on the canvas: that of the last step, which was kept
        cost = normal_matrix(
            layout,
            pose,
            image_evidence,
            prior,
            active,
            moves,
            blur,
            soft,
            value,
            owner,
            along,
            joints,
            matrix,
            vector,
        )
        gained = 0.0
        for _ in range(_TRIES):
            if not damped_step(matrix, vector, active, damping, part, step):
                damping *= _FIT_HARDER
                continue
            trial = pose.copy()
            for i in range(m):
                trial[active[i]] += step[m - 1 - i]
            if some_rest:
                bring_back(still, value, owner, along)
            else:
                clear(value, owner)
            paint_more(layout, trial, blur, image_evidence.box, moves, value, owner, along, joints)
            now = picture_cost(value, owner, image_evidence.seen, image_evidence.weight, soft)
            now += prior_cost(trial, prior, active)
            if now < cost:
                gained = cost - now
                pose = trial
                cost = now
                damping = max(damping * _FIT_EASIER, _FIT_LEAST)
                break
            damping *= _FIT_HARDER
        if gained < enough:
            break
    return pose, cost
