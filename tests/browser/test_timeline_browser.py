"""The timeline in a real browser: scrub, choose a stretch, mend it, see it in lanes and on disk."""

import json

import numpy as np
import pytest
import small_trial as scene
from test_small_screen_browser import set_theme

pytestmark = pytest.mark.browser

EVIL, LONG, HEBREW = "<img src=x onerror=window.hurt=1>", "a" * 300, "\u05e9\u05dc\u05d5\u05dd" * 30
HOSTILE = {"Light": [EVIL, LONG], "Dark": [EVIL, ""]}
"""Instead of FR and HR."""
VIEWS = [EVIL, LONG, HEBREW]
"""Instead of cam1, cam2 and cam3."""


def open_review(notebook, trial_file, change="", more=""):
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
tracks = scene.true_tracks()
{change}
w = TrackReviewer({str(trial_file)!r}, tracks{more})
w""")
    notebook.wait("c.timeline.bytes !== null")
    return trial_file.parent / "results" / "edits.jsonl"


def lines(file):
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def place(notebook, frame, lane):
    """Where the middle of a frame in a lane is on the page; lane -1 is the line of numbers."""
    notebook.page.locator(".pawnb-lanes").scroll_into_view_if_needed()
    x, y = notebook.js(
        f"(() => {{ const t = c.timeline; return [t.x({frame} + 0.5),"
        f" {lane} < 0 ? 8 : 20 + ({lane} + 0.5) * t.laneHeight]; }})()"
    )
    box = notebook.page.locator(".pawnb-lanes").bounding_box()
    return box["x"] + x, box["y"] + y


def drag(notebook, start, end):
    mouse = notebook.page.mouse
    mouse.move(*place(notebook, *start))
    mouse.down()
    mouse.move(*place(notebook, *end), steps=6)
    mouse.up()
    notebook.settle()


def bar(notebook):
    return notebook.page.locator(".pawnb-stretch").inner_text()


def bits(notebook, lane, frame):
    return notebook.js(f"c.timeline.bytes[3 * ({lane} * c.timeline.n + {frame}) + 2]")


def test_the_timeline_is_the_scrubber_and_chooses_points(notebook, trial_file):
    open_review(notebook, trial_file)
    drag(notebook, (2, -1), (30, -1))
    assert notebook.js("f.shown") == 30
    assert notebook.bar_code("cam1", scene.BITS, scene.SQUARE) == 30
    notebook.until("w.frame", 30)
    # a click in a lane goes there and chooses its point
    notebook.page.mouse.click(*place(notebook, 12, 1))
    notebook.wait("c.painted === 12")
    assert notebook.js("c.selected") == ["cam1", "HR"]
    assert notebook.js("c.timeline.stretch") is None
    # the wheel zooms about the mouse, a double click shows all again
    notebook.page.mouse.move(*place(notebook, 20, 0))
    notebook.page.mouse.wheel(0, -400)
    notebook.wait("c.timeline.view.frames < 30")
    assert abs(notebook.js("c.timeline.x(20.5)") - notebook.js(
        "92 + 20.5 * c.timeline.plotWidth / 40")) < 2  # fmt: skip
    notebook.page.mouse.dblclick(*place(notebook, 20, -1))
    notebook.wait("c.timeline.view.frames === 40")
    notebook.assert_no_errors()


def test_a_swap_of_a_stretch_takes_two_actions_and_undo_takes_it_back(notebook, trial_file):
    file = open_review(notebook, trial_file)
    first, last = 5, 34
    drag(notebook, (first, 0), (last, 0))  # one
    notebook.until("w.stretch", ["FR", first, last])
    assert f"frames {first} to {last} (30)" in bar(notebook)
    notebook.page.get_by_role("button", name="Swap with HR").click()  # two
    notebook.settle()
    line = {"edit": "swap", "frame": first, "first": "FR", "second": "HR", "view": None,
            "stop": last + 1}  # fmt: skip
    assert lines(file) == [line]
    for frame, point in ((4, "FR"), (5, "HR"), (34, "HR"), (35, "FR")):
        assert notebook.py(f"w.session.position({frame}, 'cam1', {point!r})") == list(
            scene.seen(frame)[0, 0]
        )
    notebook.focus()
    notebook.press("Control+z")
    notebook.settle()
    assert notebook.py("w.session.position(10, 'cam1', 'FR')") == list(scene.seen(10)[0, 0])
    notebook.assert_no_errors()


def test_a_wrong_stretch_is_interpolated_in_two_actions(notebook, trial_file):
    wrong = "tracks['image_position'].values[10:15, 0, :, 0, 0] += 60.0"
    file = open_review(notebook, trial_file, wrong)
    drag(notebook, (10, 0), (14, 0))
    notebook.press("n")
    notebook.settle()
    assert [line["edit"] for line in lines(file)] == ["interpolate"]
    for frame in range(10, 15):
        np.testing.assert_allclose(
            notebook.py(f"w.session.position({frame}, 'cam1', 'FR')"), scene.seen(frame)[0, 0]
        )
        assert bits(notebook, 0, frame) & 8  # predicted, and drawn so
    assert not bits(notebook, 0, 15) & 8


def test_keys_mark_a_stretch_hide_it_delete_it_and_let_it_go(notebook, trial_file):
    file = open_review(notebook, trial_file)
    notebook.page.mouse.click(*place(notebook, 8, 1))
    notebook.wait("c.painted === 8")
    notebook.press("i")
    for _ in range(3):
        notebook.press("ArrowRight")
    notebook.settle()
    notebook.press("o")
    notebook.until("w.stretch", ["HR", 8, 11])
    notebook.page.get_by_label("Where that is done").select_option(label="in cam2")
    notebook.press("h")
    notebook.settle()
    assert lines(file)[-1] == {
        "edit": "hide",
        "frame": 8,
        "view": "cam2",
        "point": "HR",
        "stop": 12,
    }
    notebook.page.get_by_label("Where that is done").select_option(label="in all views")
    notebook.press("Delete")
    notebook.settle()
    assert lines(file)[-1] == {
        "edit": "delete",
        "frame": 8,
        "stop": 12,
        "point": "HR",
        "view": None,
    }
    notebook.wait("c.timeline.bytes[3 * (c.timeline.n + 9)] === 255")  # missing
    # an end of the stretch is dragged
    _, y = place(notebook, 11, 1)
    edge = notebook.js("c.timeline.x(12)")
    left = notebook.page.locator(".pawnb-lanes").bounding_box()["x"]
    notebook.page.mouse.move(left + edge, y)
    notebook.page.mouse.down()
    notebook.page.mouse.move(place(notebook, 20, 1)[0], y, steps=4)
    notebook.page.mouse.up()
    notebook.until("w.stretch", ["HR", 8, 20])
    notebook.press("Escape")
    notebook.until("w.stretch", [])
    # Python can choose one, too
    notebook.kernel_runs("w.stretch = ['FR', 30, 33]")
    notebook.wait("c.timeline.stretch && c.timeline.stretch.first === 30")
    assert "frames 30 to 33 (4)" in bar(notebook)
    notebook.assert_no_errors()


def test_x_swaps_up_to_where_the_points_meet_next(notebook, trial_file):
    """FR glides past HR; they are nearest in cam1 in frame 12: 50 + 8 x 12.5 = 150, see place()."""
    file = open_review(notebook, trial_file, "tracks['image_position'].values[:, 0, 1, 1] = 268.0")
    notebook.page.mouse.click(*place(notebook, 2, 0))
    notebook.wait("c.painted === 2")
    assert "from here to where they meet next" in bar(notebook)
    notebook.press("x")
    notebook.settle()
    (line,) = lines(file)
    assert (line["edit"], line["frame"], line["first"], line["second"]) == ("swap", 2, "FR", "HR")
    assert line["stop"] in (12, 13)


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (1920, 1200)])
@pytest.mark.parametrize("theme", ["Light", "Dark"])
def test_hostile_names_run_nothing_and_nothing_overflows(
    notebook, trial_file, width, height, theme
):
    points = HOSTILE[theme]
    text = trial_file.read_text()
    for was, name in zip(scene.POINTS, VIEWS, strict=True):
        text = text.replace(f'name = "{was}"', f"name = {json.dumps(name)}")
    text = text.replace('name = "small"', f"name = {json.dumps(EVIL)}")
    text = text.replace('"FR"', json.dumps(points[0])).replace(', "HR"', "")
    trial_file.write_text(text)
    row = [7, EVIL, points[0], f"{EVIL} {HEBREW} {LONG}", 1.0]
    change = f"""import pandas as pd
