"""Tracking in one call: what it writes, what it refuses, and tracking again from a frame."""

from __future__ import annotations

import dataclasses
import json
import re
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from pawnb.core.rig import Rig, load_rig
from pawnb.core.video import open_views
from pawnb.core.video.doubts.exchanged_films import film_codes
from pawnb.errors import CalibrationError, InputError, InputWarning
from pawnb.gait import body_angles
from pawnb.io.native import read_tracks
from pawnb.io.start import write_start
from pawnb.schema import ORIGIN_CODE, POINTS3D_COLUMNS, SUSPECTS_COLUMNS, TRACKS_COLUMNS
from pawnb.trial import load_trial
from pawnb.workflow.evaluation.errors import count_errors
from pawnb.workflow.provenance.results import described_trial
from pawnb.workflow.tracking.retrack_points import _frames_learnt_in
from pawnb.workflow.tracking.track import retrack, track
from pawnb.workflow.tracking.trial_views import frame_range, view_facing

FRAMES = (0, 12)
SLIC = ("slic-3d", "slic-2d")


@pytest.fixture(scope="module")
def tracked(rendered_trial, tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    tracks = track(
        rendered_trial, method="paper", frames=FRAMES, out=out, command=["pawnb", "track", "x"]
    )
    return tracks, out


def test_files_and_columns_are_those_of_the_contract(tracked):
    _, out = tracked
    assert sorted(path.name for path in out.iterdir()) == [
        "notes.csv",
        "points3d.csv",
        "provenance.json",
        "quality.json",
        "suspects.csv",
        "tracks.csv",
        "tracks.nc",
    ]
    assert tuple(pd.read_csv(out / "tracks.csv").columns) == TRACKS_COLUMNS
    assert tuple(pd.read_csv(out / "points3d.csv").columns) == POINTS3D_COLUMNS
    assert tuple(pd.read_csv(out / "suspects.csv").columns) == SUSPECTS_COLUMNS


@pytest.mark.slow
@pytest.mark.parametrize("known_by", ["clicks", "tracks"])
def test_films_exchanged_since_they_were_clicked_or_tracked_are_said(small_trial, known_by):
    """Clicks of a script know no film, but the tracks that were made from them do."""
    file, text = small_trial / "start.csv", (small_trial / "trial.toml").read_text()
    if known_by == "clicks":
        with open_views(load_trial(small_trial)) as views:
            codes = film_codes(views.readers)
        clicks = pd.read_csv(file)
        write_start(clicks.assign(film=clicks["view"].map(codes)), file)
    else:
        track(small_trial, method="paper", frames=FRAMES, out=small_trial / "results")
    names = {"cam1.avi": "cam2.avi", "cam2.avi": "cam1.avi"}
    (small_trial / "trial.toml").write_text(re.sub("cam[12].avi", lambda m: names[m[0]], text))
    said = {
        "clicks": "the clicks of view cam1 were made in another film",
        "tracks": "view cam1 was given cam2",
    }
    with pytest.warns(InputWarning) as told:
        track(small_trial, method="paper", frames=FRAMES)
    assert any(str(one.message).startswith(said[known_by]) for one in told)


@pytest.mark.slow
def test_clicks_that_disagree_between_views_are_said_in_tracking(small_trial):
    clicks = pd.read_csv(small_trial / "start.csv")
    off = (clicks["view"] == "cam1") & (clicks["point"] == "FR")
    clicks.loc[off, "v"] -= 30.0
    clicks.to_csv(small_trial / "start.csv", index=False)
    with pytest.warns(InputWarning) as told:
        track(small_trial, method="paper", frames=FRAMES)
    assert any(str(one.message).startswith("start clicks of FR in frame 0 disag") for one in told)


@pytest.mark.slow
def test_the_default_follows_every_paw_through_the_recording(rendered_trial):
    """A front paw is 8 px long here; hidden paws are bridged, so nothing is missing."""
    tracks = track(rendered_trial)
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    report = count_errors(tracks, truth, threshold_px=4.0)
    assert report.share_wrong < 0.05
    assert report.share_missing == 0
    # a tenth of a front paw. Candidates are told by windows of 5 px here, which is as long as a
    # paw: those of hind paws lie 0.65 px behind what one click, put at a whole pixel, tells
    assert report.median_px < 0.8
    assert report.median_px_centred < 0.4


def clicks_in(folder, frame):
    """What is visible in a frame of what the trial's views track, as start clicks."""
    truth = pd.read_csv(folder / "truth" / "tracks.csv").query(f"frame == {frame} and visible == 1")
    start = pd.read_csv(folder / "start.csv")
    own = set(zip(start["view"], start["point"], strict=True))
    truth = truth[[pair in own for pair in zip(truth["view"], truth["point"], strict=True)]]
    return truth[["frame", "view", "point", "u", "v"]].reset_index(drop=True)


@pytest.mark.parametrize("clicked", [pytest.param(5, marks=pytest.mark.slow), 30])
@pytest.mark.slow
def test_the_default_goes_both_ways_from_where_paws_were_clicked(rendered_trial, clicked):
    """Nothing is missing before the click, and paws are found there as they are after one."""
    start = clicks_in(rendered_trial, clicked)
    assert set(start["point"]) == {"FR", "HR", "FL", "HL"}
    tracks = track(rendered_trial, start=start)
    assert tracks["frame"].to_numpy().tolist() == list(range(40))
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    for part in (truth, truth[truth["frame"] < clicked]):
        report = count_errors(tracks, part, threshold_px=4.0)
        assert report.share_wrong < 0.05
        assert report.share_missing == 0
        assert report.median_px < 1.0  # an eighth of a front paw
    here = tracks.isel(time=clicked, individual=0)
    for click in start.itertuples():
        place = here["image_position"].sel(view=click.view, keypoint=click.point)
        np.testing.assert_allclose(place, [click.u, click.v])


@pytest.mark.slow
def test_the_trials_range_is_tracked_from_its_first_frame_on(small_trial):
    change(small_trial, "[trial]", "[trial]\nframes = [4, 14]")
    tracks = track(small_trial, start=clicks_in(small_trial, 8))
    assert tracks["frame"].to_numpy().tolist() == list(range(4, 14))
    steps = json.loads(tracks.attrs["provenance"])["steps"]
    assert steps[0]["frames"] == [4, 14]


@pytest.mark.parametrize(
    ("frames", "method", "span"),
    [
        (None, "pawnb", (2, 38)),  # every view has these
        ((0, 20), "pawnb", (2, 20)),
        ((4, 20), "pawnb", (4, 20)),
        ((4, 20), "paper", (9, 20)),
        (None, "slic-2d", (9, 38)),
    ],
)
def test_a_range_begins_where_every_view_has_begun(rendered_trial, frames, method, span):
    views = SimpleNamespace(first_frame=2, n_frames=38)
    clicks = clicks_in(rendered_trial, 9)
    trial = load_trial(rendered_trial)
    assert frame_range(trial, views, clicks, method=method, frames=frames) == span


@pytest.mark.slow
def test_points_clicked_in_different_frames_are_all_tracked_from_the_first(rendered_trial):
    start = pd.concat(
        [
            clicks_in(rendered_trial, 0).query("point in ['FR', 'HL', 'FL']"),
            clicks_in(rendered_trial, 30).query("point == 'HR'"),
        ]
    )
    tracks = track(rendered_trial, start=start)
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv").query("point == 'HR'")
    report = count_errors(tracks, truth[truth["frame"] < 30], threshold_px=4.0)
    assert report.share_missing == 0
    assert report.share_wrong < 0.05


@pytest.mark.parametrize(
    "method", ["pawnb", *(pytest.param(name, marks=pytest.mark.slow) for name in SLIC)]
)
def test_every_method_tracks_again_from_a_frame(small_trial, method):
    trial = load_trial(small_trial)
    tracks = track(trial, method=method, frames=(0, 12))
    again = retrack(trial, tracks, 6)
    assert again.sizes == tracks.sizes
    before = {"time": slice(0, 6)}
    assert again.isel(before).equals(tracks.isel(before))
    assert json.loads(again.attrs["provenance"])["steps"][-1]["frame"] == 6


def test_points_stay_near_the_truth_at_first(tracked, rendered_trial):
    """The paws are clicked in frame 0; two frames later every label is still on its paw.

    A hind paw is about 40 px long at full scale (8 px at this one).
    """
    _, out = tracked
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    both = pd.read_csv(out / "tracks.csv").merge(truth, on=["frame", "view", "point"])
    both = both[(both["frame"] <= 2) & (both["visible"] == 1)]
    away = np.hypot(both["u_x"] - both["u_y"], both["v_x"] - both["v_y"])
    assert len(both) >= 24
    assert away.max() < 8


def test_provenance_names_every_input_and_no_place(tracked, rendered_trial):
    _, out = tracked
    text = (out / "provenance.json").read_text()
    (step,) = json.loads(text)["steps"]
    assert step["step"] == "track"
    assert step["method"] == "paper"
    assert step["command"] == "pawnb track x"
    assert sorted(step["inputs"]) == [
        "DLTcoefs.csv", "cam1.avi", "cam2.avi", "cam3.avi", "cam4.avi", "start.csv",
    ]  # fmt: skip
    assert step["settings"]["window_u_px"] == 70.0
    assert str(rendered_trial.parent) not in text


@pytest.mark.slow
def test_the_same_run_writes_the_same_bytes(tracked, rendered_trial, tmp_path):
    _, out = tracked
    again = {"frames": FRAMES, "out": tmp_path, "command": ["pawnb", "track", "x"]}
    track(rendered_trial, method="paper", **again)
    for path in out.iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes(), path.name


def test_tracks_carry_their_trial_and_belt(tracked, tmp_path):
    tracks = read_tracks(tracked[1] / "tracks.nc")
    assert (tracks["belt_speed"] == 300.0).all()
    trial = described_trial(tracks, where="tracks.nc", folder=tmp_path)
    assert trial.animal.species == "mouse"
    assert trial.fps == 250.0


def test_settings_of_the_call_go_before_those_of_the_trial(small_trial):
    with (small_trial / "trial.toml").open("a") as file:
        file.write("\n[tracking]\nmedian_px = 3\nwindow_u_px = 60\n")
    tracks = track(small_trial, method="paper", frames=(0, 2), settings={"median_px": "7"})
    settings = json.loads(tracks.attrs["provenance"])["steps"][0]["settings"]
    assert (settings["median_px"], settings["window_u_px"]) == (7.0, 60.0)


@pytest.mark.slow
def test_a_parameter_of_a_stage_is_set_recorded_and_kept_when_tracked_again(small_trial):
    """What is recorded as in force is what the stage reads: 0.9 of a paw width is its default."""
    tracks = track(small_trial, frames=(0, 12), settings={"smoothing.refinement_near": "0.3"})
    step = json.loads(tracks.attrs["provenance"])["steps"][0]
    assert step["settings"]["smoothing.refinement_near"] == 0.3
    assert step["parameters"]["smoothing"]["refinement_near"] == 0.3
    assert step["parameters"]["smoothing"]["refinement_sigma"] == 0.12
    plain = track(small_trial, frames=(0, 12))
    record = json.loads(plain.attrs["provenance"])["steps"][0]
    assert record["parameters"]["smoothing"]["refinement_near"] == 0.9
    assert not plain["sd"].equals(tracks["sd"])
    again = retrack(load_trial(small_trial), tracks, 6)
    settings = json.loads(again.attrs["provenance"])["steps"][-1]["settings"]
    assert settings["smoothing.refinement_near"] == 0.3


@pytest.mark.parametrize(
    ("settings", "method", "said"),
    [
        ({"smoothing.near": 1}, "pawnb", "smoothing: unknown name 'near'"),
        ({"smooth.refinement_near": 1}, "pawnb", "'smooth.refinement_near' is of no stage"),
        (
            {"smoothing.refinement_near": 1},
            "paper",
            "is of no stage; stages are maghsoudi2019, paw_proposal",
        ),
    ],
)
def test_what_is_no_parameter_of_a_stage_is_refused(small_trial, settings, method, said):
    with pytest.raises(InputError, match=said):
        track(small_trial, method=method, settings=settings)
    written = dataclasses.replace(load_trial(small_trial), tracking=settings)
    if method == "pawnb":
        with pytest.raises(InputError, match=said):
            track(written)


def test_retracking_keeps_what_was_before_and_starts_from_the_correction(tracked, small_trial):
    tracks = tracked[0]
    trial = load_trial(small_trial)
    row, frame = 6, 6
    truth = pd.read_csv(small_trial / "truth" / "tracks.csv")
    fixed = tracks.copy(deep=True)
    place = {"time": row, "individual": 0}
    for label in truth[(truth["frame"] == frame) & (truth["point"] == "FR")].itertuples():
        if label.view in ("cam1", "cam2"):
            view = trial.views.index(trial.view(label.view))
            at = {**place, "view": view, "keypoint": 0}
            fixed["image_position"][at] = [label.u, label.v]
            fixed["image_origin"][at] = ORIGIN_CODE["edited"]
    again = retrack(trial, fixed, frame)
    before = {"time": slice(0, row)}
    assert again.isel(before).equals(tracks.isel(before))
    np.testing.assert_allclose(
        again["image_position"].isel(place).sel(view="cam1", keypoint="FR"),
        fixed["image_position"].isel(place).sel(view="cam1", keypoint="FR"),
    )
    assert again.sizes == tracks.sizes
    last = json.loads(again.attrs["provenance"])["steps"][-1]
    assert (last["step"], last["frame"]) == ("retrack", frame)
    with pytest.raises(InputError, match="frame 99 is not among the tracked frames 0 to 11"):
        retrack(trial, tracks, 99)


def test_an_animal_that_was_renamed_since_keeps_its_tracks_when_tracked_again(tracked, small_trial):
    """The new tracks were joined to the old ones by the animal's name, which left none of them."""
    file = small_trial / "trial.toml"
    file.write_text(file.read_text().replace('id = "synthetic-01"', 'id = "m 7"'))
    trial = load_trial(small_trial)
    assert trial.animal.id == "m 7"
    tracks = tracked[0]
    again = retrack(trial, tracks, 6)
    assert again.sizes == tracks.sizes
    known = np.isfinite(tracks["image_position"].to_numpy())
    assert np.isfinite(again["image_position"].to_numpy())[known].mean() > 0.9


@pytest.mark.parametrize("method", [pytest.param("paper", marks=pytest.mark.slow), "pawnb"])
@pytest.mark.slow
def test_tracking_again_changes_the_corrected_points_only(method, small_trial):
    """FR is put right in frame 4 and in frame 8: rows 4 to 7 of FR are tracked again."""
    trial = load_trial(small_trial)
    tracks = track(trial, method=method, frames=(0, 12))
    lost = tracks.copy(deep=True)
    place = {"keypoint": "FR", "view": ["cam1", "cam2"]}
    late = lost["frame"] >= 4
    astray = (lost["keypoint"] == "FR") & lost["view"].isin(place["view"]) & late
    lost["image_position"] = lost["image_position"] + 15.0 * astray
    lost["image_position"] = lost["image_position"].transpose(*tracks["image_position"].dims)
    for frame in (4, 8):
        for view in ("cam1", "cam2"):
            here = {"view": view, "keypoint": "FR", "individual": trial.animal.id}
            lost["image_position"].loc[here][frame] = tracks["image_position"].loc[here][frame]
            lost["image_origin"].loc[here][frame] = ORIGIN_CODE["edited"]
    again = retrack(trial, lost, 4, learn=True)
    others = ["HR", "FL", "HL"]
    for name in ("position", "image_position", "image_origin", "confidence"):
        np.testing.assert_array_equal(again[name].sel(keypoint=others),
                                      lost[name].sel(keypoint=others), err_msg=name)  # fmt: skip
        own, was = again[name].sel(keypoint="FR"), lost[name].sel(keypoint="FR")
        np.testing.assert_array_equal(own[:4], was[:4])
        np.testing.assert_array_equal(own[8:], was[8:])
    away = np.abs(again["image_position"].loc[place] - tracks["image_position"].loc[place])
    assert away[4:8].max() < 8.0
    last = json.loads(again.attrs["provenance"])["steps"][-1]
    assert (last["points"], last["learn"]) == (["FR"], True)
    assert _frames_learnt_in(again) == {"FR": 4}


def change(folder, old, new, *, file="trial.toml"):
    path = folder / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_bad_input_is_one_sentence(small_trial):
    def refuse(kind=InputError, **options):
        with pytest.raises(kind) as caught:
            track(small_trial, **options)
        return str(caught.value)

    assert refuse(method="papr") == (
        "unknown method 'papr' (did you mean 'paper'?); expected pawnb, paper, slic-3d, slic-2d."
    )
    assert "unknown name 'medan_px' (did you mean 'median_px'?)" in refuse(
        method="paper", settings={"medan_px": "3"}
    )
    assert refuse(settings={"median_px": "3"}) == (
        "setting 'median_px' belongs to method 'paper', not to 'pawnb'; leave it out, or choose "
        "that method."
    )
    assert refuse(frames=(0, 41)) == (
        "frames 0 to 40 were asked for; the recording has frames 0 to 39: choose a range within."
    )
    assert refuse(frames=(5, 9)) == (
        "the start points were clicked in frame 0, outside frames 5 to 8; click a frame within, "
        "or change the range."
    )
    late = pd.concat([clicks_in(small_trial, frame) for frame in (0, 3, 8)])
    assert "were clicked in frame 8, outside frames 0 to 7;" in refuse(start=late, frames=(0, 8))
    change(small_trial, 'points = "start.csv"', 'pose = "pose.csv"')
    (small_trial / "start.csv").rename(small_trial / "other.csv")
    assert "has no start points; click them with pawnb.widgets.ClickInitialiser" in refuse()


def uncalibrated(folder):
    """Take the calibration out of a trial."""
    head, _, rest = (folder / "trial.toml").read_text().partition("[calibration]")
    (folder / "trial.toml").write_text(head + rest[rest.index("[start]") :])


def test_published_methods_in_space_need_a_calibration(small_trial):
    uncalibrated(small_trial)
    for method in ("paper", "slic-3d"):
        with pytest.raises(CalibrationError, match="has 4 views and no calibration; add"):
            track(small_trial, method=method)


@pytest.mark.slow
def test_without_a_calibration_points_of_several_views_keep_their_names(small_trial):
    uncalibrated(small_trial)
    tracks = track(small_trial, frames=(0, 20))
    assert tracks["keypoint"].to_numpy().tolist() == ["FR", "HR", "FL", "HL"]
    assert tracks["view"].to_numpy().tolist() == ["cam1", "cam2", "cam3", "cam4"]
    assert (tracks.sizes["space"], tracks.attrs["units"]) == (2, "px")
    start = pd.read_csv(small_trial / "start.csv")
    known = np.isfinite(tracks["image_position"]).all("image_space").any("time").squeeze()
    for view in ("cam1", "cam2", "cam3", "cam4"):
        clicked = set(start["point"][start["view"] == view])
        assert {p for p in ("FR", "HR", "FL", "HL") if known.sel(view=view, keypoint=p)} == clicked


# the animal is 87 mm from the nose to the base of the tail, an ear 11 mm wide
@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "away_mm", "yaw_deg"), [("paper", 11.0, 15.0), ("pawnb", 1.5, 3.0)]
)
def test_landmarks_are_tracked_beside_the_paws_and_give_the_bodys_angles(
    small_trial, method, away_mm, yaw_deg
):
    """Nose and ear besides the paws; truth is where the scene was drawn from."""
    names = ["ear_R", "nose"]
    start, truth = _with_landmarks(small_trial)
    tracks = track(small_trial, method=method, frames=(0, 8), start=start)
    for name in names:
        xyz = np.stack([truth.loc[(frame, name)].to_numpy() for frame in range(8)])
        place = tracks["position"].sel(keypoint=name).isel(individual=0).to_numpy()
        assert np.linalg.norm(place - xyz, axis=1).max() < away_mm, name
    true = body_angles(_with_positions(tracks, truth), along=names)
    found = body_angles(tracks, along=names)
    assert (found["yaw_deg"] - true["yaw_deg"]).abs().median() < yaw_deg


