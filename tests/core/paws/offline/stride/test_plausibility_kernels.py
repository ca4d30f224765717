"""What speaks against a motion: steps of one unit, worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.plausibility_kernels import add_kinematic_cost
from pawnb.core.paws.offline.stride.stance import Substrate

# the belt carries standing paws back by 1 a frame; the lowest click was at height 2
MANNER = MotionModel(
    acceleration=0.2,
    jerk=0.1,
    speed=5.0,
    substrate_velocity=np.array([-1.0, 0.0, 0.0]),
    axes=np.eye(3),
    substrate=2.0,
    body_scale=30.0,
    paw_width=1.0,
)


def doubted(height, speed, *, stands=np.nan, recent=False, way=1, motion_model=MANNER):
    """What speaks against a height and a speed of a point that stands at another height."""
    substrate = Substrate(
        np.array([stands]), motion_model.substrate_velocity, np.zeros((1, 3)), motion_model
    )
    x, v, cost = np.array([[0.0], [0.0], [height]]), np.array(speed)[:, None], np.array([3.0])
    add_kinematic_cost(x, v, np.array([recent]), substrate.kinematic_prior(0, way=way), cost)
    return cost[0] - 3.0


@pytest.mark.parametrize(
    ("height", "forward", "strange"),
    [
        (2.0, -1.0, 0.0),  # stands on the belt
        (9.0, 5.0, 0.0),  # swings
        (1.4, -1.0, 0.0),  # the middle of a paw may be 0.7 paw widths below its clicked end
        (0.8, -1.0, 0.5),  # half a paw width further down is one standard deviation
        (-0.2, -1.0, 4.5),  # three of them
        (2.0, -1.35, 0.5),  # one deviation, a quarter of the belt and half the acceleration
        (2.0, -50.0, 4.5),  # no more than three count
        (0.8, -1.35, 1.0),
    ],
)
def test_nothing_goes_below_the_ground_nor_back_faster_than_it(height, forward, strange):
    assert doubted(height, [forward, 0.0, 0.0]) == pytest.approx(strange, abs=1e-12)
    # told backwards in time the same is seen to go the other way
    backwards = doubted(height, [-forward, 0.0, 0.0], way=-1)
    assert backwards == pytest.approx(strange, abs=1e-12)


@pytest.mark.parametrize(
    ("above", "speed", "recent", "is_dear"),
    [
        (0.0, [-1.0, 0.0, 0.0], False, False),  # it stands
        (1.4, [-1.0, 0.0, 0.0], False, True),  # a wrist over a paw that stands
        (1.4, [-1.0, 3.0, 0.0], False, True),  # to the side does not matter
        (1.4, [-0.8, 0.1, 2.5], False, False),  # a paw that lifts off
        (0.0, [-1.0, 0.0, 0.0], True, True),  # lifted off, yet it stands
    ],
)
def test_what_rides_above_the_ground_is_no_paw(above, speed, recent, is_dear):
    cost = doubted(2.2 + above, speed, stands=2.2, recent=recent)
    assert (cost > 5.0) if is_dear else (cost < 0.1)
    # where it stands is not known
    assert doubted(2.2 + above, speed, recent=recent) == 0.0


def test_half_lifted_counts_half():
    # lifted from 0.6 paw widths on, for certain from 1.1
    half, whole = (doubted(2.2 + up, MANNER.substrate_velocity, stands=2.2) for up in (0.85, 1.1))
    assert half == pytest.approx(0.5 * whole)
    assert doubted(2.2 + 1.7, MANNER.substrate_velocity, stands=2.2) == pytest.approx(whole)


def test_where_no_ground_is_known_nothing_is_below_it():
    assert doubted(-99.0, [5.0, 0.0, 0.0], motion_model=replace(MANNER, substrate=-np.inf)) == 0.0


def test_what_is_set_is_what_the_compiled_loop_reads():
    def cost():
        return doubted(2.2 + 1.7, MANNER.substrate_velocity, stands=2.2)

    usual = cost()
    with parameters_set({"stride": {"ride": 14.0}}):
        assert cost() == pytest.approx(2.0 * usual)  # 7 by default
    with parameters_set({"stride": {"lifted_above": 2.0}}):
        assert cost() == 0.0
    assert cost() == usual
