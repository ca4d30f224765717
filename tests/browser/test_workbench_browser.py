"""The workbench in a real browser: hostile names run nothing, nothing overflows in any theme."""

import json
import os
import shutil

import pytest
from test_connection_browser import restart
from test_small_screen_browser import set_theme

pytestmark = pytest.mark.browser

HOSTILE = ["<img src=x onerror=window.hurt=1>", "a" * 200, "\u05e9\u05dc\u05d5\u05dd", "$x^2$"]


@pytest.fixture
def folder(trial_file, tmp_path):
    """Four trials with hostile names; the last cannot be read."""
    text = trial_file.read_text()
    for k, name in enumerate(HOSTILE):
        place = tmp_path / "bench" / f"t{k}"
        place.mkdir(parents=True)
        toml = text.replace('name = "small"', f"name = {json.dumps(name)}")
        (place / "trial.toml").write_text(toml if k < 3 else '[trial]\n"<b onclick=x>" = 1\n')
    return tmp_path / "bench"


@pytest.mark.parametrize(("width", "height"), [(900, 768), (1366, 768), (1920, 1200)])
@pytest.mark.parametrize("theme", ["Light", "Dark"])
def test_hostile_names_run_nothing_and_nothing_overflows(notebook, folder, width, height, theme):
    page = notebook.page
    page.set_viewport_size({"width": width, "height": height})
    set_theme(notebook, theme)
    try:
        notebook.run(f"import pawnb\nw = pawnb.Workbench({str(folder)!r})\nw")
        button = page.get_by_role("button", name="Click the start")
        button.first.wait_for(timeout=60_000)
        mend = page.get_by_role("button", name="What to mend")
        mend.wait_for(timeout=60_000)
        assert button.count() == 3
        assert page.get_by_text(HOSTILE[0], exact=True).is_visible()
        assert page.evaluate("window.hurt") is None
        area = page.locator(".jp-OutputArea-output").last.bounding_box()
        # JupyterLab's own panels leave half of a window of 900 px
        controls = ".jp-OutputArea :is(button, select, .widget-label)"
        visible = "[...document.querySelectorAll(s)].filter((e) => e.offsetParent).length > 30"
        page.wait_for_function(f"(s) => {visible}", arg=controls)
        shown = page.locator(controls).all()
        boxes = [box for one in shown if (box := one.bounding_box()) is not None]
        assert len(boxes) > 30
        for box in boxes:
            assert box["x"] + box["width"] <= area["x"] + area["width"] + 1
        # what is wrong is said in words, and the one step there is says what to mend
        mend.click()
        page.get_by_text("has an unknown field").first.wait_for(timeout=20_000)
        assert page.evaluate("window.hurt") is None
        notebook.assert_no_errors()
    finally:
        set_theme(notebook, "Light")
        page.set_viewport_size({"width": 1500, "height": 1000})


def test_half_filled_forms_with_hostile_names_run_nothing_and_are_there_again(
    notebook, trial_file, tmp_path
):
    page = notebook.page
    page.set_viewport_size({"width": 1366, "height": 768})
    (tmp_path / "bare").mkdir()
    names = [HOSTILE[0].replace("/", ""), "a" * 200, HOSTILE[2]]
    videos = [
        shutil.copy(trial_file.parent / "cam1.avi", tmp_path / "bare" / f"{name}.avi")
        for name in (names[1:] if os.name == "nt" else names[:2])
    ]
    source = f"""import pawnb
w = pawnb.Workbench({str(tmp_path / "bare")!r}, {[str(video) for video in videos]!r})
w"""
    over = """() => { const area = [...document.querySelectorAll('.jp-OutputArea-output')].pop();
        const right = area.getBoundingClientRect().right + 1;
        return [...area.querySelectorAll('button, select, input, canvas, .widget-label')]
            .filter((e) => e.offsetParent && e.getBoundingClientRect().right > right)
            .map((e) => e.className); }"""
    try:
        notebook.show(source)
        page.get_by_label("animal", exact=True).select_option(label="other: points that you name")
        page.get_by_placeholder("names with commas between").wait_for()
        typed = {"names with commas between": ", ".join(HOSTILE), "frames a second": HOSTILE[0]}
        for place, text in typed.items():
            page.get_by_placeholder(place).fill(text)
        page.get_by_role("button", name="Make the trial").click()
        page.get_by_text("expected a number").wait_for()
        assert page.evaluate(over) == []
        restart(notebook)
        page.locator(".pawnb-lost:visible").first.wait_for(timeout=60_000)
        notebook.wait_idle()
        notebook.show(source)
        for place, text in typed.items():
            assert page.get_by_placeholder(place).input_value() == text
        assert page.evaluate("window.hurt") is None
    finally:
        page.set_viewport_size({"width": 1500, "height": 1000})
    notebook.assert_no_errors()


def test_what_is_being_done_is_in_sight(notebook, trial_file):
    """The page was scrolled down to a tool, which is put away as the work begins."""
    page = notebook.page
    page.set_viewport_size({"width": 1366, "height": 768})
    try:
        notebook.show(f"""import pawnb, threading
go = threading.Event()
w = pawnb.Workbench({str(trial_file.parent)!r})
w.do("start", w.session.states[0].folder)
w.session.track = lambda state, progress: go.wait(60)
w""")
        panel = "document.querySelector('.jp-WindowedPanel-outer')"
        page.wait_for_timeout(500)
        page.evaluate(f"{panel}.scrollTop = 600")
        notebook.py("w.do('track', w.session.states[0].folder)")
        stop = page.get_by_role("button", name="Stop")
        stop.wait_for()
        page.wait_for_timeout(1000)
        top = page.evaluate(f"{panel}.getBoundingClientRect().top")
        assert top <= stop.bounding_box()["y"] < 768
    finally:
        notebook.py("go.set()")
        page.set_viewport_size({"width": 1500, "height": 1000})
    notebook.assert_no_errors()
