"""Animals, not strides: intervals by hand, their coverage, and what one animal cannot say."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import t as student
from scipy.stats import ttest_1samp

from pawnb.errors import InputError
from pawnb.gait.circular.tests import mean_test, rayleigh_test
from pawnb.gait.groups.animal_summary import summarise_animals
from pawnb.gait.groups.animals import mean_of_animals, slope_of_animals
from pawnb.gait.inference.animal_phases import interval_of_phases, phase_of_animals
from pawnb.gait.inference.variance_shares import variance_shares

T4 = 2.7764451051977987  # Student's t, 0.975, 4 degrees of freedom (tables)


def study(rng, between, within, k=5, n=10, centre=0.5):
    """Draw phases of k animals of n strides; von Mises concentrations."""
    animals = np.repeat(np.arange(k), n)
    means = rng.vonmises(0, between, k) if math.isfinite(between) else np.zeros(k)
    phases = centre + (means[animals] + rng.vonmises(0, within, k * n)) / (2 * np.pi)
    return np.mod(phases, 1.0), animals


def covers(low, high, truth):
    return math.isnan(low) or (truth - low) % 1 <= (high - low) % 1


def test_mean_of_animals_by_hand():
    # means 1, 2, 3, 4, 5 whatever the number of strides: 3 +- t sqrt(2.5 / 5)
    values = [1.0, 1, 1, 1.5, 2.5, 3, 4, 3.5, 4.5, 5]
    found = mean_of_animals(values, list("aaabbcddde"), expected=0.0)
    assert found.estimate == pytest.approx(3.0)
    assert found.high - 3 == pytest.approx(T4 * math.sqrt(0.5))
    assert 3 - found.low == pytest.approx(T4 * math.sqrt(0.5))
    assert found.sd == pytest.approx(math.sqrt(2.5))
    assert found.p == pytest.approx(0.0132, abs=5e-5)  # t = 4.2426, 4 df (tables)
    assert (found.n, found.n_animals) == (10, 5)
    assert "n = 5 animals, 10 values" in str(found)
    twin = mean_of_animals([*values[:-1], 5.1], list("aaabbcddde"), expected=0.0)
    assert twin.high - 3 != pytest.approx(T4 * math.sqrt(0.5), abs=1e-3)
    assert math.isnan(mean_of_animals(values, list("aaabbcddde")).p)


def test_animals_that_differ_by_rounding_only_have_no_interval():
    # R 4.2.2: t.test(c(.5, .5, .5), mu = .4): Error: data are essentially constant
    found = mean_of_animals([0.3, 0.1 + 0.2, 0.3], list("abc"), expected=0.2)
    assert found.estimate == pytest.approx(0.3)
    assert found.sd == 0.0
    assert np.isnan([found.low, found.high, found.p]).all()
    assert found.note == "no spread between animals beyond rounding: no interval and no p"


def test_interval_of_close_phases_is_students():
    # for small differences sines are the differences and r is 1
    means = 0.98 + np.array([1.0, 2, 3, 4, 5]) * 1e-4
    low, high = interval_of_phases(means)
    assert (high - low) % 1 / 2 == pytest.approx(T4 * math.sqrt(0.5) * 1e-4, rel=1e-5)
    assert low < 0.9803 < high
    assert interval_of_phases(np.append(means[:4], 0.9807))[1] != pytest.approx(high, abs=1e-6)


def test_interval_may_wrap_and_may_be_everything():
    low, high = interval_of_phases(np.array([0.99, 0.0, 0.01, 0.02, 0.97]))
    assert low > 0.9
    assert high < 0.1
    scattered = phase_of_animals(np.array([0.0, 0.2, 0.45, 0.6]), list("abcd"))
    # 95 % of the cycle with the mean in its middle
    assert (scattered.high - scattered.low) % 1 == pytest.approx(0.95)
    assert (scattered.mean - scattered.low) % 1 == pytest.approx(0.475)
    assert "any is possible" in scattered.note
    assert scattered.rayleigh_p > 0.5


@pytest.mark.slow
@settings(max_examples=25)
@given(st.floats(0, 1), st.integers(0, 1000))
def test_interval_turns_with_the_phases(turn, seed):
    phases, animals = study(np.random.default_rng(seed), 20, 10, n=3)
    one, two = phase_of_animals(phases, animals), phase_of_animals(phases + turn, animals)
    assert (two.low - one.low - turn + 0.5) % 1 == pytest.approx(0.5, abs=1e-9)
    assert (two.high - one.high - turn + 0.5) % 1 == pytest.approx(0.5, abs=1e-9)
    assert two.moore_p == pytest.approx(one.moore_p, rel=1e-4)


def test_an_interval_is_given_whatever_rayleighs_p_is():
    # two animals always have one, and phases that cancel out the whole cycle
    two = phase_of_animals(np.array([0.1, 0.3]), list("ab"))
    assert two.rayleigh_p > 0.3
    assert (two.high - two.low) % 1 == pytest.approx(0.95)
    three = phase_of_animals(np.array([0.45, 0.5, 0.65]), list("abc"))
    assert three.rayleigh_p > 0.1
    assert 0.3 < (three.high - three.low) % 1 < 0.95
    assert three.note == ""
    opposite = phase_of_animals(np.array([0.25, 0.75]), list("ab"))
    assert (opposite.low, opposite.high) == (0.0, 1.0)
    assert math.isnan(opposite.mean)


@pytest.mark.parametrize(
    ("k", "between", "least"), [(3, 1.0, 0.93), (3, 3.0, 0.93), (5, 1.0, 0.93), (5, 0.3, 0.885)]
)
def test_few_animals_that_differ_much_have_intervals_that_hold(k, between, least):
    # 700 studies: standard error 0.9 %. With the interval given only where Rayleigh's p was
    # small, those given held the truth in 81 to 91 %
    rng = np.random.default_rng(k)
    draws = 0.5 + rng.vonmises(0, between, (700, k)) / (2 * np.pi)
    found = [interval_of_phases(np.mod(one, 1)) for one in draws]
    assert not np.isnan(found).any()
    assert np.mean([covers(low, high, 0.5) for low, high in found]) >= least


def test_the_interval_reaches_to_the_side_of_outlying_animals():
    # Fieller's directions about which the sines do not differ from 0 by Student's t
    means = np.array([0.0, 0.0, 0.01, 0.0, 0.25, 0.0, 0.01, 0.02, 0.24, 0.0])
    found = phase_of_animals(means, [f"m{i}" for i in range(10)])
    at_end = np.sin(2 * np.pi * (means - found.high))
    assert ttest_1samp(at_end, 0.0).pvalue == pytest.approx(0.05, abs=1e-6)
    assert (found.high - found.mean) % 1 > (found.mean - found.low) % 1
    p = mean_test(means, expected=found.high, animals=[f"m{i}" for i in range(10)]).p
    assert p == pytest.approx(0.05, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("between", "within"), [(200, 10), (math.inf, 2), (10, 1), (3, 3), (1, 3)])
def test_coverage_at_five_animals_of_ten_strides(between, within):
    # 600 studies: standard error 0.9 %; benchmarks/interval_coverage.py draws more
    rng = np.random.default_rng(7)
    hit = 0
    for _ in range(600):
        phases, animals = study(rng, between, within)
        means = [
            np.angle(np.exp(2j * np.pi * phases[animals == i]).sum()) / (2 * np.pi)
            for i in range(5)
        ]
        hit += covers(*interval_of_phases(np.array(means)), 0.5)
    assert 0.925 <= hit / 600 <= 0.975


def test_phase_of_animals_agrees_with_its_tests():
    phases, animals = study(np.random.default_rng(1), 20, 5)
    found = phase_of_animals(phases, animals)
    test = rayleigh_test(phases, animals=animals)
    assert (found.rayleigh_z, found.rayleigh_p) == pytest.approx((test.statistic, test.p))
    # p of an expected phase at the end of the interval is 0.05
    assert mean_test(phases, expected=found.low, animals=animals).p == pytest.approx(0.05)
    assert mean_test(phases, expected=found.high, animals=animals).p == pytest.approx(0.05)


@pytest.mark.slow
def test_default_test_of_randomness_holds_its_level_where_the_naive_does_not():
    rng = np.random.default_rng(3)
    low = np.zeros(2)
    for _ in range(300):
        phases = rng.random(5).repeat(10) + rng.vonmises(0, 5, 50) / (2 * np.pi)
        animals = np.arange(5).repeat(10)
        low += [
            rayleigh_test(phases, animals=animals).p <= 0.05,
            rayleigh_test(phases, method="zar").p <= 0.05,
        ]
    assert low[0] / 300 <= 0.085  # 5 % and three standard errors
    assert low[1] / 300 > 0.5


def test_one_animal_has_no_interval_and_no_p():
    phases = phase_of_animals(np.array([0.4, 0.5, 0.6]), ["m1"] * 3)
    assert phases.mean == pytest.approx(0.5)
    assert all(math.isnan(v) for v in (phases.low, phases.high, phases.rayleigh_p, phases.moore_p))
    assert phases.note == "one animal: nothing can be said of animals"
    mean = mean_of_animals([0.6, 0.7], ["m1"] * 2, expected=0.5)
    assert mean.estimate == pytest.approx(0.65)
    assert all(math.isnan(v) for v in (mean.low, mean.high, mean.sd, mean.p))
    assert "one animal" in mean.note
    assert "1 animal," in str(mean)
    slope = slope_of_animals([1, 2, 3], [2, 4, 6.5], ["m1"] * 3)
    assert slope.estimate == pytest.approx(2.25)
    assert math.isnan(slope.p)


def test_animals_whose_phases_cancel_out_are_left_out():
    found = phase_of_animals(np.array([0.1, 0.6, 0.3, 0.35, 0.4]), list("aabbc"))
    assert found.n_animals == 2
    assert "1 animal without a mean phase left out" in found.note
    alone = phase_of_animals(np.array([0.1, 0.6]), list("aa"))
    assert math.isnan(alone.mean)
    assert "cancel out" in alone.note


def test_slope_by_hand():
    # slopes 1, 2 and 3 in three animals, however far apart the animals are
    x = np.array([0, 1, 2, 10, 11, 12, 20, 22, 24.0])
    y = np.array([0, 1, 2, 5, 7, 9, 0, 6, 12.0])
    found = slope_of_animals(x, y, list("aaabbbccc"))
    assert found.estimate == pytest.approx(2.0)
    assert found.sd == pytest.approx(1.0)
    assert found.p == pytest.approx(0.0742, abs=5e-5)  # t = 3.4641, 2 df (tables)
    assert slope_of_animals(x, y, list("aaabbbccc"), expected=2.0).p == pytest.approx(1.0)
    more = slope_of_animals([*x, 1, 5, 5, 5], [*y, 1, 1, 2, 3], [*"aaabbbccc", "d", *"eee"])
    assert more.estimate == pytest.approx(2.0)
    assert more.note == "2 of 5 animals without a slope left out"


def test_slope_of_phases_across_zero():
    speed = np.tile([10.0, 20, 30], 3)
    phases = np.repeat([0.0, 0.98, 0.02], 3) + np.tile([-0.02, 0, 0.02], 3)
    found = slope_of_animals(speed, np.mod(phases, 1), np.repeat(list("abc"), 3), circular=True)
    assert found.estimate == pytest.approx(0.002)
    plain = slope_of_animals(speed, np.mod(phases, 1), np.repeat(list("abc"), 3))
    assert plain.estimate != pytest.approx(0.002, abs=1e-3)


def strides():
    rng = np.random.default_rng(4)
    own = np.repeat(rng.normal(0.6, 0.05, 5), 8)
    table = pd.DataFrame({"animal": np.repeat(list("abcde"), 8), "leg": "L1"})
    table["duty_factor"] = own + rng.normal(0, 0.02, 40)
    table["period_s"] = 0.2
    return table


def test_summary_of_measures():
    table = strides()
    found = summarise_animals(table, ["duty_factor", "period_s"])
    row = found.iloc[0]
    direct = mean_of_animals(table["duty_factor"], table["animal"])
    assert (row["mean"], row["ci_low"]) == pytest.approx((direct.estimate, direct.low))
    assert (row["n"], row["n_animals"]) == (40, 5)
    own = table["duty_factor"]
    ends = student.interval(0.95, 39, own.mean(), own.std() / math.sqrt(40))
    assert (row["ci_low_strides"], row["ci_high_strides"]) == pytest.approx(ends)
    # strides as if independent: narrower
    assert row["ci_high_strides"] - row["ci_low_strides"] < row["ci_high"] - row["ci_low"]
    assert math.isnan(found.iloc[1]["icc"])  # nothing varies
    table.loc[0, "duty_factor"] = np.nan
    assert summarise_animals(table, ["duty_factor"]).iloc[0]["n"] == 39
    empty = summarise_animals(table.assign(duty_factor=np.nan), ["duty_factor"]).iloc[0]
    assert (empty["n"], empty["note"]) == (0, "no values")
    assert summarise_animals(table, ["period_s"], by=[]).columns[0] == "measure"


def test_variance_shares_by_hand():
    # means 1 and 3, strides +-1 about each: MSB = 8, MSW = 8 / 6 for four strides each
    values = [0.0, 2, 0, 2, 2, 4, 2, 4]
    within, icc = variance_shares(values, list("aaaabbbb"))
    assert within == pytest.approx(math.sqrt(8 / 6))
    assert icc == pytest.approx((8 - 8 / 6) / (8 + 3 * 8 / 6))
    assert variance_shares([0.0, 2, 2, 0], list("aabb"))[1] == 0.0
    assert all(math.isnan(v) for v in variance_shares([1.0, 2], list("ab")))
    assert math.isnan(variance_shares([1.0, 2], list("aa"))[1])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mean_of_animals([1.0, np.nan], list("ab")), "^values: 1 of 2 are not finite"),
        (lambda: mean_of_animals(["x"], ["a"]), "^values: expected numbers"),
        (lambda: mean_of_animals([1.0, 2], [None, np.nan]), "^animals: 2 of 2 have no name"),
        (lambda: mean_of_animals([], []), "^values: none was given"),
        (lambda: mean_of_animals([1.0, 2], list("abc")), "^animals: found 3 names for 2 values"),
        (lambda: mean_of_animals([1.0, 2], list("ab"), level=95), "^level is 95; expected between"),
        (lambda: phase_of_animals([0.1, 0.2], list("ab"), level=0), "^level is 0; expected"),
        (lambda: slope_of_animals([1.0, 2], [1.0], list("ab")), "^slope: found 2 values of x"),
        (lambda: slope_of_animals([1.0, 1], [1.0, 2], list("aa")), "^slope: no animal has 3"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
