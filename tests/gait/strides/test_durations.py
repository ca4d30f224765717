"""Stride durations between legs: scipy's textbook example, and statsmodels' repeated measures."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f as fisher

from pawnb.errors import InputError
from pawnb.gait.strides.durations import compare_legs, stride_duration_by_leg


def test_stride_durations_between_legs():
    # scipy.stats.f_oneway's documented example (mussel shells, McDonald 2014): F 7.121, p 0.000281
    shells = {
        "L1": [0.0571, 0.0813, 0.0831, 0.0976, 0.0817, 0.0859, 0.0735, 0.0659, 0.0923, 0.0836],
        "L2": [0.0873, 0.0662, 0.0672, 0.0819, 0.0749, 0.0649, 0.0835, 0.0725],
        "L3": [0.0974, 0.1352, 0.0817, 0.1016, 0.0968, 0.1064, 0.105],
        "L4": [0.1033, 0.0915, 0.0781, 0.0685, 0.0677, 0.0697, 0.0764, 0.0689],
        "R1": [0.0703, 0.1026, 0.0956, 0.0973, 0.1039, 0.1045],
    }
    table = pd.concat(
        [pd.DataFrame({"animal": "a", "trial": "t", "leg": k, "period_s": v})
         for k, v in shells.items()]
    )  # fmt: skip
    row = stride_duration_by_leg(table, method="f").iloc[0]
    assert row["f"] == pytest.approx(7.121, abs=1e-3)
    permuted = stride_duration_by_leg(table).iloc[0]
    assert permuted["f"] == row["f"]
    assert permuted["p"] == pytest.approx(0.000281, abs=0.0015)  # 1,999 permutations
    assert (row["method"], permuted["method"]) == ("F", "1999 permutations")
    assert row["p"] == pytest.approx(0.000281, abs=1e-6)
    assert (row["longest"], row["shortest"]) == ("L3", "L2")
    assert row["n_animals"] == 1


def legs(k=6, n=8, *, shift=0.0, seed=3):
    """Periods of k animals on four legs; L2 is slower by ``shift``."""
    rng = np.random.default_rng(seed)
    rows = [
        (f"m{a}", leg, own + shift * (leg == "L2") + rng.normal(0.0, 0.01))
        for a, own in enumerate(rng.normal(0.2, 0.02, k))
        for leg in ("L1", "L2", "R1", "R2")
        for _ in range(n)
    ]
    return pd.DataFrame(rows, columns=["animal", "leg", "period_s"])


def test_legs_over_animals_are_statsmodels_repeated_measures():
    from statsmodels.stats.anova import AnovaRM

    table = legs(shift=0.004)
    found = compare_legs(table)
    means = table.groupby(["animal", "leg"])["period_s"].mean().reset_index()
    other = AnovaRM(means, "period_s", "animal", ["leg"]).fit().anova_table.iloc[0]
    assert found.f == pytest.approx(other["F Value"])
    assert found.df_legs / found.epsilon == pytest.approx(other["Num DF"])
    assert found.df_error / found.epsilon == pytest.approx(other["Den DF"])
    assert found.p == pytest.approx(fisher.sf(found.f, found.df_legs, found.df_error))
    assert found.n_animals == 6
    assert found.legs == ("L1", "L2", "R1", "R2")
    # number of strides is no evidence: the same means from ten times as many strides
    again = compare_legs(pd.concat([table] * 10))
    assert again.p == pytest.approx(found.p)


def by_all_orders(table):
    """p of F over all exchanges of legs in every animal, by the textbook's sums of squares."""

    def f(values):
        k, n = values.shape
        legs = k * ((values.mean(axis=0) - values.mean()) ** 2).sum()
        animals = n * ((values.mean(axis=1) - values.mean()) ** 2).sum()
        rest = ((values - values.mean()) ** 2).sum() - legs - animals
        return legs / (n - 1) / (rest / ((n - 1) * (k - 1)))

    values = table.pivot_table(index="animal", columns="leg", values="period_s").to_numpy()
    orders = itertools.product(*(itertools.permutations(row) for row in values))
    every = np.array([f(np.array(order)) for order in orders])
    return (every >= f(values) * (1 - 1e-9)).mean(), every


def test_permutation_of_legs_is_exact_where_it_can_be():
    table = legs(k=3, n=1, shift=0.02)
    table = table[table["leg"] != "R2"]  # 6^3 orders
    found = compare_legs(table)
    p, every = by_all_orders(table)
    assert found.p == pytest.approx(p)
    assert found.method == "legs exchanged within trials, all permutations"
    assert found.smallest_p == pytest.approx((every >= every.max() * (1 - 1e-9)).mean())
    assert found.note == ""


def test_smallest_p_of_few_animals_is_said():
    # two legs of 3 animals, one stride each: 2 of 8 exchanges keep the same leg ahead in all
    table = legs(k=3, n=1, shift=0.1)
    found = compare_legs(table[table["leg"].isin(["L1", "L2"])])
    assert found.p == found.smallest_p == 0.25
    assert found.note == "with 3 animals no p below 0.25 is possible"


