"""Links that no cheapest set of paths can contain: found by bounds, left out before solving.

Without the rule that no tracklet belongs to two points, each point's cheapest path is quickly
found. A price on every tracklet that several points want takes the place of the rule
(Lagrangian relaxation: Held & Karp 1971, Math. Program. 1: 6-25): the sum of the cheapest
paths less the prices never costs more than the solution sought, and paths chosen one after
the other, none through another's tracklets, are never cheaper. A link whose use alone
costs more than what lies between these bounds is in no solution.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW

_DRAWN = 1e7
"""Numerics: a price below all that is charged, so that a path goes through a node it must."""
_PROGRESS, _PATIENCE, _UPPER_EVERY, _EQUAL, _LEAST_STEP, _FIRST_AIM = 0.01, 10, 4, 1e-9, 1e-3, 100.0
"""Numerics: how steps of the prices are shortened. The bounds hold whatever they are (each is that
of a dual or of a feasible solution): they only tell how soon the bounds are close."""


def useful_links(
    links: IntArray,
    cost: FloatArray,
    *,
    rank: IntArray,
    begin: IntArray,
    need: BoolArray,
    price: FloatArray,
) -> BoolArray:
    """Tell which links may be in a cheapest set of paths.

    Parameters
    ----------
    links : ndarray of int, shape (m, 3)
        Point, node from which and node to which each link leads, -1 for the end; those of
        one point after those of another.
    cost : ndarray, shape (m,)
        Their costs.
    rank : ndarray, shape (nodes,)
        An order of the nodes in which every link leads to a later one.
    begin : ndarray of int, shape (P,)
        The node at which each point begins.
    need : ndarray of bool, shape (nodes,)
        Nodes that must be passed.
    price : ndarray, shape (nodes,)
        A first guess at the price of each node, any; better ones are written into it.

    Returns
    -------
    ndarray of bool, shape (m,)
        The links worth considering; all of them where no bound was found.
    """
    order = np.lexsort((rank[links[:, 1]], links[:, 0]))
    first = np.searchsorted(links[order, 0], np.arange(len(begin) + 1))
    tail, head = np.ascontiguousarray(links[order, 1]), np.ascontiguousarray(links[order, 2])
    ordered = cost[order]
    lower, upper = _bounds(
        first, tail, head, ordered, begin, need, price, NETWORK_FLOW.pruning_rounds
    )
    slack = upper - lower + NETWORK_FLOW.pruning_exact * (1.0 + abs(lower))
    keep = np.empty(len(links), bool)
    keep[order] = _detours(first, tail, head, ordered, begin, price) <= slack
    return keep


@compiled
def _cheapest(
    tail: np.ndarray,
    head: np.ndarray,
    cost: np.ndarray,
    price: np.ndarray,
    closed: np.ndarray,
    begin: int,
) -> tuple[float, np.ndarray]:
    """Return the cost of one point's cheapest path, prices included, and its links from the end.

    ``closed`` (nodes,) are passed by others.
    """
    reached = np.full(len(price), np.inf)
    came = np.full(len(price), -1)
    reached[begin] = 0.0
    best, last = np.inf, -1
    for a in range(len(tail)):
        total = reached[tail[a]] + cost[a]
        h = head[a]
        if h < 0:
            if total < best:
                best, last = total, a
        elif not closed[h] and total + price[h] < reached[h]:
            reached[h], came[h] = total + price[h], a
    path = np.empty(len(price) + 1, np.int64)
    n = 0
    while last >= 0:
        path[n] = last
        n += 1
        last = came[tail[last]]
    return best, path[:n]


@compiled
def _one_by_one(
    first: np.ndarray,
    tail: np.ndarray,
    head: np.ndarray,
    cost: np.ndarray,
    begin: np.ndarray,
    need: np.ndarray,
    price: np.ndarray,
    leader: int,
) -> float:
    """Return the cost of paths chosen one after the other, infinite if a needed node is left."""
    closed = np.zeros(len(price), np.bool_)
    drawn = price.copy()
    for i in range(len(need)):
        if need[i]:
            drawn[i] = -_DRAWN
    total = 0.0
    for k in range(len(begin)):
        p = (leader + k) % len(begin)
        a, b = first[p], first[p + 1]
        _, path = _cheapest(tail[a:b], head[a:b], cost[a:b], drawn, closed, begin[p])
        if not len(path):
            return np.inf
        for link in path:
            total += cost[a + link]
            if head[a + link] >= 0:
                closed[head[a + link]] = True
    for i in range(len(need)):
        if need[i] and not closed[i]:
            return np.inf
    return total


@compiled
def _bounds(
    first: np.ndarray,
    tail: np.ndarray,
    head: np.ndarray,
    cost: np.ndarray,
    begin: np.ndarray,
    need: np.ndarray,
    price: np.ndarray,
    rounds: int,
) -> tuple[float, float]:
    """Return bounds of the solution's cost; the prices of the lower one are left in ``price``."""
    free = np.zeros(len(price), np.bool_)
    lower, upper, now = -np.inf, np.inf, price.copy()
    eager, since = 1.0, 0
    for k in range(rounds):
        passed = np.zeros(len(price))
        value = -now.sum()
        for p in range(len(begin)):
            a, b = first[p], first[p + 1]
            own, path = _cheapest(tail[a:b], head[a:b], cost[a:b], now, free, begin[p])
            value += own
            for link in path:
                if head[a + link] >= 0:
                    passed[head[a + link]] += 1.0
        since += 1
        if k == 0 or value > lower:
            if k == 0 or value - lower > _PROGRESS * (upper - lower):
                since = 0
            lower = value
            _copy(now, price)
        if k % _UPPER_EVERY == 0:
            upper = min(upper, _one_by_one(first, tail, head, cost, begin, need, now, k))
        step, square = _wanted(passed, now, need)
        if square == 0.0:
            # no tracklet is wanted twice, none with a price is left: this is the solution
            upper = min(upper, value)
        if square == 0.0 or upper - lower <= _EQUAL * (1.0 + abs(lower)) or eager < _LEAST_STEP:
            break
        if since == _PATIENCE:
            # too far each time: shorter steps, from the best prices
            eager, since = 0.5 * eager, 0
            _copy(price, now)
        aim = upper if np.isfinite(upper) else value + _FIRST_AIM
        _move(now, step, eager * max(aim - value, _LEAST_STEP) / square, need)
    return lower, upper


