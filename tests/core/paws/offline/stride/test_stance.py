"""Paws on moving ground: when they stand, what rides above it, and how they lift off."""

import numpy as np

from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.stance import (
    Substrate,
    covered,
    expected_jerks,
    learn_liftoff_velocity,
    learn_substrate,
)

DRIFT = np.array([-1.2, 0.0, 0.0])
MANNER = MotionModel(
    acceleration=0.3,
    jerk=0.2,
    speed=2.0,
    substrate_velocity=np.array([-1.1, 0.05, 0.02]),
    axes=np.eye(3),
    substrate=1.0,
    body_scale=40.0,
    paw_width=3.0,
)
UP = np.array([0.2, 0.1, 2.5])
"""Change of speed at lift-off, put in."""
N, LAST = 60, (19, 49)


def walk(*, liftoff_velocity=UP, noise=0.0):
    """Stand to frame 19, swing to 39, stand to 49, swing: two points, the second 8 to the side."""
    t = np.arange(N, dtype=float)
    x = np.array([50.0, 5.0, 1.2]) + t[:, None] * DRIFT
    for last in LAST:
        since = np.clip(t - last - 0.5, 0.0, 19.5 if last == 19 else 99.0)
        x += since[:, None] * liftoff_velocity
    swing = np.clip(t - 30.5, 0.0, 8.5)[:, None] * np.array([1.0, 0.0, -UP[2] * 19.5 / 8.5])
    x = np.stack([x + swing, x + swing + [0.0, 8.0, 0.0]], axis=1)
    return x + noise * np.random.default_rng(1).normal(size=x.shape)


def substrate(**changes):
    liftoff_velocity = np.tile(UP, (2, 1))
    return Substrate(
        **{
            "height": np.full(2, 1.2),
            "substrate_velocity": DRIFT,
            "liftoff_velocity": liftoff_velocity,
            "motion_model": MANNER,
            **changes,
        }
    )


def test_the_ground_is_where_paws_go_as_most_do():
    chosen = walk(noise=0.02)[:20]
    learnt = learn_substrate(chosen, MANNER)
    np.testing.assert_allclose(learnt.substrate_velocity, DRIFT, atol=0.02)
    np.testing.assert_allclose(learnt.height, 1.2, atol=0.02)
    # what is assumed before any lift-off is seen goes up
    assert (learnt.liftoff_velocity @ MANNER.axes[-1] > 0).all()
    np.testing.assert_allclose(learnt.liftoff_velocity[:, :2], 0.0)


def test_without_heights_none_are_learnt():
    flat = MotionModel(**{**vars(MANNER), "substrate": -np.inf})
    learnt = learn_substrate(walk()[:20], flat)
    assert np.isnan(learnt.height).all()
    assert np.isnan(learnt.kinematic_prior(0).height)


def test_stances_last_until_the_paw_leaves_its_place():
    x = walk(noise=0.02)
    x[23:34] = np.nan
    first, second = substrate().stances(x)
    for stances in (first, second):
        assert (stances[0].first, stances[0].stop) == (0, LAST[0] + 1)
    t = np.arange(3, 6)
    np.testing.assert_allclose(substrate().places(first[0], t), x[t, 0], atol=0.1)


def test_a_paw_that_creeps_and_slips_does_not_stand_twice_at_once():
    # it creeps for 30 frames, slips, and stands near to where it crept last
    still = np.concatenate([np.linspace(0.0, 2.5, 30), np.full(4, 4.2), np.full(15, 3.2)])
    x = np.arange(49.0)[:, None] * DRIFT + still[:, None] * [1.0, 0.0, 0.0]
    (first, second) = substrate().stances(x[:, None])[0]
    assert abs(still[first.stop - 1] - 3.2) < 0.35 * MANNER.paw_width
    assert first.first < first.stop <= second.first < second.stop == 49


def test_a_stance_needs_places_that_go_with_the_ground():
    still = np.tile([5.0, 0.0, 1.2], (30, 2, 1))
    assert substrate().stances(still) == [[], []]
    assert substrate().stances(np.full((30, 2, 3), np.nan)) == [[], []]
    assert substrate().stances(walk()[3:6] + np.array([0.0, 0.0, 2.0])) == [[], []]


def test_a_recording_may_begin_with_the_last_frames_of_a_stance():
    """Too few frames for a speed: it is as low as it stands later, and goes with the ground."""
    x = walk(noise=0.02)[15:]  # it stands in five more frames
    x[3:25] = np.nan  # and is seen in three of them
    x[2, 1] += [1.5, 0.0, 0.0]  # the second is drawn off at once
    first, second = (mine[0] for mine in substrate().stances(x))
    assert (first.first, first.stop, second.first, second.stop) == (0, 3, 0, 2)
    np.testing.assert_allclose(substrate().places(first, np.arange(3)), x[:3, 0], atol=0.1)
    # one frame, as one that is clicked, is told by its height
    x[1:3] = np.nan
    assert [(mine[0].first, mine[0].stop) for mine in substrate().stances(x)] == [(0, 1)] * 2
    # what hovers, or is not known to stand at any height, does not stand
    above = walk()[15:18] + np.array([0.0, 0.0, 1.2])
    assert substrate().stances(above) == [[], []]
    assert substrate(height=np.full(2, np.nan)).stances(walk()[:3]) == [[], []]


def test_how_paws_lift_off_is_the_median_of_what_was_seen():
    x = walk()
    seen = np.zeros((N, 2), bool)
    seen[:, 0] = True
    lift_offs = [(p, last) for p in (0, 1) for last in LAST]
    liftoff_velocity = learn_liftoff_velocity(substrate(), x, seen, lift_offs=lift_offs, frames=3)
    assumed = np.array([0.0, 0.0, MANNER.speed])
    # two lift-offs were seen, and what is assumed counts as two; forward it does not jump
    np.testing.assert_allclose(
        liftoff_velocity[0], [0.0, 0.0, 0.5 * (UP[2] + MANNER.speed)], atol=1e-9
    )
    np.testing.assert_allclose(liftoff_velocity[1], assumed)


def test_another_paw_covers_a_point_that_is_near_it_in_the_picture():
    uv = np.full((2, 3, 1, 2), np.nan)
    uv[:, 0] = [10.0, 10.0]
    uv[0, 1], uv[1, 1] = [19.0, 10.0], [20.0, 10.0]
    standing = np.array([[10.0, 10.0], [10.0, 10.0]])
    hidden = covered(standing, uv, 0, geometry=Projection(None), paw_width_px=np.array([8.0]))
    np.testing.assert_array_equal(hidden, [[True], [False]])


def test_bends_are_those_of_a_path_that_changes_its_speed_between_two_frames():
    t = np.arange(30.0)
    x = np.maximum(t - 12.5, 0.0)[:, None] * UP
    jerk_mean, near = expected_jerks([(1, 12), (0, 29)], np.tile(UP, (2, 1)), 30)
    expected = np.zeros((30, 3))
    expected[1:-2] = x[3:] - 3 * x[2:-1] + 3 * x[1:-2] - x[:-3]
    np.testing.assert_allclose(jerk_mean[:, 1], expected, atol=1e-12)
    assert not jerk_mean[:, 0].any()
    assert not near[:, 0].any()
    np.testing.assert_array_equal(np.flatnonzero(near[:, 1]), [11, 12, 13])
