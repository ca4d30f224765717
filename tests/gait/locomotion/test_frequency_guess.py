"""Stride frequency of animals that go about, guessed from their feet."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import analyse
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.frequency_guess import guess_frequency
from pawnb.schema import make_tracks

LEGS = ("FR", "HR", "FL", "HL")
OPEN_FIELD = {
    "FR": "Front Paw R", "HR": "Hind Paw R", "FL": "Front Paw L", "HL": "Hind Paw L",
}  # fmt: skip


def wandering(fs, *, swing, jitter, seconds=60.0):
    """Feet of an animal that goes in circles, a round in 10 s, and steps in turn at 4 Hz."""
    t = np.arange(0.0, seconds, 1.0 / fs)
    turn = 2 * np.pi * t / 10.0
    path = 300.0 * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    ahead = np.stack((-np.sin(turn), np.cos(turn)), axis=1)
    signs = np.array([1.0, -1.0, -1.0, 1.0]) * swing * np.sin(2 * np.pi * 4.0 * t)[:, None]
    feet = path[:, :, None] + signs[:, None, :] * ahead[:, :, None]
    feet += jitter * np.random.default_rng(1).standard_normal(feet.shape)
    return FootPaths(source="position", unit="px", legs=LEGS, positions=feet)


@pytest.mark.parametrize("fs", [20.0, 30.0, 60.0])
def test_steps_of_few_samples_are_told_from_going_about(fs):
    feet = wandering(fs, swing=30.0, jitter=2.0)
    assert guess_frequency(feet, body=None, fs_hz=fs) == pytest.approx(4.0, abs=0.2)


def test_jitter_is_no_step_however_large_it_is():
    feet = wandering(30.0, swing=0.0, jitter=30.0)
    assert guess_frequency(feet, body=None, fs_hz=30.0) < 1.0


@pytest.mark.slow
def test_feet_of_a_real_mouse_step_as_often_at_half_the_frame_rate(real_data):
    # feet alone, at 60 and at 30 frames a second: at 30 strides were found to last 5 s and more, on
    # a treadmill. The clip's own paws at 60 frames a second, with snout and tail, tell 0.26 s.
    path = real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv"
    table = pd.read_csv(path, header=[1, 2], index_col=0)
    found = []
    for every in (1, 2):
        taken = table.iloc[::every]
        tracks = make_tracks(
            np.arange(len(taken)), list(LEGS), fps=60.0 / every, unit="px", space=("x", "y")
        )
        for k, name in enumerate(OPEN_FIELD.values()):
            sure = taken[name]["likelihood"].to_numpy() >= 0.6
            place = taken[name][["x", "y"]].to_numpy()
            tracks["position"].data[:, :, k, 0] = np.where(sure[:, None], place, np.nan)
        tracks["confidence"].data[:] = 1.0
        found.append(analyse(tracks).strides)
    assert min(map(len, found)) > 200
    periods = [strides["period_s"].median() for strides in found]
    assert periods == pytest.approx([0.25, 0.25], rel=0.1)
    speeds = [strides["speed"].median() for strides in found]
    assert speeds[1] == pytest.approx(speeds[0], rel=0.05)
