"""Pose tracks as Tracks and back, through netCDF and movement."""

import dataclasses

import numpy as np
import pytest
from walking_poses import uncertain_track, walking_poses

from pawnb.core.pose.as_tracks import animal_of, point_names, poses_of, tracks_from_poses
from pawnb.core.pose.poses import joint_positions, tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import join_tracks, plain_track
from pawnb.errors import InputError
from pawnb.io.movement import from_movement, to_movement
from pawnb.io.native import read_tracks, tracks_table, write_tracks
from pawnb.schema import ORIGIN_CODE, check_tracks, make_tracks


def _same(a, b):
    for field in dataclasses.fields(a):
        if field.name == "estimated":  # stands in the provenance
            continue
        left, right = getattr(a, field.name), getattr(b, field.name)
        if dataclasses.is_dataclass(left):
            _same(left, right)
        else:
            np.testing.assert_allclose(left, right, rtol=1e-12, err_msg=field.name)


@pytest.fixture(params=["dolomedes", "spider", "insect"])
def animal(request):
    return load_species(request.param)


@pytest.mark.parametrize("px_per_unit", [None, 2.4])
def test_poses_come_back_from_tracks_and_from_a_file(animal, tmp_path, px_per_unit):
    track = uncertain_track(animal, walking_poses(animal, 12))
    tracks = tracks_from_poses(
        animal, track, fps=125, view="top", px_per_unit=px_per_unit, unit="mm"
    )
    check_tracks(tracks)
    _same(poses_of(tracks), track)
    back = read_tracks(write_tracks(tracks, tmp_path / "tracks.nc"))
    _same(poses_of(back), track)
    assert animal_of(back) == animal
    for dims in ("plural", "singular"):
        there = to_movement(tracks, dims=dims)
        assert ("individuals" if dims == "plural" else "individual") in there["heading"].dims
        _same(poses_of(from_movement(there)), track)


def test_points_are_body_tips_and_joints_where_the_pose_puts_them():
    animal = load_species("dolomedes")
    poses = walking_poses(animal, 6)
    tracks = tracks_from_poses(
        animal, plain_track(animal, poses), fps=125, view="top", px_per_unit=4.0, unit="mm"
    )
    # 1 body, 8 tips, 8 legs of 7 joints
    assert len(point_names(animal)) == tracks.sizes["keypoint"] == 65
    image = tracks["image_position"].sel(view="top").isel(individual=0)
    np.testing.assert_allclose(image.sel(keypoint="body"), poses.xy)
    np.testing.assert_allclose(image.sel(keypoint="R3"), tip_positions(animal, poses)[:, 6])
    np.testing.assert_allclose(
        image.sel(keypoint="L2.PT"), joint_positions(animal, poses)[:, 1, 4], err_msg="5th joint"
    )
    np.testing.assert_allclose(tracks["position"].isel(individual=0) * 4.0, image)
    assert tracks.attrs["units"] == tracks["position"].attrs["units"] == "mm"
    table = tracks_table(tracks)
    assert len(table) == 6 * 65
    assert set(table["view"]) == {"top"}


def test_a_leg_that_is_missing_has_no_place_but_the_body_has():
    animal = load_species("dolomedes")
    poses = walking_poses(animal, 4)
    track = plain_track(animal, poses)
    track.origin[1:3, 2] = ORIGIN_CODE["missing"]
    tracks = tracks_from_poses(animal, track, fps=125, view="top").isel(individual=0)
    lost = tracks["position"].sel(keypoint=["L3", "L3.BC"]).isnull().all(("space", "keypoint"))
    assert lost.to_numpy().tolist() == [False, True, True, False]
    assert tracks["position"].sel(keypoint=["body", "L2"]).notnull().all()


def test_tracks_without_an_animal_are_refused():
    with pytest.raises(InputError, match="hold points only"):
        poses_of(make_tracks([0, 1], ["L1"], fps=10, views=["top"]))


def test_stretches_are_joined_and_taken_and_faults_are_named():
    animal = load_species("insect")
    track = uncertain_track(animal, walking_poses(animal, 10))
    _same(join_tracks([track.take(slice(0, 4)), track.take(slice(4, 10))]), track)
    with pytest.raises(InputError, match="do not ascend"):
        track.take(np.array([3, 2]))
    with pytest.raises(
        InputError, match=r"places_sd_px has shape .10, 6, 5, 2.; expected .10, 5, 5, 2."
    ):
        dataclasses.replace(track, confidence=track.confidence[:, :5], origin=track.origin)
