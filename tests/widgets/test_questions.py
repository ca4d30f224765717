"""Questions about doubtful labels: what is asked, what an answer does, and what is written."""

import base64
import json

import cv2
import numpy as np
import pandas as pd
import pytest
import small_trial as scene

from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.core.video import open_views
from pawnb.trial import load_trial
from pawnb.widgets import TrackReviewer
from pawnb.widgets.questions import Answer


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


@pytest.fixture
def opened(trial_file, tmp_path):
    """Open reviews of some tracks, and close them after the test."""
    widgets = []

    def open_it(tracks, **options):
        options = {"edits": tmp_path / "edits.jsonl", **options}
        widgets.append(TrackReviewer(trial_file, tracks, **options))
        return widgets[-1]

    yield open_it
    for widget in widgets:
        widget.close()


def press(widget, action):
    return widget.edit("action", {"action": action, "frame": 0})


def doubts(*rows):
    return pd.DataFrame(rows, columns=["frame", "view", "point", "reason", "score"])


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def meeting():
    """Return tracks of cam1 alone in which FR passes HR: x = 50 + 8 f reaches 150 in frame 12.5."""
    tracks = scene.true_tracks()
    uv = tracks["image_position"].to_numpy()
    uv[:, 0, 1, 1] = uv[:, 0, 1, 0]  # both as high
    uv[:, 1:] = np.nan
    return tracks


def test_each_question_has_its_answers_and_one_key_each(opened):
    table = doubts([7, "cam1", "HR", "it leaps", 1.0], [31, "cam2", "FR", "it is lost", 0.5])
    widget = opened(scene.true_tracks(), suspects=table)
    assert press(widget, "ask") == 7
    assert widget.status.startswith("Is this HR in cam1? (it leaps; frame 7, 1 more).")
    keys = {action["id"]: action["keys"] for action in widget.actions}
    assert keys == {
        "answer right": ["Enter"], "answer is FR": ["1"], "answer none": ["0"],
        "answer skipped": ["s"], "undo": ["Ctrl+z"], "ask end": ["q"],
    }  # fmt: skip
    shown = widget.overlay(7)
    assert shown["current"] == ["cam1", "HR"]
    u, v = scene.seen(7)[0, 1]
    assert shown["look"]["views"]["cam1"] == [u, v, 96.0]
    assert "cam3" not in shown["look"]["views"]  # it has no HR
    # the sheet shows both labels, that which is asked about first
    assert [(c["frame"], c["view"], c["point"], c["now"]) for c in widget.sheet] == [
        (7, "cam1", "HR", True), (31, "cam2", "FR", False),
    ]  # fmt: skip
    crop = widget.sheet[0]
    jpeg = np.frombuffer(base64.b64decode(crop["url"].partition(",")[2]), np.uint8)
    picture = cv2.imdecode(jpeg, cv2.IMREAD_COLOR_RGB)
    assert picture.shape == (128, 128, 3)
    # scene.frames paints paws: the middle of the ring has the colour of HR's paw
    with open_views(load_trial(widget._trial.folder)) as views:
        paw = views.frame(7)["cam1"].image()[round(v), round(u)]
    x, y = (round(128 * share - 0.5) for share in crop["at"])
    np.testing.assert_allclose(picture[y, x], paw, atol=25)
    # another of the sheet may be answered first; that before it stays on the list
    widget.edit("action", {"action": "ask about", "frame": 7, "value": "1"})
    assert [(c["frame"], c["now"]) for c in widget.sheet] == [(31, True), (7, False)]
    widget.edit("action", {"action": "ask about", "frame": 31, "value": "1"})
    assert "Expected errors left: " in widget.status
    assert press(widget, "answer right") == 31
    assert press(widget, "answer skipped") is None
    assert widget.overlay(31)["look"]["views"] == {}
    assert widget.status.startswith("No doubtful label is left to ask about: 2 answers in 0.0 min")
    assert "retrack" in [action["id"] for action in widget.actions]
    assert widget.sheet == []


