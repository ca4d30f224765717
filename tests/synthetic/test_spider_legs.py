"""The legs of the synthetic spider: rigid segments in space that end on the foot's place."""

import dataclasses

import numpy as np
import pytest

from pawnb.core.pose.poses import joint_positions, leg_angles
from pawnb.errors import InputError
from pawnb.synthetic.spider_legs import LegBuilder
from pawnb.synthetic.spider_motion import plan_motion
from pawnb.synthetic.spider_scene import draw_individual, spider_scene

SEEDS = range(4)


def build(difficulty, seed, scale=0.5):
    scene = spider_scene(difficulty, seed=seed, scale=scale)
    individual = draw_individual(scene)
    motion = plan_motion(scene, individual, duration_s=0.6)
    t = np.linspace(0.0, 0.6, 60)
    return scene, individual, motion, t, LegBuilder(scene, individual).posture(motion, t)


@pytest.mark.parametrize("difficulty", ["easy", "normal", "hard"])
def test_joints_in_space_and_in_the_picture_agree(difficulty):
    for seed in SEEDS:
        scene, individual, motion, t, posture = build(difficulty, seed)
        # seen from above: u is X and v is Y, (0, 0) the centre of the first pixel
        seen = posture.joints_mm[..., :2] * scene.px_per_mm - 0.5
        np.testing.assert_allclose(
            joint_positions(individual.animal, posture.poses), seen, atol=1e-8
        )
        for i, leg in enumerate(individual.animal.legs):
            np.testing.assert_allclose(
                posture.joints_mm[:, i, -1], motion.feet[leg.name].place(t), atol=1e-8
            )
            # a segment keeps its length in space, and is never longer in the picture
            steps = np.diff(posture.joints_mm[:, i], axis=1)
            whole = individual.size * np.array(leg.lengths)
            np.testing.assert_allclose(np.linalg.norm(steps, axis=2), whole[None].repeat(60, 0))
            share = np.linalg.norm(steps[..., :2], axis=2) / whole
            assert share.min() > 0.1
            assert share.std(axis=0).max() > 0.02  # foreshortening changes within the stride
            assert posture.joints_mm[:, i, :-1, 2].min() > 0  # no joint below the ground
        angles = np.stack([motion.leg_angle(name, t) for name in individual.animal.leg_names], 1)
        np.testing.assert_allclose(leg_angles(individual.animal, posture.poses), angles, atol=1e-8)


@pytest.mark.parametrize("difficulty", ["easy", "normal", "hard"])
def test_joints_turn_within_their_ranges(difficulty):
    for seed in SEEDS:
        _, individual, _, _, posture = build(difficulty, seed)
        animal = individual.animal
        turn = np.abs(posture.poses.angles_deg - animal.natural_deg)
        hip = np.array([name.endswith("_BC") for name in animal.joints])
        assert (turn <= 0.5 * animal.range_deg + 1e-9)[:, ~hip].all()
        # the body-coxa joint goes a few degrees beyond, as Table 4.6 observes
        assert (turn <= 0.5 * animal.range_deg + 16.0)[:, hip].all()
        # and the joints do move
        assert np.ptp(posture.poses.angles_deg, axis=0)[hip].min() > 12.0


@pytest.mark.slow
def test_every_animal_can_reach_its_feet():
    for difficulty in ("easy", "normal", "hard"):
        for seed in range(100, 125):
            build(difficulty, seed)


def test_a_foot_out_of_reach_is_said():
    scene, individual, motion, t, _ = build("normal", 0)
    feet = dict(motion.feet)
    feet["L2"] = dataclasses.replace(feet["L2"], places_mm=feet["L2"].places_mm + 30.0)
    far = dataclasses.replace(motion, feet=feet)
    with pytest.raises(InputError, match="foot of L2 is out of reach"):
        LegBuilder(scene, individual).posture(far, t)


def test_individuals_differ_and_the_same_seed_is_the_same_animal():
    a, b, again = (draw_individual(spider_scene(seed=s)) for s in (1, 2, 1))
    np.testing.assert_array_equal(a.animal.lengths, again.animal.lengths)
    ratio = a.animal.lengths / b.animal.lengths
    assert 0.005 < np.abs(ratio - 1).mean() < 0.06  # a few per cent
    assert a.size != b.size
