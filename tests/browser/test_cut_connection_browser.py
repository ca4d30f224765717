"""Every widget that shows pictures, in a real browser: the kernel killed in mid-drag, the line cut
and back, one notebook in two windows. Nothing seems kept that is not; what was kept is there."""

import time
from types import SimpleNamespace

import ball_scene
import numpy as np
import pytest
import small_pose_trial as spider
import small_trial as scene
from jupyter_page import NotebookPage
from test_connection_browser import LOST, dismiss, kill, wait_lost

pytestmark = pytest.mark.browser

KINDS = ("initialiser", "reviewer", "poser", "pose_reviewer", "digitiser")


_INITIALISER = """from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({trial!r})
w"""
_REVIEWER = """import small_trial as scene
from pawnb.widgets import TrackReviewer
w = TrackReviewer({trial!r}, scene.true_tracks())
w"""
_DIGITISER = """from pathlib import Path
from pawnb.widgets import CalibrationDigitiser
home = Path({home!r})
w = CalibrationDigitiser({{"left": home / "in" / "left", "right": home / "in" / "right"}},
                         points=home / "in" / "points.csv", folder=home)
w"""
_BALL = next(iter(ball_scene.PLACES))


@pytest.fixture
def widget(request, notebook, tmp_path, trial_file):
    """One of the widgets, with one thing made in it and kept: its source, view, mark and file."""
    kind, home = request.param, tmp_path / "home"
    home.mkdir()
    names = {"trial": str(trial_file), "home": str(home)}
    click = None
    if kind == "initialiser":
        file, click = trial_file.parent / "start.csv", scene.seen(0)[0, 0]
        made = of(_INITIALISER.format(**names), "cam1", "FR", file)
    elif kind == "reviewer":
        file = trial_file.parent / "results" / "edits.jsonl"
        made = of(_REVIEWER.format(**names), "cam1", "FR", file)
    elif kind == "digitiser":
        ball_scene.write(home / "in")
        click = ball_scene.seen("left", [ball_scene.PLACES[_BALL]])[0]
        made = of(_DIGITISER.format(**names), "left", _BALL, home / "calibration_clicks.csv")
    else:
        made = _of_spider(kind, home)
    notebook.show(made.source)
    made.notebook = notebook
    notebook.focus()
    if click is not None:  # something to drag
        notebook.click(made.view, *map(float, click))
    else:
        start = place(made)
        drag(made, start, start + np.array([8, 6]))
    notebook.settle()
    assert made.file.exists(), sorted(path.name for path in made.file.parent.iterdir())
    return made


def of(source, view, mark, file):
    return SimpleNamespace(source=source, view=view, mark=mark, file=file)


def _of_spider(kind, home):
    trial = spider.write_pose_trial(home / "trial")
    if kind == "poser":
        file = home / "start_pose.csv"
        source = f"""from pawnb.widgets import StickPoser
w = StickPoser({str(trial)!r}, frame={spider.EMPTY}, path={str(file)!r})
w"""
        return of(source, "top", "R2", file)
    file = home / "edits.jsonl"
    source = f"""import numpy as np, small_pose_trial as spider
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.poses import join_poses
from pawnb.core.pose.track_result import plain_track
from pawnb.schema import add_provenance
from pawnb.widgets import PoseReviewer
poses = join_poses([spider.truth()] * 4)
poses.frames[:] = np.arange(spider.EMPTY, spider.N_FRAMES)
tracks = tracks_from_poses(spider.SPECIES, plain_track(spider.SPECIES, poses), fps=125.0,
                           view="top", individual="s1", px_per_unit=spider.SCALE, unit="mm")
tracks = add_provenance(tracks, step="track", method="pawnb", settings={{}},
                        start=[{{"frame": spider.EMPTY}}])
w = PoseReviewer({str(trial)!r}, tracks, edits={str(file)!r})
w"""
    return of(source, "top", "R2", file)


def place(made, notebook=None):
    """Where the mark is drawn, px of its view."""
    stage = f"c.stages.find((s) => s.name === {made.view!r})"
    marks = (
        f"[...({stage}.stick ? {stage}.stick.handles() : []), ...({stage}.overlay.points || [])]"
    )
    found = (notebook or made.notebook).js(f"{marks}.find((m) => m.id === {made.mark!r})")
    return np.array([found["u"], found["v"]])


def drag(made, start, end, **options):
    made.notebook.drag(made.view, *(tuple(map(float, at)) for at in (start, end)), **options)


