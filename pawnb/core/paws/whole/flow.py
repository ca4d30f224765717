"""Which pieces belong to which point: the cheapest set of paths over the whole recording.

Every point starts at its anchor and goes from piece to piece; between two pieces it is
hidden. No piece belongs to two points. The sum of all costs is lowest over the whole
recording: a flow of several commodities, solved as a linear programme (whose solution is
whole-numbered in practice; where it is not, it is solved again in whole numbers).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from pawnb.core.paws.whole.flow_bounds import useful_links
from pawnb.core.paws.whole.tracklets import Tracklet


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
    drift : ndarray, shape (d,)
        What an unknown speed is on average.
    hide, stay : float
        Cost of each gap, and of each frame in it.
    longest_gap : int
        Frames after which a point must have come out again.
    links : int
        Pieces considered after each piece.
    """

    acceleration: float
    noise: float
    speed: float
    drift: np.ndarray
    hide: float
    stay: float
    longest_gap: int
    links: int


@dataclass(frozen=True)
class _Ends:
    """Position, speed and its variance at one end of every piece."""

    frame: np.ndarray  # (n,)
    x: np.ndarray  # (n, d)
    v: np.ndarray  # (n, d)
    var: np.ndarray  # (n,)

    @classmethod
    def of(cls, nodes: Sequence[Tracklet], costs: FlowCosts, *, head: bool) -> _Ends:
        """Take the first or the last end of every piece."""
        ends = [node.end(costs.drift, head=head) for node in nodes]
        return cls(
            np.array([node.first if head else node.last for node in nodes]),
            np.stack([end[0] for end in ends]),
            np.stack([end[1] for end in ends]),
            np.array([_speed_variance(end[2], costs) for end in ends]),
        )


def link_costs(
    tails: _Ends, heads: _Ends, *, i: int, j: np.ndarray, costs: FlowCosts
) -> np.ndarray:
    """Return the costs of going from the end of piece i to the beginnings of pieces j.

    The least squared acceleration that joins the two ends, in units of its variance: for
    a gap of g frames, ``12 |dx|^2 / g^3 + |dv|^2 / g`` with ``dx`` what the mean of both
    speeds does not explain.
    """
    gap = (heads.frame[j] - tails.frame[i])[:, None].astype(float)
    v0, v1 = tails.v[i], heads.v[j]
    dx = heads.x[j] - tails.x[i] - 0.5 * (v0 + v1) * gap
    dv = v1 - v0
    gap = gap[:, 0]
    q, r = costs.acceleration**2, costs.noise**2
    var_v = q * gap + tails.var[i] + heads.var[j]
    var_x = q * gap**3 / 12 + 2 * r + (tails.var[i] + heads.var[j]) * gap**2 / 4
    mismatch = 0.5 * ((dx**2).sum(axis=1) / var_x + (dv**2).sum(axis=1) / var_v)
    volume = 0.15 * dx.shape[1] * np.log(var_x / (2 * r))
    hidden = np.where(gap > 1, costs.hide + costs.stay * (gap - 1), 0.0)
    return np.asarray(mismatch + volume + hidden)


def _speed_variance(n: int, costs: FlowCosts) -> float:
    """Return the variance of a speed told from n frames."""
    if n == 1:
        return costs.speed**2
    return min(12 * costs.noise**2 / (n * (n**2 - 1)) * (2.0 if n >= 5 else 1.0), costs.speed**2)


class Flow:
    """The choice of pieces; it can be made again with other costs of pieces.

    Parameters
    ----------
    pieces : sequence of Tracklet
        The pieces.
    anchors : mapping
        Frame to point number to position, certain; a point begins at its first.
    n_frames : int
        Number of frames.
    costs : FlowCosts
        What paths cost.
    strangers : int
        Further points, numbered after the others, that begin nobody knows where.
    """

    def __init__(
        self,
        pieces: Sequence[Tracklet],
        anchors: Mapping[int, Mapping[int, np.ndarray]],
        n_frames: int,
        costs: FlowCosts,
        *,
        strangers: int = 0,
    ) -> None:
        known = 1 + max(p for here in anchors.values() for p in here)
        self.n_points = known + strangers
        fixed = [
            (p, Tracklet(t, [-2], np.asarray(at, float)[None], np.zeros(1)))
            for t, here in sorted(anchors.items()) for p, at in here.items()
        ]  # fmt: skip
        self.nodes = [*pieces, *(piece for _, piece in fixed)]
        self.owner = np.full(len(self.nodes), -1)
        self.owner[len(pieces) :] = [p for p, _ in fixed]
        self.edges = _edges(self.nodes, self.owner, costs)
        nowhere = np.zeros((1, len(costs.drift)))
        for p in range(known, self.n_points):
            self.nodes.append(Tracklet(min(anchors), [-2], nowhere, np.zeros(1)))
            self.owner = np.append(self.owner, p)
            self.edges += _first_links(pieces, len(self.nodes) - 1, min(anchors), costs)
        self.size, self.costs = (n_frames, len(pieces)), costs

    def assign(self, prior: np.ndarray | None = None) -> list[list[int]]:
        """Choose the pieces of every point.

        Parameters
        ----------
        prior : ndarray, shape (n_points, n_pieces), optional
            Further cost of each piece for each point.

        Returns
        -------
        list of list of int
            For each point the numbers of its pieces, in the order of time.
        """
        return _solve(
            self.nodes, self.owner, self.edges, self.n_points, self.size, self.costs, prior
        )


