"""PoseReviewer without a browser: every pose is shown, corrected, tracked again and kept."""

import json
import threading

import numpy as np
import pandas as pd
import pytest

from pawnb.core.pose.as_tracks import poses_of
from pawnb.core.pose.corrected import posed_frames
from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.widgets.pose_reviewer import PoseReviewer
from pawnb.widgets.track_reviewer import TrackReviewer
from pawnb.workflow.tracking.track import track


@pytest.fixture(scope="module")
def tracks(rendered_spider):
    return track(
        rendered_spider, settings={"choose_path": False}, progress=lambda _done, _total: None
    )


@pytest.fixture
def reviewer(rendered_spider, tracks, tmp_path):
    """Open the review of 14 frames, 10 to 23; what is tracked again comes from a stand-in."""

    def again(_trial, some, frame):
        new = some.copy(deep=True)
        new["heading"].to_numpy()[new["frame"].to_numpy() == frame + 1] += 1.0
        return new

    widget = PoseReviewer(
        rendered_spider, tracks, edits=tmp_path / "edits.jsonl", retrack=again, frame=15
    )
    yield widget
    widget.close()


def drag(widget, frame, leg="L2", by=(9.0, -6.0)):
    """Drag a tip, and return where it was and where it should be."""
    was = widget.session.pose_at(frame).places(leg)[-1]
    u, v = was + by
    widget.edit("moved", {"frame": frame, "point": leg, "u": u, "v": v, "whole": True})
    return was, np.array([u, v])


def tip(widget, frame, leg="L2"):
    at = widget.tracks["image_position"].sel(keypoint=leg, view="top", individual="spider-01")
    return at.to_numpy()[frame - 10]


def test_each_frame_shows_its_own_pose(reviewer, tracks):
    for frame in (10, 23):
        stick = reviewer.overlay(frame)["views"]["top"]["stick"]
        np.testing.assert_allclose(stick["xy"], poses_of(tracks).poses.xy[frame - 10])
        assert not stick["dashed"]


@pytest.mark.slow
def test_a_drag_corrects_the_frame_looked_at_and_undo_takes_it_back(reviewer, tracks):
    was, to = drag(reviewer, 17)
    np.testing.assert_allclose(tip(reviewer, 17), to, atol=1.0)
    np.testing.assert_array_equal(posed_frames(reviewer.tracks), [17])
    assert "1 correction in edits.jsonl" in reviewer.status
    line = json.loads(reviewer.session.path.read_text())
    assert (line["edit"], line["frame"]) == ("pose", 17)
    reviewer.edit("action", {"frame": 12, "action": "undo"})
    np.testing.assert_allclose(tip(reviewer, 17), was, atol=1e-6)
    assert reviewer.session.frame == 17
    reviewer.edit("action", {"frame": 17, "action": "redo"})
    np.testing.assert_allclose(tip(reviewer, 17), to, atol=1.0)


def test_nothing_of_a_review_writes_over_its_corrections(reviewer):
    drag(reviewer, 17)
    path = reviewer.session.path
    kept = path.read_bytes()
    reviewer.session.save()
    assert path.read_bytes() == kept
    assert [file.name for file in path.parent.glob("*.before*")] == []
    offered = {action["id"] for action in reviewer.actions}
    assert not offered & {"here", "here_too", "drop", "propose"}


def test_accepting_keeps_the_pose_as_certain(reviewer, tracks):
    reviewer.edit("action", {"frame": 13, "action": "accept"})
    np.testing.assert_array_equal(posed_frames(reviewer.tracks), [13])
    kept = tracks["image_position"].sel(keypoint="L2", view="top").isel(time=3, individual=0)
    np.testing.assert_allclose(tip(reviewer, 13), kept, atol=1e-3)


@pytest.mark.slow
def test_tracking_again_saving_and_opening_again(reviewer, rendered_spider, tracks, tmp_path):
    drag(reviewer, 17)
    before = reviewer.tracks["heading"].to_numpy()[8, 0]
    reviewer.edit("action", {"frame": 17, "action": "retrack"})
    reviewer._worker.join()
    assert reviewer.alarm == ""
    assert reviewer.tracks["heading"].to_numpy()[8, 0] == pytest.approx(before + 1.0)
    assert "2 corrections" in reviewer.status
    reviewer.edit("action", {"frame": 17, "action": "save"})
    saved = read_tracks(tmp_path / "tracks.nc")
    np.testing.assert_allclose(saved["heading"], reviewer.tracks["heading"])
    again = PoseReviewer(rendered_spider, saved, edits=tmp_path / "edits.jsonl")
    assert "2 corrections" in again.status
    assert not again.session.can_undo
    again.close()


