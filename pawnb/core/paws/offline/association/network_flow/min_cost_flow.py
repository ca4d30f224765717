"""Which tracklets belong to which point: the cheapest set of paths over the whole recording.

Every point goes from tracklet to tracklet, through all its anchors; between two tracklets it is
occluded. One that is not placed in the first frame begins wherever that is cheapest, as every
point ends. No tracklet belongs to two points. The sum of all costs is lowest over the whole
recording: a flow of several commodities, solved as a linear programme (whose solution is
whole-numbered in practice; where it is not, it is solved again in whole numbers). How long that may
take is limited by its size and not by a clock, so that a busy machine gives the same tracks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.association.network_flow.links import (
    FlowCosts,
    first_links,
    links_back,
    links_between,
)
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.pruning import useful_links
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, total_costs

_WHOLE_WITHIN = 1e-6
"""Numerics: how far the solver's whole numbers may lie off them."""


class MinCostFlow:
    """The choice of tracklets; it can be made again with other costs of tracklets.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        The tracklets.
    anchors : mapping
        Frame to point number to position, certain; a point placed in frame 0 begins there.
    n_frames : int
        Number of frames.
    costs : FlowCosts
        What paths cost.
    contralateral : int
        Further points, numbered after the others, that begin nobody knows where.
    """

    def __init__(
        self,
        tracklets: Sequence[Tracklet],
        anchors: Mapping[int, Mapping[int, np.ndarray]],
        n_frames: int,
        costs: FlowCosts,
        *,
        contralateral: int = 0,
    ) -> None:
        known = 1 + max(p for here in anchors.values() for p in here)
        self.n_points = known + contralateral
        fixed = [
            (p, Tracklet(t, [-2], np.asarray(at, float)[None], np.zeros(1)))
            for t, here in sorted(anchors.items()) for p, at in here.items()
        ]  # fmt: skip
        self.nodes = [*tracklets, *(tracklet for _, tracklet in fixed)]
        self.owner = np.full(len(self.nodes), -1)
        self.owner[len(tracklets) :] = [p for p, _ in fixed]
        self.costs, self._is_begun = costs, 0 in anchors
        self.edges = links_between(self.nodes, self.owner, costs)
        self.begin = np.array([self._begin(p, len(tracklets)) for p in range(self.n_points)])
        self.size = (n_frames, len(tracklets))

    def _begin(self, point: int, n_tracklets: int) -> int:
        """Return the node at which a point begins: placed in the first frame, or nowhere."""
        own = np.flatnonzero(self.owner == point).tolist()
        if own and not self.nodes[own[0]].first:
            return int(own[0])
        begin, ahead = len(self.nodes), [*range(n_tracklets), *own[:1]]
        first = np.array([self.nodes[i].first for i in ahead])
        if self._is_begun and not own:
            # an unlabelled target is there with those that are placed
            start, links = 0, first_links(first, begin, self.costs)
        else:
            start, links = -1, links_back(first, begin, ahead, costs=self.costs)
        nowhere = np.zeros((1, len(self.costs.substrate_velocity)))
        self.nodes.append(Tracklet(start, [-2], nowhere, np.zeros(1)))
        self.owner = np.append(self.owner, point)
        self.edges += links
        return begin

    def assign(self, prior: FloatArray | None = None) -> list[list[int]]:
        """Choose the tracklets of every point.

        Parameters
        ----------
        prior : ndarray, shape (n_points, n_pieces), optional
            Further cost of each tracklet for each point.

        Returns
        -------
        list of list of int
            For each point the numbers of its tracklets, in the order of time.
        """
        return _solve(self.nodes, self.owner, self.edges, self.begin, self.size, self.costs, prior)