@pytest.mark.slow
def test_landmarks_are_tracked_before_their_click_too(small_trial):
    _, truth = _with_landmarks(small_trial)
    for _view in range(4):
        change(small_trial, '"ear_R", ', "")
    rig = load_rig(load_trial(small_trial))
    nose = rig.project(truth.loc[(7, "nose")].to_numpy()[None])[0]
    clicks = pd.DataFrame(
        [(7, view, "nose", *uv) for view, uv in zip(rig.names, nose, strict=True)],
        columns=["frame", "view", "point", "u", "v"],
    )
    done = []
    tracks = track(
        small_trial, frames=(0, 10), progress=lambda *step: done.append(step),
        settings={"evidence": "colour"}, start=pd.concat([clicks_in(small_trial, 7), clicks]),
    )  # fmt: skip
    place = tracks["position"].sel(keypoint="nose").isel(individual=0).to_numpy()
    true = np.stack([truth.loc[(frame, "nose")].to_numpy() for frame in range(10)])
    assert np.linalg.norm(place - true, axis=1).max() < 1.5  # as where it is clicked at first
    assert (tracks["origin"].sel(keypoint="nose") == ORIGIN_CODE["measured"])[:7].all()
    # the seven frames before are gone through once more
    assert done == [(k + 1, 17) for k in range(17)]


