"""A laptop of 1366 x 768, light and dark: nothing runs away, is cut off or mistaken."""

import numpy as np
import pytest
import small_trial as scene
from test_gait_explorer_browser import SOURCE as GAIT

pytestmark = pytest.mark.browser

RESIDUALS = """import numpy as np
import pandas as pd
from pawnb.widgets import ResidualExplorer
t = np.arange(200) / 250.0
w = ResidualExplorer(pd.DataFrame({"x": np.sin(2 * np.pi * 4 * t)}), fs_hz=250.0)
w"""


@pytest.fixture
def small(notebook):
    """Give the notebook on a small screen; light and large again after the test."""
    notebook.page.set_viewport_size({"width": 1366, "height": 768})
    yield notebook
    set_theme(notebook, "Light")
    notebook.page.set_viewport_size({"width": 1500, "height": 1000})


def set_theme(notebook, name):
    command = "window.jupyterapp.commands.execute('apputils:change-theme', {theme})"
    notebook.page.evaluate(f"async (theme) => await {command}", f"JupyterLab {name}")
    light = "true" if name == "Light" else "false"
    notebook.page.wait_for_function(f"document.body.dataset.jpThemeLight === '{light}'")
    # Jupyter takes its splash away 200 ms later, and stumbles where another theme came meanwhile
    notebook.page.wait_for_function("!document.getElementById('jupyterlab-splash')")


def truth(view, point, frame=0):
    return scene.seen(frame)[list(scene.POINTS).index(view), ["FR", "HR"].index(point)]


def test_the_slider_stays_under_the_mouse_while_frames_are_loaded(small, trial_file):
    small.show(f"""import pawnb
from pawnb.core.video import open_views
from pawnb.widgets import FrameCanvas
w = FrameCanvas(open_views(pawnb.load_trial({str(trial_file)!r})))
w""")
    slider = small.page.locator(".pawnb-slider")
    slider.scroll_into_view_if_needed()

    def box():
        found = slider.bounding_box()
        return found["x"], found["width"]

    was = box()
    # no frame comes until it is let go: the words say so
    small.js("f.request = () => {}")
    x, y = was[0] + 0.7 * was[1], slider.bounding_box()["y"] + slider.bounding_box()["height"] / 2
    small.page.mouse.move(was[0] + 0.2 * was[1], y)
    small.page.mouse.down()
    small.page.mouse.move(x, y, steps=8)
    caption = small.page.locator(".pawnb-caption")
    small.wait("f.late")  # a frame that comes at once is not announced
    assert "(loading" in caption.inner_text()
    assert box() == was
    chosen = small.js("f.want")
    small.js("c.connection.set({busy: true})")
    assert "(Python is busy)" in caption.inner_text()
    assert box() == was
    small.js("c.connection.set({busy: false})")
    small.js("delete f.request")
    small.js("f.step()")
    small.settle()
    assert box() == was
    small.page.mouse.move(x, y + 1)  # the hand is still there
    small.settle()
    assert small.js("f.shown") == chosen
    small.page.mouse.up()
    small.focus()
    small.press(" ")  # plays: its button has other words
    small.wait("f.playing")
    assert box() == was
    small.press(" ")


def test_a_click_beside_a_placed_paw_places_the_one_asked_for(small, trial_file):
    small.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial_file)!r})
w""")
    first = truth("cam1", "FR")
    small.click("cam1", *first)
    small.settle()
    near = (first[0] + 9.0, first[1])
    assert np.hypot(*np.subtract(small.at("cam1", *near), small.at("cam1", *first))) < 14
    small.click("cam1", *near)
    small.settle()
    places = small.py("[[*k[1:], *v] for k, v in w.session.clicks.items()]")
    assert [place[:2] for place in places] == [["cam1", "FR"], ["cam1", "HR"]]
    np.testing.assert_allclose(places[0][2:], first, atol=1.0)
    np.testing.assert_allclose(places[1][2:], near, atol=1.0)
    # a click on the very ring, too; a drag of the ring moves it
    small.click("cam2", *truth("cam2", "HR"))
    small.settle()
    small.click("cam2", *truth("cam2", "HR"))
    small.settle()
    assert small.py("len(w.session.clicks)") == 4
    small.drag("cam1", near, truth("cam1", "HR"))
    small.settle()
    moved = small.py("w.session.clicks[0, 'cam1', 'HR']")
    np.testing.assert_allclose(moved, truth("cam1", "HR"), atol=1.5)
    small.assert_no_errors()


def test_a_click_that_contradicts_another_view_says_so_while_it_is_made(small, trial_file):
    small.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial_file)!r})
w""")
    for view, point in (("cam1", "FR"), ("cam1", "HR")):
        small.click(view, *truth(view, point))
        small.settle()
    u, v = truth("cam2", "FR")
    words = "c.stages[1].offWords('FR', {}, {}, true)"
    # the line of cam1 in cam2 is level: see small_trial.py
    small.page.mouse.move(*small.at("cam2", u, v + 25))
    small.wait("c.stages[1].aim !== null")
    aim = small.js("c.stages[1].aim")
    assert small.js(words.format(aim["u"], aim["v"])) in ("⚠ 24 px", "⚠ 25 px", "⚠ 26 px")
    small.click("cam2", u, v + 25)
    small.settle()
    status = small.page.locator(".pawnb-status").inner_text()
    assert "⚠ FR in cam1 is 2" in status
    assert "from where cam2 puts it: one of these clicks is on another point." in status
    # while it is dragged right, the number falls, before it is let go
    small.drag("cam2", (u, v + 25), (u, v), release=False)
    held = small.js("c.stages[1].drag.point")
    said = small.js(words.format(held["u"], held["v"]))
    assert "⚠" not in said
    assert float(said.split()[0]) < 1.5
    small.page.mouse.up()
    small.settle()
    assert "⚠" not in small.page.locator(".pawnb-status").inner_text()
    small.assert_no_errors()