def test_points_of_poses_are_not_reviewed_one_by_one(rendered_spider, tracks, reviewer, tmp_path):
    with pytest.raises(InputError, match="PoseReviewer"):
        TrackReviewer(rendered_spider, tracks, edits=tmp_path / "other.jsonl")
    with pytest.raises(InputError, match="which are missing"):
        reviewer.edit("hide", {"frame": 15, "point": "L2"})


def test_a_frame_without_the_animal_can_be_posed(rendered_spider, tracks, tmp_path):
    gone = tracks.copy(deep=True)
    for name in ("heading", "scale", "joint_angle", "segment_length", "image_position"):
        gone[name].to_numpy()[5] = np.nan
    widget = PoseReviewer(rendered_spider, gone, edits=tmp_path / "edits.jsonl", frame=15)
    assert widget.overlay(15)["views"]["top"]["stick"]["dashed"]
    assert "was not found in this frame" in widget.status
    widget.edit("action", {"frame": 15, "action": "accept"})
    assert np.isfinite(tip(widget, 15)).all()
    assert not widget.overlay(15)["views"]["top"]["stick"]["dashed"]
    widget.close()


def test_a_pose_that_was_corrected_is_doubtful_no_more(reviewer):
    table = pd.DataFrame(
        [[17, "top", "L2", "a", 1.0], [20, "top", "R1", "b", 0.5], [17, "top", "R1", "c", 0.1]],
        columns=["frame", "view", "point", "reason", "score"],
    )
    reviewer._offer_doubtful(table)
    drag(reviewer, 17)
    assert [text.split(":")[0] for _, text in reviewer._suspects] == ["frame 20"]
    menu = next(action for action in reviewer.actions if action["id"] == "suspect")
    assert len(menu["options"]) == 1
    # undone, they are looked for anew
    reviewer.edit("action", {"frame": 17, "action": "undo"})
    assert len(reviewer._suspects) == len(reviewer.session.suspects())


@pytest.mark.slow
def test_a_page_without_python_has_the_animal_of_each_frame(reviewer, tmp_path):
    text = reviewer.export_page(tmp_path / "page.html", frames=[12, 13]).read_text()
    data = json.loads(text.split('id="pawnb-data">', 1)[1].split("</", 1)[0])
    sticks = [one["overlay"]["views"]["top"]["stick"] for one in data["frames"]]
    assert [len(stick["legs"]) for stick in sticks] == [8, 8]
    assert sticks[0] != sticks[1]


def test_the_plain_picture_has_the_legs_of_the_animal(reviewer, monkeypatch):
    with_legs = reviewer.plain_picture()
    (legs,) = reviewer.plain_legs(15).values()
    np.testing.assert_allclose(legs[0][0], reviewer.session.pose_at(15).places("L1"))
    monkeypatch.setattr(reviewer, "plain_legs", lambda _frame: {})
    assert reviewer.plain_picture() != with_legs


@pytest.mark.slow
def test_tracks_of_poses_are_observed_and_set(reviewer, tracks):
    heard = []
    reviewer.observe(lambda change: heard.append(change["new"]), "tracks")
    message = {"frame": 12, "point": "L2", "u": 40.0, "v": 40.0, "whole": True}
    reviewer._answer_edit({"what": "moved", "who": "a", "n": 1} | message)
    assert len(heard) == 1
    other = tracks.copy(deep=True)
    other["heading"].to_numpy()[:] += 3.0
    reviewer.tracks = other
    assert len(heard) == 2
    at = int(other["frame"][0])
    assert reviewer.session.pose_at(at).heading_deg == pytest.approx(
        float(tracks["heading"][0, 0]) + 3.0
    )


def stretch(widget, action, point, first, last, **more):
    message = {"frame": first, "action": action, "point": point, "stretch": [first, last], **more}
    widget.edit("stretch", message)


