"""Tracking poses again about a corrected frame: the stretch, and what stays outside it."""

import dataclasses

import numpy as np
import pytest

from pawnb.core.edits.log import EditLog, Pose, Retrack
from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.corrected import pose_values, posed_frames, put_pose
from pawnb.core.pose.poses import Poses, tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking.pose import retrack_pose as module
from pawnb.workflow.tracking.track import retrack, track

ANIMAL = load_species("insect")
N = 400


def straight(x):
    """Poses of N frames that differ in x alone; the leg span is 100 px."""
    scale = 100.0 / ANIMAL.span
    return Poses(
        frames=np.arange(N),
        xy=np.column_stack([x, np.full(N, 50.0)]),
        heading_deg=np.zeros(N),
        scale=np.full(N, scale),
        angles_deg=np.tile(ANIMAL.natural_deg, (N, 1)),
        lengths_px=np.tile(scale * ANIMAL.lengths, (N, 1)),
    )


def again(true_from, true_to, *, here=200, certain=(0, 200), limits=(0, N)):
    """Track again where the old track is 5 px off from ``true_from`` to ``true_to``, inclusive."""
    right = straight(np.zeros(N))
    off = np.zeros(N)
    off[true_from : true_to + 1] = 5.0
    off[here] = 0.0
    old, new = plain_track(ANIMAL, straight(off)), plain_track(ANIMAL, right)
    asked = []

    def track_part(part):
        asked.append((part[0], part[-1]))
        return new.take(slice(part[0], part[-1] + 1))

    work = module._Again(ANIMAL, old, here, range(*limits), list(certain))
    touched, found = work.run(track_part)
    return (touched[0], touched[-1]), asked, found


def test_the_stretch_ends_where_the_tracks_have_met_for_ten_frames():
    touched, asked, found = again(190, 230)
    assert touched == (190, 230)
    assert asked == [(100, 300)]
    np.testing.assert_array_equal(found.poses.frames, np.arange(190, 231))
    assert (found.poses.xy[:, 0] == 0).all()


def test_the_stretch_grows_until_the_tracks_meet():
    """The first reach is 100 frames, of which the last ten must agree."""
    touched, asked, _ = again(190, 295)
    assert touched == (190, 295)
    assert asked == [(100, 300), (0, 399)]


def test_posed_frames_bound_the_stretch_and_stay():
    touched, asked, _ = again(150, 260, certain=(180, 200, 240), limits=(180, 241))
    assert asked == [(180, 240)]
    assert touched == (181, 239)


def test_the_ends_of_the_tracks_are_tracked_again_too():
    assert again(0, 399, certain=(200,))[0] == (0, 399)
    assert again(200, 200, certain=(200,))[0] == (200, 200)


@pytest.fixture(scope="module")
def spoilt(rendered_spider, tmp_path_factory):
    """Tracks of the still spider in which leg L2 lies 40 degrees off in five frames."""
    out = tmp_path_factory.mktemp("spoilt")
    tracks = track(rendered_spider, out=out, progress=lambda _done, _total: None)
    animal, found = animal_of(tracks), poses_of(tracks)
    wrong = tracks
    for row in range(6, 11):
        pose = found.poses.take(slice(row, row + 1))
        angles = pose.angles_deg.copy()
        angles[0, animal.joints.index("L2_BC")] += 40.0
        values = pose_values(animal, dataclasses.replace(pose, angles_deg=angles))
        wrong = put_pose(wrong, int(pose.frames[0]), values)
    wrong["image_origin"][:] = tracks["image_origin"]
    wrong["origin"][:] = tracks["origin"]
    return tracks, wrong


@pytest.mark.slow
def test_a_corrected_frame_mends_its_neighbours_and_is_replayed(spoilt, rendered_spider, tmp_path):
    tracks, wrong = spoilt
    trial = load_trial(rendered_spider)
    animal, right = animal_of(tracks), poses_of(tracks).poses

    def tracker(some, frame):
        return retrack(trial, some, frame, progress=lambda _done, _total: None)

    scale = trial.calibration.px_per_unit
    log = EditLog(wrong, tmp_path / "edits.jsonl", px_per_unit=scale, retrack=tracker)
    log.apply(Pose(frame=18, pose=pose_values(animal, right.take(slice(8, 9)))))
    log.apply(Retrack(frame=18))
    found = poses_of(log.tracks)
    apart = tip_positions(animal, found.poses) - tip_positions(animal, right)
    assert np.hypot(*np.moveaxis(apart, -1, 0)).max() < 3.0  # of a leg span of 145 px
    # the first row is the start pose, by hand, and bounds the stretch
    assert log.tracks.isel(time=0).identical(wrong.isel(time=0).assign_attrs(log.tracks.attrs))
    np.testing.assert_array_equal(posed_frames(log.tracks), [18])
    step = provenance_steps(log.tracks)[-1]
    assert (step["step"], step["frame"], step["frames"]) == ("retrack", 18, [11, 24])
    back = EditLog(wrong, tmp_path / "edits.jsonl", px_per_unit=scale, retrack=tracker)
    assert back.tracks.identical(log.tracks)


@pytest.mark.slow
def test_a_pose_put_a_little_off_changes_rows_near_it_only(tmp_path):
    """The body 1 px and a leg 8 degrees off, in the middle: a leg span is 145 px."""
    render_spider_trial(tmp_path / "spider", frames=58, scale=0.3, seed=1, motion="still")
    trial = load_trial(tmp_path / "spider")
    tracks = track(trial, progress=lambda _done, _total: None)
    animal, row = animal_of(tracks), 24
    frame = int(tracks["frame"][row])
    pose = poses_of(tracks).poses.take(slice(row, row + 1))
    angles = pose.angles_deg.copy()
    angles[0, animal.joints.index("L2_BC")] += 8.0
    off = dataclasses.replace(pose, angles_deg=angles, xy=pose.xy + 1.0)
    wrong = put_pose(tracks, frame, pose_values(animal, off))
    again = retrack(trial, wrong, frame, progress=lambda _done, _total: None)
    first, end = provenance_steps(again)[-1]["frames"]
    assert frame - 12 <= first <= frame
    assert frame < end <= frame + 13
    outside = (again["frame"] < first) | (again["frame"] >= end) | (again["frame"] == frame)
    kept, were = (t.isel(time=outside.to_numpy()) for t in (again, wrong))
    assert kept.identical(were.assign_attrs(again.attrs))


@pytest.mark.slow
def test_what_cannot_be_tracked_again(spoilt, rendered_spider):
    trial = load_trial(rendered_spider)
    with pytest.raises(InputError, match="frame 3 is not among the tracked frames 10 to 23"):
        retrack(trial, spoilt[0], 3)
    stopped = retrack(trial, spoilt[0], 15, stop=lambda: True, progress=lambda _d, _t: None)
    assert stopped.identical(spoilt[0])
