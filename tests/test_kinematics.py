"""Body frame, mean path and directions: rigid motions whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.kinematics import (
    along,
    body_frame_from_points,
    body_frame_of_path,
    is_travelling,
    mean_path,
    smooth_path,
    swing_direction,
    travel_direction,
)


def moving_feet(n=300, seed=0):
    """Four feet at fixed places about a body that follows a smooth curve."""
    t = np.arange(n) / n
    path = np.column_stack((100 * t, 20 * np.sin(3 * t)))
    places = np.array([[30.0, -30.0, 28.0, -33.0], [10.0, 10.0, -10.0, -12.0]])
    return path, path[:, :, None] + places[None]


def test_mean_path_does_not_jump_when_feet_come_and_go():
    _, feet = moving_feet()
    rng = np.random.default_rng(0)
    gappy = feet.copy()
    for k in range(4):
        for start in rng.integers(0, 280, 3):
            gappy[start : start + 20, :, k] = np.nan
    expected = feet.mean(axis=2)
    found = mean_path(gappy)
    seen = np.isfinite(gappy).all(axis=1).any(axis=1)
    shift = (found - expected)[seen]
    np.testing.assert_allclose(shift - shift[0], 0.0, atol=1e-6)
    # the plain mean of what is there jumps by centimetres
    plain = np.nanmean(gappy, axis=2) - expected
    assert np.nanmax(np.abs(plain - plain[0])) > 5


def test_mean_path_of_complete_feet_is_their_mean():
    _, feet = moving_feet()
    np.testing.assert_allclose(mean_path(feet), feet.mean(axis=2), atol=1e-9)
    assert np.isnan(mean_path(np.full((5, 2, 3), np.nan))).all()


@pytest.mark.slow
@settings(deadline=None)
@given(st.floats(-180, 180), st.floats(-1e3, 1e3))
def test_body_frame_turns_with_the_body(angle, place):
    # the same animal, turned and moved: fore-aft positions stay
    _, feet = moving_feet()
    centre = feet.mean(axis=2)
    body = np.stack([centre + np.array([-20, 0]), centre + np.array([25, 0])], axis=-1)
    a = np.radians(angle)
    spin = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    seen = []
    for turn in (np.eye(2), spin):
        moved_body = np.einsum("ij,njk->nik", turn, body) + place
        moved_feet = np.einsum("ij,njk->nik", turn, feet) + place
        frame = body_frame_from_points(moved_body, cutoff_hz=None, fs_hz=250.0)
        np.testing.assert_allclose(np.linalg.norm(frame.forward, axis=1), 1.0)
        seen.append(frame.fore_aft(moved_feet))
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-6)
    np.testing.assert_allclose(seen[0][:, 0] - seen[0][:, 1], 60.0, atol=1e-9)


def test_heading_is_level_in_space():
    body = np.zeros((10, 3, 2))
    body[:, :, 1] = [3.0, 4.0, 12.0]
    frame = body_frame_from_points(body, cutoff_hz=None, fs_hz=250.0, up=np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(frame.forward, np.tile([0.6, 0.8, 0.0], (10, 1)))
    assert frame.method == "body points"


def test_laboratory_frame_stays_at_the_mean_of_the_path():
    path, feet = moving_feet()
    path[:7] = np.nan
    lab = body_frame_of_path(path, [2.0, 0.0], at_rest=True, method="laboratory")
    np.testing.assert_allclose(lab.fore_aft(feet), feet[:, 0] - path[7:, 0].mean())
    path, _ = moving_feet()
    moving = body_frame_of_path(path, [2.0, 0.0], at_rest=False, method="mean of the feet")
    np.testing.assert_allclose(moving.fore_aft(feet), np.tile(feet[0, 0], (300, 1)), atol=1e-9)
    assert (lab.method, moving.method) == ("laboratory", "mean of the feet")
    np.testing.assert_allclose(along(feet, np.tile([0.0, 1.0], (300, 1))), feet[:, 1])


def test_travel_direction_and_straightness():
    t = np.linspace(0, 1, 200)
    direction, straight = travel_direction(np.column_stack((-3 * t, 4 * t)))
    np.testing.assert_allclose(direction, [-0.6, 0.8])
    assert straight == pytest.approx(1.0)
    half = np.column_stack((np.cos(np.pi * t), np.sin(np.pi * t)))  # half a circle
    direction, straight = travel_direction(half)
    np.testing.assert_allclose(direction, [-1.0, 0.0], atol=1e-12)
    assert straight == pytest.approx(2 / np.pi, rel=1e-3)
    climbing = np.column_stack((3 * t, 0 * t, 5 * t))
    level, _ = travel_direction(climbing, up=np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(level, [1.0, 0.0, 0.0], atol=1e-12)


def stepping(duty=0.6, n=750, period=75, stride=90.0):
    """Two feet that step in one place, forward being +u."""
    x = np.mod(np.arange(n)[:, None] / period + [0.0, 0.5], 1.0)
    s = np.clip((x - duty) / (1 - duty), 0, 1)
    back = stride * duty * (0.5 - x / duty)
    swing = stride * (s**3 * (10 - 15 * s + 6 * s**2)) - stride * (x - duty) - stride * duty / 2
    feet = np.zeros((n, 2, 2))
    feet[:, 0] = np.where(x < duty, back, swing)
    feet[:, 1] = 300 - 8 * 16 * s**2 * (1 - s) ** 2
    return feet


@pytest.mark.parametrize("duty", [0.42, 0.6, 0.8])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_swing_tells_the_front(duty, sign):
    feet = stepping(duty) * np.array([sign, 1.0])[:, None]
    found = swing_direction(feet, fs_hz=250.0)
    assert found[0] * sign > 0.98


def test_labels_that_are_exchanged_halfway_do_not_turn_the_front():
    """From below, 120 px between left and right: more than a foot steps."""
    feet = stepping()
    feet[:, 1] += [0.0, 120.0]
    feet[400:] = feet[400:, :, ::-1]
    assert swing_direction(feet, fs_hz=250.0)[0] > 0.98


def test_stepping_in_place_is_no_travel():
    feet = stepping()
    path = smooth_path(feet, cutoff_hz=1.0, fs_hz=250.0)
    assert not is_travelling(feet, path)
    feet[:, 0] += np.arange(750)[:, None] * 1.2
    assert is_travelling(feet, smooth_path(feet, cutoff_hz=1.0, fs_hz=250.0))


def test_a_path_shorter_than_the_cutoff_is_a_line():
    path, feet = moving_feet(40)
    found = smooth_path(feet, cutoff_hz=0.5, fs_hz=250.0)
    np.testing.assert_allclose(np.diff(found, 2, axis=0), 0.0, atol=1e-9)
    np.testing.assert_allclose(found[:, 0] - found[0, 0], path[:, 0], atol=1e-9)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"names 1 point; expected two or more"):
        body_frame_from_points(np.zeros((5, 2, 1)), cutoff_hz=None, fs_hz=100.0)
    with pytest.raises(InputError, match=r"are never seen together; name others"):
        body_frame_from_points(np.full((5, 2, 2), np.nan), cutoff_hz=None, fs_hz=100.0)


def test_a_foot_that_stays_exactly_where_it_was_says_nothing_of_the_arithmetic():
    t = np.arange(200) / 250.0
    feet = np.stack([np.stack([100 * np.sin(20 * t), 0 * t], 1), np.zeros((200, 2))], axis=2)
    with np.errstate(all="raise"):
        assert abs(swing_direction(feet, fs_hz=250.0)[0]) > 0.98
