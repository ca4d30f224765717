"""The workbench without a browser: from bare videos to tracks and gait, and what is refused."""

import shutil

import numpy as np
import pytest
import small_trial as scene

import pawnb
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE
from pawnb.widgets import ClickInitialiser, TrackReviewer
from pawnb.widgets.crop_canvas import CropCanvas, drag_corner
from pawnb.widgets.workbench_session import WorkbenchSession
from pawnb.workflow.provenance.results import write_track_results
from pawnb.workflow.workbench.new_trial import new_trial


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small") / "trial"
    scene.write_trial(folder)
    (folder / "start.csv").write_text(clicks())
    return folder


@pytest.fixture
def described(rendered, tmp_path):
    """A trial that is started, in a folder of its own below the one that is opened."""
    shutil.copytree(rendered, tmp_path / "m1")
    return tmp_path / "m1"


@pytest.fixture
def bare(described):
    """The same without any description."""
    for name in ("trial.toml", "start.csv"):
        (described / name).unlink()
    return described


def clicks():
    rows = ["frame,view,point,u,v"]
    for k, (view, points) in enumerate(scene.POINTS.items()):
        uv = dict(zip(("FR", "HR"), scene.seen(0)[k], strict=True))
        rows += [f"0,{view},{p},{uv[p][0]},{uv[p][1]}" for p in points]
    return "\n".join(rows) + "\n"


def said(bench):
    return bench._told.value


def test_bare_videos_become_a_trial_and_its_start_is_clicked_next(bare, opened):
    bench = opened(bare, videos=["cam1.avi", "cam2.avi", "cam3.avi"])
    form = bench.tool
    assert form.dlt.value == str(bare / "DLTcoefs.csv")
    assert form.write() is None
    assert "how many frames were filmed in a second" in form._told.value
    form.fps.value = "fast"
    assert form.write() is None
    assert "filmed at is 'fast'; expected a number" in form._told.value
    form.fps.value = "250"
    form._rows[2].points.value = "FR, FL"
    form.first.value = "two"
    assert form.write() is None
    assert "a frame to use is 'two'; expected a number" in form._told.value
    form.first.value, form.last.value = "2", str(scene.N_FRAMES)
    assert form.write() is None
    assert f"expected two of frames 0 to {scene.N_FRAMES - 1}" in form._told.value
    form._canvas.frame = scene.N_FRAMES - 2
    form._take_frame(form.last)
    assert form.write() == bare / "trial.toml"
    trial = pawnb.load_trial(bare)
    assert (trial.fps, trial.views[2].points) == (250.0, ("FR", "FL"))
    assert trial.frames == (2, scene.N_FRAMES - 1)
    assert isinstance(bench.tool.tool, ClickInitialiser)
    assert [state.next_step for state in bench.session.states] == ["start"]


def test_the_page_of_bare_videos_is_opened_again_when_the_trial_is_made(bare, opened):
    """The cell still names the videos: it runs again as the browser comes back."""
    first = opened(bare, videos=["cam1.avi"]).tool
    first.fps.value = "100"
    assert first.write() is not None
    again = opened(bare, videos=["cam1.avi"])
    assert again.tool is None
    assert "go on with the next step" in again._told.value
    assert [state.next_step for state in again.session.states] == ["start"]


def test_another_view_of_the_same_video_is_added_and_left_out(bare, opened):
    bench = opened(bare, videos=["cam1.avi"])
    form = bench.tool
    form._add(form.made.views[0])
    assert [view.name for view in form.made.views] == ["cam1", "cam1-2"]
    form._rows[1].mirror.value = True
    form._canvas.edit("moved", {"frame": 0, "view": "cam1-2", "point": "left top", "u": 9, "v": 99})
    form._rows[0].name.value = form._rows[1].name.value = "same"
    form._add(form.made.views[0])
    assert "the name 'same' is there twice" in form._told.value
    form._rows[0].name.value = "side"
    form.fps.value = "100"
    assert form.write() is not None
    first, second = pawnb.load_trial(bare).views
    assert (first.name, first.crop, first.mirror) == ("side", None, False)
    assert (second.name, second.video, second.crop, second.mirror) == (
        "same", "cam1.avi", (9, 99, scene.WIDTH, scene.HEIGHT), True,
    )  # fmt: skip


