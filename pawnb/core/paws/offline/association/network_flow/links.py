"""What may follow what: the links between tracklets, and what each costs.

Two tracklets are linked by the least acceleration that joins their ends, with the cost of being
occluded between them; a few successors of each are worth considering. Links to and from the places
of points that were placed by hand come besides.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, total_costs
from pawnb.core.sorting_kernels import ascending


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
    substrate_velocity: FloatArray
    occlusion_onset_cost: float
    occlusion_frame_cost: float
    max_occlusion: int
    max_successors: int


class _TrackletEnds(NamedTuple):
    """Position, speed and its variance at one end of every tracklet."""

    frame: np.ndarray  # (n,)
    x: np.ndarray  # (n, d)
    v: np.ndarray  # (n, d)
    var: np.ndarray  # (n,)

    @classmethod
    def of(cls, nodes: Sequence[Tracklet], costs: FlowCosts, *, head: bool) -> _TrackletEnds:
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
    tails: _TrackletEnds,
    heads: _TrackletEnds,
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
    return min(12 * costs.noise**2 / (n * (n**2 - 1)), costs.speed**2)


def links_between(
    nodes: Sequence[Tracklet], owner: IntArray, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links worth considering.

    Parameters
    ----------
    nodes : sequence of Tracklet
        Tracklets, and the anchors of all points.
    owner : ndarray of int, shape (n,)
        Point whose anchor each is, -1 for a tracklet.
    costs : FlowCosts
        What paths cost.

    Returns
    -------
    list of tuple
        From, to and cost of each.
    """
    heads, tails = (
        _TrackletEnds.of(nodes, costs, head=True),
        _TrackletEnds.of(nodes, costs, head=False),
    )
    order = np.argsort(heads.frame, kind="stable")
    starts = heads.frame[order]
    low = np.searchsorted(starts, tails.frame + 1)
    high = np.searchsorted(starts, tails.frame + costs.max_occlusion, side="right")
    lasts = np.array([len(node.detection_indices) for node in nodes])
    worth = costs.occlusion_frame_cost * lasts - total_costs(nodes)
    worth = np.minimum(worth, NETWORK_FLOW.most_worth)
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
    tails: _TrackletEnds,
    heads: _TrackletEnds,
    order: np.ndarray,
    within: np.ndarray,
    owner: np.ndarray,
    worth: np.ndarray,
    max_successors: int,
    costs: tuple[float, float, float, float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cheapest links from each tracklet: from, to and cost.

    Parameters
    ----------
    tails, heads : _TrackletEnds
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
    most = n * (max_successors + int((owner >= 0).sum()))
    tail, head, price = np.empty(most, np.int64), np.empty(most, np.int64), np.empty(most)
    count = 0
    for i in range(n):
        low, high = within[i, 0], within[i, 1]
        cost, net_cost = np.empty(max(high - low, 0)), np.empty(max(high - low, 0))
        for k in range(len(cost)):
            j = order[low + k]
            cost[k], net_cost[k] = (
                _link_cost(tails, heads, i, j, q, r, onset, each, vague),
                np.inf,
            )
            if owner[i] < 0 or owner[j] < 0 or owner[j] == owner[i]:
                # long good tracklets first: a place nearby is worth little if it leads nowhere
                net_cost[k] = cost[k] - worth[j]
        for rank, k in enumerate(ascending(net_cost)):
            j = order[low + k]
            if net_cost[k] < np.inf and (rank < max_successors or owner[j] >= 0):
                tail[count], head[count], price[count] = i, j, cost[k]
                count += 1
    return tail[:count], head[:count], price[:count]


def _long_links(
    nodes: Sequence[Tracklet], owner: IntArray, costs: FlowCosts
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


def first_links(first: IntArray, begin: int, costs: FlowCosts) -> list[tuple[int, int, float]]:
    """Return the links of a point that may begin with any early tracklet.

    Parameters
    ----------
    first : ndarray of int, shape (tracklets,)
        Their first frames.
    begin : int
        The node at which the point begins.
    costs : FlowCosts
        What paths cost.

    Returns
    -------
    list of tuple
        From, to and cost of each.
    """
    return [
        (begin, i, costs.occlusion_onset_cost + costs.occlusion_frame_cost * (frames - 1))
        for i, frames in enumerate(first.tolist()) if 0 < frames <= costs.max_occlusion
    ]  # fmt: skip


def links_back(
    first: IntArray, begin: int, ahead: Sequence[int], *, costs: FlowCosts
) -> list[tuple[int, int, float]]:
    """Return the links of a point of which nothing is known in frame 0.

    To be occluded before costs as much as to be occluded after the last.

    Parameters
    ----------
    first : ndarray of int, shape (k,)
        The first frames of nodes with which it may begin.
    begin : int
        The node at which the point begins.
    ahead : sequence of int
        These nodes.
    costs : FlowCosts
        What paths cost.

    Returns
    -------
    list of tuple
        From, to and cost of each.
    """
    cost = np.where(first > 0, costs.occlusion_onset_cost + costs.occlusion_frame_cost * first, 0.0)
    return [(begin, i, own) for i, own in zip(ahead, cost.tolist(), strict=True)]
