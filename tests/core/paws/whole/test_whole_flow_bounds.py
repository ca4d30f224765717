"""Links left out by bounds: the cheapest paths, found by trying all, never need them."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.paws.whole.flow import _optimum
from pawnb.core.paws.whole.flow_bounds import useful_links


def network(seed, n_points, n_nodes, needed):
    """Links between nodes in order, with whole-numbered costs for each point; begins come first."""
    rng = np.random.default_rng(seed)
    rows, cost = [], []
    need = np.zeros(n_points + n_nodes, bool)
    need[n_points + rng.permutation(n_nodes)[:needed]] = True
    owner = {int(i): int(rng.integers(n_points)) for i in np.flatnonzero(need)}
    for p in range(n_points):
        nodes = [p, *range(n_points, n_points + n_nodes)]
        nodes = [i for i in nodes if owner.get(i, p) == p]
        for k, i in enumerate(nodes):
            rows.append((p, i, -1))
            cost.append(rng.integers(0, 30))
            for j in nodes[k + 1 :]:
                if rng.random() < 0.6 or need[j]:
                    rows.append((p, i, j))
                    cost.append(rng.integers(-10, 20))
    return np.array(rows), np.array(cost, float), np.arange(n_points), need


def paths(rows, cost, point, at):
    """Every path of a point from a node on: cost and links."""
    for a in np.flatnonzero((rows[:, 0] == point) & (rows[:, 1] == at)).tolist():
        if rows[a, 2] < 0:
            yield cost[a], [a]
        else:
            for more, links in paths(rows, cost, point, rows[a, 2]):
                yield cost[a] + more, [a, *links]


def cheapest_by_trying_all(rows, cost, begin, need):
    best = np.inf
    every = [list(paths(rows, cost, p, i)) for p, i in enumerate(begin)]
    for chosen in itertools.product(*every):
        total = sum(own for own, _ in chosen)
        if total < best:
            passed = [rows[a, 2] for _, links in chosen for a in links if rows[a, 2] >= 0]
            if len(set(passed)) == len(passed) and need[passed].sum() == need.sum():
                best = total
    return best


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(1, 5), st.integers(0, 2))
def test_the_cheapest_paths_are_still_there(seed, n_points, n_nodes, needed):
    rows, cost, begin, need = network(seed, n_points, n_nodes, min(needed, n_nodes))
    expected = cheapest_by_trying_all(rows, cost, begin, need)
    if not np.isfinite(expected):
        return
    keep = useful_links(
        rows, cost, rank=np.arange(len(need)), begin=begin, need=need, price=np.zeros(len(need))
    )
    x = _optimum(rows[keep], cost[keep], begin, need)
    np.testing.assert_allclose(cost[keep] @ x, expected, atol=1e-6)


def test_most_links_of_a_large_network_are_left_out():
    rows, cost, begin, need = network(3, 4, 40, 3)
    order = np.random.default_rng(0).permutation(len(rows))
    rows, cost = rows[order], cost[order]
    by_point = np.argsort(rows[:, 0], kind="stable")
    rows, cost = rows[by_point], cost[by_point] + 0.01 * np.arange(len(rows))
    price = np.zeros(len(need))
    keep = useful_links(rows, cost, rank=np.arange(len(need)), begin=begin, need=need, price=price)
    assert keep.mean() < 0.5
    best = cost @ _optimum(rows, cost, begin, need)
    again = cost[keep] @ _optimum(rows[keep], cost[keep], begin, need)
    np.testing.assert_allclose(again, best, atol=1e-6)
    # pieces that nobody must pass have no negative price
    assert (price[~need] >= 0).all()
