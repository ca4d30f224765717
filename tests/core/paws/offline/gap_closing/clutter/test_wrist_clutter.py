"""Wrists: seen apart from a paw that stands, they are not that paw, and say where it is."""

from dataclasses import replace

import numpy as np
import pytest
from pipeline_states import known_state

from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.clutter.wrist_clutter import follow_wrist_clutter
from pawnb.core.paws.offline.gap_closing.gap_closing import close_gaps
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.stance import Stance, Substrate

THICKNESS = 8.0
DRIFT = np.array([-5.0, 0.0])
MANNER = MotionModel(
    acceleration=1.0,
    jerk=0.6,
    speed=12.0,
    substrate_velocity=DRIFT,
    axes=np.array([[1.0, 0.0], [0.0, -1.0]]),
    substrate=-1000.0,
    body_scale=150.0,
    paw_width=THICKNESS,
)
ON = Substrate(np.zeros(2), DRIFT, np.zeros((2, 2)), MANNER)
N, STOP, LIFT = 40, 20, 23
"""The stance is certain until the paw is covered; it lifts off later."""
STEPS = round(0.03 * MANNER.fps)


def scene():
    """A paw stands on moving ground and lifts off; its wrist turns over it, and clutter is far."""
    t = np.arange(float(N))
    paw = np.column_stack([200.0 - 5.0 * t, np.full(N, 100.0)])
    stance = Stance(0, STOP, np.array([200.0, 100.0]))
    paw[LIFT + 1 :, 1] -= 6.0 * np.arange(1, N - LIFT)
    wrist = paw + np.column_stack([-6.0 + 0.3 * t, np.full(N, -10.0)])
    clutter = np.column_stack([5.0 * t, np.full(N, 20.0)])
    return stance, np.stack([paw, wrist, clutter], axis=1)


def sights_of(at, there=None, *, detection_probability=1.0, n_points=2):
    """Detections (n, C, 2) of one view; those that are there have to come first."""
    there = np.ones(at.shape[:2], bool) if there is None else there
    detection_probability = np.broadcast_to(detection_probability, at.shape[:2])
    return Observations(
        at[:, None], np.repeat(at[:, None, None], n_points, axis=1), detection_probability[:, None],
        there[:, None],
    )  # fmt: skip


def wrists_of(stance, observations):
    """Follow the wrists of the first of two points."""
    return follow_wrist_clutter(
        [[stance], []], observations, substrate=ON, geometry=Projection(None),
        paw_width_px=np.array([THICKNESS]),
    )  # fmt: skip


def test_a_wrist_is_followed_from_where_its_paw_stood():
    stance, at = scene()
    found = wrists_of(stance, sights_of(at)).found
    # for 0.03 s, and neither the paw itself nor what is far from it; nothing of the other point
    expected = np.zeros((N, 2, 1, 3), bool)
    expected[STOP : STOP + STEPS, 0, 0, 1] = True
    np.testing.assert_array_equal(found, expected)


def test_a_wrist_says_where_its_paw_is():
    stance, at = scene()
    observations = sights_of(at)
    moved, negative_log_odds = wrists_of(stance, observations).observed(
        observations, np.zeros((N, 2, 1, 3))
    )
    followed = slice(STOP, STOP + STEPS)
    # by the turning of the wrist, 0.3 px a frame, what it says is ahead of the paw
    late = 0.3 * np.arange(1, STEPS + 1)
    expected = at[followed, 0] + np.column_stack([late, np.zeros(STEPS)])
    np.testing.assert_allclose(moved.at[followed, 0, 0, 1], expected, atol=1e-9)
    assert (negative_log_odds[followed, 0, 0, 1] > 0).all()
    # all else says what it said, and costs nothing more
    np.testing.assert_array_equal(moved.at[:, :, 0, ::2], observations.at[:, :, 0, ::2])
    np.testing.assert_array_equal(moved.at[:, 1], observations.at[:, 1])
    assert negative_log_odds[:, 1].max() == negative_log_odds[:, 0, 0, ::2].max() == 0


def test_a_wrist_is_no_measurement():
    stance, at = scene()
    wrist_clutter = wrists_of(stance, sights_of(at))
    choice = np.full((N, 2, 1), -1)
    choice[15:24, 0], choice[24:30, 0], choice[:, 1] = 1, 0, 1
    left, negative_log_odds = wrist_clutter.left_out(choice, np.zeros((N, 2, 1, 3)))
    # before the stance ends it was not told by following
    expected = choice.copy()
    expected[STOP:24, 0] = -1
    np.testing.assert_array_equal(left, expected)
    np.testing.assert_array_equal(negative_log_odds > 10, wrist_clutter.found)


