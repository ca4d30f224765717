"""Kernels that end, restart, are busy or fall silent, in a real browser: nothing seems saved that
is not, and what was saved is there again when the cell is run again."""

import json

import numpy as np
import pytest
import small_pose_trial as spider
import small_trial as scene

pytestmark = pytest.mark.browser

LOST = ".pawnb-lost"


def lines(file):
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def restart(notebook):
    notebook.page.evaluate(
        "window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.restart()"
    )


def kill(notebook):
    """End the kernel's process as a crash would; its server starts another."""
    notebook.page.evaluate(
        """() => { window.jupyterapp.shell.currentWidget.sessionContext.session.kernel
            .requestExecute({code: 'import os\\nos.kill(os.getpid(), 9)', store_history: false})
            .done.catch(() => {}); }"""
    )


def dismiss(notebook):
    """Close what Jupyter says of a kernel that died: it would take the clicks that follow."""
    button = notebook.page.locator(".jp-Dialog button", has_text="Ok")
    button.wait_for(timeout=60_000)
    button.click()


def begin(notebook, code):
    """Let the kernel begin something, and do not wait for it."""
    notebook.page.evaluate(
        """(code) => { window.jupyterapp.shell.currentWidget.sessionContext.session.kernel
            .requestExecute({code, store_history: false}).done.catch(() => {}); }""",
        code,
    )


def wait_lost(notebook):
    notebook.wait("c.connection.down && f.asked === null && f.ahead === null", seconds=60)
    text = notebook.page.locator(LOST).inner_text()
    assert text.startswith("Not connected: nothing is saved.")
    assert "(loading" not in notebook.page.locator(".pawnb-caption").inner_text()
    return text


@pytest.mark.parametrize("end", [kill, restart])
def test_points_tracked_again_are_there_after_the_kernel_ended(notebook, small_trial, end):
    """The tracker is the real one; what is opened again comes from files alone."""
    source = f"""from pathlib import Path
import pawnb
from pawnb.io.native import read_tracks
from pawnb.widgets import TrackReviewer
trial = Path({str(small_trial)!r})
if not (trial / "results" / "tracks.nc").exists():
    pawnb.track(trial, method="paper", frames=(0, 12), out=trial / "results")
w = TrackReviewer(trial, read_tracks(trial / "results" / "tracks.nc"))
w"""
    notebook.show(source)
    file = small_trial / "results" / "edits.jsonl"
    notebook.focus()
    for _ in range(4):
        notebook.press("ArrowRight")
    notebook.settle()
    was = notebook.py("w.session.position(4, 'cam1', 'FR')")
    notebook.drag("cam1", was, (was[0] + 6, was[1] - 4))
    notebook.settle()
    notebook.press("r")
    notebook.until("[len(w.session.corrections), w.session.busy]", [2, False], seconds=90)
    notebook.settle()
    put = {frame: notebook.py(f"w.session.position({frame}, 'cam1', 'FR')") for frame in (4, 6)}
    kept = lines(file)
    assert [line["edit"] for line in kept] == ["move", "retrack"]

    end(notebook)
    assert "has ended or was restarted: run its cell again" in wait_lost(notebook)
    if end is kill:
        dismiss(notebook)
    shown = notebook.js("f.shown")
    # a point cannot be dragged, and nothing can be pressed
    notebook.drag("cam1", put[4], (put[4][0] + 30, put[4][1]))
    point = notebook.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), put[4], atol=0.01)
    notebook.click("cam1", put[4][0], put[4][1], button="right")
    for key in ("a", "Control+z", "Delete"):
        notebook.press(key)
    for action in ("undo", "save", "accept"):
        assert notebook.page.locator(f"[data-action={action}]").is_disabled()
    assert notebook.js("c.pending") == 0
    # frames that were fetched before can be looked at; others do not come
    notebook.press("End")
    notebook.js("f.go(11)")
    assert notebook.js("f.loading") is False
    assert notebook.js("f.shown") in (shown, 11)
    assert lines(file) == kept

    notebook.wait_idle()
    notebook.show(source)
    assert "2 corrections in edits.jsonl" in notebook.page.locator(".pawnb-status").inner_text()
    assert notebook.page.locator(LOST).is_hidden()
    for frame, place in put.items():
        assert notebook.py(f"w.session.position({frame}, 'cam1', 'FR')") == place
    notebook.focus()
    notebook.press("Home")
    notebook.wait("c.painted === 0")
    notebook.settle()
    notebook.click("cam1", *notebook.py("w.session.position(0, 'cam1', 'FR')"))
    notebook.press("a")
    notebook.settle()
    assert lines(file)[-1]["edit"] == "accept"
    notebook.assert_no_errors()


