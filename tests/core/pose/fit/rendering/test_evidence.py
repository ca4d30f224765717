"""Darkness relative to the background survives a shadow and a slope of light."""

from types import SimpleNamespace

import numpy as np

from pawnb.core.pose.fit.rendering.evidence import make_evidence, reduced, without_wide
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence


def scene(light: np.ndarray):
    """A disc that takes 70 % of the light, on a panel lit by ``light`` times its background."""
    v, u = np.mgrid[:200, :200]
    empty = 200.0 - 0.2 * u
    disc = np.hypot(u - 100, v - 100) < 25
    image = empty * light * np.where(disc, 0.3, 1.0)
    covered = np.where(np.hypot(u - 100, v - 100) < 32, 0, -1)
    # the panel goes on beyond what is looked at, as it does beyond a crop
    empty = np.pad(empty, 2, mode="edge")
    background = SimpleNamespace(mean=empty, sd=np.full(empty.shape, 2.0))
    return background, image, covered, disc


BOX = (2, 2, 202, 202)


def test_a_shadow_leaves_darkness_as_it_is():
    u = np.arange(200.0)
    for light in (np.ones((200, 200)), np.tile(0.8 - 0.25 * u / 200, (200, 1))):
        background, image, covered, disc = scene(light)
        evidence = make_evidence(background, factor=1, light=0.0, spread=0.1)
        image_evidence = evidence.image_evidence(image, BOX, covered)
        assert abs(np.median(image_evidence.seen[disc]) - 0.7) < 0.03
        assert np.abs(image_evidence.seen[~disc]).max() < 0.1


def test_light_animals_count_as_dark():
    background, _, covered, disc = scene(np.ones((200, 200)))
    image = np.where(disc, 250.0, background.mean[2:202, 2:202] * 0.5)
    background.mean = background.mean * 0.5
    evidence = make_evidence(background, factor=1, light=250.0, spread=0.1)
    image_evidence = evidence.image_evidence(image, BOX, covered)
    assert abs(np.median(image_evidence.seen[disc]) - 1.0) < 0.03
    assert np.abs(image_evidence.seen[~disc]).max() < 0.05


def test_crop_stays_inside_the_picture_and_reduction_is_the_mean_of_squares():
    background = SimpleNamespace(mean=np.arange(24.0).reshape(4, 6), sd=np.ones((4, 6)))
    evidence = make_evidence(background, factor=2, light=0.0, spread=0.1)
    np.testing.assert_array_equal(evidence.mean, [[3.5, 5.5, 7.5], [15.5, 17.5, 19.5]])
    np.testing.assert_allclose(evidence.sd, 0.5)
    assert evidence.crop_box(np.array([0.0, 50.0]), 4.0) == (0, 0, 3, 2)
    np.testing.assert_array_equal(reduced(np.ones((5, 5)), 2), np.ones((2, 2)))


def test_what_is_wider_than_a_leg_is_taken_as_a_filter_before_it():
    # a leg 3 px wide that takes 60 % of the light, half of it behind a wing that takes 20 %
    wing, leg = np.zeros((80, 80)), np.zeros((80, 80))
    wing[20:60, 40:75] = 0.2
    leg[39:42, 5:70] = 0.6
    seen = 1.0 - (1.0 - wing) * (1.0 - leg)
    nowhere = np.zeros(seen.shape, bool)
    thin = without_wide(
        ImageEvidence(seen, np.full(seen.shape, 50.0), np.zeros(2)), nowhere, size=11
    )
    assert abs(thin.seen[40, 10:35].mean() - 0.6) < 0.01
    assert abs(thin.seen[40, 45:68].mean() - 0.6) < 0.03
    assert np.abs(thin.seen[25:35, 45:70]).max() < 0.05
    assert thin.weight[30, 55] < thin.weight[40, 20]
    # a body is wide itself
    body = wing > 0
    kept = without_wide(ImageEvidence(seen, np.full(seen.shape, 50.0), np.zeros(2)), body, size=11)
    np.testing.assert_allclose(kept.seen[body], seen[body])
