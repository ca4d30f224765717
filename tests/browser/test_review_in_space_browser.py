"""Corrections in space, in a real browser: what one view, then a second, makes of a point."""

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