@pytest.mark.slow
def test_landmarks_leave_the_paws_alone_and_are_tracked_again(small_trial):
    paws = track(small_trial, frames=(0, 8))
    start, truth = _with_landmarks(small_trial)
    both = track(small_trial, frames=(0, 8), start=start)
    own = both.sel(keypoint=paws["keypoint"])
    np.testing.assert_array_equal(own["position"], paws["position"])
    np.testing.assert_array_equal(own["sd"], paws["sd"])
    assert (both["origin"].sel(keypoint="nose") != ORIGIN_CODE["missing"]).all()
    # put the nose elsewhere by hand, as the review does: it goes on from there
    trial = load_trial(small_trial)
    rig = load_rig(trial)
    moved = both.copy(deep=True)
    there = rig.project(truth.loc[(4, "ear_R")].to_numpy()[None])[0]
    for v, view in enumerate(rig.names):
        moved["image_position"].loc[{"view": view, "keypoint": "nose"}][4, :, 0] = there[v]
        moved["image_origin"].loc[{"view": view, "keypoint": "nose"}][4, 0] = ORIGIN_CODE["edited"]
    again = retrack(trial, moved, 4)
    nose = again["position"].sel(keypoint="nose").isel(individual=0).to_numpy()
    ear = np.stack([truth.loc[(frame, "ear_R")].to_numpy() for frame in range(8)])
    assert np.linalg.norm(nose - ear, axis=1)[5:].max() < 3.0
    np.testing.assert_array_equal(again["position"][:4], both["position"][:4])


