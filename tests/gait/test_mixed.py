"""Mixed models against closed forms of balanced data and against statsmodels, and their level."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.animals import mean_of_animals
from pawnb.gait.differences import compare_two
from pawnb.gait.mixed import MIXED_COLUMNS, fit_mixed


def strides(seed=0, k=10, n=12, between=0.03, slope=-0.005):
    rng = np.random.default_rng(seed)
    animal = np.repeat(np.arange(k), n)
    table = pd.DataFrame({"animal": animal, "trial": np.tile(np.repeat([0, 1, 2], n // 3), k)})
    table["group"] = np.where(animal < k // 2, "control", "lesion")
    table["speed"] = 20 + rng.normal(0, 3, k)[animal] + rng.normal(0, 3, k * n)
    trial = rng.normal(0, 0.01, (k, 3))[animal, table["trial"]]
    own = rng.normal(0, between, k)[animal]
    table["duty"] = 0.7 + slope * table["speed"] + own + trial + rng.normal(0, 0.02, k * n)
    return table


def test_mean_of_balanced_data_is_that_of_the_animals():
    # REML of a balanced one-way layout: exactly the t test of the means
    table = strides()
    found = fit_mixed(table, "duty", trials=False)
    direct = mean_of_animals(table["duty"], table["animal"])
    row = found.terms.iloc[0]
    assert list(found.terms.columns) == list(MIXED_COLUMNS)
    assert row["estimate"] == pytest.approx(direct.estimate)
    assert (row["ci_low"], row["ci_high"]) == pytest.approx((direct.low, direct.high), rel=1e-4)
    assert (row["n"], row["n_animals"], row["df"]) == (120, 10, 9)
    # and the intraclass correlation is that of the analysis of variance
    means = table.groupby("animal")["duty"].mean()
    msb = 12 * means.var(ddof=1)
    msw = table.groupby("animal")["duty"].var(ddof=1).mean()
    assert found.icc == pytest.approx((msb - msw) / (msb + 11 * msw), rel=1e-3)
    assert found.sd_residual == pytest.approx(math.sqrt(msw), rel=1e-3)
    assert math.isnan(found.sd_trials)
    twin = table.copy()
    twin.loc[0, "duty"] += 0.05
    assert fit_mixed(twin, "duty", trials=False).icc != pytest.approx(found.icc, rel=1e-3)


def test_groups_of_balanced_data_are_compared_by_their_animals():
    table = strides(slope=0.0)
    row = fit_mixed(table, "duty", ["group"], trials=False).terms.iloc[1]
    means = table.groupby(["group", "animal"])["duty"].mean()
    other = compare_two(means["control"].to_numpy(), means["lesion"].to_numpy())
    assert row["term"] == "group: lesion - control"
    assert row["estimate"] == pytest.approx(other.difference)
    pooled = math.sqrt((means["control"].var() + means["lesion"].var()) / 5)
    assert row["se"] == pytest.approx(pooled, rel=1e-4)
    assert row["df"] == 8
    assert row["p_strides"] < row["p"]


def test_terms_are_those_of_statsmodels():
    from statsmodels.regression.mixed_linear_model import MixedLM

    table = strides().iloc[7:]  # not balanced
    found = fit_mixed(table, "duty", ["speed", "group"], trials=False, slopes=False)
    lesion = (table["group"] == "lesion").astype(float)
    design = np.column_stack((np.ones(len(table)), table["speed"], lesion))
    other = MixedLM(table["duty"].to_numpy() * 100, design, groups=table["animal"]).fit()
    assert found.terms["estimate"].to_numpy() == pytest.approx(other.fe_params / 100, rel=1e-4)
    # statsmodels' errors are those of the whole Hessian; they differ a little
    assert found.terms["se"].to_numpy() == pytest.approx(other.bse_fe / 100, rel=0.03)
    assert found.sd_animals == pytest.approx(math.sqrt(other.cov_re[0, 0]) / 100, rel=1e-3)
    assert found.terms["df"].tolist() == [8, 102, 8]


def test_dyestuff():
    # Davies (1947), yields of 6 batches; lme4's documentation: 42.00 and 49.51, 1527.5 +- 19.38
    yields = [1545, 1440, 1440, 1520, 1580, 1540, 1555, 1490, 1560, 1495, 1595, 1550, 1605, 1510,
              1560, 1445, 1440, 1595, 1465, 1545, 1595, 1630, 1515, 1635, 1625, 1520, 1455, 1450,
              1480, 1445]  # fmt: skip
    table = pd.DataFrame({"animal": np.repeat(list("ABCDEF"), 5), "y": yields})
    found = fit_mixed(table, "y")
    assert found.sd_animals == pytest.approx(42.00, abs=0.005)
    assert found.sd_residual == pytest.approx(49.51, abs=0.005)
    assert found.terms.loc[0, "estimate"] == pytest.approx(1527.5)
    assert found.terms.loc[0, "se"] == pytest.approx(19.38, abs=0.005)
    table.loc[0, "y"] += 10
    assert fit_mixed(table, "y").sd_animals != pytest.approx(42.00, abs=0.005)


def test_variances_are_recovered():
    # 60 animals of 3 trials of 10 strides: sd 0.03, 0.01 and 0.02, slope -0.005
    found = fit_mixed(strides(k=60, n=30), "duty", ["speed"])
    assert found.sd_animals == pytest.approx(0.03, rel=0.25)
    assert found.sd_trials == pytest.approx(0.01, rel=0.25)
    assert found.sd_residual == pytest.approx(0.02, rel=0.05)
    assert found.icc == pytest.approx(9 / 14, abs=0.12)
    slope = found.terms.iloc[1]
    assert slope["ci_low"] < -0.005 < slope["ci_high"]
    assert slope["df"] == 59
    assert found.sd_slopes["speed"] < 0.001


def test_units_of_the_outcome_do_not_matter():
    table = strides()
    small = fit_mixed(table, "duty", ["speed", "group"])
    large = fit_mixed(table.assign(duty=table["duty"] * 1e6), "duty", ["speed", "group"])
    assert large.terms["p"].to_numpy() == pytest.approx(small.terms["p"].to_numpy(), rel=1e-3)
    assert large.icc == pytest.approx(small.icc, rel=1e-3)


def test_animals_with_slopes_of_their_own_widen_the_interval():
    rng = np.random.default_rng(2)
    table = strides(k=6)
    table["duty"] += rng.normal(0, 0.006, 6)[table["animal"]] * (table["speed"] - 20)
    own, common = (fit_mixed(table, "duty", ["speed"], slopes=s).terms.iloc[1] for s in (1, 0))
    assert own["se"] > 2 * common["se"]
    assert (own["df"], common["df"]) == (5, 72 - 6 - 1)


def test_trial_as_a_term_is_not_random_too():
    found = fit_mixed(strides(), "duty", ["trial"])
    assert math.isnan(found.sd_trials)
    assert found.terms["term"].tolist() == ["intercept", "trial"]


def test_no_variance_between_animals_is_told():
    rng = np.random.default_rng(3)
    table = pd.DataFrame({"animal": np.repeat(list("abcde"), 10), "y": rng.normal(0, 1, 50)})
    table["y"] -= table.groupby("animal")["y"].transform("mean")
    found = fit_mixed(table, "y")
    assert found.icc == pytest.approx(0.0, abs=1e-4)
    assert "no variance between animals found" in found.note
    assert fit_mixed(strides(), "duty").note == ""


@pytest.mark.slow
def test_level_with_five_animals():
    # no slope, animals with slopes of their own: 150 studies, standard error 1.8 %
    rng = np.random.default_rng(4)
    low = np.zeros(2)
    animal = np.repeat(np.arange(5), 10)
    for _ in range(150):
        x = rng.normal(0, 1, 50)
        y = rng.normal(0, 1, 5)[animal] + rng.normal(0, 0.5, 5)[animal] * x + rng.normal(0, 1, 50)
        terms = fit_mixed(pd.DataFrame({"animal": animal, "x": x, "y": y}), "y", ["x"]).terms
        low += terms.loc[1, ["p", "p_strides"]].to_numpy(dtype=float) <= 0.05
    assert low[0] / 150 <= 0.09
    assert low[1] / 150 > 0.2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: (t[t["animal"] == 0], []), "^mixed model: 12 strides of 1 animals"),
        (lambda t: (t.iloc[:0], []), "^mixed model: 0 strides of 0 animals"),
        (lambda t: (t[t["animal"].isin([0, 9])], ["group"]), "2 of them between animals; expected"),
        (
            lambda t: (t.assign(twice=2 * t["speed"]), ["speed", "twice"]),
            "terms repeat one another",
        ),
        (lambda t: (t.assign(duty=0.5), []), "the outcome is the same in all strides"),
        (lambda t: (t, ["animal"]), "^mixed model: animal and duty cannot be terms"),
        (lambda t: (t.assign(speed=np.inf), ["speed"]), "some values are infinite"),
        (lambda t: (t, ["mass"]), "column 'mass' is missing"),
    ],
)
def test_bad_input_is_refused(change, message):
    table, terms = change(strides())
    with pytest.raises(InputError, match=message):
        fit_mixed(table, "duty", terms)
