"""Where an animal comes into the picture, legs that nobody saw make no steps."""

import numpy as np
import pytest
import xarray as xr

from pawnb import gait
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.core.video.doubts.frozen_labels import without_frozen
from pawnb.gait.joints import get_joint_angles, joint_range_table
from pawnb.gait.locomotion.seen_part import seen_part
from pawnb.io.formats import read_any_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.synthetic import render_spider_trial, spider_trial
from pawnb.trial import load_trial

N_UNSEEN = 7


@pytest.fixture(scope="module")
def entering(tmp_path_factory):
    """True poses of a spider, the first seven as tracked where three legs only are in view.

    Gives trial, true tracks, and those in which the other legs are swung about, as was seen.
    """
    folder = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spider_trial, "render_video", lambda path, *_, **__: path.touch())
        render_spider_trial(folder, frames=110, scale=0.1, seed=1)
    animal, poses = read_start_pose(folder / "truth" / "pose.csv", load_species("dolomedes"))
    true = tracks_from_poses(
        animal, plain_track(animal, poses), fps=125, view="top", px_per_unit=0.484, unit="mm"
    )
    poses.angles_deg[:N_UNSEEN] += np.linspace(160.0, 0.0, N_UNSEEN)[:, None]
    origin = np.full((len(poses), 8), ORIGIN_CODE["measured"], dtype=np.int8)
    origin[:N_UNSEEN, 3:] = ORIGIN_CODE["predicted"]
    track = plain_track(animal, poses, origin=origin)
    tracks = tracks_from_poses(animal, track, fps=125, view="top", px_per_unit=0.484, unit="mm")
    return load_trial(folder), true, tracks


@pytest.mark.slow
def test_where_few_legs_are_seen_nothing_steps(entering):
    trial, true, tracks = entering
    expected = gait.analyse(true.isel(time=slice(N_UNSEEN, None)), trial=trial)
    found = gait.analyse(tracks, trial=trial)
    assert found.events["frame"].tolist() == pytest.approx(expected.events["frame"].tolist())
    left_out = found.dropped[found.dropped["what"] == "frames"]
    assert left_out["why"].tolist() == ["fewer than half of the legs are seen"]
    times = tracks["time"].to_numpy()[[0, N_UNSEEN - 1]]
    assert left_out[["start_s", "end_s"]].to_numpy().tolist() == [times.tolist()]


@pytest.mark.slow
def test_no_stride_reaches_over_a_film_that_stood_still(entering):
    """The pose is held for 15 frames, about a stride: strides were twice as long as they are."""
    trial, true, _ = entering
    true = true.isel(time=slice(N_UNSEEN, None))
    held = true.copy(deep=True)
    for name in ("position", "image_position", "joint_angle"):
        held[name].values[40:55] = held[name].values[39]
    frozen = without_frozen(held, {"top": [tuple(held["frame"].to_numpy()[[40, 55]])]})
    longest = gait.analyse(true, trial=trial).strides["period_s"].max()
    found = gait.analyse(frozen, trial=trial)
    assert gait.analyse(held, trial=trial).strides["period_s"].max() > 1.5 * longest
    assert found.strides["period_s"].max() < 1.1 * longest
    time = held["time"].to_numpy()
    left_out = found.dropped[found.dropped["what"] == "track"]
    assert len(left_out) == 8
    assert (left_out["start_s"] <= time[40]).all()
    assert (left_out["end_s"] >= time[54]).all()
    # joint angles leave those frames out too
    angles = get_joint_angles(frozen).groupby(["leg", "joint"])["angle_deg"].count()
    assert (angles == len(time) - 15).all()


def test_greatest_joint_angles_are_of_the_animal_in_view(entering):
    _, true, tracks = entering
    tables = [
        joint_range_table(get_joint_angles(some))
        for some in (true.isel(time=slice(N_UNSEEN, None)), tracks)
    ]
    np.testing.assert_allclose(tables[1]["max_mean_deg"], tables[0]["max_mean_deg"])


def test_legs_hidden_in_between_and_poses_by_hand_stay(entering):
    _, _, tracks = entering
    part, dropped = seen_part(tracks)
    assert int(part["frame"][0]) == int(tracks["frame"][N_UNSEEN])
    assert len(dropped) == 1
    hidden = part.copy(deep=True)
    hidden["origin"].values[10:20] = ORIGIN_CODE["predicted"]
    assert seen_part(hidden)[0].sizes["time"] == part.sizes["time"]
    posed = tracks.copy(deep=True)
    posed["origin"].values[2] = ORIGIN_CODE["edited"]
    assert int(seen_part(posed)[0]["frame"][0]) == int(tracks["frame"][2])
    nothing = tracks.copy(deep=True)
    nothing["origin"].values[:] = ORIGIN_CODE["predicted"]
    assert seen_part(nothing)[0].sizes["time"] == tracks.sizes["time"]


@pytest.mark.slow
def test_each_of_several_animals_is_seen_for_a_time_of_its_own(entering):
    """The one that stays kept the other's frames in which nothing of it is in the picture."""
    trial, true, tracks = entering
    both = xr.concat(
        [true.assign_coords(individual=["stays"]), tracks.assign_coords(individual=["comes"])],
        dim="individual", data_vars="minimal", combine_attrs="override",
    )  # fmt: skip
    alone = gait.analyse(tracks, trial=trial)
    found = gait.analyse(both, trial=trial)
    events = found.events[found.events["animal"] == "comes"]
    assert events["frame"].tolist() == pytest.approx(alone.events["frame"].tolist())
    left_out = found.dropped[found.dropped["what"] == "frames"]
    assert left_out["animal"].tolist() == ["comes"]
    np.testing.assert_allclose(
        joint_range_table(get_joint_angles(both, animal="comes"))["max_mean_deg"],
        joint_range_table(get_joint_angles(tracks))["max_mean_deg"],
    )


