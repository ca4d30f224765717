"""StickPoser without a browser: scale by two clicks, fit to the picture, layers of both methods."""

import numpy as np
import pytest
import small_pose_trial as scene

from pawnb.core.pose.poses import leg_angles
from pawnb.errors import InputError
from pawnb.trial import load_trial
from pawnb.widgets.fit_layers import FIT_SLIDERS as FIT_SETTINGS
from pawnb.widgets.scale_clicks import ScaleClicks
from pawnb.widgets.stick_poser import StickPoser


@pytest.fixture
def poser(tmp_path):
    widget = StickPoser(scene.write_pose_trial(tmp_path / "trial"), frame=scene.EMPTY)
    yield widget
    widget.close()


def act(widget, action, value=None):
    widget.edit("action", {"frame": scene.EMPTY, "action": action, "value": value})


def click(widget, u, v):
    widget.edit("click", {"frame": scene.EMPTY, "view": "top", "u": u, "v": v})


def test_two_clicks_and_a_length_give_the_scale_of_the_trial(poser):
    folder = poser.trial.folder
    act(poser, "scale")
    assert "Click one end" in poser.status
    assert "stick" not in poser.overlay(scene.EMPTY)["views"]["top"]
    click(poser, 20.0, 40.0)
    assert not next(a for a in poser.actions if a["id"] == "use_scale")["enabled"]
    click(poser, 20.0, 100.0)
    act(poser, "known_length", 20.0)
    assert "3 ± 0.071 px per mm" in poser.status  # 60 px over 20 mm; clicks of sd 1 px
    poser.edit("moved", {"frame": 2, "point": "end 2", "u": 100.0, "v": 40.0, "whole": True})
    marks = poser.overlay(scene.EMPTY)["views"]["top"]
    assert [(p["u"], p["v"]) for p in marks["points"]] == [(20.0, 40.0), (100.0, 40.0)]
    act(poser, "use_scale")
    assert load_trial(folder).calibration.px_per_unit == 4.0
    # nobody has posed the animal yet: it takes that size
    assert poser.session.pose.scale == 4.0
    assert poser.overlay(scene.EMPTY)["views"]["top"]["stick"]["scale"] == 4.0


@pytest.mark.slow
def test_a_proposal_says_how_far_it_is(poser, monkeypatch):
    said = []
    poser.observe(lambda change: said.append(change["new"]), names="status")
    act(poser, "propose")
    told = [text for text in said if text.startswith("Looking for")]
    assert told[0] == "Looking for the empty scene: 0 %."
    scene_told = [text for text in told if "empty scene" in text]
    assert told[len(scene_told)] == "Looking for the animal: 0 %."
    assert told[-1] == "Looking for the animal: 100 %."
    shares = [int(text.split()[-2]) for text in scene_told]
    assert shares == sorted(shares)
    assert not poser.status.startswith("Looking for")
    assert poser.session.proposed
    # where it cannot be done, what was said before stands there again
    before = poser.status
    monkeypatch.setattr(
        "pawnb.widgets.stick_poser.propose_pose_in_views", lambda *_, **__: {}["none"]
    )
    with pytest.raises(KeyError):
        act(poser, "propose")
    assert poser.status == before


def test_a_pose_made_by_hand_keeps_its_size(poser):
    poser.edit("moved", {"frame": 2, "point": "body", "u": 150.0, "v": 118.0, "whole": True})
    act(poser, "scale")
    click(poser, 20.0, 40.0)
    click(poser, 20.0, 80.0)
    act(poser, "use_scale")
    assert poser.session.pose.scale == scene.SCALE


def test_clicks_of_the_scale_that_cannot_be():
    clicks = ScaleClicks()
    with pytest.raises(InputError, match="known length is 0"):
        clicks.set_length(0.0)
    with pytest.raises(InputError, match="end 1 was not clicked"):
        clicks.move("end 1", 3.0, 4.0)
    clicks.click(1.0, 1.0)
    clicks.click(2.0, 1.0)
    with pytest.raises(InputError, match="far from each other"):
        clicks.result()
    clicks.click(90.0, 1.0)  # the nearer end goes there
    assert clicks.ends == {"end 1": (1.0, 1.0), "end 2": (90.0, 1.0)}


@pytest.mark.slow
def test_a_rough_pose_is_fitted_and_can_be_undone(poser):
    at = {"frame": scene.EMPTY, "whole": True}
    u, v = scene.XY
    poser.edit("moved", {**at, "point": "body", "u": u + 4, "v": v - 3})
    turn = np.radians(scene.HEADING + 4)
    ahead = (u + 4 + 50 * np.cos(turn), v - 3 + 50 * np.sin(turn))
    poser.edit("moved", {**at, "point": "heading", "u": ahead[0], "v": ahead[1]})
    before = poser.session.pose.xy
    act(poser, "fit")
    found = poser.session.poses()
    np.testing.assert_allclose(found.xy[0], scene.XY, atol=0.6)
    off = leg_angles(scene.SPECIES, found) - leg_angles(scene.SPECIES, scene.truth())
    assert np.abs(off).max() < 1.5
    act(poser, "undo")
    assert poser.session.pose.xy == before


def test_layers_of_the_default_method_follow_its_settings(poser):
    poser.session.propose(scene.SPECIES, scene.truth())
    act(poser, "layer", "unexplained")
    told = poser.overlay(scene.EMPTY)
    assert told["views"]["top"]["tint"]["url"].startswith("data:image/png")
    assert told["caption"].startswith("cost -")
    assert [line["id"] for line in poser.sliders] == ["length", *FIT_SETTINGS]
    shown, view = poser._look()
    dark = view.darkness > 0.4
    assert view.unexplained[dark].mean() < 0.2
    opaque = shown.paint(view, "darkness")[..., 3]
    assert opaque[dark].mean() > 3 * opaque[~dark].mean()
    act(poser, "unexplained_sd", 0.3)
    assert poser.fit_settings.unexplained_sd == 0.3
    assert poser.overlay(scene.EMPTY)["caption"] != told["caption"]
    act(poser, "estimate")
    assert poser.overlay(scene.EMPTY)["caption"] == told["caption"]
    act(poser, "layer", "segmentation")
    assert poser.overlay(scene.EMPTY)["caption"].startswith("energy")
    act(poser, "layer", "nothing")
    assert "tint" not in poser.overlay(scene.EMPTY)["views"]["top"]


def test_a_leg_that_is_off_is_named(poser):
    poser.session.propose(scene.SPECIES, scene.truth())
    act(poser, "layer", "painted")
    assert "Poorly explained" not in poser.status
    tip = poser.session.pose.places("R2")[-1]
    poser.edit("moved", {"frame": 2, "point": "R2", "u": tip[0] - 30, "v": tip[1], "whole": True})
    assert "R2 to" in poser.status


def test_a_scale_that_another_window_has_measured_stays(poser):
    other = StickPoser(poser.trial.folder, frame=scene.EMPTY)
    message = {"type": "edit", "who": "b", "n": 1, "frame": scene.EMPTY, "what": "action"}
    for widget, far in ((other, 100.0), (poser, 80.0)):
        act(widget, "scale")
        click(widget, 20.0, 40.0)
        click(widget, 20.0, far)
        widget._receive(widget, message | {"action": "use_scale"}, [])
    other.close()
    assert load_trial(poser.trial.folder).calibration.px_per_unit == 6.0  # 60 px over 10 mm
    assert "px_per_unit is 6.0 there and was 2 when the trial was read" in poser.alarm
    assert len(poser.measuring.ends) == 2  # what was clicked is still there
