"""A jointed animal with a second view: its joints in space, and what is refused."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest

from pawnb import gait
from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.corrected import pose_values, put_pose
from pawnb.core.pose.poses import leg_angles
from pawnb.core.pose.space import pipeline
from pawnb.core.video import open_views
from pawnb.errors import CalibrationError, InputError, InputWarning
from pawnb.io.native import read_tracks, tracks_table
from pawnb.schema import POINTS3D_COLUMNS
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking.methods import settings_in_force, space_settings, tracker_settings
from pawnb.workflow.tracking.pose import retrack_pose
from pawnb.workflow.tracking.pose.pose_in_space import load_second
from pawnb.workflow.tracking.pose.track_pose import pose_views
from pawnb.workflow.tracking.track import retrack, track

pytestmark = pytest.mark.slow  # scenes are rendered and tracked


@pytest.fixture(scope="module")
def two_views(tmp_path_factory):
    """Return a trial of a running spider seen from above and, through a mirror, from the side."""
    folder = tmp_path_factory.mktemp("two")
    render_spider_trial(folder, frames=56, scale=0.4, seed=3, views=2)
    return folder


@pytest.fixture(scope="module")
def found(two_views, tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    return track(two_views, out=out), out


def test_joints_and_tips_are_near_the_truth_in_space(found, two_views):
    """Medians within 1 % of the leg span, nineteen of twenty within 5 %."""
    tracks, out = found
    table = pd.read_csv(out / "points3d.csv")
    assert tuple(table.columns) == POINTS3D_COLUMNS
    truth = pd.read_csv(two_views / "truth" / "points3d.csv")
    both = table.merge(truth, on=["frame", "point"], suffixes=("", "_true"))
    assert len(both) == 65 * tracks.sizes["time"] > 65 * 10
    off = np.sqrt(sum((both[c] - both[f"{c}_true"]) ** 2 for c in "xyz"))
    span = 60.0  # mm, of this small individual's legs
    tips = both["point"].str.len() == 2
    for which in (tips, ~tips):
        assert off[which].median() < 0.01 * span
        assert off[which].quantile(0.95) < 0.05 * span
    assert off[both["point"] == "body"].max() < 0.02 * span


def test_tracks_hold_both_views_and_the_pose_of_the_first(found, two_views):
    tracks, out = found
    assert tracks.attrs["units"] == "mm"
    assert tracks.sizes["space"] == 3
    assert tracks["view"].to_numpy().tolist() == ["top", "side"]
    assert read_tracks(out / "tracks.nc").identical(tracks)
    seen = pd.read_csv(out / "tracks.csv")
    truth = pd.read_csv(two_views / "truth" / "tracks.csv")
    both = seen.merge(truth, on=["frame", "view", "point"], suffixes=("", "_true"))
    off = np.hypot(both["u"] - both["u_true"], both["v"] - both["v_true"])
    assert off.groupby(both["view"]).median().max() < 1.5
    assert (tracks["sd"].to_numpy() > 0).mean() > 0.95
    # the pose is that of the first view: its numbers are px of it
    poses = poses_of(tracks)
    image = tracks["image_position"].sel(view="top", keypoint="body").to_numpy()[..., 0]
    np.testing.assert_allclose(poses.poses.xy, image)
    assert poses.confidence.shape == (tracks.sizes["time"], 8)
    (step,) = json.loads((out / "provenance.json").read_text())["steps"]
    assert step["second_view"] == "side"
    assert "DLTcoefs.csv" in step["inputs"]


def test_joints_in_space_correct_the_pose_of_the_first_view(found, two_views):
    """From above, where along a straight leg its joints lie shows poorly.

    Inner joints of all legs, in 56 frames, were 0.59 px off at the median, and 0.38 px with it.
    """
    tracks, _ = found
    alone = track(two_views, settings={"space.correct_first": "false"})
    truth = pd.read_csv(two_views / "truth" / "tracks.csv").query("view == 'top'")
    inner = truth[truth["point"].str.contains("[.](?:CT|PT|TM)$")]
    off = {}
    for name, some in (("corrected", tracks), ("alone", alone)):
        seen = tracks_table(some.sel(view=["top"]))
        both = seen.merge(inner, on=["frame", "view", "point"], suffixes=("", "_true"))
        off[name] = np.hypot(both["u"] - both["u_true"], both["v"] - both["v_true"]).median()
    assert off["corrected"] < 0.8 * off["alone"]
    settings = [json.loads(t.attrs["provenance"])["steps"][0]["settings"] for t in (tracks, alone)]
    assert [one["space"]["correct_first"] for one in settings] == [True, False]


def test_leg_angles_of_gait_are_those_of_the_pose(found):
    tracks, _ = found
    table = gait.leg_angles(tracks)

    own = leg_angles(animal_of(tracks), poses_of(tracks).poses)
    for number, leg in enumerate(animal_of(tracks).leg_names):
        angle = table.loc[table["leg"] == leg, "leg_angle"]
        np.testing.assert_allclose(angle, own[:, number], atol=1e-6)


def test_tracking_again_finds_joints_in_space_in_the_touched_stretch_alone(
    found, two_views, monkeypatch
):
    """Leg L2 is put 40 degrees off in four frames, then right in one of them."""
    tracks, _ = found
    animal, poses = animal_of(tracks), poses_of(tracks)
    numbers = poses.poses.frames
    wrong = tracks
    for row in range(16, 20):
        angles = poses.poses.angles_deg[row : row + 1].copy()
        angles[0, animal.joints.index("L2_BC")] += 40.0
        bent = dataclasses.replace(poses.poses.take([row]), angles_deg=angles)
        wrong = put_pose(wrong, int(numbers[row]), pose_values(animal, bent))
    wrong["image_origin"][:], wrong["origin"][:] = tracks["image_origin"], tracks["origin"]
    wrong["position"][16:20] = np.nan
    wrong = put_pose(wrong, int(numbers[18]), pose_values(animal, poses.poses.take([18])))
    settled, plain = set(), pipeline._with_neighbours

    def with_neighbours(state, k):
        settled.add(int(state.recording.numbers[k]))
        return plain(state, k)

    monkeypatch.setattr(pipeline, "_with_neighbours", with_neighbours)
    monkeypatch.setattr(retrack_pose, "_FRAMES_BESIDE", 3)
    again = retrack(load_trial(two_views), wrong, int(numbers[18]))
    begin, end = provenance_steps(again)[-1]["frames"]
    assert begin <= numbers[16]
    assert numbers[19] < end
    assert settled == set(range(begin - 3, end + 3)) & set(numbers)
    assert len(settled) < len(numbers)
    outside = (numbers < begin) | (numbers >= end)
    assert again["position"][outside].identical(wrong["position"][outside])
    # 60 mm of leg span: the same places again, where leg L2 had been off and nothing in space known
    off = (again["position"] - tracks["position"]).to_numpy()[16:18]
    assert np.abs(off).max() < 1.0


def test_joints_in_space_go_on_where_they_were_stopped(found, two_views, tmp_path, monkeypatch):
    whole, _ = found
    taken, fitted = [], []
    take_over, alone = pipeline._take_over, pipeline._alone

    def take_over_too(state, k, other):
        taken.append(k)
        return take_over(state, k, other)

    def alone_too(state, k):
        fitted.append(k)
        return alone(state, k)

    monkeypatch.setattr(pipeline, "_take_over", take_over_too)
    monkeypatch.setattr(pipeline, "_alone", alone_too)
    part = track(two_views, out=tmp_path, stop=lambda: len(taken) >= 8)
    n = whole.sizes["time"]
    assert part.sizes["time"] == n
    assert not provenance_steps(part)[-1]["complete"]
    assert np.isfinite(part["position"].sel(keypoint="body")).all()
    assert len(taken) == 8
    assert len(fitted) == 3 * 16 + n
    taken.clear()
    fitted.clear()
    with pytest.warns(InputWarning, match=f"{n} of 56 frames were found before"):
        again = track(two_views, out=tmp_path)
    assert len(fitted) == 3 * 16  # what the model is learnt from
    assert len(taken) == 2 * n - 8
    assert again.identical(whole)


def test_a_second_view_without_calibration_is_told(small_spider):
    trial = load_trial(small_spider)
    (view,) = trial.views
    assert pose_views(trial) == (view, None)
    two = (view, dataclasses.replace(view, name="side"))
    with pytest.raises(InputError, match="has a second view, 'side', but no calibration"):
        track(dataclasses.replace(trial, views=two, calibration=None))
    three = (*two, dataclasses.replace(view, name="front"))
    with pytest.raises(InputError, match="has 3 views; a pose is tracked in one view"):
        track(dataclasses.replace(trial, views=three))


def test_settings_of_space_are_checked(two_views, small_spider):
    trial = load_trial(two_views)
    written = dataclasses.replace(trial, tracking={"space": {"length_sd": 0.05}, "candidates": 3})
    assert space_settings(written).length_sd == 0.05
    assert space_settings(written, settings={"space.length_sd": "0.1"}).length_sd == 0.1
    assert tracker_settings(written, settings={"space.bend_sd": 2}).candidates == 3
    assert settings_in_force(written, method="pawnb")["space"]["length_sd"] == 0.05
    assert "space" not in settings_in_force(load_trial(small_spider), method="pawnb")
    with pytest.raises(InputError, match=r"unknown name 'lenght_sd' .did you mean 'length_sd'"):
        track(trial, settings={"space.lenght_sd": "0.1"})
    with pytest.raises(InputError, match="is about a second view, but trial"):
        track(small_spider, settings={"space.length_sd": "0.1"})


def test_two_views_of_one_direction_are_refused_before_tracking(tmp_path):
    render_spider_trial(tmp_path, frames=14, scale=0.1, seed=2, views=2, motion="still")
    coefs = np.loadtxt(tmp_path / "DLTcoefs.csv", delimiter=",")
    assert "second view side" in check_trial(tmp_path).text()
    np.savetxt(tmp_path / "DLTcoefs.csv", coefs[:, [0, 0]], delimiter=",")
    trial = load_trial(tmp_path)
    with open_views(trial) as views, pytest.raises(CalibrationError, match="nearly the same dir"):
        load_second(trial, views)
    assert "nearly the same direction" in check_trial(tmp_path).text()
