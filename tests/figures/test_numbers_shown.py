"""Numbers in figures are written as a person would write them."""

import pytest

from pawnb.figures.numbers_shown import say_number


@pytest.mark.parametrize(
    ("value", "words"),
    [(3001.6, "3002"), (2145.0, "2145"), (-0.5, "−0.5"), (12.345, "12.3"), (2e-5, "2e−5")],
)
def test_numbers_have_three_digits_and_no_power_of_ten_where_none_is_needed(value, words):
    assert say_number(value) == words