def _edges(
    nodes: Sequence[Tracklet], owner: np.ndarray, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) worth considering."""
    heads, tails = _Ends.of(nodes, costs, head=True), _Ends.of(nodes, costs, head=False)
    order = np.argsort(heads.frame, kind="stable")
    starts = heads.frame[order]
    worth = np.array([min(costs.stay * len(n.picks) - n.cost.sum(), 30.0) for n in nodes])
    edges = []
    for i, node in enumerate(nodes):
        low = np.searchsorted(starts, node.last + 1)
        high = np.searchsorted(starts, node.last + costs.longest_gap, side="right")
        j = order[low:high]
        if owner[i] >= 0:
            j = j[(owner[j] < 0) | (owner[j] == owner[i])]
        if not len(j):
            continue
        cost = link_costs(tails, heads, i=i, j=j, costs=costs)
        # long good pieces first: a place nearby is worth little if it leads nowhere
        keep = np.argsort(cost - worth[j])
        keep = keep[(np.arange(len(j)) < costs.links) | (owner[j[keep]] >= 0)]
        edges += [(i, int(j[o]), float(cost[o])) for o in keep]
    return edges + _long_links(nodes, owner, costs)


def _long_links(
    nodes: Sequence[Tracklet], owner: np.ndarray, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return links between anchors of a point that are farther apart than a gap may be.

    Without them nothing could be chosen where no piece leads from one to the next.
    """
    links = []
    for p in np.unique(owner[owner >= 0]):
        own = sorted(np.flatnonzero(owner == p).tolist(), key=lambda i: nodes[i].last)
        for i, j in itertools.pairwise(own):
            gap = nodes[j].first - nodes[i].last
            if gap > costs.longest_gap:
                links.append((i, j, costs.hide + costs.stay * (gap - 1)))
    return links


def _first_links(
    pieces: Sequence[Tracklet], node: int, start: int, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) of a point that may begin with any early piece."""
    left = [(i, piece.first - start) for i, piece in enumerate(pieces)]
    return [
        (node, i, costs.hide + costs.stay * (frames - 1))
        for i, frames in left if 0 < frames <= costs.longest_gap
    ]  # fmt: skip


def _solve(
    nodes: Sequence[Tracklet],
    owner: np.ndarray,
    edges: Sequence[tuple[int, int, float]],
    n_points: int,
    size: tuple[int, int],
    costs: FlowCosts,
    prior: np.ndarray | None,
) -> list[list[int]]:
    """Solve the flow; return the pieces of each point."""
    n_frames, n_pieces = size
    n_nodes = len(nodes)
    weight = np.array([node.cost.sum() for node in nodes])
    tail = np.array([e[0] for e in edges], int)
    head = np.array([e[1] for e in edges], int)
    link = np.array([e[2] for e in edges])
    begins: dict[int, int] = {}
    for i in range(n_pieces, n_nodes):
        begins.setdefault(int(owner[i]), i)
    objective, meaning = [], []
    for p in range(n_points):
        own = weight.copy()
        if prior is not None:
            own[:n_pieces] = own[:n_pieces] + prior[p]
        usable = (owner < 0) | (owner == p)
        ok = usable[tail] & usable[head]
        e = np.flatnonzero(ok)
        objective.append(link[e] + own[head[e]])
        meaning.append(np.column_stack([np.full(len(e), p), tail[e], head[e]]))
        ends = np.flatnonzero(usable)
        left = np.array([n_frames - 1 - nodes[i].last for i in ends.tolist()])
        objective.append(np.where(left > 0, costs.hide + costs.stay * left, 0.0))
        meaning.append(np.column_stack([np.full(len(ends), p), ends, np.full(len(ends), -1)]))
    what, cost = np.concatenate(meaning), np.concatenate(objective)
    # every anchor must be passed
    need = np.zeros(n_nodes, bool)
    need[[i for i in range(n_pieces, n_nodes) if i not in begins.values()]] = True
    begin = np.array([begins[p] for p in range(n_points)])
    keep = useful_links(
        what, cost, rank=np.array([node.first for node in nodes]), begin=begin, need=need,
        price=np.zeros(n_nodes),
    )  # fmt: skip
    what, cost = what[keep], cost[keep]
    x = _optimum(what, cost, begin, need)
    return _follow(what[x > 0.5], begins, n_points, n_pieces)


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
            options={"mip_rel_gap": 1e-4, "time_limit": 60.0},
        )  # fmt: skip
        x = answer.x
    return np.asarray(x)


def _follow(
    used: np.ndarray, begins: Mapping[int, int], n_points: int, n_pieces: int
) -> list[list[int]]:
    """Read the pieces of each point off the links used (point, from, to)."""
    chosen = []
    for p in range(n_points):
        nexts = {int(i): int(j) for q, i, j in used if q == p}
        at, own = begins[p], []
        while at >= 0:
            if at < n_pieces:
                own.append(at)
            at = nexts.get(at, -1)
        chosen.append(own)
    return chosen
