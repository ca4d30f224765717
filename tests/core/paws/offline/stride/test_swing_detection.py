"""When swings begin and end, told by the stances around them, and when one is due to begin."""

import numpy as np
import pytest

from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.stance import Stance, Substrate
from pawnb.core.paws.offline.stride.swing import Swings
from pawnb.core.paws.offline.stride.swing_detection import find_swings, since_landing

DRIFT = np.array([-1.2, 0.1, 0.05])


def test_when_swings_begin_and_end_is_told_by_stances_and_rhythm():
    """At 250 frames a second edges are told to 0.003 s and half a frame: 1.25 frames."""
    origin = np.zeros(3)
    ahead = np.array([60.0, 0.0, 0.0])
    stances = [[Stance(10, 40, origin), Stance(60, 90, ahead)]]
    seen = np.ones((100, 1), bool)
    (swing,) = find_swings(stances, seen, None, certain=seen, fps=250.0, substrate_velocity=DRIFT)
    assert (swing.point, swing.is_whole) == (0, True)
    assert (swing.times, swing.sd) == ((39.0, 60.0), (1.25, 1.25))
    np.testing.assert_array_equal([swing.begin, swing.end], [origin, ahead])
    # three times as much where that is not seen
    seen[38] = seen[61] = False
    (swing,) = find_swings(stances, seen, None, certain=seen, fps=250.0, substrate_velocity=DRIFT)
    assert swing.sd == (3.75, 3.75)
    duty_factor = DutyFactor(np.array([0.5]), np.array([0.02]), 50.0, 2.0)
    before, swing, after = sorted(
        find_swings(stances, seen, duty_factor, certain=seen, fps=250.0, substrate_velocity=DRIFT),
        key=lambda one: one.times,
    )
    # of its own stride of 50 frames it stands for 25, give or take one; that is half way between
    # its ends, which are told to 1.25 and 3.75 frames
    # seems to stand: what it seems is half a frame longer at either end than what it is
    due, known = 10 - 0.5 + 25 - 0.5, 1.0**2 + (0.5 * 1.25) ** 2 + (0.5 * 3.75) ** 2
    sure = 1 / 3.75**2 + 1 / known
    assert swing.times[0] == pytest.approx((39.0 / 3.75**2 + due / known) / sure)
    assert swing.sd[0] == pytest.approx(sure**-0.5)
    assert (before.is_whole, after.is_whole) == (False, False)
    assert before.times == (10.0 - 26.0, 10.0)
    np.testing.assert_array_equal(before.begin, -ahead)
    np.testing.assert_array_equal(after.end, 2 * ahead)
    # of strides it is told to a twentieth at least
    spread = np.hypot(2.0, 2.5)
    assert before.sd[0] == pytest.approx(np.hypot(1.0, 0.5 * spread))
    assert after.times[1] - after.times[0] == pytest.approx(26.0)


def test_swings_of_which_one_end_is_not_known_last_as_long_as_those_between_stances():
    """A paw stands on its place, to half a frame, from 10 to 30 of every 40 frames."""
    stances = [Stance(at, at + 21, np.array([at * 1.5, 0.0, 0.0])) for at in (50, 90, 130)]
    seen = np.ones((170, 1), bool)
    duty_factor = DutyFactor(np.array([21 / 40]), np.array([0.02]), 40.0, 1.0)
    swings = find_swings(
        [stances], seen, duty_factor, certain=seen, fps=250.0, substrate_velocity=DRIFT
    )
    times = sorted(one.times for one in swings)
    np.testing.assert_allclose(times, [(30, 50), (70, 90), (110, 130), (150, 170)])
    assert sum(one.is_whole for one in swings) == 2


@pytest.mark.parametrize(("first", "stop"), [(30, 70), (5, 42), (38, 95)])
def test_a_stance_whose_end_nothing_shows_may_end_anywhere_in_between(first, stop):
    """A standard deviation of what is equally likely in n frames is n / sqrt(12), 0.29 n."""
    stances = [[Stance(2, 40, np.zeros(3)), Stance(97, 120, np.ones(3))]]
    seen = np.ones((130, 1), bool)
    seen[first:stop] = False
    (swing,) = find_swings(stances, seen, None, certain=seen, fps=250.0, substrate_velocity=DRIFT)
    assert swing.times[0] == 39.0
    assert swing.sd[0] == pytest.approx((stop - first) / np.sqrt(12.0), rel=0.05)
    assert swing.sd[1] < 4.0


