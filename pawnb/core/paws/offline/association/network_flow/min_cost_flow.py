"""Which tracklets belong to which point: the cheapest set of paths over the whole recording.

Every point goes from tracklet to tracklet, through all its anchors; between two tracklets it is
occluded. One that is not placed in the first frame begins wherever that is cheapest, as every
point ends. No tracklet belongs to two points. The sum of all costs is lowest over the whole
recording: a flow of several commodities, solved as a linear programme (whose solution is
whole-numbered in practice; where it is not, it is solved again in whole numbers).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.pruning import useful_links
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, total_costs
from pawnb.core.sorting_kernels import ascending

_LONGEST_S = 60.0
"""Resource: time, s, after which the best association so far is taken."""


@dataclass(frozen=True)
class FlowCosts:
    """What paths cost.

    Parameters
    ----------
    acceleration : float
        Standard deviation of the acceleration, length per frame squared.
    noise : float
        Standard deviation of a place.
    speed : float
        Standard deviation of an unknown speed, length per frame.
    substrate_velocity : ndarray, shape (d,)
        What an unknown speed is on average.
    occlusion_onset_cost, occlusion_frame_cost : float
        Cost of each gap, and of each frame in it.
    max_occlusion : int
        Frames after which a point must have come out again.
    max_successors : int
        Tracklets considered after each tracklet.
    """

    acceleration: float
    noise: float
    speed: float
    substrate_velocity: np.ndarray
    occlusion_onset_cost: float
    occlusion_frame_cost: float
    max_occlusion: int
    max_successors: int


class _Ends(NamedTuple):
    """Position, speed and its variance at one end of every tracklet."""

    frame: np.ndarray  # (n,)
    x: np.ndarray  # (n, d)
    v: np.ndarray  # (n, d)
    var: np.ndarray  # (n,)

    @classmethod
    def of(cls, nodes: Sequence[Tracklet], costs: FlowCosts, *, head: bool) -> _Ends:
        """Take the first or the last end of every tracklet."""
        ends = [node.end(costs.substrate_velocity, head=head) for node in nodes]
        return cls(
            np.array([node.first if head else node.last for node in nodes]),
            np.stack([end[0] for end in ends]),
            np.stack([end[1] for end in ends]),
            np.array([_speed_variance(end[2], costs) for end in ends]),
        )


@compiled
def _link_cost(
    tails: _Ends,
    heads: _Ends,
    i: int,
    j: int,
    q: float,
    r: float,
    occlusion_onset_cost: float,
    occlusion_frame_cost: float,
    vague: float,
) -> float:
    """Return the cost of going from the end of tracklet i to the beginning of tracklet j.

    The least squared acceleration that joins the two ends, in units of its variance: for
    a gap of g frames, ``12 |dx|^2 / g^3 + |dv|^2 / g`` with ``dx`` what the mean of both
    speeds does not explain. ``q`` is that variance and ``r`` the one of a place; ``vague`` is the
    weight of how wide they let it be.
    """
    gap, d = float(heads.frame[j] - tails.frame[i]), heads.x.shape[1]
    unsure = tails.var[i] + heads.var[j]
    var_v = q * gap + unsure
    var_x = q * gap**3 / 12 + 2 * r + unsure * gap**2 / 4
    away, turned = 0.0, 0.0
    for k in range(d):
        v0, v1 = tails.v[i, k], heads.v[j, k]
        away += (heads.x[j, k] - tails.x[i, k] - 0.5 * (v0 + v1) * gap) ** 2
        turned += (v1 - v0) ** 2
    occluded = occlusion_onset_cost + occlusion_frame_cost * (gap - 1) if gap > 1 else 0.0
    return 0.5 * (away / var_x + turned / var_v) + vague * d * np.log(var_x / (2 * r)) + occluded


def _speed_variance(n: int, costs: FlowCosts) -> float:
    """Return the variance of a speed estimated from n frames."""
    if n == 1:
        return costs.speed**2
    # a parabola tells its slope less well than a line does
    more = NETWORK_FLOW.parabola_variance if n >= NETWORK_FLOW.parabola_from else 1.0
    return min(12 * costs.noise**2 / (n * (n**2 - 1)) * more, costs.speed**2)


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
        self.edges = _edges(self.nodes, self.owner, costs)
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
            start, links = 0, _first_links(first, begin, self.costs)
        else:
            start, links = -1, _links_back(first, begin, ahead, self.costs)
        nowhere = np.zeros((1, len(self.costs.substrate_velocity)))
        self.nodes.append(Tracklet(start, [-2], nowhere, np.zeros(1)))
        self.owner = np.append(self.owner, point)
        self.edges += links
        return begin

    def assign(self, prior: np.ndarray | None = None) -> list[list[int]]:
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


def _edges(
    nodes: Sequence[Tracklet], owner: np.ndarray, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) worth considering."""
    heads, tails = _Ends.of(nodes, costs, head=True), _Ends.of(nodes, costs, head=False)
    order = np.argsort(heads.frame, kind="stable")
    starts = heads.frame[order]
    low = np.searchsorted(starts, tails.frame + 1)
    high = np.searchsorted(starts, tails.frame + costs.max_occlusion, side="right")
    lasts = np.array([len(node.detection_indices) for node in nodes])
    worth = np.minimum(
        costs.occlusion_frame_cost * lasts - total_costs(nodes), NETWORK_FLOW.most_worth
    )
    found = _cheapest(
        tails,
        heads,
        order,
        np.column_stack([low, high]),
        owner,
        worth,
        costs.max_successors,
        (
            costs.acceleration**2,
            costs.noise**2,
            costs.occlusion_onset_cost,
            costs.occlusion_frame_cost,
            NETWORK_FLOW.vague,
        ),
    )
    edges = list(zip(*(part.tolist() for part in found), strict=True))
    return edges + _long_links(nodes, owner, costs)


