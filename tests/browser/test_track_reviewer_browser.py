"""TrackReviewer in a real browser: what the screen shows, and what reached Python and disk."""

import json

import numpy as np
import pytest
import small_trial as scene

pytestmark = pytest.mark.browser


@pytest.fixture
def reviewing(notebook, trial_file):
    """Open the widget on true tracks, with a tracker that moves cam1 by 5 px."""
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
asked = []
def retrack(trial, tracks, frame):
    asked.append(frame)
    new = tracks.copy(deep=True)
    new["image_position"].values[new["frame"].values >= frame, 0, 0] += 5
    return new
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks(), retrack=retrack)
w""")
    return notebook, trial_file.parent / "results" / "edits.jsonl"


def seen_frame(notebook, view="cam1"):
    return notebook.bar_code(view, scene.BITS, scene.SQUARE)


def lines(file):
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def truth(frame, view=0, point=0):
    return tuple(scene.seen(frame)[view, point])


def test_keys_slider_and_play_show_the_pixels_of_that_frame(reviewing):
    notebook, _ = reviewing
    notebook.focus()
    last = scene.N_FRAMES - 1
    steps = [("ArrowRight", 1), ("ArrowRight", 2), ("Shift+ArrowRight", 12), ("ArrowLeft", 11)]
    steps += [("End", last), ("Shift+ArrowLeft", last - 10), ("Home", 0), ("ArrowLeft", 0)]
    for key, frame in steps:
        notebook.press(key)
        notebook.wait(f"c.painted === {frame} && f.want === {frame} && !c.dirty")
        assert [seen_frame(notebook, view) for view in scene.POINTS] == [frame] * 3
        # what is drawn belongs to the same frame
        point = notebook.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
        np.testing.assert_allclose((point["u"], point["v"]), truth(frame), atol=0.01)
    notebook.until("w.frame", 0)
    # many presses at once: the newest wins, and it is the right one
    for _ in range(25):
        notebook.press("ArrowRight")
    notebook.settle()
    assert seen_frame(notebook) == 25
    text = notebook.page.locator(".pawnb-caption").inner_text()
    assert text == "frame 25 of 39, 0.100 s"
    # Space plays on to the end and stops there
    notebook.press(" ")
    assert notebook.page.get_by_role("button", name="Stop").is_visible()
    notebook.wait(f"f.shown === {last} && !f.playing")
    notebook.settle()
    assert seen_frame(notebook) == last
    # a frame by its number
    notebook.press("g")
    notebook.page.keyboard.type("17")
    notebook.press("Enter")
    notebook.wait("c.painted === 17")
    notebook.settle()
    assert seen_frame(notebook) == 17
    # Python can choose the frame as well
    notebook.kernel_runs("w.frame = 3")
    notebook.wait("c.painted === 3")
    notebook.settle()
    assert seen_frame(notebook) == 3
    notebook.assert_no_errors()


def test_a_doubtful_frame_shows_with_its_point_chosen(notebook, trial_file):
    notebook.show(f"""import pandas as pd
import small_trial as scene
from pawnb.widgets import TrackReviewer
table = pd.DataFrame([[7, "cam1", "HR", "it leaps", 1.0], [31, "cam2", "FR", "it is lost", 0.5]],
                     columns=["frame", "view", "point", "reason", "score"])
