"""TrackReviewer without a browser: what it offers to look at."""

import dataclasses
import os
import warnings

import numpy as np
import pandas as pd
import pytest
import small_trial as scene

from pawnb import load_trial
from pawnb.core.edits.log import Swap, apply_edit
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.io import read_tracks
from pawnb.io.native import write_tracks
from pawnb.widgets import TrackReviewer
from pawnb.workflow.provenance.report.tracking_text import tracking_sentences
from pawnb.workflow.provenance.results import describe_trial, write_track_results
from pawnb.workflow.reviewing.quality import assess_quality


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


def offered(widget):
    """Return the frames in the menu of doubtful frames."""
    menus = [action for action in widget.actions if action["id"] == "suspect"]
    # "frame 20: HR in cam1, ..."
    return [int(text.split()[1][:-1]) for _, text in menus[0]["options"]] if menus else []


def mend(_trial, tracks, _frame):
    return tracks.copy(data=scene.true_tracks())


@pytest.fixture
def review(trial_file):
    """Open a review of tracks that are 30 px off in one frame, with a tracker that mends it."""
    tracks = scene.true_tracks()
    tracks["image_position"][20, 0, 1, 0, 0] += 30.0
    opened = []

    def open_it(**options):
        opened.append(TrackReviewer(trial_file, tracks, retrack=mend, **options))
        return opened[-1]

    yield open_it
    for widget in opened:
        widget.close()


def test_doubtful_frames_are_found_by_themselves_and_again_after_tracking_again(review):
    widget = review()
    assert offered(widget)[0] == 20
    widget.retrack(19)
    widget._worker.join(60)
    assert widget.alarm == ""
    assert offered(widget) == []
    # the verdict from before is that of other tracks
    verdict = assess_quality(widget.tracks).line()
    assert widget.status.startswith(f"Tracked again from frame 19 on; now {verdict}")


def test_a_frame_rate_that_was_mended_since_tracking_is_used(trial_file, tmp_path, monkeypatch):
    trial = load_trial(trial_file)
    tracks = describe_trial(scene.true_tracks(), trial)
    slower = dataclasses.replace(trial, fps=trial.fps / 10.0)
    said = []
    # threads of other widgets exchange the filters of warnings, so that pytest.warns may miss one
    monkeypatch.setattr(warnings, "warn", lambda text, *_a, **_k: said.append(text))
    widget = TrackReviewer(slower, tracks, edits=tmp_path / "edits.jsonl", retrack=mend)
    try:
        assert any("fps was changed" in text for text in said)
        assert widget.tracks.attrs["fps"] == trial.fps / 10.0
        np.testing.assert_allclose(widget.tracks["time"], tracks["time"] * 10.0)
    finally:
        widget.close()


def test_colours_are_learnt_anew_where_a_person_asks(trial_file, tmp_path):
    asked = []

    def tracker(_trial, tracks, frame, **options):
        asked.append((frame, options))
        return tracks

    edits = tmp_path / "edits.jsonl"
    widget = TrackReviewer(trial_file, scene.true_tracks(), retrack=tracker, edits=edits)
    for action in ("learn", "retrack"):
        assert action in [offer["id"] for offer in widget.actions]
        widget.edit("action", {"action": action, "frame": 12})
        widget._worker.join(60)
        assert widget.alarm == ""
    assert asked == [(12, {"learn": True}), (12, {})]
    assert [edit.learn for edit in widget.session.corrections] == [True, False]
    widget.close()


def test_keys_are_heard_again_before_it_is_said_that_tracking_again_is_done(review):
    # a browser that reads the words and presses the key at once was not heard (a race)
    widget = review()
    heard = []

    def note(change):
        on = {offer["id"]: offer["enabled"] for offer in widget.actions}
        heard.append((change["new"].split(" from ")[0], on["learn"]))

    widget.observe(note, "status")
    widget.retrack(19)
    widget._worker.join(60)
    assert heard == [("Tracking again", False), ("Tracked again", True)]


