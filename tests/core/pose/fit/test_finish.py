"""Legs whose tips meet for a few frames go straight on."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pawnb.core.pose.fit.finish import hold_met


class TwoSticks:
    """Two legs of one link: an angle, here the tip's u, and a length, here its v."""

    numbers = (np.array([0, 1]), np.array([2, 3]))
    layout = SimpleNamespace(n_segments=np.array([1, 1]))

    def joints(self, pose):
        return np.array([[[0.0, 0.0], pose[:2]], [[0.0, 0.0], pose[2:]]])


def walk(met):
    """Return 30 poses in which the first leg moves evenly, but leaps to the second's tip."""
    poses = np.array([[float(t), 20.0, 80.0, 50.0] for t in range(30)])
    poses[met, :2] = (79.0, 50.0)
    return poses


def test_a_leg_at_another_tip_for_a_few_frames_goes_straight_on():
    met = slice(10, 14)
    poses, held = hold_met(TwoSticks(), walk(met))
    np.testing.assert_allclose(poses, walk([]))
    np.testing.assert_array_equal(np.flatnonzero(held[:, 0]), np.arange(30)[met])


def test_legs_together_for_long_or_at_an_end_are_left():
    for met in (slice(5, 25), slice(0, 4), slice(27, 30)):
        poses, held = hold_met(TwoSticks(), walk(met))
        np.testing.assert_array_equal(poses, walk(met))
        assert not held.any()


def test_legs_apart_are_left():
    poses, held = hold_met(TwoSticks(), walk([]))
    np.testing.assert_array_equal(poses, walk([]))
    assert not held.any()