def test_an_edge_that_is_seen_but_not_certain_is_told_half_as_well():
    seen = np.ones((100, 1), bool)
    certain = seen.copy()
    certain[60] = False
    stances = [[Stance(10, 40, np.zeros(3)), Stance(60, 90, np.ones(3))]]
    (swing,) = find_swings(
        stances, seen, None, certain=certain, fps=250.0, substrate_velocity=DRIFT
    )
    assert swing.sd == (1.25, 2.5)
    # nor is it when it lifted off, before its last frame on the ground or after it
    for edge in (39, 40):
        unsure = seen.copy()
        unsure[edge] = False
        (swing,) = find_swings(
            stances, seen, None, certain=unsure, fps=250.0, substrate_velocity=DRIFT
        )
        assert swing.sd == (2.5, 1.25)
    # nor is it known better when the paw that landed there is due to lift off
    duty_factor = DutyFactor(np.array([0.5]), np.array([0.02]), 50.0, 2.0)
    stances[0].append(Stance(110, 140, np.ones(3)))
    seen = np.ones((200, 1), bool)
    certain = seen.copy()
    certain[60] = False
    swing = find_swings(
        stances, seen, duty_factor, certain=certain, fps=250.0, substrate_velocity=DRIFT
    )[1]
    known = 1.25**-2 + 1.0 / (1.0**2 + (0.5 * 2.5) ** 2 + (0.5 * 1.25) ** 2)
    assert swing.sd[0] == pytest.approx(known**-0.5)


def test_a_stance_begins_where_its_paw_is_first_seen_on_its_place():
    """A paw comes down with 2 paw widths a frame and stands from frame 30 on."""
    paw_width = 3.0
    motion_model = MotionModel(
        acceleration=0.3,
        jerk=0.2,
        speed=2.0,
        substrate_velocity=DRIFT,
        axes=np.eye(3),
        substrate=0.0,
        body_scale=40.0,
        paw_width=paw_width,
    )
    substrate = Substrate(np.zeros(1), DRIFT, np.zeros((1, 3)), motion_model)
    frames = np.arange(80)
    above = np.where(frames < 30, 30 - frames, np.maximum(frames - 59, 0)) * 2.0 * paw_width
    x = (frames[:, None] * DRIFT + above[:, None] * [0.0, 0.0, 1.0])[:, None]
    seen = np.ones((80, 1), bool)
    late = [[Stance(40, 60, np.zeros(3))]]
    ((landed,),) = since_landing(late, x, seen=seen, substrate=substrate)
    assert (landed.first, landed.stop) == (30, 60)
    np.testing.assert_array_equal(landed.origin, late[0][0].origin)
    # where it was not seen nothing is known of it
    seen[35] = False
    assert since_landing(late, x, seen=seen, substrate=substrate)[0][0].first == 36
    # to the side a place is told less well, and is not asked
    x[..., 1] += 2.0 * paw_width
    assert since_landing(late, x, seen=seen, substrate=substrate)[0][0].first == 36
    # a stance begins after the one before has ended
    x[:30] = frames[:30, None, None] * DRIFT
    both = [[Stance(2, 20, np.zeros(3)), Stance(40, 60, np.zeros(3))]]
    seen[:] = True
    assert [one.first for one in since_landing(both, x, seen=seen, substrate=substrate)[0]] == [
        0,
        21,
    ]


def test_stances_that_follow_at_once_have_no_swing_between_them():
    stances = [[Stance(10, 40, np.zeros(3)), Stance(42, 70, np.ones(3))], []]
    seen = np.ones((100, 2), bool)
    assert find_swings(stances, seen, None, certain=seen, fps=250.0, substrate_velocity=DRIFT) == []


def test_a_single_stance_steps_as_far_as_the_ground_goes_in_a_stride():
    seen = np.ones((100, 1), bool)
    duty_factor = DutyFactor(np.array([0.6]), np.array([0.02]), 50.0, 2.0)
    swings = find_swings(
        [[Stance(30, 60, np.zeros(3))]],
        seen,
        duty_factor,
        certain=seen,
        fps=250.0,
        substrate_velocity=DRIFT,
    )
    for swing in swings:
        np.testing.assert_allclose(swing.end - swing.begin, -50.0 * DRIFT)
    assert [swing.times[0] < 30 for swing in swings] == [True, False]


@pytest.mark.parametrize("sd", [0.1, 2.0])
def test_a_lift_off_is_due_when_its_swing_begins(sd):
    nowhere = np.full((100, 2, 3), np.nan)
    swings = Swings(nowhere, nowhere, nowhere, ((0, 40.2, sd), (0, 90.0, sd), (1, 60.0, sd)))
    frames = np.arange(30, 50)
    # between two frames, and to 0.7 frames at best; half the square, 8 at most
    expected = np.minimum(0.5 * ((frames - 0.5 - 40.2) / max(sd, 0.7)) ** 2, 8.0)
    np.testing.assert_allclose(swings.due(0, frames, 250.0), expected)
    assert frames[np.argmin(expected)] == 41
    # nothing is due within 0.02 s of it, nor in any case within five frames
    assert swings.due(0, np.arange(46, 60), 250.0) is None
    assert swings.due(0, np.arange(45, 60), 250.0) is not None
    assert swings.due(0, np.arange(46, 60), 500.0) is not None
    assert swings.due(0, np.arange(20, 35), 250.0) is None
    assert swings.due(1, frames, 250.0) is None
    # of two the nearer one
    both = swings.due(0, np.arange(30, 100), 250.0)
    assert (np.flatnonzero(both < 1.0) + 30 > 80).any()
    assert (np.flatnonzero(both < 1.0) + 30 < 50).any()