def test_corners_stay_within_the_picture_and_apart():
    size = (640, 360)
    assert drag_corner(None, size, "left top", u=-20, v=-3) is None
    assert drag_corner(None, size, "left top", u=10.4, v=20.6) == (10, 21, 640, 360)
    # the pixel that the corner lies on is kept
    assert drag_corner(None, size, "right bottom", u=99, v=199) == (0, 0, 100, 200)
    crop = drag_corner((100, 100, 200, 200), size, "left top", u=500, v=500)
    assert crop == (184, 184, 200, 200)


def test_the_canvas_shows_what_is_kept(bare):
    made = new_trial([bare / "cam1.avi"])
    canvas = CropCanvas(made)
    canvas.edit("moved", {"frame": 0, "view": "cam1", "point": "right bottom", "u": 299, "v": 199})
    assert made.views[0].crop == (0, 0, 300, 200)
    corners = canvas.overlay(0)["views"]["cam1"]["points"]
    assert [(c["u"], c["v"]) for c in corners] == [(0, 0), (299, 199)]
    assert "cam1: 300 x 200 of 640 x 360 px" in canvas.status
    canvas.close()


@pytest.mark.slow
def test_the_list_follows_what_is_clicked_and_saved(described, opened):
    def row():
        cells = bench._list.children[0].children[8:]
        return [cell.value for cell in cells[3:6]], cells[7].children[0].description

    points = (described / "start.csv").read_text().splitlines()[1:]
    (described / "start.csv").unlink()
    bench = opened(described.parent)
    bench.do("start", described)
    clicking = bench.tool.tool
    (go_on,) = bench.tool.children[0].children
    for k, (_, view, point, u, v) in enumerate(line.split(",") for line in points):
        assert row() == (["–", "–", "–"], "Click the start") or k > 1
        message = {"frame": 0, "view": view, "point": point, "u": float(u), "v": float(v)}
        clicking.edit("moved", message)
        if k == 0:  # HR is in no view yet
            go_on.click()
            assert "the start is not complete" in said(bench)
    assert row() == (["✓", "–", "–"], "Track")
    for _ in points:
        clicking.edit("action", {"frame": 0, "action": "undo"})
    assert row() == (["–", "–", "–"], "Click the start")
    for _ in points:
        clicking.edit("action", {"frame": 0, "action": "redo"})
    bench.do("start", described)
    bench.tool.tool.edit("moved", message | {"u": 9.0})  # a copy of the start is kept
    assert sorted(described.glob("start*.csv")) == [
        described / "start.before.csv", described / "start.csv",
    ]  # fmt: skip
    assert WorkbenchSession(described).track_files() == []
    write_track_results(scene.true_tracks(), described / "results")
    bench.do("review", described)
    bench.look_again()
    message = {"frame": 5, "view": "cam1", "point": "FR", "u": 9.0, "v": 9.0}
    bench.tool.tool.edit("moved", message)
    assert row() == (["✓", "✓", "–"], "Analyse the gait")
    bench.tool.tool.edit("action", {"frame": 5, "action": "save"})
    assert row() == (["✓", "✓", "✓"], "Analyse the gait")
    bench.tool.tool._analysts.submit(int).result()  # its filters of warnings end with this test


