"""Stretches that are associated again: which certain frames are around them, and in which order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.offline.gap_closing.gap import Gap
from pawnb.core.paws.offline.gap_closing.rejection import runs
from pawnb.core.paws.offline.stride.stance import Stance

N = 40


def opened(*gaps, n=N):
    is_open = np.zeros(n, bool)
    for first, stop in gaps:
        is_open[first:stop] = True
    return is_open


def test_a_stretch_is_told_from_ten_frames_before_it_and_six_after():
    gap = Gap.of(15, 20, opened((15, 20)))
    np.testing.assert_array_equal(gap.before, np.arange(5, 15))
    np.testing.assert_array_equal(gap.frames, np.arange(15, 20))
    np.testing.assert_array_equal(gap.after, np.arange(20, 26))
    assert (gap.is_last, gap.way) == (False, 1)


def test_it_is_told_from_no_frames_beyond_the_next_stretch():
    gap = Gap.of(15, 20, opened((8, 11), (15, 20), (23, 30)))
    np.testing.assert_array_equal(gap.before, np.arange(11, 15))
    np.testing.assert_array_equal(gap.after, np.arange(20, 23))


def test_the_first_stretch_is_told_backwards_from_what_follows():
    gap = Gap.of(0, 5, opened((0, 5)))
    np.testing.assert_array_equal(gap.before, np.arange(5, 15)[::-1])
    np.testing.assert_array_equal(gap.frames, np.arange(5)[::-1])
    assert len(gap.after) == 0
    assert (gap.is_last, gap.way) == (True, -1)


@pytest.mark.parametrize(("stop", "is_last"), [(34, False), (35, True), (39, True), (40, True)])
def test_hardly_anything_follows_where_fewer_than_six_frames_do(stop, is_last):
    gap = Gap.of(20, stop, opened((20, stop)))
    assert gap.is_last == is_last
    np.testing.assert_array_equal(gap.after, np.arange(stop, N)[:6])


def test_a_recording_that_is_open_from_end_to_end_is_one_stretch_told_from_nothing():
    gap = Gap.of(0, 5, opened((0, 5), n=5))
    assert len(gap.before) == len(gap.after) == 0
    assert gap.stance([Stance(0, 5, np.zeros(3))]) is None


def test_a_point_stands_where_a_stretch_begins_if_its_stance_ends_there():
    stances = [Stance(2, 8, np.zeros(3)), Stance(10, 15, np.ones(3)), Stance(20, 30, np.zeros(3))]
    assert Gap.of(15, 20, opened((15, 20))).stance(stances) is stances[1]
    # it has gone on for a frame
    assert Gap.of(16, 20, opened((16, 20))).stance(stances) is None
    assert Gap.of(15, 20, opened((15, 20))).stance([]) is None
    # told backwards, a stance begins where it ends
    assert Gap.of(0, 10, opened((0, 10))).stance(stances) is stances[1]
    assert Gap.of(0, 9, opened((0, 9))).stance(stances) is None


@given(st.lists(st.booleans(), min_size=1, max_size=60).map(lambda m: np.array(m, bool)))
def test_around_a_stretch_are_certain_frames_in_a_row(is_open):
    for first, stop in runs(is_open):
        gap = Gap.of(first, stop, is_open)
        told = np.concatenate([gap.before, gap.frames, gap.after])
        np.testing.assert_array_equal(np.diff(told), gap.way)
        assert is_open[gap.frames].all()
        assert sorted(gap.frames) == list(range(first, stop))
        assert not is_open[gap.before].any()
        assert not is_open[gap.after].any()
