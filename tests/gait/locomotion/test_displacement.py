"""Turning animals: what is said of their feet must not depend on where the picture's origin is."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.gait import analyse
from pawnb.gait.locomotion.displacement import displacement_along, measure_motion
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.grid import Grid
from pawnb.kinematics import BodyFrame
from pawnb.schema import ORIGIN_CODE, make_tracks

FS, PERIOD_S, DUTY, SPEED, TURN = 200.0, 1 / 6, 0.6, 12.0, 1.2
LAGS = {"LF": 0.0, "LM": 0.5, "LH": 0.0, "RF": 0.5, "RM": 0.0, "RH": 0.5}
PLACES = {leg: ({"F": 1.0, "M": 0.0, "H": -1.0}[leg[1]], 1.1 * (-1) ** (leg[0] == "L"))
          for leg in LAGS}  # fmt: skip
BODY = {"head": (1.3, 0.0), "abdomen": (-1.8, 0.0)}


def circling(*, away=0.0, body=True, turn=TURN, duration_s=5.0):
    """A tripod gait along a circle of 10 mm, feet at rest on the ground in stance."""
    t = np.arange(0, duration_s, 1 / FS)

    def placed(at, offset):
        angle = turn * at
        x = SPEED / turn * np.sin(angle) + np.cos(angle) * offset[0] - np.sin(angle) * offset[1]
        y = SPEED / turn * (1 - np.cos(angle)) + np.sin(angle) * offset[0]
        return np.stack([x, y + np.cos(angle) * offset[1]], axis=-1) + away

    points = {name: placed(t, offset) for name, offset in (BODY if body else {}).items()}
    for leg, lag in LAGS.items():
        k, x = np.divmod(t / PERIOD_S - lag, 1.0)
        holds = [placed((k + n + lag + DUTY / 2) * PERIOD_S, PLACES[leg]) for n in (0, 1)]
        s = np.clip((x - DUTY) / (1 - DUTY), 0, 1)[:, None]
        eased = s**3 * (10 - 15 * s + 6 * s**2)
        points[leg] = holds[0] * (1 - eased) + holds[1] * eased
    tracks = make_tracks(range(len(t)), list(points), fps=FS, space=("x", "y"), unit="mm")
    for i, place in enumerate(points.values()):
        tracks["position"].data[:, :, i, 0] = place
    tracks["origin"].data[:] = ORIGIN_CODE["measured"]
    tracks["confidence"].data[:] = 1.0
    return tracks


def check_strides(strides):
    """Compare with the walk: 2 mm a stride, a tripod, and contact as soft swings show it."""
    assert len(strides) >= 6 * 27
    means = strides[["period_s", "speed", "stride_length", "step_displacement"]].mean()
    np.testing.assert_allclose(means, [PERIOD_S, SPEED, 2.0, 2.0], rtol=0.02)
    assert strides["step_length"].mean() == pytest.approx(1.0, abs=0.03)  # half a stride
    # of soft swings contact is found 0.06 too long, as along a straight line
    assert (strides["contact_duty_factor"] - DUTY - 0.06).abs().max() < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("away", [0.0, 100.0])
def test_feet_of_an_animal_that_turns_stand_still_wherever_the_origin_is(away):
    check_strides(analyse(circling(away=away)).strides)


@pytest.mark.parametrize("turn", [TURN, -TURN])
def test_an_animal_that_turns_is_told_from_its_feet_where_no_body_is_known(turn):
    tables = analyse(circling(away=50.0, body=False, turn=turn))
    check_strides(tables.strides)
    assert any("the heading turns as the feet do" in note for note in tables.notes)
    means = tables.phase_summary.set_index(["leg", "reference"])["mean_strides"]
    assert means["LF", "RF"] == pytest.approx(0.5, abs=0.02)
    assert means["LM", "RM"] == pytest.approx(0.5, abs=0.02)


def test_ways_are_positions_along_a_heading_that_stays_and_gaps_stay_gaps():
    # along (0.6, 0.8) a foot at 5 t of that line has come 5 t
    t = np.arange(6.0)
    positions = (np.array([3.0, 4.0])[None, :] * t[:, None] + 7.0)[:, :, None]
    positions[3] = np.nan
    displacement = displacement_along(positions, np.tile([0.6, 0.8], (6, 1)))[:, 0]
    np.testing.assert_allclose(displacement, [0.0, 5.0, 10.0, np.nan, 20.0, 25.0])


def test_a_step_while_the_heading_turns_goes_along_the_mean_of_both_headings():
    # trapezoid rule by hand: 4 to the right while the heading turns from right to down is 2
    forward = np.array([[1.0, 0.0], [0.0, 1.0], [np.nan, np.nan], [0.0, 1.0]])
    positions = np.array([[5.0, 1.0], [9.0, 1.0], [9.0, 2.0], [9.0, 6.0]])[:, :, None]
    displacement = displacement_along(positions, forward)[:, 0]
    np.testing.assert_allclose(displacement, [0.0, 2.0, np.nan, 7.0])  # 5 down over the gap


def test_motion_over_a_belt_that_speeds_up_by_hand():
    # belt at 0, 2, 4 a second, two samples a second: 0.5 and 1.5 roll by; the body stays in the
    # room, 3 behind the zero of its feet, and turns over the direction where angles begin anew
    heading = np.radians([170.0, 180.0, 190.0])
    forward = np.column_stack((np.cos(heading), np.sin(heading)))
    path = np.full((3, 2), 40.0)
    motion = measure_motion(
        FootPaths(source="position", unit="mm", legs=("FL",), positions=np.zeros((3, 2, 1))),
        BodyFrame(origin=path + 3.0 * forward, forward=forward, path=path, method="body points"),
        displacement=np.array([[0.0], [1.0], [2.0]]),
        fore_aft=np.array([[0.25], [0.5], [0.75]]),
        belt=np.array([0.0, 2.0, 4.0]),
        grid=Grid(time_s=np.array([0.0, 0.5, 1.0]), frame=np.arange(3.0), fs_hz=2.0),
    )
    np.testing.assert_allclose(motion.body, [0.0, 0.5, 2.0])
    np.testing.assert_allclose(motion.feet["FL"], [0.0, 1.5, 4.0])
    np.testing.assert_allclose(motion.places["FL"], [3.25, 4.0, 5.75])
    np.testing.assert_allclose(motion.heading_deg, [170.0, 180.0, 190.0])