@pytest.mark.slow
def test_the_frame_to_click_is_chosen_anew_when_the_trial_was_tracked_again(
    described, opened, monkeypatch
):
    """What is tracked again comes from a stand-in that is sure from frame 20 on."""

    def again(_trial, tracks, _frame, **_options):
        new = tracks.copy(deep=True)
        new["image_confidence"].values[20:] = 1.0
        return new

    monkeypatch.setattr("pawnb.widgets.retracking.workflow_retrack", again)
    tracks = scene.true_tracks()
    tracks["image_confidence"].values[15:] = 0.05
    tracks["image_confidence"].values[:15] = 1.0
    write_track_results(tracks, described / "results")
    bench = opened(described.parent)
    bench.do("review", described)
    bench._tell("small: tracked 40 frames, look")
    review, offers = bench.tool.tool, bench.tool.children[0].children[1]

    def offered():
        return [button.description for button in offers.children]

    (at_first,) = offered()
    assert "Click frame" in at_first
    review.retrack(20)
    review._worker.join()
    frame = pawnb.suggest_frames(described, review.tracks, n=1)["frame"]
    assert offered() == [f"Click frame {frame[0]} as well, and track again"] != [at_first]
    assert said(bench) == ""  # the verdict of the tracks before
    review.edit("action", {"frame": 20, "action": "undo"})
    review._renew_lanes()
    assert offered() == [at_first]
    review._analysts.submit(int).result()  # its filters of warnings end with this test


@pytest.mark.slow
def test_a_started_trial_is_tracked_reviewed_and_analysed(described, opened):
    bench = opened(described.parent)
    assert [s.next_step for s in bench.session.states] == ["track"]
    bench.do("track", described)
    bench.work.wait(120)
    assert "small: tracked 40 frames" in said(bench)
    review = bench.tool.tool
    assert isinstance(review, TrackReviewer)
    u, v = scene.seen(5)[0, 0]
    review.edit("moved", {"frame": 5, "view": "cam1", "point": "FR", "u": u, "v": v})
    bench._reviewed(bench.session.state(described))
    bench.work.wait(120)
    assert (described / "results" / "events.csv").exists()
    (state,) = bench.session.states
    assert state.next_step == "look"
    assert "no stride was found" in said(bench)
    assert "(dropped.csv says why); note: small: no stride" in said(bench)
    # clicks in another frame are offered where the tracks are not good, and open there
    tracks = bench.session.tracks(state)
    sure = tracks.copy(deep=True)
    sure["image_confidence"][:] = 1.0
    lost = {"view": "cam2", "keypoint": "HR"}  # it stands, and is missing at the end
    sure["image_position"].loc[lost] = sure["image_position"].sel(lost)[0]
    sure["image_origin"].loc[lost] = ORIGIN_CODE["measured"]
    assert bench.session.frame_to_click(state, sure) is None
    frame = bench.session.frame_to_click(state, tracks)
    assert frame == pawnb.suggest_frames(described, tracks)["frame"][0]
    # and the frames in which the animal is in view, where the others have hardly a right label
    assert bench.session.frames_to_use(state, tracks) is None
    part = sure.copy(deep=True)
    part["image_confidence"][24:] = 0.0
    assert bench.session.frames_to_use(state, part) == (0, 24)
    bench._open(lambda: bench._review(state))
    with pytest.raises(InputError, match="corrections were made; take them back first"):
        bench._use_frames(state, (0, 24))
    assert pawnb.load_trial(described).frames is None
    bench.session.use_frames(state, (0, 24))
    assert pawnb.load_trial(described).frames == (0, 24)
    bench._click_also(state, frame)
    assert isinstance(bench.tool.tool, ClickInitialiser)
    assert bench.tool.tool.frame == frame
    assert len(bench.tool.tool.start) == len(clicks().splitlines()) - 1
    # what was corrected is in the tracks that were analysed
    saved = bench.session.tracks(state)
    assert saved["image_position"].values[5, 0, :, 0, 0].tolist() == [round(u, 3), round(v, 3)]
    assert f"seen in frame {frame}, then Track" in said(bench)


