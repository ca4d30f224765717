"""A person's pose in Tracks: what it changes, and what it leaves."""

import numpy as np
import pytest
from walking_poses import uncertain_track, walking_poses

from pawnb.core.edits.log import EditLog, Move, Pose, Retrack, Swap
from pawnb.core.pose.as_tracks import poses_of, tracks_from_poses
from pawnb.core.pose.corrected import pose_values, posed_frames, put_pose
from pawnb.core.pose.poses import tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE

ANIMAL = load_species("spider")


@pytest.fixture
def tracks():
    track = uncertain_track(ANIMAL, walking_poses(ANIMAL, 12))
    return tracks_from_poses(ANIMAL, track, fps=125, view="top", px_per_unit=2.4, unit="mm")


def test_one_frame_takes_the_pose_and_the_others_stay(tracks):
    other = walking_poses(ANIMAL, 12).take(slice(9, 10))
    before = tracks.copy(deep=True)
    new = put_pose(tracks, 8, pose_values(ANIMAL, other))
    assert tracks.identical(before)
    assert new.drop_isel(time=3).identical(tracks.drop_isel(time=3))
    row = new.isel(time=3, individual=0)
    np.testing.assert_allclose(row["joint_angle"], other.angles_deg[0], atol=1e-4)
    tips = row["image_position"].sel(view="top", keypoint=list(ANIMAL.leg_names))
    np.testing.assert_allclose(tips.T, tip_positions(ANIMAL, other)[0], atol=1e-2)
    np.testing.assert_allclose(row["position"] * 2.4, row["image_position"].sel(view="top"))
    assert (row["origin"] == ORIGIN_CODE["edited"]).all()
    assert (row["confidence"] == 1).all()
    assert np.isnan(row["sd"]).all()
    assert np.isnan(row["joint_angle_sd"]).all()
    np.testing.assert_array_equal(posed_frames(new), [8])


def test_corrections_are_kept_in_the_file_and_made_again(tracks, tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(tracks, path, px_per_unit=2.4)
    pose = pose_values(ANIMAL, walking_poses(ANIMAL, 12).take(slice(9, 10)))
    log.apply(Pose(frame=8, pose=pose))
    assert EditLog(tracks, path, px_per_unit=2.4).tracks.identical(log.tracks)
    assert log.undo() == Pose(frame=8, pose=pose)
    assert log.tracks.identical(tracks)
    log.redo()
    np.testing.assert_array_equal(posed_frames(log.tracks), [8])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"L9_BC": 3.0}, "the animal has no 'L9_BC'"),
        ({"x": np.nan}, "x, y, heading or scale is not a number"),
        ({"L1_Fe_px": -1.0}, "expected px above 0"),
    ],
)
def test_a_pose_that_cannot_be_is_refused(tracks, change, sentence):
    values = pose_values(ANIMAL, walking_poses(ANIMAL, 1)) | change
    with pytest.raises(InputError, match=sentence):
        put_pose(tracks, 8, values)


def test_points_of_a_jointed_animal_are_not_moved_alone(tracks):
    """The angles would no longer be those of the points."""
    log = EditLog(tracks, px_per_unit=2.4)
    with pytest.raises(InputError, match="PoseReviewer"):
        log.apply(Move(frame=8, view="top", point="L1", u=3.0, v=4.0))
    with pytest.raises(InputError, match="frame 400 is not in the tracks"):
        log.apply(Pose(frame=400, pose=pose_values(ANIMAL, walking_poses(ANIMAL, 1))))
    with pytest.raises(InputError, match="no tracker was given"):
        log.apply(Retrack(frame=8))


def test_a_frame_without_the_animal_can_be_posed(tracks):
    missing = tracks.copy(deep=True)
    for name in missing.data_vars:
        values = missing[name].to_numpy()
        values[3] = ORIGIN_CODE["missing"] if name.endswith("origin") else np.nan
    new = put_pose(missing, 8, pose_values(ANIMAL, walking_poses(ANIMAL, 1)))
    assert np.isfinite(poses_of(new).poses.xy[3]).all()


def test_legs_exchanged_by_hand_stay_so_when_tracked_again(tracks, tmp_path):
    path = tmp_path / "edits.jsonl"

    def taken_back(_some, _frame):
        """A tracker that finds the legs where it found them at first."""
        return tracks.copy(deep=True)

    log = EditLog(tracks, path, px_per_unit=2.4, retrack=taken_back)
    log.apply(Swap(frame=8, first="L2", second="L3"))
    exchanged = log.tracks
    for frame in (8, 10, 6):
        log.apply(Retrack(frame=frame))
        for name in ("image_position", "joint_angle", "origin"):
            np.testing.assert_allclose(log.tracks[name], exchanged[name], atol=1e-6)
    assert (log.tracks["image_position"] != tracks["image_position"]).any()
    again = EditLog(tracks, path, px_per_unit=2.4, retrack=taken_back)
    np.testing.assert_allclose(again.tracks["joint_angle"], exchanged["joint_angle"], atol=1e-6)
    # who poses a leg where the other was has changed their mind
    as_found = poses_of(tracks).poses
    log.apply(Pose(frame=9, pose=pose_values(ANIMAL, as_found.take([4]))))
    log.apply(Retrack(frame=9))
    np.testing.assert_allclose(log.tracks["image_position"], tracks["image_position"], atol=1e-6)