def test_strides_are_exchanged_within_their_trial_only():
    # a fast and a slow trial with the legs unequally often in each: the leg that was seen in the
    # slow trial only has longer strides, and no trial says that legs differ
    rng = np.random.default_rng(0)
    rows = [
        (f"m{a}", trial, leg, period + rng.normal(0, 0.01))
        for a in range(3)
        for trial, period, counts in (("fast", 0.1, (9, 2)), ("slow", 0.2, (2, 9)))
        for leg, count in zip(("L1", "R1"), counts, strict=True)
        for _ in range(count)
    ]
    table = pd.DataFrame(rows, columns=["animal", "trial", "leg", "period_s"])
    assert compare_legs(table).p > 0.05
    assert compare_legs(table.drop(columns="trial")).p < 0.02


def test_permutation_is_the_default_below_six_animals():
    for k, name in ((2, "permut"), (5, "permut"), (6, "Greenhouse-Geisser")):
        assert name in compare_legs(legs(k=k)).method
    table = legs(k=5)
    assert compare_legs(table) == compare_legs(table)
    assert compare_legs(table, seed=1).p != compare_legs(table).p
    with pytest.raises(InputError, match=r"^method is 'f'; expected one of"):
        compare_legs(table, method="f")
    with pytest.raises(InputError, match=r"^method is 'x'; expected 'auto', 'permutation' or 'f'"):
        stride_duration_by_leg(table.assign(trial="t"), method="x")


def test_a_difference_that_is_the_same_in_every_animal():
    table = legs(k=3, n=4)
    table["period_s"] = 0.2 + 0.05 * (table["leg"] == "L2")
    found = compare_legs(table)
    assert math.isinf(found.f)
    assert found.p < 0.01
    alike = compare_legs(table.assign(period_s=0.2))
    assert math.isnan(alike.p)
    assert alike.note == "the legs differ by the same in every animal: no test"


@pytest.mark.slow
def test_longer_strides_of_one_leg_are_found_with_three_animals():
    # strides that vary by 20 %, one of four legs 25 % longer: Greenhouse-Geisser finds 0.6 of
    # 200 studies, benchmarks/few_animals.py
    found = np.zeros(2)
    for seed in range(30):
        rng = np.random.default_rng(seed)
        table = legs(k=3, n=10, seed=seed)
        table["period_s"] = 0.2 * (
            1 + 0.25 * (table["leg"] == "L2") + rng.normal(0, 0.2, len(table))
        )
        both = (
            compare_legs(table, method=m, n_permutations=199)
            for m in ("auto", "greenhouse-geisser")
        )
        found += [one.p <= 0.05 for one in both]
    assert found[0] >= 26
    assert found[1] <= 24


def test_greenhouse_and_geissers_correction():
    # by the textbook form with the covariance of the legs (Winer 1991): n^2 (mean of variances -
    # mean of all)^2 / ((n - 1) (sum s^2 - 2 n sum of squared row means + n^2 mean^2))
    table = legs(k=5)
    s = np.cov(table.pivot_table(index="leg", columns="animal", values="period_s").to_numpy())
    n = 4
    above = n**2 * (np.diag(s).mean() - s.mean()) ** 2
    below = (s**2).sum() - 2 * n * (s.mean(axis=1) ** 2).sum() + n**2 * s.mean() ** 2
    assert compare_legs(table).epsilon == pytest.approx(above / ((n - 1) * below))
    two = compare_legs(table[table["leg"].isin(["L1", "R1"])])
    assert two.epsilon == pytest.approx(1.0)


def test_few_animals_and_missing_legs_are_said():
    one = compare_legs(legs(k=1))
    assert math.isnan(one.p)
    assert one.note.startswith("one animal: nothing can be said of animals")
    table = legs(k=4)
    lame = table[~((table["animal"] == "m0") & (table["leg"] == "R2"))]
    found = compare_legs(lame)
    assert (found.n_animals, found.note) == (3, "1 of 4 animals without all legs left out")
    assert compare_legs(table[table["leg"] == "L1"]).note == "one leg: nothing to compare"
    with pytest.raises(InputError, match=r"^comparison of legs: no animal has period_s of every"):
        compare_legs(table[(table["animal"] == "m0") != (table["leg"] == "L1")])


@pytest.mark.slow
def test_level_over_animals():
    # no difference between legs: at most 5 %; measured 2.0 %, the correction is a careful one
    how = {"method": "greenhouse-geisser"}
    low = [compare_legs(legs(k=5, n=2, seed=s), **how).p <= 0.05 for s in range(1000)]
    assert 0.005 < np.mean(low) < 0.06
    # and it finds one that is there: half the spread of the animals
    low = [compare_legs(legs(k=5, n=2, shift=0.03, seed=s), **how).p <= 0.05 for s in range(100)]
    assert np.mean(low) > 0.6
    # by permutation 5 %, standard error 1 %
    low = [compare_legs(legs(k=3, n=3, seed=s), n_permutations=199).p <= 0.05 for s in range(500)]
    assert 0.02 < np.mean(low) < 0.08