@pytest.mark.filterwarnings("ignore:Passing unrecognized arguments:DeprecationWarning")
@pytest.mark.slow
def test_results_say_what_a_reader_must_know_and_are_old_once_events_are_corrected(
    described, opened
):
    tracks = scene.true_tracks()
    steps = 20.0 * np.sin(2 * np.pi * (np.arange(scene.N_FRAMES)[:, None] / 8.0 + [0.0, 0.5]))
    tracks["position"].values[:, 0, :, 0] += steps
    write_track_results(tracks, described / "results")
    bench = opened(described.parent)
    bench.do("gait", described)
    bench.work.wait(60)
    notes = bench.session.notes(bench.session.state(described))
    assert any("strides a second" in note for note in notes)
    shown = [line.value for line in bench.tool.tool.children if hasattr(line, "value")]
    assert set(notes) <= set(shown)
    assert bench.session.state(described).next_step == "review"
    assert "analysed" in bench.session.state(described).done
    bench._strides(bench.session.state(described))
    explorer = bench.tool.tool.session
    explorer.pick_event(0.08, within_s=1.0)
    explorer.delete_event()
    assert "analysed" not in bench.session.refresh()[0].done
    (again,) = bench.tool.children[0].children
    assert again.description == "Analyse the gait again"
    again.click()
    bench.work.wait(60)
    state = bench.session.state(described)
    assert "analysed" in state.done
    assert any("corrections by hand in force: 1" in note for note in bench.session.notes(state))


def test_what_cannot_be_done_is_said_and_changes_nothing(bare, opened):
    (bare / "trial.toml").write_text("[trial]\nfsp = 250\n")
    bench = opened(bare.parent)
    (state,) = bench.session.states
    assert state.next_step == "mend"
    bench.do("mend", bare)
    assert "did you mean 'fps'" in bench.tool.tool.children[0].value
    with pytest.raises(InputError, match="step is 'paint'"):
        bench.do("paint", bare)
    with pytest.raises(InputError, match="no trial there"):
        bench.do("track", bare.parent / "none")
    bench.do("track", bare)
    bench.work.wait(60)
    assert "did you mean 'fps'" in said(bench)
    with pytest.raises(InputError, match="no such folder"):
        WorkbenchSession(bare / "none")


def test_what_failed_in_tracking_is_in_the_list_until_it_is_tracked(described, opened):
    (described / "cam1.avi").write_bytes(b"damaged")
    bench = opened(described.parent)
    bench.do("track", described)
    bench.work.wait(60)
    assert "cam1.avi" in said(bench)
    again = opened(described.parent)  # as the next day
    assert "tracking failed when it was tried last" in again._list.children[1].value
    assert "cam1.avi" in again._list.children[1].value
    write_track_results(scene.true_tracks(), described / "results")
    again.look_again()
    assert len(again._list.children) == 1


def test_trials_of_one_name_are_told_apart_by_their_folders(described):
    """As those are whose folder was copied."""
    shutil.copytree(described, described.parent / "m2")
    session = WorkbenchSession(described.parent)
    assert [session.title(state) for state in session.states] == ["small (m1)", "small (m2)"]
    assert WorkbenchSession(described).title(session.states[0]) == "small"


def test_a_list_that_is_tracked_says_which_trial_it_is_at(described, monkeypatch):
    told = []
    session = WorkbenchSession(described)

    def track(trial, *, progress, **options):
        progress(3, 40, "decoding")
        return scene.true_tracks()

    monkeypatch.setattr("pawnb.widgets.workbench_session.track", track)
    session.track_all(lambda *words: told.append(words))
    assert told == [(3, 40, "small (1 of 1), decoding")]


@pytest.mark.slow
def test_the_list_of_a_batch_changes_as_each_trial_is_done(described, monkeypatch, opened):
    shutil.copytree(described, described.parent / "m2")
    bench = opened(described.parent)
    ticks = []

    def track(trial, *, out, **options):
        ticks.append([bench._list.children[0].children[row * 8 + 4].value for row in (1, 2)])
        write_track_results(scene.true_tracks(), out)
        return scene.true_tracks()

    monkeypatch.setattr("pawnb.widgets.workbench_session.track", track)
    bench._track_all()
    bench.work.wait(60)
    assert ticks == [["–", "–"], ["✓", "–"]]  # column "tracked"