@pytest.mark.slow
def test_legs_are_exchanged_interpolated_and_hidden_over_a_stretch(reviewer, tracks):
    was = {leg: [tip(reviewer, f, leg) for f in range(10, 24)] for leg in ("L2", "R2", "L3")}
    stretch(reviewer, "swap", "L2", 14, 16, other="R2")
    for frame in range(13, 18):
        own, other = ("R2", "L2") if 14 <= frame <= 16 else ("L2", "R2")
        # a leg's joints and tip are where the other's were
        np.testing.assert_allclose(tip(reviewer, frame, "L2"), was[own][frame - 10], atol=1e-6)
        np.testing.assert_allclose(tip(reviewer, frame, "R2"), was[other][frame - 10], atol=1e-6)
        np.testing.assert_array_equal(tip(reviewer, frame, "L3"), was["L3"][frame - 10])
    assert "L2 and R2 exchanged in frames 14 to 16" in reviewer.status
    shown = reviewer.session.pose_at(15).places("L2")[-1]  # what is drawn, from the angles
    np.testing.assert_allclose(shown, was["R2"][5], atol=1e-6)
    reviewer.edit("action", {"frame": 14, "action": "undo"})
    np.testing.assert_allclose(tip(reviewer, 15), was["L2"][5], atol=1e-9)

    drag(reviewer, 18, by=(60.0, -40.0))
    stretch(reviewer, "interpolate", "L2", 18, 20)  # through what was posed in 18
    posed = reviewer.session.pose_at(18).legs["L2"].angles_deg
    ends = [posed, reviewer.session.pose_at(21).legs["L2"].angles_deg]
    for frame in (19, 20):
        angles = reviewer.session.pose_at(frame).legs["L2"].angles_deg
        low, high = np.minimum(*ends) - 1e-6, np.maximum(*ends) + 1e-6
        assert ((angles >= low) & (angles <= high)).all()  # PCHIP does not overshoot

    stretch(reviewer, "hide", "R1", 12, 13)
    assert np.isnan(tip(reviewer, 12, "R1")).all()
    assert np.isfinite(tip(reviewer, 14, "R1")).all()
    drawn = {f: reviewer.overlay(f)["views"]["top"]["stick"]["legs"] for f in (12, 14)}
    assert [leg["name"] for leg in drawn[12] if leg["missing"]] == ["R1"]
    assert not any(leg["missing"] for leg in drawn[14])
    reviewer.edit("action", {"frame": 12, "action": "retrack"})
    reviewer._worker.join()
    assert np.isnan(tip(reviewer, 13, "R1")).all()  # stays so when tracked again
    with pytest.raises(InputError, match="has no leg 'L9'"):
        stretch(reviewer, "delete", "L9", 12, 13)


def test_both_legs_that_were_exchanged_are_doubtful_no_more(reviewer, monkeypatch):
    rows = [[frame, "top", leg, "a", 1.0] for frame in (15, 18) for leg in ("L2", "R2", "L3")]
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "reason", "score"])
    monkeypatch.setattr(reviewer.session, "suspects", lambda: table)
    stretch(reviewer, "swap", "L2", 14, 16, other="R2")
    left = reviewer._doubtful[["frame", "point"]].to_numpy().tolist()
    assert left == [[15, "L3"], [18, "L2"], [18, "R2"], [18, "L3"]]


def test_poses_are_compared_with_those_before_the_corrections(rendered_spider, tracks, tmp_path):
    widget = PoseReviewer(
        rendered_spider, tracks, edits=tmp_path / "edits.jsonl", against="before", frame=17
    )
    was, _ = drag(widget, 17)
    others = {one["id"]: one for one in widget.overlay(17)["views"]["top"]["others"]}
    assert set(others) == set(widget.session.colours)  # tips, not joints
    np.testing.assert_allclose([others["L2"]["u"], others["L2"]["v"]], was, atol=0.01)
    assert widget.edit("action", {"frame": 10, "action": "apart"}) == 17
    far = float(np.hypot(*(tip(widget, 17) - was)))
    assert (
        f"L2 in top, {far:.1f} px from the other tracks (before the corrections)" in widget.status
    )
    widget.close()


def test_the_next_doubtful_frame_chooses_the_leg_that_is_doubtful(reviewer):
    places = [["frame", 16, "R3"], ["frame", 20, "L4"]]
    rows = [(frame, "top", leg, "a joint turns fast", 1.0) for _, frame, leg in places]
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "reason", "score"])
    reviewer._offer_doubtful(table)
    for _, frame, leg in places:
        assert reviewer.edit("action", {"frame": 15, "action": "next"}) == frame
        assert reviewer.overlay(frame)["current"] == ["top", leg]
        assert f"frame {frame}: {leg}" in reviewer.status
    reviewer.edit("select", {"frame": 20, "point": "R1"})  # from here on a person chooses
    assert reviewer.overlay(20)["current"] == ["top", "R1"]