def _with_landmarks(small_trial):
    """Let the views of a trial track nose and ear, too; return all start clicks, and the truth."""
    text = (small_trial / "trial.toml").read_text()
    for leg in ("HR", "HL"):
        text = text.replace(f'"{leg}",', f'"{leg}", "ear_R", "nose",')
    (small_trial / "trial.toml").write_text(text)
    truth = pd.read_csv(small_trial / "truth" / "landmarks3d.csv").set_index(["frame", "point"])
    rig = load_rig(load_trial(small_trial))
    rows = [
        (0, view, name, *rig.project(truth.loc[(0, name)].to_numpy()[None])[0, v])
        for name, views in (("nose", rig.names), ("ear_R", ("cam1", "cam2")))
        for v, view in enumerate(rig.names)
        if view in views
    ]
    clicks = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    start = pd.concat([pd.read_csv(small_trial / "start.csv"), clicks])
    return start, truth


def _with_positions(tracks, truth):
    """Tracks with the true positions of landmarks."""
    tracks = tracks.copy(deep=True)
    for name in ("ear_R", "nose"):
        xyz = [truth.loc[(frame, name)].to_numpy() for frame in tracks["frame"].to_numpy()]
        tracks["position"].loc[{"keypoint": name}] = np.array(xyz)[:, :, None]
    return tracks


