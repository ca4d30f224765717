"""An animal is followed by what moves about its clicks."""

from __future__ import annotations

import numpy as np

from pawnb.core.paws.offline.scene.registration.camera_motion import find_camera_motion
from pawnb.core.paws.offline.scene.registration.following import follow_animal

N, EXTENT = 40, 50.0
T = np.arange(N)


def follow(pictures, centre, begin):
    return follow_animal(
        pictures, find_camera_motion(pictures), begin=begin, centre=centre[begin], extent=EXTENT
    )


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