def test_a_review_with_corrections_that_are_not_saved_is_not_done(described, opened):
    write_track_results(scene.true_tracks(), described / "results")
    (described / "results" / "edits.jsonl").write_text(
        '{"edit": "hide", "frame": 1, "view": "cam1", "point": "FR"}\n'
    )
    bench = opened(described.parent)
    assert "1 correction is not in the tracks" in bench._list.children[1].value
    (state,) = bench.session.states
    bench.session.has_looked(state)
    assert bench.session.next_step(state) == "review"


def test_a_review_in_which_all_was_right_counts(described):
    session = WorkbenchSession(described)
    results = described / "results"
    results.mkdir()
    (results / "tracks.nc").write_bytes(b"")
    (state,) = session.refresh()
    assert session.next_step(state) == "review"
    session.has_looked(state)
    assert session.next_step(state) == "gait"
    assert session.videos() == []


def test_a_long_list_is_shown_page_by_page(described, opened):
    for k in range(24):
        (described.parent / f"x{k:02}").mkdir()
        (described.parent / f"x{k:02}" / "trial.toml").write_text("")
    bench = opened(described.parent)
    rows = len(bench._list.children[0].children) / 8 - 1
    assert rows == 20
    bench._turn(20)
    assert len(bench._list.children[0].children) / 8 - 1 == 5
    bench._turn(20)
    assert len(bench._list.children[0].children) / 8 - 1 == 5


def test_views_that_are_not_calibrated_are_on_the_same_page(described, opened):
    rig = load_rig(pawnb.load_trial(described))
    file = described / "trial.toml"
    before = file.read_text().replace('[calibration]\ndlt = "DLTcoefs.csv"\n', "")
    file.write_text(before)
    (described / "DLTcoefs.csv").unlink()
    # eight corners of a box that every view shows
    xyz = np.array([[x, y, z] for x in (10, 60) for y in (0, 20) for z in (0, 15)], float)
    rows = [f"p{k},{x},{y},{z}" for k, (x, y, z) in enumerate(xyz)]
    (described / "known.csv").write_text("\n".join(["point,x,y,z", *rows]) + "\n")
    bench = opened(described.parent)
    buttons = [b.description for b in bench._list.children[0].children[-1].children[:2]]
    assert buttons == ["Track", "Calibrate"]
    bench.do("calibrate", described)
    form = bench.tool.tool
    form.way.value = "points"
    with pytest.raises(InputError, match="name the file of the known points"):
        form.begin()
    form.file.value, form.unit.value = "known.csv", "cm"
    form.begin()
    with pytest.raises(InputError, match="not every view is determined yet") as refused:
        form.use()
    # what to do next is that of the pictures: a board is found, not clicked
    assert str(refused.value).endswith(form.digitiser.session.prompt())
    for k, uv in enumerate(rig.project(xyz)):
        for view, (u, v) in zip(rig.names, uv, strict=True):
            click = {"frame": 0, "view": view, "point": f"p{k}", "u": u, "v": v}
            form.digitiser.edit("moved", click)
    form.use()
    assert file.read_text().startswith(before.rstrip())  # all else in the file is as it was
    trial = pawnb.load_trial(described)
    calibration = trial.calibration
    assert (calibration.dlt, calibration.pixels, calibration.unit) == ("DLTcoefs.csv", "file", "cm")
    assert bench.session.track_files() == []  # what was clicked to calibrate is no track
    np.testing.assert_allclose(load_rig(trial).project(xyz), rig.project(xyz), atol=1e-3)
    assert isinstance(bench.tool.tool, ClickInitialiser)
    assert "calibrated" in bench.session.states[0].done


def test_words_on_what_is_wrong_can_be_read_on_a_dark_page(bare, opened):
    (bare / "trial.toml").write_text("[trial]\nfsp = 250\n")
    bench = opened(bare)

    def colour():
        return bench._list.children[1].style.text_color

    light = colour()
    bench._around.dark = True
    assert int(colour()[1:3], 16) > 200 > int(light[1:3], 16)