@pytest.mark.slow
def test_each_of_several_views_is_tracked_by_itself_without_calibration(small_trial):
    """What slic-2d finds in the pictures does not depend on the calibration."""
    known = track(small_trial, method="slic-2d", frames=(0, 8))
    uncalibrated(small_trial)
    out = small_trial / "results"
    tracks = track(small_trial, method="slic-2d", frames=(0, 8), out=out)
    assert (tracks.sizes["space"], tracks.attrs["units"]) == (2, "px")
    for view, points in (("cam1", ["FR", "HR"]), ("cam4", ["FL", "HL"])):
        own = {"view": view, "keypoint": points}
        np.testing.assert_array_equal(
            tracks["image_position"].sel(own), known["image_position"].sel(own)
        )
    # the first view in which each point was clicked
    for view, point in (("cam1", "HR"), ("cam3", "FL")):
        np.testing.assert_array_equal(
            tracks["position"].sel(keypoint=point).to_numpy(),
            tracks["image_position"].sel(view=view, keypoint=point).to_numpy(),
        )
    again = retrack(load_trial(small_trial), tracks, 4)
    assert again.sizes == tracks.sizes
    assert read_tracks(out / "tracks.nc").sizes == tracks.sizes
    with pytest.raises(CalibrationError, match="by itself with method pawnb or slic-2d"):
        track(small_trial, method="paper")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pawnb.errors.QualityWarning")  # 3 frames: HR is lost
