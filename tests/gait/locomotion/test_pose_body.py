"""Gait of a jointed animal: leg angles of its pose, AEP and PEP against rendered truth."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb import gait
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.poses import leg_angles
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.gait.joints import get_joint_angles
from pawnb.gait.locomotion.foot_trajectories import get_foot_paths
from pawnb.gait.locomotion.grid import put_on_grid
from pawnb.gait.locomotion.pose_body import pose_body
from pawnb.synthetic import render_spider_trial, spider_trial
from pawnb.trial import load_trial


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return trial, animal and true poses of a running spider; nobody looks at pictures."""
    folder = tmp_path_factory.mktemp("run")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spider_trial, "render_video", lambda path, *_, **__: path.touch())
        render_spider_trial(folder, frames=110, scale=0.1, seed=1)
    trial = load_trial(folder)
    animal, poses = read_start_pose(folder / "truth" / "pose.csv", load_species("dolomedes"))
    return trial, animal, poses


def _tracks(trial, animal, poses, **options):
    return tracks_from_poses(animal, plain_track(animal, poses), fps=125, view="top", **options)


@pytest.mark.parametrize("options", [{}, {"px_per_unit": 0.484, "unit": "mm"}])
def test_leg_angles_are_those_of_the_stick_animal(run, options):
    _, animal, poses = run
    _, dense = put_on_grid(_tracks(*run, **options), where="here")
    (feet,) = get_foot_paths(dense, {leg: leg for leg in animal.leg_names})
    body, posed = pose_body(dense, feet, individual="animal")
    np.testing.assert_allclose(posed.angle_deg, leg_angles(animal, poses), atol=1e-9)
    np.testing.assert_allclose(body.points[:, :, 0], poses.xy / options.get("px_per_unit", 1.0))
    direction = np.diff(body.points, axis=2)[:, :, 0]
    turn = np.degrees(np.arctan2(direction[:, 1], direction[:, 0])) - poses.heading_deg
    np.testing.assert_allclose((turn + 180) % 360, 180, atol=1e-9)


@pytest.mark.slow
def test_events_are_within_a_fraction_of_a_frame_of_the_truth(run):
    trial, *_ = run
    tables = gait.analyse(_tracks(*run, px_per_unit=0.484, unit="mm"), trial=trial)
    events = tables.events[tables.events["event"].isin(["AEP", "PEP"])]
    assert set(events["method"]) == {"leg angle"}
    truth = pd.read_csv(trial.folder / "truth" / "events.csv")
    errors = []
    for row in truth[truth["frame"] < 104].itertuples():  # the last turns need frames after them
        own = events[(events["leg"] == row.leg) & (events["event"] == row.event)]["frame"]
        errors.append(np.abs(own - row.frame).min())
    assert len(errors) > 30
    assert np.median(errors) < 0.1
    assert max(errors) < 0.3
    phases = pd.read_csv(trial.folder / "truth" / "phases.csv")
    pairs = set(zip(phases["leg"], phases["reference"], strict=True))
    assert set(zip(tables.phases["leg"], tables.phases["reference"], strict=True)) >= pairs
    assert (
        len(set(zip(tables.phase_summary["leg"], tables.phase_summary["reference"], strict=True)))
        == 16
    )


@pytest.mark.slow
def test_speed_is_that_of_the_body_in_real_units(run):
    trial, _, poses = run
    tables = gait.analyse(_tracks(*run, px_per_unit=0.484, unit="mm"), trial=trial)
    way = np.linalg.norm(np.diff(poses.xy, axis=0), axis=1).sum() / 0.484
    speed = way / ((len(poses) - 1) / 125)
    assert tables.strides["speed"].median() == pytest.approx(speed, rel=0.1)
    assert (tables.strides["aep_position"] > tables.strides["pep_position"]).all()


@pytest.mark.slow
def test_points_alone_are_analysed_by_position(run):
    trial, *_ = run
    tables = gait.analyse(_tracks(*run).drop_vars("heading"), trial=trial)
    with pytest.raises(InputError, match="hold no pose"):
        gait.leg_angles(_tracks(*run).drop_vars("heading"))
    assert all("fore-aft" in m for m in tables.events["method"] if "foot speed" not in m)


def test_leg_angles_are_a_table(run):
    _, animal, poses = run
    table = gait.leg_angles(_tracks(*run))
    assert list(table.columns) == ["frame", "time_s", "leg", "leg_angle"]
    wide = table.pivot_table(index="frame", columns="leg", values="leg_angle")[
        list(animal.leg_names)
    ]
    np.testing.assert_allclose(wide, leg_angles(animal, poses), atol=1e-9)
    assert table["time_s"].iloc[0] == poses.frames[0] / 125


@pytest.mark.slow
def test_the_joint_at_the_body_is_found_whatever_a_species_file_calls_it(run):
    """An insect's is ThC: without it the body was the mean of the feet, and nothing said so."""
    trial, *_ = run
    tracks = _tracks(*run, px_per_unit=0.484, unit="mm")
    named = {
        what: [str(name).replace("BC", "ThC") for name in tracks[what].to_numpy()]
        for what in ("keypoint", "joint")
    }
    other = tracks.assign_coords(named)
    expected, found = (gait.analyse(some, trial=trial).events for some in (tracks, other))
    assert set(found["method"]) == set(expected["method"])
    np.testing.assert_allclose(found["frame"], expected["frame"])
    pd.testing.assert_frame_equal(gait.leg_angles(other), gait.leg_angles(tracks))
    assert "ThC" in set(get_joint_angles(other)["joint"])
    assert len(get_joint_angles(other)) == len(get_joint_angles(tracks))


def test_a_heading_across_the_wrap_is_interpolated_where_time_stamps_are_uneven(run):
    """The body turns five times a second: from one frame to the next by 16 degrees."""
    tracks = _tracks(*run)
    uneven = tracks["time"].to_numpy() + 0.3 / 125 * (np.arange(tracks.sizes["time"]) % 2)
    heading = (2000.0 * uneven + 180) % 360 - 180
    tracks = tracks.assign(heading=(("time", "individual"), heading[:, None]))
    grid, dense = put_on_grid(tracks.assign_coords(time=uneven), where="here")
    off = (dense["heading"].to_numpy()[:, 0] - 2000.0 * grid.time_s + 180) % 360 - 180
    assert np.abs(off).max() < 0.5
