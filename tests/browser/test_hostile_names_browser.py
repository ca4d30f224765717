"""Names from files and fields that are script, endless, empty or right to left, in a real browser.

Nothing of them runs, and nothing overflows. TrackReviewer is tried so in
``test_timeline_browser.py``, the list of the workbench in ``test_workbench_browser.py``, the page
without Python in ``test_page_browser.py``.
"""

import json

import ball_scene
import numpy as np
import pytest
import small_pose_trial as pose_scene
import small_trial as scene
from test_small_screen_browser import set_theme

from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.poses import join_poses
from pawnb.core.pose.track_result import plain_track
from pawnb.io.native import write_tracks
from pawnb.schema import add_provenance

pytestmark = pytest.mark.browser

EVIL, LONG, HEBREW = "<img src=x onerror=window.hurt=1>", "a" * 300, "\u05e9\u05dc\u05d5\u05dd" * 30
NAMES = [EVIL, LONG, HEBREW, "$x^2$", ""]

OVER = """() => {
    const area = [...document.querySelectorAll('.jp-OutputArea-output')].pop();
    const right = area.getBoundingClientRect().right + 2;
    return [...area.querySelectorAll('button, select, input, canvas, .widget-label, div, span')]
        .filter((e) => e.offsetParent && e.getBoundingClientRect().right > right)
        .map((e) => `${e.className}: ${(e.textContent || '').slice(0, 30)}`); }"""


@pytest.fixture(params=[(1366, "Light"), (1920, "Dark")], ids=["small-light", "large-dark"])
def screen(notebook, request):
    """The notebook on a small light screen and on a large dark one."""
    width, theme = request.param
    notebook.page.set_viewport_size({"width": width, "height": 768 if width == 1366 else 1200})
    set_theme(notebook, theme)
    notebook.page.evaluate("window.hurt = undefined")
    yield notebook
    set_theme(notebook, "Light")
    notebook.page.set_viewport_size({"width": 1500, "height": 1000})


def harmless(notebook):
    """Nothing ran, and nothing stands beyond the right edge of the cell."""
    notebook.wait_idle()
    notebook.page.wait_for_timeout(700)
    assert notebook.page.evaluate("window.hurt") is None
    assert notebook.page.locator(".jp-OutputArea-output img[src=x]").count() == 0
    assert notebook.page.evaluate(OVER) == []
    notebook.assert_no_errors()


def type_everywhere(notebook, text):
    """Type a text into every field that there is; return how many."""
    fields = notebook.page.locator(".jp-OutputArea-output input[type=text]:visible")
    for k in range(fields.count()):
        fields.nth(k).fill(text)
        fields.nth(k).press("Tab")
    return fields.count()


def renamed(trial_file, points):
    """The small trial with hostile names of views and points."""
    text = trial_file.read_text()
    for was, name in zip(scene.POINTS, (EVIL, LONG, HEBREW), strict=True):
        text = text.replace(f'name = "{was}"', f"name = {json.dumps(name)}")
    for was, name in zip(("FR", "HR"), points, strict=True):
        text = text.replace(f'"{was}"', json.dumps(name))
    text = text.replace('name = "small"', f"name = {json.dumps(EVIL)}")
    trial_file.write_text(text)
    return trial_file


@pytest.mark.parametrize("text", [EVIL, LONG, HEBREW], ids=["script", "long", "hebrew"])
def test_every_field_of_the_form_of_a_trial(screen, bare_videos, text):
    screen.show(f"""from pawnb.widgets.trial_form import TrialForm
w = TrialForm({bare_videos!r}, done=print)
w""")
    screen.page.get_by_label("animal", exact=True).select_option(
        label="other: points that you name"
    )
    screen.page.get_by_placeholder("names with commas between").wait_for()
    assert type_everywhere(screen, text) >= 8
    screen.page.get_by_role("button", name="Make the trial").click()
    harmless(screen)
    before = screen.page.locator(".jp-OutputArea-output .pawnb-wrap").all_inner_texts()
    assert any(words.strip() for words in before)  # what is wrong is said


