"""The run of the synthetic spider: feet that stand still, phases and numbers of the thesis."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.synthetic.spider_motion import plan_motion
from pawnb.synthetic.spider_scene import draw_individual, spider_scene
from pawnb.synthetic.spider_truth import PAIRS, leg_extremes

DURATION_S = 1.0
difficulties = st.sampled_from(["easy", "normal", "hard"])


def plan(difficulty, seed, duration_s=DURATION_S):
    scene = spider_scene(difficulty, seed=seed)
    return plan_motion(scene, draw_individual(scene), duration_s=duration_s)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(difficulties, st.integers(0, 10_000))
def test_a_standing_foot_does_not_move_and_a_swing_joins_without_a_jerk(difficulty, seed):
    for foot in plan(difficulty, seed).feet.values():
        for k in range(3, len(foot.touch_down_s) - 2):
            down, off = foot.touch_down_s[k], foot.lift_off_s[k]
            standing = foot.place(np.linspace(down, off, 12))
            np.testing.assert_allclose(standing, standing[:1].repeat(12, axis=0), atol=1e-9)
            assert standing[0, 2] == 0.0
            swing = foot.place(np.linspace(off, foot.touch_down_s[k + 1], 101))
            assert swing[50, 2] == pytest.approx(foot.lift_mm)
            # speed and acceleration begin and end at 0: the first and last steps are tiny
            steps = np.linalg.norm(np.diff(swing, axis=0), axis=1)
            assert max(steps[0], steps[-1]) < 1e-3 * steps.max()


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(difficulties, st.integers(0, 10_000))
def test_feet_stay_between_the_walls(difficulty, seed):
    # the arena is 10 cm wide (thesis §2.2) in the middle of a picture 1024 / 4.84 mm high
    middle = 1024 / 4.84 / 2
    t = np.linspace(0.0, DURATION_S, 200)
    for foot in plan(difficulty, seed).feet.values():
        assert np.abs(foot.place(t)[:, 1] - middle).max() < 50.0


def test_an_animal_beside_the_wall_puts_its_feet_down_before_it():
    scene = dataclasses.replace(spider_scene("normal", seed=3), off_centre_mm=(32.0, 32.0))
    run = plan_motion(scene, draw_individual(scene), duration_s=DURATION_S)
    middle = 1024 / 4.84 / 2
    side = np.sign(run.body.start_mm[1] - middle)
    outmost = [side * (foot.places_mm[:, 1] - middle) for foot in run.feet.values()]
    # 32 mm and the 25 mm of a leg would be beyond the wall at 50 mm
    assert 48.0 < max(places.max() for places in outmost) < 50.0


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(0, DURATION_S), st.floats(-40, 40), st.floats(-40, 40))
def test_body_frame_there_and_back(seed, t, x, y):
    body = plan("normal", seed).body
    time_s, point = np.array([t]), np.array([[x, y]])
    there = body.to_arena(time_s, point)
    np.testing.assert_allclose(body.from_arena(time_s, there), point, atol=1e-9)
    # a point ahead lies ahead in the direction of the heading
    turn = np.radians(body.heading(time_s)[0])
    ahead = body.to_arena(time_s, np.array([[1.0, 0.0]]))[0] - body.place(time_s)[0]
    np.testing.assert_allclose(ahead, [np.cos(turn), np.sin(turn)], atol=1e-9)


@pytest.mark.slow
def test_gait_numbers_are_those_of_the_thesis():
    runs = [plan(d, seed) for d in ("easy", "normal", "hard") for seed in range(12)]
    # §4.2.2: Fig. 4.5 shows 5.1 to 8.4 Hz; duty factor "generally higher than 0.5", Table 4.5
    # puts it near 0.55
    frequency = np.array([run.frequency_hz for run in runs])
    assert ((frequency > 5.0) & (frequency < 9.6)).all()
    duty = np.array([run.duty_factor for run in runs])
    assert ((duty > 0.5) & (duty < 0.58)).all()
    speed = [np.hypot(*run.body.velocity_mm_s) / 10 for run in runs]  # cm/s
    assert min(speed) > 11.0
    assert max(speed) < 34.0
    towards = {np.sign(np.cos(np.radians(run.body.heading_deg))) for run in runs}
    assert towards == {-1.0, 1.0}


@pytest.mark.slow
def test_events_alternate_and_are_extremes_of_the_leg_angle():
    run = plan("normal", 4)
    for leg in run.feet:
        aep, pep = leg_extremes(run, leg)
        order = sorted([(t, "AEP") for t in aep] + [(t, "PEP") for t in pep])
        assert all(a[1] != b[1] for a, b in itertools.pairwise(order))
        for times, sign in ((aep, 1.0), (pep, -1.0)):
            for t in times:
                around = sign * run.leg_angle(leg, t + np.array([-2e-3, -1e-4, 0.0, 1e-4, 2e-3]))
                assert around[2] >= around.max() - 1e-9
                assert around[2] > around[0] + 1e-4  # a true turning point, not a plateau
                assert around[2] > around[4] + 1e-4


# §4.2.4, means of all animals: (leg, reference) and phase in cycles
_THESIS = {
    ("L1", "R1"): 0.458, ("L2", "R2"): 0.498, ("L3", "R3"): 0.485, ("L4", "R4"): 0.510,
    ("L1", "L2"): 0.368, ("R1", "R2"): 0.377, ("L2", "L3"): 0.437, ("R2", "R3"): 0.461,
    ("L3", "L4"): 0.493, ("R3", "R4"): 0.512, ("L2", "L4"): 0.936, ("R2", "R4"): 0.972,
}  # fmt: skip


@pytest.mark.slow
def test_phases_are_near_those_of_the_thesis():
    assert set(_THESIS) <= set(PAIRS)
    runs = [plan("normal", seed, 1.5) for seed in range(12)]
    extremes = [{leg: leg_extremes(run, leg)[0] for leg in run.feet} for run in runs]
    for (leg, reference), expected in _THESIS.items():
        turns = []
        for aep in extremes:
            base = aep[reference]
            k = np.searchsorted(base, aep[leg], side="right") - 1
            fits = (k >= 0) & (k < len(base) - 1)
            phase = (aep[leg][fits] - base[k[fits]]) / np.diff(base)[k[fits]]
            turns.append(np.exp(2j * np.pi * phase))
        mean = np.angle(np.concatenate(turns).mean()) / (2 * np.pi)
        assert abs((mean - expected + 0.5) % 1.0 - 0.5) < 0.06, (leg, reference, mean % 1)
