"""Which pieces belong to which point: the cheapest set of paths over the whole recording.

Every point starts at its anchor and goes from piece to piece; between two pieces it is
hidden. No piece belongs to two points. The sum of all costs is lowest over the whole
recording: a flow of several commodities, solved as a linear programme (whose solution is
whole-numbered in practice; where it is not, it is solved again in whole numbers).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array, csr_array

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
    hide: float
    stay: float
    longest_gap: int
    links: int


def link_cost(before: Tracklet, after: Tracklet, costs: FlowCosts) -> float:
    """Return the cost of going from one piece to a later one.

    The least squared acceleration that joins the two ends, in units of its variance: for
    a gap of g frames, ``12 |dx|^2 / g^3 + |dv|^2 / g`` with ``dx`` what the mean of both
    speeds does not explain.
    """
    gap = after.first - before.last
    x0, v0, n0 = before.end(head=False)
    x1, v1, n1 = after.end(head=True)
    q, r = costs.acceleration**2, costs.noise**2
    rv0, rv1 = (_speed_variance(n, costs) for n in (n0, n1))
    if n0 == 1:
        v0 = v1 * (n1 > 1)
    if n1 == 1:
        v1 = v0
    dx = x1 - x0 - 0.5 * (v0 + v1) * gap
    dv = v1 - v0
    var_x = q * gap**3 / 12 + 2 * r + (rv0 + rv1) * gap**2 / 4
    var_v = q * gap + rv0 + rv1
    d = len(dx)
    mismatch = 0.5 * (dx @ dx / var_x + dv @ dv / var_v)
    volume = 0.25 * d * np.log(var_x / (2 * r))
    hidden = (costs.hide + costs.stay * (gap - 1)) if gap > 1 else 0.0
    return float(mismatch + volume + hidden)


def _speed_variance(n: int, costs: FlowCosts) -> float:
    """Return the variance of a speed told from n frames."""
    if n == 1:
        return costs.speed**2
    return min(12 * costs.noise**2 / (n * (n**2 - 1)) * (2.0 if n >= 5 else 1.0), costs.speed**2)


def assign(
    pieces: Sequence[Tracklet],
    anchors: Mapping[int, Mapping[int, np.ndarray]],
    n_frames: int,
    costs: FlowCosts,
    *,
    prior: np.ndarray | None = None,
) -> list[list[int]]:
    """Choose the pieces of every point.

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
    prior : ndarray, shape (n_points, n_pieces), optional
        Further cost of each piece for each point.

    Returns
    -------
    list of list of int
        For each point the numbers of its pieces, in the order of time.
    """
    n_points = 1 + max(p for here in anchors.values() for p in here)
    fixed = [
        (t, p, Tracklet(t, [-2], np.asarray(at, float)[None], np.zeros(1)))
        for t, here in sorted(anchors.items()) for p, at in here.items()
    ]  # fmt: skip
    nodes = list(pieces) + [piece for _, _, piece in fixed]
    owner = np.full(len(nodes), -1)
    owner[len(pieces) :] = [p for _, p, _ in fixed]
    edges = _edges(nodes, owner, n_frames, costs)
    chosen = _solve(nodes, owner, edges, n_points, (n_frames, len(pieces)), costs, prior)
    return chosen


def _edges(
    nodes: Sequence[Tracklet], owner: np.ndarray, n_frames: int, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links (from, to, cost) worth considering."""
    first = np.array([node.first for node in nodes])
    order = np.argsort(first, kind="stable")
    starts = first[order]
    edges = []
    for i, node in enumerate(nodes):
        low = np.searchsorted(starts, node.last + 1)
        high = np.searchsorted(starts, node.last + costs.longest_gap, side="right")
        options = []
        for j in order[low:high]:
            if owner[i] >= 0 and owner[j] >= 0 and owner[i] != owner[j]:
                continue
            options.append((link_cost(node, nodes[j], costs), int(j)))
        options.sort()
        keep = options[: costs.links] + [o for o in options[costs.links :] if owner[o[1]] >= 0]
        edges += [(i, j, cost) for cost, j in keep]
    return edges


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
    begins = {}
    for i in range(n_pieces, n_nodes):
        begins.setdefault(int(owner[i]), i)
    columns, rows, values, objective, meaning = [], [], [], [], []
    count = 0
    for p in range(n_points):
        own = weight.copy()
        if prior is not None:
            own[:n_pieces] = own[:n_pieces] + prior[p]
        usable = (owner < 0) | (owner == p)
        ok = usable[tail] & usable[head]
        e = np.flatnonzero(ok)
        index = count + np.arange(len(e))
        # flow leaves its tail and enters its head
        rows += [p * n_nodes + tail[e], p * n_nodes + head[e]]
        columns += [index, index]
        values += [np.ones(len(e)), -np.ones(len(e))]
        objective.append(link[e] + own[head[e]])
        meaning.append(np.column_stack([np.full(len(e), p), tail[e], head[e]]))
        count += len(e)
        ends = np.flatnonzero(usable)
        index = count + np.arange(len(ends))
        rows.append(p * n_nodes + ends)
        columns.append(index)
        values.append(np.ones(len(ends)))
        left = np.array([n_frames - 1 - nodes[i].last for i in ends])
        objective.append(np.where(left > 0, costs.hide + costs.stay * left, 0.0))
        meaning.append(np.column_stack([np.full(len(ends), p), ends, np.full(len(ends), -1)]))
        count += len(ends)
    A = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(n_points * n_nodes, count),
    ).tocsr()
    b = np.zeros(n_points * n_nodes)
    for p, i in begins.items():
        b[p * n_nodes + i] = 1.0
    what = np.concatenate(meaning)
    cost = np.concatenate(objective)
    enters = np.flatnonzero(what[:, 2] >= 0)
    single = coo_array(
        (np.ones(len(enters)), (what[enters, 2], enters)), shape=(n_nodes, count)
    ).tocsr()
    # every anchor must be passed
    need = np.zeros(n_nodes)
    need[[i for i in range(n_pieces, n_nodes) if i not in begins.values()]] = 1.0
    x = _optimum(cost, A, b, single, need)
    return _follow(what[x > 0.5], begins, n_points, n_pieces)


def _optimum(
    cost: np.ndarray, A: csr_array, b: np.ndarray, single: csr_array, need: np.ndarray
) -> np.ndarray:
    """Return the cheapest whole-numbered flow."""
    constraints = [LinearConstraint(A, b, b), LinearConstraint(single, need, 1.0)]
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