def test_frames_to_look_at_can_be_given(review):
    table = pd.DataFrame(
        [[7, "cam1", "HR", "to try", 1.0]], columns=["frame", "view", "point", "reason", "score"]
    )
    assert offered(review(suspects=table)) == [7]
    assert offered(review(suspects=table.iloc[:0])) == []


def test_a_doubtful_frame_is_shown_with_its_point_chosen_and_its_reason(review):
    rows = [[7, "cam1", "HR", "it leaps", 1.0], [31, "cam2", "FR", "it is lost", 0.5]]
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "reason", "score"])
    widget = review(suspects=table)

    def press(action, value=None):
        return widget.edit("action", {"action": action, "value": value, "frame": 0})

    assert press("suspect", "1") == 31
    assert widget.status.startswith("Doubtful 2 of 2, frame 31: FR in cam2, it is lost.")
    assert widget.overlay(31)["current"] == ["cam2", "FR"]
    assert "current" not in widget.overlay(30)
    assert press("next") == 7  # not looked at yet, though higher up
    assert press("next") is None
    assert widget.status.startswith("That was the last of the doubtful frames.")
    # what is chosen by hand stays chosen
    press("suspect", "1")
    widget.edit("moved", {"frame": 31, "view": "cam1", "point": "HR", "u": 9.0, "v": 9.0})
    assert "current" not in widget.overlay(31)
    fresh = review(suspects=table)
    assert [fresh.edit("action", {"action": "next", "frame": 0}) for _ in rows] == [7, 31]


def test_an_exchange_takes_what_it_has_mended_from_the_doubtful_frames(trial_file, tmp_path):
    swap = Swap(frame=20, first="FR", second="HR")
    swapped = apply_edit(scene.true_tracks(), swap, rig=load_rig(load_trial(trial_file)))
    widget = TrackReviewer(trial_file, swapped, edits=tmp_path / "edits.jsonl")
    was = offered(widget)
    assert was[0] in (19, 20)
    swap = next(action for action in widget.actions if action["id"] == "swap")
    value = next(value for value, text in swap["options"] if text == "FR and HR")
    press(widget, "swap", value, frame=20)
    assert offered(widget) == []
    press(widget, "undo")
    assert offered(widget) == was
    press(widget, "redo")
    assert offered(widget) == []
    widget.close()


def test_what_a_person_has_settled_is_doubtful_no_more(review):
    rows = [[7, "cam1", "HR", "a", 1.0], [7, "cam1", "FR", "b", 1.0], [31, "cam2", "FR", "c", 0.5],
            [9, "cam2", "FR", "d", 0.5]]  # fmt: skip
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "reason", "score"])
    widget = review(suspects=table)
    assert press(widget, "next") == 7
    widget.edit("moved", {"frame": 7, "view": "cam2", "point": "HR", "u": 9.0, "v": 9.0})
    assert offered(widget) == [7, 31, 9]
    assert press(widget, "next") == 7  # the other paw of that frame
    press(widget, "accept", frame=7, selected=["cam1", "FR"])
    assert offered(widget) == [31, 9]
    assert press(widget, "next") == 31
    widget.edit("hide", {"frame": 31, "view": "cam2", "point": "FR"})
    assert offered(widget) == [9]
    assert press(widget, "next") == 9
    assert press(widget, "next") is None


def press(widget, action, value=None, *, frame=0, **more):
    return widget.edit("action", {"action": action, "value": value, "frame": frame, **more})


def put(widget, frame, **more):
    where = {"frame": frame, "view": "cam1", "point": "HR", "u": 9.0, "v": 9.0}
    message = {"type": "edit", "who": "a", "n": 1, "what": "moved", **where, **more}
    widget._receive(widget, message, [])


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows renames no folder whose films are open")
def test_what_is_corrected_and_saved_stays_with_its_trial(tmp_path, monkeypatch):
    """The notebook goes to another folder; then the trial's folder is renamed."""
    scene.write_trial(tmp_path / "m07")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    widget = TrackReviewer("m07", scene.true_tracks())
    monkeypatch.chdir(tmp_path / "elsewhere")
    put(widget, 3)
    put(widget, 3, what="action", action="save")
    assert widget.alarm == ""
    kept = {path.name for path in (tmp_path / "m07" / "results").iterdir()}
    assert {"edits.jsonl", "tracks.nc"} <= kept
    assert list((tmp_path / "elsewhere").iterdir()) == []
    (tmp_path / "m07").rename(tmp_path / "m08")
    put(widget, 4)
    assert "moved, renamed or deleted since edits.jsonl was opened" in widget.alarm
    put(widget, 4, what="action", action="save")
    assert not (tmp_path / "m07").exists()
    widget.close()


