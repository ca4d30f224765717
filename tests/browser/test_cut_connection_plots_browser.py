"""The explorers and the workbench in a real browser: the kernel killed in mid-drag, the line cut
and back, one notebook in two windows. What was kept is there, and nothing else seems to be."""

import json

import pytest
from jupyter_page import NotebookPage
from test_connection_browser import LOST, dismiss, kill, lines
from test_cut_connection_browser import cut, join
from test_gait_explorer_browser import (
    FIRST,
    click,
    pick_stride,
    press_pep,
    shown,
    told,
)

pytestmark = pytest.mark.browser

PLOTS = ".jupyter-matplotlib canvas"


@pytest.fixture
def gait(notebook, tmp_path):
    """The explorer of strides with one event dragged: its source and its file."""
    file = tmp_path / "event_edits.jsonl"
    source = f"""from pawnb import gait
from pawnb.synthetic.spider_study import simulate_spider_study
from pawnb.widgets import GaitExplorer
run = simulate_spider_study(animals=1, trials=1, seed=3).runs[0]
w = GaitExplorer(gait.analyse(run.tracks(noise_px=0.2), trial=run.trial), {str(file)!r})
w"""
    shown(notebook, source)
    pick(notebook)
    x, y = press_pep(notebook, stance_end(notebook))
    notebook.page.mouse.move(x + 12, y, steps=4)
    notebook.page.mouse.up()
    told(notebook, "1 correction;")
    assert len(lines(file)) == 1
    return notebook, source, file


def stance_end(notebook):
    return notebook.py(f"float({FIRST}['start_s'] + {FIRST}['stance_s'])")


def pick(notebook):
    notebook.page.get_by_label("phase of").last.select_option("R2 to R3")
    notebook.until("list(w.session.pair)", ["R2", "R3"], seconds=30)
    pick_stride(notebook, notebook.py(f"float({FIRST}['start_s'])"))


def lost(notebook):
    """Wait until the widget says that Python does not hear it."""
    line = notebook.page.locator(f".pawnb-surroundings {LOST}:visible").first
    line.wait_for(timeout=60_000)
    text = line.inner_text()
    assert text.startswith("Not connected: nothing is saved.")
    return text


def hears_again(notebook):
    """Wait until the line is back; Jupyter, too, connects again, at a time of its own."""
    join(notebook)
    notebook.page.wait_for_timeout(4000)
    line = notebook.page.locator(f".pawnb-surroundings {LOST}").first
    line.wait_for(state="hidden", timeout=60_000)
    notebook.wait_idle()


def test_a_kernel_killed_while_an_event_is_dragged_keeps_what_was_corrected(gait):
    notebook, source, file = gait
    kept, was = lines(file), stance_end(notebook)
    x, y = press_pep(notebook, was)
    notebook.page.mouse.move(x + 15, y, steps=3)
    kill(notebook)
    assert "has ended or was restarted: run its cell again" in lost(notebook)
    notebook.page.mouse.up()
    dismiss(notebook)
    notebook.wait_idle()
    assert lines(file) == kept
    shown(notebook, source)
    told(notebook, "1 correction")
    assert stance_end(notebook) == pytest.approx(was)
    assert notebook.page.locator(f".pawnb-surroundings {LOST}:visible").count() == 0


def test_a_line_that_is_cut_and_back_keeps_corrections_and_what_was_typed(gait):
    notebook, _, file = gait
    kept = lines(file)
    pick(notebook)
    cut(notebook)
    assert "its connection is lost" in lost(notebook)
    notebook.page.get_by_placeholder("reason").last.fill("stumbled")
    click(notebook, "exclude stride")
    notebook.page.wait_for_timeout(1500)
    assert lines(file) == kept
    # Jupyter hands over what was pressed meanwhile when the line is back: it is done then, once
    hears_again(notebook)
    told(notebook, "2 corrections")
    assert [line.get("reason") for line in lines(file)][1:] == ["stumbled"]
    notebook.page.get_by_text("2 corrections").last.wait_for(timeout=30_000)
    click(notebook, "undo")
    told(notebook, "1 correction")