@compiled
def _wanted(passed: np.ndarray, price: np.ndarray, need: np.ndarray) -> tuple[np.ndarray, float]:
    """Return by how many points too many each node is passed, and the sum of the squares."""
    step, square = np.empty(len(passed)), 0.0
    for i in range(len(step)):
        step[i] = passed[i] - 1.0
        if step[i] < 0 and price[i] <= 0 and not need[i]:
            step[i] = 0.0
        square += step[i] ** 2
    return step, square


@compiled
def _move(price: np.ndarray, step: np.ndarray, far: float, need: np.ndarray) -> None:
    """Change prices; those of what need not be passed stay at least 0."""
    for i in range(len(price)):
        price[i] += far * step[i]
        if not need[i]:
            price[i] = max(price[i], 0.0)


@compiled
def _copy(values: np.ndarray, to: np.ndarray) -> None:
    """Copy values: this is quicker to compile than a slice."""
    for i in range(len(values)):
        to[i] = values[i]


@compiled
def _detours(
    first: np.ndarray,
    tail: np.ndarray,
    head: np.ndarray,
    cost: np.ndarray,
    begin: np.ndarray,
    price: np.ndarray,
) -> np.ndarray:
    """Return how much more a point's path through each link costs than its cheapest path."""
    more = np.empty(len(cost))
    for p in range(len(begin)):
        reached = np.full(len(price), np.inf)
        left = np.full(len(price), np.inf)
        reached[begin[p]] = 0.0
        for a in range(first[p], first[p + 1]):
            h = head[a]
            if h >= 0:
                reached[h] = min(reached[h], reached[tail[a]] + cost[a] + price[h])
        for a in range(first[p + 1] - 1, first[p] - 1, -1):
            h = head[a]
            after = cost[a] if h < 0 else cost[a] + price[h] + left[h]
            left[tail[a]] = min(left[tail[a]], after)
            more[a] = after + reached[tail[a]]
        for a in range(first[p], first[p + 1]):
            more[a] -= left[begin[p]]
    return more
