"""StickPoser in a real browser: a leg follows the mouse, and Python keeps what was seen."""

import numpy as np
import pytest
import small_pose_trial as scene

from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.poses import joint_positions, tip_positions

pytestmark = pytest.mark.browser


@pytest.fixture(scope="session")
def pose_trial(tmp_path_factory):
    return scene.write_pose_trial(tmp_path_factory.mktemp("pose") / "trial")


@pytest.fixture
def posing(notebook, pose_trial, tmp_path):
    """Open the widget on the painted spider, at a frame that shows it."""
    file = tmp_path / "start_pose.csv"
    notebook.show(f"""from pawnb.widgets import StickPoser
w = StickPoser({str(pose_trial)!r}, frame={scene.EMPTY}, path={str(file)!r})
w""")
    return notebook, file


def handle(notebook, name):
    """Where a handle is, px of the view."""
    found = notebook.js(f"c.stages[0].stick.handles().find((h) => h.id === '{name}')")
    return np.array([found["u"], found["v"]])


def drag(notebook, name, to, **options):
    notebook.drag("top", handle(notebook, name), to, **options)


def saved(file):
    animal, poses = read_start_pose(file, scene.SPECIES)
    return animal, poses, joint_positions(animal, poses)[0]


def seen(notebook):
    """Joints and tips as the browser draws them, (legs, joints, 2)."""
    return np.array(
        notebook.js("c.stages[0].stick.spec.legs.map((l) => c.stages[0].stick.places(l))")
    )


def test_body_heading_and_size_are_dragged_onto_the_animal(posing):
    notebook, file = posing
    drag(notebook, "body", scene.XY)
    notebook.settle()
    turn = np.radians(scene.HEADING)
    drag(notebook, "heading", np.array(scene.XY) + 60 * np.array([np.cos(turn), np.sin(turn)]))
    notebook.settle()
    _, poses, _ = saved(file)
    np.testing.assert_allclose(poses.xy[0], scene.XY, atol=0.6)
    assert poses.heading_deg[0] == pytest.approx(scene.HEADING, abs=1.5)
    assert poses.scale[0] == pytest.approx(scene.SCALE)  # that of the calibration
    # the first pose lies on the painted animal now
    np.testing.assert_allclose(
        tip_positions(scene.SPECIES, poses), tip_positions(scene.SPECIES, scene.truth()), atol=3
    )
    u, v = handle(notebook, "span")
    away = np.array([u, v]) - poses.xy[0]
    drag(notebook, "span", poses.xy[0] + 0.8 * away)
    notebook.settle()
    assert saved(file)[1].scale[0] == pytest.approx(0.8 * scene.SCALE, rel=0.02)
    notebook.assert_no_errors()


@pytest.mark.parametrize("name", ["L2.PT", "R3.CF", "R1", "L4"])
def test_a_leg_is_bent_and_what_was_seen_is_kept(posing, name):
    notebook, file = posing
    # towards the body, so that a tip stays within reach, and a little aside
    to = 0.85 * handle(notebook, name) + 0.15 * handle(notebook, "body") + [4, -6]
    drag(notebook, name, to, release=False)
    held = seen(notebook)
    if "." not in name:  # a tip follows the mouse
        i = scene.SPECIES.leg_names.index(name)
        np.testing.assert_allclose(held[i, -1], to, atol=1.0)
    notebook.page.mouse.up()
    notebook.settle()
    # Python has bent the leg by the same rules as the browser
    np.testing.assert_allclose(saved(file)[2], held, atol=0.02)
    np.testing.assert_allclose(seen(notebook), held, atol=0.02)
    assert notebook.js("c.selected") == ["top", name.split(".")[0]]
    assert notebook.py("len(w.session._past)") == 1  # one change a drag
    notebook.assert_no_errors()


