"""The strides of the synthetic mouse: exact stance, smooth swing, true events."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pawnb.synthetic.gait_model import PAW_HEIGHT_MM, mean_gait, plan_gait
from pawnb.synthetic.scene import LEGS, scene_settings

scenes = st.builds(
    lambda difficulty, seed, speed, size: scene_settings(
        difficulty, changes={"seed": seed, "belt_speed_mm_s": speed, "size": size}
    ),
    st.sampled_from(["easy", "normal", "hard"]),
    st.integers(0, 10_000),
    st.floats(100.0, 600.0),
    st.floats(0.8, 1.2),
)


@pytest.fixture(scope="module")
def long_run():
    """40 s of a normal mouse: about 200 strides of each leg."""
    return plan_gait(scene_settings("normal"), 40.0)


def strides_within(motion, begin_s, end_s):
    """Numbers of the strides that lie wholly in a time."""
    down = motion.touch_down_s
    return [k for k in range(len(down) - 1) if down[k] >= begin_s and down[k + 1] <= end_s]


@settings(max_examples=25, deadline=None)
@given(scenes)
def test_standing_paws_move_with_the_belt_and_only_with_it(scene):
    gait = plan_gait(scene, 1.0)
    for motion in gait.legs.values():
        for k in strides_within(motion, 0.5, 2.0):
            time_s = np.linspace(motion.touch_down_s[k], motion.lift_off_s[k], 20)[:-1]
            path = motion.position(time_s)
            start = path[0]
            expected = start - np.outer(time_s - time_s[0], [scene.belt_speed_mm_s, 0.0, 0.0])
            np.testing.assert_allclose(path, expected, atol=1e-9)
            assert start[2] == PAW_HEIGHT_MM


@settings(max_examples=25, deadline=None)
@given(scenes)
def test_paths_have_no_jump_and_leave_the_belt_without_a_jerk(scene):
    gait = plan_gait(scene, 1.0)
    step = 1e-6
    for motion in gait.legs.values():
        instants = np.concatenate([motion.touch_down_s[1:-1], motion.lift_off_s[:-1]])
        before, after = motion.position(instants - step), motion.position(instants + step)
        # no paw of a mouse is faster than some 3 m/s
        assert np.abs(after - before).max() < 3000.0 * 2 * step
        lift = motion.lift_off_s[:-1]
        speed = (motion.position(lift + step) - motion.position(lift))[:, 0] / step
        np.testing.assert_allclose(speed, -scene.belt_speed_mm_s, rtol=1e-3)


@settings(max_examples=25, deadline=None)
@given(scenes)
def test_touch_down_and_lift_off_alternate_and_duty_factors_are_those_of_a_mouse(scene):
    for motion in plan_gait(scene, 1.0).legs.values():
        both = np.column_stack([motion.touch_down_s, motion.lift_off_s]).ravel()
        assert (np.diff(both) > 0).all()
        stance = (motion.lift_off_s - motion.touch_down_s)[:-1]
        duty = stance / np.diff(motion.touch_down_s)
        assert duty.min() >= 0.5 - 1e-9
        assert duty.max() <= 0.8 + 1e-9


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(scenes)
# one of its swings ends behind where it began: its turning points are no largest and smallest value
@example(scene_settings("hard", changes={"seed": 316, "belt_speed_mm_s": 100.0, "size": 0.8125}))
def test_extremes_are_the_turning_points_that_dense_sampling_finds(scene):
    for motion in plan_gait(scene, 0.5).legs.values():
        pep, aep = motion.extremes()
        for k in range(len(pep)):
            lift, down = motion.lift_off_s[k], motion.touch_down_s[k + 1]
            assert lift < pep[k] < aep[k] < down
            time_s = np.linspace(lift, down, 2001)[:-1]
            forwards = np.flatnonzero(np.diff(motion.position(time_s)[:, 0]) > 0)
            grain = (down - lift) / 2000
            assert pep[k] == pytest.approx(time_s[forwards[0]], abs=1.01 * grain)
            assert aep[k] == pytest.approx(time_s[forwards[-1] + 1], abs=1.01 * grain)


def test_strides_vary_as_the_settings_say(long_run):
    scene = scene_settings("normal")
    frequency, duty = mean_gait(scene)
    for leg, motion in long_run.legs.items():
        period = np.diff(motion.touch_down_s)
        assert period.mean() == pytest.approx(1 / frequency, rel=0.03)
        # periods vary by themselves and by the jitter of both touch-downs
        expected = np.hypot(scene.period_sd, np.sqrt(2) * scene.phase_jitter)
        assert period.std() / period.mean() == pytest.approx(expected, rel=0.35)
        stance = (motion.lift_off_s - motion.touch_down_s)[:-1]
        assert np.mean(stance / period) == pytest.approx(
            duty + (0.01 if leg[0] == "H" else -0.01), abs=0.01
        )
        assert motion.lift_mm.std() > 0.02 * motion.lift_mm.mean()


def test_left_and_right_alternate_and_diagonals_step_together(long_run):
    def phase(leg, reference):
        down, of = long_run.legs[leg].touch_down_s[3:-3], long_run.legs[reference].touch_down_s
        k = np.searchsorted(of, down) - 1
        lag = (down - of[k]) / (of[k + 1] - of[k])
        return np.angle(np.exp(2j * np.pi * lag).mean()) / (2 * np.pi) % 1.0

    assert phase("FL", "FR") == pytest.approx(0.5, abs=0.03)
    assert phase("HL", "HR") == pytest.approx(0.5, abs=0.03)
    assert abs((phase("HL", "FR") + 0.5) % 1.0 - 0.5) < 0.08
    assert abs((phase("HR", "FL") + 0.5) % 1.0 - 0.5) < 0.08


def test_paws_stay_under_the_animal_for_the_whole_run(long_run):
    time_s = np.arange(1.0, 40.0, 0.01)
    body = long_run.body.value("forward", time_s)
    for leg in LEGS:
        path = long_run.legs[leg].position(time_s)
        relative = path[:, 0] - body
        low, high = (-15.0, 50.0) if leg[0] == "F" else (-60.0, 10.0)
        assert relative.min() > low
        assert relative.max() < high
        assert (np.sign(path[:, 1] - long_run.body.value("left", time_s)) == (
            1.0 if leg[1] == "L" else -1.0
        )).mean() > 0.99  # fmt: skip
        assert path[:, 2].min() >= PAW_HEIGHT_MM


def test_the_seed_decides():
    scene = scene_settings("normal")
    time_s = np.arange(1.0, 2.0, 0.01)
    same = [plan_gait(scene, 1.0).legs["FR"].position(time_s) for _ in range(2)]
    other = plan_gait(scene_settings("normal", changes={"seed": 1}), 1.0)
    np.testing.assert_array_equal(*same)
    assert np.abs(other.legs["FR"].position(time_s) - same[0]).max() > 1.0


def test_frequency_rises_and_duty_factor_falls_with_speed():
    # Clarke & Still 1999: mice step faster and stand for a smaller share at higher speed
    slow, fast = (
        mean_gait(scene_settings("normal", changes={"belt_speed_mm_s": v})) for v in (150, 600)
    )
    assert slow[0] < fast[0]
    assert slow[1] > fast[1]
    fixed = scene_settings("normal", changes={"stride_frequency_hz": 4.0, "duty_factor": 0.7})
    assert mean_gait(fixed) == (4.0, 0.7)
