"""What speaks against a motion: steps of one unit, worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pawnb.core.paws.whole.manner import Manner

# the belt carries standing paws back by 1 a frame; the lowest click was at height 2
MANNER = Manner(
    acceleration=0.2, jerk=0.1, speed=5.0, drift=np.array([-1.0, 0.0, 0.0]), axes=np.eye(3),
    ground=2.0, span=30.0, thickness=1.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("height", "forward", "strange"),
    [
        (2.0, -1.0, 0.0),  # stands on the belt
        (9.0, 5.0, 0.0),  # swings
        (1.4, -1.0, 0.0),  # the middle of a paw may be 0.7 thicknesses below its clicked end
        (0.8, -1.0, 0.5),  # half a thickness further down is one standard deviation
        (-0.2, -1.0, 4.5),  # three of them
        (2.0, -1.35, 0.5),  # one deviation, a quarter of the belt and half the acceleration
        (2.0, -50.0, 4.5),  # no more than three count
        (0.8, -1.35, 1.0),
    ],
)
def test_nothing_goes_below_the_ground_nor_back_faster_than_it(height, forward, strange):
    found = MANNER.strangeness(np.array([0.0, 0.0, height]), np.array([forward, 0.0, 0.0]))
    assert found == pytest.approx(strange)


@pytest.mark.parametrize("fps", [100.0, 250.0, 1000.0])
def test_the_rate_is_told_by_how_far_the_fastest_swings_go_in_a_frame(fps):
    # they go 12 spans a second, here 360
    assert replace(MANNER, speed=360.0 / fps).fps == pytest.approx(fps)