@pytest.mark.slow
def test_answers_are_corrections_and_are_written_with_their_time(opened, tmp_path, monkeypatch):
    clock = iter([100.0, 103.5, 103.5, 200.0, 200.0])
    monkeypatch.setattr("pawnb.widgets.questions.monotonic", lambda: next(clock))
    table = doubts([7, "cam1", "HR", "a", 1.0], [31, "cam2", "FR", "b", 0.5])
    widget = opened(scene.true_tracks(), suspects=table)
    press(widget, "ask")
    press(widget, "answer right")
    press(widget, "answer none")
    edits = lines(tmp_path / "edits.jsonl")
    assert [edit["edit"] for edit in edits] == ["accept", "delete"]
    assert (edits[1]["frame"], edits[1]["stop"], edits[1]["view"]) == (31, 32, "cam2")
    assert widget.session.position(31, "cam2", "FR") is None
    written = lines(tmp_path / "answers.jsonl")
    assert written == [
        {"edit": "answer", "frame": 7, "view": "cam1", "point": "HR", "answer": "right",
         "seconds": 3.5},
        {"edit": "answer", "frame": 31, "view": "cam2", "point": "FR", "answer": "none",
         "seconds": 60.0},  # a pause
    ]  # fmt: skip
    assert widget.effort() == {
        "answers": 2, "answer_minutes": pytest.approx(63.5 / 60), "minutes": 0.0, "corrections": 2,
    }  # fmt: skip
    again = opened(scene.true_tracks(), suspects=table)
    press(again, "ask")
    assert [type(answer) for answer in again.answers] == [Answer, Answer]


def test_another_paw_is_an_exchange_up_to_the_encounters_and_settles_that_stretch(opened):
    right = meeting()
    wrong = right.copy(deep=True)
    uv = wrong["image_position"].to_numpy()
    uv[13:, 0] = uv[13:, 0][:, :, ::-1].copy()
    table = doubts([20, "cam1", "FR", "a", 1.0], [25, "cam1", "HR", "b", 0.9],
                   [3, "cam1", "HR", "c", 0.5])  # fmt: skip
    widget = opened(wrong, suspects=table)
    assert press(widget, "ask") == 20
    assert press(widget, "answer is HR") == 3  # 25 lies in the same stretch
    (edit,) = widget.session.corrections
    # where they are nearest either frame may be taken: they lie as far apart in both
    assert edit.frame in (12, 13)
    assert edit.stop == 40
    now = widget.tracks["image_position"].to_numpy()[13:, 0, :, :, 0]
    np.testing.assert_array_equal(now, right["image_position"].to_numpy()[13:, 0, :, :, 0])


def test_where_both_paws_are_in_one_place_nothing_is_exchanged(opened):
    tracks = meeting()  # FR and HR pass each other in frames 12 and 13
    widget = opened(tracks, suspects=doubts([12, "cam1", "HR", "a", 1.0]))
    press(widget, "ask")
    press(widget, "answer is FR")
    (edit,) = widget.session.corrections
    assert (type(edit).__name__, edit.frame, edit.stop, edit.view) == ("Delete", 12, 13, "cam1")


def test_expected_errors_left_are_those_nobody_has_looked_at(opened):
    tracks = scene.true_tracks()
    tracks["image_confidence"].attrs["is_probability"] = 1
    widget = opened(tracks)
    wrong = 1.0 - label_chances(tracks)[:, 0, 1]  # of HR in cam1
    everywhere = widget.expected_errors_left
    assert everywhere > wrong.sum() > 0
    widget.session.accept(20, "cam1", "HR")  # shows frames 17 to 23
    left = everywhere - wrong[17:24].sum()
    assert widget.expected_errors_left == pytest.approx(left)
    u, v = scene.seen(30)[0, 1]
    widget.session.move(30, "cam1", "HR", u=u, v=v)  # it was wrong: those beside it may be, too
    assert widget.expected_errors_left == pytest.approx(left - wrong[30])
    doubtful = widget._find_doubtful()
    own = doubtful[(doubtful["view"] == "cam1") & (doubtful["point"] == "HR")]
    assert not own["frame"].isin([*range(17, 24), 30]).any()
    widget.session.undo()
    widget.session.undo()
    assert widget.expected_errors_left == pytest.approx(everywhere)


def test_the_stretch_between_encounters(opened):
    session = opened(meeting()).session
    begin, met = session.stretch_between_crossings(5, "FR", "HR")
    assert begin == 0
    assert met in (12, 13)
    assert session.stretch_between_crossings(20, "FR", "HR") == (met, 40)
    assert session.stretch_between_crossings(met, "FR", "HR") == (met, 40)


def test_undo_asks_again_what_was_taken_back(opened):
    table = doubts([7, "cam1", "HR", "a", 1.0], [31, "cam2", "FR", "b", 0.5])
    widget = opened(scene.true_tracks(), suspects=table)
    press(widget, "ask")
    press(widget, "answer right")
    assert press(widget, "undo") == 31  # the question that stands is still asked
    assert widget.status.startswith("Is this FR in cam2?")
    assert widget.session.corrections == ()
    assert (7, "cam1", "HR", "a") not in widget._looked
    assert press(widget, "ask end") is None
    assert np.isfinite(widget.session.position(7, "cam1", "HR")).all()
