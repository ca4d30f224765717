"""Stretches that are told anew: which certain frames are around them, and in which order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.offline.gap_closing.gap import OpenStretch
from pawnb.core.paws.offline.gap_closing.rejection import runs
from pawnb.core.paws.offline.stride.stance import Stance

N = 40


def opened(*gaps, n=N):
    is_open = np.zeros(n, bool)
    for first, stop in gaps:
        is_open[first:stop] = True
    return is_open


def test_a_stretch_is_told_from_ten_frames_before_it_and_six_after():
    stretch = OpenStretch.of(15, 20, opened((15, 20)))
    np.testing.assert_array_equal(stretch.before, np.arange(5, 15))
    np.testing.assert_array_equal(stretch.frames, np.arange(15, 20))
    np.testing.assert_array_equal(stretch.after, np.arange(20, 26))
    assert (stretch.is_last, stretch.way) == (False, 1)


def test_it_is_told_from_no_frames_beyond_the_next_stretch():
    stretch = OpenStretch.of(15, 20, opened((8, 11), (15, 20), (23, 30)))
    np.testing.assert_array_equal(stretch.before, np.arange(11, 15))
    np.testing.assert_array_equal(stretch.after, np.arange(20, 23))


def test_the_first_stretch_is_told_backwards_from_what_follows():
    stretch = OpenStretch.of(0, 5, opened((0, 5)))
    np.testing.assert_array_equal(stretch.before, np.arange(5, 15)[::-1])
    np.testing.assert_array_equal(stretch.frames, np.arange(5)[::-1])
    assert len(stretch.after) == 0
    assert (stretch.is_last, stretch.way) == (True, -1)


@pytest.mark.parametrize(("stop", "is_last"), [(34, False), (35, True), (39, True), (40, True)])
def test_hardly_anything_follows_where_fewer_than_six_frames_do(stop, is_last):
    stretch = OpenStretch.of(20, stop, opened((20, stop)))
    assert stretch.is_last == is_last
    np.testing.assert_array_equal(stretch.after, np.arange(stop, N)[:6])


def test_a_recording_that_is_open_from_end_to_end_is_one_stretch_told_from_nothing():
    stretch = OpenStretch.of(0, 5, opened((0, 5), n=5))
    assert len(stretch.before) == len(stretch.after) == 0
    assert stretch.stance([Stance(0, 5, np.zeros(3))]) is None


def test_a_point_stands_where_a_stretch_begins_if_its_stance_ends_there():
    stances = [Stance(2, 8, np.zeros(3)), Stance(10, 15, np.ones(3)), Stance(20, 30, np.zeros(3))]
    assert OpenStretch.of(15, 20, opened((15, 20))).stance(stances) is stances[1]
    # it has gone on for a frame
    assert OpenStretch.of(16, 20, opened((16, 20))).stance(stances) is None
    assert OpenStretch.of(15, 20, opened((15, 20))).stance([]) is None
    # told backwards, a stance begins where it ends
    assert OpenStretch.of(0, 10, opened((0, 10))).stance(stances) is stances[1]
    assert OpenStretch.of(0, 9, opened((0, 9))).stance(stances) is None


@given(st.lists(st.booleans(), min_size=1, max_size=60).map(lambda m: np.array(m, bool)))
def test_around_a_stretch_are_certain_frames_in_a_row(is_open):
    for first, stop in runs(is_open):
        stretch = OpenStretch.of(first, stop, is_open)
        told = np.concatenate([stretch.before, stretch.frames, stretch.after])
        np.testing.assert_array_equal(np.diff(told), stretch.way)
        assert is_open[stretch.frames].all()
        assert sorted(stretch.frames) == list(range(first, stop))
        assert not is_open[stretch.before].any()
        assert not is_open[stretch.after].any()
