"""Links left out by bounds: the cheapest paths, found by trying all, never need them."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import milp

from pawnb.core.parameters import values_in_force
from pawnb.core.paws.offline.association.network_flow import min_cost_flow
from pawnb.core.paws.offline.association.network_flow.min_cost_flow import _optimum
from pawnb.core.paws.offline.association.network_flow.pruning import useful_links


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
    # tracklets that nobody must pass have no negative price
    assert (price[~need] >= 0).all()


CONTESTED = """
0,5,17,1772 0,17,22,2285 0,22,27,2189 0,27,40,35 0,40,43,1356 0,40,45,1861 0,0,5,82 0,43,-1,0
0,45,-1,0 1,4,6,25 1,4,10,372 1,6,14,1216 1,10,14,1124 1,14,18,714 1,18,21,1289 1,21,26,1742
1,26,30,23 1,26,36,647 1,30,31,37 1,31,34,82 1,31,41,1136 1,34,36,82 1,36,38,155 1,36,43,1603
1,38,39,870 1,39,44,501 1,41,42,1194 1,1,4,63 1,42,-1,0 1,43,-1,0 1,44,-1,350 2,7,8,18 2,8,9,9
2,9,15,1418 2,15,16,316 2,16,20,1658 2,20,23,132 2,23,25,1347 2,25,28,2229 2,28,32,502
2,28,33,682 2,28,34,733 2,28,37,959 2,32,33,12 2,32,41,1054 2,33,35,11 2,33,42,1461 2,34,41,1056
2,34,42,1498 2,35,41,993 2,37,41,878 2,41,42,370 2,2,7,512 2,2,15,1972 2,42,-1,0 3,4,6,108
3,6,12,331 3,7,8,30 3,8,9,11 3,9,11,24 3,11,12,23 3,12,13,115 3,13,19,3038 3,19,23,2110
3,19,24,3167 3,23,24,894 3,24,29,1552 3,29,30,656 3,29,32,850 3,29,33,965 3,29,39,1401
3,29,38,1193 3,29,37,1255 3,30,31,162 3,31,38,322 3,32,33,17 3,32,38,298 3,33,35,7 3,35,38,122
3,37,45,2455 3,38,39,130 3,39,44,229 3,3,4,272 3,3,7,518 3,3,11,773 3,44,-1,350 3,45,-1,0
"""
"""Links (point, from, to, ten times the cost) of a recording in which prices overshoot."""


def test_bounds_hold_where_prices_go_back_to_better_ones():
    # an upper bound was told from prices that had already been given up: nothing was kept
    table = np.array([[float(x) for x in link.split(",")] for link in CONTESTED.split()])
    rows, cost, begin = table[:, :3].astype(int), table[:, 3] / 10.0, np.arange(4)
    need = np.zeros(46, bool)
    keep = useful_links(rows, cost, rank=np.arange(46), begin=begin, need=need, price=np.zeros(46))
    best = cost @ _optimum(rows, cost, begin, need)
    again = cost[keep] @ _optimum(rows[keep], cost[keep], begin, need)
    np.testing.assert_allclose(again, best, atol=1e-6)


def passes_each_once(x, rows, begin, need):
    """Whether whole paths lead from where points begin to their ends, none over another's."""
    entered = np.bincount(rows[x > 0.5, 2][rows[x > 0.5, 2] >= 0], minlength=len(need))
    ends = [int(rows[k, 0]) for k in np.flatnonzero(x > 0.5) if rows[k, 2] < 0]
    return (
        entered.max() <= 1 and (entered[need] == 1).all() and sorted(ends) == [*range(len(begin))]
    )


@pytest.mark.parametrize("seed", [2, 28, 54, 76])  # whose relaxation is not whole-numbered
def test_a_large_programme_is_solved_over_the_links_of_its_relaxation(monkeypatch, seed):
    rows, cost, begin, need = network(seed, 4, 10, 3)
    best = cost @ _optimum(rows, cost, begin, need)
    small = dataclasses.replace(values_in_force(min_cost_flow.NETWORK_FLOW), solver_links=0)
    monkeypatch.setattr(min_cost_flow, "NETWORK_FLOW", small)
    asked = []
    monkeypatch.setattr(min_cost_flow, "milp", lambda c, **k: asked.append(len(c)) or milp(c, **k))
    x = _optimum(rows, cost, begin, need)
    assert len(asked) == 2
    assert asked[1] < asked[0]
    assert passes_each_once(x, rows, begin, need)
    assert cost @ x >= best - 1e-6


def test_where_these_links_do_not_suffice_paths_end_where_they_are_shared(monkeypatch):
    """As in a dog filmed indoors, with 41,000 links: asked for nothing, it was an error."""
    rows, cost, begin, need = network(2, 4, 10, 3)

    def whole_fails(c, **options):
        found = milp(c, **options)
        if options.get("integrality") is not None:
            found.x = None
        return found

    monkeypatch.setattr(min_cost_flow, "milp", whole_fails)
    x = _optimum(rows, cost, begin, need)
    assert np.bincount(rows[x > 0.5, 2][rows[x > 0.5, 2] >= 0]).max() <= 1
