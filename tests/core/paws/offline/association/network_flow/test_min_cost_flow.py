"""Tracklets and their choice: who goes where through crossings and gaps."""

import numpy as np

from pawnb.core.paws.offline.association.network_flow.links import FlowCosts
from pawnb.core.paws.offline.association.network_flow.min_cost_flow import MinCostFlow
from pawnb.core.paws.offline.association.network_flow.tracklets import (
    LinkingModel,
    Tracklet,
    build_tracklets,
    estimate_substrate_velocity,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses

COSTS = FlowCosts(0.5, 0.3, 2.0, np.zeros(2), 3.0, 2.0, 30, 16)
N = 40


def tracklet(path, first, last, cost=0.0):
    frames = np.arange(first, last + 1)
    return Tracklet(first, list(frames), path[first : last + 1], np.full(len(frames), cost))


def crossing():
    """Two points that run towards each other and go on, both occluded in frames 15 to 24."""
    t = np.arange(N, dtype=float)
    right = np.column_stack([t, np.zeros(N)])
    left = np.column_stack([39.0 - t, np.ones(N)])
    return right, left


def test_points_keep_their_way_through_a_hidden_crossing():
    right, left = crossing()
    tracklets = [tracklet(p, a, b) for p in (right, left) for a, b in ((1, 14), (25, 39))]
    flow = MinCostFlow(tracklets, {0: {0: right[0], 1: left[0]}}, N, COSTS)
    assert flow.assign() == [[0, 1], [2, 3]]


def test_a_later_anchor_decides_otherwise():
    right, left = crossing()
    tracklets = [tracklet(p, a, b) for p in (right, left) for a, b in ((1, 14), (25, 38))]
    anchors = {0: {0: right[0], 1: left[0]}, 39: {0: left[39], 1: right[39]}}
    assert MinCostFlow(tracklets, anchors, N, COSTS).assign() == [[0, 3], [2, 1]]


def test_no_piece_belongs_to_two_points():
    right, _ = crossing()
    flow = MinCostFlow([tracklet(right, 1, 39)], {0: {0: right[0], 1: right[0] + 0.5}}, N, COSTS)
    chains = flow.assign()
    assert sorted(len(chain) for chain in chains) == [0, 1]


def test_a_dear_piece_is_left_out_and_a_prior_moves_the_choice():
    right, _ = crossing()
    dear = tracklet(right, 1, 39, cost=5.0)
    assert MinCostFlow([dear], {0: {0: right[0]}}, N, COSTS).assign() == [[]]
    good = tracklet(right, 1, 39)
    flow = MinCostFlow([good], {0: {0: right[0], 1: right[0]}}, N, COSTS)
    assert flow.assign(np.array([[50.0], [0.0]])) == [[], [0]]
    assert flow.assign(np.array([[0.0], [50.0]])) == [[0], []]


def test_hiding_at_the_end_costs_as_much_as_anywhere():
    """Ten frames occluded cost 3 for the gap and 2 each, whether or not another place follows."""
    right, _ = crossing()
    begun = tracklet(right, 1, 29)
    for cost, taken in ((2.1, [0, 1]), (2.6, [0])):  # 21 or 26, and the link to it
        late = tracklet(right, 30, 39, cost=cost)
        assert MinCostFlow([begun, late], {0: {0: right[0]}}, N, COSTS).assign() == [taken]


def test_tracklets_follow_lone_points_and_break_where_two_come_close():
    rng = np.random.default_rng(0)
    right, left = crossing()
    left[:, 1] = 0.2
    places = [
        PointHypotheses(
            np.stack([right[t], left[t]]) + rng.normal(scale=0.02, size=(2, 2)), np.zeros(2)
        )
        for t in range(N)
    ]
    tracklets = build_tracklets(places, LinkingModel(0.1, 0.3, 2.0, np.zeros(2), 1.0))
    taken = [(p.first + i, pick) for p in tracklets for i, pick in enumerate(p.detection_indices)]
    assert sorted(taken) == [(t, k) for t in range(N) for k in range(2)]
    # each tracklet stays with one point: their places come in a fixed order
    assert all(len(set(p.detection_indices)) == 1 for p in tracklets)
    assert max(len(p.detection_indices) for p in tracklets) >= 15


def test_the_drift_is_the_commonest_step():
    rng = np.random.default_rng(1)
    places = []
    for t in range(60):
        substrate = np.array([[100.0, 0.0], [60.0, 5.0], [20.0, -3.0]]) - [1.5 * t, 0.0]
        places.append(
            PointHypotheses(np.vstack([substrate, rng.uniform(-50, 50, (2, 2))]), np.zeros(5))
        )
    substrate_velocity = estimate_substrate_velocity(places, within=0.3, longest=10.0)
    np.testing.assert_allclose(substrate_velocity, [-1.5, 0.0], atol=0.05)


def test_the_drift_is_told_by_dim_paws_where_there_are_no_others():
    """Two paws walk on ground that moves by 0.8; few of their places are good by themselves."""
    rng = np.random.default_rng(2)
    paws, aside = np.array([[100.0, 0.0], [60.0, 5.0]]), rng.uniform(-50, 50, (80, 2, 2))
    places = [
        PointHypotheses(
            np.vstack([paws - [0.8 * t, 0.0], aside[t]]), np.array([1.0, 0.8, 1.4, 1.4])
        )
        for t in range(80)
    ]
    np.testing.assert_allclose(
        estimate_substrate_velocity(places, within=0.3, longest=10.0), [-0.8, 0.0], atol=0.02
    )
    nothing = [PointHypotheses(at.at, np.full(4, 3.0)) for at in places]
    assert not estimate_substrate_velocity(nothing, within=0.3, longest=10.0).any()


def test_the_drift_is_told_better_over_some_frames_than_over_one():
    """Places err by more than the ground moves, and something keeps its place."""
    rng, error = np.random.default_rng(3), []
    for _ in range(10):
        places = []
        for t in range(120):
            substrate = np.array([[100.0, 0.0], [60.0, 5.0], [0.0, 8.0]]) - [0.5 * t, 0.0]
            substrate[2] = 0.0, 8.0
            places.append(PointHypotheses(substrate + rng.normal(0.0, 0.3, (3, 2)), np.zeros(3)))
        error.append(
            [
                np.linalg.norm(
                    estimate_substrate_velocity(places, within=1.0, longest=5.0, lag=lag)
                    - [-0.5, 0.0]
                )
                for lag in (1, 4)
            ]
        )
    once, often = np.mean(error, axis=0)
    assert often < 0.02 < 0.5 * once
    # where there are fewer frames it takes what there is
    two = [
        estimate_substrate_velocity(places[:2], within=1.0, longest=5.0, lag=lag)
        for lag in (1, 400)
    ]
    np.testing.assert_array_equal(*two)
    assert np.abs(two[0]).max() > 0.0


def test_anchors_farther_apart_than_a_gap_may_be_are_both_passed():
    right, _ = crossing()
    near = tracklet(right, 36, 38)
    costs = FlowCosts(0.5, 0.3, 2.0, np.zeros(2), 3.0, 2.0, 5, 16)
    flow = MinCostFlow([near], {0: {0: right[0]}, 35: {0: right[35]}}, N, costs)
    assert flow.assign() == [[0]]  # the tracklet is reached from the second anchor only


def test_points_placed_in_the_middle_are_followed_both_ways():
    right, left = crossing()
    tracklets = [tracklet(p, a, b) for p in (right, left) for a, b in ((0, 14), (25, 39))]
    # each in a frame of its own
    flow = MinCostFlow(tracklets, {18: {0: right[18]}, 20: {1: left[20]}}, N, COSTS)
    assert flow.assign() == [[0, 1], [2, 3]]


def test_one_point_may_be_placed_in_the_first_frame_and_another_later():
    right, left = crossing()
    tracklets = [tracklet(right, 1, 39), tracklet(left, 1, 14), tracklet(left, 25, 39)]
    flow = MinCostFlow(tracklets, {0: {0: right[0]}, 20: {1: left[20]}}, N, COSTS)
    assert flow.assign() == [[0], [1, 2]]


def test_hiding_at_the_start_costs_as_much_as_at_the_end():
    """The same as at the end: the ten frames before the first tracklet, or the tracklet there."""
    right, _ = crossing()
    later = tracklet(right, 10, 38)
    for cost, taken in ((2.1, [0, 1]), (2.6, [1])):  # 21 or 26, and the link from it
        early = tracklet(right, 0, 9, cost=cost)
        assert MinCostFlow([early, later], {39: {0: right[39]}}, N, COSTS).assign() == [taken]


def test_a_stranger_is_found_before_the_first_click():
    right, left = crossing()
    tracklets = [
        tracklet(right, 0, 29),
        tracklet(right, 31, 39),
        tracklet(left + np.array([0, 6]), 0, 39),
    ]
    assert MinCostFlow(tracklets, {30: {0: right[30]}}, N, COSTS, contralateral=1).assign() == [
        [0, 1],
        [2],
    ]


def test_an_anchor_that_no_piece_leads_to_is_passed():
    right, _ = crossing()
    costs = FlowCosts(0.5, 0.3, 2.0, np.zeros(2), 3.0, 2.0, 5, 16)
    tracklets = [tracklet(right, 0, 9), tracklet(right, 31, 39)]
    # twenty frames without a tracklet are more than the five that a gap may have
    assert MinCostFlow(tracklets, {30: {0: right[30]}}, N, costs).assign() == [[1]]
