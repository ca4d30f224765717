"""Samples are equally spaced, and no more than the file has; what cannot be put on them is said."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.gait import analyse
from pawnb.gait.locomotion.grid import put_on_grid
from pawnb.schema import absent_frames, make_tracks

FPS, FREQUENCY_HZ, N = 200.0, 4.0, 600
LEGS = ("FR", "HR", "FL", "HL")


def stepping_tracks(frames):
    """Feet on a belt that step ``FREQUENCY_HZ`` times a second, at these frames of the film."""
    tracks = make_tracks(frames, LEGS, fps=FPS, unit="px", space=("x", "y"))
    for k in range(4):
        cycle = (FREQUENCY_HZ * np.asarray(frames) / FPS + 0.5 * (k in (1, 2))) % 1.0
        swing = np.clip((cycle - 0.6) / 0.4, 0.0, 1.0)
        x = np.where(cycle < 0.6, 18.0 - 60.0 * cycle, -18.0 * np.cos(np.pi * swing))
        tracks["position"][:, 0, k, 0] = 300.0 + 80.0 * (k % 2 == 0) + x
        tracks["position"][:, 1, k, 0] = 200.0 - 12.0 * np.sin(np.pi * swing)
    tracks["confidence"][:] = 1.0
    tracks["origin"][:] = 1
    return tracks


def with_empty_rows(step):
    """As SLEAP's analysis export holds a film of which every third frame was tracked."""
    tracks = stepping_tracks(np.arange(N))
    empty = np.arange(N) % step > 0
    tracks["position"].to_numpy()[empty] = np.nan
    tracks["confidence"].to_numpy()[empty] = 0.0
    tracks["origin"].to_numpy()[empty] = 0
    return tracks


@pytest.mark.parametrize("step", [2, 3])
def test_rows_between_those_that_were_tracked_are_no_samples(step):
    grid, dense = put_on_grid(with_empty_rows(step), where="these tracks")
    assert grid.fs_hz == pytest.approx(FPS / step)
    assert np.array_equal(grid.frame, np.arange(0, N, step))
    assert np.isfinite(dense["position"]).all()


def test_gaps_and_a_few_places_are_no_step():
    whole = stepping_tracks(np.arange(N))
    whole["position"].to_numpy()[100:200] = np.nan
    assert put_on_grid(whole, where="these tracks")[0].fs_hz == pytest.approx(FPS)
    few = stepping_tracks(np.arange(9))
    few["position"].to_numpy()[1::2] = np.nan
    assert put_on_grid(few, where="these tracks")[0].fs_hz == pytest.approx(FPS)


@pytest.mark.slow
def test_empty_rows_do_not_change_the_gait():
    """The same places without these rows, as DeepLabCut's csv with its own numbers of frames."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # there was "Mean of empty slice"
        filled = analyse(with_empty_rows(3))
    without = analyse(stepping_tracks(np.arange(0, N, 3)))
    columns = ["leg", "period_s", "duty_factor", "stride_length"]
    for name in columns[1:]:
        np.testing.assert_allclose(filled.strides[name], without.strides[name], rtol=1e-9)
    assert filled.strides["frequency_hz"].median() == pytest.approx(FREQUENCY_HZ, rel=0.02)


def example():
    tracks = make_tracks(range(6), ["FR", "HR"], fps=100.0)
    tracks["position"].data[:] = 1.0
    return tracks


def test_frame_numbers_may_be_floats_that_are_whole():
    tracks = example().isel(time=[0, 1, 3, 4, 5])
    floats = tracks.assign_coords(frame=tracks["frame"].astype(float))
    grid, dense = put_on_grid(floats, where="x")
    assert grid.frame.tolist() == [0, 1, 2, 3, 4, 5]
    assert np.isnan(dense["position"][2]).all()
    assert absent_frames(floats) == [(2, 2, "the tracks")]


@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_a_position_at_infinity_is_refused_and_not_taken_for_a_missing_one(value):
    tracks = example()
    tracks["position"].data[4, 2, 1, 0] = value
    with pytest.raises(InputError, match=r"^x: frame 4, point 'HR' is at infinity; expected"):
        put_on_grid(tracks, where="x")


def test_times_that_do_not_rise_are_refused():
    tracks = example()
    back = tracks.assign_coords(time=tracks["time"].to_numpy()[[0, 1, 3, 2, 4, 5]])
    with pytest.raises(InputError, match=r"^x: times must rise with the frames"):
        put_on_grid(back, where="x")