def test_a_leg_has_the_colour_of_the_figures(small, trial_file):
    small.show(f"""from pawnb.widgets import ClickInitialiser
from pawnb.figures.style import colour_legs
w = ClickInitialiser({str(trial_file)!r})
w""")
    small.click("cam1", *truth("cam1", "FR"))
    small.settle()
    shown = small.page.locator("[data-view=cam1] [data-point=FR]").evaluate(
        "(chip) => getComputedStyle(chip, '::before').backgroundColor"
    )
    red, green, blue = (int(part) for part in shown[4:-1].split(","))
    assert f"#{red:02X}{green:02X}{blue:02X}" == small.py("colour_legs(['HR', 'FR'])['FR']")


@pytest.mark.parametrize("source", [GAIT, RESIDUALS], ids=["gait", "residuals"])
def test_plots_fit_the_page_and_follow_its_theme(small, source):
    small.run(source)
    canvas = small.page.locator(".jupyter-matplotlib canvas").last
    canvas.wait_for(timeout=60_000)
    for theme, dark in (("Light", False), ("Dark", True), ("Light", False)):
        set_theme(small, theme)
        small.until("w._around.dark", dark, seconds=30)
        small.wait_idle()
        small.page.wait_for_function(
            """(dark) => { const c = [...document.querySelectorAll('.jupyter-matplotlib canvas')]
                .find((one) => one.width > 100), g = c.getContext('2d');
            const [r] = g.getImageData(3, 3, 1, 1).data; return dark ? r < 80 : r > 200; }""",
            arg=dark,
            timeout=30_000,
        )
        small.page.wait_for_function(  # drawn anew in the colours first, in the size after
            """(most) => [...document.querySelectorAll('.jupyter-matplotlib canvas')].at(-1)
                .getBoundingClientRect().height < most""",
            arg=768 - 250,
            timeout=30_000,
        )
        area = small.page.locator(".jp-OutputArea-output").last
        room, box = area.bounding_box(), canvas.bounding_box()
        assert box["x"] + box["width"] <= room["x"] + room["width"] + 1  # nothing is cut off
        assert box["width"] > 0.9 * room["width"]
    small.page.set_viewport_size({"width": 1920, "height": 1200})
    # the cell is wider (in Notebook 7 as wide as its page gets), and the plots follow
    small.page.wait_for_timeout(1500)  # the page is laid out anew first
    small.page.wait_for_function(
        """() => { const wide = (what) => [...document.querySelectorAll(what)].at(-1)
            .getBoundingClientRect().width;
        return wide('.jupyter-matplotlib canvas') > 0.9 * wide('.jp-OutputArea-output'); }""",
        timeout=30_000,
    )
    small.wait_idle()
    assert canvas.bounding_box()["width"] > 0.9 * area.bounding_box()["width"]


def test_the_names_of_what_is_exchanged_are_not_cut_off(small, trial_file):
    small.page.set_viewport_size({"width": 820, "height": 480})  # a laptop at a zoom of 150 %
    small.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
tracks = scene.true_tracks()
names = {{"FR": "front right paw", "HR": "hind right paw"}}
tracks = tracks.assign_coords(keypoint=[names[str(p)] for p in tracks["keypoint"].values])
w = TrackReviewer({str(trial_file)!r}, tracks)
w""")
    small.js("c.choose('front right paw')")
    small.settle()
    for part in (".pawnb-stretch .pawnb-point", ".pawnb-stretch .pawnb-button"):
        shown = small.page.locator(part).first
        assert "right paw" in shown.inner_text()
        assert shown.evaluate("(one) => one.scrollWidth <= one.clientWidth + 1")
