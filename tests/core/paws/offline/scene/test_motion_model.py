"""The rate of a recording, told by how points move in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pawnb.core.paws.offline.scene.motion_model import MotionModel

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


@pytest.mark.parametrize("fps", [100.0, 250.0, 1000.0])
def test_the_rate_is_told_by_how_far_the_fastest_swings_go_in_a_frame(fps):
    # they go 12 spans a second, here 360
    assert replace(MANNER, speed=360.0 / fps).fps == pytest.approx(fps)
