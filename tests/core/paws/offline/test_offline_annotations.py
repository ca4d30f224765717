"""Clicks of a view: which points and rows, how large the animal is, and a map of them."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.layout import Placement
from pawnb.core.paws.offline.annotations import Annotations, annotations_of_view

# two frames with a triangle of sides 3, 4, 5 and twice as large, one with two of its points only
TRIANGLES = Annotations(
    {
        4: {0: np.array([0.0, 0.0]), 2: np.array([3.0, 0.0]), 1: np.array([3.0, 4.0])},
        1: {0: np.array([0.0, 0.0]), 2: np.array([6.0, 0.0]), 1: np.array([6.0, 8.0])},
        9: {0: np.array([0.0, 0.0]), 2: np.array([100.0, 0.0])},
    }
)


def test_rows_and_points_are_in_order():
    assert TRIANGLES.rows == [1, 4, 9]
    assert TRIANGLES.points == [0, 1, 2]
    assert TRIANGLES.rows_of(1) == [1, 4]
    assert Annotations({3: {}, 5: {1: np.zeros(2)}}).rows == [5]


def test_extent_is_the_median_of_the_longest_sides_of_frames_with_the_most_points():
    assert TRIANGLES.extent() == pytest.approx((5 + 10) / 2)
    assert TRIANGLES.without(1).extent() == pytest.approx(5)


def test_extent_is_that_of_all_frames_where_each_has_one_point():
    places = {0: {3: np.zeros(2)}, 5: {4: np.array([3.0, 4.0])}}
    assert Annotations(places).extent() == pytest.approx(5)


@pytest.mark.parametrize("places", [{}, {0: {}}, {0: {3: np.zeros(2)}, 5: {3: np.ones(2)}}])
def test_extent_is_unknown_where_there_are_no_two_points(places):
    assert np.isnan(Annotations(places).extent())


def test_without_leaves_one_frame_out_and_the_whole_as_it_was():
    assert TRIANGLES.without(4).rows == [1, 9]
    assert TRIANGLES.rows == [1, 4, 9]


def test_moved_maps_each_row_by_its_own_map():
    """A quarter turn in row 1 puts (6, 8) at (-8, 6); row 4 is shifted; row 9 is doubled."""
    to = np.zeros((10, 2, 3))
    to[1] = [[0, -1, 0], [1, 0, 0]]
    to[4] = [[1, 0, 10], [0, 1, -20]]
    to[9] = [[2, 0, 0], [0, 2, 0]]
    moved = TRIANGLES.moved(to).places
    np.testing.assert_allclose(moved[1][1], [-8, 6])
    np.testing.assert_allclose(moved[4][1], [13, -16])
    np.testing.assert_allclose(moved[9][2], [200, 0])
    assert set(moved[9]) == {0, 2}


def test_what_was_placed_in_one_view_counts_rows_from_the_first_frame():
    placed = {
        100: [Placement(0, 1, np.array([1.0, 2.0])), Placement(1, 1, np.array([3.0, 4.0]))],
        103: [Placement(0, 0, np.array([5.0, 6.0]))],
    }
    found = annotations_of_view(placed, 0, 100)
    assert {row: list(here) for row, here in found.places.items()} == {0: [1], 3: [0]}
    np.testing.assert_array_equal(found.places[0][1], [1, 2])
    assert annotations_of_view(placed, 1, 100).rows == [0]  # frame 103 has nothing of view 1