def test_one_view_needs_no_calibration(small_trial):
    text = (small_trial / "trial.toml").read_text()
    document, _, rest = text.partition("[[views]]")
    first = "[[views]]" + rest.partition("[[views]]")[0]
    tail = text[text.index("[start]") :]
    (small_trial / "trial.toml").write_text(document + first + tail)
    clicks = pd.read_csv(small_trial / "start.csv")
    clicks[clicks["view"] == "cam1"].to_csv(small_trial / "start.csv", index=False)
    tracks = track(small_trial, frames=(0, 3), out=small_trial / "results")
    assert tracks.sizes["space"] == 2
    assert tracks.attrs["units"] == "px"
    assert np.isfinite(tracks["position"]).all()
    # with a scale, the same positions in mm, also after tracking again
    with (small_trial / "trial.toml").open("a") as file:
        file.write('[calibration]\npx_per_unit = 2.0\nunit = "mm"\n')
    scaled = track(small_trial, frames=(0, 3))
    assert scaled.attrs["units"] == "mm"
    np.testing.assert_allclose(scaled["position"], tracks["position"] / 2)
    assert (tracks["sd"].attrs["units"], scaled["sd"].attrs["units"]) == ("px", "mm")
    np.testing.assert_allclose(scaled["sd"], tracks["sd"] / 2)
    again = retrack(load_trial(small_trial), scaled, 1)
    np.testing.assert_allclose(again["position"][:2], scaled["position"][:2])
    assert not (small_trial / "results" / "points3d.csv").exists()


