"""ClickInitialiser in a real browser: real clicks, real keys, and what reached Python."""

import json

import numpy as np
import pytest
import small_trial as scene

pytestmark = pytest.mark.browser

ORDER = [("cam1", "FR"), ("cam1", "HR"), ("cam2", "FR"), ("cam2", "HR"), ("cam3", "FR")]


@pytest.fixture
def clicking(notebook, trial_file):
    """Open the widget on a trial without start points."""
    notebook.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial_file)!r})
w""")
    return notebook, trial_file.parent / "start.csv"


def truth(view, point, frame=0):
    return scene.seen(frame)[list(scene.POINTS).index(view), ["FR", "HR"].index(point)]


def rows(path):
    """Read start.csv plainly: {(frame, view, point): (u, v)}."""
    lines = [line.split(",") for line in path.read_text().split()[1:]]
    return {(int(f), view, point): (float(u), float(v)) for f, view, point, u, v in lines}


def clicks(notebook):
    return {
        (f, view, point): tuple(uv)
        for f, view, point, uv in notebook.py("[[*k, v] for k, v in w.session.clicks.items()]")
    }


def test_clicking_every_paw_in_turn_gives_the_start(clicking):
    notebook, file = clicking
    for view, point in ORDER:
        assert notebook.js("c.selected") == [view, point]  # offered by itself
        notebook.click(view, *truth(view, point))
        notebook.settle()
        assert (0, view, point) in rows(file)  # saved as it was clicked
    assert notebook.js("c.selected") is None
    found = rows(file)
    assert [key[1:] for key in found] == ORDER
    # a view of 640 px is about as wide on the screen: the mouse aims to half a pixel or so
    for (_, view, point), uv in found.items():
        np.testing.assert_allclose(uv, truth(view, point), atol=1.1)
    text = notebook.page.locator(".pawnb-status").inner_text()
    assert "All points are placed" in text
    assert "Nothing is missing. Saved in start.csv." in text
    notebook.assert_no_errors()


def test_drag_undo_redo_and_esc(clicking):
    notebook, file = clicking
    notebook.click("cam1", 200, 200)
    notebook.settle()
    notebook.drag("cam1", (200, 200), (300, 150))
    notebook.settle()
    np.testing.assert_allclose(rows(file)[0, "cam1", "FR"], (300, 150), atol=1.1)
    assert notebook.py("len(w.session._past)") == 2  # one change a drag, not one a mouse move
    notebook.press("Control+z")
    notebook.settle()
    np.testing.assert_allclose(rows(file)[0, "cam1", "FR"], (200, 200), atol=1.1)
    notebook.press("Control+y")
    notebook.settle()
    np.testing.assert_allclose(rows(file)[0, "cam1", "FR"], (300, 150), atol=1.1)
    notebook.page.locator("[data-action=undo]").click()
    notebook.settle()
    # Esc while the point is in the hand: it is back, and nothing was written
    before = file.read_bytes()
    notebook.drag("cam1", (200, 200), (100, 300), release=False)
    notebook.press("Escape")
    notebook.page.mouse.up()
    notebook.settle()
    point = notebook.js("c.stages[0].overlay.points[0]")
    np.testing.assert_allclose((point["u"], point["v"]), (200, 200), atol=1.1)
    assert file.read_bytes() == before


def test_the_wheel_scrolls_the_page_until_the_widget_is_clicked_or_with_ctrl(clicking):
    notebook, _ = clicking
    zoom = "c.stages[0].zoom.scale / c.stages[0].fitScale"

    def turn():
        """Turn the wheel over the picture; gives whether the page was kept from scrolling."""
        notebook.page.mouse.move(*notebook.at("cam1", 150, 220))
        notebook.page.evaluate(
            "() => { window.kept = new Promise((done) => document.addEventListener("
            "'wheel', (e) => done(e.defaultPrevented), {once: true})); }"
        )
        notebook.page.mouse.wheel(0, -200)
        return notebook.page.evaluate("window.kept")

    assert not notebook.js("c.root.contains(document.activeElement)")
    assert turn() is False
    assert notebook.js(zoom) == 1
    notebook.page.keyboard.down("Control")
    assert turn() is True
    notebook.page.keyboard.up("Control")
    assert notebook.js(zoom) > 1.2
    assert turn() is False
    notebook.focus()
    assert turn() is True
    assert notebook.js(zoom) > 1.5


def test_wheel_and_rectangle_zoom_keep_image_points_under_the_mouse(clicking):
    notebook, _ = clicking
    notebook.focus()
    # wheel events carry whole CSS pixels: aim at one, and see which image point is there
    x, y = (round(p) for p in notebook.at("cam1", 150, 220))
    u, v = notebook.under("cam1", x, y)
    notebook.page.mouse.move(x, y)
    for _ in range(8):
        notebook.page.mouse.wheel(0, -200)
    notebook.wait("c.stages[0].zoom.scale > 5 * c.stages[0].fitScale")
    # the point under the mouse has stayed there
    np.testing.assert_allclose(notebook.at("cam1", u, v), (x, y), atol=1)
    assert not notebook.js("c.stages[0].fitted")
    assert notebook.js("c.stages[1].fitted")  # each view has its own zoom
    notebook.page.mouse.click(x, y)
    notebook.settle()
    # ten times larger, the click is exact to a fraction of a pixel
    np.testing.assert_allclose(clicks(notebook)[0, "cam1", "FR"], (u, v), atol=0.3)
    # enlarged pixels are squares: nothing is smoothed between them
    assert notebook.js("c.stages[0].image.getContext('2d').imageSmoothingEnabled") is False
    notebook.press("0")
    notebook.wait("c.stages[0].fitted")
    # rectangle with the button: u 100..260, v 100..190 fill the view
    notebook.page.get_by_role("button", name="Zoom rectangle").click()
    notebook.drag("cam2", (100, 100), (260, 190))
    notebook.wait("!c.stages[1].fitted && !c.rectangle")
    scale = notebook.js("c.stages[1].zoom.scale / c.stages[1].fitScale")
    assert scale == pytest.approx(4, rel=0.05)
    centre = notebook.js(
        "[c.stages[1].marks.width / 2, c.stages[1].marks.height / 2].map((p, i) =>"
        " (p - [c.stages[1].zoom.tx, c.stages[1].zoom.ty][i]) / c.stages[1].zoom.scale - 0.5)"
    )
    np.testing.assert_allclose(centre, (180, 145), atol=1.5)
    assert len(clicks(notebook)) == 1  # zooming placed nothing
    # and with Shift, further in
    notebook.page.keyboard.down("Shift")
    notebook.drag("cam2", (160, 134), (200, 156.5))
    notebook.page.keyboard.up("Shift")
    notebook.wait("c.stages[1].zoom.scale > 14 * c.stages[1].fitScale")
    # dragging the zoomed picture pans it, and is no click
    u_before = notebook.js("c.stages[1].zoom.tx")
    notebook.drag("cam2", (175, 145), (185, 145))
    notebook.wait(f"c.stages[1].zoom.tx > {u_before} + 50")
    assert len(clicks(notebook)) == 1


def test_a_screen_reader_says_of_which_view_a_button_is(clicking):
    notebook, _ = clicking
    for view in ("cam1", "cam2"):
        buttons = notebook.page.get_by_role("group", name=f"view {view}")
        for name in ("FR", "HR", "Larger"):
            assert buttons.get_by_role("button", name=name).count() == 1


def test_hidden_points_the_epipolar_line_and_another_frame(clicking):
    notebook, file = clicking
    notebook.click("cam1", *truth("cam1", "FR"))
    notebook.settle()
    notebook.press("h")  # HR is hidden in cam1
    notebook.settle()
    assert notebook.js("c.selected") == ["cam2", "FR"]
    chip = notebook.page.locator("[data-view=cam1] [data-point=HR]")
    assert chip.get_attribute("title") == "HR: hidden here"
    # cam1 says v = 270 wherever FR is in depth: 20 px higher in cam2
    (line,) = notebook.js("c.stages[1].overlay.lines")
    np.testing.assert_allclose([v for _, v in line["at"]], truth("cam2", "FR")[1], atol=1.1)
    # a right click takes a point away; the chip above the picture asks for it again
    notebook.click("cam1", *truth("cam1", "FR"), button="right")
    notebook.settle()
    assert rows(file) == {}
    notebook.page.locator("[data-view=cam1] [data-point=FR]").click()
    notebook.settle()
    assert notebook.js("c.selected") == ["cam1", "FR"]
    # clicks belong to the frame on the screen
    notebook.press("ArrowRight")
    notebook.press("ArrowRight")
    notebook.settle()
    notebook.until("w.session.frame", 2)
    notebook.settle()
    notebook.click("cam1", *truth("cam1", "FR", frame=2))
    notebook.settle()
    assert list(rows(file)) == [(2, "cam1", "FR")]


def test_a_proposal_is_accepted_with_enter_or_dragged(notebook, trial_file):
    file = trial_file.parent / "start.csv"
    notebook.show(f"""import numpy as np, pandas as pd