@pytest.mark.parametrize("text", [EVIL, LONG, HEBREW], ids=["script", "long", "hebrew"])
def test_every_field_of_the_form_of_a_calibration(screen, trial_file, text):
    renamed(trial_file, [EVIL, LONG])
    screen.run(f"""import pawnb
from pawnb.widgets.calibration_form import CalibrationForm
w = CalibrationForm(pawnb.load_trial({str(trial_file)!r}), done=print)
w""")
    begin = screen.page.get_by_role("button", name="Show the pictures")
    begin.wait_for(timeout=60_000)
    ways = screen.page.get_by_label("by", exact=True)
    for k in range(ways.locator("option").count()):
        ways.select_option(index=k)
        screen.page.wait_for_timeout(700)  # the fields of this way come, and others go
        screen.wait_idle()
        assert type_everywhere(screen, text) >= 1
        begin.click()
        harmless(screen)
    screen.page.get_by_role("button", name="Use this calibration").click()
    harmless(screen)


def test_names_of_balls_and_views_in_the_digitiser(screen, tmp_path):
    home = tmp_path / "home"
    ball_scene.write(home / "in")
    text = (home / "in" / "points.csv").read_text()
    for was, name in zip(ball_scene.PLACES, (EVIL, LONG, HEBREW, "$x^2$"), strict=False):
        text = text.replace(was, name)
    (home / "in" / "points.csv").write_text(text)
    screen.show(f"""from pathlib import Path
from pawnb.widgets import CalibrationDigitiser
home = Path({str(home)!r})
w = CalibrationDigitiser({{{EVIL!r}: home / "in" / "left", {LONG!r}: home / "in" / "right"}},
                         points=home / "in" / "points.csv", folder=home)
w""")
    screen.focus()
    for u, v in ball_scene.seen("left", list(ball_scene.PLACES.values()))[:5]:
        box = screen.page.locator(".pawnb-view").first.locator(".pawnb-marks")
        x, y = screen.js(f"c.stages[0].toCanvas({u}, {v})")
        box.click(position={"x": float(x), "y": float(y)})
        screen.settle()
    assert len(screen.py("list(w.session.clicks.values())")) == 5
    harmless(screen)


def test_names_of_points_and_views_where_the_start_is_clicked(screen, trial_file):
    renamed(trial_file, [EVIL, LONG])
    screen.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial_file)!r})
w""")
    screen.focus()
    for k in (0, 1):
        x, y = screen.js(f"c.stages[{k}].toCanvas(200, 100)")
        view = screen.page.locator(".pawnb-view").nth(k).locator(".pawnb-marks")
        view.click(position={"x": float(x), "y": float(y)})
        screen.settle()
    screen.press("?")
    harmless(screen)


def test_names_of_legs_animals_and_reasons_in_the_explorer_of_strides(screen, tmp_path):
    screen.run(f"""from pawnb import gait
from pawnb.synthetic.spider_study import simulate_spider_study
from pawnb.widgets import GaitExplorer
run = simulate_spider_study(animals=1, trials=1, seed=3).runs[0]
events = gait.analyse(run.tracks(noise_px=0.2), trial=run.trial).events
events = events.replace(dict(zip(["R2", "R3", "L1", "L2"], {NAMES[:4]!r})))
found = gait.analyse_events(events.assign(trial={EVIL!r}, animal={LONG!r}))
w = GaitExplorer(found, {str(tmp_path / "edits.jsonl")!r})
w""")
    screen.page.locator(".jupyter-matplotlib canvas").last.wait_for(timeout=60_000)
    screen.wait_idle()
    harmless(screen)
    # a stride of the leg that is script is picked and excluded for a reason that is script
    start = screen.py(
        f"float(w.tables.strides[w.tables.strides['leg'] == {EVIL!r}].iloc[1]['start_s'])"
    )
    screen.kernel_runs(f"w.session.pick({EVIL!r}, {start!r} + 0.02)\nw._panels.mark()")
    screen.kernel_runs("w._tell(w.session.text())")
    for text in (EVIL, LONG, HEBREW):
        screen.page.get_by_placeholder("reason").last.fill(text)
    screen.page.locator("button.jupyter-button", has_text="exclude stride").last.click()
    screen.until("'1 correction' in w._told.value", True, seconds=30)
    assert screen.py("len(w._panels.rows)") == 8
    harmless(screen)
    # no name runs out of the picture, or into another plot
    outside = screen.py("""[t.get_text() for ax in w._figure.axes for t in
        [ax.title, ax.xaxis.label, ax.yaxis.label, *ax.get_yticklabels()] if t.get_text()
        and t.get_window_extent().x1 > w._figure.bbox.x1 + 2]""")
    assert outside == []


def test_names_of_signals_in_the_explorer_of_residuals(screen):
    screen.run(f"""import numpy as np