other = scene.true_tracks()
other["image_position"][22, 0, 1, 1, 0] += 40.0
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks(), suspects=table, against=other)
w""")
    # the largest difference from other tracks, drawn as a dashed ring
    notebook.focus()
    notebook.press("c")
    notebook.wait("c.painted === 22")
    notebook.settle()
    assert notebook.js("c.selected") == ["cam1", "HR"]
    (mark,) = notebook.js("c.stages[0].overlay.others.filter((p) => p.id === 'HR')")
    np.testing.assert_allclose(
        (mark["u"], mark["v"]), np.add(truth(22, point=1), (0, 40)), atol=0.01
    )
    lane = notebook.js("c.timeline.words({lane: c.timeline.lanes[1], frame: 22, named: false})")
    # one of 80 labels is above the scale, their 99.5th percentile: between 0 and 40 px
    assert "distance ≥ 24 px from the other tracks" in lane
    menu = notebook.page.locator("select[data-action=suspect]")
    menu.select_option(label="frame 31: FR in cam2, it is lost")
    notebook.wait("c.painted === 31")
    notebook.settle()
    assert notebook.js("c.selected") == ["cam2", "FR"]
    status = notebook.page.locator(".pawnb-status")
    assert status.inner_text().startswith("Doubtful 2 of 2, frame 31: FR in cam2, it is lost.")
    # another point chosen there by hand stays chosen, also once it is corrected
    notebook.drag("cam1", truth(31, point=1), (300, 150))
    notebook.settle()
    assert notebook.js("c.selected") == ["cam1", "HR"]
    notebook.kernel_runs("w._looked_at = -1")
    notebook.focus()
    notebook.press("d")
    notebook.wait("c.painted === 7")
    notebook.settle()
    assert notebook.js("c.selected") == ["cam1", "HR"]
    assert "Doubtful 1 of 2, frame 7: HR in cam1, it leaps." in status.inner_text()
    notebook.assert_no_errors()


def test_questions_are_answered_by_one_key_each(notebook, trial_file):
    notebook.show(f"""import pandas as pd