@pytest.mark.parametrize(("where", "followed"), [(0.7, 0), (0.9, STEPS), (2.4, STEPS), (2.6, 0)])
def test_what_is_nearer_is_the_paw_and_what_is_farther_another(where, followed):
    stance, at = scene()
    at[:, 1] = at[:, 0] - [0.0, where * THICKNESS]
    assert wrists_of(stance, sights_of(at)).found.sum() == followed


def test_what_was_the_paw_in_the_frame_before_is_no_wrist():
    stance, at = scene()
    at[:, 1] = at[:, 0] - [0.0, 0.9 * THICKNESS]
    at[STOP - 2, 1] = at[STOP - 2, 0] - [0.0, 0.7 * THICKNESS]
    assert not wrists_of(stance, sights_of(at)).found.any()


def test_a_paw_that_comes_near_is_no_wrist():
    """It lands beside the paw that stands: in the frame before it was elsewhere."""
    stance, at = scene()
    at[:, 1] = at[:, 0] + [0.0, -12.0] + 7.0 * (np.arange(N) - STOP + 1.0)[:, None]
    assert not wrists_of(stance, sights_of(at)).found.any()


def test_a_wrist_that_is_lost_is_not_found_again():
    stance, at = scene()
    at[STOP + 2, 1] += [0.0, -6.0]  # in steps of less than 4 px it is followed
    found = wrists_of(stance, sights_of(at)).found
    np.testing.assert_array_equal(np.flatnonzero(found[:, 0, 0, 1]), [STOP, STOP + 1])


@pytest.mark.parametrize(("liftoff_velocity", "followed"), [(STOP - 1, 1), (STOP, 2), (N, STEPS)])
def test_what_has_left_the_ground_may_be_the_paw(liftoff_velocity, followed):
    stance, at = scene()
    # 3.5 px in the first frame; 5.6, seven tenths of a paw width, are gone in the second
    at[liftoff_velocity + 1 :, 1, 1] -= 3.5 * np.arange(1, N - liftoff_velocity)
    assert wrists_of(stance, sights_of(at)).found.sum() == followed


def test_what_is_not_there_is_not_followed():
    stance, at = scene()
    there = np.ones((N, 3), bool)
    there[:, 1:] = False
    assert not wrists_of(stance, sights_of(at, there)).found.any()


def test_nothing_is_followed_past_the_end_of_a_recording():
    stance, at = scene()
    found = wrists_of(Stance(0, N - 2, stance.origin), sights_of(at)).found
    assert found.sum() <= 2
    assert not wrists_of(Stance(0, N, stance.origin), sights_of(at)).found.any()


def lifting_off():
    """A paw that a landing one covers as it lifts off; the wrist stays in sight, well seen."""
    t = np.arange(60.0)
    s = np.clip((t - 26.5) / 16.0, 0.0, 1.0)
    paw = np.column_stack([200.0 - 3.0 * t, 100.0 - 40.0 * np.sin(np.pi * s)])
    paw[:, 0] += 120.0 * (s - np.sin(2 * np.pi * s) / (2 * np.pi))
    other = np.column_stack([206.0 - 3.0 * t, np.full(60, 102.0)])
    other[:20] += np.column_stack([-12.0 * (20.0 - t[:20]), -3.0 * (20.0 - t[:20])])
    wrist = paw + np.column_stack([-6.0 + 0.4 * (t - 22.0), np.full(60, -10.0)])
    at = np.stack([other, paw, wrist], axis=1)
    there = np.ones((60, 3), bool)
    there[:16, 2] = there[29:, 2] = False
    hidden = (t >= 22) & (t < 36)
    at[hidden] = at[hidden][:, [0, 2, 1]]
    there[hidden] = np.column_stack([np.ones(14), t[hidden] < 29, np.zeros(14)]).astype(bool)
    detection_probability = np.where((at == wrist[:, None]).all(axis=-1), 0.95, 1.0)
    chosen = np.stack([paw, other], axis=1)
    chosen[hidden, 0] = np.nan
    return paw, chosen, at, there, detection_probability


def test_a_paw_that_lifts_off_is_not_taken_for_its_wrist():
    paw, chosen, at, there, detection_probability = lifting_off()
    bridged = close_gaps(
        known_state(chosen, np.zeros((60, 2), bool)),
        sights_of(at, there, detection_probability=detection_probability),
        geometry=Projection(None),
        paw_width_px=np.array([THICKNESS]),
        tracked_in_view=np.ones((2, 1), bool),
        motion_model=replace(MANNER, substrate_velocity=np.array([-3.0, 0.0])),
    )
    # in frame 26 it stands for the last time; taken for its wrist it would lift off in 23
    (liftoff_velocity,) = (t for p, t in bridged.lift_offs if p == 0 and 20 < t < 36)
    assert abs(liftoff_velocity - 26) <= 2
    assert (bridged.choice[22:36, 0] < 0).all()
    standing = np.arange(22, 26)
    np.testing.assert_allclose(bridged.held[standing, 0], paw[standing], atol=0.5)
