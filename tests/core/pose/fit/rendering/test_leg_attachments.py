"""The corners between legs and body turn it no longer, and only they lose their weight."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.fitter import FrameFitter, make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, paint_some
from pawnb.core.pose.fit.rendering.leg_attachments import without_leg_attachments
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species

SCALE, SIZE = 2.4, 220


@pytest.fixture
def scene():
    """A fitter, a pose and its sight: legs and body cover what they cover, each by itself.

    The legs are turned, on both sides about the same way, so that the corners turn the body.
    """
    animal = load_species("dolomedes")
    layout = make_layout(animal, px_per_unit=SCALE)
    natural = natural_pose(animal, xy=(108.0, 110.0), heading_deg=20.0, scale=SCALE)
    prior = anatomy(animal, pose_vectors(animal, natural)[0], foreshortening_sd=0.12)
    fitter = make_fitter(
        animal, layout, evidence=SimpleNamespace(), anatomy=prior, settings=PoseSettings()
    )
    pose = pose_vectors(animal, natural)[0]
    for leg, side in enumerate(layout.side):
        pose[fitter.index.numbers[leg][0]] += 0.6 * side
    legs, body = (
        painted(fitter, pose, shown)
        for shown in (~fitter.index.body_shown, fitter.index.body_shown)
    )
    dark = layout.ellipse[:, 4].max()
    # what light one lets through, the other stops: independent covers, as of two films
    seen = dark * (1.0 - (1.0 - np.minimum(legs / dark, 1.0)) * (1.0 - body / dark))
    return fitter, pose, ImageEvidence(seen, np.full((SIZE, SIZE), 70.0), np.zeros(2))


def painted(fitter: FrameFitter, pose: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Return how dark some parts are painted, 0 where they are not."""
    canvas = make_canvas(SIZE, SIZE, fitter.layout)
    paint_some(fitter.layout, pose, fitter.blur, np.zeros(2), shown, *canvas)
    return np.where(canvas[1] == -1, 0.0, canvas[0])


def test_only_what_both_cover_in_part_loses_its_weight(scene):
    fitter, pose, image_evidence = scene
    weight = without_leg_attachments(fitter, pose, image_evidence).weight
    gone = weight == 0.0
    assert 20 < gone.sum() < 400
    assert (weight[~gone] == 70.0).all()
    for shown in (~fitter.index.body_shown, fitter.index.body_shown):
        alone = painted(fitter, pose, shown)
        assert (alone[gone] > 0.0).all()
    assert (image_evidence.weight == 70.0).all()


def test_corners_turn_the_body_less_without_their_weight(scene):
    fitter, pose, image_evidence = scene
    without = without_leg_attachments(fitter, pose, image_evidence)
    turned, left = (
        fitter.fit(pose, seen, fitter.anatomy, rounds=30, enough=1e-4)[0][2] - pose[2]
        for seen in (image_evidence, without)
    )
    assert abs(turned) > np.radians(0.05)
    assert abs(left) < 0.3 * abs(turned)


def test_a_crop_that_cuts_the_body_is_no_hindrance(scene):
    fitter, pose, image_evidence = scene
    whole = without_leg_attachments(fitter, pose, image_evidence).weight
    cut = ImageEvidence(
        image_evidence.seen[100:, 90:], image_evidence.weight[100:, 90:], np.array([90.0, 100.0])
    )
    np.testing.assert_array_equal(
        without_leg_attachments(fitter, pose, cut).weight, whole[100:, 90:]
    )
