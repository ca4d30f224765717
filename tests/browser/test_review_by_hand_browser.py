"""Corrections by hand, in a real browser: in space, and let go outside of the picture."""

import json

import numpy as np
import pytest
import small_trial as scene

pytestmark = pytest.mark.browser


def test_a_point_that_one_view_sees_is_placed_there_and_then_in_a_second_view(notebook, trial_file):
    """What was placed in one view only had no place in space, and could not be placed elsewhere."""
    notebook.show(f"""import small_trial as scene
from pawnb.schema import ORIGIN_CODE
from pawnb.widgets import TrackReviewer
tracks = scene.true_tracks()
tracks["image_origin"].values[5, 1:, 0] = ORIGIN_CODE["reprojected"]
w = TrackReviewer({str(trial_file)!r}, tracks)
w.frame = 5
w""")
    notebook.wait("c.painted === 5")
    notebook.settle()
    assert notebook.js("c.stages[1].overlay.points.some((p) => p.id === 'FR')") is False
    was = notebook.py("w.session.position(5, 'cam2', 'FR')")
    u, v = scene.seen(5)[0, 0]
    notebook.drag("cam1", (u, v), (u + 20, v))
    notebook.settle()
    status = notebook.page.locator(".pawnb-status")
    assert "only cam1 sees it, so its distance from there is a guess" in status.inner_text()
    # cam2 looks across: a point that keeps its distance from cam1 moves there, too
    shown = notebook.js("c.stages[1].overlay.hollow.find((p) => p.id === 'FR')")
    assert np.hypot(shown["u"] - was[0], shown["v"] - was[1]) > 5
    notebook.page.locator("[data-view=cam2] [data-point=FR]").click()
    notebook.click("cam2", *was)
    notebook.settle()
    np.testing.assert_allclose(notebook.py("w.session.position(5, 'cam2', 'FR')"), was, atol=1.1)
    file = trial_file.parent / "results" / "edits.jsonl"
    made = [json.loads(line) for line in file.read_text().splitlines()]
    assert [line["view"] for line in made] == [
        "cam1", "cam2",
    ]  # fmt: skip
    assert "only" not in status.inner_text()
    notebook.assert_no_errors()


def test_a_point_that_is_let_go_outside_of_the_picture_stays_where_it_was(notebook, trial_file):
    """It was put on the border of the picture, as a person's word; zoomed in, out of sight."""
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks())
w""")
    file, mouse = trial_file.parent / "results" / "edits.jsonl", notebook.page.mouse
    first = scene.seen(0)[0, 0]
    x, y = notebook.at("cam1", *first)
    top = notebook.page.locator("[data-view=cam1] .pawnb-marks").bounding_box()["y"]
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, top - 40, steps=5)
    held = notebook.js("c.stages[0].drag.point")
    np.testing.assert_allclose((held["u"], held["v"]), first, atol=0.01)
    mouse.up()
    notebook.settle()
    assert not file.exists()
    # a hand that overshoots a little means the border
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, top - 6, steps=5)
    mouse.up()
    notebook.settle()
    (made,) = [json.loads(line) for line in file.read_text().splitlines()]
    assert made["edit"] == "move"
    assert made["v"] == pytest.approx(-0.49)
    notebook.assert_no_errors()
