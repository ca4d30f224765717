"""Clicking the start points without a browser; the scene is that of small_trial.py."""

import numpy as np
import pandas as pd
import pytest
import small_trial as scene

from pawnb import load_trial
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.io.start import check_start, read_start
from pawnb.widgets.start_marks import find_guide
from pawnb.widgets.start_session import StartSession
from pawnb.widgets.start_words import what_contradicts

SIZES = dict.fromkeys(scene.POINTS, (scene.WIDTH, scene.HEIGHT))
ORDER = [("cam1", "FR"), ("cam1", "HR"), ("cam2", "FR"), ("cam2", "HR"), ("cam3", "FR")]


@pytest.fixture
def trial(tmp_path):
    """The trial described in a folder of its own; no video is needed here."""
    return load_trial(scene.describe_trial(tmp_path))


def session_of(trial, **options):
    options = {"sizes": SIZES, "span": (0, 39), "rig": load_rig(trial)} | options
    return StartSession(trial, **options)


def truth(frame, view, point):
    return scene.seen(frame)[list(scene.POINTS).index(view), ["FR", "HR"].index(point)]


def click_all(session, frame=0):
    for view, point in ORDER:
        session.click(view, *truth(frame, view, point))


def test_the_next_point_is_asked_for_view_by_view(trial):
    session = session_of(trial)
    asked = []
    while session.current is not None:
        asked.append(session.current)
        session.click(session.current[0], *truth(0, *session.current))
    assert asked == ORDER
    assert session.prompt() == (
        "All points are placed or marked as hidden. Drag a point to adjust it."
    )


def test_the_prompt_names_the_paw_in_words(trial):
    session = session_of(trial)
    assert session.prompt() == (
        "Click FR (right front paw) in cam1, or press H if it is hidden there."
    )


def test_every_click_is_in_the_file_at_once_and_the_tracker_accepts_the_whole(trial):
    session = session_of(trial)
    session.click("cam1", 110.25, 270.5)
    lines = session.path.read_text().split()
    assert lines == ["frame,view,point,u,v", "0,cam1,FR,110.25,270.5"]
    for view, point in ORDER[1:]:
        session.click(view, *truth(0, view, point))
    start = read_start(trial.path("start.csv"), trial)
    check_start(start, trial, SIZES)
    assert list(zip(start["view"], start["point"], strict=True)) == ORDER
    pd.testing.assert_frame_equal(start, session.table(), check_dtype=False)


def test_a_click_in_another_view_places_the_same_point_there(trial):
    session = session_of(trial)
    session.click("cam1", 100, 100)  # FR; HR in cam1 is asked for now
    assert session.current == ("cam1", "HR")
    assert session.click("cam2", 50, 60) == "HR"
    assert session.clicks[0, "cam2", "HR"] == (50, 60)
    # HR is not tracked by cam3: the first open point of that view is placed
    session.select("cam1", "HR")
    assert session.click("cam3", 20, 30) == "FR"
    assert session.current == ("cam1", "HR")


def test_a_click_where_all_is_placed_says_so_and_changes_nothing(trial):
    session = session_of(trial)
    session.click("cam3", 20, 30)
    before = session.clicks
    session.select("cam1", "HR")
    with pytest.raises(InputError) as error:
        session.click("cam3", 40, 50)
    assert str(error.value) == (
        "every point of cam3 is placed or hidden in frame 0; drag one to move it, or choose one "
        "above the picture to place it again."
    )
    assert session.clicks == before


def test_choosing_a_placed_point_places_it_again(trial):
    session = session_of(trial)
    click_all(session)
    session.select("cam2", "HR")
    session.click("cam2", 5, 6)
    assert session.clicks[0, "cam2", "HR"] == (5, 6)
    assert len(session.clicks) == 5


def test_hidden_points_are_left_out_of_the_file_and_not_asked_for_again(trial):
    session = session_of(trial)
    session.hide()
    assert session.current == ("cam1", "HR")
    for view, point in ORDER[1:]:
        session.click(view, *truth(0, view, point))
    assert session.current is None
    assert (0, "cam1", "FR") in session.hidden
    assert "cam1,FR" not in session.path.read_text()
    session.hide("cam2", "HR")  # taking a placed point away
    assert "cam2,HR" not in session.path.read_text()
    with pytest.raises(InputError, match="no point is asked for"):
        session.hide()


