"""Expected errors, and the choice of frames that shows most of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pawnb.core.suspects.rates import CURVES, INTERCEPT, choose_looks, error_rates, weigh
from pawnb.core.suspects.uncertainty import Doubt


def silent(_row, _point):
    return ""


def test_one_frame_shows_what_is_near_and_each_doubt_is_shown_once():
    rates = np.zeros((100, 2))
    rates[20, 0] = rates[23, 1] = 0.4  # both are seen from 18 to 25
    rates[60, 0] = 0.5
    looks = choose_looks(rates, np.arange(100), around=5, least=0.01)
    # 1 - exp(-0.4) of each, by Poisson's chance of none
    np.testing.assert_allclose([look[1] for look in looks], [2 * 0.32968, 0.39347], rtol=1e-4)
    first, second = looks
    assert first[0] in (20, 23)  # what is doubtful itself, not a frame between
    assert second[0] == 60
    assert first[3].tolist() == [20, 23]
    assert second[3][0] == 60
    np.testing.assert_allclose(second[2], [0.39347, 0.0], atol=1e-5)


def test_frames_are_counted_by_their_numbers():
    rates = np.full((3, 1), 0.3)
    looks = choose_looks(rates, np.array([0, 5, 100]), around=5, least=0.01)
    # 0 and 5 are seen from each other
    assert [look[0] in (0, 1) for look in looks] == [True, False]
    np.testing.assert_allclose(looks[0][1], 1 - np.exp(-0.6))
    assert choose_looks(np.zeros((0, 2)), np.zeros(0, int), around=5, least=0.01) == []


def test_a_doubt_without_a_break_is_listed_once():
    rates = np.zeros((100, 2))
    rates[20:60, 0] = 0.1
    rates[35, 0] = 0.3
    rates[22, 1] = 0.05  # of another point, and not seen from there
    looks = choose_looks(rates, np.arange(100), around=5, least=0.01)
    assert [look[0] for look in looks] == [35, 22]
    np.testing.assert_allclose(looks[1][2], [0.0, -np.expm1(-0.05)])
    # the same doubt, weak in between, is two
    rates[26:30, 0] = 0.01
    looks = choose_looks(rates, np.arange(100), around=5, least=0.01)
    assert looks[1][0] in range(20, 26)
    assert looks[1][2][0] > 0.3


def test_some_looks_are_listed_however_little_they_may_find():
    rates = np.full((100, 1), 1e-4)
    rates[50:] = 0.0
    frames = np.arange(100)
    assert choose_looks(rates, frames, around=5, least=0.01) == []
    assert len(choose_looks(rates, frames, around=5, least=0.01, at_least=3)) == 3
    # where nothing at all is doubtful there is nothing to look at
    assert len(choose_looks(rates, frames, around=5, least=0.01, at_least=90)) < 15


@given(arrays(float, (40, 3), elements=st.floats(0, 0.99)), st.integers(1, 8))
def test_looks_never_rise_and_nothing_is_left(rates, around):
    looks = choose_looks(rates, np.arange(40), around=around, least=0.02)
    scores = [look[1] for look in looks]
    assert scores == sorted(scores, reverse=True)
    # what is left can only be less than what no look is near to
    left = rates.copy()
    for row, *_ in looks:
        left[max(0, row - around) : row + around + 1] = 0.0
    left[rates >= 0.03] = 0.0
    for row in range(40):
        expected = -np.expm1(-left[max(0, row - around) : row + around + 1].sum(axis=0))
        assert expected.sum() < 0.02 + 1e-9


def test_what_is_not_known_does_not_count():
    nothing = Doubt({"vague": np.full((2, 1), np.nan)}, silent)
    np.testing.assert_array_equal(weigh(nothing), 0.0)
    np.testing.assert_allclose(error_rates([nothing]), 1 / (1 + np.exp(-INTERCEPT)))


def test_curves_are_well_formed_and_say_what_they_should():
    for name, (knots, values) in CURVES.items():
        assert len(knots) == len(values), name
        assert (np.diff(knots) > 0).all(), name
    # whatever they were learnt from: less sure is more doubtful, and so is being moved
    for name in ("unrecognised", "vague", "revision", "off_cycle"):
        assert CURVES[name][1][-1] > 1 + CURVES[name][1][0]
    for name in ("separation", "apart"):
        away = np.diff(CURVES[name][1]) * (-1 if name == "separation" else 1)
        assert (away >= 0).all(), name
    assert CURVES["near"][1][-1] < CURVES["near"][1][0] - 1
