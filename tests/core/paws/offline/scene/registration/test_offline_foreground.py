"""The animal's blob against the ellipse that was drawn."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.scene.registration.camera_motion import find_camera_motion
from pawnb.core.paws.offline.scene.registration.foreground import find_blob

N = 40
AXES = (30, 13)
EXTENT = 50.0


def truth():
    """It travels 150 px, so that no place is its for half of the time, and turns by 60 degrees."""
    t = np.arange(N) / (N - 1)
    centre = np.stack([35 + 150 * t, 60 + 15 * np.sin(4 * t)], axis=-1)
    return centre, np.radians(60) * t


def apart(found, expected):
    """Angle between two axes, degrees."""
    return np.abs(np.degrees(np.angle(np.exp(2j * (found - expected))) / 2))


def clicks(centre, angle, row):
    along = np.array([np.cos(angle[row]), np.sin(angle[row])])
    return {row: centre[row] + np.outer([-0.7, 0.0, 0.7], AXES[0] * along)}


@pytest.mark.parametrize("row", [0, 25, N - 1])
def test_centre_angle_and_elongation_are_those_of_the_ellipse(film_animal, row):
    centre, angle = truth()
    pictures = film_animal(centre, angle, size=(220, 120), axes=AXES)
    camera = find_camera_motion(pictures)
    found = find_blob(pictures, camera, clicks=clicks(centre, angle, row), extent=EXTENT)
    np.testing.assert_allclose(found.centre, centre, atol=2.5)
    assert apart(found.angle, angle).max() < 6
    # second moments of an ellipse are a² / 4 and b² / 4
    a, b = AXES
    np.testing.assert_allclose(found.elongation, (a**2 - b**2) / (a**2 + b**2), atol=0.08)
    # inside more than one threshold, and outside none
    for t in (0, 20, 39):
        u, v = np.round(centre[t]).astype(int)
        assert found.difference[t, v, u] > 1
        assert found.difference[t, 5, 5] < 0.5
    assert found.difference.max() <= 3


def test_before_a_panning_camera_the_animal_stands_out_as_well(film_animal):
    """The ground goes 3 px a frame to the left while an animal of 36 px stays in the picture.

    In the nearest frames that are compared, 18 away, the animal is 54 px off on the ground.
    """
    n = 40
    camera = np.stack([-3.0 * np.arange(n), np.zeros(n)], axis=-1)
    centre, angle = np.tile([110.0, 35.0], (n, 1)), np.zeros(n)
    pictures = film_animal(centre, angle, size=(220, 70), axes=(18, 9), camera=camera)
    motion = find_camera_motion(pictures)
    assert motion.pans
    found = find_blob(
        pictures, motion, clicks={20: centre[20] + np.array([[-12, 0], [12, 0]])}, extent=30.0
    )
    np.testing.assert_allclose(found.centre, centre, atol=3)
    # the ground of neighbours is laid over that of the picture, so that nothing is left of it
    assert np.median(found.difference[20, :, 50:80]) < 0.06
    assert np.median(found.difference[20, 32:39, 100:121]) > 1


def test_of_two_animals_the_one_that_holds_the_clicks_is_followed(film_animal):
    """Two go side by side, 70 px apart."""
    t = np.arange(N) / (N - 1)
    upper = np.stack([35 + 150 * t, np.full(N, 35.0)], axis=-1)
    lower = upper + np.array([0, 70])
    one, other = (
        film_animal(centre, np.zeros(N), size=(220, 140), axes=AXES) for centre in (upper, lower)
    )
    pictures = np.concatenate([one[:, :70], other[:, 70:]], axis=1)
    camera = find_camera_motion(pictures)
    for centre in (upper, lower):
        found = find_blob(pictures, camera, clicks=clicks(centre, np.zeros(N), 10), extent=EXTENT)
        np.testing.assert_allclose(found.centre, centre, atol=2.5)


def test_a_larger_animal_far_away_is_not_taken_for_one_that_is_hidden(film_animal):
    """It is hidden from frame 30 on; the other one goes 130 px below it all the time."""
    t = np.arange(N) / (N - 1)
    own = np.stack([35 + 150 * t, np.full(N, 30.0)], axis=-1)
    seen = np.where((np.arange(N) < 30)[:, None], own, 1000.0)
    upper = film_animal(seen, np.zeros(N), size=(220, 210), axes=(16, 8))
    below = film_animal(own + np.array([0, 130]), np.zeros(N), size=(220, 210), axes=(34, 20))
    pictures = np.concatenate([upper[:, :70], below[:, 70:]], axis=1)
    camera = find_camera_motion(pictures)
    clicked = {10: own[10] + np.outer([-0.7, 0.7], [16.0, 0.0])}
    found = find_blob(pictures, camera, clicks=clicked, extent=30.0)
    np.testing.assert_allclose(found.centre[:30], own[:30], atol=2.5)
    assert np.isnan(found.centre[30:]).all()


def test_each_click_finds_the_blob_about_it(film_animal):
    """It is carried on by 150 px from one frame to the next, in the middle between two clicks."""
    rows = np.arange(N)
    along = np.where(rows < 18, 40 + 4 * rows, 190 + 4 * rows)
    centre = np.stack([along, np.full(N, 60.0)], axis=-1)
    angle = np.zeros(N)
    pictures = film_animal(centre, angle, size=(390, 120), axes=AXES)
    both = clicks(centre, angle, 5) | clicks(centre, angle, 30)
    found = find_blob(pictures, find_camera_motion(pictures), clicks=both, extent=EXTENT)
    np.testing.assert_allclose(found.centre, centre, atol=2.5)


def test_where_nothing_differs_there_is_no_blob():
    pictures = np.full((5, 60, 80), 90, np.uint8)
    found = find_blob(
        pictures, find_camera_motion(pictures), clicks={2: np.array([[40.0, 30]])}, extent=30.0
    )
    assert np.isnan(found.centre).all()
    assert np.isnan(found.angle).all()
