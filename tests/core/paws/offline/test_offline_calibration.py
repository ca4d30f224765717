"""Chances and standard deviations of labels."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pawnb.core.paws.offline.calibration import Signs, probability_right, standard_deviation

USUAL = Signs(*(np.array([x]) for x in (0.8, 1.0, 1.0, True, 0.8)))


@pytest.mark.parametrize(
    ("sign", "better", "worse"),
    [
        ("probability", 0.95, 0.2),
        ("motion", 2.5, 0.0),
        ("apart", 0.1, 3.0),
        ("between", True, False),
        ("agreement", 1.0, 0.05),
    ],
)
def test_every_sign_speaks_for_or_against_a_label(sign, better, worse):
    """Each was found to on marks by hand: motion, clicks on both sides and agreement speak for."""
    more, less = (
        dataclasses.replace(USUAL, **{sign: np.array([value])}) for value in (better, worse)
    )
    assert probability_right(more) > probability_right(less)


def test_what_is_certain_or_excluded_stays_a_chance():
    for p in (0.0, 1.0):
        chance = probability_right(dataclasses.replace(USUAL, probability=np.array([p])))
        assert 0 < chance < 1


def test_agreement_counts_only_between_clicks():
    outside = dataclasses.replace(USUAL, between=np.array([False]))
    apart = dataclasses.replace(outside, agreement=np.array([0.1]))
    np.testing.assert_array_equal(probability_right(outside), probability_right(apart))


def test_standard_deviations_add_in_squares():
    """3-4-5 of a sure label's own and a click's of 1.2 % of 1000/3; an unsure one is astray."""
    extent = 1000 / 3
    assert standard_deviation(np.array(3.0), np.array(1.0), extent) == pytest.approx(5)
    lost = standard_deviation(np.array(3.0), np.array(0.0), extent)
    assert lost == pytest.approx(np.sqrt(25 + 100**2))