import small_trial as scene
from pawnb.widgets import TrackReviewer
table = pd.DataFrame([[7, "cam1", "HR", "it leaps", 1.0], [31, "cam2", "FR", "it is lost", 0.5]],
                     columns=["frame", "view", "point", "reason", "score"])
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks(), suspects=table)
w""")
    notebook.focus()
    notebook.press("q")
    notebook.wait("c.painted === 7 && !c.stages[0].fitted")
    notebook.settle()
    # the asked point is in the middle of its view, whose other part is outside
    middle = notebook.js(
        "((s) => [(s.image.width / 2 - s.zoom.tx) / s.zoom.scale - 0.5,"
        " (s.image.height / 2 - s.zoom.ty) / s.zoom.scale - 0.5,"
        " s.image.width / s.zoom.scale])(c.stages[0])"
    )
    np.testing.assert_allclose(middle, (*truth(7, point=1), 96), atol=1e-6)
    assert notebook.page.locator("[data-action=retrack]").count() == 0
    # the sheet: both labels, that which is asked about chosen; the other can be answered first
    crops = notebook.page.locator(".pawnb-crop")
    assert [one.get_attribute("aria-pressed") for one in crops.all()] == ["true", "false"]
    assert crops.nth(1).inner_text().split() == ["FR?", "cam2,", "31"]
    crops.nth(1).click()
    notebook.wait("c.painted === 31 && !c.stages[1].fitted")
    crops.nth(1).click()
    notebook.wait("c.painted === 7")
    notebook.settle()
    notebook.press("Enter")
    notebook.wait("c.painted === 31 && !c.stages[1].fitted")
    notebook.settle()
    assert crops.count() == 1
    notebook.press("0")
    notebook.wait("c.stages.every((s) => s.fitted)")
    notebook.settle()
    results = trial_file.parent / "results"
    assert [line["edit"] for line in lines(results / "edits.jsonl")] == ["accept", "delete"]
    assert [line["answer"] for line in lines(results / "answers.jsonl")] == ["right", "none"]
    assert crops.count() == 0
    assert "2 answers in" in notebook.page.locator(".pawnb-status").inner_text()
    notebook.assert_no_errors()


def test_a_drag_is_on_disk_before_another_frame_shows(reviewing):
    notebook, file = reviewing
    notebook.focus()
    notebook.press("ArrowRight")
    notebook.press("ArrowLeft")
    notebook.settle()
    notebook.wait("f.pictures.get(1) && f.overlays.has(1)")  # frame 1 could be shown at once
    # writing takes long now: the next frame must wait for it
    notebook.kernel_runs(
        "import os, time, pawnb.core.edits.records as r\n"
        "sync = os.fsync\n"
        "def slow(fd):\n"
        "    time.sleep(1.0)\n"
        "    sync(fd)\n"
        "r.os.fsync = slow"
    )
    notebook.page.evaluate(
        """() => { const c = document.querySelector('.pawnb-root')._pawnb;
        window.stood = [];
        (function look() { stood.push([c.painted, c.pending]); requestAnimationFrame(look); })();
        }"""
    )
    notebook.drag("cam1", truth(0), (truth(0)[0] + 40, truth(0)[1] - 30))
    notebook.press("ArrowRight")
    notebook.wait("c.painted === 1")
    (line,) = lines(file)
    assert {k: line[k] for k in ("edit", "frame", "view", "point")} == {
        "edit": "move", "frame": 0, "view": "cam1", "point": "FR",
    }  # fmt: skip
    np.testing.assert_allclose(
        (line["u"], line["v"]), (truth(0)[0] + 40, truth(0)[1] - 30), atol=1.1
    )
    notebook.kernel_runs("r.os.fsync = sync")
    history = notebook.page.evaluate("window.stood")
    assert [0, 1] in history  # frame 0 stood while the line was being written
    assert [1, 1] not in history  # and frame 1 was never on the screen meanwhile
    assert notebook.py("w.session.position(0, 'cam1', 'FR')") == [line["u"], line["v"]]


def test_a_point_in_the_hand_is_followed_in_the_other_views(reviewing):
    """Expected places are those of the three formulas of small_trial.py, solved by numpy."""
    notebook, _ = reviewing
    was, to = truth(0), (truth(0)[0] + 40, truth(0)[1] - 30)
    notebook.drag("cam1", was, to, release=False)
    u, v = notebook.js("[c.stages[0].drag.point.u, c.stages[0].drag.point.v]")
    np.testing.assert_allclose((u, v), to, atol=1.1)
    notebook.wait("!c.dirty && c.stages[1].live && c.stages[2].live")
    # cam1 knows x and z: v is level in cam2, u upright in cam3
    x, z = u - 60, 300 - v
    ends = notebook.js("[c.stages[1].live.line, c.stages[2].live.line]")
    np.testing.assert_allclose([v for _, v in ends[0]], 280 - z, atol=1e-6)
    np.testing.assert_allclose(sorted(u for u, _ in ends[0]), (-0.5, 639.5), atol=1e-6)
    np.testing.assert_allclose([u for u, _ in ends[1]], x + 40, atol=1e-6)
    # all three views tracked it, so all three say where it is
    A = np.array([[1, 0, 0], [0, 0, -1], [1, 0.5, 0], [0, 0, -1], [1, 0, 0], [0, 1, 0]])
    seen = [x + 60, v, *truth(0, 1), *truth(0, 2)]
    xyz = np.linalg.lstsq(A, np.array(seen) - [60, 300, 0, 280, 40, 80], rcond=None)[0]
    at = (xyz[0] + 40, 80 + xyz[1])
    np.testing.assert_allclose(notebook.js("c.stages[2].live.at"), at, atol=1e-6)
    off = np.hypot(*np.subtract(at, truth(0, 2)))
    notebook.js("c.moved()")  # as where a picture that was fetched ahead arrives just now
    said = notebook.js("c.detail.textContent")
    assert said.startswith("FR is off by ")
    assert said.endswith(f"{off:.{1 if off < 10 else 0}f} px in cam3")
    notebook.page.mouse.up()
    notebook.settle()
    assert notebook.js("c.stages.map((s) => s.live)") == [None] * 3
    assert "is off by" not in notebook.js("c.detail.textContent")
    # what two hands have placed overrules the tracker in the third view
    notebook.drag("cam2", truth(0, 1), (110, 280 - z), release=False)
    u2, v2 = notebook.js("[c.stages[1].drag.point.u, c.stages[1].drag.point.v]")
    placed = notebook.py("w.session.position(0, 'cam1', 'FR')")
    y = 2 * (u2 - (placed[0] - 60))
    notebook.wait("!c.dirty && c.stages[2].live && c.stages[2].live.at")
    np.testing.assert_allclose(
        notebook.js("c.stages[2].live.at"), (placed[0] - 20, 80 + y), atol=1e-6
    )
    assert abs(notebook.js("c.stages[0].live.off") - abs(v2 + 20 - placed[1]) / 2) < 1e-6
    notebook.press("Escape")
    notebook.page.mouse.up()
    notebook.settle()
    # a click where one other view contradicts it says so while it is made
    notebook.click("cam2", *truth(0, 1, 1), button="right")
    notebook.settle()
    notebook.page.locator("[data-view=cam2] [data-point=HR]").click()
    notebook.page.mouse.move(*notebook.at("cam2", truth(0, 1, 1)[0], truth(0, 1, 1)[1] + 30))
    notebook.wait("c.stages[1].aim !== null")
    aim = notebook.js("c.stages[1].aim")
    said = notebook.js(
        f"c.stages[1].offWords('HR', {aim['u']}, {aim['v']}, true, c.stages[1].aim.guide)"
    )
    assert said == f"⚠ {aim['v'] - truth(0, 1, 1)[1]:.0f} px"
    notebook.assert_no_errors()


def test_a_save_that_is_refused_says_so_in_sight(reviewing):
    """Its button stands below the pictures, and the words above them."""
    notebook, _ = reviewing
    page = notebook.page
    page.set_viewport_size({"width": 1366, "height": 600})
    try:
        notebook.kernel_runs(
            "from pawnb.errors import InputError\n"
            "def full():\n"
            "    raise InputError('the disc is full.')\n"
            "w.session.save = full"
        )
        button = page.get_by_role("button", name="Save tracks")
        button.scroll_into_view_if_needed()
        button.click()
        alarm = page.locator(".pawnb-alarm", has_text="the disc is full")
        alarm.wait_for()
        page.wait_for_timeout(300)
        box = alarm.bounding_box()
        panel = page.locator(".jp-WindowedPanel-outer").first.bounding_box()
        assert box["y"] >= panel["y"] - 1
        assert box["y"] + box["height"] <= panel["y"] + panel["height"] + 1
    finally:
        page.set_viewport_size({"width": 1500, "height": 1000})


def test_undo_redo_go_to_the_frame_they_change(reviewing):
    notebook, file = reviewing
    notebook.drag("cam1", truth(0), (200, 100))
    notebook.settle()
    moved = notebook.py("w.session.position(0, 'cam1', 'FR')")
    notebook.focus()
    notebook.press("End")
    notebook.settle()
    notebook.press("Control+z")
    notebook.wait("c.painted === 0 && c.pending === 0")
    notebook.settle()
    assert notebook.py("w.session.position(0, 'cam1', 'FR')") == list(truth(0))
    assert notebook.page.locator("[data-action=undo]").is_disabled()
    point = notebook.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), truth(0), atol=0.01)
    notebook.press("Control+Shift+Z")
    notebook.settle()
    assert notebook.py("w.session.position(0, 'cam1', 'FR')") == moved
    assert [line["edit"] for line in lines(file)] == ["move", "undo", "redo"]
    # an answer that was on its way since before these corrections does not bring them back
    late = "{frame: 0, sent: false, shrink: [1, 1, 1], version: 0, overlay: {views: {}}}"
    notebook.js(f"f.received({late}, [])")
    assert notebook.js("f.overlays.get(0).views.cam1.points.length") == 2
    text = notebook.page.locator(".pawnb-status").inner_text()
    assert text.splitlines() == [
        "Made again: FR in cam1 moved in frame 0.", "1 correction in edits.jsonl.",
    ]  # fmt: skip


def test_hide_place_accept_and_exchange(reviewing):
    notebook, file = reviewing
    notebook.click("cam2", *truth(0, 1, 1), button="right")
    notebook.settle()
    assert lines(file)[-1] == {"edit": "hide", "frame": 0, "view": "cam2", "point": "HR"}
    # a click on the picture means nothing until the missing point is chosen
    notebook.click("cam2", 400, 300)
    notebook.settle()
    assert len(lines(file)) == 1
    notebook.page.locator("[data-view=cam2] [data-point=HR]").click()
    notebook.click("cam2", 400, 300)
    notebook.settle()
    assert lines(file)[-1]["edit"] == "move"
    np.testing.assert_allclose(
        notebook.py("w.session.position(0, 'cam2', 'HR')"), (400, 300), atol=1.1
    )
    notebook.page.locator("[data-view=cam1] [data-point=FR]").click()
    notebook.press("a")
    notebook.settle()
    assert lines(file)[-1]["edit"] == "accept"
    detail = notebook.page.locator(".pawnb-detail").inner_text()
    assert detail.startswith("cam1, FR: placed by hand, residual 0.0 px")
    notebook.page.locator("[data-action=swap]").select_option(label="FR and HR")
    notebook.settle()
    assert lines(file)[-1] == {
        "edit": "swap",
        "frame": 0,
        "first": "FR",
        "second": "HR",
        "view": None,
    }
    assert notebook.py("w.session.position(5, 'cam1', 'HR')") == list(truth(5))


def test_tracking_again_from_here_and_keys_that_stay_in_the_widget(reviewing):
    notebook, file = reviewing
    notebook.focus()
    cells = notebook.n_cells()
    notebook.press("Shift+ArrowRight")
    notebook.settle()
    notebook.press("r")
    notebook.until("asked", [10])
    notebook.wait("c.status.innerText.startsWith('Tracked again from frame 10 on')")
    notebook.settle()
    assert lines(file) == [{"edit": "retrack", "frame": 10}]
    # the screen shows the new place without any further key
    notebook.wait("c.stages[0].overlay.points.find((p) => p.id === 'FR').u > "
                  f"{truth(10)[0] + 4.9}")  # fmt: skip
    assert notebook.py("w.session.position(9, 'cam1', 'FR')") == list(truth(9))
    assert notebook.py("w.session.position(11, 'cam1', 'FR')") == [truth(11)[0] + 5, truth(11)[1]]
    notebook.press("Control+z")
    notebook.settle()
    assert notebook.py("w.session.position(11, 'cam1', 'FR')") == list(truth(11))
    for key in ("b", "d", "d", "x", "v", "m", "Enter", "ArrowDown", "ArrowUp"):
        notebook.press(key)
    # D asks for a doubtful frame; what is pressed before the answer comes is overtaken by it
    notebook.settle()
    notebook.press("Home")
    notebook.wait("c.painted === 0")
    assert notebook.n_cells() == cells
    notebook.assert_no_errors()


def test_new_colours_are_learnt_where_the_button_or_its_key_says_so(notebook, small_trial):
    """The tracker is the real one: what it was asked for stands in the record of the tracks."""
    notebook.show(f"""import json, pawnb
