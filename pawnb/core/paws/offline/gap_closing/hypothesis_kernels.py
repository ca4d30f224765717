"""Stories of a point, side by side in columns, and what a frame makes of them, compiled.

States are position, speed and acceleration one after another. Of covariances the lower triangle
is kept, row after row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled


class Stories(NamedTuple):
    """Room for stories.

    Parameters
    ----------
    mean : ndarray, shape (3 d, b)
        Their states.
    covariance : ndarray, shape (3 d (3 d + 1) / 2, b)
        Covariances of these.
    cost : ndarray, shape (b,)
        Minus the logarithm of how likely each is.
    origin : ndarray of int, shape (b,)
        Which story of the frame before it was.
    taken : ndarray of int, shape (V, b)
        Candidate of each view that it took in this frame, -1 where none.
    since : ndarray of int, shape (b,)
        Frames since it lifted off, 0 if it did not.
    standing, hidden : ndarray of bool, shape (b,)
        Whether it stands, and whether it was hidden at the end of the frame before.
    """

    mean: np.ndarray
    covariance: np.ndarray
    cost: np.ndarray
    origin: np.ndarray
    taken: np.ndarray
    since: np.ndarray
    standing: np.ndarray
    hidden: np.ndarray


class Moves(NamedTuple):
    """How stories go on from frame to frame.

    Parameters
    ----------
    plain, kicked, lifted : ndarray, shape (3 d (3 d + 1) / 2,)
        Covariances of what happens between two frames: usually, where a point is kicked,
        and where it lifts off.
    drift, lift : ndarray, shape (d,)
        Speed of the ground, and how much lift-off changes that of a point.
    hold, slip : float
        Variances of where a point stands, and of what it moves there from frame to frame.
    """

    plain: np.ndarray
    kicked: np.ndarray
    lifted: np.ndarray
    drift: np.ndarray
    lift: np.ndarray
    hold: float
    slip: float


@compiled
def room_for(stories: int, d: int, views: int) -> Stories:
    """Return room for so many stories."""
    size = 3 * d
    return Stories(
        np.empty((size, stories)), np.empty((size * (size + 1) // 2, stories)),
        np.zeros(stories), np.zeros(stories, np.int64), np.full((views, stories), -1, np.int64),
        np.zeros(stories, np.int64), np.zeros(stories, np.bool_), np.zeros(stories, np.bool_),
    )  # fmt: skip


@compiled
def cell(j: int, i: int) -> int:
    """Return where a covariance of two coordinates is kept."""
    return j * (j + 1) // 2 + i if j >= i else i * (i + 1) // 2 + j


@compiled
def copy(now: Stories, which: np.ndarray, then: Stories) -> None:
    """Copy some stories."""
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
        then.standing[k], then.hidden[k] = now.standing[b], now.hidden[b]


@compiled
def begin(
    stories: Stories, state: np.ndarray, covariance: np.ndarray, place: np.ndarray, moves: Moves
) -> int:
    """Begin with one story, and return that number.

    Parameters
    ----------
    stories : Stories
        Where it goes.
    state, covariance : ndarray, shape (3, d) and (3, 3)
        Position, speed and acceleration, and their covariance, the same along each axis.
    place : ndarray, shape (d,)
        Where the point stands, NaN where it does not.
    moves : Moves
        How stories go on.
    """
    # a constant would be a type of its own: what takes it would be compiled twice
    n, d = int(np.int64(1)), len(place)
    for e in range(len(stories.covariance)):
        stories.covariance[e, 0] = 0.0
    for k in range(3):
        for i in range(d):
            stories.mean[k * d + i, 0] = state[k, i]
            for m in range(k + 1):
                stories.covariance[cell(k * d + i, m * d + i), 0] = covariance[k, m]
    stories.cost[0], stories.since[0], stories.hidden[0] = 0.0, 0, False
    stories.standing[0] = not np.isnan(place[0])
    if stories.standing[0]:
        for i in range(d):
            stories.mean[i, 0] = place[i]
        _hold(stories, n - 1, np.full(d, moves.hold), moves)
    return n


@compiled
def _hold(stories: Stories, b: int, variance: np.ndarray, moves: Moves) -> None:
    """Let a story stand where it is, with variances (d,) of that."""
    d = len(variance)
    for e in range(len(stories.covariance)):
        stories.covariance[e, b] = 0.0
    for i in range(d):
        stories.mean[d + i, b], stories.mean[2 * d + i, b] = moves.drift[i], 0.0
        stories.covariance[cell(i, i), b] = variance[i]
        stories.covariance[cell(d + i, d + i), b] = moves.slip


@compiled
def advance(
    now: Stories, n: int, then: Stories, moves: Moves, kick_cost: float, lifting: float
) -> int:
    """Go on by one frame: every story plainly, and with a kick.

    What stands goes with the ground, whatever is seen; a kick is its lift-off.

    Parameters
    ----------
    now, then : Stories
        The stories, and where they go: first as they go on plainly, then as they are kicked.
    n : int
        How many there are.
    moves : Moves
        How they go on.
    kick_cost, lifting : float
        Cost of a kick, and of lifting off.

    Returns
    -------
    int
        How many there are then.
    """
    d = len(moves.drift)
    _stepped(now, n, then)
    for e in range(len(moves.plain)):
        plain, kicked = moves.plain[e], moves.kicked[e]
        for b in range(n):
            spread = then.covariance[e, b]
            then.covariance[e, b] = spread + plain
            then.covariance[e, n + b] = spread + kicked
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
            then.origin[k], then.hidden[k], then.cost[k] = b, now.hidden[b], now.cost[b]
            then.since[k], then.standing[k] = since, False
        # every paw that stands lifts off once
        then.cost[n + b] += lifting if stands else kick_cost
        if stands:
            then.since[n + b], then.standing[b] = 1, True
            for i in range(d):
                variance[i] = now.covariance[cell(i, i), b] + moves.slip
            _hold(then, b, variance, moves)
            _lift_off(then, n + b, moves)
    return 2 * n


@compiled
def _stepped(now: Stories, n: int, then: Stories) -> None:
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
                half[i, j, b], half[d + i, j, b], half[2 * d + i, j, b] = x + v + 0.5 * a, v + a, a
    for j in range(size):
        for i in range(d):
            for b in range(n):
                x, v, a = half[j, i, b], half[j, d + i, b], half[j, 2 * d + i, b]
                if j >= i:
                    then.covariance[cell(j, i), b] = x + v + 0.5 * a
                if j >= d + i:
                    then.covariance[cell(j, d + i), b] = v + a
                if j >= 2 * d + i:
                    then.covariance[cell(j, 2 * d + i), b] = a


@compiled
def _lift_off(stories: Stories, b: int, moves: Moves) -> None:
    """Change the speed of a story at some time between the frames."""
    d = len(moves.lift)
    for i in range(d):
        stories.mean[i, b] += 0.5 * moves.lift[i]
        stories.mean[d + i, b] += moves.lift[i]
    for e in range(len(moves.lifted)):
        stories.covariance[e, b] += moves.lifted[e] - moves.kicked[e]


@compiled
def stand(stories: Stories, n: int, at: np.ndarray, variance: float) -> None:
    """Take in a certain place (d,), its coordinates one after the other: they are independent."""
    axis, every = np.zeros(len(at)), np.ones(n)
    for i in range(len(at)):
        axis[:] = 0.0
        axis[i] = 1.0
        square, spread = _take_in(stories, n, axis, at[i], variance, every)
        for b in range(n):
            stories.cost[b] += 0.5 * square[b] + 0.5 * np.log(spread[b])


@compiled
def expect(
    stories: Stories, n: int, at: np.ndarray, axes: np.ndarray, variance: np.ndarray, most: float
) -> None:
    """Take in where the point is expected.

    Parameters
    ----------
    stories : Stories
        The stories, and
    n : int
        how many there are.
    at, variance : ndarray, shape (d,)
        The expected place, and its variances along the axes.
    axes : ndarray, shape (d, d)
        Unit vectors.
    most : float
        Stories for which it would cost more are elsewhere for once: they cost this, and
        the expectation tells them nothing.
    """
    told, square = np.empty(n), _squares(stories, n, at, axes, variance)
    for b in range(n):
        told[b] = 1.0 if 0.5 * square[b] < most else 0.0
        stories.cost[b] += min(0.5 * square[b], most)
    for k in range(len(at)):
        value = 0.0
        for i in range(len(at)):
            value += axes[k, i] * at[i]
        _take_in(stories, n, axes[k], value, variance[k], told)


@compiled
def _squares(
    stories: Stories, n: int, at: np.ndarray, axes: np.ndarray, variance: np.ndarray
) -> np.ndarray:
    """Return squared distances of stories from an expected place, in standard deviations."""
    d, square = len(at), np.zeros(n)
    step, spread = _apart(stories, n, at, axes)
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
def _apart(
    stories: Stories, n: int, at: np.ndarray, axes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far stories are from a place along axes (d, b), and covariances (d, d, b)."""
    d = len(at)
    step, spread = np.zeros((d, n)), np.zeros((d, d, n))
    for k in range(d):
        for i in range(d):
            for b in range(n):
                step[k, b] += axes[k, i] * (at[i] - stories.mean[i, b])
        for m in range(k + 1):
            for i in range(d):
                for j in range(d):
                    share, e = axes[k, i] * axes[m, j], cell(i, j)
                    for b in range(n):
                        spread[k, m, b] += share * stories.covariance[e, b]
    return step, spread


@compiled
def _take_in(
    stories: Stories, n: int, axis: np.ndarray, value: float, variance: float, share: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Take in one coordinate of the position along an axis, as a Kalman filter does.

    Only stories whose ``share`` is 1, not 0, learn from it. Returns how far each story was
    from it, squared and in standard deviations, and the variance of that.
    """
    size, d = len(stories.mean), len(axis)
    across, spread = np.zeros((size, n)), np.full(n, variance)
    step, gain, square = np.full(n, value), np.empty(n), np.empty(n)
    for i in range(d):
        for j in range(size):
            at = cell(j, i)
            for b in range(n):
                across[j, b] += stories.covariance[at, b] * axis[i]
        for b in range(n):
            step[b] -= axis[i] * stories.mean[i, b]
    for b in range(n):
        for i in range(d):
            spread[b] += axis[i] * across[i, b]
        gain[b], square[b] = share[b] / spread[b], step[b] * step[b] / spread[b]
    for j in range(size):
        for b in range(n):
            stories.mean[j, b] += across[j, b] * gain[b] * step[b]
        for i in range(j + 1):
            at = cell(j, i)
            for b in range(n):
                stories.covariance[at, b] -= across[j, b] * across[i, b] * gain[b]
    return square, spread
