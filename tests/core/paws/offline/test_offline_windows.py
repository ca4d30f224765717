"""Windows over long recordings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.pipeline import ViewTrack, no_track
from pawnb.core.paws.offline.windows import (
    chance_to_go_on,
    handed_on,
    take_over,
    windows,
)


@given(n=st.integers(1, 20_000), clicked=st.integers(0, 19_999))
def test_windows_cover_every_row_and_each_meets_one_before_it(n, clicked):
    spans = windows(n, [min(clicked, n - 1)])
    seen = np.zeros(n, bool)
    for i, (begin, end) in enumerate(spans):
        assert 0 <= begin < end <= n
        assert end - begin <= RUN.window_rows
        if i:
            assert seen[begin:end].any()  # there is something to go on from
        seen[begin:end] = True
    assert seen.all()
    begin, end = spans[0]
    assert begin <= min(clicked, n - 1) < end


def track_of(rows, n, value, probability=0.95):
    track = no_track(n, 1)
    track.uv[rows, 0] = value
    track.probability[rows, 0] = probability
    track.sd_px[rows, 0] = 1.0
    return track


def test_clicks_and_what_the_neighbour_found_are_handed_on():
    found = track_of(slice(0, 60), 100, (7.0, 8.0))
    clicked = Annotations({80: {0: np.array([1.0, 2.0])}})
    own = handed_on(clicked, found, begin=40, end=100)
    np.testing.assert_array_equal(own.places[40][0], (1.0, 2.0))
    given_on = [row for row in own.rows if row != 40]
    assert len(given_on) == 3
    assert all(row < 20 for row in given_on)
    np.testing.assert_array_equal(own.places[given_on[0]][0], (7.0, 8.0))
    unsure = track_of(slice(0, 60), 100, (7.0, 8.0), probability=0.4)
    assert handed_on(clicked, unsure, begin=40, end=100).rows == [40]


def test_a_window_is_as_sure_as_what_it_goes_on_from():
    """Known in rows 40 to 59 of 40 to 99, with 0.8 and 0.6; clicked there, it is certain."""
    found = track_of(slice(0, 50), 100, (7.0, 8.0), probability=0.8)
    found.probability[50:60] = 0.6
    nothing, clicked = Annotations({}), Annotations({80: {0: np.array([1.0, 2.0])}})
    assert chance_to_go_on(nothing, found, begin=40, end=100) == pytest.approx(0.7)
    assert chance_to_go_on(clicked, found, begin=40, end=100) == 1.0
    assert chance_to_go_on(nothing, no_track(100, 1), begin=40, end=100) == 1.0


@pytest.mark.parametrize("after", [True, False])
def test_each_window_keeps_its_half_of_the_overlap(after):
    old, begin = (slice(0, 60), 40) if after else (slice(40, 100), 0)
    whole = track_of(old, 100, (1.0, 1.0))
    new = ViewTrack(np.full((60, 1, 2), 2.0), np.full((60, 1), 0.9), np.full((60, 1), 1.0))
    take_over(whole, new, begin)
    expected = np.r_[np.full(50, 1.0), np.full(50, 2.0)]
    np.testing.assert_array_equal(whole.uv[:, 0, 0], expected if after else expected[::-1])
