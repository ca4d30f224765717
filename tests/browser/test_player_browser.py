"""Playing at any speed, backwards and in a loop; light; keys that move a point; what is chosen."""

import json

import numpy as np
import pytest
import small_trial as scene

pytestmark = pytest.mark.browser


@pytest.fixture
def reviewing(notebook, trial_file):
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks())
w""")
    notebook.wait("c.timeline.bytes !== null")
    notebook.focus()
    return notebook, trial_file.parent / "results" / "edits.jsonl"


def watch(notebook):
    """Keep which frames are painted from now on, also two that are painted in one refresh."""
    notebook.page.evaluate(
        """() => { const c = document.querySelector('.pawnb-root')._pawnb;
        let painted = c.painted;
        window.seen = [painted];
        Object.defineProperty(c, 'painted', { configurable: true, get: () => painted,
            set: (frame) => { painted = frame;
                if (window.seen.at(-1) !== frame) window.seen.push(frame); } }); }"""
    )


def test_it_plays_backwards_and_a_stretch_in_a_loop_and_skips_no_frame(reviewing):
    notebook, _ = reviewing
    for frame in (6, 7, 8, 9):  # there before they are played
        notebook.js(f"f.go({frame})")
        notebook.wait(f"c.painted === {frame}")
    notebook.settle()
    watch(notebook)
    notebook.press("b")
    notebook.wait("f.playing && c.painted < 7")
    notebook.press("b")
    notebook.wait("!f.playing")
    notebook.settle()
    seen = notebook.page.evaluate("window.seen")
    assert seen == list(range(9, 9 - len(seen), -1))
    notebook.kernel_runs("w.stretch = ['FR', 3, 5]")
    notebook.wait("c.timeline.stretch && c.timeline.stretch.first === 3")
    watch(notebook)
    notebook.press("Shift+ ")
    notebook.wait("window.seen.filter((frame) => frame === 3).length >= 2")  # once round
    notebook.press(" ")
    notebook.wait("!f.playing")
    notebook.settle()
    played = notebook.page.evaluate("window.seen.slice(window.seen.indexOf(3))")
    assert played[:4] == [3, 4, 5, 3]
    assert set(played) == {3, 4, 5}
    # faster and slower, by key and list
    assert notebook.js("f.speed") == 25
    notebook.press("+")
    assert notebook.js("f.speed") == 50
    notebook.press("-")
    notebook.press("-")
    assert notebook.page.get_by_label("frames a second").input_value() == "10"
    notebook.assert_no_errors()


def test_a_point_is_moved_by_keys_and_kept_once(reviewing):
    notebook, file = reviewing
    notebook.page.locator("[data-view=cam1] [data-point=FR]").click()
    for _ in range(3):
        notebook.press("Alt+ArrowRight")
    for _ in range(5):
        notebook.press("Alt+Shift+ArrowUp")
    notebook.until("len(w.session.corrections)", 1)
    u, v = scene.seen(0)[0, 0]
    (line,) = map(json.loads, file.read_text().splitlines())
    assert (line["edit"], line["frame"], line["view"], line["point"]) == ("move", 0, "cam1", "FR")
    np.testing.assert_allclose((line["u"], line["v"]), (u + 3, v - 0.5), atol=1e-3)
    # another key keeps it before anything else is done
    notebook.press("Alt+ArrowLeft")
    notebook.press("ArrowRight")
    notebook.wait("c.painted === 1")
    notebook.settle()
    assert [e["frame"] for e in map(json.loads, file.read_text().splitlines())] == [0, 0]
    np.testing.assert_allclose(
        notebook.py("w.session.position(0, 'cam1', 'FR')"), (u + 2, v - 0.5), atol=1e-3
    )
    notebook.assert_no_errors()


def test_the_light_changes_what_is_shown_only(reviewing):
    notebook, _ = reviewing
    notebook.page.get_by_text("Brightness, contrast, gamma").click()
    image = notebook.page.locator(".pawnb-image").first
    before = image.screenshot()
    notebook.page.get_by_label("gamma").fill("3")
    assert "url(" in image.evaluate("(one) => one.style.filter")
    brighter = image.screenshot()
    assert brighter != before
    assert notebook.bar_code("cam1", scene.BITS, scene.SQUARE) == 0  # the pixels are as filmed
    notebook.page.get_by_role("button", name="As it is").click()
    assert image.evaluate("(one) => one.style.filter") == ""
    notebook.assert_no_errors()


def test_what_is_chosen_can_be_seen_and_set_from_python(reviewing):
    notebook, _ = reviewing
    notebook.page.locator("[data-view=cam2] [data-point=HR]").click()
    notebook.until("w.selected", ["cam2", "HR"])
    notebook.kernel_runs("w.selected = ['cam1', 'FR']")
    notebook.wait("c.selected && c.selected[0] === 'cam1' && c.selected[1] === 'FR'")
    pressed = notebook.page.locator("[data-view=cam1] [data-point=FR]").get_attribute(
        "aria-pressed"
    )
    assert pressed == "true"
    # a slider that the browser itself links to it, without Python
    notebook.kernel_runs(
        "import ipywidgets\nslider = ipywidgets.IntSlider(max=39)\n"
        "link = ipywidgets.jslink((slider, 'value'), (w, 'frame'))"
    )
    notebook.kernel_runs("slider.value = 6")
    notebook.wait("c.painted === 6")
    notebook.focus()
    notebook.press("ArrowRight")
    notebook.until("[slider.value, w.frame]", [7, 7])
    notebook.kernel_runs("link.close()")
    notebook.press("?")
    assert notebook.page.locator(".pawnb-help").get_attribute("open") is not None
    listed = notebook.page.locator(".pawnb-help").inner_text()
    for key in ("I, O", "X", "Alt and an arrow", "Ctrl+Z, Ctrl+Y", "+, -", "G"):
        assert key in listed
    notebook.press("?")
    assert notebook.page.locator(".pawnb-help").get_attribute("open") is None
    notebook.assert_no_errors()


SHOWN = """c.stages.map((s) => [(s.image.width / 2 - s.zoom.tx) / s.zoom.scale - 0.5,
    (s.image.height / 2 - s.zoom.ty) / s.zoom.scale - 0.5, s.zoom.scale / s.fitScale])"""


def test_views_follow_the_chosen_point_a_loupe_and_a_point_placed_without_a_mouse(reviewing):
    notebook, file = reviewing
    notebook.js("f.go(20)")
    notebook.wait("c.painted === 20")
    notebook.page.locator("[data-view=cam1] [data-point=FR]").click()
    notebook.focus()
    notebook.press("V")  # as with Caps Lock: a capital without Shift
    notebook.settle()
    for frame in (20, 21):
        shown = np.array(notebook.js(SHOWN))
        np.testing.assert_allclose(shown[:, :2], scene.seen(frame)[:, 0], atol=1.0)
        np.testing.assert_allclose(shown[:, 2], 4.0)
        notebook.press("ArrowRight")
        notebook.wait(f"c.painted === {frame + 1}")
    # zooming in one view zooms all
    box = notebook.page.locator("[data-view=cam2] .pawnb-marks").bounding_box()
    notebook.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    notebook.page.mouse.wheel(0, -300)
    notebook.wait("c.stages.every((s) => s.zoom.scale / s.fitScale > 5)")
    assert np.ptp(np.array(notebook.js(SHOWN))[:, 2]) < 1e-6

    # of a disc of 70 px above the mouse, or below it, a pixel beside its cross
    x, y = box["x"] + box["width"] / 2 + 1, box["y"] + box["height"] / 2
    covered = f"""((s) => {{ const at = s.locate({{ clientX: {x}, clientY: {y} }});
        const v = at.y > 154 ? at.y - 84 : Math.min(at.y + 84, s.marks.height - 70);
        const g = s.marks.getContext('2d');
        return g.getImageData(Math.round(at.x) + 40, Math.round(v), 1, 1).data[3];
        }})(c.stages[1])"""
    assert notebook.js(covered) == 0
    notebook.press("u")
    notebook.page.mouse.move(x, y)
    notebook.settle()
    assert notebook.js(covered) == 255
    notebook.press("u")
    notebook.press("0")
    notebook.wait("c.stages.every((s) => s.fitted)")

    # hidden, then placed again by E where the other two views put it, and moved by keys
    notebook.press("Delete")
    notebook.settle()
    notebook.press("e")
    notebook.settle()
    notebook.press("Alt+ArrowRight")
    notebook.until("len(w.session.corrections)", 3)
    hide, place, nudge = [json.loads(line) for line in file.read_text().splitlines()]
    assert (hide["edit"], place["edit"], place["view"], place["frame"]) == (
        "hide",
        "move",
        "cam1",
        22,
    )
    np.testing.assert_allclose([place["u"], place["v"]], scene.seen(22)[0, 0], atol=0.05)
    assert nudge["u"] == pytest.approx(place["u"] + 1, abs=1e-3)
    notebook.assert_no_errors()


def test_a_key_that_moves_a_point_never_steps_to_another_frame(reviewing):
    notebook, _ = reviewing
    notebook.kernel_runs(
        "import time; kept = w.edit; w.edit = lambda *a: (time.sleep(0.4), kept(*a))[1]"
    )
    notebook.page.locator("[data-view=cam1] [data-point=FR]").click()
    notebook.settle()
    # while the last change is on its way nothing can be moved; that key must not step instead:
    # the next one would correct another frame
    notebook.press("Alt+ArrowRight")
    notebook.wait("c.pending > 0")
    notebook.press("Alt+ArrowRight")
    notebook.settle()
    assert notebook.js("f.shown") == 0
    notebook.press("Alt+ArrowRight")
    notebook.until("len(w.session.corrections)", 2)
    notebook.settle()
    assert notebook.py("[edit.frame for edit in w.session.corrections]") == [0, 0]
    notebook.assert_no_errors()
