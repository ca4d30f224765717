"""Joint angles as signals: cut into strides they give back the courses they were made of."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.cycles import average_cycles, cut_cycles
from pawnb.gait.cycles.joint_signals import joint_signals
from pawnb.schema import make_tracks

FPS = 100.0
N = 200


def posed(*, frames=None, individuals="m1"):
    """Two legs whose FP joints turn once in 0.5 s, the left half a stride late; BC stands still."""
    frames = np.arange(N) if frames is None else frames
    tracks = make_tracks(frames, ("L1", "R1"), fps=FPS, individual=individuals, unit="mm")
    joints = ["L1_BC", "L1_FP", "R1_BC", "R1_FP"]
    t = np.asarray(frames) / FPS
    course = [0.0 * t + 5.0, 20.0 * np.sin(2 * np.pi * (2.0 * t - 0.5)), 0.0 * t,
              20.0 * np.sin(4 * np.pi * t)]  # fmt: skip
    angle = np.stack(course, axis=1)[:, :, None]
    return tracks.assign_coords(joint=joints).assign(
        joint_angle=(("time", "joint", "individual"), angle)
    )


def strides():
    rows = [("m1", "t", leg, k, 0.5 * k, 0.5, 0.3) for leg in ("L1", "R1") for k in range(3)]
    columns = ["animal", "trial", "leg", "stride", "start_s", "period_s", "stance_s"]
    return pd.DataFrame(rows, columns=columns)


def test_joints_that_move_are_signals_of_their_legs():
    (one,) = joint_signals(posed(), trial="t")
    assert (one.signal, one.unit, one.legs) == ("FP joint angle", "deg", ("L1", "R1"))
    cycles = cut_cycles([one], strides())
    table = average_cycles(cycles)
    right = table[table["leg"] == "R1"].set_index("percent")["mean"]
    np.testing.assert_allclose(right, 20.0 * np.sin(2 * np.pi * right.index / 100.0), atol=0.2)
    left = table[table["leg"] == "L1"].set_index("percent")["mean"]
    np.testing.assert_allclose(left, -right, atol=0.2)


def test_frames_without_a_row_are_missing_and_smoothing_bridges_nothing():
    tracks = posed(frames=np.r_[0:60, 70:N])
    (one,) = joint_signals(tracks, trial="t", animal="other", smooth=True)
    assert one.animal == "other"
    assert one.samples.shape == (N, 2)
    assert np.isnan(one.samples[60:70]).all()
    (raw,) = joint_signals(tracks, trial="t")
    known = np.isfinite(raw.samples)
    np.testing.assert_allclose(one.samples[known], raw.samples[known], atol=0.5)


def test_tracks_without_joints_are_refused():
    with pytest.raises(InputError, match="these tracks have no joint_angle"):
        joint_signals(posed().drop_vars("joint_angle"))