import small_trial as scene
from pawnb.widgets import ClickInitialiser
from pawnb.workflow.start.propose import StartProposal
rows = [(3, view, point, *scene.seen(3)[k, "FR HR".split().index(point)])
        for k, (view, points) in enumerate(scene.POINTS.items()) for point in points]
points = pd.DataFrame([("FR", 0.9, "sure"), ("HR", 0.1, "unsure, check it")],
                      columns=["point", "sure", "words"])
start = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
w = ClickInitialiser({str(trial_file)!r}, propose=StartProposal(3, start, points))
w""")
    assert notebook.py("w.frame") == 3
    assert not file.exists()  # nothing is a start before it is accepted
    text = notebook.page.locator(".pawnb-status").inner_text()
    assert "FR sure; HR unsure, check it" in text
    origins = notebook.js("c.stages[0].overlay.points.map((p) => p.origin)")
    assert origins == ["predicted", "predicted"]  # dashed
    u, v = truth("cam1", "HR", frame=3)
    notebook.drag("cam1", (u, v), (u + 40, v + 30))
    notebook.settle()
    assert list(rows(file)) == [(3, "cam1", "HR")]
    notebook.focus()
    notebook.press("Enter")
    notebook.settle()
    found = rows(file)
    assert sorted(key[1:] for key in found) == sorted(ORDER)
    np.testing.assert_allclose(found.pop((3, "cam1", "HR")), (u + 40, v + 30), atol=1.1)
    for (_, view, point), uv in found.items():
        np.testing.assert_allclose(uv, truth(view, point, frame=3), atol=1e-3)
    assert notebook.page.locator("[data-action=accept]").count() == 0
    notebook.assert_no_errors()


def test_the_picture_stands_still_while_a_point_is_dragged(clicking):
    notebook, file = clicking
    notebook.click("cam1", 200, 200)
    notebook.settle()
    top = "c.stages[0].marks.getBoundingClientRect().top"
    before = notebook.js(top)
    notebook.drag("cam1", (200, 200), (300, 150), release=False)
    # choosing the point makes the words longer: with them the picture would move down
    notebook.kernel_runs("w.status = chr(10).join(['one', 'two', 'three', 'four'])")
    notebook.wait("c.model.get('status').startsWith('one')")
    notebook.page.mouse.move(*notebook.at("cam1", 301, 150))
    assert notebook.js(top) == before
    notebook.page.mouse.up()
    notebook.settle()
    np.testing.assert_allclose(rows(file)[0, "cam1", "FR"], (301, 150), atol=1.1)
    # and what waited is said once it is let go
    assert notebook.py("w.status") in notebook.page.locator(".pawnb-status").inner_text()
    # nor does it jump back up when fewer words follow, while a click is on its way
    notebook.kernel_runs("w.status = chr(10).join(['one', 'two', 'three', 'four'])")
    notebook.wait("c.status.innerText.includes('four')")
    low = notebook.js(top)
    assert low > before
    notebook.kernel_runs("w.status = 'one'")
    notebook.wait("c.status.innerText === 'one'")
    assert notebook.js(top) == low


def test_many_points_take_another_line_above_their_picture(notebook, trial_file):
    names = [f"landmark_{i}" for i in range(12)]
    text = trial_file.read_text().replace('["FR", "HR"]', str(["FR", "HR", *names]))
    trial_file.write_text(text)
    notebook.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial_file)!r})
w""")
    right = "c.stages.map((s) => s.{}.getBoundingClientRect().right)"
    edge = notebook.js("c.root.getBoundingClientRect().right")
    assert max(notebook.js(right.format("el"))) <= edge
    assert notebook.js("c.root.scrollWidth <= c.root.clientWidth")
    chips = "[...c.stages[0].head.querySelectorAll('.pawnb-chip')]"
    assert notebook.js(f"{chips}.length") == 14
    assert notebook.js(f"Math.max(...{chips}.map((b) => b.getBoundingClientRect().right))") <= edge
    # the pictures of a row stand in line, whatever is above them
    assert notebook.js("c.stages[0].head.offsetHeight > c.stages[2].head.offsetHeight")
    top = "c.stages.map((s) => Math.round(s.image.getBoundingClientRect().bottom))"
    assert len(set(notebook.js(top)[:2])) == 1


