"""Which tracklet is which point, decided for all points and the whole recording at once.

Every point takes a path through tracklets. A tracklet belongs to one point at most; a path pays
for what appearance, motion from clicks and positional prior say against the name, for changes of
velocity from one tracklet to the next, and for every row in which the point is hidden. All paths
together are the cheapest ones: a multi-commodity flow (Zhang, Li & Nevatia 2008 for one commodity).
Where the cheapest path of each point by itself shares no tracklet with another, these are it; where
some do, it is solved by integer programming.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.parallel import on_threads
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.association.tracklets import ViewTracklet
from pawnb.core.paws.offline.parameters import IdentityParameters

_INTEGER_WITHIN = 1e-6
"""Numerics: a flow is 0 or 1 up to so much, HiGHS's own tolerance."""


@dataclass(frozen=True)
class _Arcs:
    """Arcs of the graph of one point: from one node to another at a cost."""

    source: IntArray
    target: IntArray
    cost: FloatArray
    tracklet: IntArray
    """The tracklet that is passed, or -1."""
    hidden: IntArray
    """Rows of the nodes at which the point is hidden; they come last."""


class TrackletGraph:
    """What paths of points through tracklets cost, beside what each tracklet gains.

    Parameters
    ----------
    tracklets : sequence of ViewTracklet
        N of them.
    clicked : mapping
        Tracklet to the point (column of gains) that was clicked in it.
    n : int
        Number of rows.
    radius : float
        About half a paw, in places.
    parameters : IdentityParameters
        The stage's parameters.
    """

    def __init__(
        self,
        tracklets: Sequence[ViewTracklet],
        clicked: Mapping[int, int],
        *,
        n: int,
        radius: float,
        parameters: IdentityParameters,
    ) -> None:
        self.clicked, self.parameters = clicked, parameters
        self.arcs = _graph(tracklets, n, radius, parameters)
        self.entering = _entering(self.arcs, tracklets)

    def decide(self, gains: FloatArray) -> IntArray:
        """Give tracklets to points.

        Parameters
        ----------
        gains : ndarray, shape (N, P)
            Log-likelihood of each being each point, beside its being none.

        Returns
        -------
        ndarray of int, shape (N,)
            The point, or -1.
        """
        return self._decide_each([gains])[0]

    def _decide_each(self, each: Sequence[FloatArray]) -> list[IntArray]:
        """Give tracklets to points, by each of several gains (N, P)."""
        gains = np.stack(each)
        n, n_points = gains.shape[1:]
        for tracklet, point in self.clicked.items():
            gains[:, tracklet] = -LINKS.click_worth
            gains[:, tracklet, point] = LINKS.click_worth
        alone = _paths_alone(self.arcs, self.entering, np.hstack(list(gains)))

        def decided(own: FloatArray, passed: BoolArray) -> IntArray:
            # what is cheapest without a limit and keeps it is so with it
            share = passed if (passed.sum(axis=1) <= 1).all() else _solve(self.arcs, own, n_points)
            best = share.argmax(axis=1)
            return np.where(share[np.arange(n), best] > 0.5, best, -1)

        return on_threads(
            lambda one: decided(*one), zip(gains, np.hsplit(alone, len(each)), strict=True)
        )

    def name_shares(self, gains: FloatArray, names: IntArray) -> FloatArray:
        """Return how often tracklets keep their names where gains are perturbed.

        Perturb-and-MAP (Papandreou & Yuille 2011, ICCV 193): the cheapest paths by gains with
        Gumbel noise are samples of all paths, by how likely they are. The noise is as large as a
        tracklet's errors of appearance: the inverse of ``alike``.

        Parameters
        ----------
        gains : ndarray, shape (N, P)
            As for :meth:`decide`.
        names : ndarray of int, shape (N,)
            What that decided.

        Returns
        -------
        ndarray, shape (N,)
            Share of the samples, and of the decision itself, in which the name is this one.
        """
        random = np.random.default_rng(0)
        scale = 1.0 / self.parameters.alike
        noisy = [
            gains + scale * random.gumbel(size=gains.shape) for _ in range(self.parameters.samples)
        ]
        kept = [names == sample for sample in [names, *self._decide_each(noisy)]]
        return np.mean(kept, axis=0)