def test_a_camera_along_the_path_tells_no_direction(rendered_trial):
    """A camera on the belt's axis sees the animal face neither left nor right."""
    along = np.array([0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0.0])  # u = y, v = -z
    side = np.array([1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0.0])  # u = x, v = -z
    rig = Rig(("side", "along"), np.stack([side, along], axis=1))
    assert view_facing(load_trial(rendered_trial), rig) == {"side": 1}


def test_time_follows_the_stamps_of_a_variable_rate(tmp_path):
    """Ten grey pictures, the fifth shown three times as long: a gap of 3 frames in time."""
    import av

    stamps = [0, 1, 2, 3, 4, 7, 8, 9, 10, 11]
    with av.open(str(tmp_path / "v.mkv"), "w") as container:
        stream = container.add_stream("ffv1", rate=100)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "gray"
        stream.codec_context.time_base = Fraction(1, 100)
        for stamp in stamps:
            picture = np.zeros((48, 64), np.uint8)
            picture[20:28, 20 + stamp : 28 + stamp] = 255
            frame = av.VideoFrame.from_ndarray(picture, format="gray")
            frame.pts, frame.time_base = stamp, Fraction(1, 100)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    (tmp_path / "start.csv").write_text("frame,view,point,u,v\n0,v,spot,24,24\n")
    (tmp_path / "trial.toml").write_text(
        '[trial]\nfps = 100\n[[views]]\nname = "v"\nvideo = "v.mkv"\n'
        '[start]\npoints = "start.csv"\n[tracking]\nscale = 0.2\nmedian_px = 1\n'
    )
    with pytest.warns(InputWarning, match=r"the frame rate varies"):
        tracks = track(tmp_path, method="paper")
    np.testing.assert_allclose(tracks["time"], np.array(stamps) / 100, atol=1e-9)


@pytest.mark.slow
def test_start_csv_beside_the_trial_is_found(small_trial):
    """The ClickInitialiser writes it there where the trial names no other file."""
    change(small_trial, '[start]\npoints = "start.csv"', "")
    tracks = track(small_trial, frames=(0, 2))
    assert "start.csv" in json.loads(tracks.attrs["provenance"])["steps"][0]["inputs"]


def test_frames_before_the_first_click_are_said_to_be_left_out(small_trial):
    clicks = pd.read_csv(small_trial / "start.csv")
    clicks["frame"] += 3  # paws move little in three frames
    with pytest.warns(InputWarning, match="frames 0 to 2 lie before the first click, in frame 3"):
        tracks = track(small_trial, method="slic-2d", start=clicks, frames=(0, 8))
    assert tracks["frame"].to_numpy().tolist() == [3, 4, 5, 6, 7]
