"""Body angles of points that were turned with scipy's rotations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pawnb.errors import InputError
from pawnb.gait import body_angles
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Calibration, Trial

# an animal along +X, its left at +Y, in mm; the ears are neither level with nor amid the axis
POINTS = {"tail_base": (-36, 0, 0), "nose": (50, 0, 0), "ear_L": (29, 8, 6), "ear_R": (29, -8, 6)}
ANGLE = st.floats(-179.0, 179.0)


def turned(roll, pitch, yaw, *, to=None):
    """Tracks of the animal turned by yaw, pitch (nose up) and roll about its own axes.

    scipy's capital letters turn about the body's axes; a turn about +Y is nose down.
    """
    angles = np.stack(np.broadcast_arrays(yaw, -np.asarray(pitch), roll), axis=-1).reshape(-1, 3)
    turn = Rotation.from_euler("ZYX", angles, degrees=True)
    to = Rotation.identity() if to is None else to
    tracks = make_tracks(
        range(10, 10 + len(angles)), list(POINTS), fps=250.0, space=("x", "y", "z"), unit="mm"
    )
    for k, place in enumerate(POINTS.values()):
        tracks["position"][:, :, k, 0] = to.apply(turn.apply(place)) + np.array([5.0, -3.0, 20.0])
    return tracks


def measure(tracks, **options):
    return body_angles(
        tracks, along=["tail_base", "nose"], across=("ear_L", "ear_R"), **options
    )  # fmt: skip


@pytest.mark.slow
@given(roll=ANGLE, pitch=st.floats(-85.0, 85.0), yaw=ANGLE)
@settings(max_examples=60, deadline=None)
def test_angles_are_those_the_animal_was_turned_by(roll, pitch, yaw):
    table = measure(turned(roll, pitch, yaw))
    found = table[["roll_deg", "pitch_deg", "yaw_deg"]].to_numpy()[0]
    np.testing.assert_allclose(found, [roll, pitch, yaw], atol=1e-6)


def test_signs_are_left_side_up_nose_up_and_to_the_left():
    """Without scipy: the point that each positive angle moves, and where to."""
    still = measure(turned(0, 0, 0))
    np.testing.assert_allclose(still[["roll_deg", "pitch_deg", "yaw_deg"]], 0.0, atol=1e-9)
    tracks = turned(0, 0, 0)
    tracks["position"].loc[{"keypoint": "ear_L"}][0, 2] += 4.0
    tracks["position"].loc[{"keypoint": "nose"}][0, 1] += 10.0
    tracks["position"].loc[{"keypoint": "nose"}][0, 2] += 10.0
    row = measure(tracks).iloc[0]
    assert row["roll_deg"] > 5.0
    assert row["pitch_deg"] > 5.0
    assert row["yaw_deg"] > 5.0
    assert row["frame"] == 10
    assert row["time_s"] == pytest.approx(0.04)


def test_directions_are_those_of_the_trial_or_of_the_call():
    """The laboratory is turned as a whole: forward is -Y and up is +X there."""
    lab = Rotation.from_matrix(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]))
    forward, up = lab.apply([1.0, 0.0, 0.0]), lab.apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(forward, [0.0, -1.0, 0.0], atol=1e-12)
    tracks = turned([5.0, -8.0], [10.0, 3.0], [-20.0, 60.0], to=lab)
    expected = [[5.0, 10.0, -20.0], [-8.0, 3.0, 60.0]]
    named = measure(tracks, forward=forward.tolist(), up=up.tolist())
    np.testing.assert_allclose(named[["roll_deg", "pitch_deg", "yaw_deg"]], expected, atol=1e-9)
    trial = Trial(
        kind="paws", name="t", fps=250.0,
        animal=Animal(id="a", body=("tail_base", "nose")),
        calibration=Calibration(dlt="x.csv", forward=tuple(forward), up=tuple(up)),
    )  # fmt: skip
    of_trial = body_angles(tracks, trial=trial, across=("ear_L", "ear_R"))
    np.testing.assert_allclose(of_trial[["roll_deg", "pitch_deg", "yaw_deg"]], expected, atol=1e-9)


def test_an_angle_is_missing_where_its_points_are():
    tracks = turned([1.0] * 3, [2.0] * 3, [3.0] * 3)
    tracks["position"].loc[{"keypoint": "ear_R"}][1] = np.nan
    tracks["position"].loc[{"keypoint": "nose"}][2] = np.nan
    table = measure(tracks)
    assert table["roll_deg"].isna().tolist() == [False, True, True]
    assert table["yaw_deg"].isna().tolist() == [False, False, True]
    alone = body_angles(tracks, along=["tail_base", "nose"])
    assert alone["roll_deg"].isna().all()
    assert alone["pitch_deg"].iloc[0] == pytest.approx(2.0)


def test_a_lowpass_takes_the_tremble_away():
    t = np.arange(200) / 250.0
    slow, fast = 10.0 * np.sin(2 * np.pi * 2 * t), 3.0 * np.sin(2 * np.pi * 60 * t)
    table = measure(turned(0.0, 0.0, slow + fast), cutoff_hz=15.0)
    assert np.abs(table["yaw_deg"].to_numpy()[20:-20] - slow[20:-20]).max() < 0.5


def test_what_cannot_be_told_is_said():
    tracks = turned(0, 0, 0)
    with pytest.raises(InputError, match="two or more points along the body, rear to front"):
        body_angles(tracks)
    with pytest.raises(InputError, match="no point 'nos' \\(did you mean 'nose'\\?\\)"):
        body_angles(tracks, along=["tail_base", "nos"])
    with pytest.raises(InputError, match="not parallel"):
        measure(tracks, forward=[0, 0, 2.0])
    flat = make_tracks([0], ["a", "b"], fps=1.0, space=("x", "y"))
    with pytest.raises(InputError, match="positions x, y, z of one individual"):
        body_angles(flat, along=["a", "b"])