def arrives(made, at, notebook=None):
    """Wait until the mark is there: another window hears a moment later of what is done."""
    end = time.monotonic() + 20
    while np.hypot(*(place(made, notebook) - at)) > 0.05:
        assert time.monotonic() < end, (place(made, notebook), at)
        time.sleep(0.05)


def moves(made, was):
    """Wait until the mark is elsewhere, and give its new place: a busy kernel takes its time."""
    end = time.monotonic() + 20
    while np.hypot(*(place(made) - was)) <= 3:
        assert time.monotonic() < end, (place(made), was)
        time.sleep(0.05)
    made.notebook.settle()
    return place(made)


def cut(notebook):
    """Close the line to the kernel, and let Jupyter open no other."""
    notebook.page.evaluate(
        """() => {
            const k = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
            window._open = k._createSocket; k._createSocket = () => {}; k._ws.close(); }"""
    )


def join(notebook):
    notebook.page.evaluate(
        """async () => {
            const k = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
            k._createSocket = window._open; await k.reconnect(); }"""
    )


@pytest.mark.parametrize("widget", KINDS, indirect=True)
def test_a_kernel_killed_in_mid_drag_loses_nothing_that_was_kept(widget):
    notebook, was, kept = widget.notebook, place(widget), widget.file.read_bytes()
    drag(widget, was, was + 15, release=False)
    kill(notebook)
    assert "has ended or was restarted: run its cell again" in wait_lost(notebook)
    notebook.page.mouse.up()
    np.testing.assert_allclose(place(widget), was, atol=1e-9)
    dismiss(notebook)
    notebook.wait_idle()
    assert widget.file.read_bytes() == kept
    notebook.show(widget.source)
    assert notebook.page.locator(LOST).is_hidden()
    np.testing.assert_allclose(place(widget), was, atol=0.05)
    notebook.assert_no_errors()


@pytest.mark.parametrize("widget", KINDS, indirect=True)
def test_a_line_that_is_cut_and_back_keeps_what_was_done(widget):
    notebook, was, kept = widget.notebook, place(widget), widget.file.read_bytes()
    drag(widget, was, was + 10, release=False)
    cut(notebook)
    text = wait_lost(notebook)
    assert "Python does not answer: its connection is lost" in text
    notebook.page.mouse.up()
    np.testing.assert_allclose(place(widget), was, atol=1e-9)
    drag(widget, was, was + 10)  # refused, and said
    np.testing.assert_allclose(place(widget), was, atol=1e-9)
    assert widget.file.read_bytes() == kept
    join(notebook)
    notebook.wait("!c.connection.down", seconds=60)
    notebook.settle()
    assert notebook.page.locator(LOST).is_hidden()
    # Jupyter, too, tries to connect again, at a time of its own, and closes the new line for it:
    # what is dragged in that moment is refused, as above
    for _ in range(3):
        notebook.page.wait_for_timeout(3000)
        notebook.wait("!c.connection.down", seconds=60)
        notebook.settle()
        drag(widget, was, was + 10)
        notebook.settle()
        if np.hypot(*(place(widget) - was)) > 3:
            break
    assert np.hypot(*(place(widget) - was)) > 3
    assert widget.file.read_bytes() != kept


@pytest.mark.parametrize("widget", KINDS, indirect=True)
def test_one_notebook_in_two_windows_shows_in_each_what_is_done_in_the_other(widget):
    notebook, was = widget.notebook, place(widget)
    notebook.page.evaluate("window.jupyterapp.commands.execute('docmanager:save')")
    second = notebook.page.context.browser.new_page(viewport={"width": 1500, "height": 1000})
    try:
        second.goto(notebook.page.url.replace("?reset", ""))
        other = NotebookPage.__new__(NotebookPage)  # of a notebook that is there
        other.page, other.errors = second, []
        second.locator(".pawnb-root").first.wait_for(timeout=90_000)
        other.wait("!!c && c.painted !== undefined && c.painted !== null")
        other.settle()
        arrives(widget, was, other)
        notebook.page.bring_to_front()
        drag(widget, was, was + 10)
        now = moves(widget, was)
        assert np.hypot(*(now - was)) > 3
        arrives(widget, now, other)
        # and the other way round
        kept = widget.file.read_bytes()
        second.bring_to_front()
        other.focus()
        other.press("Control+z")
        arrives(widget, was, other)
        arrives(widget, was)
        assert widget.file.read_bytes() != kept
    finally:
        second.close()
