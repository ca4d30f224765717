"""What sticks out of the body is found, and does not draw it."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.fitter import make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.learning.attached_clutter_kernels import disregard
from pawnb.core.pose.fit.learning.body_clutter import find_body_clutter, without_body_clutter
from pawnb.core.pose.fit.learning.clutter import Clutter
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species

SCALE, SIZE = 2.4, 200


@pytest.fixture
def scene():
    """A fitter, and frames of a spider with something in front of its head, two heads wide."""
    animal = load_species("dolomedes")
    settings = PoseSettings()
    layout = make_layout(animal, px_per_unit=SCALE)
    natural = natural_pose(animal, xy=(98.0, 100.0), scale=SCALE)
    prior = anatomy(animal, pose_vectors(animal, natural)[0], foreshortening_sd=0.12)
    fitter = make_fitter(
        animal, layout, evidence=SimpleNamespace(), anatomy=prior, settings=settings
    )
    frames = []
    for t in range(8):
        natural = natural_pose(animal, xy=(98.0 + 0.4 * t, 100.0), heading_deg=5.0 * t, scale=SCALE)
        pose = pose_vectors(animal, natural)[0]
        canvas = make_canvas(SIZE, SIZE, layout)
        paint(layout, pose, fitter.blur, np.zeros(2), *canvas)
        seen = canvas[0].copy()
        v, u = np.mgrid[:SIZE, :SIZE]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        forward = (u - pose[0]) * cos + (v - pose[1]) * sin
        right = -(u - pose[0]) * sin + (v - pose[1]) * cos
        jaws = (np.abs(forward - 14 * SCALE) < 2.0) & (np.abs(right) < 3.0)
        seen[jaws & (canvas[1] < 0)] = 0.8
        frames.append((pose, ImageEvidence(seen, np.full((SIZE, SIZE), 70.0), np.zeros(2))))
    return fitter, frames


def test_what_sticks_out_does_not_count_and_the_rest_does(scene):
    fitter, frames = scene
    kept = find_body_clutter(fitter, frames)
    half = kept.shape[0] // 2
    assert kept[half, half + round(14 * SCALE) + 1] == 0.0  # the jaws, in front
    assert kept[half, half - round(14 * SCALE) :][: round(26 * SCALE)].min() == 1.0
    assert 1.0 - kept.mean() < 0.05


def test_without_odd_places_nothing_counts_at_the_jaws_and_the_evidence_stays_as_it_was(
    scene,
):
    fitter, frames = scene
    fitter = fitter.with_clutter(Clutter(body=find_body_clutter(fitter, frames)))
    pose, image_evidence = frames[3]
    counts = without_body_clutter(fitter, pose, image_evidence).weight
    ahead = 14 * SCALE * np.array([np.cos(pose[2]), np.sin(pose[2])])
    u, v = np.round(pose[:2] + ahead).astype(int)
    assert counts[v, u] == 0.0
    assert counts[round(pose[1]), round(pose[0])] == 70.0
    assert (image_evidence.weight == 70.0).all()


def test_too_few_frames_tell_nothing(scene):
    fitter, frames = scene
    assert find_body_clutter(fitter, frames[:5]) is None
    pose, image_evidence = frames[0]
    assert without_body_clutter(fitter, pose, image_evidence) is image_evidence


def test_the_weight_is_taken_where_the_place_lies_in_the_picture():
    kept = np.ones((41, 41))
    kept[19:22, 29:32] = 0.0  # ten px ahead of the origin
    weight = np.full((60, 60), 3.0)
    disregard(kept, np.array([25.0, 30.0, np.pi / 2]), np.array([5.0, 0.0]), weight)
    assert weight[40, 20] == 0.0  # ahead is down, and the crop begins at u = 5
    assert weight[20, 20] == 3.0
    assert weight.sum() == pytest.approx(3.0 * (3600 - 9), abs=1e-6)