@pytest.mark.slow
def test_a_leg_out_of_sight_by_itself_at_an_end_makes_no_steps_there(entering):
    trial, true, _ = entering
    n, places = 40, [str(point) for point in true["keypoint"].to_numpy()]
    hidden = true.copy(deep=True)
    hidden["origin"].values[-n:, places.index("R2")] = ORIGIN_CODE["predicted"]
    expected, found = (gait.analyse(some, trial=trial) for some in (true, hidden))
    last_s = float(true["time"][-n])
    steps = found.events[found.events["leg"] == "R2"]
    assert len(steps) > 0
    assert steps["time_s"].max() < last_s
    of_others = [some.events[some.events["leg"] != "R2"]["frame"] for some in (expected, found)]
    np.testing.assert_allclose(*of_others)
    said = found.dropped[found.dropped["why"] == "the leg is not seen"]
    assert said[["leg", "start_s"]].to_numpy().tolist() == [["R2", pytest.approx(last_s)]]
    angles = get_joint_angles(hidden)
    lost = {
        leg: (get_joint_angles(true)["leg"] == leg).sum() - (angles["leg"] == leg).sum()
        for leg in ("R2", "L2")
    }
    assert lost == {"R2": n * 5, "L2": 0}
    # nothing of what was given is changed
    assert np.isfinite(hidden["position"].values[:, :, places.index("R2")]).all()


def test_points_have_no_position_where_every_foot_is_predicted_without_confidence():
    """A snout that is still seen keeps no foot in place; one foot that is seen keeps the frame."""
    tracks = make_tracks(range(10), ["FR", "FL", "snout"], fps=100.0, views=["side"])
    for name, value in (("confidence", 0.9), ("origin", ORIGIN_CODE["measured"])):
        tracks[name][:] = value
    tracks["position"][:] = 1.0
    tracks["origin"].loc[{"keypoint": ["FR", "FL"]}] = ORIGIN_CODE["predicted"]
    tracks["confidence"][3:6] = 0.0
    tracks["origin"][5, 0] = ORIGIN_CODE["edited"]
    part, dropped = seen_part(tracks, feet=["FR", "FL"])
    is_there = np.isfinite(part["position"].sel(keypoint=["FR", "FL"])).all(axis=(1, 2, 3))
    assert np.flatnonzero(~is_there).tolist() == [3, 4]
    assert dropped == []
    assert seen_part(tracks)[0] is tracks


@pytest.mark.parametrize("least", [0.0, 0.6])
def test_ends_without_any_foot_are_left_out_and_said(least):
    tracks = make_tracks(range(20), ["FR", "FL", "nose"], fps=100.0, space=("x", "y"), unit="px")
    tracks["position"].data[:] = 1.0
    tracks["confidence"].data[:] = 1.0
    if least:  # a program that gives a place in every frame
        tracks["confidence"].data[:4, :2] = tracks["confidence"].data[15:, :2] = 0.3
    else:
        tracks["position"].data[:4, :, :2] = tracks["position"].data[15:, :, :2] = np.nan
    tracks["position"].data[8:11, :, :2] = np.nan  # hidden for a while
    part, dropped = seen_part(tracks, feet=["FR", "FL"], least=least)
    assert part["frame"].to_numpy().tolist() == list(range(4, 15))
    assert [(row["start_s"], row["end_s"], row["why"]) for row in dropped] == [
        (0.0, 0.03, "no foot is seen"), (0.15, 0.19, "no foot is seen"),
    ]  # fmt: skip
    # one foot that is there is enough, and what is hardly there at all stays as it is
    tracks["position"].data[0, :, 1] = 1.0
    tracks["confidence"].data[0, 1] = 1.0
    assert int(seen_part(tracks, feet=["FR", "FL"], least=least)[0]["frame"][0]) == 0
    tracks["position"].data[1:] = np.nan
    assert seen_part(tracks, feet=["FR", "FL"], least=least)[0].sizes["time"] == 20


@pytest.mark.parametrize(("before", "after"), [(500, 0), (0, 500), (7, 50)])
def test_the_film_before_and_after_a_real_mouse_changes_no_stride(real_data, before, after):
    # a mouse on a beam (DeepLabCut); periods changed by up to 0.6 %, stride lengths by up to 5.5 %
    (path,) = (real_data("mouse-autogaita-beam")).glob("*Mouse15*SIMI*.csv")
    tracks = read_any_tracks(path, fps=100.0)
    n = tracks.sizes["time"]
    frames = np.arange(before + n + after)
    longer = make_tracks(
        frames, [str(p) for p in tracks["keypoint"].to_numpy()], fps=100.0, unit="px",
        space=("x", "y"),
    )  # fmt: skip
    longer.attrs |= tracks.attrs
    for name in ("position", "confidence"):
        longer[name].data[before : before + n] = tracks[name].transpose(*longer[name].dims).data
    legs = {"FR": "Front paw tao", "HR": "Hind paw tao"}
    strides, same = (gait.analyse(one, legs=legs).strides for one in (tracks, longer))
    assert len(strides) == len(same) >= 10
    np.testing.assert_allclose(same["start_s"] - before / 100.0, strides["start_s"], atol=1e-9)
    columns = ["period_s", "duty_factor", "contact_duty_factor", "stride_length", "aep_position"]
    np.testing.assert_allclose(same[columns], strides[columns], rtol=1e-9)
