"""The verdict on poses that lie well on something dark, and on the wrong legs."""

from __future__ import annotations

import dataclasses
import json

import pandas as pd
import pytest

import pawnb
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.doubts.limbs_left_over import LIMBS_LEFT_OVER, left_over_of
from pawnb.core.pose.poses import join_poses, natural_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.core.video import open_views
from pawnb.workflow.start.propose_pose import trial_background
from pawnb.workflow.tracking.pose.left_over import with_left_over


@pytest.fixture
def started(small_spider):
    """Return the trial and its start pose, which is the truth."""
    return pawnb.load_trial(small_spider), pd.read_csv(small_spider / "start_pose.csv")


@pytest.mark.slow
def test_legs_that_are_right_leave_nothing_over(started):
    trial, _ = started
    tracks = pawnb.track(trial, frames=(10, 16))
    assert left_over_of(tracks) < 0.2
    assert pawnb.assess_quality(tracks).verdict == "good"


@pytest.mark.slow
def test_a_leg_that_was_taken_for_missing_is_said(started):
    """Its neighbours went onto its place, and the verdict was *good*."""
    trial, start = started
    start["L2_scale"] = 0.0
    tracks = pawnb.track(trial, start=start, frames=(10, 16))
    quality = pawnb.assess_quality(tracks)
    assert quality.verdict == "look"
    assert "lie on no leg of the stick animal" in quality.line()


@pytest.mark.slow
def test_a_correction_that_is_tracked_looks_anew_what_is_left_over(started):
    trial, _ = started
    tracks = pawnb.track(trial, frames=(10, 16))
    stale = tracks.assign_attrs({LIMBS_LEFT_OVER: json.dumps({str(f): 2.0 for f in range(10, 16)})})
    assert pawnb.assess_quality(stale).verdict == "look"
    again = pawnb.retrack(trial, stale, 12)
    assert pawnb.assess_quality(again).verdict == "good"
    assert left_over_of(again) == left_over_of(tracks)


def test_frames_that_were_not_tracked_again_keep_what_was_found(started):
    trial, _ = started
    tracks = tracks_of(load_species("dolomedes"), RUN, heading=0.0)
    tracks = tracks.assign_attrs({LIMBS_LEFT_OVER: json.dumps({"0": 3.0, "1": 2.0, "2": 1.0})})
    with open_views(trial) as views:
        reader, background = views.readers["top"], trial_background(trial, views)
        made = with_left_over(tracks, reader=reader, background=background, again=range(2, 3))
    kept = json.loads(made.attrs[LIMBS_LEFT_OVER])
    assert (kept["0"], kept["1"]) == (3.0, 2.0)
    assert "2" not in kept  # nothing is seen there: the scene is empty up to frame 9


def tracks_of(animal, places, *, heading):
    """Return tracks of natural poses, of which each leg is surely on something dark."""
    poses = join_poses(
        [
            natural_pose(animal, frame=t, xy=xy, heading_deg=heading, scale=2.0)
            for t, xy in enumerate(places)
        ]
    )
    track = plain_track(animal, poses)
    track.places_sd_px[:] = 0.1  # as the default method has them
    return tracks_from_poses(animal, track, fps=125.0, view="top")


RUN = [(100.0 + 6.0 * t, 150.0) for t in range(20)]


@pytest.mark.parametrize(("heading", "verdict"), [(0.0, "good"), (180.0, "look")])
def test_a_runner_with_its_head_at_the_rear_is_said(heading, verdict):
    """Every leg was taken for another, and the verdict was *good*."""
    quality = pawnb.assess_quality(tracks_of(load_species("dolomedes"), RUN, heading=heading))
    assert quality.verdict == verdict
    assert ("the animal goes backwards by its heading" in quality.line()) == (verdict == "look")


def test_a_leg_that_lies_along_another_is_said():
    """It was tracked on its neighbour where the animal lacked it, and the verdict was *good*."""
    animal = load_species("dolomedes")
    first, second = animal.leg("L1"), animal.leg("L2")
    over = dataclasses.replace(second, attach=first.attach, natural_deg=first.natural_deg)
    legs = tuple(over if leg is second else leg for leg in animal.legs)
    tracks = tracks_of(dataclasses.replace(animal, legs=legs), RUN, heading=0.0)
    quality = pawnb.assess_quality(tracks)
    assert quality.verdict == "look"
    assert "L2" in quality.poor_points
    assert "L2 lies along L1 in 100 % of frames" in quality.line()
    assert "M in StickPoser, or 0 under L2_scale" in quality.line()
