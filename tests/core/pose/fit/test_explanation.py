"""What the default method sees: pictures of evidence, model and difference; a fit of one frame."""

import dataclasses

import numpy as np
import pytest
from painted_walk import painted_walk

from pawnb.core.pose.fit.explanation import explain_fit, fit_to_picture
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import tip_positions
from pawnb.errors import InputError


@pytest.fixture(scope="module")
def scene():
    animal, poses, reader, background = painted_walk(3)
    return animal, poses, reader.frame(1), background


def look(scene, pose, **settings):
    animal, _, frame, background = scene
    return explain_fit(
        frame, pose, animal=animal, background=background, settings=PoseSettings(**settings)
    )


def test_the_true_pose_explains_what_is_dark(scene):
    _, poses, frame, _ = scene
    view = look(scene, poses.take([1]))
    u0, v0, u1, v1 = view.box
    assert 0 <= u0 < u1
    assert 0 <= v0 < v1
    dark = view.darkness > 0.5
    assert view.painted[dark].mean() > 0.6
    assert view.painted[view.darkness < 0.05].mean() < 0.05
    np.testing.assert_allclose(view.unexplained, np.abs(view.darkness - view.painted))
    assert min(view.support.values()) > 0.7
    # the picture is dark where the animal is
    picture = frame.crop(u0, v0, u1, v1)[: view.darkness.shape[0], : view.darkness.shape[1]]
    assert picture[dark].mean() < picture[~dark].mean() - 30


def test_a_leg_beside_its_place_is_told(scene):
    animal, poses, _, _ = scene
    angles = poses.angles_deg[[1]].copy()
    angles[0, animal.joints.index("R2_BC")] += 12.0
    wrong = dataclasses.replace(poses.take([1]), angles_deg=angles)
    right, off = look(scene, poses.take([1])), look(scene, wrong)
    assert off.support["R2"] < 0.6 * right.support["R2"]
    assert off.support["L2"] > 0.7
    assert off.cost > right.cost
    # a pixel counts less where much is expected to stay unexplained
    assert 0.5 * off.cost < look(scene, wrong, unexplained_sd=0.5).cost < 0


@pytest.mark.slow
def test_a_rough_pose_comes_onto_the_animal(scene):
    animal, poses, frame, background = scene
    rng = np.random.default_rng(3)
    true = poses.take([1])
    rough = dataclasses.replace(
        true,
        xy=true.xy + np.array([2.5, -2.0]),
        angles_deg=true.angles_deg + rng.normal(0, 5, true.angles_deg.shape),
    )
    found, support = fit_to_picture(frame, rough, animal=animal, background=background)
    assert support > 0.8
    np.testing.assert_allclose(found.xy, true.xy, atol=0.3)
    off = np.linalg.norm(tip_positions(animal, found) - tip_positions(animal, true), axis=-1)
    assert np.median(off) < 0.01 * animal.span * true.scale[0]
    away = dataclasses.replace(true, xy=np.array([[20.0, 240.0]]))
    with pytest.raises(InputError, match="is not on the animal"):
        fit_to_picture(frame, away, animal=animal, background=background)