def test_undo_and_redo_follow_in_the_file_and_ask_for_the_point_again(trial):
    session = session_of(trial)
    session.click("cam1", 100, 100)
    session.click("cam1", 200, 200)
    session.place("cam1", "FR", 101, 99)
    assert session.undo()
    assert session.clicks[0, "cam1", "FR"] == (100, 100)
    assert session.undo()
    assert session.current == ("cam1", "HR")
    assert session.path.read_text().split()[1:] == ["0,cam1,FR,100.0,100.0"]
    assert session.redo()
    assert session.clicks[0, "cam1", "HR"] == (200, 200)
    assert session.undo()
    session.hide()
    assert not session.redo()  # a new change forgets what was undone
    for _ in range(2):
        assert session.undo()
    assert not session.undo()
    assert session.clicks == {}
    assert session.current == ("cam1", "FR")


def test_undo_goes_back_to_the_frame_where_it_was_made(trial):
    session = session_of(trial)
    session.click("cam1", 100, 100)
    session.go(7)
    session.undo()
    assert session.frame == 0
    assert session.current == ("cam1", "FR")


def test_any_points_may_be_clicked_in_any_number_of_frames(trial):
    session = session_of(trial)
    click_all(session)
    assert session.clicked() == ""  # they are what is looked at
    session.go(3)
    assert session.clicked() == "Clicked: frame 0."
    assert session.prompt() == (
        "Click FR (right front paw) in cam1, or leave it out here: it is clicked in another frame."
    )
    session.select("cam2", "HR")
    for frame in (3, 5, 39):
        session.go(frame)
        session.place("cam2", "HR", *truth(frame, "cam2", "HR"))
    assert session.clicked() == "Clicked: frames 0, 3, 5, 39."
    assert session.missing() == "Nothing is missing."
    with pytest.raises(InputError, match=r"frame 40 is not in the trial \(0 to 39\)"):
        session.go(40)
    start = session.table()
    check_start(start, trial, SIZES)
    # frame by frame, in each as the points are asked for
    assert start["frame"].is_monotonic_increasing
    for _, own in start.groupby("frame"):
        told = list(own[["view", "point"]].itertuples(index=False, name=None))
        assert told == [slot for slot in ORDER if slot in told]
    assert session_of(trial).clicks == session.clicks  # and they are gone on with


def test_of_many_clicked_frames_the_first_are_named(trial):
    session = session_of(trial)
    for frame in range(20, 31):
        session.go(frame)
        session.click("cam1", 100, 100)
    assert session.clicked() == "Clicked: frames 20, 21, 22, 23, 24, 25, 26, 27 and 3 more."


def test_what_is_missing_in_words(trial):
    session = session_of(trial)
    assert session.missing() == "Not clicked in any view yet: FR, HR."
    session.click("cam1", 100, 100)
    assert session.missing() == (
        "Not clicked in any view yet: HR. Clicked in one view only, two are needed in 3D: "
        "FR (cam1)."
    )
    for view, point in ORDER[1:]:
        session.click(view, *truth(0, view, point))
    assert session.missing() == "Nothing is missing."


@pytest.mark.parametrize(("u", "v"), [(-0.6, 5), (5, 359.6), (640, 5)])
def test_a_click_outside_the_picture_is_refused(trial, u, v):
    session = session_of(trial)
    with pytest.raises(InputError, match=r"outside the picture of cam1 \(640 x 360 px\)"):
        session.click("cam1", u, v)
    assert not session.path.exists()


def test_a_start_there_already_is_taken_up_and_kept_before_it_is_changed(trial):
    first = session_of(trial)
    first.go(2)
    click_all(first, frame=2)
    before = first.path.read_bytes()
    again = session_of(trial)
    assert again.frame == 2
    assert again.clicks == first.clicks
    assert again.current is None
    assert first.path.read_bytes() == before  # opening alone changes nothing
    again.place("cam1", "FR", 7, 8)
    assert trial.path("start.before.csv").read_bytes() == before
    again.place("cam1", "FR", 9, 8)
    assert trial.path("start.before.csv").read_bytes() == before
    # a third session keeps what the second left, beside what the second kept
    second = first.path.read_bytes()
    session_of(trial).place("cam1", "FR", 1, 1)
    assert trial.path("start.before.csv").read_bytes() == before
    assert trial.path("start.before-2.csv").read_bytes() == second


def test_an_unfinished_start_is_gone_on_with(trial):
    session_of(trial).click("cam1", 100, 100)
    again = session_of(trial)
    assert again.current == ("cam1", "HR")
    assert again.clicks == {(0, "cam1", "FR"): (100, 100)}