from pawnb.widgets import TrackReviewer
made = pawnb.track({str(small_trial)!r}, method="paper", frames=(0, 12))
def learnt():
    steps = json.loads(w.tracks.attrs["provenance"])["steps"]
    return [(s["frame"], s["points"], s["learn"]) for s in steps if s["step"] == "retrack"]
w = TrackReviewer({str(small_trial)!r}, made)
w""")
    file = small_trial / "results" / "edits.jsonl"
    notebook.focus()
    for _ in range(4):
        notebook.press("ArrowRight")
    notebook.settle()
    was = notebook.py("w.session.position(4, 'cam1', 'FR')")
    notebook.drag("cam1", was, (was[0] + 6, was[1] - 4))
    notebook.settle()
    put = notebook.py("w.session.position(4, 'cam1', 'FR')")
    assert put != was
    button = notebook.page.get_by_role("button", name="… with new colours")
    button.click()
    notebook.wait("c.status.innerText.startsWith('Tracked again from frame 4 on')")
    notebook.settle()
    assert notebook.py("learnt()") == [[4, ["FR"], True]]
    assert lines(file)[-1] == {"edit": "retrack", "frame": 4, "learn": True}
    # what was put in place stays there, and the screen shows it
    assert notebook.py("w.session.position(4, 'cam1', 'FR')") == put
    point = notebook.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), put, atol=0.01)
    assert point["origin"] == "edited"
    # tracking again alone learns nothing; the key does the same as the button
    for key, learn in (("r", [True, False]), ("l", [True, False, True])):
        notebook.press(key)
        notebook.until("[[step[2] for step in learnt()], w.session.busy]", [learn, False])
        # keys are heard again once what was done is said
        notebook.wait("c.status.innerText.startsWith('Tracked again from frame 4 on')")
    notebook.assert_no_errors()


def test_pictures_arrive_as_text_where_binary_messages_get_lost(reviewing):
    notebook, _ = reviewing
    # a front end that drops the buffers on their way to the browser
    notebook.kernel_runs(
        "send = type(w).send\nw.send = lambda content, buffers=None: send(w, content)"
    )
    notebook.page.evaluate("document.querySelector('.pawnb-root')._pawnb.frames.pictures.clear()")
    notebook.focus()
    notebook.press("End")
    notebook.wait(f"c.painted === {scene.N_FRAMES - 1} && f.plain")
    notebook.settle()
    assert seen_frame(notebook) == scene.N_FRAMES - 1