tracks = tracks.assign_coords(keypoint={points!r}, view={VIEWS!r})
other = tracks.copy(deep=True)
other["image_position"][9] += 30.0
table = pd.DataFrame([{row!r}], columns=["frame", "view", "point", "reason", "score"])
"""
    more = f", suspects=table, against=other, against_name={EVIL + LONG!r}"
    notebook.page.set_viewport_size({"width": width, "height": height})
    set_theme(notebook, theme)
    try:
        open_review(notebook, trial_file, change, more)
        # what is said of a doubtful label, and of a difference, holds every name there is
        for key, words in (("d", "Doubtful 1 of 1"), ("c", "Difference 1 of")):
            notebook.focus()
            notebook.press(key)
            notebook.wait(f"c.status.innerText.startsWith({words!r}) && c.pending === 0")
            notebook.settle()
            assert EVIL in notebook.page.locator(".pawnb-status").inner_text()
        notebook.kernel_runs(f"w.alarm = {EVIL + LONG + HEBREW!r}")
        notebook.wait("!c.alarm.hidden")
        over = """(() => { const right = c.root.getBoundingClientRect().right + 2;
            return [...c.root.querySelectorAll('div, button, select, canvas, input, span')]
                .filter((e) => e.offsetParent && e.getBoundingClientRect().right > right)
                .map((e) => e.className); })()"""
        assert notebook.js(over) == []
        for part in ("root", "grid", "status", "alarm", "detail"):
            assert notebook.js(f"c.{part}.scrollWidth - c.{part}.clientWidth") <= 2, part
        # nor do the questions' sheet and the buttons of its answers run anything, or run away
        notebook.kernel_runs("w._looked.clear()")
        notebook.focus()
        notebook.press("q")
        notebook.page.locator(".pawnb-crop").wait_for()
        notebook.settle()
        assert "Expected errors left" in notebook.page.locator(".pawnb-status").inner_text()
        assert notebook.js(over) == []
        assert notebook.js("c.sheet.el.scrollWidth - c.sheet.el.clientWidth") <= 2
        notebook.press("q")
        notebook.page.locator(".pawnb-crop").wait_for(state="detached")
        notebook.settle()
        drag(notebook, (5, 0), (30, 0))
        stretch = notebook.page.locator(".pawnb-stretch")
        assert EVIL in stretch.inner_text()
        room = notebook.page.locator(".pawnb-root").bounding_box()
        for part in (".pawnb-stretch", ".pawnb-lanes", ".pawnb-timeline"):
            box = notebook.page.locator(part).bounding_box()
            assert box["x"] + box["width"] <= room["x"] + room["width"] + 2, part
        assert stretch.bounding_box()["height"] < 40  # one line: the lanes stay where they are
        close = stretch.get_by_role("button", name="✕").bounding_box()
        assert close["x"] + close["width"] <= room["x"] + room["width"]
        assert notebook.page.evaluate("window.hurt") is None
        # the lane is drawn on the ground of its theme
        pixel = notebook.js(
            "[...c.timeline.canvas.getContext('2d').getImageData("
            "c.timeline.canvas.width - 3, 5, 1, 1).data]"
        )
        assert (sum(pixel[:3]) > 3 * 128) == (theme == "Light")
        notebook.assert_no_errors()
    finally:
        set_theme(notebook, "Light")
        notebook.page.set_viewport_size({"width": 1500, "height": 1000})


def test_the_lanes_are_drawn_anew_in_another_theme_without_moving(notebook, trial_file):
    """The page has no width for a moment while it changes its theme."""
    open_review(notebook, trial_file)
    notebook.js("c.timeline.canvas.style.setProperty('display', 'none')")
    set_theme(notebook, "Dark")
    try:
        notebook.wait("c.timeline.theme === c.timeline.colours().ink + c.timeline.colours().paper")
        notebook.js("c.timeline.canvas.style.removeProperty('display')")
        # the lane of FR is filled to its right end: confidence 0.8 of its height
        pixel = notebook.js(
            "[...c.timeline.lanesPicture.getContext('2d').getImageData("
            "c.timeline.canvas.width - 3, 20 + c.timeline.laneHeight - 4, 1, 1).data]"
        )
        assert pixel[2] > pixel[0] + 40  # FR is blue
        assert notebook.js("c.timeline.x(39)") > 0.9 * notebook.js("c.timeline.canvas.width")
    finally:
        set_theme(notebook, "Light")
