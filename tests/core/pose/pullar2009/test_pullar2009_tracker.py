"""The 2009 search and tracker on painted animals whose pose is known."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from painted_spider import PaintedReader, paint

from pawnb.core.pose.background import mean_background
from pawnb.core.pose.poses import Poses, join_poses, joint_positions, leg_angles, natural_pose
from pawnb.core.pose.pullar2009.energy import Pullar2009Energy
from pawnb.core.pose.pullar2009.inference import draw_turns, infer_pose
from pawnb.core.pose.pullar2009.limb_steps import part_distances, shape_cost, softplus
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.pullar2009.sticks import pose_vector
from pawnb.core.pose.pullar2009.tracker import track_pullar2009
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError, InputWarning
from pawnb.schema import ORIGIN_CODE

pytestmark = pytest.mark.slow

ANIMAL = load_species("open_insect.toml", folder=Path(__file__).parent)
SIZE = (330, 250)
SCALE = 34.0
QUICK = Pullar2009Settings(combinations=16, max_rounds=5, leg_lengths="start")


def walking(n, *, first=0, step=3.0, x=130.0):
    """Return an insect that walks to the right and swings its legs to and fro."""
    poses = []
    for i in range(n):
        pose = natural_pose(ANIMAL, frame=first + i, xy=(x + step * i, 124.0), scale=SCALE)
        angles = pose.angles_deg.copy()
        for k, leg in enumerate(ANIMAL.leg_names):
            swing = 15 * np.sin(2 * np.pi * (i / 14 + k / 2)) - 15 * np.sin(np.pi * k)
            angles[0, ANIMAL.joints.index(f"{leg}_BC")] += swing
        poses.append(dataclasses.replace(pose, angles_deg=angles))
    return join_poses(poses)


def filmed(poses, *, empty=6, seed=0, size=SIZE):
    """Return a recording: empty frames, then the poses; and the empty scene."""
    rng = np.random.default_rng(seed)
    pictures = [paint(ANIMAL, None, size, rng, noise=4.0) for _ in range(empty)]
    pictures += [paint(ANIMAL, poses.take([i]), size, rng, noise=4.0) for i in range(len(poses))]
    reader = PaintedReader(pictures)
    return reader, mean_background(reader, range(empty))


@pytest.fixture(scope="module")
def walk():
    poses = walking(6, first=6)
    reader, background = filmed(poses)
    return poses, reader, background


def moved(pose, *, xy=(0.0, 0.0), heading=0.0, angles=0.0):
    return Poses(
        frames=pose.frames, xy=pose.xy + np.array(xy), heading_deg=pose.heading_deg + heading,
        scale=pose.scale, angles_deg=pose.angles_deg + angles, lengths_px=pose.lengths_px,
    )  # fmt: skip


def error_px(found, true):
    return np.linalg.norm(joint_positions(ANIMAL, found) - joint_positions(ANIMAL, true), axis=-1)


@pytest.mark.slow
def test_walk_is_followed_both_ways_from_a_frame_in_the_middle(walk):
    poses, reader, background = walk
    seen = []
    track = track_pullar2009(
        reader, moved(poses.take([3]), xy=(2, -2), heading=4), animal=ANIMAL,
        background=background, settings=QUICK, frames=(6, 12),
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    np.testing.assert_array_equal(track.poses.frames, np.arange(6, 12))
    away = np.nanmedian(error_px(track.poses, poses), axis=(1, 2))
    assert away.max() < 2.5
    turned = np.abs(leg_angles(ANIMAL, track.poses) - leg_angles(ANIMAL, poses))
    assert np.median(turned) < 4.0
    assert (track.origin == ORIGIN_CODE["measured"]).mean() > 0.95
    assert np.median(track.confidence) > 0.6
    assert np.isnan(track.angles_sd_deg).all()
    assert seen[-1] == (6, 6)


@pytest.mark.slow
def test_frames_between_two_start_poses_are_tracked_from_the_nearer(walk):
    """The first pose stands a leg on its neighbour's place; the second, three frames on, is right.

    Tracked from the first alone, frames 9 and 10 keep that leg wrong.
    """
    poses, reader, background = walk
    wrong = poses.take([0])
    angles = wrong.angles_deg.copy()
    angles[0, ANIMAL.joints.index("L2_BC")] = angles[0, ANIMAL.joints.index("L1_BC")]
    starts = join_poses([dataclasses.replace(wrong, angles_deg=angles), poses.take([4])])
    track = track_pullar2009(
        reader, starts, animal=ANIMAL, background=background, settings=QUICK, frames=(6, 12)
    )
    assert np.isfinite(track.poses.xy).all()
    away = np.nanmedian(error_px(track.poses, poses), axis=(1, 2))
    assert away[2:].max() < 2.5
    turned = np.abs(leg_angles(ANIMAL, track.poses) - leg_angles(ANIMAL, poses))
    assert turned[2:].max() < 12.0


def test_runs_are_repeatable_and_the_seed_matters(walk):
    poses, reader, background = walk

    def run(**settings):
        return track_pullar2009(
            reader, poses.take([0]), animal=ANIMAL, background=background, frames=(6, 7),
            settings=dataclasses.replace(QUICK, **settings),
        ).poses.angles_deg  # fmt: skip

    np.testing.assert_array_equal(run(), run())
    assert (run() != run(seed=1)).any()


def test_lengths_in_the_start_pose_are_kept_where_asked(walk):
    poses, reader, background = walk
    start = poses.take([0])
    short = dataclasses.replace(start, lengths_px=0.9 * start.lengths_px)

    def lengths(kind):
        return track_pullar2009(
            reader, short, animal=ANIMAL, background=background, frames=(6, 7),
            settings=dataclasses.replace(QUICK, leg_lengths=kind),
        ).poses.lengths_px[0]  # fmt: skip

    np.testing.assert_array_equal(lengths("start"), short.lengths_px[0])
    ratio = lengths("fitted") / start.lengths_px[0]
    assert ratio.mean() == pytest.approx(1.0, abs=0.06)


def test_energy_never_rises_and_falls_from_a_bad_guess(walk):
    poses, reader, background = walk
    picture, start = reader.frame(8).image(), poses.take([2])
    energy = Pullar2009Energy(ANIMAL, start, picture=picture, background=background, settings=QUICK)
    guess = pose_vector(moved(start, xy=(3, 3), heading=6, angles=4))
    frame = energy.frame(picture, guess, slack_px=25)
    fit = infer_pose(energy, frame, guess, rng=np.random.default_rng(0))
    assert fit.cut.energy < energy.cut(frame, guess).energy
    assert fit.cut.energy == energy.cut(frame, fit.pose).energy
    assert np.hypot(*(fit.pose[:2] - start.xy[0])) < 2.0


def test_turns_go_outwards_with_falling_steps():
    turns = draw_turns(4, first_multiplier=3, combinations=20, rng=np.random.default_rng(0))
    assert turns.shape == (60, 4)
    for i, multiplier in enumerate((3, 2, 1)):
        own = turns[20 * i : 20 * (i + 1)]
        assert set(np.unique(own)) == {-multiplier, 0, multiplier}
        # a quarter turns the first joint, the next leaves it and turns the second, ...
        innermost = (own != 0).argmax(axis=1)
        np.testing.assert_array_equal(innermost, np.repeat([0, 1, 2, 3], 5))


def test_shape_cost_for_given_labels_is_the_sum_over_pixels(walk):
    poses, reader, background = walk
    picture, start = reader.frame(8).image(), poses.take([2])
    energy = Pullar2009Energy(ANIMAL, start, picture=picture, background=background, settings=QUICK)
    vector, p, sticks = pose_vector(start), energy.parameters, energy.sticks
    labels = np.random.default_rng(1).random((80, 90)) < 0.3
    points, parts = sticks.points(vector), sticks.parts(vector)
    v, u = np.mgrid[:80, :90]
    pixels = np.stack([u.ravel() + 90, v.ravel() + 80], axis=1).astype(float)
    away = part_distances(pixels, vector[2], points, sticks.n_links, parts).min(axis=0)
    x = p.steepness * (away - p.thickness_px)
    # Eq. 3.14 and 3.15: -log P of the label of every pixel
    expected = np.where(labels.ravel(), np.logaddexp(0, x), np.logaddexp(0, -x)).sum()
    made = shape_cost(labels, (90, 80), vector[2], points, sticks.n_links, parts,
                      p.thickness_px, p.steepness)  # fmt: skip
    assert made == pytest.approx(expected, rel=1e-4)
    assert softplus(0.5) == pytest.approx(np.log1p(np.exp(0.5)))


def test_a_start_pose_off_the_animal_is_refused(walk):
    poses, reader, background = walk
    with pytest.raises(InputError, match=r"not on the animal: only \d+ % .* move the pose there"):
        track_pullar2009(reader, moved(poses.take([0]), xy=(85, 0)), animal=ANIMAL,
                         background=background, frames=(6, 8))  # fmt: skip


def test_a_start_pose_at_the_edge_is_refused(walk):
    poses, reader, background = walk
    with pytest.raises(InputError, match=r"reaches outside the picture .* start in a frame"):
        track_pullar2009(reader, moved(poses.take([0]), xy=(-115, 0)), animal=ANIMAL,
                         background=background, frames=(6, 8))  # fmt: skip


def test_a_start_pose_of_another_stretch_is_refused(walk):
    poses, reader, background = walk
    with pytest.raises(InputError, match="frame 6, but frames 8 to 9"):
        track_pullar2009(reader, poses.take([0]), animal=ANIMAL, background=background,
                         frames=(8, 10))  # fmt: skip


def test_tracking_ends_where_the_animal_leaves_the_picture():
    poses = walking(5, first=6, step=14.0, x=240.0)
    reader, background = filmed(poses)
    with pytest.warns(InputWarning, match=r"reaches outside the picture; tracking forwards ends"):
        track = track_pullar2009(reader, poses.take([0]), animal=ANIMAL, background=background,
                                 settings=QUICK, frames=(6, 11))  # fmt: skip
    assert len(track) == 5
    lost = np.isnan(track.poses.xy[:, 0])
    assert lost[-1]
    assert not lost[0]
    assert (track.origin[lost] == ORIGIN_CODE["missing"]).all()


def test_tracking_can_be_stopped(walk):
    poses, reader, background = walk
    track = track_pullar2009(reader, poses.take([0]), animal=ANIMAL, background=background,
                             settings=QUICK, frames=(6, 12), stop=lambda: True)  # fmt: skip
    assert np.isfinite(track.poses.xy[:, 0]).tolist() == [True] + [False] * 5
