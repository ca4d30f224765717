"""Evaluations of poses against errors that were put in, and against sums done by hand."""

import dataclasses

import numpy as np
import pytest

from pawnb.core.pose.poses import Poses, join_poses, natural_pose, tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.workflow.evaluation.pose_errors import measure_pose_errors
from pawnb.workflow.evaluation.pose_spread import (
    build_direction_table,
    build_jitter_table,
    compare_directions,
    disturbed,
)

ANIMAL = load_species("dolomedes")
SCALE = 2.0


def run(n=20, **kwargs):
    """Return an animal that walks to the right with its legs at rest."""
    return join_poses(
        [natural_pose(ANIMAL, frame=i, xy=(50.0 + 3 * i, 80.0), scale=SCALE, **kwargs)
         for i in range(n)]
    )  # fmt: skip


def changed(poses, **fields):
    return dataclasses.replace(poses, **fields)


def row(table, measure, legs=""):
    (found,) = table[(table["measure"] == measure) & (table["legs"] == legs)].to_dict("records")
    return found


def test_jitter_of_a_pose_that_shakes():
    poses = run(4)
    shake = np.array([0.0, 2.0, 0.0, 2.0])
    angles = poses.angles_deg.copy()
    angles[:, ANIMAL.joints.index("L1_CT")] += shake
    angles[:, ANIMAL.joints.index("R1_CT")] += 3 * shake
    still = changed(poses, xy=np.array([[5.0, 7.0]] * 4), angles_deg=angles)
    table = build_jitter_table(ANIMAL, still)
    assert row(table, "x")["range"] == 0
    joint = row(table, "CT", "L1, R1")
    # by hand: ranges 2 and 6; standard deviations of 0, 2, 0, 2 with n - 1: 1.1547, times 3
    assert joint["range"] == pytest.approx(4.0)
    assert joint["sd"] == pytest.approx(2 * 1.1547005)
    assert row(table, "CT", "L2, R2")["range"] == 0
    # the coxa-trochanter joint turns nearly the whole leg: total angle a little less
    assert 3.0 < row(table, "total leg", "L1, R1")["range"] < 4.0
    assert len(table) == 3 + 4 * 6


def test_jitter_across_the_wrap_is_small():
    poses = changed(run(3), heading_deg=np.array([179.0, -179.0, 179.5]))
    assert row(build_jitter_table(ANIMAL, poses), "heading")["range"] == pytest.approx(2.0)


def test_jitter_needs_two_poses():
    with pytest.raises(InputError, match="two poses or more; found 1"):
        build_jitter_table(ANIMAL, run(1))


def test_forward_against_reverse_is_the_root_mean_square_of_differences():
    forward = run(10)
    angles = forward.angles_deg.copy()
    angles[:, ANIMAL.joints.index("L3_MT")] += [4.0, -4.0] * 5
    reverse = changed(forward, xy=forward.xy + np.array([3.0, 0.0]), angles_deg=angles).take(
        slice(2, None)
    )
    table = build_direction_table(ANIMAL, forward, reverse)
    assert row(table, "x")["rms_difference"] == pytest.approx(3.0)
    assert row(table, "y")["rms_difference"] == 0
    # mean of 4 (left) and 0 (right)
    assert row(table, "MT", "L3, R3")["rms_difference"] == pytest.approx(2.0)


def test_directions_are_compared_from_disturbed_starts():
    poses, asked = run(10), []

    def track(start):
        asked.append(start)
        return plain_track(ANIMAL, changed(poses, xy=poses.xy + start.xy[0] - poses.xy[0]))

    starts = poses.take([0]), poses.take([0])
    assert row(compare_directions(track, starts, animal=ANIMAL), "x")["rms_difference"] == 0
    table = compare_directions(track, starts, animal=ANIMAL, disturb_px=5.0, disturb_deg=5.0)
    step = asked[-1].xy - asked[-2].xy
    assert row(table, "x")["rms_difference"] == pytest.approx(abs(step[0, 0]))
    turned = np.concatenate([s.angles_deg - poses.angles_deg[:1] for s in asked[-2:]])
    assert turned.std() == pytest.approx(5.0, rel=0.2)