def _graph(
    tracklets: Sequence[ViewTracklet], n: int, radius: float, parameters: IdentityParameters
) -> _Arcs:
    """Return the arcs: through tracklets, between them, and beside them while hidden.

    Nodes 2 i and 2 i + 1 are begin and end of tracklet i; after them comes a node for every row
    in which a tracklet begins or may be left: the point is hidden there. A tracklet may be left
    some rows before its end, as the next one may be seen before it has ended.
    """
    begins = np.array([one.begin for one in tracklets])
    ends = np.array([one.end for one in tracklets])
    left = np.maximum(begins, ends - LINKS.overlap_rows) + 1
    rows = np.unique(np.concatenate([begins, left, ends + 1, [0, n]]))
    first = 2 * len(tracklets)
    at_row = {int(row): first + i for i, row in enumerate(rows)}
    arcs: list[tuple[int, int, float, int]] = [
        (2 * i, 2 * i + 1, 0.0, i) for i in range(len(tracklets))
    ]
    for before, after in itertools.pairwise(rows):
        hidden = parameters.hidden * float(after - before)
        arcs.append((at_row[int(before)], at_row[int(after)], hidden, -1))
    for i in range(len(tracklets)):
        enter = parameters.lost if begins[i] > 0 else 0.0
        leave = parameters.lost if ends[i] < n - 1 else 0.0
        arcs.append((at_row[int(begins[i])], 2 * i, enter, -1))
        after = int(left[i]) if ends[i] < n - 1 else n
        # the rows up to its end are paid for as hidden ones on the way
        leave -= parameters.hidden * (int(ends[i]) + 1 - after)
        arcs.append((2 * i + 1, at_row[after], leave, -1))
    arcs += _continuations(tracklets, begins, ends, radius, parameters)
    source, target, cost, through = map(np.array, zip(*arcs, strict=True))
    return _Arcs(source, target, cost, through, rows)


def _entering(arcs: _Arcs, tracklets: Sequence[ViewTracklet]) -> list[tuple[int, IntArray]]:
    """Return the arcs into each node, a node after all those that it is reached from.

    All arcs lead on in time, by the row of a node; that of a tracklet's end is its first row, as it
    may be left before its last one. Of one row, hidden comes first, and begins before ends.
    """
    first = 2 * len(tracklets)
    row = np.full(int(arcs.target.max()) + 1, -1)
    row[:first] = np.repeat([one.begin for one in tracklets], 2)
    hidden = arcs.hidden
    row[first:] = hidden
    kind = np.concatenate([np.tile([1, 2], len(tracklets)), np.zeros(len(hidden), int)])
    rank = np.empty(len(row), int)
    rank[np.lexsort((kind, row))] = np.arange(len(row))
    order = np.argsort(rank[arcs.target], kind="stable")
    target = arcs.target[order]
    begins = np.flatnonzero(np.diff(target, prepend=-1))
    return list(zip(target[begins].tolist(), np.split(order, begins[1:]), strict=True))


def _paths_alone(
    arcs: _Arcs, entering: Sequence[tuple[int, IntArray]], gains: FloatArray
) -> BoolArray:
    """Return which tracklets (N, K) the cheapest paths pass, each by gains (N, K) of its own."""
    n_tracklets, count = gains.shape
    cost = np.repeat(arcs.cost[:, None], count, axis=1)
    through = arcs.tracklet >= 0
    cost[through] -= gains[arcs.tracklet[through]]
    first, last = 2 * n_tracklets, int(arcs.target.max())
    total, via = np.zeros((last + 1, count)), np.zeros((last + 1, count), int)
    path = np.arange(count)
    for node, into in entering:
        sums = total[arcs.source[into]] + cost[into]
        best = sums.argmin(axis=0)
        via[node], total[node] = into[best], sums[best, path]
    passed = np.zeros((n_tracklets, count), bool)
    at = np.full(count, last)
    while len(path):
        arc = via[at, path]
        here = arcs.tracklet[arc]
        passed[here[here >= 0], path[here >= 0]] = True
        on = arcs.source[arc] != first  # hidden before the first row
        at, path = arcs.source[arc][on], path[on]
    return passed