@compiled
def _cheapest(
    tails: _Ends,
    heads: _Ends,
    order: np.ndarray,
    within: np.ndarray,
    owner: np.ndarray,
    worth: np.ndarray,
    links: int,
    costs: tuple[float, float, float, float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cheapest links from each tracklet: from, to and cost.

    Parameters
    ----------
    tails, heads : _Ends
        Where tracklets end and begin.
    order, within : ndarray of int, shape (n,) and (n, 2)
        Tracklets in the order of their first frames, and which of these may follow each.
    owner, worth : ndarray, shape (n,)
        Point whose anchor each is, -1 for a tracklet, and what it is worth to go through it.
    max_successors : int
        Links kept from each; those to anchors come besides.
    costs : tuple of float
        See :func:`_link_cost`.
    """
    n, (q, r, onset, each, vague) = len(order), costs
    most = n * (links + int((owner >= 0).sum()))
    tail, head, price = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(most)
    count = 0
    for i in range(n):
        low, high = within[i, 0], within[i, 1]
        cost, dear = np.empty(max(high - low, 0)), np.empty(max(high - low, 0))
        for k in range(len(cost)):
            j = order[low + k]
            cost[k], dear[k] = (
                _link_cost(tails, heads, i, j, q, r, onset, each, vague),
                np.inf,
            )
            if owner[i] < 0 or owner[j] < 0 or owner[j] == owner[i]:
                # long good tracklets first: a place nearby is worth little if it leads nowhere
                dear[k] = cost[k] - worth[j]
        for rank, k in enumerate(ascending(dear)):
            j = order[low + k]
            if dear[k] < np.inf and (rank < links or owner[j] >= 0):
                tail[count], head[count], price[count] = i, j, cost[k]
                count += 1
    return tail[:count], head[:count], price[:count]


def _long_links(
    nodes: Sequence[Tracklet], owner: np.ndarray, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return links between anchors of a point that are farther apart than a gap may be.

    Without them nothing could be chosen where no tracklet leads from one to the next.
    """
    links = []
    for p in np.unique(owner[owner >= 0]):
        own = sorted(np.flatnonzero(owner == p).tolist(), key=lambda i: nodes[i].last)
        for i, j in itertools.pairwise(own):
            gap = nodes[j].first - nodes[i].last
            if gap > costs.max_occlusion:
                links.append(
                    (i, j, costs.occlusion_onset_cost + costs.occlusion_frame_cost * (gap - 1))
                )
    return links


def _first_links(first: np.ndarray, begin: int, costs: FlowCosts) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) of a point that may begin with any early tracklet.

    ``first`` (tracklets,) are their first frames.
    """
    return [
        (begin, i, costs.occlusion_onset_cost + costs.occlusion_frame_cost * (frames - 1))
        for i, frames in enumerate(first.tolist()) if 0 < frames <= costs.max_occlusion
    ]  # fmt: skip


def _links_back(
    first: np.ndarray, begin: int, ahead: Sequence[int], costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) of a point of which nothing is known in frame 0.

    It may begin with any of the nodes ``ahead``, whose first frames are ``first``. To be occluded
    before costs as much as to be occluded after the last.
    """
    cost = np.where(first > 0, costs.occlusion_onset_cost + costs.occlusion_frame_cost * first, 0.0)
    return [(begin, i, own) for i, own in zip(ahead, cost.tolist(), strict=True)]


def _solve(
    nodes: Sequence[Tracklet],
    owner: np.ndarray,
    edges: Sequence[tuple[int, int, float]],
    begin: np.ndarray,
    size: tuple[int, int],
    costs: FlowCosts,
    prior: np.ndarray | None,
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


def _optimum(what: np.ndarray, cost: np.ndarray, begin: np.ndarray, need: np.ndarray) -> np.ndarray:
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
    whole = np.zeros(len(cost))
    answer = milp(cost, constraints=constraints, bounds=Bounds(0, 1), integrality=whole)
    x = answer.x
    if x is None or np.abs(x - np.round(x)).max() > 1e-6:
        answer = milp(
            cost, constraints=constraints, bounds=Bounds(0, 1), integrality=np.ones(len(cost)),
            options={"mip_rel_gap": NETWORK_FLOW.solver_gap, "time_limit": _LONGEST_S},
        )  # fmt: skip
        x = answer.x
    return np.asarray(x)


def _follow(used: np.ndarray, begin: np.ndarray, n_tracklets: int) -> list[list[int]]:
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