def second_window(notebook):
    """Open the same notebook in another window."""
    notebook.page.evaluate("window.jupyterapp.commands.execute('docmanager:save')")
    page = notebook.page.context.browser.new_page(viewport={"width": 1500, "height": 1000})
    page.goto(notebook.page.url.replace("?reset", ""))
    other = NotebookPage.__new__(NotebookPage)  # of a notebook that is there
    other.page, other.errors = page, []
    return other


def test_one_notebook_in_two_windows_shows_in_each_what_is_corrected_in_the_other(gait):
    notebook, _, file = gait
    other = second_window(notebook)
    try:
        other.page.locator(PLOTS).last.wait_for(timeout=90_000)
        other.wait_idle()
        other.page.get_by_text("1 correction").last.wait_for(timeout=30_000)
        notebook.page.bring_to_front()
        press_pep(notebook, stance_end(notebook))
        notebook.page.mouse.up()
        click(notebook, "delete event")
        told(notebook, "2 corrections")
        other.page.get_by_text("2 corrections").last.wait_for(timeout=30_000)
        other.page.bring_to_front()
        click(other, "undo")
        told(notebook, "1 correction")
        notebook.page.bring_to_front()  # a window that nobody sees need not be drawn
        notebook.page.get_by_text("1 correction").last.wait_for(timeout=30_000)
        other.page.bring_to_front()
        # and with the mouse in the plots of the other window
        pick_stride(other, notebook.py(f"float({FIRST}['start_s'])"))
        x, y = press_pep(other, stance_end(notebook))
        other.page.mouse.move(x - 12, y, steps=4)
        other.page.mouse.up()
        told(notebook, "2 corrections")
        notebook.page.bring_to_front()
        notebook.page.get_by_text("2 corrections").last.wait_for(timeout=30_000)
        assert len(lines(file)) >= 2
    finally:
        other.page.close()


RESIDUAL = """import numpy as np, pandas as pd
from pawnb.widgets import ResidualExplorer
t = np.arange(400) / 100.0
rng = np.random.default_rng(3)
signals = pd.DataFrame({"a": 10 * np.sin(4 * np.pi * t) + 0.3 * rng.standard_normal(400)})
w = ResidualExplorer(signals, fs_hz=100.0, unit="mm")
w"""


def drag_cutoff(notebook, by=30, *, release=True):
    """Drag in the residual curve, the left third of the picture."""
    canvas, mouse = notebook.page.locator(PLOTS).last, notebook.page.mouse
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    x, y = box["x"] + 0.2 * box["width"], box["y"] + 0.4 * box["height"]
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + by, y, steps=5)
    if release:
        mouse.up()


@pytest.fixture
def residual(notebook):
    shown(notebook, RESIDUAL)
    before = notebook.py("w.cutoff_hz")
    drag_cutoff(notebook)
    notebook.until(f"w.cutoff_hz != {before!r}", True, seconds=30)
    notebook.wait_idle()
    notebook.page.wait_for_timeout(500)
    return notebook


def box_says_the_cutoff(notebook, window):
    """Wait until the box in a window says the cut-off that the widget has."""
    box = window.page.locator("input[type=number]").last
    # moves may still arrive on a slow machine: what is shown and what is so must meet
    for _ in range(40):
        said, now = float(box.input_value()), notebook.py("w.cutoff_hz")
        if said == pytest.approx(now, abs=1e-3):
            break
        window.page.wait_for_timeout(500)
    assert said == pytest.approx(now, abs=1e-3)


def test_the_cutoff_of_the_hand_outlives_a_cut_line(residual):
    notebook, was = residual, residual.py("w.cutoff_hz")
    drag_cutoff(notebook, 5, release=False)
    cut(notebook)
    assert "its connection is lost" in lost(notebook)
    notebook.page.mouse.up()
    hears_again(notebook)
    box_says_the_cutoff(notebook, notebook)
    drag_cutoff(notebook, 60)
    notebook.until(f"w.cutoff_hz > {was!r}", True, seconds=30)


def test_a_kernel_killed_while_the_cutoff_is_dragged_is_said(residual):
    notebook = residual
    drag_cutoff(notebook, 40, release=False)
    kill(notebook)
    assert "has ended or was restarted: run its cell again" in lost(notebook)
    notebook.page.mouse.up()
    dismiss(notebook)
    notebook.wait_idle()
    shown(notebook, RESIDUAL)
    assert notebook.page.locator(f".pawnb-surroundings {LOST}:visible").count() == 0
    box_says_the_cutoff(notebook, notebook)


