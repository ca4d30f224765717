"""Reviewing tracks without a browser; the scene is that of small_trial.py."""

import dataclasses
import json
import threading

import numpy as np
import pandas as pd
import pytest
import small_trial as scene
import xarray as xr

from pawnb import load_trial
from pawnb.core.edits.log import Move, Retrack
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.trial import View
from pawnb.widgets.review_session import TRAIL, ReviewSession, suspect_options


@pytest.fixture
def trial(tmp_path):
    return load_trial(scene.describe_trial(tmp_path))


def session_of(trial, tracks=None, **options):
    options = {"rig": load_rig(trial), "edits": trial.folder / "edits.jsonl"} | options
    return ReviewSession(trial, scene.true_tracks() if tracks is None else tracks, **options)


def mark(overlay, view, kind, name):
    (found,) = [m for m in overlay["views"][view][kind] if m["id"] == name]
    return found


def at(found):
    return [found["u"], found["v"]]


def test_points_and_reprojections_lie_where_the_scene_has_them(trial):
    overlay = session_of(trial).overlay(12)
    uv = scene.seen(12)
    for k, view in enumerate(scene.POINTS):
        np.testing.assert_allclose(at(mark(overlay, view, "hollow", "FR")), uv[k, 0], atol=0.01)
        np.testing.assert_allclose(at(mark(overlay, view, "points", "FR")), uv[k, 0], atol=0.01)
    # cam3 does not track HR: only where the 3D point is, no ring and no button
    assert [p["id"] for p in overlay["views"]["cam3"]["points"]] == ["FR"]
    assert [c["id"] for c in overlay["views"]["cam3"]["chips"]] == ["FR"]
    np.testing.assert_allclose(at(mark(overlay, "cam3", "hollow", "HR")), uv[2, 1], atol=0.01)


def test_nothing_is_tracked_again_where_another_window_has_made_corrections(trial):
    asked = []
    first, second = (session_of(trial, retrack=lambda *_: asked.append(1)) for _ in range(2))
    first.hide(3, "cam1", "FR")
    with pytest.raises(InputError, match="another window or program has made corrections since"):
        second.retrack(5)
    assert (asked, second.busy) == ([], False)


def test_it_is_said_that_one_view_only_sees_a_point(trial):
    tracks = scene.true_tracks()
    tracks["image_origin"].to_numpy()[12, 1:, 0] = ORIGIN_CODE["reprojected"]
    session = session_of(trial, tracks)
    assert session.say_seen_once(11, "FR") == ""
    again = "place it in a second view as well"
    assert session.say_seen_once(12, "FR") == (
        f"; only cam1 sees it, so its distance from there is a guess: {again}"
    )
    assert session.is_seen(12, "cam1", "FR")
    assert not session.is_seen(12, "cam2", "FR")
    # of a stretch it is said in how many frames: hidden where one other view is left
    session.hide(10, "cam3", "FR", stop=12)
    assert session.say_lost(10, 12, "FR") == ""
    session.hide(10, "cam2", "FR", stop=12)
    assert session.say_lost(8, 12, "FR") == (
        "; in 2 of these frames only one view has FR, so it has no place in space"
    )
    session.delete(12, 13, "FR")
    assert session.say_seen_once(12, "FR") == ""
    u, v = scene.seen(12)[0, 0]
    session.move(12, "cam1", "FR", u=u, v=v)
    assert session.say_seen_once(12, "FR") == (
        f"; only cam1 sees it, so it has no place in space here: {again}"
    )


def test_a_point_that_is_wrong_in_one_view_shows_up_in_that_view(trial):
    """FR has three views: leaving cam1 out, the two others are right about where it is."""
    tracks = scene.true_tracks()
    tracks["image_position"].to_numpy()[12, 0, :, 0, 0] += [30, -40]
    overlay = session_of(trial, tracks).overlay(12)
    np.testing.assert_allclose(
        at(mark(overlay, "cam1", "hollow", "FR")), scene.seen(12)[0, 0], atol=0.01
    )
    assert mark(overlay, "cam1", "chips", "FR")["title"] == (
        "FR: measured, confidence 0.80, residual 0.0 px, 50.0 px from where the other views put it"
    )


def test_a_trail_goes_back_twenty_frames_and_shows_gaps(trial):
    tracks = scene.true_tracks()
    tracks["image_position"].to_numpy()[28, 0, :, 0, 0] = np.nan
    overlay = session_of(trial, tracks).overlay(30)
    (trail,) = [
        line for line in overlay["views"]["cam1"]["lines"]
        if line["at"][-1] == scene.seen(30)[0, 0].tolist()
    ]  # fmt: skip
    assert len(trail["at"]) == TRAIL + 1
    assert trail["at"][0] == scene.seen(10)[0, 0].tolist()
    assert trail["at"][18] is None
    assert trail["fade"]
    first = session_of(trial, tracks, edits=None).overlay(0)
    assert first["views"]["cam1"]["lines"] == []  # one point is no line


