"""Tracklets, short certain parts of paths: places that follow each other without any doubt."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses


@dataclass(frozen=True)
class LinkingModel:
    """When places of consecutive frames belong together.

    Parameters
    ----------
    acceleration : float
        Standard deviation of the acceleration, length per frame squared.
    noise : float
        Standard deviation of a place.
    speed : float
        Standard deviation of an unknown speed, length per frame.
    substrate_velocity : ndarray, shape (d,)
        The commonest speed, length per frame: that of paws on the ground.
    best_cost : float
        Places that cost more than this are left out.
    """

    acceleration: float
    noise: float
    speed: float
    substrate_velocity: FloatArray
    best_cost: float


@dataclass(frozen=True)
class Tracklet:
    """One tracklet: the places ``detection_indices[i]`` of frames ``first + i``.

    Parameters
    ----------
    first : int
        Its first frame.
    detection_indices : list of int
        Numbers of the places.
    at : ndarray, shape (n, d)
        Their positions.
    cost : ndarray, shape (n,)
        Their costs.
    """

    first: int
    detection_indices: list[int]
    at: FloatArray
    cost: FloatArray

    @property
    def last(self) -> int:
        """Its last frame."""
        return self.first + len(self.detection_indices) - 1

    def end(
        self, substrate_velocity: FloatArray, *, head: bool
    ) -> tuple[FloatArray, FloatArray, int]:
        """Return position and speed at the first or last frame, and how many frames it is from."""
        part = (
            self.at[: NETWORK_FLOW.tracklets_ends]
            if head
            else self.at[-NETWORK_FLOW.tracklets_ends :]
        )
        n = len(part)
        if n == 1:
            return part[0], substrate_velocity, 1
        place, speed = _end_weights(n, head=head) @ part
        return place, speed, n


@functools.cache
def _end_weights(n: int, *, head: bool) -> FloatArray:
    """Return what each of n places weighs in position and speed (2, n) at one end.

    Those of the straight line of least squares.
    """
    time = np.arange(n) - (0 if head else n - 1)
    return np.asarray(np.linalg.pinv(time[:, None] ** np.arange(2)))


def estimate_substrate_velocity(
    places: Sequence[PointHypotheses], *, within: float, longest: float, lag: int = 1
) -> FloatArray:
    """Return the commonest step of good places from one frame to the next, (d,).

    Paws on the ground all move with it, so their steps pile up.

    Parameters
    ----------
    places : sequence of PointHypotheses
        Hypotheses of each frame.
    within : float
        Steps closer than this count as the same.
    longest : float
        Longest step considered.
    lag : int
        Frames over which steps are taken; those of a single one are hardly longer than places
        err. Shorter recordings take what they have.

    Returns
    -------
    ndarray
        The mean of the steps where they are densest, a frame; 0 where there are none.
    """
    lag = max(1, min(lag, len(places) - 1))
    sampled = range(0, len(places) - lag, max(1, len(places) // NETWORK_FLOW.ground_frames))
    every = np.empty((0, places[0].at.shape[1]))
    for cost_limit in NETWORK_FLOW.tracklets_cost_limits:
        pairs = [[p.at[p.cost < cost_limit] for p in (places[t], places[t + lag])] for t in sampled]
        steps = [(later[None] - now[:, None]).reshape(-1, every.shape[1]) for now, later in pairs]
        every = np.concatenate([every[:0], *steps])
        every = every[np.linalg.norm(every, axis=1) < longest * lag]
        if len(every) >= NETWORK_FLOW.tracklets_enough * len(sampled):
            break
    if not len(every):
        return np.zeros(every.shape[1])
    tree = cKDTree(every)
    count = tree.query_ball_point(every, within, return_length=True)
    middle = every[int(np.argmax(count))]
    return np.asarray(every[tree.query_ball_point(middle, within)].mean(axis=0) / lag)


def build_tracklets(places: Sequence[PointHypotheses], linking: LinkingModel) -> list[Tracklet]:
    """Join places of consecutive frames wherever each is the other's only choice.

    Parameters
    ----------
    places : sequence of PointHypotheses
        Hypotheses of each frame.
    linking : LinkingModel
        What belongs together.

    Returns
    -------
    list of Tracklet
        Tracklets in the order of their first frames; no place is in two of them.
    """
    d = len(linking.substrate_velocity)
    ids, n_chains = np.empty(0, int), 0
    at, speed, var = np.empty((0, d)), np.empty((0, d)), np.empty((0, 3))
    substrate_velocity = np.ascontiguousarray(linking.substrate_velocity, float)
    spread = (linking.noise**2, linking.acceleration**2, linking.speed**2)
    gate = (NETWORK_FLOW.gate, NETWORK_FLOW.clear, *NETWORK_FLOW.clear_near)
    rows = []
    for here in places:
        good = np.flatnonzero(here.cost <= linking.best_cost)
        detection_indices, chain, at, speed, var = _followed(
            at, speed, var, here.at[good], here.cost[good], substrate_velocity, spread, gate
        )
        old, detection_indices = ids[chain], good[detection_indices]
        ids = np.concatenate([old, n_chains + np.arange(len(detection_indices) - len(old))])
        n_chains += len(detection_indices) - len(old)
        rows.append(
            (ids, detection_indices, here.at[detection_indices], here.cost[detection_indices])
        )
    return _pieces(rows, n_chains)


@compiled
def _followed(
    at: np.ndarray,
    speed: np.ndarray,
    var: np.ndarray,
    places: np.ndarray,
    cost: np.ndarray,
    substrate_velocity: np.ndarray,
    spread: tuple[float, float, float],
    gate: tuple[float, float, float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Follow chains to the places of the next frame, as a Kalman filter does.

    Parameters
    ----------
    at, speed : ndarray, shape (k, d)
        Where chains are, and how fast they go.
    var : ndarray, shape (k, 3)
        Variance of place, covariance, variance of speed.
    places, cost : ndarray, shape (m, d) and (m,)
        The places, and what speaks against them.
    substrate_velocity : ndarray, shape (d,)
        The commonest speed.
    spread : tuple of float
        Variances of a place, of the acceleration and of an unknown speed.
    gate : tuple of float
        As for :func:`_mutual`.

    Returns
    -------
    detection_indices : ndarray of int, shape (m,)
        The places: first those that go on a chain, then those that begin one.
    chain : ndarray of int
        The chain that each of the first goes on.
    at, speed, var : ndarray
        Of the chains that there are now, in the order of ``detection_indices``.
    """
    (noise, q, unknown), (rows, d), columns = spread, at.shape, len(places)
    ahead, wide, square = at + speed, np.empty((rows, 3)), np.zeros((rows, columns))
    for r in range(rows):
        v0, v1, v2 = var[r, 0], var[r, 1], var[r, 2]
        wide[r, 0], wide[r, 1], wide[r, 2] = v0 + 2 * v1 + v2 + q / 4, v1 + v2 + q / 2, v2 + q
        for c in range(columns):
            for i in range(d):
                square[r, c] += (places[c, i] - ahead[r, i]) ** 2
            square[r, c] = square[r, c] / (wide[r, 0] + noise) + 2.0 * cost[c]
    taken = _mutual(square, gate)
    detection_indices, chain, old = np.empty(columns, np.int64), np.empty(columns, np.int64), 0
    for c in range(columns):
        if taken[c] >= 0:
            detection_indices[old], chain[old] = c, taken[c]
            old += 1
    count = old
    for c in range(columns):
        if taken[c] < 0:
            detection_indices[count] = c
            count += 1
    now, going, spreads = np.empty((columns, d)), np.empty((columns, d)), np.empty((columns, 3))
    for k, mine in enumerate(detection_indices):
        if k >= old:
            for i in range(d):
                now[k, i], going[k, i] = places[mine, i], substrate_velocity[i]
            spreads[k, 0], spreads[k, 1], spreads[k, 2] = noise, 0.0, unknown
            continue
        r = chain[k]
        gain, gain_v = wide[r, 0] / (wide[r, 0] + noise), wide[r, 1] / (wide[r, 0] + noise)
        for i in range(d):
            step = places[mine, i] - ahead[r, i]
            now[k, i], going[k, i] = ahead[r, i] + gain * step, speed[r, i] + gain_v * step
        spreads[k, 0], spreads[k, 1] = wide[r, 0] * (1.0 - gain), wide[r, 1] * (1.0 - gain)
        spreads[k, 2] = wide[r, 2] - gain_v * wide[r, 1]
    return detection_indices, chain[:old], now, going, spreads