def _continuations(
    tracklets: Sequence[ViewTracklet],
    begins: IntArray,
    ends: IntArray,
    radius: float,
    parameters: IdentityParameters,
) -> list[tuple[int, int, float, int]]:
    """Return arcs from tracklets to those that may continue them at their velocity."""
    start = LINKS.start_sd_radii * radius
    drift = max(_drift(tracklets), LINKS.drift_sd_radii * radius)
    turn = (LINKS.velocity_sd_radii * radius) ** 2 + drift**2
    first = np.array([one.places[0] for one in tracklets])
    first_step = np.array([one.first_step for one in tracklets])
    arcs = []
    for i, one in enumerate(tracklets):
        # where things meet the one that goes on may be seen before the other has ended
        later = np.flatnonzero(
            (begins > ends[i] - LINKS.overlap_rows) & (begins > begins[i]) & (ends > ends[i])
        )
        last = np.minimum(ends[i], begins[later] - 1)
        gap = (begins[later] - last)[:, None]
        left = one.places[last - one.begin]
        ahead = left + one.last_step * gap - first[later]
        back = first[later] - first_step[later] * gap - left
        square = ((ahead**2).sum(axis=1) + (back**2).sum(axis=1)) / 2
        variance = start**2 + (drift * gap[:, 0]) ** 2
        turned = ((one.last_step - first_step[later]) ** 2).sum(axis=1)
        cost = square / (2 * variance) + np.log(variance / start**2)
        cost += turned / (2 * turn * gap[:, 0]) + parameters.hidden * (gap[:, 0] - 1)
        for j in np.argsort(cost, kind="stable")[: LINKS.most_continuations]:
            if cost[j] < 2 * parameters.lost + parameters.hidden * gap[j, 0]:
                arcs.append((2 * i + 1, 2 * int(later[j]), float(cost[j]), -1))
    return arcs


def _drift(tracklets: Sequence[ViewTracklet]) -> float:
    """Return how far points stray from a constant velocity in a row, in places."""
    missed = [
        np.linalg.norm(
            one.places[2 * LINKS.ahead_rows :]
            - 2 * one.places[LINKS.ahead_rows : -LINKS.ahead_rows]
            + one.places[: -2 * LINKS.ahead_rows],
            axis=1,
        )
        for one in tracklets
        if len(one.places) > 2 * LINKS.ahead_rows
    ]
    return float(np.median(np.concatenate(missed))) / LINKS.ahead_rows if missed else 0.0


def _solve(arcs: _Arcs, gains: FloatArray, n_points: int) -> FloatArray:
    """Return 1 where the path of a point passes a tracklet, else 0, (N, P)."""
    n_arcs, n_nodes = len(arcs.cost), int(arcs.target.max()) + 1
    first = 2 * len(gains)
    through = np.flatnonzero(arcs.tracklet >= 0)
    cost = np.tile(arcs.cost, (n_points, 1))
    cost[:, through] -= gains[arcs.tracklet[through]].T
    arc = np.arange(n_arcs)
    rows, columns, values, supply = [], [], [], np.zeros(n_points * n_nodes)
    for point in range(n_points):
        rows += [point * n_nodes + arcs.source, point * n_nodes + arcs.target]
        columns += [point * n_arcs + arc] * 2
        values += [np.ones(n_arcs), -np.ones(n_arcs)]
        supply[point * n_nodes + first] = 1.0  # hidden before the first row, after the last one
        supply[point * n_nodes + n_nodes - 1] = -1.0
    flow = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(n_points * n_nodes, n_points * n_arcs),
    ).tocsr()
    owners = coo_array(
        (
            np.ones(n_points * len(through)),
            (
                np.tile(arcs.tracklet[through], n_points),
                (np.arange(n_points)[:, None] * n_arcs + through).ravel(),
            ),
        ),
        shape=(len(gains), n_points * n_arcs),
    ).tocsr()
    integer = np.zeros(n_points * n_arcs, int)
    integer[(np.arange(n_points)[:, None] * n_arcs + through).ravel()] = 1
    share = np.zeros((len(gains), n_points))
    limits = [LinearConstraint(flow, supply, supply), LinearConstraint(owners, ub=1.0)]
    found = _cheapest(cost.ravel(), integer, limits)
    if found is not None:
        share[arcs.tracklet[through]] = found.reshape(n_points, n_arcs)[:, through].T
    return share


def _cheapest(
    cost: FloatArray, integer: IntArray, limits: Sequence[LinearConstraint]
) -> FloatArray | None:
    """Return flows of 0 to 1 at the least cost, 0 or 1 where they must be; None if none is found.

    The optimum of the linear relaxation nearly always is an integer one, and no other costs less.
    It is found in a seventh of the time.
    """
    asked: dict[str, Any] = {"bounds": Bounds(0, 1), "constraints": limits}
    found = milp(cost, options={"presolve": False}, **asked).x
    if found is not None and (np.abs(found - np.rint(found))[integer > 0] < _INTEGER_WITHIN).all():
        return np.asarray(found)
    options = {"node_limit": LINKS.most_nodes, "mip_rel_gap": LINKS.solver_gap}
    found = milp(cost, integrality=integer, options=options, **asked).x
    return None if found is None else np.asarray(found)
