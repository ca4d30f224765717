"""Where a point may be that is not seen: about its own part of the body, on no other's place."""

from dataclasses import replace

import numpy as np
from pipeline_states import known_state

from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.gap_closing import close_gaps
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.gap_closing.usual_region import (
    UsualRegion,
    add_region_cost,
    same_kind,
    usual_region,
)
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel

FLAT = MotionModel(
    acceleration=1.0, jerk=0.6, speed=12.0, substrate_velocity=np.zeros(2),
    axes=np.array([[1.0, 0.0], [0.0, -1.0]]), substrate=-1000.0, body_scale=100.0, paw_width=8.0,
)  # fmt: skip
SPACE = replace(FLAT, substrate_velocity=np.zeros(3), axes=np.eye(3))


def test_what_lies_beyond_costs_the_more_the_farther_it_is():
    region = UsualRegion(
        np.array([[1.0, 0.0]]), np.array([[10.0]]), np.array([[20.0]]), 2.0,
        np.empty((1, 0, 2)), 5.0, 3.0,
    )  # fmt: skip
    x = np.array([[10.0, 15.0, 20.0, 24.0, 4.0], [0.0, 90.0, -90.0, 0.0, 7.0]])
    cost = np.ones(5)
    add_region_cost(x, region, 0, cost)
    # a normal distribution: half the square of two and of three standard deviations
    np.testing.assert_allclose(cost - 1.0, [0.0, 0.0, 0.0, 2.0, 4.5])


def test_the_place_of_another_point_costs_and_one_that_nobody_knows_does_not():
    others = np.array([[[0.0, 0.0, 0.0], [np.nan, np.nan, np.nan]]])
    limit = np.full((1, 2), np.inf)
    region = UsualRegion(np.eye(3)[:2], -limit, limit, 1.0, others, 4.0, 3.0)
    x = np.array([[0.0, 0.0, 0.0, 30.0], [0.0, 3.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0]])
    cost = np.zeros(4)
    add_region_cost(x, region, 0, cost)
    np.testing.assert_allclose(cost, [3.0, 0.75, 0.0, 0.0])


def test_the_region_goes_with_the_body():
    n = 100
    body = np.column_stack([2.0 * np.arange(n), np.zeros(n), np.zeros(n)])
    swing = np.linspace(-10.0, 30.0, n)
    own = body + np.column_stack([swing, 5.0 + 0.1 * swing, np.zeros(n)])
    sure = np.stack([own, body], axis=1)
    sure[40:60, 0] = np.nan
    frames = np.arange(40, 60)
    region = usual_region(sure, body, 0, frames=frames, motion_model=SPACE)
    tail = GAP_CLOSING.region_tail
    known = np.delete(swing, frames)
    low, high = np.quantile(known, [tail, 1.0 - tail])
    ahead, aside = 100.0 * GAP_CLOSING.region_ahead, 100.0 * GAP_CLOSING.region_aside
    np.testing.assert_allclose(region.low[:, 0], 2.0 * frames + low - ahead)
    np.testing.assert_allclose(region.high[:, 0], 2.0 * frames + high + ahead)
    np.testing.assert_allclose(region.low[:, 1], 5.0 + 0.1 * low - aside)
    np.testing.assert_allclose(region.high[:, 1], 5.0 + 0.1 * high + aside)
    np.testing.assert_array_equal(region.others[:, 0], body[frames])


def test_nothing_is_learnt_from_few_frames():
    sure = np.full((100, 1, 3), np.nan)
    sure[: GAP_CLOSING.region_least - 1] = 0.0
    frames = np.arange(60, 100)
    for body in (np.zeros((100, 3)), None):
        region = usual_region(sure, body, 0, frames=frames, motion_model=SPACE)
        assert np.isneginf(region.low).all()
        assert np.isposinf(region.high).all()
        sure[:] = 0.0  # and without a body nothing is known, however much is certain


