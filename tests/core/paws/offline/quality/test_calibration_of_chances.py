"""Chances and standard deviations of labels."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.stats import norm

from pawnb.core.paws.offline.quality.calibration import (
    of_all_views,
    probability_right,
    standard_deviation,
)
from pawnb.core.paws.offline.quality.signs import Signs

OF_ALL = {"usual_look", "left_out"}
USUAL = Signs(*(np.array([x]) for x in (0.99, 1.0, 0.0, -1.0, 1.0, 0.9)), 0.0)


@pytest.mark.parametrize(
    ("sign", "better", "worse"),
    [
        ("probability", 0.99, 0.5),
        ("motion_along", 2.5, 0.0),
        ("look", 2.0, -3.0),
        ("other_look", 2.0, -3.0),
        ("name_share", 1.0, 0.0),
        ("broken", 0.1, 20.0),
        ("usual_look", 0.0, -2.0),
        ("left_out", 0.5, -0.5),
    ],
)
def test_every_sign_speaks_for_or_against_a_label(sign, better, worse):
    """Each was found to on marks by hand."""
    more, less = (
        dataclasses.replace(USUAL, **{sign: value if sign in OF_ALL else np.array([value])})
        for value in (better, worse)
    )
    assert probability_right(more) > probability_right(less)


def test_no_label_is_surer_than_the_model_itself():
    """Of 57 marks that it gave less than 0.9, 14 were right."""
    unsure = dataclasses.replace(USUAL, motion_along=np.array([2.5]), probability=np.array([0.3]))
    np.testing.assert_allclose(probability_right(unsure), 0.3)


def test_a_label_without_any_click_stays_a_chance():
    """It looks like none of them, and has no tracklet."""
    unseen, lost, none = np.array([-2.0]), np.array([np.inf]), np.zeros(1)
    chance = probability_right(Signs(np.ones(1), none, unseen, unseen, lost, none, -0.5))
    assert 0 < chance < 0.3


def test_views_of_one_place_are_right_or_wrong_together():
    """Odds 9, 1 and 1/9 have the geometric mean 1, odds 16 and 1 (and a view without any) 4."""
    chance = np.array([[0.9, 0.5, 0.1], [16 / 17, np.nan, 0.5], [np.nan] * 3])
    told = of_all_views(chance)
    np.testing.assert_allclose(told, [[0.5] * 3, [0.8] * 3, [0.0] * 3])


def test_what_is_beside_a_click_is_good_and_what_was_lost_on_the_way_is_even():
    """Of marks that flow reaches from a click 97 % are right, of others about half.

    Looks are those of the middle of twenty runs on real clips, names as sure as those of right and
    of wrong labels.
    """
    look, other, sure = np.full(2, 0.33), np.full(2, -3.26), np.array([1.0, 0.67])
    chance = probability_right(
        Signs(np.ones(2), np.array([2.6, 0.0]), look, other, np.array([0.0, 8.0]), sure, -0.23)
    )
    assert chance[0] > 0.9
    assert 0.4 < chance[1] < 0.7


def test_sure_labels_are_as_exact_as_a_click_and_their_own_distribution_allow():
    """3-4-5: a click is off by 1.4 % of the size."""
    sd = standard_deviation(np.array(3.0), np.array(1.0), 4 / 0.014)
    assert sd == pytest.approx(5.0, rel=1e-3)


def test_lost_labels_are_as_far_off_as_the_animal_is_large():
    sd = standard_deviation(np.array(0.0), np.array(0.0), 100.0)
    assert sd == pytest.approx(40.0, rel=1e-3)


@pytest.mark.parametrize("right", [0.97, 0.9, 0.6])
def test_95_percent_lie_within_limits_of_the_mixture(right):
    limit = 1.96 * standard_deviation(np.array(1.0), np.array(right), 100.0)
    near, far = np.hypot(1, 1.4), np.hypot(1, 40)
    beyond = 2 * (right * norm.sf(limit / near) + (1 - right) * norm.sf(limit / far))
    assert beyond == pytest.approx(0.05, abs=1e-6)
