"""The published method's view of a painted spider, while its settings change."""

import numpy as np
import pytest
import small_pose_trial as scene

from pawnb.core.pose.background import Background
from pawnb.errors import InputError
from pawnb.trial import Animal, Trial
from pawnb.widgets.stick_layers import PULLAR_LAYERS, PULLAR_SLIDERS, EnergyLayers
from pawnb.widgets.stick_session import StickSession


@pytest.fixture(scope="module")
def empty():
    frames = np.stack([scene.picture(k) for k in range(scene.EMPTY)]).astype(np.float32)
    return Background(
        mean=frames.mean(axis=0),
        sd=np.full(frames[0].shape, 2.0, np.float32),
        n_frames=2,
        source="",
    )


@pytest.fixture
def session(tmp_path):
    trial = Trial(kind="pose", name="t", fps=1.0, animal=Animal(id="a"), folder=tmp_path)
    size = (scene.WIDTH, scene.HEIGHT)
    made = StickSession(trial, scene.SPECIES, size=size, span=(0, 5), frame=scene.EMPTY)
    made.propose(scene.SPECIES, scene.truth())
    return made


@pytest.fixture
def layers():
    made = EnergyLayers()
    made.show("segmentation")
    return made


def test_segmentation_and_prior_lie_on_the_animal(layers, session, empty):
    view = layers.look(session, scene.picture(scene.EMPTY), empty)
    u0, v0, u1, v1 = view.box
    dark = scene.picture(scene.EMPTY)[v0:v1, u0:u1] < 125
    assert (view.segmentation & dark).sum() / (view.segmentation | dark).sum() > 0.8
    for name in PULLAR_LAYERS:
        assert layers.paint(view, name).shape == (v1 - v0, u1 - u0, 4)
    clear = layers.paint(view, "segmentation")[..., 3] == 0
    np.testing.assert_array_equal(clear, ~view.segmentation)
    opaque = layers.paint(view, "shape_prior")[..., 3]
    assert opaque[dark].mean() > 4 * opaque[~dark].mean()
    assert all(word in layers.in_words(view) for word in ("likelihood", "shape prior", "Ising"))


def test_a_setting_has_its_effect_and_can_be_estimated_again(layers, session, empty):
    picture = scene.picture(scene.EMPTY)
    usual = layers.look(session, picture, empty)
    assert layers.look(session, picture, empty) is usual  # computed once
    sliders = {line["id"]: line for line in layers.sliders()}
    assert list(sliders) == list(PULLAR_SLIDERS)
    for name, line in sliders.items():
        estimated = getattr(usual.parameters, name)
        assert line["min"] < line["value"] < line["max"]
        assert line["value"] == pytest.approx(estimated, rel=0.01)
    layers.set("thickness_px", 4 * usual.parameters.thickness_px)
    wide = layers.look(session, picture, empty)
    # Eq. 3.15: a thicker animal makes more pixels likely to be subject
    assert wide.shape_prior.sum() > 1.5 * usual.shape_prior.sum()
    assert layers.settings.thickness_px == pytest.approx(4 * usual.parameters.thickness_px)
    layers.reset()
    again = layers.look(session, picture, empty)
    np.testing.assert_array_equal(again.segmentation, usual.segmentation)


def test_the_view_follows_the_pose(layers, session, empty):
    picture = scene.picture(scene.EMPTY)
    usual = layers.look(session, picture, empty)
    session.drag("heading", scene.XY[0], scene.XY[1] - 50)
    assert layers.look(session, picture, empty).energy > usual.energy


def test_unknown_names_are_refused(layers):
    with pytest.raises(InputError, match="expected one of segmentation"):
        layers.show("segments")
    with pytest.raises(InputError, match="expected one of ising"):
        layers.set("isling", 3.0)
    layers.show("")
    assert layers.sliders() == []
