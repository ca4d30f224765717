"""Every widget has a picture beside it, for nbconvert and for viewers without a kernel."""

import base64
import inspect

import cv2
import numpy as np
import pandas as pd
import pytest
import small_trial as scene

import pawnb
from pawnb import gait, widgets
from pawnb.core.video import open_views
from pawnb.widgets.plain import Plain

pytestmark = pytest.mark.filterwarnings(
    "ignore:Passing unrecognized arguments:DeprecationWarning"  # from ipympl
)
WIDGET = "application/vnd.jupyter.widget-view+json"


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


def picture_of(widget):
    """Return the picture of what a notebook is given to show, RGB, and close the widget."""
    bundle = widget._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    widget.close()
    assert WIDGET in data  # the widget itself is still there
    return cv2.imdecode(
        np.frombuffer(base64.b64decode(data["image/png"]), np.uint8), cv2.IMREAD_COLOR_RGB
    ).astype(int)


def test_every_public_widget_has_a_plain_picture():
    for name in widgets.__all__:
        kind = getattr(widgets, name)
        assert issubclass(kind, Plain), name
        assert inspect.getattr_static(kind, "plain_picture") is not Plain.plain_picture, name


def test_a_canvas_shows_its_frame_and_its_points(trial_file, tmp_path):
    trial = pawnb.load_trial(trial_file)
    views = open_views(trial)
    bare = picture_of(widgets.FrameCanvas(views, frame=21))
    views.close()
    tracks = scene.true_tracks()
    shown = picture_of(
        widgets.TrackReviewer(trial_file, tracks, frame=21, edits=tmp_path / "edits.jsonl")
    )
    # the first view is the left upper part; its bar code tells the frame
    part = (bare.shape[1] - 4) // 2
    scale = part / scene.WIDTH
    at = [int((bit + 0.5) * scene.SQUARE * scale) for bit in range(3, scene.BITS)]
    above = 1  # the name of the view covers the lower part, how much depends on the font
    assert [shown[above, u].mean() > 128 for u in at] == [False, True, False]  # 21 is 010101
    changed = np.abs(shown - bare).max(axis=2) > 30
    for point in range(2):
        u, v = (scene.seen(21)[0, point] + 0.5) * scale - 0.5
        around = changed[round(v) - 8 : round(v) + 9, round(u) - 8 : round(u) + 9]
        assert around.mean() > 0.2
    assert not changed[-40:-30, : part // 4].any()


@pytest.mark.slow
def test_clicks_and_plots_and_lists_have_pictures(trial_file, tmp_path):
    start = pd.DataFrame(
        [[0, "cam1", "FR", 110.0, 270.0]], columns=["frame", "view", "point", "u", "v"]
    )
    clicked = picture_of(widgets.ClickInitialiser(trial_file, start=start, path=tmp_path / "s.csv"))
    empty = picture_of(
        widgets.ClickInitialiser(trial_file, start=start.iloc[:0], path=tmp_path / "t.csv")
    )
    assert (clicked != empty).any()
    form = widgets.TrialForm([trial_file.parent / "cam1.avi"], folder=tmp_path)
    assert picture_of(form).shape[1] == 720
    bench = widgets.Workbench(trial_file.parent)
    name = "$x$ " + "<img src=x onerror=alert(1)>" * 20
    for state in bench.session.states:
        object.__setattr__(state, "name", name)
    assert picture_of(bench).shape[1] == 720
    t = np.arange(400) / 200.0
    signals = pd.DataFrame({"x": np.sin(2 * np.pi * 3 * t)})
    explorer = widgets.ResidualExplorer(signals, fs_hz=200.0)
    canvas = explorer._figure.canvas
    assert picture_of(explorer).std() > 5
    assert explorer._figure.canvas is canvas  # still the one that the browser shows
    assert picture_of(widgets.GaitExplorer(steps("m", "L1"))).std() > 5


def steps(name, leg):
    """Return the gait of two legs, six strides each, of an animal and trial of that name."""
    events = [
        {
            "animal": name,
            "trial": name,
            "leg": own,
            "event": event,
            "time_s": 0.2 * (lag + k + late),
        }
        for own, lag in ((leg, 0.5), ("R1", 0.0))
        for k in range(7)
        for event, late in (("AEP", 0.0), ("PEP", 0.6))
    ]
    return gait.analyse_events(pd.DataFrame(events))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["$\\bad{x$", "<img src=x>" * 40])
def test_names_in_plots_are_no_mathematics(name):
    assert picture_of(widgets.GaitExplorer(steps(name, name))).std() > 5
    t = np.arange(200) / 100.0
    signals = pd.DataFrame({name: np.sin(12 * t)})
    explorer = widgets.ResidualExplorer(signals, fs_hz=100.0, unit=name)
    assert picture_of(explorer).std() > 5


def test_a_frame_that_cannot_be_read_leaves_the_widget(trial_file, tmp_path):
    widget = widgets.TrackReviewer(
        trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl", frame=0
    )
    widget._own_views.close()
    bundle = widget._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert WIDGET in data
    assert "image/png" not in data
    widget.close()


def test_marks_that_cannot_be_drawn_leave_the_widget(trial_file):
    views = open_views(pawnb.load_trial(trial_file))
    marks = {"cam1": {"points": [{"id": "x", "u": 5.0, "v": 5.0, "colour": "rgb(1, 2, 3)"}]}}
    widget = widgets.FrameCanvas(views, overlay=lambda _frame: {"views": marks})
    bundle = widget._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert WIDGET in data
    assert "image/png" not in data
    widget.close()
    views.close()