@pytest.mark.slow
def test_a_second_window_saves_no_tracks_that_lack_what_the_first_corrected(trial_file, tmp_path):
    options = {"edits": tmp_path / "edits.jsonl"}
    first, second = (TrackReviewer(trial_file, scene.true_tracks(), **options) for _ in range(2))
    put(first, 3)
    put(first, 3, what="action", action="save")
    assert first.alarm == ""
    kept = (tmp_path / "tracks.nc").read_bytes()
    put(second, 7)
    assert "changed by another window or program" in second.alarm
    put(second, 7, what="action", action="save")
    assert "another window or program has made corrections since" in second.alarm
    assert (tmp_path / "tracks.nc").read_bytes() == kept
    put(first, 4)
    put(first, 4, what="action", action="save")
    assert first.alarm == ""
    first.close()
    second.close()


@pytest.mark.slow
def test_the_minutes_of_a_review_are_counted_shown_and_saved(trial_file, tmp_path):
    clock = [0.0]
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    widget.working_time._clock = lambda: clock[0]
    # looks around for 30 s and corrects; makes a pause of 10 minutes; saves 15 s after the next
    for now, act in ((0, None), (30, "moved"), (630, None), (645, "save")):
        clock[0] = now
        if act is None:
            widget._receive(widget, {"type": "active"}, [])
        else:
            put(widget, 3, what="action" if act == "save" else act, action=act)
    assert widget.status.endswith("1 correction in edits.jsonl, 0.8 min of work.")
    assert widget.effort() == {
        "minutes": 0.75, "corrections": 1, "answers": 0, "answer_minutes": 0.0,
    }  # fmt: skip
    saved = read_tracks(tmp_path / "tracks.nc")
    assert "1 correction in 0.8 min of work (gaps" in tracking_sentences([saved])
    widget.close()
    again = TrackReviewer(trial_file, saved, edits=tmp_path / "edits.jsonl")
    assert again.effort()["minutes"] == 0.75
    again.close()


@pytest.mark.slow
def test_what_saved_tracks_contain_is_undone_in_another_session(trial_file, tmp_path):
    options = {"edits": tmp_path / "edits.jsonl"}
    first = TrackReviewer(trial_file, scene.true_tracks(), **options)
    was = first.session.position(3, "cam1", "HR")
    put(first, 3)
    first.session.swap(20, "FR", "HR", stop=25)
    put(first, 3, what="action", action="save")
    assert first.alarm == ""
    first.close()
    again = TrackReviewer(trial_file, read_tracks(tmp_path / "tracks.nc"), **options)
    for _ in range(2):
        put(again, 3, what="action", action="undo")
    assert again.alarm == ""
    assert again.session.position(3, "cam1", "HR") == pytest.approx(was, abs=1e-3)
    assert "0 corrections" in again.status
    assert not again.session.can_undo
    put(again, 3, what="action", action="redo")
    assert again.session.position(3, "cam1", "HR") == (9.0, 9.0)
    again.close()
    # the saved tracks went along: nothing of it stands in the way of a third session
    third = TrackReviewer(trial_file, read_tracks(tmp_path / "tracks.nc"), **options)
    assert third.session.position(3, "cam1", "HR") == (9.0, 9.0)
    # tracks that do not come of those from before are left as they are, and that is said
    put(third, 3, what="action", action="save")
    third.close()
    other = scene.true_tracks()
    other["image_position"][30] += 5.0
    write_tracks(other, tmp_path / "tracks.before.nc")
    last = TrackReviewer(trial_file, read_tracks(tmp_path / "tracks.nc"), **options)
    put(last, 3, what="action", action="undo")
    assert "do not lead to these" in last.alarm
    assert last.session.position(3, "cam1", "HR") == (9.0, 9.0)
    assert "1 correction" in last.status
    last.close()