def test_esc_lets_go_and_undo_takes_back(posing):
    notebook, file = posing
    before = seen(notebook)
    drag(notebook, "R2", np.add(handle(notebook, "R2"), (-25, -15)), release=False)
    assert np.abs(seen(notebook) - before).max() > 10
    notebook.press("Escape")
    notebook.page.mouse.up()
    notebook.settle()
    np.testing.assert_allclose(seen(notebook), before, atol=1e-6)
    assert not file.exists()
    drag(notebook, "R2", np.add(handle(notebook, "R2"), (-25, -15)))
    notebook.settle()
    notebook.press("Control+z")
    notebook.settle()
    np.testing.assert_allclose(seen(notebook), before, atol=1e-6)


def test_mirror_missing_and_length_by_keys(posing):
    notebook, file = posing
    drag(notebook, "L1", np.add(handle(notebook, "L1"), (-10, -12)))
    notebook.settle()
    notebook.press("Shift+L")
    notebook.settle()
    angles = dict(zip(scene.SPECIES.joints, saved(file)[1].angles_deg[0], strict=True))
    for joint in ("BC", "CF", "PT", "TM", "MT"):
        assert angles[f"L1_{joint}"] == pytest.approx(angles[f"R1_{joint}"])
    notebook.page.locator(".pawnb-chip[data-point=R4]").click()
    notebook.settle()
    notebook.press("m")
    notebook.settle()
    assert "R4" not in saved(file)[0].leg_names
    assert notebook.js("c.stages[0].stick.handles().some((h) => h.id === 'R4')") is False
    notebook.page.locator(".pawnb-chip[data-point=L3]").click()
    notebook.settle()
    notebook.press("]")
    notebook.settle()
    np.testing.assert_allclose(
        saved(file)[0].leg("L3").lengths, 1.02 * np.array(scene.SPECIES.leg("L3").lengths)
    )
    slider = notebook.page.locator("[data-slider=length] input")
    slider.fill("1.2")
    notebook.settle()
    notebook.until("round(w.session.pose.length_of('L3'), 3)", 1.2)
    notebook.assert_no_errors()


def test_the_proposal_lies_on_the_animal_and_is_accepted(posing):
    notebook, file = posing
    notebook.focus()
    notebook.press("p")
    notebook.settle()
    assert "proposed" in notebook.page.locator(".pawnb-status").inner_text()
    assert not file.exists()
    notebook.press("Enter")
    notebook.settle()
    animal, poses, _ = saved(file)
    truth = scene.truth()
    assert (np.hypot(*(poses.xy - truth.xy)[0])) < 2
    off = np.hypot(*(tip_positions(animal, poses) - tip_positions(scene.SPECIES, truth))[0].T)
    assert off.max() < 0.05 * scene.SPECIES.span * scene.SCALE
    notebook.assert_no_errors()


def test_layers_of_the_published_method_follow_its_settings(posing):
    notebook, file = posing
    notebook.focus()
    notebook.press("p")
    notebook.settle()
    menu = notebook.page.locator("[data-action=layer]")
    menu.select_option("segmentation")
    notebook.settle()
    notebook.wait("c.stages[0].tint && c.stages[0].tint.image.complete")
    u0, v0, u1, v1 = notebook.js("c.stages[0].tint.box")
    assert u0 < scene.XY[0] < u1
    assert v0 < scene.XY[1] < v1
    assert "Energy: likelihood" in notebook.page.locator(".pawnb-status").inner_text()
    before = notebook.js("c.stages[0].tint.url")
    menu.select_option("shape_prior")
    notebook.settle()
    prior = notebook.js("c.stages[0].tint.url")
    assert prior != before
    notebook.page.locator("[data-slider=thickness_px] input").fill("3")
    notebook.settle()
    notebook.until("w.settings.thickness_px", 3.0)
    assert notebook.js("c.stages[0].tint.url") != prior
    notebook.page.locator("[data-action=estimate]").click()
    notebook.settle()
    notebook.until("w.settings.thickness_px", None)
    notebook.page.locator("[data-action=layer]").select_option("nothing")
    notebook.settle()
    assert notebook.js("c.stages[0].tint") is None
    assert not file.exists()  # looking changes nothing
    notebook.assert_no_errors()


