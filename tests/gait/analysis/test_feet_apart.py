"""Two labels on one foot are told; feet that pass each other, stand or are missing are not."""

import numpy as np
import pytest

from pawnb.gait.analysis.feet_apart import say_on_one_place
from pawnb.gait.locomotion.foot_trajectories import FootPaths

FS, N = 100.0, 400


def walking(rng, legs=("FR", "HR", "FL", "HL")):
    """Feet of a walk seen from the side: left and right ones pass each other twice a stride."""
    phase = np.arange(N)[:, None] / 25.0 + [0.0, 0.25, 0.5, 0.75]
    x = 40.0 * np.cos(2 * np.pi * phase) + [0, 90, 0, 90]
    y = 5.0 * np.maximum(0.0, np.sin(2 * np.pi * phase))
    x, y = np.broadcast_arrays(x, y)
    places = np.stack([x, y], axis=1) + rng.normal(0.0, 0.7, (N, 2, 4))
    return FootPaths(source="position", unit="px", legs=legs, positions=places)


@pytest.fixture
def feet():
    return walking(np.random.default_rng(3))


def test_a_foot_that_is_tracked_as_two_is_said(feet):
    feet.positions[100:180, :, 3] = feet.positions[100:180, :, 1] + 0.8
    (said,) = say_on_one_place(feet, fs_hz=FS)
    # 80 of 400 frames, but for the places at which the legs of a walk pass each other
    assert said.startswith("HR and HL (position) lie on one place in 2")
    assert "0.8 s without a break" in said or "0.81 s" in said or "0.82 s" in said


@pytest.mark.parametrize("jitter_px", [0.0, 1.0, 2.0])
def test_two_labels_of_one_network_on_one_foot_are_said_each_with_a_jitter_of_its_own(jitter_px):
    """With 1 px where feet move by 80 they were never so near for a whole stride."""
    rng = np.random.default_rng(4)
    feet = walking(rng)
    feet.positions[:, :, 3] = feet.positions[:, :, 1] + rng.normal(0.0, jitter_px, (N, 2))
    feet.positions[::7, :, 3] = np.nan
    (said,) = say_on_one_place(feet, fs_hz=FS)
    share = int(said.split("one place in ")[1].split("%")[0])
    assert 90 <= share <= 100
    assert said.startswith("HR and HL")


def test_feet_that_pass_each_other_stand_or_are_missing_are_not_said(feet):
    assert say_on_one_place(feet, fs_hz=FS) == []
    # for less than a stride of 25 frames
    feet.positions[100:118, :, 3] = feet.positions[100:118, :, 1]
    assert say_on_one_place(feet, fs_hz=FS) == []
    feet.positions[200:330, 0] = np.array([0.0, 90.0, 0.0, 90.0])  # it stands
    feet.positions[200:330, 1] = 0.0
    assert say_on_one_place(feet, fs_hz=FS) == []
    feet.positions[:, :, 3] = np.nan
    assert say_on_one_place(feet, fs_hz=FS) == []