@pytest.mark.slow
def test_an_exchange_that_was_saved_is_said_where_the_trial_was_tracked_anew(trial_file, tmp_path):
    options = {"edits": tmp_path / "edits.jsonl"}
    first = TrackReviewer(trial_file, scene.true_tracks(), **options)
    first.session.swap(20, "FR", "HR", stop=25)
    put(first, 3, what="action", action="save")
    first.close()
    again = TrackReviewer(trial_file, read_tracks(tmp_path / "tracks.nc"), **options)
    assert "tracked anew" not in again.status
    again.close()
    anew = scene.true_tracks()
    anew["image_position"][30] += 5.0
    write_track_results(anew, tmp_path)
    last = TrackReviewer(trial_file, read_tracks(tmp_path / "tracks.nc"), **options)
    assert "still needed: FR and HR exchanged in frames 20 to 24" in last.status
    last.close()


def test_tracks_that_were_made_meanwhile_are_not_written_over(trial_file, tmp_path):
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    put(widget, 3)
    write_track_results(scene.true_tracks(), tmp_path)  # somebody tracks the trial again
    kept = (tmp_path / "tracks.nc").read_bytes()
    put(widget, 3, what="action", action="save")
    assert "tracks.nc: changed by another window or program" in widget.alarm
    assert "every correction is in its file" in widget.alarm
    assert (tmp_path / "tracks.nc").read_bytes() == kept
    widget.close()


@pytest.mark.slow
def test_results_that_were_changed_or_cut_off_are_told_when_a_review_opens(trial_file, tmp_path):
    write_track_results(scene.true_tracks(), tmp_path)

    def said():
        widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
        widget.close()
        return widget.status

    assert "pawnb track" not in said()
    (tmp_path / "suspects.csv").write_text("")
    assert "not as pawnb track left it (changed: suspects.csv)" in said()
    # what a review saves is as whole as what a tracker writes
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    widget.edit("action", {"action": "save", "frame": 0})
    widget.close()
    assert "pawnb track" not in said()


def test_tracks_are_a_trait_that_is_observed_set_and_checked(trial_file, tmp_path):
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    heard = []
    widget.observe(lambda change: heard.append(change["new"]), "tracks")
    put(widget, 3)

    def u_of(tracks):
        rows = tracks["frame"].to_numpy() == 3
        return float(tracks["image_position"].to_numpy()[rows, 0, 0, 1, 0][0])

    assert [u_of(tracks) for tracks in heard] == [9.0]
    assert u_of(widget.tracks) == 9.0
    put(widget, 3, what="action", action="undo")
    assert len(heard) == 2
    put(widget, 3, what="select")
    assert len(heard) == 2  # nothing has changed
    # other tracks of the trial; what is corrected in the file is corrected in them, too
    put(widget, 3)
    other = scene.true_tracks()
    other["image_position"][:, 1] += 2.0
    widget.tracks = other
    assert u_of(widget.tracks) == 9.0
    shown = widget.overlay(5)["views"]["cam2"]["points"][0]
    assert shown["u"] == pytest.approx(scene.seen(5)[1, 0, 0] + 2.0)
    assert widget.status.startswith("Other tracks are shown.")
    assert len(heard) == 4
    put(widget, 4)
    assert u_of(heard[-1]) == 9.0
    # what does not fit is refused, and what was there stays
    with pytest.raises(InputError, match=r"^these tracks have other keypoints \(FR\) than those"):
        widget.tracks = other.isel(keypoint=[0])
    with pytest.raises(InputError):
        widget.tracks = None
    assert widget.overlay(5)["views"]["cam2"]["points"][0] == shown
    widget.close()
