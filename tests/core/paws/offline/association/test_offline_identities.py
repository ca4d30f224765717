"""Tracklets are given to points jointly: by velocity, by looks, one name each."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, milp

from pawnb.core.paws.offline.association import identities
from pawnb.core.paws.offline.association.identities import TrackletGraph
from pawnb.core.paws.offline.association.tracklets import ViewTracklet
from pawnb.core.paws.offline.parameters import IdentityParameters

RADIUS = 2.5
N = 40
LEFT, RIGHT = 0, 1


def tracklet(begin, end, at, step):
    places = np.array(at, float) + np.outer(np.arange(end - begin + 1), step)
    return ViewTracklet(begin, places, np.array(step, float), np.array(step, float))


def graph_of(tracklets, clicked, parameters=None):
    return TrackletGraph(
        tracklets, clicked, n=N, radius=RADIUS, parameters=parameters or IdentityParameters()
    )


def given(tracklets, gains, clicked):
    return graph_of(tracklets, clicked).decide(np.array(gains, float)).tolist()


@pytest.fixture
def crossing():
    """Two that cross about row 20: before it, the first goes right and the second left."""
    return [
        tracklet(0, 18, (10, 10), (1, 0)),
        tracklet(0, 18, (50, 10), (-1, 0)),
        tracklet(22, 39, (32, 10), (1, 0)),
        tracklet(22, 39, (28, 10), (-1, 0)),
    ]


def test_legs_that_look_alike_pass_each_other_and_do_not_turn_back(crossing):
    gains = np.full((4, 2), 3.0)
    assert given(crossing, gains, {0: LEFT, 1: RIGHT}) == [LEFT, RIGHT, LEFT, RIGHT]
    assert given(crossing, gains, {2: LEFT, 3: RIGHT}) == [LEFT, RIGHT, LEFT, RIGHT]


def test_looks_that_are_clear_enough_say_that_they_turned_back(crossing):
    """What was learnt of either outweighs velocity; without clicks afterwards nothing else does."""
    gains = [[3, 3], [3, 3], [-20, 20], [20, -20]]
    assert given(crossing, gains, {0: LEFT, 1: RIGHT}) == [LEFT, RIGHT, RIGHT, LEFT]


def test_a_click_after_they_met_decides_what_lies_before_the_next_meeting(crossing):
    gains = np.full((4, 2), 3.0)
    found = given(crossing, gains, {0: LEFT, 1: RIGHT, 2: RIGHT})
    assert found == [LEFT, RIGHT, RIGHT, LEFT]


def test_a_tracklet_belongs_to_one_point():
    """Only one of two legs is seen from row 20 on: the other is hidden, and takes nothing."""
    some = [
        tracklet(0, 18, (10, 10), (1, 0)),
        tracklet(0, 18, (50, 10), (-1, 0)),
        tracklet(20, 39, (30, 10), (1, 0)),
    ]
    assert given(some, np.full((3, 2), 3.0), {0: LEFT, 1: RIGHT}) == [LEFT, RIGHT, LEFT]


def test_what_is_no_point_is_left_out():
    some = [tracklet(0, 39, (10, 10), (0, 0)), tracklet(5, 30, (40, 15), (0, 0))]
    assert given(some, [[3.0], [-4.0]], {0: 0}) == [0, -1]


def test_the_end_of_one_may_be_seen_after_the_next_has_begun():
    some = [tracklet(0, 20, (10, 10), (1, 0)), tracklet(19, 39, (29, 10), (1, 0))]
    assert given(some, [[3.0], [1.0]], {0: 0}) == [0, 0]


def test_a_click_decides_though_its_tracklet_begins_before_the_last_one_has_ended():
    """The point jumps: nothing but the clicks joins the two, and none of them may be lost."""
    some = [tracklet(0, 20, (10, 10), (1, 0)), tracklet(20, 39, (60, 15), (0, 0))]
    assert given(some, np.full((2, 2), 3.0), {0: LEFT, 1: LEFT}) == [LEFT, LEFT]


def test_without_tracklets_nothing_is_given():
    assert given([], np.empty((0, 2)), {}) == []


@pytest.fixture
def asked(monkeypatch):
    """What solvers were asked for: whether flows must be integers."""
    asked = []
    monkeypatch.setattr(
        identities, "milp", lambda cost, **k: asked.append("integrality" in k) or milp(cost, **k)
    )
    return asked


def test_where_the_linear_relaxation_is_integer_no_integer_programme_is_solved(crossing, asked):
    """Both looks say that the first is the left one: the cheapest paths share it."""
    gains = [[5, 4], [3, 3], [3, 3], [3, 3]]
    assert given(crossing, gains, {1: RIGHT}) == [LEFT, RIGHT, LEFT, RIGHT]
    assert given(crossing[:1], [[5, 4]], {}) == [LEFT]
    assert asked == [False]


def test_where_the_cheapest_paths_share_no_tracklet_nothing_is_solved(crossing, asked):
    gains = np.full((4, 2), 3.0)
    assert given(crossing, gains, {0: LEFT, 1: RIGHT}) == [LEFT, RIGHT, LEFT, RIGHT]
    assert asked == []


@pytest.mark.slow
def test_cheapest_paths_are_those_that_an_integer_programme_finds(crossing, monkeypatch):
    """HiGHS, for 100 draws of gains; in some of them the cheapest paths share a tracklet."""
    some = [*crossing, tracklet(5, 30, (20, 15), (0.3, 0)), tracklet(17, 21, (28, 10), (1, 0))]
    each = 4 * np.random.default_rng(1).standard_normal((100, len(some), 3))
    graph, solved = graph_of(some, {}), []
    expected = []
    for gains in each:
        share = identities._solve(graph.arcs, gains, 3)
        expected.append(np.where(share.max(axis=1) > 0.5, share.argmax(axis=1), -1))
    solve = identities._solve
    monkeypatch.setattr(identities, "_solve", lambda *a: solved.append(1) or solve(*a))
    np.testing.assert_array_equal([graph.decide(gains) for gains in each], expected)
    assert 0 < len(solved) < 100


def test_where_the_linear_relaxation_is_not_integer_the_integer_programme_is_solved():
    """Of three of which any two exclude each other: halves of all three are the cheapest."""
    pairs = LinearConstraint(np.array([[1, 1, 0], [0, 1, 1], [1, 0, 1]]), ub=1.0)
    cost = np.array([-1.0, -1.0, -1.2])
    found = identities._cheapest(cost, np.ones(3, int), [pairs])
    assert found == pytest.approx([0, 0, 1])
    assert identities._cheapest(cost, np.zeros(3, int), [pairs]) == pytest.approx([0.5, 0.5, 0.5])


@pytest.mark.slow
@pytest.mark.parametrize("more", [0.0, 1.0, 3.0, 20.0])
def test_names_are_as_sure_as_gains_tell_them_apart(more):
    """Of two paths the one that gains ``more`` is drawn in 1 of 1 + exp(-more / scale) samples.

    That is the Gumbel-max trick: Papandreou & Yuille 2011, section 2.
    """
    parameters = IdentityParameters(samples=1000)
    graph = graph_of([tracklet(0, N - 1, (10, 10), (1, 0))], {}, parameters)
    gains = np.array([[100.0 + more, 100.0]])
    names = graph.decide(gains)
    assert more == 0 or names.tolist() == [LEFT]
    share = graph.name_shares(gains, names)[0]
    assert share == pytest.approx(1 / (1 + np.exp(-more * parameters.alike)), abs=0.04)


def test_a_click_leaves_no_doubt_of_its_tracklet_and_little_of_what_continues_it(crossing):
    gains = np.full((4, 2), 3.0)
    graph = graph_of(crossing, {0: LEFT, 1: RIGHT})
    shares = graph.name_shares(gains, graph.decide(gains))
    np.testing.assert_allclose(shares[:2], 1.0)
    assert (shares > 0.8).all()


def test_names_that_velocity_and_looks_contradict_are_not_sure(crossing):
    """Looks say that they turned back, by about as much as velocity says that they did not."""
    graph = graph_of(crossing, {0: LEFT, 1: RIGHT})
    clear = np.full((4, 2), 3.0)
    unclear = clear + np.array([[0, 0], [0, 0], [-1, 1], [1, -1]]) * least_to_turn(graph)
    shares = graph.name_shares(unclear, graph.decide(unclear))
    assert (shares[2:] < 0.9).all()


def least_to_turn(graph):
    """Return what looks must gain for names to be exchanged where two cross, by halving."""
    low, high = 0.0, 100.0
    for _ in range(20):
        middle = (low + high) / 2
        gains = np.full((4, 2), 3.0) + np.array([[0, 0], [0, 0], [-1, 1], [1, -1]]) * middle
        turned = graph.decide(gains).tolist() == [LEFT, RIGHT, RIGHT, LEFT]
        low, high = (low, middle) if turned else (middle, high)
    return high