def test_a_start_can_be_given(trial):
    start = pd.DataFrame(
        [[4, "cam2", "HR", 10.0, 20.0]], columns=["frame", "view", "point", "u", "v"]
    )
    session = session_of(trial, start=start, path=trial.folder / "other.csv")
    assert session.frame == 4
    assert session.clicks == {(4, "cam2", "HR"): (10, 20)}
    assert session.path.name == "other.csv"
    with pytest.raises(InputError, match="cam3 does not track a point 'HR'"):
        session_of(trial, start=start.assign(view="cam3"))


def test_one_other_view_gives_the_epipolar_line_two_the_point(trial):
    session = session_of(trial)
    session.click("cam1", *truth(0, "cam1", "FR"))
    (u0, v0), (u1, v1) = find_guide(session, 0, view="cam2", point="FR")
    # cam1 sees u = x + 60 and v = 300 - z whatever y is; in cam2 v = 280 - z is 20 px higher
    assert v0 == pytest.approx(truth(0, "cam1", "FR")[1] - 20)
    assert v1 == pytest.approx(v0)
    assert {u0, u1} == {-0.5, 639.5}
    session.place("cam2", "FR", *truth(0, "cam2", "FR"))
    ((u, v),) = find_guide(session, 0, view="cam3", point="FR")
    np.testing.assert_allclose([u, v], truth(0, "cam3", "FR"), atol=0.01)
    assert find_guide(session, 0, view="cam1", point="HR") is None
    assert (
        find_guide(session, 1, view="cam3", point="FR") is None
    )  # clicks of another frame say nothing


def test_without_a_calibration_there_is_no_guide(trial):
    session = session_of(trial, rig=None)
    session.click("cam1", 100, 100)
    assert find_guide(session, 0, view="cam2", point="FR") is None


def test_what_is_drawn(trial):
    session = session_of(trial)
    session.click("cam1", 110, 270)
    session.hide()
    overlay = session.overlay(0)
    assert overlay["current"] == ["cam2", "FR"]
    cam1, cam2 = overlay["views"]["cam1"], overlay["views"]["cam2"]
    assert [(p["id"], p["u"], p["v"]) for p in cam1["points"]] == [("FR", 110, 270)]
    assert [(c["id"], c["state"]) for c in cam1["chips"]] == [("FR", "done"), ("HR", "hidden")]
    assert [c["title"] for c in cam1["chips"]] == [
        "FR: clicked at (110.0, 270.0)", "HR: hidden here",
    ]  # fmt: skip
    assert len(cam2["lines"]) == 1
    assert session.overlay(1)["current"] is None
    assert session.overlay(1)["views"]["cam1"]["points"] == []


def test_a_click_that_cannot_be_saved_is_not_made(trial):
    (trial.folder / "file").write_text("")
    session = session_of(trial, path=trial.folder / "file" / "start.csv")
    with pytest.raises((InputError, OSError)):
        session.click("cam1", 100, 100)
    assert session.clicks == {}
    assert session.current == ("cam1", "FR")
    assert not session.can_undo


def test_a_trial_that_names_no_points_asks_for_a_mouses_paws_or_says_so(tmp_path):
    for species, message in (("mouse", None), ("rat", "does not say which points to click")):
        path = tmp_path / species / "trial.toml"
        path.parent.mkdir()
        path.write_text(
            f'[trial]\nfps = 100.0\n[animal]\nspecies = "{species}"\n'
            '[[views]]\nname = "side"\nvideo = "side.avi"\n'
        )
        options = {"sizes": {"side": (100, 50)}, "span": (0, 9), "rig": None}
        if message is None:
            assert session_of(load_trial(path), **options).points == ("FR", "HR", "FL", "HL")
        else:
            with pytest.raises(InputError, match=message):
                session_of(load_trial(path), **options)


def test_without_a_calibration_one_view_is_enough(trial):
    session = session_of(trial, rig=None)
    session.click("cam1", 100, 100)
    session.click("cam1", 200, 100)
    assert session.missing() == "Nothing is missing."