def test_the_next_difference_chooses_its_leg_and_stays_said(rendered_spider, tracks, tmp_path):
    other = tracks.copy(deep=True)
    at = other["image_position"].sel(view="top", keypoint="R2")
    at.to_numpy()[9] += 7.0  # frame 19
    widget = PoseReviewer(rendered_spider, tracks, edits=tmp_path / "e.jsonl", against=other)
    assert widget.edit("action", {"frame": 15, "action": "apart"}) == 19
    assert widget.overlay(19)["current"] == ["top", "R2"]
    widget.frame = 19  # the browser goes there
    assert widget.status.startswith("Difference 1 of")
    widget.close()


@pytest.mark.slow
def test_a_leg_at_full_reach_that_is_dragged_further_out_is_no_correction(reviewer):
    """Its segments are in line then: together they reach from the body to the tip."""
    was = reviewer.session.pose_at(17).places("L2")
    u, v = was[0] + 5.0 * (was[-1] - was[0])
    message = {"frame": 17, "point": "L2", "u": u, "v": v, "whole": True}
    reviewer.edit("moved", message)
    places = reviewer.session.pose_at(17).places("L2")
    reach = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert np.linalg.norm(places[-1] - places[0]) == pytest.approx(reach, rel=0.005)
    for _ in range(3):
        reviewer.edit("moved", message)
    np.testing.assert_array_equal(reviewer.session.pose_at(17).places("L2"), places)
    assert len(reviewer.corrected.corrections) == 1
    assert reviewer.session.path.read_text().count("\n") == 1
    assert reviewer.status.startswith("That moved nothing, so it is no correction. A leg at full")
    reviewer.edit("action", {"frame": 17, "action": "accept"})  # it is right as it is
    assert len(reviewer.corrected.corrections) == 2


def test_a_key_may_change_a_small_animal_by_less_than_a_drag(reviewer):
    session = reviewer.session
    session.go(17)
    was = session.pose_at(17)
    session.set_length(1.001 * was.length_of("L2"), "L2")
    moved = np.abs(session.pose_at(17).places("L2") - was.places("L2")).max()
    assert 0.0 < moved < 0.3
    assert len(reviewer.corrected.corrections) == 1


@pytest.mark.slow
def test_undo_and_redo_say_what_they_did(reviewer):
    drag(reviewer, 17)
    reviewer.edit("action", {"frame": 12, "action": "undo"})
    assert reviewer.status.startswith("Undone: posed in frame 17.\n")
    reviewer.frame = 17  # the browser goes there, and that stays said
    assert reviewer.status.startswith("Undone: posed in frame 17.\n")
    reviewer.edit("action", {"frame": 17, "action": "undo"})
    assert reviewer.status.startswith("Nothing to undo.\n")
    reviewer.edit("action", {"frame": 17, "action": "redo"})
    assert reviewer.status.startswith("Made again: posed in frame 17.\n")


@pytest.mark.slow
def test_what_tracking_again_did_is_said_where_another_frame_was_looked_at(reviewer):
    drag(reviewer, 17)
    began, go_on = threading.Event(), threading.Event()
    again = reviewer._retrack_trial

    def slow(trial, some, frame):
        began.set()
        assert go_on.wait(20)
        return again(trial, some, frame)

    reviewer._retrack_trial = slow
    reviewer.edit("action", {"frame": 17, "action": "retrack"})
    assert began.wait(20)
    # meanwhile: a look at another frame and leg, and a correction that has to wait
    reviewer.frame = 21
    reviewer.edit("select", {"frame": 21, "point": "R1"})
    assert reviewer.status.startswith("The poses are being tracked again;")
    assert [a["id"] for a in reviewer.actions if a["enabled"]] == ["stop"]
    message = {"type": "edit", "what": "action", "action": "undo", "who": "a", "n": 1, "frame": 21}
    reviewer._answer_edit(message)
    assert "being tracked again" in reviewer.alarm
    go_on.set()
    reviewer._worker.join()
    assert reviewer.status.startswith("Tracked again from frame 17 on; now ")
    assert reviewer.alarm == ""  # there is nothing left to wait for
    reviewer.frame = 17  # the browser goes there, and that stays said
    assert reviewer.status.startswith("Tracked again from frame 17 on; now ")
    assert len(reviewer.corrected.corrections) == 2
