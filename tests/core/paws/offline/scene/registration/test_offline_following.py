"""An animal is followed by what moves about its clicks."""

from __future__ import annotations

import numpy as np

from pawnb.core.paws.offline.scene.registration.camera_motion import find_camera_motion
from pawnb.core.paws.offline.scene.registration.following import (
    between_two_ways,
    follow_animal,
)

N, EXTENT = 40, 50.0
T = np.arange(N)


def follow(pictures, centre, *clicked):
    clicks = {row: centre[row] + np.array([[-20.0, 0.0], [20.0, 0.0]]) for row in clicked}
    return follow_animal(pictures, find_camera_motion(pictures), clicks=clicks, extent=EXTENT)


def way(speed):
    return np.stack([60 + speed * T, np.full(N, 60.0)], axis=-1)


def test_a_walking_animal_is_followed_both_ways(film_animal):
    centre = way(2.0)
    pictures = film_animal(centre, np.zeros(N), size=(200, 120))
    found = follow(pictures, centre, 20)
    np.testing.assert_array_equal(found[20], centre[20])
    np.testing.assert_allclose(found, centre, atol=0.1 * EXTENT)


def test_a_shadow_that_goes_with_it_and_another_animal_do_little_harm(film_animal):
    """A dark band travels beside it at its speed; another animal crosses behind, the other way.

    The ground shines through the band, so that some of its features lag behind.
    """
    centre = way(2.0)
    pictures = film_animal(centre, np.zeros(N), size=(200, 180))
    other = film_animal(
        np.stack([160 - 2.0 * T, np.full(N, 140.0)], -1),
        np.zeros(N),
        size=(200, 180),
        axes=(24, 10),
    )
    pictures[:, 125:155] = other[:, 125:155]
    for t in T:
        u = int(centre[t, 0])
        pictures[t, 76:86, u - 25 : u + 25] = pictures[t, 76:86, u - 25 : u + 25] // 3
    np.testing.assert_allclose(follow(pictures, centre, 5), centre, atol=0.2 * EXTENT)


def test_one_that_stays_is_not_carried_away(film_animal):
    centre = way(0.0)
    pictures = film_animal(centre, np.zeros(N), size=(120, 120))
    np.testing.assert_allclose(follow(pictures, centre, 8), centre, atol=0.02 * EXTENT)


def test_before_a_panning_camera_what_stays_in_the_scene_goes_with_it(film_animal):
    """The ground goes 2 px a frame to the left, and the animal that stands on it as well."""
    camera = np.stack([-2.0 * T, np.zeros(N)], axis=-1)
    centre = np.array([150.0, 60.0]) + camera
    pictures = film_animal(centre, np.zeros(N), camera=camera, size=(220, 120))
    np.testing.assert_allclose(follow(pictures, centre, 20), centre, atol=0.05 * EXTENT)


def test_where_it_was_lost_a_later_click_finds_it_again(film_animal):
    """It goes 50 px while nothing of it is seen, in frames 14 to 23."""
    hidden = slice(14, 24)
    centre = way(5.0)
    pictures = film_animal(centre, np.zeros(N), size=(320, 120))
    pictures[hidden] = film_animal(centre + 1000.0, np.zeros(N), size=(320, 120))[hidden]
    lost = follow(pictures, centre, 5)
    assert np.abs(lost[24:] - centre[24:]).max() > 0.8 * EXTENT
    found = follow(pictures, centre, 5, 35)
    np.testing.assert_allclose(found[[5, 35]], centre[[5, 35]])
    np.testing.assert_allclose(found[35:], centre[35:], atol=0.1 * EXTENT)
    np.testing.assert_allclose(found[:5], centre[:5], atol=0.1 * EXTENT)
    np.testing.assert_allclose(found, centre, atol=0.5 * EXTENT)


def test_clicks_where_it_was_not_lost_change_nothing(film_animal):
    """Those of other points of it lie elsewhere on it."""
    centre = way(2.0)
    pictures = film_animal(centre, np.zeros(N), size=(200, 120))
    other = {30: centre[30] + np.array([[18.0, 5.0]]), 20: centre[20][None]}
    both = follow_animal(pictures, find_camera_motion(pictures), clicks=other, extent=EXTENT)
    np.testing.assert_array_equal(both, follow(pictures, centre, 20))


def test_of_two_ways_the_one_that_arrives_counts_more():
    """There stops half way; back arrives at the beginning."""
    true = np.stack([np.arange(11.0), np.zeros(11)], axis=-1)
    there = np.minimum(true, 5.0)
    np.testing.assert_allclose(between_two_ways(there, true), true, atol=1e-4)
