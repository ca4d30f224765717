"""Stride durations between legs: scipy's textbook example, and statsmodels' repeated measures."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f as fisher

from pawnb.errors import InputError
from pawnb.gait.durations import compare_legs, stride_duration_by_leg


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
    row = stride_duration_by_leg(table).iloc[0]
    assert row["f"] == pytest.approx(7.121, abs=1e-3)
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
    low = [compare_legs(legs(k=5, n=2, seed=s)).p <= 0.05 for s in range(1000)]
    assert 0.005 < np.mean(low) < 0.06
    # and it finds one that is there: half the spread of the animals
    low = [compare_legs(legs(k=5, n=2, shift=0.03, seed=s)).p <= 0.05 for s in range(100)]
    assert np.mean(low) > 0.6