def test_errors_that_were_put_in_are_measured():
    truth = run(30)
    angles = truth.angles_deg.copy()
    angles[:, ANIMAL.joints.index("R2_BC")] += 7.0
    poses = changed(truth, xy=truth.xy + np.array([3.0, 4.0]), angles_deg=angles)
    poses.xy[5] = np.nan
    errors = measure_pose_errors(ANIMAL, poses, truth)
    assert errors.value("frames") == 29
    assert errors.value("true frames without a pose") == 1
    assert errors.value("body error, median") == pytest.approx(5.0)
    assert errors.value("heading error, RMS") == 0
    legs = errors.legs.set_index("leg")
    # a turn at the body-coxa joint is a turn of the whole leg
    assert legs.loc["R2", "leg_angle_rmse_deg"] == pytest.approx(7.0)
    assert legs.loc["R2", "leg_angle_bias_deg"] == pytest.approx(7.0)
    assert legs.loc["R2", "joint_rmse_deg"] == pytest.approx(7.0 / np.sqrt(5))
    assert legs.loc["L1", "tip_px_median"] == pytest.approx(5.0)
    assert legs.loc["L1", "tip_share_median"] == pytest.approx(5.0 / (SCALE * ANIMAL.span))
    assert errors.value("total leg angle error, RMS") == pytest.approx(7.0 / np.sqrt(8))
    assert errors.swaps.empty


def with_tip_on(poses, leg, other, frames):
    """Return poses in which a leg's tip lies nearly where another's is, in some frames."""
    places, angles = tip_positions(ANIMAL, poses), poses.angles_deg.copy()
    i, j = ANIMAL.leg_names.index(leg), ANIMAL.leg_names.index(other)
    k = ANIMAL.joints.index(f"{leg}_BC")
    for f in frames:
        best = min(
            np.arange(-90, 90, 0.5),
            key=lambda turn: np.hypot(*(_tip(poses, f, k, turn)[i] - places[f, j])),
        )
        angles[f, k] += best
    return changed(poses, angles_deg=angles)


def _tip(poses, frame, column, turn):
    one = poses.take([frame])
    angles = one.angles_deg.copy()
    angles[0, column] += turn
    return tip_positions(ANIMAL, changed(one, angles_deg=angles))[0]


@pytest.mark.slow
def test_a_leg_on_its_neighbours_place_is_a_swap():
    truth = run(40)
    poses = with_tip_on(truth, "L2", "L1", [5, 6, 7, 10, 20])
    errors = measure_pose_errors(ANIMAL, poses, truth)
    # frames 5 to 10 are one swap (two frames between), frame 20 another
    assert errors.swaps.to_dict("records") == [
        {"leg": "L2", "taken_for": "L1", "first_frame": 5, "last_frame": 10, "n_frames": 4},
        {"leg": "L2", "taken_for": "L1", "first_frame": 20, "last_frame": 20, "n_frames": 1},
    ]
    assert errors.value("leg swaps per 1000 frames") == pytest.approx(50.0)
    assert errors.value("frames with a swapped leg") == 7
    assert len(measure_pose_errors(ANIMAL, poses, truth, gap_frames=1).swaps) == 3
    assert measure_pose_errors(ANIMAL, poses, truth, far_share=2.0).swaps.empty


def test_poses_without_a_common_frame_are_refused():
    with pytest.raises(InputError, match="no frame with a pose in common"):
        measure_pose_errors(ANIMAL, run(3), changed(run(3), frames=np.array([7, 8, 9])))


def test_unknown_measure_is_refused():
    with pytest.raises(InputError, match="no measure 'speed'; there are frames"):
        measure_pose_errors(ANIMAL, run(3), run(3)).value("speed")


def test_disturbing_keeps_frames_and_sizes():
    poses = run(5)
    moved = disturbed(poses, px=2.0, deg=1.0, rng=np.random.default_rng(0))
    assert isinstance(moved, Poses)
    np.testing.assert_array_equal(moved.lengths_px, poses.lengths_px)
    assert 0 < np.abs(moved.xy - poses.xy).max() < 8
