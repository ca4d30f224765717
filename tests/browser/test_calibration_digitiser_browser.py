"""CalibrationDigitiser in a real browser: clicked, undone, set aside, written, opened again."""

import ball_scene as scene
import numpy as np
import pytest

pytestmark = pytest.mark.browser


@pytest.fixture
def digitising(notebook, tmp_path):
    """Open the widget on two pictures of twelve balls; gives what opens it again, too."""
    scene.write(tmp_path / "in")

    def show():
        notebook.show(f"""from pathlib import Path
from pawnb.widgets import CalibrationDigitiser
home = Path({str(tmp_path)!r})
w = CalibrationDigitiser({{"left": home / "in" / "left", "right": home / "in" / "right"}},
                         points=home / "in" / "points.csv", folder=home)
w""")
        return notebook, tmp_path

    return show


def status(notebook):
    return notebook.page.locator(".pawnb-status").inner_text()


def test_balls_are_clicked_undone_set_aside_written_and_opened_again(digitising):
    notebook, folder = digitising()
    notebook.focus()
    notebook.press("s")  # clicks snap to the centres of balls
    notebook.settle()
    for view in scene.VIEWS:
        for u, v in scene.seen(view, list(scene.PLACES.values())):
            notebook.click(view, u + 3.0, v - 2.0)
            notebook.settle()
    clicks = {
        (v, p): uv for v, p, uv in notebook.py("[[*k, v] for k, v in w.session.clicks.items()]")
    }
    assert len(clicks) == 24
    for (view, point), uv in clicks.items():
        np.testing.assert_allclose(uv, scene.seen(view, [scene.PLACES[point]])[0], atol=0.1)
    assert "Every point is clicked in each view." in status(notebook)
    # axes and grid are drawn over both views, and their ends are named
    for stage in (0, 1):
        names = notebook.js(f"c.stages[{stage}].overlay.hollow.map((mark) => mark.id)")
        assert names == ["x", "y", "z"]
    # one ball is dragged away: it is named; undone, it is back
    start = clicks["left", "b010"]
    notebook.press("s")
    notebook.settle()
    notebook.drag("left", start, (start[0] + 60.0, start[1] + 8.0))
    notebook.settle()
    assert "⚠ b010 in left" in status(notebook)
    notebook.press("Control+z")
    notebook.settle()
    assert "⚠" not in status(notebook)
    notebook.press("Control+y")
    notebook.settle()
    notebook.page.locator("[data-view=left] [data-point=b010]").click()
    notebook.settle()
    notebook.press("x")
    notebook.settle()
    assert "of 11 points" in status(notebook)
    assert "⚠" not in status(notebook)
    notebook.press("w")
    notebook.settle()
    assert "Wrote DLTcoefs.csv" in status(notebook)
    coefs = np.loadtxt(folder / "DLTcoefs.csv", delimiter=",")
    xyz = np.array([10.0, -20.0, 15.0])
    for column, view in zip(coefs.T, scene.VIEWS, strict=True):
        below = xyz @ column[8:11] + 1.0
        uv = (np.array([column[0:3] @ xyz, column[4:7] @ xyz]) + column[[3, 7]]) / below
        np.testing.assert_allclose(uv, scene.seen(view, [xyz])[0], atol=0.2)
    notebook.assert_no_errors()
    # opened again: everything is there, and the one that was set aside still is
    notebook.kernel_runs("w.close()")
    notebook, _ = digitising()
    assert notebook.py("len(w.session.clicks)") == 24
    chip = notebook.page.locator("[data-view=left] [data-point=b010]")
    assert "set aside" in chip.get_attribute("title")
    assert "of 11 points" in status(notebook)
    notebook.assert_no_errors()