def test_keys_reach_the_notebook_only_outside(posing):
    notebook, file = posing
    cells = notebook.n_cells()
    notebook.focus()
    for key in ("a", "b", "x", "d", "d", "Shift+Enter"):
        notebook.press(key)
    notebook.settle()
    assert notebook.n_cells() == cells
    notebook.page.locator(".jp-Cell").last.click()
    notebook.press("Escape")  # to command mode, where brackets do nothing
    notebook.press("]")
    notebook.press("[")
    assert not file.exists()
    assert notebook.py("w.session.can_undo") is False


def test_a_scale_is_clicked_and_the_length_typed(posing):
    """Digits typed in the field are not keys of the canvas: 0 would show the picture whole."""
    notebook, file = posing
    notebook.focus()
    notebook.press("c")
    notebook.settle()
    notebook.click("top", 20, 40)
    notebook.settle()
    notebook.click("top", 20, 100)
    notebook.settle()
    field = notebook.page.locator("[data-slider=known_length] input")
    field.fill("20")
    field.press("Enter")
    notebook.settle()
    assert "3 ± " in notebook.page.locator(".pawnb-status").inner_text()
    assert notebook.js("c.stages[0].stick") is None
    notebook.drag("top", np.array([20.0, 100.0]), (20, 120))
    notebook.settle()
    ends = notebook.py("w.measuring.ends")  # the page may scroll under the hand
    assert ends["end 2"][1] > 103
    np.testing.assert_allclose(ends["end 1"], (20, 40), atol=0.5)
    notebook.focus()
    notebook.press("c")
    notebook.settle()
    assert notebook.js("c.stages[0].stick !== null")
    assert not file.exists()
    notebook.assert_no_errors()


def test_the_default_method_is_looked_at_and_fits(posing):
    notebook, file = posing
    drag(notebook, "body", np.add(scene.XY, (3, -2)))
    notebook.settle()
    turn = np.radians(scene.HEADING)
    drag(notebook, "heading", np.array(scene.XY) + 60 * np.array([np.cos(turn), np.sin(turn)]))
    notebook.settle()
    notebook.page.locator("[data-action=layer]").select_option("unexplained")
    notebook.settle()
    notebook.wait("c.stages[0].tint && c.stages[0].tint.image.complete")
    before = notebook.js("c.stages[0].tint.url")
    notebook.focus()
    notebook.press("t")
    notebook.settle()
    np.testing.assert_allclose(saved(file)[1].xy[0], scene.XY, atol=0.6)
    assert notebook.js("c.stages[0].tint.url") != before
    assert "explained" in notebook.page.locator(".pawnb-status").inner_text()
    notebook.assert_no_errors()


def test_a_second_frame_starts_the_tracking_as_well(posing):
    notebook, file = posing
    drag(notebook, "body", scene.XY)
    notebook.settle()
    notebook.press("ArrowRight")
    notebook.wait(f"c.painted === {scene.EMPTY + 1}")
    notebook.until("w.session.frame", scene.EMPTY + 1)
    notebook.wait("c.model.get('actions').some((a) => a.id === 'here_too')")
    notebook.press("Shift+F")
    notebook.settle()
    assert saved(file)[1].frames.tolist() == [scene.EMPTY, scene.EMPTY + 1]
    drag(notebook, "body", np.add(scene.XY, (12, -9)))
    notebook.settle()
    np.testing.assert_allclose(saved(file)[1].xy, [scene.XY, np.add(scene.XY, (12, -9))], atol=0.6)
    notebook.press("Shift+Delete")
    notebook.settle()
    assert saved(file)[1].frames.tolist() == [scene.EMPTY]
    notebook.assert_no_errors()