import pandas as pd
from pawnb.widgets import ResidualExplorer
t = np.arange(200) / 250.0
table = pd.DataFrame({{name: np.sin(2 * np.pi * 4 * t + k) for k, name in enumerate({NAMES!r})}})
w = ResidualExplorer(table, fs_hz=250.0, unit={EVIL!r})
w""")
    screen.page.locator(".jupyter-matplotlib canvas").last.wait_for(timeout=60_000)
    menu = screen.page.locator(".jp-OutputArea-output select").last
    for k in range(menu.locator("option").count()):
        menu.select_option(index=k)
        harmless(screen)


HOSTILE = pytest.mark.parametrize(
    "name", [EVIL, LONG, HEBREW, "a\"b'c"], ids=["script", "long", "hebrew", "quotes"]
)


def posed(folder, name):
    """The small trial of a jointed animal, its view, animal and name hostile."""
    file = pose_scene.write_pose_trial(folder)
    text = file.read_text()
    for was in ("top", "s1", "small"):
        for key in ("name", "id"):
            text = text.replace(f'{key} = "{was}"', f"{key} = {json.dumps(name)}")
    file.write_text(text)
    return file


@HOSTILE
def test_names_of_view_and_animal_where_a_pose_is_dragged(screen, tmp_path, name):
    file = posed(tmp_path / "trial", name)
    screen.show(f"""from pawnb.widgets import StickPoser
w = StickPoser({str(file)!r}, frame={pose_scene.EMPTY}, path={str(tmp_path / "pose.csv")!r})
w""")
    found = screen.js("c.stages[0].stick.handles().find((h) => h.id === 'R2')")
    marks = screen.page.locator(".pawnb-view .pawnb-marks").first
    marks.scroll_into_view_if_needed()
    x, y = screen.js(f"c.stages[0].toCanvas({found['u']}, {found['v']})")
    box, mouse = marks.bounding_box(), screen.page.mouse
    mouse.move(box["x"] + x, box["y"] + y)
    mouse.down()
    mouse.move(box["x"] + x - 6, box["y"] + y - 4, steps=3)
    mouse.up()
    screen.settle()
    screen.kernel_runs(f"w.alarm = {name + LONG!r}")
    screen.focus()
    screen.press("?")
    harmless(screen)
    assert screen.py("len(w.session._past)") == 1


@HOSTILE
def test_names_of_view_and_animal_where_poses_are_reviewed(screen, tmp_path, name):
    file = posed(tmp_path / "trial", name)
    poses = join_poses([pose_scene.truth()] * 4)
    poses.frames[:] = np.arange(pose_scene.EMPTY, pose_scene.N_FRAMES)
    tracks = tracks_from_poses(
        pose_scene.SPECIES, plain_track(pose_scene.SPECIES, poses), fps=125.0, view=name,
        individual=name, px_per_unit=pose_scene.SCALE, unit="mm",
    )  # fmt: skip
    start = [{"frame": pose_scene.EMPTY}]
    tracks = add_provenance(tracks, step="track", method="pawnb", settings={}, start=start)
    kept = write_tracks(tracks, tmp_path / "tracks.nc")
    screen.show(f"""from pawnb.io.native import read_tracks
from pawnb.widgets import PoseReviewer
w = PoseReviewer({str(file)!r}, read_tracks({str(kept)!r}),
                 edits={str(tmp_path / "e.jsonl")!r})
w""")
    screen.kernel_runs(f"w.alarm = {name + LONG!r}")
    screen.focus()
    screen.press("ArrowRight")
    screen.settle()
    screen.press("?")
    harmless(screen)
