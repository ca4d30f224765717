"""Spines of legs are found, and do not draw their ends."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.fitter import make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.learning.clutter import Clutter
from pawnb.core.pose.fit.learning.leg_clutter import find_leg_clutter, without_leg_clutter
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species

SCALE, SIZE, LEG = 2.4, 220, 2
AWAY_PX = 2.2


def spine_places(tip: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Return where pixels of a spine lie, (n, 2) as v, u: along one side of the last segment."""
    along = (tip - before) / np.linalg.norm(tip - before)
    aside = AWAY_PX * np.array([-along[1], along[0]])
    places = tip + aside - np.linspace(2.0, 7.0, 12)[:, None] * along
    return np.unique(np.round(places[:, ::-1]).astype(int), axis=0)


@pytest.fixture
def scene():
    """A fitter, and frames of a spider that has a spine beside the end of one leg."""
    animal = load_species("dolomedes")
    layout = make_layout(animal, px_per_unit=SCALE)
    natural = natural_pose(animal, xy=(108.0, 110.0), scale=SCALE)
    prior = anatomy(animal, pose_vectors(animal, natural)[0], foreshortening_sd=0.12)
    fitter = make_fitter(
        animal, layout, evidence=SimpleNamespace(), anatomy=prior, settings=PoseSettings()
    )
    frames = []
    for t in range(8):
        natural = natural_pose(
            animal, xy=(108.0 + 0.4 * t, 110.0), heading_deg=5.0 * t, scale=SCALE
        )
        pose = pose_vectors(animal, natural)[0]
        canvas = make_canvas(SIZE, SIZE, layout)
        paint(layout, pose, fitter.blur, np.zeros(2), *canvas)
        seen = canvas[0].copy()
        v, u = spine_places(*fitter.joints(pose)[LEG][[-1, -2]]).T
        seen[v, u] = np.maximum(seen[v, u], 0.45)
        frames.append((pose, ImageEvidence(seen, np.full((SIZE, SIZE), 70.0), np.zeros(2))))
    return fitter, frames


def test_a_spine_is_found_where_it_is_and_nowhere_else(scene):
    fitter, frames = scene
    leg_clutter = find_leg_clutter(fitter, frames)
    assert leg_clutter[LEG, -1].any()
    middle = leg_clutter.shape[3] // 2
    assert not leg_clutter[LEG, -1][:, : middle + 1].any()  # it is on one side
    leg_clutter[LEG, -1] = False
    assert not leg_clutter.any()


def test_only_the_spine_loses_its_weight(scene):
    fitter, frames = scene
    fitter = fitter.with_clutter(Clutter(legs=find_leg_clutter(fitter, frames)))
    pose, image_evidence = frames[3]
    weight = without_leg_clutter(fitter, pose, image_evidence).weight
    tip, before = fitter.joints(pose)[LEG][[-1, -2]]
    gone = np.argwhere(weight == 0.0)
    spine = spine_places(tip, before)
    apart = np.linalg.norm(gone[:, None] - spine[None], axis=-1)
    assert len(gone) > 4
    assert apart.min(axis=1).max() < 2.5
    assert (weight[weight > 0.0] == 70.0).all()
    assert (image_evidence.weight == 70.0).all()


def test_without_its_spine_a_leg_is_fitted_where_it_is(scene):
    fitter, frames = scene
    pose, image_evidence = frames[5]
    true = fitter.joints(pose)[LEG, -1]
    drawn = fitter.joints(fitter.fit(pose, image_evidence, fitter.anatomy)[0])[LEG, -1]
    fitter = fitter.with_clutter(Clutter(legs=find_leg_clutter(fitter, frames)))
    without = without_leg_clutter(fitter, pose, image_evidence)
    found = fitter.joints(fitter.fit(pose, without, fitter.anatomy)[0])[LEG, -1]
    assert np.linalg.norm(drawn - true) > 0.2
    assert np.linalg.norm(found - true) < 0.5 * np.linalg.norm(drawn - true)


def test_rings_are_no_hairs(scene):
    """A ring darkens both sides of a segment alike."""
    fitter, frames = scene
    for pose, image_evidence in frames:
        canvas = make_canvas(SIZE, SIZE, fitter.layout)
        paint(fitter.layout, pose, fitter.blur, np.zeros(2), *canvas)
        ring = (canvas[1] == 64 * LEG + 3) & (np.abs(canvas[2] - 0.5) < 0.25)
        image_evidence.seen[ring] += 0.3
    leg_clutter = find_leg_clutter(fitter, frames)
    assert leg_clutter[LEG, -1].any()
    assert not leg_clutter[LEG, :-1].any()


def test_too_few_frames_tell_nothing(scene):
    fitter, frames = scene
    assert find_leg_clutter(fitter, frames[:5]) is None
    pose, image_evidence = frames[0]
    assert without_leg_clutter(fitter, pose, image_evidence) is image_evidence
