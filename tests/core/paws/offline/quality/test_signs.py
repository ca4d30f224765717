"""What tells of labels whether they are right."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.estimates import Estimates
from pawnb.core.paws.offline.quality.signs import (
    SIGNS,
    Signs,
    mean_along,
    read_signs,
    sum_from_clicks,
    usual_look,
)


def test_sums_begin_beside_a_click_and_hold_the_row_itself():
    values = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    np.testing.assert_allclose(sum_from_clicks(values, [2]), [3, 2, 0, 8, 24])


def test_of_two_ways_the_one_that_is_broken_less_counts():
    """Between clicks in rows 0 and 4: one way breaks in row 1, the other nowhere."""
    values = np.array([0.0, 9.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(sum_from_clicks(values, [0, 4]), [0, 9, 2, 1, 0])
    # exchanged between two breaks: neither way is sound
    values = np.array([0.0, 5.0, 0.0, 0.0, 4.0, 0.0])
    np.testing.assert_allclose(sum_from_clicks(values, [0, 5])[2:4], 4.0)


def test_means_reach_up_to_the_stops_on_either_side_and_hold_them():
    values = np.array([1.0, 2.0, 6.0, 3.0, 9.0])
    np.testing.assert_allclose(mean_along(values, [2]), [3, 3, 21 / 5, 6, 6])
    np.testing.assert_allclose(mean_along(values, []), 21 / 5)


def test_without_a_click_there_is_no_way():
    assert np.isinf(sum_from_clicks(np.zeros(3), [])).all()
    assert np.isfinite(Signs(*np.zeros((3, 3)), np.full(3, np.inf), 0.0).columns()).all()


def test_signs_are_read_at_the_estimate():
    """Flow puts e squared at (3, 1) in row 1, appearance 1/e; agreement is 1/e from there on."""
    motion, look = np.ones((2, 3, 4, 5))
    motion[1, 1, 3], look[1, 1, 3] = np.exp(2), np.exp(-1)
    even = np.full(3, 0.5)
    found = Estimates(np.array([[0, 0], [2.8, 1.2], [3, 1]]), even, np.ones(3))
    signs = read_signs(
        found,
        motion=motion,
        look=look,
        agreement=np.array([0.5, np.exp(-1), np.exp(-1)]),
        clicked=[0],
        usual_look=-0.7,
        left_out=-0.3,
    )
    np.testing.assert_allclose(signs.broken, [0, 1, 2])
    np.testing.assert_allclose(signs.look, [0, -1, 0])
    np.testing.assert_allclose(signs.motion_along, [1, 2 / 3, 1])  # 1 and 2 are breaks
    columns = dict(zip(SIGNS, signs.columns().T, strict=True))
    np.testing.assert_allclose(columns["broken"], np.log([1, 2, 3]))
    np.testing.assert_allclose(columns["usual_look"], -0.7)
    np.testing.assert_allclose(columns["left_out"], -0.3)


def test_agreement_of_nothing_is_a_break_and_not_the_end():
    found = Estimates(np.zeros((2, 2)), np.ones(2), np.ones(2))
    even = np.ones((2, 1, 1))
    signs = read_signs(
        found, motion=even, look=even, agreement=np.zeros(2), clicked=[0], usual_look=0.0
    )
    assert signs.broken[1] == pytest.approx(np.log(100))


def test_the_usual_look_is_that_at_all_estimates_of_a_view():
    """Logarithms 2 and 0 of one point, -1 and -3 of another: mean -0.5."""
    looks = np.full((2, 2, 3, 3), np.exp(9.0))
    looks[0, [0, 1], [0, 1], [0, 1]] = np.exp([2.0, 0.0])
    looks[1, [0, 1], [2, 2], [1, 0]] = np.exp([-1.0, -3.0])
    places = np.array([[[0, 0], [1, 1]], [[1.2, 1.9], [0, 2]]])
    found = {i: Estimates(place, np.ones(2), np.ones(2)) for i, place in enumerate(places)}
    assert usual_look(found, dict(enumerate(looks))) == pytest.approx(-0.5)
