"""The whole tracker on painted frames: error, both ways, missing frames, bad input."""

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from painted_walk import PaintedReader, painted_walk

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.fit.reading import WaysReader
from pawnb.core.pose.fit.sequence.one_direction import Follower
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import join_poses, leg_angles, tip_positions
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE


@pytest.fixture(scope="module")
def walk():
    animal, poses, reader, background = painted_walk(12)
    reader.images[11] = background.mean.astype(np.uint8)  # the animal has gone
    return animal, poses, reader, background


def disturbed(pose, seed):
    rng = np.random.default_rng(seed)
    return dataclasses.replace(
        pose,
        xy=pose.xy + rng.normal(0, 2.5, (1, 2)),
        heading_deg=pose.heading_deg + rng.normal(0, 5.0),
        angles_deg=pose.angles_deg + rng.normal(0, 5.0, pose.angles_deg.shape),
    )


@pytest.fixture(scope="module")
def track(walk):
    animal, poses, reader, background = walk
    start = disturbed(poses.at_frame(5), 1)
    return track_pose(reader, start, animal=animal, background=background, frames=(0, 12))


def test_poses_are_those_painted(walk, track):
    animal, poses, _, _ = walk
    found, true = track.poses.take(slice(0, 11)), poses.take(slice(0, 11))
    assert np.hypot(*(found.xy - true.xy).T).max() < 0.25
    tips = np.linalg.norm(tip_positions(animal, found) - tip_positions(animal, true), axis=-1)
    assert np.median(tips) < 0.01 * animal.span * true.scale[0]
    apart = leg_angles(animal, found) - leg_angles(animal, true)
    assert np.sqrt((apart**2).mean()) < 1.5
    assert (track.confidence[:11] > 0.3).mean() > 0.95


def test_frames_without_the_animal_are_missing(track):
    assert np.isnan(track.poses.xy[11]).all()
    assert (track.origin[11] == ORIGIN_CODE["missing"]).all()
    assert (track.confidence[11] == 0).all()
    assert (track.origin[:11] != ORIGIN_CODE["missing"]).all()
    np.testing.assert_array_equal(track.poses.frames, np.arange(12))


def test_standard_deviations_are_of_the_size_of_the_errors(walk, track):
    _, poses, _, _ = walk
    error = np.abs(track.poses.xy[:11] - poses.xy[:11])
    assert 0.0 < np.median(track.xy_sd_px[:11]) < 0.5
    assert np.isfinite(track.places_sd_px[:11]).all()
    assert error.max() < 10 * track.xy_sd_px[:11].max()


@pytest.mark.slow
def test_progress_counts_up_and_stop_ends_early(walk):
    animal, poses, reader, background = walk
    seen = []
    part = track_pose(
        reader, poses.at_frame(0), animal=animal, background=background, frames=(0, 12),
        progress=lambda done, total: seen.append((done, total)), stop=lambda: len(seen) > 2,
    )  # fmt: skip
    assert seen == sorted(seen)
    assert np.isnan(part.poses.xy[-1]).all()
    assert np.isfinite(part.poses.xy[0]).all()


def test_a_way_reads_with_a_reader_of_its_own_and_closes_it(walk):
    _, _, reader, _ = walk
    closed = []

    class Counted(PaintedReader):
        def close(self):
            closed.append(self)

    first = Counted(reader.images)
    ways = WaysReader(first, Steps(10))
    one, other = ways.read(range(5)), ways.read(range(9, 4, -1))
    assert [next(one).index, next(other).index] == [0, 9]
    assert [f.index for f in other] == [8, 7, 6, 5]
    assert len(closed) == 1
    assert closed[0] is not first
    assert [f.index for f in one] == [1, 2, 3, 4]
    assert [f.index for f in ways.read(range(2))] == [0, 1]
    assert len(closed) == 1, "the reader that was given stays open"