def test_poses_tracked_again_are_there_after_the_kernel_was_restarted(notebook, tmp_path):
    trial = spider.write_pose_trial(tmp_path / "trial")
    source = f"""from pathlib import Path
import pawnb, small_pose_trial as scene
from pawnb.io.native import read_tracks
from pawnb.widgets import PoseReviewer
trial = Path({str(trial.parent)!r})
if not (trial / "results" / "tracks.nc").exists():
    from pawnb.core.pose.pose_table import write_start
    write_start(trial / "start_pose.csv", scene.SPECIES, scene.truth(), species=scene.SPECIES)
    pawnb.track(trial, settings={{"choose_path": False}}, out=trial / "results")
w = PoseReviewer(trial, read_tracks(trial / "results" / "tracks.nc"), frame=3)
w"""
    notebook.show(source)
    found = notebook.js("c.stages[0].stick.handles().find((h) => h.id === 'R2')")
    notebook.drag("top", (found["u"], found["v"]), (found["u"] + 6, found["v"] + 5))
    notebook.settle()
    notebook.press("r")
    notebook.until("[len(w.corrected.corrections), w.corrected.busy]", [2, False], seconds=90)
    notebook.settle()
    tips = "[w.session.pose_at(f).places('R2')[-1].tolist() for f in (2, 3, 4)]"
    put = notebook.py(tips)
    kept = lines(trial.parent / "results" / "edits.jsonl")
    assert [line["edit"] for line in kept] == ["pose", "retrack"]
    restart(notebook)
    wait_lost(notebook)
    before = notebook.js("c.stages[0].stick.handles().find((h) => h.id === 'R2')")
    notebook.drag("top", (before["u"], before["v"]), (before["u"] + 20, before["v"]))
    after = notebook.js("c.stages[0].stick.handles().find((h) => h.id === 'R2')")
    assert (after["u"], after["v"]) == (before["u"], before["v"])
    notebook.wait_idle()
    notebook.show(source)
    assert "2 corrections in edits.jsonl" in notebook.page.locator(".pawnb-status").inner_text()
    np.testing.assert_allclose(notebook.py(tips), put, atol=1e-6)
    assert lines(trial.parent / "results" / "edits.jsonl") == kept


@pytest.fixture
def reviewing(notebook, trial_file):
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
w = TrackReviewer({str(trial_file)!r}, scene.true_tracks())
w""")
    return notebook, trial_file.parent / "results" / "edits.jsonl"


def test_a_kernel_that_is_busy_is_waited_for_and_what_was_done_is_kept(reviewing, tmp_path):
    notebook, file = reviewing
    done = tmp_path / "done"
    begin(notebook, f"import os, time\nwhile not os.path.exists({str(done)!r}): time.sleep(0.05)")
    u, v = scene.seen(0)[0, 0]
    try:
        notebook.drag("cam1", (u, v), (u + 20, v + 10))
        # newer kernels answer widgets beside what a cell does, others do so after it
        notebook.wait("c.connection.busy || c.pending === 0", seconds=60)
        assert notebook.js("c.connection.down") is False
        assert notebook.page.locator(LOST).is_hidden()
        if notebook.js("c.connection.busy"):
            assert "is not saved yet" in notebook.page.locator(".pawnb-detail").inner_text()
    finally:
        done.write_text("")
    notebook.wait("c.pending === 0 && !c.connection.busy", seconds=60)
    notebook.settle()
    assert [line["edit"] for line in lines(file)] == ["move"]


def test_a_widget_that_python_knows_no_more_is_not_connected(reviewing):
    """The kernel is well and answers, but not for this widget."""
    notebook, file = reviewing
    notebook.kernel_runs("w.on_msg(w._receive, remove=True)")
    u, v = scene.seen(0)[0, 0]
    notebook.drag("cam1", (u, v), (u + 20, v + 10))
    text = wait_lost(notebook)
    assert "The last change got no answer and may not be saved; it is shown as before." in text
    point = notebook.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), (u, v), atol=0.01)
    assert lines(file) == []
    assert notebook.page.get_by_role("button", name="Ask again").is_visible()
    # it is there again: noticed as soon as the kernel does anything, or when asked
    notebook.kernel_runs("w.on_msg(w._receive)")
    notebook.wait("!c.connection.down")
    notebook.settle()
    assert notebook.page.locator(LOST).is_hidden()
    notebook.drag("cam1", (u, v), (u + 20, v + 10))
    notebook.settle()
    assert [line["edit"] for line in lines(file)] == ["move"]


def test_a_question_that_is_lost_is_asked_again(reviewing):
    """As where Jupyter opens its line anew just then; nobody presses anything."""
    notebook, file = reviewing
    notebook.js("void (c.really = c.model.send, c.model.send = () => {}, c.connection.ask())")
    wait_lost(notebook)
    notebook.js("void (c.model.send = c.really)")
    notebook.wait("!c.connection.down")
    assert notebook.page.locator(LOST).is_hidden()
    u, v = scene.seen(0)[0, 0]
    notebook.drag("cam1", (u, v), (u + 20, v + 10))
    notebook.settle()
    assert [line["edit"] for line in lines(file)] == ["move"]


def test_plots_say_that_their_kernel_has_ended(notebook):
    notebook.run("""import numpy as np
import pandas as pd
from pawnb.widgets import ResidualExplorer
t = np.arange(200) / 250.0
w = ResidualExplorer(pd.DataFrame({"x": np.sin(2 * np.pi * 4 * t)}), fs_hz=250.0)
w""")
    notebook.page.locator(".jupyter-matplotlib canvas").last.wait_for(timeout=60_000)
    notebook.wait_idle()
    lost = notebook.page.locator(f".pawnb-surroundings {LOST}")
    assert lost.is_hidden()
    restart(notebook)
    lost.wait_for(state="visible", timeout=60_000)
    assert lost.inner_text().startswith("Not connected: nothing is saved. The kernel of this")
    notebook.wait_idle()