def test_the_overlay_is_plain_json(trial):
    tracks = scene.true_tracks()
    tracks["image_position"].to_numpy()[3, :, :, 0] = np.nan
    tracks["image_origin"].to_numpy()[3, :, 0] = ORIGIN_CODE["missing"]
    tracks["residual"].to_numpy()[:] = np.nan
    text = json.dumps(session_of(trial, tracks).overlay(3), allow_nan=False)
    assert json.loads(text)["views"]["cam1"]["chips"][0] == {
        "id": "FR", "colour": "#0072B2", "state": "missing",
        "title": "FR: not visible here; click in this view to place it",
    }  # fmt: skip


def test_a_correction_is_on_disk_and_in_what_is_drawn(trial):
    session = session_of(trial)
    said = session.move(12, "cam1", "FR", u=200.0, v=100.0)
    assert said == "FR in cam1 moved in frame 12"
    (line,) = (trial.folder / "edits.jsonl").read_text().splitlines()
    assert json.loads(line) == {
        "edit": "move", "frame": 12, "view": "cam1", "point": "FR", "u": 200.0, "v": 100.0,
    }  # fmt: skip
    overlay = session.overlay(12)
    point = mark(overlay, "cam1", "points", "FR")
    assert (at(point), point["origin"]) == ([200, 100], "edited")
    assert mark(overlay, "cam1", "chips", "FR")["title"].startswith("FR: placed by hand, residual")
    assert float(session.tracks["residual"].to_numpy()[12, 0, 0]) > 10
    assert session.tracks.attrs["provenance"] != "{}"


def test_undo_redo_and_opening_again(trial):
    session = session_of(trial)
    assert not session.can_undo
    session.move(12, "cam1", "FR", u=200.0, v=100.0)
    session.hide(13, "cam2", "HR")
    assert session.undo().frame == 13
    assert session.position(13, "cam2", "HR") == tuple(scene.seen(13)[1, 1])
    again = session_of(trial)
    assert again.position(12, "cam1", "FR") == (200, 100)
    assert again.position(13, "cam2", "HR") is not None
    assert again.can_undo
    assert again.can_redo
    assert again.redo().frame == 13
    assert again.position(13, "cam2", "HR") is None
    assert again.redo() is None


def test_accepting_keeps_the_place_and_needs_one(trial):
    session = session_of(trial)
    assert session.accept(5, "cam1", "HR") == "HR in cam1 accepted in frame 5"
    assert session.position(5, "cam1", "HR") == tuple(scene.seen(5)[0, 1])
    with pytest.raises(InputError, match="HR has no position in cam3, frame 5; click it first"):
        session.accept(5, "cam3", "HR")


def test_exchanging_two_points_from_a_frame_on(trial):
    session = session_of(trial)
    assert session.pairs() == [("FR", "HR")]
    session.swap(20, "FR", "HR")
    assert session.position(19, "cam1", "FR") == tuple(scene.seen(19)[0, 0])
    assert session.position(20, "cam1", "FR") == tuple(scene.seen(20)[0, 1])


def nudge(tracks, frame):
    """A tracker that moves everything by (1, 0) px from a frame on."""
    new = tracks.copy(deep=True)
    new["image_position"].to_numpy()[new["frame"].to_numpy() >= frame, :, 0] += 1
    return new


def test_tracking_again_uses_the_corrected_tracks_and_can_be_undone(trial):
    asked = []

    def tracker(tracks, frame):
        asked.append((frame, tracks["image_position"].to_numpy()[10, 0, :, 0, 0].tolist()))
        return nudge(tracks, frame)

    session = session_of(trial, retrack=tracker)
    session.move(10, "cam1", "FR", u=200.0, v=100.0)
    assert session.retrack(10) == "tracked again from frame 10 on"
    assert asked == [(10, [200, 100])]
    assert session.position(10, "cam1", "FR") == (200, 100)
    assert session.position(11, "cam1", "FR") == tuple(scene.seen(11)[0, 0] + np.array([1, 0]))
    session.undo()
    assert session.position(11, "cam1", "FR") == tuple(scene.seen(11)[0, 0])
    session.redo()
    assert len(asked) == 1  # redo takes the result that is there
    again = session_of(trial, retrack=tracker)
    xr.testing.assert_allclose(again.tracks, session.tracks)
    assert len(asked) == 2  # opened with tracks from before, it is done again


def test_pictures_can_be_looked_at_but_not_corrected_while_tracking_again(trial):
    begun, go_on = threading.Event(), threading.Event()

    def slow(tracks, frame):
        begun.set()
        assert go_on.wait(10)
        return nudge(tracks, frame)

    session = session_of(trial, retrack=slow)
    worker = threading.Thread(target=session.retrack, args=(10,))
    worker.start()
    assert begun.wait(10)
    session.overlay(3)
    for refused in (
        lambda: session.move(3, "cam1", "FR", u=1.0, v=1.0),
        lambda: session.undo(),
        lambda: session.retrack(5),
    ):
        with pytest.raises(InputError) as error:
            refused()
        assert str(error.value) == (
            "the trial is being tracked again; wait until that is done, or stop it."
        )
    go_on.set()
    worker.join(10)
    assert session.corrections == (Retrack(frame=10),)
    session.move(3, "cam1", "FR", u=1.0, v=1.0)
    assert session.corrections[1:] == (Move(frame=3, view="cam1", point="FR", u=1, v=1),)