def _pieces(
    rows: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], n_chains: int
) -> list[Tracklet]:
    """Gather the tracklets from the numbers, picks, positions and costs of every frame."""
    if not rows:
        return []
    ids = np.concatenate([row[0] for row in rows])
    frame = np.repeat(np.arange(len(rows)), [len(row[0]) for row in rows])
    order = np.argsort(ids, kind="stable")
    detection_indices, at, cost = (
        np.concatenate([row[k] for row in rows])[order] for k in (1, 2, 3)
    )
    edge = np.searchsorted(ids[order], np.arange(n_chains + 1)).tolist()
    first = frame[order]
    return [
        Tracklet(int(first[a]), detection_indices[a:b].tolist(), at[a:b], cost[a:b])
        for a, b in itertools.pairwise(edge)
    ]


@compiled
def _mutual(square: np.ndarray, gate: tuple[float, float, float, float]) -> np.ndarray:
    """Return for each column the row that it alone belongs to, or -1.

    A pair belongs together if each is the other's nearest within the gate and the next
    nearest of either is clearly farther: by more than ``clear``, or by ``far`` and ``factor``
    times where the nearest is near.
    """
    (nearby, clear, factor, far), (rows, columns) = gate, square.shape
    taken = np.full(columns, -1)
    for c in range(columns if rows else 0):
        r, nearest = 0, 0
        for other in range(rows):
            if square[other, c] < square[r, c]:
                r = other
        for other in range(columns):
            if square[r, other] < square[r, nearest]:
                nearest = other
        best = square[r, c]
        if best > nearby or nearest != c:
            continue
        next_best = np.inf
        for other in range(columns):
            if other != c:
                next_best = min(next_best, square[r, other])
        for other in range(rows):
            if other != r:
                next_best = min(next_best, square[other, c])
        if next_best >= min(best + clear, factor * best + far):
            taken[c] = r
    return taken


def total_costs(tracklets: Sequence[Tracklet]) -> FloatArray:
    """Return the summed costs (tracklets,) of the places of each tracklet."""
    if not tracklets:
        return np.zeros(0)
    first = np.cumsum([0, *(len(tracklet.cost) for tracklet in tracklets[:-1])])
    return np.asarray(
        np.add.reduceat(np.concatenate([tracklet.cost for tracklet in tracklets]), first)
    )


def joined(tracklets: Sequence[Tracklet]) -> tuple[IntArray, FloatArray, IntArray]:
    """Return all tracklets one after another.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        The tracklets, at least one.

    Returns
    -------
    frame : ndarray of int, shape (k,)
        Frame of each place.
    at : ndarray, shape (k, d)
        The places.
    first : ndarray of int, shape (tracklets,)
        Where each tracklet begins.
    """
    first = np.concatenate(
        [[0], np.cumsum([len(tracklet.detection_indices) for tracklet in tracklets])[:-1]]
    )
    frame = np.concatenate(
        [tracklet.first + np.arange(len(tracklet.detection_indices)) for tracklet in tracklets]
    )
    return frame, np.concatenate([tracklet.at for tracklet in tracklets]), first
