"""Hypotheses of a point, side by side in columns, and what a frame makes of them, compiled.

States are position, speed and acceleration one after another. Of covariances the lower triangle
is kept, row after row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled


class HypothesisBank(NamedTuple):
    """Room for hypotheses.

    Parameters
    ----------
    mean : ndarray, shape (3 d, b)
        Their states.
    covariance : ndarray, shape (3 d (3 d + 1) / 2, b)
        Covariances of these.
    cost : ndarray, shape (b,)
        Minus the logarithm of how likely each is.
    origin : ndarray of int, shape (b,)
        Which hypothesis of the frame before it was.
    taken : ndarray of int, shape (V, b)
        Detection of each view that it took in this frame, -1 where none.
    since : ndarray of int, shape (b,)
        Frames since it lifted off, 0 if it did not.
    standing, occluded : ndarray of bool, shape (b,)
        Whether it stands, and whether it was occluded at the end of the frame before.
    """

    mean: np.ndarray
    covariance: np.ndarray
    cost: np.ndarray
    origin: np.ndarray
    taken: np.ndarray
    since: np.ndarray
    standing: np.ndarray
    occluded: np.ndarray


class ProcessNoise(NamedTuple):
    """How hypotheses go on from frame to frame.

    Parameters
    ----------
    plain, manoeuvring, lifted : ndarray, shape (3 d (3 d + 1) / 2,)
        Covariances of what happens between two frames: usually, where a point gets an impulse,
        and where it lifts off.
    substrate_velocity, liftoff_velocity : ndarray, shape (d,)
        Speed of the ground, and how much lift-off changes that of a point.
    hold, slip : float
        Variances of where a point stands, and of what it moves there from frame to frame.
    """

    plain: np.ndarray
    manoeuvring: np.ndarray
    lifted: np.ndarray
    substrate_velocity: np.ndarray
    liftoff_velocity: np.ndarray
    hold: float
    slip: float


@compiled
def allocate(hypotheses: int, d: int, views: int) -> HypothesisBank:
    """Return room for so many hypotheses."""
    size = 3 * d
    return HypothesisBank(
        np.empty((size, hypotheses)),
        np.empty((size * (size + 1) // 2, hypotheses)),
        np.zeros(hypotheses),
        np.zeros(hypotheses, np.int64),
        np.full((views, hypotheses), -1, np.int64),
        np.zeros(hypotheses, np.int64),
        np.zeros(hypotheses, np.bool_),
        np.zeros(hypotheses, np.bool_),
    )


@compiled
def cell(j: int, i: int) -> int:
    """Return where a covariance of two coordinates is kept."""
    return j * (j + 1) // 2 + i if j >= i else i * (i + 1) // 2 + j


@compiled
def copy(now: HypothesisBank, which: np.ndarray, then: HypothesisBank) -> None:
    """Copy some hypotheses."""
    for j in range(len(now.mean)):
        for k in range(len(which)):
            then.mean[j, k] = now.mean[j, which[k]]
    for e in range(len(now.covariance)):
        for k in range(len(which)):
            then.covariance[e, k] = now.covariance[e, which[k]]
    for v in range(len(now.taken)):
        for k in range(len(which)):
            then.taken[v, k] = now.taken[v, which[k]]
    for k, b in enumerate(which):
        then.cost[k], then.origin[k], then.since[k] = now.cost[b], now.origin[b], now.since[b]
        then.standing[k], then.occluded[k] = now.standing[b], now.occluded[b]


@compiled
def initialise(
    hypotheses: HypothesisBank,
    state: np.ndarray,
    covariance: np.ndarray,
    place: np.ndarray,
    process_noise: ProcessNoise,
) -> int:
    """Begin with one hypothesis, and return that number.

    Parameters
    ----------
    hypotheses : HypothesisBank
        Where it goes.
    state, covariance : ndarray, shape (3, d) and (3, 3)
        Position, speed and acceleration, and their covariance, the same along each axis.
    place : ndarray, shape (d,)
        Where the point stands, NaN where it does not.
    process_noise : ProcessNoise
        How hypotheses go on.
    """
    # a constant would be a type of its own: what takes it would be compiled twice
    n, d = int(np.int64(1)), len(place)
    for e in range(len(hypotheses.covariance)):
        hypotheses.covariance[e, 0] = 0.0
    for k in range(3):
        for i in range(d):
            hypotheses.mean[k * d + i, 0] = state[k, i]
            for m in range(k + 1):
                hypotheses.covariance[cell(k * d + i, m * d + i), 0] = covariance[k, m]
    hypotheses.cost[0], hypotheses.since[0], hypotheses.occluded[0] = 0.0, 0, False
    hypotheses.standing[0] = not np.isnan(place[0])
    if hypotheses.standing[0]:
        for i in range(d):
            hypotheses.mean[i, 0] = place[i]
        _hold(hypotheses, n - 1, np.full(d, process_noise.hold), process_noise)
    return n


@compiled
def _hold(
    hypotheses: HypothesisBank, b: int, variance: np.ndarray, process_noise: ProcessNoise
) -> None:
    """Let a hypothesis stand where it is, with variances (d,) of that."""
    d = len(variance)
    for e in range(len(hypotheses.covariance)):
        hypotheses.covariance[e, b] = 0.0
    for i in range(d):
        hypotheses.mean[d + i, b], hypotheses.mean[2 * d + i, b] = (
            process_noise.substrate_velocity[i],
            0.0,
        )
        hypotheses.covariance[cell(i, i), b] = variance[i]
        hypotheses.covariance[cell(d + i, d + i), b] = process_noise.slip


@compiled
def predict(
    now: HypothesisBank,
    n: int,
    then: HypothesisBank,
    process_noise: ProcessNoise,
    impulse_cost: float,
    lifting: float,
) -> int:
    """Go on by one frame: every hypothesis plainly, and with an impulse.

    What stands goes with the ground, whatever is seen; an impulse is its lift-off.

    Parameters
    ----------
    now, then : HypothesisBank
        The hypotheses, and where they go: first as they go on plainly, then with an impulse.
    n : int
        How many there are.
    process_noise : ProcessNoise
        How they go on.
    impulse_cost, lifting : float
        Cost of an impulse, and of lifting off.

    Returns
    -------
    int
        How many there are then.
    """
    d = len(process_noise.substrate_velocity)
    _stepped(now, n, then)
    for e in range(len(process_noise.plain)):
        plain, manoeuvring = process_noise.plain[e], process_noise.manoeuvring[e]
        for b in range(n):
            spread = then.covariance[e, b]
            then.covariance[e, b] = spread + plain
            then.covariance[e, n + b] = spread + manoeuvring
    for j in range(len(then.mean)):
        for b in range(n):
            then.mean[j, n + b] = then.mean[j, b]
    for v in range(len(then.taken)):
        for b in range(2 * n):
            then.taken[v, b] = -1
    variance = np.empty(d)
    for b in range(n):
        since = now.since[b] + 1 if now.since[b] > 0 else 0
        stands = now.standing[b]
        for k in (b, n + b):
            then.origin[k], then.occluded[k], then.cost[k] = b, now.occluded[b], now.cost[b]
            then.since[k], then.standing[k] = since, False
        # every paw that stands lifts off once
        then.cost[n + b] += lifting if stands else impulse_cost
        if stands:
            then.since[n + b], then.standing[b] = 1, True
            for i in range(d):
                variance[i] = now.covariance[cell(i, i), b] + process_noise.slip
            _hold(then, b, variance, process_noise)
            _lift_off(then, n + b, process_noise)
    return 2 * n


@compiled
def _stepped(now: HypothesisBank, n: int, then: HypothesisBank) -> None:
    """Go on by one frame at constant acceleration."""
    size = len(now.mean)
    d = size // 3
    half = np.empty((size, size, n))
    for i in range(d):
        for b in range(n):
            x, v, a = now.mean[i, b], now.mean[d + i, b], now.mean[2 * d + i, b]
            then.mean[i, b], then.mean[d + i, b] = x + v + 0.5 * a, v + a
            then.mean[2 * d + i, b] = a
        for j in range(size):
            at_x, at_v, at_a = cell(i, j), cell(d + i, j), cell(2 * d + i, j)
            for b in range(n):
                x, v, a = (
                    now.covariance[at_x, b], now.covariance[at_v, b], now.covariance[at_a, b],
                )  # fmt: skip
                (
                    half[i, j, b],
                    half[d + i, j, b],
                    half[2 * d + i, j, b],
                ) = x + v + 0.5 * a, v + a, a
    for j in range(size):
        for i in range(d):
            for b in range(n):
                x, v, a = (
                    half[j, i, b],
                    half[j, d + i, b],
                    half[j, 2 * d + i, b],
                )
                if j >= i:
                    then.covariance[cell(j, i), b] = x + v + 0.5 * a
                if j >= d + i:
                    then.covariance[cell(j, d + i), b] = v + a
                if j >= 2 * d + i:
                    then.covariance[cell(j, 2 * d + i), b] = a


@compiled
def _lift_off(hypotheses: HypothesisBank, b: int, process_noise: ProcessNoise) -> None:
    """Change the speed of a hypothesis at some time between the frames."""
    d = len(process_noise.liftoff_velocity)
    for i in range(d):
        hypotheses.mean[i, b] += 0.5 * process_noise.liftoff_velocity[i]
        hypotheses.mean[d + i, b] += process_noise.liftoff_velocity[i]
    for e in range(len(process_noise.lifted)):
        hypotheses.covariance[e, b] += process_noise.lifted[e] - process_noise.manoeuvring[e]


@compiled
def update_with_position(
    hypotheses: HypothesisBank, n: int, at: np.ndarray, variance: float
) -> None:
    """Take in a certain place (d,), its coordinates one after the other: they are independent."""
    axis, every = np.zeros(len(at)), np.ones(n)
    for i in range(len(at)):
        axis[:] = 0.0
        axis[i] = 1.0
        square, spread = _update(hypotheses, n, axis, at[i], variance, every)
        for b in range(n):
            hypotheses.cost[b] += 0.5 * square[b] + 0.5 * np.log(spread[b])


@compiled
def update_with_expectation(
    hypotheses: HypothesisBank,
    n: int,
    at: np.ndarray,
    axes: np.ndarray,
    variance: np.ndarray,
    most: float,
) -> None:
    """Take in where the point is expected.

    Parameters
    ----------
    hypotheses : HypothesisBank
        The hypotheses, and
    n : int
        how many there are.
    at, variance : ndarray, shape (d,)
        The expected place, and its variances along the axes.
    axes : ndarray, shape (d, d)
        Unit vectors.
    most : float
        Hypotheses for which it would cost more are elsewhere for once: they cost this, and
        the expectation tells them nothing.
    """
    informed, square = np.empty(n), _mahalanobis_squared(hypotheses, n, at, axes, variance)
    for b in range(n):
        informed[b] = 1.0 if 0.5 * square[b] < most else 0.0
        hypotheses.cost[b] += min(0.5 * square[b], most)
    for k in range(len(at)):
        value = 0.0
        for i in range(len(at)):
            value += axes[k, i] * at[i]
        _update(hypotheses, n, axes[k], value, variance[k], informed)


@compiled
def _mahalanobis_squared(
    hypotheses: HypothesisBank, n: int, at: np.ndarray, axes: np.ndarray, variance: np.ndarray
) -> np.ndarray:
    """Return squared distances of hypotheses from an expected place, in standard deviations."""
    d, square = len(at), np.zeros(n)
    step, spread = _innovation(hypotheses, n, at, axes)
    # one axis after the other, each given those before it
    for k in range(d):
        for b in range(n):
            spread[k, k, b] += variance[k]
            square[b] += step[k, b] * step[k, b] / spread[k, k, b]
        for m in range(k + 1, d):
            for b in range(n):
                step[m, b] -= spread[m, k, b] / spread[k, k, b] * step[k, b]
            for o in range(k + 1, m + 1):
                for b in range(n):
                    spread[m, o, b] -= spread[m, k, b] / spread[k, k, b] * spread[o, k, b]
    return square


@compiled
def _innovation(
    hypotheses: HypothesisBank, n: int, at: np.ndarray, axes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far hypotheses are from a place along axes (d, b), and covariances (d, d, b)."""
    d = len(at)
    step, spread = np.zeros((d, n)), np.zeros((d, d, n))
    for k in range(d):
        for i in range(d):
            for b in range(n):
                step[k, b] += axes[k, i] * (at[i] - hypotheses.mean[i, b])
        for m in range(k + 1):
            for i in range(d):
                for j in range(d):
                    share, e = axes[k, i] * axes[m, j], cell(i, j)
                    for b in range(n):
                        spread[k, m, b] += share * hypotheses.covariance[e, b]
    return step, spread


