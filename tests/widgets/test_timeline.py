"""The timeline without a browser: which stretch is chosen, and what is sent of the lanes."""

import base64
import json

import numpy as np
import pytest
import small_trial as scene
import traitlets

from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE
from pawnb.widgets import TrackReviewer, timeline


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


@pytest.fixture
def review(trial_file, tmp_path, monkeypatch):
    """Open a review; what it sends is kept."""
    sent = []
    send = TrackReviewer.send
    monkeypatch.setattr(TrackReviewer, "send", lambda w, m, **more: (sent.append(m), send(w, m))[1])
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    yield widget, sent
    widget.close()


def do(widget, action, point="FR", stretch=(10, 14), **more):
    message = {"type": "edit", "who": "a", "n": 1, "what": "stretch", "frame": 3}
    message |= {"action": action, "point": point, "stretch": stretch, **more}
    widget._receive(widget, message, [])


def lines(widget):
    return [json.loads(line) for line in widget.session.edits.read_text().splitlines()]


def test_a_stretch_can_be_set_and_is_checked(review):
    widget, _ = review
    widget.stretch = ["HR", 14, 10]
    assert widget.stretch == ["HR", 10, 14]
    for wrong in (["nose", 1, 2], ["HR", 1], ["HR", 10, 40]):
        with pytest.raises((InputError, traitlets.TraitError), match="stretch is"):
            widget.stretch = wrong
    assert widget.stretch == ["HR", 10, 14]
    widget.stretch = []
    seen = []
    widget.observe(lambda change: seen.append(change["new"]), "stretch")
    widget.stretch = ["FR", 1, 2]
    assert seen == [["FR", 1, 2]]


def test_left_and_right_are_offered_first(review):
    widget, _ = review
    assert [lane["id"] for lane in widget.lanes] == ["FR", "HR"]
    assert widget.lanes[0]["partners"] == ["HR"]


@pytest.mark.slow
def test_each_action_is_a_line_of_its_stretch(review):
    widget, _ = review
    for action, more, expected in (
        ("swap", {"other": "HR"}, {"edit": "swap", "first": "FR", "second": "HR", "view": None}),
        ("hide", {"view": "cam2"}, {"edit": "hide", "point": "FR", "view": "cam2"}),
        ("delete", {}, {"edit": "delete", "point": "FR", "view": None}),
        ("interpolate", {}, {"edit": "interpolate", "point": "FR", "view": None}),
    ):
        do(widget, action, **more)
        assert widget.alarm == ""
        assert lines(widget)[-1] == expected | {"frame": 10, "stop": 15}
    do(widget, "paint")
    assert widget.alarm == "paint is nothing that can be done to a stretch."


def test_only_the_frames_that_changed_are_sent(review):
    widget, sent = review
    widget._analysts.submit(int).result()  # the stances of before
    sent.clear()
    do(widget, "delete", stretch=(14, 10))
    # those of after may be there already, in a message of their own
    lanes = next(message for message in sent if message["type"] == "lanes")
    data = np.frombuffer(base64.b64decode(lanes["data"]), np.uint8).reshape(2, -1, 3)
    begin, stop = lanes["begin"], lanes["begin"] + data.shape[1]
    assert (lanes["first"], lanes["n"]) == (0, scene.N_FRAMES)
    assert begin <= 10 < 15 <= stop
    assert (data[0, 10 - begin : 15 - begin, 0] == 255).all()
    widget._analysts.submit(int).result()
    sent.clear()
    widget._receive(widget, {"type": "lanes"}, [])
    (whole,) = [message for message in sent if message["type"] == "lanes"]
    assert (whole["begin"], len(base64.b64decode(whole["data"]))) == (0, 2 * scene.N_FRAMES * 3)


def test_a_stretch_is_tracked_again_from_what_was_placed_in_it(trial_file, tmp_path):
    asked = []

    def tracker(_trial, tracks, frame):
        asked.append(frame)
        new = tracks.copy(deep=True)
        new["image_position"].values[:, 0, 0, 0] += 5.0
        return new

    edits = tmp_path / "edits.jsonl"
    widget = TrackReviewer(trial_file, scene.true_tracks(), retrack=tracker, edits=edits)
    u, v = scene.seen(12)[0, 0] + 3.0
    widget.edit("moved", {"frame": 12, "view": "cam1", "point": "FR", "u": u, "v": v})
    do(widget, "retrack")
    widget._worker.join(60)
    assert widget.alarm == ""
    assert asked == [12]
    assert lines(widget)[-1] == {"edit": "retrack", "frame": 12, "since": 10, "stop": 15}
    for frame, shift in ((9, 0), (10, 5), (14, 5), (15, 0)):
        assert widget.session.position(frame, "cam1", "FR")[0] == scene.seen(frame)[0, 0, 0] + shift
    widget.close()


def test_next_crossing_is_where_the_points_are_nearest_again(review):
    """FR passes over HR in cam1 where 50 + 8 f = 150: between frames 12 and 13, see place()."""
    widget, _ = review
    tracks = widget.session.present
    tracks["image_position"].values[:, 0, 1, 1, 0] = 268.0  # 2 px above FR's path
    assert widget.session.next_crossing(2, "FR", "HR") in (12, 13)
    assert widget.session.next_crossing(20, "FR", "HR") == scene.N_FRAMES
    # within the encounter it is not the next one
    assert widget.session.next_crossing(12, "HR", "FR") == scene.N_FRAMES
    # a gap does not hide it
    tracks["image_position"].values[8:18, :, :, 0, 0] = np.nan
    tracks["image_origin"].values[8:18, :, 0, 0] = ORIGIN_CODE["missing"]
    assert widget.session.next_crossing(2, "FR", "HR") in (12, 13)


@pytest.mark.parametrize(("most", "times"), [(scene.N_FRAMES - 1, 0), (scene.N_FRAMES, 1)])
def test_stances_of_long_recordings_are_not_looked_for(
    trial_file, tmp_path, monkeypatch, most, times
):
    asked = []
    monkeypatch.setattr(timeline, "_MOST_DRAWN_FRAMES", most)
    monkeypatch.setattr(timeline, "find_stances", lambda *_: asked.append(1) or {})
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    widget._analysts.shutdown(wait=True)
    assert len(asked) == times
    widget.close()