def test_a_tracker_that_fails_leaves_tracks_and_file_as_they_were(trial):
    def broken(tracks, frame):
        raise InputError("no paw in frame 10")

    session = session_of(trial, retrack=broken)
    with pytest.raises(InputError, match="no paw in frame 10"):
        session.retrack(10)
    assert not session.busy
    assert not (trial.folder / "edits.jsonl").exists()
    xr.testing.assert_identical(session.tracks, scene.true_tracks())


def test_saved_tracks_are_written_again_when_what_they_contain_is_undone(trial):
    saved = []
    session = session_of(trial, save=saved.append)
    session.move(10, "cam1", "FR", u=200.0, v=100.0)
    session.save()
    session.hide(11, "cam1", "FR")
    session.undo()
    assert len(saved) == 1  # the saved tracks never had that one
    session.undo()
    assert len(saved) == 2
    reopened = session_of(trial, saved[-1])
    assert reopened.position(10, "cam1", "FR") == tuple(scene.seen(10)[0, 0])


@pytest.mark.slow
def test_many_threads_correct_and_look_at_once(trial):
    session = session_of(trial)
    faults = []

    def work(point):
        try:
            for frame in range(10):
                session.move(frame, "cam1", point, u=float(frame), v=1.0)
                session.overlay(frame)
        except Exception as error:  # noqa: BLE001, whatever it is fails the test
            faults.append(error)

    threads = [threading.Thread(target=work, args=(point,)) for point in ("FR", "HR")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert faults == []
    assert len(session.corrections) == 20
    again = session_of(trial)
    np.testing.assert_array_equal(again.tracks["image_position"], session.tracks["image_position"])


def test_uncalibrated_tracks_can_be_reviewed(trial):
    tracks = scene.true_tracks().isel(space=[0, 1])
    session = session_of(trial, tracks, rig=None)
    assert session.overlay(3)["views"]["cam1"]["hollow"] == []
    session.move(3, "cam1", "FR", u=7.0, v=8.0)
    np.testing.assert_array_equal(session.tracks["position"].to_numpy()[3, :, 0, 0], [7, 8])


def test_suspects_are_offered_as_frames_to_jump_to():
    table = pd.DataFrame(
        [[12, "cam1", "FR", "residual 9 px", 3.0]],
        columns=["frame", "view", "point", "reason", "score"],
    )
    assert suspect_options(table) == [["0", "frame 12: FR in cam1, residual 9 px"]]
    assert suspect_options(None) == []


@pytest.mark.parametrize(
    ("points", "pairs"),
    [
        # two cameras beside a mouse: neither tracks a left and a right paw
        ({"near": "FR HR", "far": "FL HL"}, "FR-FL HR-HL FR-HR FL-HL"),
        ({"near": "L1 L2", "far": "R1 R2"}, "L1-R1 L2-R2 L1-L2 R1-R2"),
        # as other programs' users name them
        (
            {"near": "hindpaw_left nose", "far": "hindpaw_right ear_L ear_R"},
            "hindpaw_left-hindpaw_right ear_L-ear_R hindpaw_left-nose "
            "hindpaw_right-ear_L hindpaw_right-ear_R",
        ),
        ({"near": "a b", "far": "c"}, "a-b"),
    ],
)
def test_left_and_right_are_offered_for_exchange_also_where_no_view_tracks_both(
    trial, points, pairs
):
    views = tuple(
        View(name=v, video=f"{v}.avi", points=tuple(p.split())) for v, p in points.items()
    )
    trial = dataclasses.replace(trial, views=views, calibration=None)
    every = [point for named in points.values() for point in named.split()]
    tracks = make_tracks(range(4), every, fps=250.0, views=list(points), unit="px")
    offered = session_of(trial, tracks, rig=None).pairs()
    assert ["-".join(pair) for pair in offered] == pairs.split()


def test_a_view_is_told_where_the_others_put_each_point_also_where_it_is_missing(trial):
    tracks = scene.true_tracks()
    tracks["image_position"].to_numpy()[12, 0, :, 0, 0] = np.nan
    tracks["image_origin"].to_numpy()[12, 0, 0, 0] = ORIGIN_CODE["missing"]
    views = session_of(trial, tracks).overlay(12)["views"]
    np.testing.assert_allclose(views["cam1"]["guides"]["FR"], [scene.seen(12)[0, 0]], atol=0.1)
    # of HR, which two views track, each has one other only: no place can be told
    assert "HR" not in views["cam1"]["guides"]