def test_the_cutoff_is_the_same_in_two_windows(residual):
    notebook = residual
    other = second_window(notebook)
    try:
        other.page.locator(PLOTS).last.wait_for(timeout=90_000)
        other.wait_idle()
        before = notebook.py("w.cutoff_hz")
        other.page.bring_to_front()
        drag_cutoff(other, 80)
        notebook.until(f"w.cutoff_hz != {before!r}", True, seconds=30)
        other.wait_idle()
        for one in (notebook, other):
            one.page.bring_to_front()
            box_says_the_cutoff(notebook, one)
    finally:
        other.page.close()


@pytest.fixture
def bench(notebook, trial_file):
    source = f"""import pawnb
w = pawnb.Workbench({str(trial_file.parent)!r})
w"""
    notebook.run(source)
    button(notebook, "Click the start").wait_for(timeout=60_000)
    button(notebook, "Click the start").click()
    notebook.page.locator(".pawnb-root").first.wait_for(timeout=60_000)
    notebook.wait("!!c && c.painted !== undefined && c.painted !== null && c.stages[0].fitted")
    notebook.settle()
    notebook.focus()
    view, point = notebook.js(
        "((s) => [s.name, s.overlay.asks])(c.stages.find((s) => s.overlay.asks))"
    )
    notebook.click(view, 200, 100)
    notebook.settle()
    start = trial_file.parent / "start.csv"
    assert f"{point}" in start.read_text()
    return notebook, source, start


def button(notebook, name):
    return notebook.page.get_by_role("button", name=name).first


def test_a_killed_kernel_is_said_in_the_workbench_and_its_work_is_there_again(bench):
    notebook, source, start = bench
    kept = start.read_bytes()
    kill(notebook)
    assert "has ended or was restarted: run its cell again" in lost(notebook)
    dismiss(notebook)
    button(notebook, "Look again").click()  # nobody hears it
    notebook.wait_idle()
    assert start.read_bytes() == kept
    notebook.run(source)
    notebook.page.locator(".jp-OutputArea select").last.wait_for(timeout=60_000)
    button(notebook, "Click the start").click()  # one of its points is placed, and kept
    notebook.page.locator(".pawnb-root").first.wait_for(timeout=60_000)
    notebook.settle()
    assert notebook.page.locator(f"{LOST}:visible").count() == 0
    assert notebook.js("c.stages.flatMap((s) => s.overlay.points || []).length") == 1


def test_a_line_that_is_cut_and_back_leaves_the_workbench_as_it_was(bench):
    notebook, _, start = bench
    kept = start.read_bytes()
    cut(notebook)
    assert "its connection is lost" in lost(notebook)
    assert notebook.js("c.connection.down")
    hears_again(notebook)
    notebook.wait("!c.connection.down", seconds=60)
    notebook.settle()
    assert start.read_bytes() == kept
    button(notebook, "Look again").click()
    notebook.until("len(w.session.states)", 1, seconds=20)
    notebook.wait_idle()
    assert notebook.page.locator(f"{LOST}:visible").count() == 0


def test_the_workbench_is_the_same_in_two_windows(bench):
    notebook, _, start = bench
    other = second_window(notebook)
    try:
        other.page.locator(".pawnb-root").first.wait_for(timeout=90_000)
        other.wait("!!c && c.painted !== undefined && c.painted !== null")
        other.settle()
        kept = start.read_bytes()
        other.page.bring_to_front()
        other.focus()
        view = other.js("c.stages.find((s) => s.overlay.asks).name")
        other.click(view, 220, 120)
        other.settle()
        assert start.read_bytes() != kept
        n = json.dumps(notebook.js("c.status.textContent"))
        notebook.wait(f"c.status.textContent !== '' && {n} !== null")
        # the step that is opened in one window is open in the other
        button(other, "Look again").click()
        notebook.page.bring_to_front()
        notebook.settle()
        assert notebook.js("c.stages.flatMap((s) => s.overlay.points || []).length") == other.js(
            "c.stages.flatMap((s) => s.overlay.points || []).length"
        )
    finally:
        other.page.close()
