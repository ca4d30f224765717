"""Bootstrap over animals: draws counted by hand, correction for few animals, coverage."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.groups.bootstrap import bootstrap_animals, bootstrap_units, mean_by_animal
from pawnb.gait.inference.animal_phases import interval_of_phases


def table(by_animal):
    rows = [(a, v) for a, values in by_animal.items() for v in values]
    return pd.DataFrame(rows, columns=["animal", "value"])


THREE = table({"a": [0.0, 0.0], "b": [1.0], "c": [2.0, 2.0, 2.0]})


def test_all_draws_of_three_animals():
    # 27 draws of 0, 1, 2: their mean is below 1/3 with probability 1/27 and below 2/3 with
    # 4/27; the 10th percentile is 1/3
    found = bootstrap_animals(THREE, mean_by_animal("value"), corrected=False, level=0.8)
    assert found.estimate == pytest.approx(1.0)
    assert (found.low, found.high) == pytest.approx((1 / 3, 5 / 3))
    assert found.method == "bootstrap of animals, all draws, percentiles"
    assert (found.n, found.n_animals) == (6, 3)
    twin = table({"a": [0.0], "b": [1.0], "c": [2.2]})
    moved = bootstrap_animals(twin, mean_by_animal("value"), corrected=False, level=0.8)
    assert moved.high != pytest.approx(5 / 3, abs=1e-3)


def test_ends_are_stretched_for_few_animals():
    # t(2) = 4.302653, z = 1.959964 (tables); sqrt(3 / 2)
    plain = bootstrap_animals(THREE, mean_by_animal("value"), corrected=False)
    found = bootstrap_animals(THREE, mean_by_animal("value"))
    factor = 4.302653 / 1.959964 * math.sqrt(1.5)
    assert found.high - 1 == pytest.approx((plain.high - 1) * factor, rel=1e-6)
    assert 1 - found.low == pytest.approx((1 - plain.low) * factor, rel=1e-6)
    assert "stretched for few animals" in found.method


@pytest.mark.slow
def test_random_draws_approach_all_draws_and_repeat():
    data = table({name: [float(i)] for i, name in enumerate("abcdefg")})
    found = bootstrap_animals(data, mean_by_animal("value"), corrected=False, n_resamples=1000)
    assert found.method == "bootstrap of animals, 1000 draws, percentiles"
    # normal approximation: 3 +- 1.96 * 2 / sqrt(7)
    assert found.high == pytest.approx(3 + 1.96 * 2 / math.sqrt(7), abs=0.2)
    again = bootstrap_animals(data, mean_by_animal("value"), corrected=False, n_resamples=1000)
    assert again == found
    other = bootstrap_animals(
        data, mean_by_animal("value"), corrected=False, n_resamples=1000, seed=1
    )
    assert other.low != found.low or other.high != found.high


@pytest.mark.slow
def test_drawing_strides_too_widens_the_interval():
    rng = np.random.default_rng(0)
    data = table({name: rng.normal(0, 1, 10) for name in "abcde"})
    animals = bootstrap_animals(data, mean_by_animal("value"))
    both = bootstrap_animals(data, mean_by_animal("value"), strides=True)
    assert both.high - both.low > 1.05 * (animals.high - animals.low)
    assert "animals and strides" in both.method
    # of ten strides the first alone is not 0: it is drawn as often as each other, once on average
    data = table({name: [5.0, *[0.0] * 9] for name in "abcde"})
    both = bootstrap_animals(data, mean_by_animal("value"), strides=True)
    assert both.low < 0.5 < both.high


def test_phases_across_zero():
    data = table({"a": [0.98, 0.97], "b": [0.01], "c": [0.02, 0.03], "d": [0.99]})
    found = bootstrap_animals(data, mean_by_animal("value", circular=True), circular=True)
    assert found.low > 0.9
    assert found.high < 0.1
    turned = data.assign(value=(data["value"] + 0.5) % 1)
    half = bootstrap_animals(turned, mean_by_animal("value", circular=True), circular=True)
    assert half.low == pytest.approx(found.low - 0.5)
    assert half.high == pytest.approx(found.high + 0.5)


def test_scattered_phases_have_no_interval():
    data = table({"a": [0.0], "b": [0.2], "c": [0.45], "d": [0.6]})
    found = bootstrap_animals(data, mean_by_animal("value", circular=True), circular=True)
    assert (found.high - found.low) % 1 == pytest.approx(0.95)
    assert "any is possible" in found.note


@pytest.mark.slow
@pytest.mark.parametrize(("between", "within"), [(0.05, 0.1), (0.02, 0.02)])
def test_coverage_at_five_animals_of_ten_strides(between, within):
    # 1000 studies: standard error 0.7 %; one phase an animal, as the mean of its strides
    rng = np.random.default_rng(5)
    hits = np.zeros(3)
    for _ in range(1000):
        centres = 0.5 + rng.normal(0, math.hypot(between, within / math.sqrt(10)), 5)
        found = bootstrap_units(centres, circular=True)
        plain = bootstrap_units(centres, circular=True, corrected=False)
        ends = [(found.low, found.high), (plain.low, plain.high), interval_of_phases(centres)]
        hits += [low <= 0.5 <= high for low, high in ends]
    stretched, percentile, t = hits / 1000
    assert 0.93 <= stretched <= 0.97
    assert 0.93 <= t <= 0.97
    assert percentile < 0.9


def test_one_number_an_animal_is_the_same_as_a_table_of_strides():
    data = table({"a": [0.98, 0.97], "b": [0.01], "c": [0.02, 0.03], "d": [0.99]})
    for circular, units in (
        (True, [0.975, 0.01, 0.025, 0.99]),
        (False, [0.975, 0.01, 0.025, 0.99]),
    ):
        slow = bootstrap_animals(
            data, mean_by_animal("value", circular=circular), circular=circular
        )
        fast = bootstrap_units(np.array(units), circular=circular)
        assert (fast.low, fast.high, fast.estimate) == pytest.approx(
            (slow.low, slow.high, slow.estimate)
        )


def test_one_animal_has_no_interval():
    found = bootstrap_animals(table({"a": [1.0, 2.0]}), mean_by_animal("value"))
    assert found.estimate == 1.5
    assert math.isnan(found.low)
    assert "one animal" in found.note
    assert math.isnan(bootstrap_units(np.array([1.5])).low)


def test_a_statistic_that_often_fails_has_no_interval():
    def needs_all(drawn):
        means = drawn.groupby("animal")["value"].mean()
        return float(means.mean()) if means.nunique() == 3 else math.nan

    found = bootstrap_animals(THREE, needs_all)  # 6 of 27 draws have all three
    assert math.isnan(found.low)
    assert "in 22 % of the draws only" in found.note


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bootstrap_animals(THREE.drop(columns="animal"), len), "'animal' is missing"),
        (lambda: bootstrap_animals(THREE.iloc[:0], len), "^bootstrap: the statistic of all 0 rows"),
        (lambda: bootstrap_animals(THREE, lambda _: math.nan), "all 6 rows is nan; expected a n"),
        (lambda: bootstrap_animals(THREE, len, level=2), "^level is 2; expected between"),
        (lambda: bootstrap_units(np.array([0.1, 0.6]), circular=True), "the phases cancel out"),
        (lambda: bootstrap_animals(THREE, len, n_resamples=5), "^n_resamples is 5; expected 100"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
