"""Bouts in speeds made by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.gait.strides.bouts import find_bouts

HOW = {"fs_hz": 10.0, "start_fraction": 0.35, "stop_fraction": 0.2, "min_bout_s": 1.0,
       "min_pause_s": 0.5}  # fmt: skip


def test_stop_and_go():
    speed = np.concatenate(
        [np.full(30, 100.0), np.full(20, 5.0), np.full(40, 90.0), np.full(10, 0.0)]
    )
    found = find_bouts(speed, **HOW)
    assert found.bouts.tolist() == [[0, 30], [50, 90]]
    assert found.pauses.tolist() == [[30, 50], [90, 100]]
    assert (found.start_speed, found.stop_speed) == (35.0, 20.0)


def test_a_bout_needs_the_higher_speed_and_lasts_to_the_lower_one():
    # 30 is above the stop speed (20) but below the start speed (35)
    speed = np.concatenate([np.full(20, 30.0), np.full(5, 0.0), np.full(50, 100.0),
                            np.full(20, 30.0), np.full(5, 0.0)])  # fmt: skip
    assert find_bouts(speed, **HOW).bouts.tolist() == [[25, 95]]


def test_short_pauses_and_short_bouts():
    speed = np.full(100, 100.0)
    speed[40:43] = 0.0  # 0.3 s
    assert find_bouts(speed, **HOW).bouts.tolist() == [[0, 100]]
    speed = np.zeros(100)
    speed[10:18] = 100.0  # 0.8 s
    speed[50:80] = 100.0
    assert find_bouts(speed, **HOW).bouts.tolist() == [[50, 80]]


def test_unknown_speed_ends_no_bout():
    speed = np.full(100, 50.0)
    speed[20:60] = np.nan
    assert find_bouts(speed, **HOW).bouts.tolist() == [[0, 100]]
    assert find_bouts(np.full(10, np.nan), **HOW).bouts.tolist() == [[0, 10]]


@given(level=st.floats(0.01, 1e4), wave=st.floats(0.0, 0.6))
def test_a_steady_run_is_one_bout(level, wave):
    t = np.arange(200) / 10.0
    found = find_bouts(level * (1 + wave * np.sin(3 * t)), **HOW)
    assert found.bouts.tolist() == [[0, 200]]


@given(st.lists(st.floats(0, 100), min_size=2, max_size=80))
def test_bouts_and_pauses_are_the_whole_recording(values):
    found = find_bouts(np.array(values), **HOW)
    both = np.concatenate([found.bouts, found.pauses])
    assert both[np.argsort(both[:, 0]), 0].tolist() == [0, *sorted(both[:, 1])[:-1]]
    assert both[:, 1].max() == pytest.approx(len(values))