@compiled
def _update(
    hypotheses: HypothesisBank,
    n: int,
    axis: np.ndarray,
    value: float,
    variance: float,
    share: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Take in one coordinate of the position along an axis, as a Kalman filter does.

    Only hypotheses whose ``share`` is 1, not 0, learn from it. Returns how far each hypothesis was
    from it, squared and in standard deviations, and the variance of that.
    """
    size, d = len(hypotheses.mean), len(axis)
    across, spread = np.zeros((size, n)), np.full(n, variance)
    step, gain, square = np.full(n, value), np.empty(n), np.empty(n)
    for i in range(d):
        for j in range(size):
            at = cell(j, i)
            for b in range(n):
                across[j, b] += hypotheses.covariance[at, b] * axis[i]
        for b in range(n):
            step[b] -= axis[i] * hypotheses.mean[i, b]
    for b in range(n):
        for i in range(d):
            spread[b] += axis[i] * across[i, b]
        gain[b], square[b] = share[b] / spread[b], step[b] * step[b] / spread[b]
    for j in range(size):
        for b in range(n):
            hypotheses.mean[j, b] += across[j, b] * gain[b] * step[b]
        for i in range(j + 1):
            at = cell(j, i)
            for b in range(n):
                hypotheses.covariance[at, b] -= across[j, b] * across[i, b] * gain[b]
    return square, spread
