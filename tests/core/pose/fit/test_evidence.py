"""Darkness relative to the background survives a shadow and a slope of light."""

from types import SimpleNamespace

import numpy as np

from pawnb.core.pose.fit.evidence import Evidence, reduced


def scene(light: np.ndarray):
    """A disc that takes 70 % of the light, on a panel lit by ``light`` times its background."""
    v, u = np.mgrid[:200, :200]
    empty = 200.0 - 0.2 * u
    disc = np.hypot(u - 100, v - 100) < 25
    image = empty * light * np.where(disc, 0.3, 1.0)
    covered = np.where(np.hypot(u - 100, v - 100) < 32, 0, -1)
    background = SimpleNamespace(mean=empty, sd=np.full(empty.shape, 2.0))
    return background, image, covered, disc


def test_a_shadow_leaves_darkness_as_it_is():
    u = np.arange(200.0)
    for light in (np.ones((200, 200)), np.tile(0.8 - 0.25 * u / 200, (200, 1))):
        background, image, covered, disc = scene(light)
        evidence = Evidence(background, factor=1, light=0.0, spread=0.1)
        sight = evidence.sight(image, (0, 0, 200, 200), covered)
        assert abs(np.median(sight.seen[disc]) - 0.7) < 0.03
        assert np.abs(sight.seen[~disc]).max() < 0.1


def test_light_animals_count_as_dark():
    background, _, covered, disc = scene(np.ones((200, 200)))
    image = np.where(disc, 250.0, background.mean * 0.5)
    background.mean = background.mean * 0.5
    evidence = Evidence(background, factor=1, light=250.0, spread=0.1)
    sight = evidence.sight(image, (0, 0, 200, 200), covered)
    assert abs(np.median(sight.seen[disc]) - 1.0) < 0.03
    assert np.abs(sight.seen[~disc]).max() < 0.05


def test_crop_stays_inside_the_picture_and_reduction_is_the_mean_of_squares():
    background = SimpleNamespace(mean=np.arange(24.0).reshape(4, 6), sd=np.ones((4, 6)))
    evidence = Evidence(background, factor=2, light=0.0, spread=0.1)
    np.testing.assert_array_equal(evidence.mean, [[3.5, 5.5, 7.5], [15.5, 17.5, 19.5]])
    np.testing.assert_allclose(evidence.sd, 0.5)
    assert evidence.crop_box(np.array([0.0, 50.0]), 4.0) == (0, 0, 3, 2)
    np.testing.assert_array_equal(reduced(np.ones((5, 5)), 2), np.ones((2, 2)))
