"""Doubts about tracked poses: each kind is found where it was put, and nowhere else."""

import numpy as np
import pytest
from walking_poses import uncertain_track, walking_poses

import pawnb
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.pose_suspects import (
    chances_of_crossing,
    chances_of_tips,
    find_pose_suspects,
    joints_beyond_range,
)
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.core.video.doubts.frozen_labels import without_frozen
from pawnb.schema import ORIGIN_CODE
from pawnb.workflow.reviewing.quality import next_step

ANIMAL = load_species("dolomedes")
LEGS = ANIMAL.leg_names


@pytest.fixture
def track():
    return plain_track(ANIMAL, walking_poses(ANIMAL, 60), confidence=0.9)


def _suspects(track):
    return find_pose_suspects(tracks_from_poses(ANIMAL, track, fps=125, view="top"))


def _joint(name):
    return ANIMAL.joints.index(name)


def test_a_walk_without_fault_has_no_suspects(track):
    assert len(_suspects(track)) == 0


def test_a_leg_that_the_picture_does_not_show(track):
    track.confidence[30, 2] = 0.1
    (row,) = _suspects(track).to_dict("records")
    assert (row["frame"], row["view"], row["point"]) == (35, "top", "L3")
    assert row["reason"] == "the picture hardly shows it (confidence 0.10)"


def test_a_film_that_stands_still_is_what_its_frames_are_doubted_for(track):
    """It was said that the picture hardly shows the legs; those after it were not doubted."""
    track.origin[39, LEGS.index("R1")] = ORIGIN_CODE["edited"]  # frames of the walk begin at 5
    tracks = tracks_from_poses(ANIMAL, track, fps=125, view="top")
    rows = find_pose_suspects(without_frozen(tracks, {"top": [(25, 40)]}))
    still, after = rows[rows["frame"] == 25], rows[rows["frame"] == 40]
    assert len(rows) == len(still) + len(after)
    assert sorted(still["point"]) == sorted(LEGS)
    reason = "the film stands still in frames 25 to 39: nothing is seen of it"
    assert set(still["reason"]) == {reason}
    assert sorted(after["point"]) == sorted(LEGS)
    assert set(after["reason"]) == {"the film stood still before, and legs may be exchanged"}


def test_a_joint_that_jumps_for_one_frame(track):
    track.poses.angles_deg[20, _joint("R2_CT")] += 40
    rows = _suspects(track)
    assert rows["point"].tolist()[0] == "R2"
    assert abs(rows["frame"].tolist()[0] - 25) <= 1
    assert rows["reason"].tolist()[0].startswith("a joint turns by 40 degrees")


def test_a_joint_beyond_its_range_in_all_frames(track):
    # Table 3.2 of Pullar 2009: TM of leg 1 has a whole range of 14 degrees
    track.poses.angles_deg[:, _joint("L1_TM")] = 7 + 25
    rows = _suspects(track)
    assert set(rows["point"]) == {"L1"}
    assert set(rows["reason"]) == {"a joint is 25 degrees beyond its range"}
    # frames that are listed lie apart
    assert np.diff(np.sort(rows["frame"])).min() >= 3
    assert joints_beyond_range(ANIMAL, track.poses.angles_deg[0]) == {"L1_TM": pytest.approx(25)}


@pytest.mark.parametrize(("confidence", "verdict"), [(1.0, "good"), (0.8, "good"), (0.1, "look")])
def test_the_verdict_follows_what_the_picture_shows_of_the_legs(confidence, verdict):
    # of a real fly 57 % of tips are right where nothing of a leg is seen, 85 % where hardly any is
    track = uncertain_track(ANIMAL, walking_poses(ANIMAL, 60))
    track.confidence[:] = confidence
    quality = pawnb.assess_quality(tracks_from_poses(ANIMAL, track, fps=125, view="top"))
    assert quality.verdict == verdict
    assert quality.expected_right == pytest.approx(float(chances_of_tips(np.array(confidence))))


def test_where_no_leg_is_seen_at_all_there_is_no_body_that_they_follow():
    # the 57 % above are of legs beside others that are seen; here the whole animal is lost
    track = uncertain_track(ANIMAL, walking_poses(ANIMAL, 60))
    track.confidence[:] = 0.0
    quality = pawnb.assess_quality(tracks_from_poses(ANIMAL, track, fps=125, view="top"))
    assert (quality.verdict, quality.expected_right) == ("failed", 0.0)


def test_a_leg_that_is_hidden_for_long_is_told_in_the_verdict():
    track = uncertain_track(ANIMAL, walking_poses(ANIMAL, 60))
    track.confidence[:] = 1.0
    track.confidence[:40, 2] = 0.0
    quality = pawnb.assess_quality(tracks_from_poses(ANIMAL, track, fps=125, view="top"))
    assert quality.poor_points == ("L3",)
    assert "the tracker is not sure of L3 in 67 % of frames" in quality.line()
    after = next_step(quality, "results", of_poses=True)
    assert after == "review (pawnb.widgets.PoseReviewer), then pawnb gait results"


def test_legs_on_each_others_place_are_told_where_the_method_is_sure_of_them(track):
    """The method of 2009 makes pixels along a leg subject by its shape prior: it is always sure.

    Of a rendered spider legs had changed places in 156 of 164 frames, and the verdict was "good".
    """
    track.confidence[:] = 1.0
    apart = pawnb.assess_quality(tracks_from_poses(ANIMAL, track, fps=125, view="top"))
    assert apart.verdict == "look"  # nothing tells that it is right
    first, last = _joint("L1_BC"), _joint("L4_BC")
    angles = track.poses.angles_deg
    angles[:, [first, last]] = angles[:, [last, first]]
    tracks = tracks_from_poses(ANIMAL, track, fps=125, view="top")
    assert (chances_of_crossing(tracks) < 0.5).any(axis=0).tolist() == [
        False, True, True, True, True, False, False, False, False,
    ]  # fmt: skip
    quality = pawnb.assess_quality(tracks)
    assert {p.name for p in quality.points if p.verdict == "failed"} >= {"L1", "L4"}
    assert quality.expected_right < apart.expected_right - 0.1


def test_legs_that_cross(track):
    track.poses.angles_deg[10:12, _joint("L2_BC")] += 24
    track.poses.angles_deg[10:12, _joint("L1_BC")] -= 24
    rows = _suspects(track)
    crossed = rows[rows["reason"].str.contains("crosses another leg")]
    assert set(crossed["point"]) == {"L1", "L2"}
    assert set(crossed["frame"]) <= {15, 16}


def test_a_tip_that_is_only_vaguely_known():
    track = uncertain_track(ANIMAL, walking_poses(ANIMAL, 40))
    track.confidence[:] = 1.0
    track.places_sd_px[:] = 0.5
    track.places_sd_px[7, 5, 7] = 6.0
    (row,) = _suspects(track).to_dict("records")
    assert (row["frame"], row["point"]) == (12, "R2")
    assert row["reason"] == "its tip is only known to 8.5 px"  # 6 px in u and in v


def test_what_a_person_placed_is_not_doubted(track):
    track.confidence[30, 2] = 0.1
    track.origin[30, 2] = ORIGIN_CODE["edited"]
    assert len(_suspects(track)) == 0