def test_keys_stay_in_the_widget(clicking):
    notebook, _ = clicking
    notebook.focus()
    # older releases of JupyterLab 4 listen before the widget does: this attribute stops them
    assert notebook.js("c.root.dataset.lmSuppressShortcuts") == "true"
    cells = notebook.n_cells()
    for key in ("a", "b", "d", "d", "x", "c", "v", "z", "m", "Shift+Enter", "Control+Enter"):
        notebook.press(key)
    # a round trip through page and kernel: whatever the keys began has been done
    notebook.press("End")
    notebook.settle()
    notebook.until("w.frame", scene.N_FRAMES - 1)
    assert notebook.n_cells() == cells
    sources = json.loads(
        notebook.page.evaluate(
            "JSON.stringify([...window.jupyterapp.shell.currentWidget.content.widgets]"
            ".map((cell) => [cell.model.type, cell.model.sharedModel.getSource()]))"
        )
    )
    assert sources[1] == ["code", "1 + 1"]
    # the same keys do reach the notebook when the widget has not the focus
    notebook.page.locator(".jp-Cell").last.click()
    notebook.press("Escape")
    notebook.press("b")
    notebook.page.wait_for_function(
        f"window.jupyterapp.shell.currentWidget.content.widgets.length === {cells + 1}"
    )