def _solve(
    nodes: Sequence[Tracklet],
    owner: IntArray,
    edges: Sequence[tuple[int, int, float]],
    begin: IntArray,
    size: tuple[int, int],
    costs: FlowCosts,
    prior: FloatArray | None,
) -> list[list[int]]:
    """Solve the flow; return the tracklets of each point."""
    n_frames, n_tracklets = size
    n_nodes = len(nodes)
    weight = total_costs(nodes)
    tail = np.array([e[0] for e in edges], int)
    head = np.array([e[1] for e in edges], int)
    link = np.array([e[2] for e in edges])
    objective, meaning = [], []
    for p in range(len(begin)):
        own = weight.copy()
        if prior is not None:
            own[:n_tracklets] = own[:n_tracklets] + prior[p]
        usable = (owner < 0) | (owner == p)
        ok = usable[tail] & usable[head]
        e = np.flatnonzero(ok)
        objective.append(link[e] + own[head[e]])
        meaning.append(np.column_stack([np.full(len(e), p), tail[e], head[e]]))
        ends = np.flatnonzero(usable)
        left = np.array([n_frames - 1 - nodes[i].last for i in ends.tolist()])
        objective.append(
            np.where(left > 0, costs.occlusion_onset_cost + costs.occlusion_frame_cost * left, 0.0)
        )
        meaning.append(np.column_stack([np.full(len(ends), p), ends, np.full(len(ends), -1)]))
    what, cost = np.concatenate(meaning), np.concatenate(objective)
    # every anchor must be passed
    need = np.zeros(n_nodes, bool)
    need[n_tracklets:] = True
    need[begin] = False
    keep = useful_links(
        what,
        cost,
        rank=np.array([node.first for node in nodes]),
        begin=begin,
        need=need,
        price=np.zeros(n_nodes),
    )
    what, cost = what[keep], cost[keep]
    x = _optimum(what, cost, begin, need)
    return _follow(what[x > 0.5], begin, n_tracklets)


def _optimum(what: IntArray, cost: FloatArray, begin: IntArray, need: BoolArray) -> FloatArray:
    """Return the cheapest whole-numbered flow through links (point, from, to), to -1 at the end."""
    n_nodes, column = len(need), np.arange(len(what))
    enters = np.flatnonzero(what[:, 2] >= 0)
    one = np.ones(len(enters))
    # flow leaves its tail and enters its head
    leaving, entering = what[:, 0] * n_nodes + what[:, 1], what[:, 0] * n_nodes + what[:, 2]
    A = coo_array(
        (
            np.concatenate([np.ones(len(what)), -one]),
            (np.concatenate([leaving, entering[enters]]), np.concatenate([column, enters])),
        ),
        shape=(len(begin) * n_nodes, len(what)),
    ).tocsr()
    b = np.zeros(len(begin) * n_nodes)
    b[np.arange(len(begin)) * n_nodes + begin] = 1.0
    single = coo_array((one, (what[enters, 2], enters)), shape=(n_nodes, len(what))).tocsr()
    constraints = [
        LinearConstraint(A, b, b), LinearConstraint(single, need.astype(float), 1.0),
    ]  # fmt: skip
    relaxed = milp(cost, constraints=constraints, bounds=Bounds(0, 1)).x
    if relaxed is None:
        return np.zeros(len(cost))
    if np.abs(relaxed - np.round(relaxed)).max() <= _WHOLE_WITHIN:
        return np.asarray(relaxed)
    # of a large programme only the links that its relaxation uses: all would take minutes
    is_small = len(cost) <= NETWORK_FLOW.solver_links
    used = np.flatnonzero((relaxed > _WHOLE_WITHIN) | is_small)
    found = milp(
        cost[used],
        constraints=[LinearConstraint(one.A[:, used], one.lb, one.ub) for one in constraints],
        bounds=Bounds(0, 1),
        integrality=np.ones(len(used)),
        options={
            "mip_rel_gap": NETWORK_FLOW.solver_gap,
            "node_limit": NETWORK_FLOW.solver_nodes,
        },
    ).x
    if found is None:  # paths then end where their links are shared by halves or less
        return np.asarray(relaxed)
    x = np.zeros(len(cost))
    x[used] = found
    return x


def _follow(used: IntArray, begin: IntArray, n_tracklets: int) -> list[list[int]]:
    """Read the tracklets of each point off the links used (point, from, to)."""
    chosen = []
    for p, first in enumerate(begin.tolist()):
        nexts = {int(i): int(j) for q, i, j in used if q == p}
        at, own = first, []
        while at >= 0:
            if at < n_tracklets:
                own.append(at)
            at = nexts.get(at, -1)
        chosen.append(own)
    return chosen