@pytest.mark.slow
def test_several_start_poses_are_all_used(walk):
    """The animal is away in frames 5 and 6: from frame 2 alone nothing after them is found.

    The second pose is written a whole turn further round, as a person's file may have it.
    """
    animal, poses, reader, background = walk
    images = list(reader.images)
    images[5] = images[6] = background.mean.astype(np.uint8)
    images[7] = images[6]
    gap = PaintedReader(images)
    starts = join_poses([disturbed(poses.at_frame(9), 2), disturbed(poses.at_frame(2), 1)])
    starts = dataclasses.replace(starts, heading_deg=starts.heading_deg + np.array([360.0, 0.0]))
    one, two = (
        track_pose(gap, start, animal=animal, background=background, frames=(0, 11))
        for start in (starts.take([1]), starts)
    )
    assert np.isnan(one.poses.xy[8:]).all()
    there = [0, 1, 2, 3, 4, 8, 9, 10]
    assert np.isnan(two.poses.xy[5:8]).all()
    assert np.hypot(*(two.poses.xy - poses.xy[:11])[there].T).max() < 0.25
    assert np.abs(np.diff(two.poses.heading_deg[there])).max() < 10.0
    off = tip_positions(animal, two.poses) - tip_positions(animal, poses.take(slice(0, 11)))
    assert np.median(np.hypot(*np.moveaxis(off[there], -1, 0))) < 0.01 * animal.span * 2.1


@pytest.mark.slow
def test_a_path_between_two_start_poses_goes_through_both(walk):
    animal, poses, reader, background = walk
    starts = join_poses([disturbed(poses.at_frame(1), 3), disturbed(poses.at_frame(8), 4)])
    seen = []
    track = track_pose(
        reader, starts, animal=animal, background=background, frames=(0, 11),
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    assert np.hypot(*(track.poses.xy - poses.xy[:11]).T).max() < 0.25
    # 11 frames are followed and fitted for good, the 7 up to the second start twice
    assert seen[-1] == (29, 29)


def test_start_poses_that_cannot_be(walk):
    animal, poses, reader, background = walk
    start = poses.at_frame(5)
    with pytest.raises(InputError, match="give a start pose within them"):
        track_pose(reader, start, animal=animal, background=background, frames=(6, 9))
    off = dataclasses.replace(start, xy=np.array([[20.0, 240.0]]))
    with pytest.raises(InputError, match="is not on the animal"):
        track_pose(reader, off, animal=animal, background=background, frames=(0, 12))
    outside = dataclasses.replace(start, xy=np.array([[-300.0, 20.0]]))
    with pytest.raises(InputError, match="outside the view"):
        track_pose(reader, outside, animal=animal, background=background, frames=(0, 12))


def states(monkeypatch):
    """Return all that followers know when their run ends, as plain text."""
    ended, run = [], Follower.run

    def run_too(self, *args, **options):
        found = run(self, *args, **options)
        # what fits and paints holds no memory of earlier frames
        known = {k: v for k, v in vars(found).items() if k != "fitter"}
        with np.printoptions(floatmode="unique", threshold=sys.maxsize):
            ended.append({k: _text(v) for k, v in known.items()})
        return found

    monkeypatch.setattr(Follower, "run", run_too)
    return ended


def _text(value):
    if isinstance(value, (list, tuple)):
        return [_text(item) for item in value]
    plain = value if isinstance(value, np.ndarray) else getattr(value, "__dict__", value)
    return {k: _text(v) for k, v in plain.items()} if isinstance(plain, dict) else repr(plain)


@pytest.mark.slow
def test_a_follower_that_goes_on_knows_all_that_it_knew(walk, track, monkeypatch, tmp_path):
    animal, poses, reader, background = walk
    ended = states(monkeypatch)
    start, path = disturbed(poses.at_frame(5), 1), tmp_path / "kept.bin"
    for _ in range(2):
        with KeptFrames(path, depends_on="") as kept:
            again = track_pose(
                reader, start, animal=animal, background=background, frames=(0, 12), kept=kept
            )
    assert kept.frames == set(range(12))
    np.testing.assert_array_equal(again.poses.angles_deg, track.poses.angles_deg)
    assert len(ended) == 4
    assert ended[:2] == ended[2:]