def test_a_paw_that_is_hardly_ever_seen_stays_on_its_side_and_goes_as_far_as_its_kind():
    # a mouse 100 long: front paws swing from 10 to 60 ahead, hind ones from 60 to 10 behind, left
    # ones 20 to the left of the middle and right ones as far to the right
    n, kinds = 100, ("front", "hind", "front", "hind")
    body = np.column_stack([0.5 * np.arange(n), np.zeros(n), np.zeros(n)])
    swing = 35.0 + 25.0 * np.sin(0.3 * np.arange(n))
    places = np.zeros((n, 4, 3))
    for p, (ahead, aside) in enumerate([(1, -20.0), (-1, -20.0), (1, 20.0), (-1, 20.0)]):
        places[:, p] = body + np.column_stack([ahead * swing, np.full(n, aside), np.zeros(n)])
    by_hand = np.zeros((n, 4), bool)
    by_hand[0] = True
    sure = places.copy()
    sure[1:, 0] = np.nan  # the right front paw was clicked once and never seen again
    frames = np.arange(40, 60)
    alike = same_kind(
        Assignment(sure, by_hand), body, 0, kinds=kinds, across=np.array([0.0, 1.0, 0.0])
    )
    assert [other for other, _ in alike] == [2]
    np.testing.assert_allclose(alike[0][1], [0.0, -40.0, 0.0])
    region = usual_region(sure, body, 0, frames=frames, motion_model=SPACE, alike=alike)
    speaks = np.zeros((4, len(frames)))
    for p in range(4):
        for row, frame in enumerate(frames):
            add_region_cost(places[frame, p][:, None], region, row, speaks[p, row : row + 1])
    np.testing.assert_array_equal(speaks[0], 0.0)
    # left paws are 40 off, limits 6 beyond, one standard deviation is 5
    assert (speaks[2:] > 0.5 * (34.0 / 5.0) ** 2 - 1e-6).all()
    # what nobody has placed by hand tells no side
    nobody = Assignment(sure, by_hand & (np.arange(4) != 2))
    assert not same_kind(nobody, body, 0, kinds=kinds, across=np.array([0.0, 1.0, 0.0]))


def test_places_that_are_known_poorly_keep_no_distance():
    sure = np.zeros((100, 2, 3))
    body, frames = np.zeros((100, 3)), np.arange(10)
    given = {"frames": frames, "motion_model": SPACE}
    assert usual_region(sure, body, 0, **given).others.shape[1] == 1
    poor = usual_region(sure, body, 0, **given, are_apart=False)
    assert poor.others.shape[1] == 0
    assert np.isfinite(usual_region(sure, body, 0, **given).high).all()
    assert np.isinf(poor.high).all()  # nor do they say how far a point goes


def test_a_hind_paw_that_is_not_seen_does_not_go_to_where_front_paws_are():
    n = 100
    t = np.arange(n)
    hind = np.column_stack([5.0 * np.sin(0.3 * t), np.zeros(n)])
    chosen = hind[:, None].copy()
    gap = slice(50, 80)
    chosen[gap] = np.nan
    # all that is seen there goes ahead by as much as the animal is long, and back
    away = hind.copy()
    away[gap, 0] += 100.0 * np.sin(np.pi * (t[gap] - 50) / 30)
    observations = Observations(
        away[:, None, None], away[:, None, None, None], np.ones((n, 1, 1)), np.ones((n, 1, 1), bool)
    )
    taken = {}
    for known, body in (("nothing", None), ("body", np.zeros((n, 2)))):
        closed = close_gaps(
            known_state(chosen, np.zeros((n, 1), bool), body=body),
            observations,
            geometry=Projection(None),
            paw_width_px=np.array([8.0]),
            tracked_in_view=np.ones((1, 1), bool),
            motion_model=FLAT,
        )
        taken[known] = np.flatnonzero(closed.choice[:, 0, 0] >= 0)
    assert {60, 65, 70} <= set(taken["nothing"])
    assert not {60, 65, 70} & set(taken["body"])
