"""What tells of labels whether they are right."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.estimates import Estimates
from pawnb.core.paws.offline.association.forward_backward import Posterior
from pawnb.core.paws.offline.quality.signs import (
    SIGNS,
    Signs,
    mean_along,
    read_signs,
    sum_from_clicks,
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
    signs = Signs(*np.zeros((4, 3)), np.full(3, np.inf), np.ones(3), 0.0)
    assert np.isfinite(signs.columns()).all()


def clicked(*points):
    """Return that points were clicked in row 0."""
    return Annotations({0: dict.fromkeys(points, np.zeros(2))})


def posterior(agreement, name_share=None):
    return Posterior(np.empty(0), np.array(agreement), name_share)


def test_signs_are_read_at_the_estimate():
    """Flow puts e squared at (3, 1) in row 1, appearance 1/e; agreement is 1/e from there on."""
    motion, look = np.ones((2, 3, 4, 5))
    motion[1, 1, 3], look[1, 1, 3] = np.exp(2), np.exp(-1)
    even = np.full(3, 0.5)
    found = Estimates(np.array([[0, 0], [2.8, 1.2], [3, 1]]), even, np.ones(3))
    signs = read_signs(
        {7: found}, {7: posterior([0.5, np.exp(-1), np.exp(-1)])}, motion={7: motion},
        looks={7: look}, clicked=clicked(7), left_out={7: -0.3},
    )[7]  # fmt: skip
    np.testing.assert_allclose(signs.broken, [0, 1, 2])
    np.testing.assert_allclose(signs.look, [0, -1, 0])
    np.testing.assert_allclose(signs.other_look, np.log(0.01))  # there is no other
    np.testing.assert_allclose(signs.motion_along, [1, 2 / 3, 1])  # 1 and 2 are breaks
    columns = dict(zip(SIGNS, signs.columns().T, strict=True))
    np.testing.assert_allclose(columns["broken"], np.log([1, 2, 3]))
    np.testing.assert_allclose(columns["name_share"], 1)
    np.testing.assert_allclose(columns["usual_look"], -1 / 3)
    np.testing.assert_allclose(columns["left_out"], -0.3)


def test_agreement_of_nothing_is_a_break_and_not_the_end():
    found = Estimates(np.zeros((2, 2)), np.ones(2), np.ones(2))
    even = {0: np.ones((2, 1, 1))}
    signs = read_signs(
        {0: found}, {0: posterior(np.zeros(2))}, motion=even, looks=even, clicked=clicked(0)
    )
    assert signs[0].broken[1] == pytest.approx(np.log(100))


def test_looks_of_others_and_names_are_those_at_each_points_estimate():
    """By appearance, logarithms 2 and 0 of one point at its own places, -1 and -3 of another.

    The usual look of the view is their mean, -0.5.
    """
    looks = np.full((2, 2, 3, 3), np.exp(9.0))
    looks[0, [0, 1], [0, 1], [0, 1]] = np.exp([2.0, 0.0])
    looks[1, [0, 1], [2, 2], [1, 0]] = np.exp([-1.0, -3.0])
    looks[0, [0, 1], [2, 2], [1, 0]] = np.exp([4.0, 5.0])  # at the places of the other
    places = np.array([[[0, 0], [1, 1]], [[1.2, 1.9], [0, 2]]])
    found = {i: Estimates(place, np.ones(2), np.ones(2)) for i, place in enumerate(places)}
    sure = {i: posterior(np.ones(2), name_share=np.array([1.0, 0.25 * i])) for i in found}
    signs = read_signs(
        found, sure, motion=dict(enumerate(looks)), looks=dict(enumerate(looks)),
        clicked=clicked(0, 1),
    )  # fmt: skip
    assert signs[0].usual_look == signs[1].usual_look == pytest.approx(-0.5)
    np.testing.assert_allclose(signs[1].look, [-1, -3])
    np.testing.assert_allclose(signs[1].other_look, [4, 5])
    np.testing.assert_allclose(signs[0].other_look, [9, 9])
    np.testing.assert_allclose(signs[1].name_share, [1, 0.25])