def test_a_proposal_is_no_click_until_it_is_accepted(trial):
    session = session_of(trial)
    rows = [(7, v, p, *truth(7, v, p)) for v, p in ORDER]
    session.propose(pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"]))
    assert session.frame == 7
    assert session.clicks == {}
    assert not session.path.exists()
    drawn = session.overlay(7)["views"]["cam1"]["points"]
    assert [(p["id"], p["origin"]) for p in drawn] == [("FR", "predicted"), ("HR", "predicted")]
    session.place("cam1", "HR", 11.0, 12.0)  # dragged: accepted where it was put
    session.hide("cam3", "FR")
    assert session.overlay(7)["views"]["cam3"]["points"] == []
    session.accept_all()
    assert session.clicks == {
        (7, v, p): (11.0, 12.0) if (v, p) == ("cam1", "HR") else pytest.approx(truth(7, v, p))
        for v, p in ORDER
        if (v, p) != ("cam3", "FR")
    }
    assert "origin" not in session.overlay(7)["views"]["cam1"]["points"][0]
    assert session.current is None
    assert len(read_start(session.path, trial)) == 4
    session.undo()
    assert len(session.clicks) == 3


def test_a_proposal_that_does_not_fit_the_trial_is_refused(trial):
    row = [[7, "cam3", "HR", 1.0, 2.0]]
    with pytest.raises(InputError, match="cam3 does not track a point 'HR'"):
        session_of(trial).propose(pd.DataFrame(row, columns=["frame", "view", "point", "u", "v"]))


def test_a_second_window_never_writes_over_the_clicks_of_the_first(trial):
    first, second = session_of(trial), session_of(trial)
    click_all(first)
    kept = first.path.read_bytes()
    for change in (lambda: second.click("cam1", 50.0, 60.0), lambda: second.hide("cam2", "FR")):
        with pytest.raises(InputError, match="changed by another window or program since it was"):
            change()
        assert first.path.read_bytes() == kept
    assert second.clicks == {}  # not shown as if it were kept
    assert not second.hidden
    first.place("cam1", "FR", 51.0, 61.0)
    again = session_of(trial)  # opened again, it goes on from there
    assert again.clicks == first.clicks
    again.place("cam1", "FR", 52.0, 62.0)
    for step in (first.undo, lambda: first.place("cam1", "FR", 51.0, 61.0)):
        with pytest.raises(InputError, match="run its cell"):
            step()
    assert first.clicks[0, "cam1", "FR"] == (51.0, 61.0)
    assert session_of(trial).clicks[0, "cam1", "FR"] == (52.0, 62.0)


def test_a_click_that_contradicts_the_other_views_is_said_with_its_distance(trial):
    session = session_of(trial)
    click_all(session)
    assert what_contradicts(session) == ""
    overlay = session.overlay(0)["views"]
    chip = overlay["cam2"]["chips"][0]["title"]
    assert chip.endswith(", 0.0 px from where the other views put it")
    # HR has two views; u of cam1 is x + 60 and v = 300 - z, v of cam2 280 - z: the epipolar lines
    # of both are level, so 12 px down in cam2 are 12 px off in either
    u, v = truth(0, "cam2", "HR")
    session.place("cam2", "HR", u, v + 12.0)
    assert what_contradicts(session) == (
        "HR in cam1 is 12 px from where cam2 puts it: one of these clicks is on another point."
    )
    overlay = session.overlay(0)["views"]
    for view in ("cam1", "cam2"):
        title = next(c["title"] for c in overlay[view]["chips"] if c["id"] == "HR")
        assert title.endswith(", 12.0 px from where the other views put it")
        assert len(overlay[view]["guides"]["HR"]) == 2
    assert overlay["cam1"]["limit_px"] == 10.0
    # along the line another view cannot tell
    session.place("cam2", "HR", u + 50.0, v)
    assert what_contradicts(session) == ""
    # FR has three views: the two others say where it is in cam3
    u, v = truth(0, "cam3", "FR")
    session.place("cam3", "FR", u + 30.0, v + 40.0)
    assert "FR in cam3 is 50 px from where cam1 and cam2 put it" in what_contradicts(session)


def test_what_a_click_would_place_is_told_for_each_view(trial):
    session = session_of(trial)

    def asks():
        return {view: marks["asks"] for view, marks in session.overlay(0)["views"].items()}

    assert asks() == {"cam1": "FR", "cam2": "FR", "cam3": "FR"}
    session.click("cam1", *truth(0, "cam1", "FR"))
    assert asks() == {"cam1": "HR", "cam2": "HR", "cam3": "FR"}
    for view in ("cam1", "cam3", "cam2", "cam2"):
        point = asks()[view]
        assert session.click(view, *truth(0, view, point)) == point
    assert asks() == dict.fromkeys(scene.POINTS)
    session.select("cam1", "FR")  # chosen above the picture: a click places it again
    assert asks()["cam1"] == "FR"
    assert session.overlay(5)["views"]["cam1"]["asks"] is None  # another frame is looked at
