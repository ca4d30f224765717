"""Headings told from the feet, against walks whose heading is known."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.gait.locomotion.feet_heading import heading_of_feet

FS = 100.0
T = np.arange(0, 8, 1 / FS)
FEET = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])  # ahead, to the left


def walked(heading, *, course=0.0, speed=3.0, swing=0.4):
    """Feet that swing at 4 Hz about places of a body that faces ``heading`` and goes ``course``."""
    way = heading + course
    steps = np.column_stack((np.cos(way), np.sin(way))) * np.broadcast_to(speed, len(T))[:, None]
    path = np.cumsum(steps / FS, axis=0)
    ahead = np.column_stack((np.cos(heading), np.sin(heading)))
    left = np.column_stack((-np.sin(heading), np.cos(heading)))
    feet = []
    for (x, y), sign in zip(FEET, [1, -1, -1, 1], strict=True):
        along = x + sign * swing * np.sin(2 * np.pi * 4 * T)
        feet.append(path + along[:, None] * ahead + y * left)
    return np.stack(feet, axis=-1), path


def turned_deg(found, heading, *, by=0.0):
    """Return the angle from the true front to what was found."""
    true = np.exp(1j * (heading + by))
    return np.degrees(np.angle((found[:, 0] + 1j * found[:, 1]) / true))


@pytest.mark.parametrize("heading", [0.9 * T, -0.9 * T, 0.8 * np.sin(T)])
def test_the_heading_of_feet_is_that_of_the_body(heading):
    positions, path = walked(heading)
    positions[100:130, :, 0] = np.nan
    found = heading_of_feet(positions, path, up=None, cutoff_hz=4 / 3, fs_hz=FS)
    assert np.abs(turned_deg(found, heading)).max() < 6.0
    # level in space, whichever way is up
    lifted = np.stack([positions[:, 0], np.zeros_like(positions[:, 0]), -positions[:, 1]], axis=1)
    flat = np.column_stack((path[:, 0], np.zeros(len(T)), -path[:, 1]))
    space = heading_of_feet(lifted, flat, up=np.array([0, 1.0, 0]), cutoff_hz=4 / 3, fs_hz=FS)
    np.testing.assert_allclose(space[:, [0, 2]] * [1, -1], found, atol=1e-6)


def test_some_steps_backwards_keep_the_front_and_a_crab_goes_to_its_side():
    heading = 0.3 * T
    positions, path = walked(heading, speed=np.where((T > 3) & (T < 4), -3.0, 3.0))
    found = heading_of_feet(positions, path, up=None, cutoff_hz=4 / 3, fs_hz=FS)
    assert np.abs(turned_deg(found, heading)).max() < 6.0
    positions, path = walked(heading, course=np.pi / 2)
    found = heading_of_feet(positions, path, up=None, cutoff_hz=4 / 3, fs_hz=FS)
    assert np.abs(turned_deg(found, heading, by=np.pi / 2)).max() < 6.0


def test_no_front_is_made_up():
    there_and_back, path = walked(0.0 * T, speed=np.where(T < 4, 3.0, -3.0))
    assert heading_of_feet(there_and_back, path, up=None, cutoff_hz=1.3, fs_hz=FS) is None
    one_foot, path = walked(0.5 * T)
    assert heading_of_feet(one_foot[:, :, :1], path, up=None, cutoff_hz=1.3, fs_hz=FS) is None
    noise = np.random.default_rng(0).standard_normal((len(T), 2, 4))
    assert heading_of_feet(noise, path, up=None, cutoff_hz=1.3, fs_hz=FS) is None


@pytest.mark.parametrize("seen", [0.4, 0.6])
def test_feet_that_are_seen_together_in_less_than_half_of_the_time_tell_no_heading(seen):
    # gaps between are bridged: it is the ends that lack
    heading = 0.5 * T
    positions, path = walked(heading)
    positions[int(seen * len(T)) :, :, 0] = np.nan
    found = heading_of_feet(positions, path, up=None, cutoff_hz=4 / 3, fs_hz=FS)
    assert (found is None) == (seen < 0.5)
