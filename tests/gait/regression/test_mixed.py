"""Mixed models against closed forms of balanced data and against statsmodels, and their level."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.groups.animals import mean_of_animals
from pawnb.gait.groups.differences import compare_two
from pawnb.gait.regression import slope_over_animals
from pawnb.gait.regression.mixed import MIXED_COLUMNS, fit_mixed


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
    assert (row["n"], row["n_animals"]) == (120, 10)
    assert row["df"] == pytest.approx(9.0, rel=1e-6)
    assert row["method"] == "Kenward-Roger"
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
    assert row["df"] == pytest.approx(8.0, rel=1e-6)
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
    assert 50 < slope["df"] < 60
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
    assert own["df"] == pytest.approx(5.0, abs=0.05)
    assert 60 < common["df"] <= 72 - 6 - 1


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


# lme4's sleepstudy (Belenky et al. 2003): reaction, ms, of 18 subjects on days 0 to 9
SLEEP = """
249.56 258.7047 250.8006 321.4398 356.8519 414.6901 382.2038 290.1486 430.5853 466.3535
222.7339 205.2658 202.9778 204.707 207.7161 215.9618 213.6303 217.7272 224.2957 237.3142
199.0539 194.3322 234.32 232.8416 229.3074 220.4579 235.4208 255.7511 261.0125 247.5153
321.5426 300.4002 283.8565 285.133 285.7973 297.5855 280.2396 318.2613 305.3495 354.0487
287.6079 285 301.8206 320.1153 316.2773 293.3187 290.075 334.8177 293.7469 371.5811
234.8606 242.8118 272.9613 309.7688 317.4629 309.9976 454.1619 346.8311 330.3003 253.8644
283.8424 289.555 276.7693 299.8097 297.171 338.1665 332.0265 348.8399 333.36 362.0428
265.4731 276.2012 243.3647 254.6723 279.0244 284.1912 305.5248 331.5229 335.7469 377.299
241.6083 273.9472 254.4907 270.8021 251.4519 254.6362 245.4523 235.311 235.7541 237.2466
312.3666 313.8058 291.6112 346.1222 365.7324 391.8385 404.2601 416.6923 455.8643 458.9167
236.1032 230.3167 238.9256 254.922 250.7103 269.7744 281.5648 308.102 336.2806 351.6451
256.2968 243.4543 256.2046 255.5271 268.9165 329.7247 379.4445 362.9184 394.4872 389.0527
250.5265 300.0576 269.8939 280.5891 271.8274 304.6336 287.7466 266.5955 321.5418 347.5655
221.6771 298.1939 326.8785 346.8555 348.7402 352.8287 354.4266 360.4326 375.6406 388.5417
271.9235 268.4369 257.2424 277.6566 314.8222 317.2135 298.1353 348.1229 340.28 366.5131
225.264 234.5235 238.9008 240.473 267.5373 344.1937 281.1481 347.5855 365.163 372.2288
269.8804 272.4428 277.8989 281.7895 279.1705 284.512 259.2658 304.6306 350.7807 369.4692
269.4117 273.474 297.5968 310.6316 287.1726 329.6076 334.4818 343.2199 369.1417 364.1236"""


def test_sleepstudy():
    reaction = np.array(SLEEP.split(), dtype=float)
    table = pd.DataFrame({"animal": np.repeat(np.arange(18), 10), "days": np.tile(range(10), 18)})
    row = fit_mixed(table.assign(y=reaction), "y", ["days"]).terms.iloc[1]
    # lmerTest: 10.467, 1.546, df 17.000, t 6.771; pbkrtest: F 45.853, ddf 17, p 3.264e-06
    assert row["estimate"] == pytest.approx(10.467, abs=5e-4)
    assert row["se"] == pytest.approx(1.546, abs=5e-4)
    assert row["df"] == pytest.approx(17.0, abs=5e-3)
    assert row["t"] == pytest.approx(6.771, abs=1e-3)
    assert row["p"] == pytest.approx(3.264e-06, abs=2e-9)


# nlme's Oats (Yates 1935): 6 blocks of Victory, Golden Rain and Marvellous at 4 levels of nitrogen
OATS = """111 130 157 174 117 114 161 141 105 140 118 156 61 91 97 100 70 108 126 149 96 124 121 144
68 64 112 86 60 102 89 96 89 129 132 124 74 89 81 122 64 103 132 133 70 89 104 117 62 90 100 116
80 82 94 126 63 70 109 99 53 74 118 113 89 82 86 104 97 99 119 121"""


def oats():
    """The unbalanced part of emmeans' vignette: yield ~ Variety + nitro + (1|Block/Variety)."""
    table = pd.DataFrame({"y": np.array(OATS.split(), dtype=float)})
    table["animal"], table["trial"] = np.repeat(range(6), 12), np.tile(np.repeat(range(3), 4), 6)
    table["nitro"] = np.tile(range(4), 18)
    table["golden"], table["marvellous"] = (
        (table["trial"] == i) * 1.0 - (table["trial"] == 0) for i in (1, 2)
    )
    return table.drop(index=np.array([1, 2, 3, 5, 8, 13, 21, 34, 55]) - 1)


@pytest.mark.parametrize(
    ("nitro", "mean", "se", "df", "low", "high"),
    # emmeans(Oats.lmer, "nitro"), Kenward-Roger by pbkrtest, printed in emmeans' vignette
    [(0, 78.89207, 7.294379, 7.78, 61.98930, 95.79484),
     (1, 97.03425, 7.136271, 7.19, 80.25029, 113.81822),
     (2, 114.19816, 7.136186, 7.19, 97.41454, 130.98179),
     (3, 124.06857, 7.070235, 6.95, 107.32795, 140.80919)],
)  # fmt: skip
def test_unbalanced_trials_in_animals_are_those_of_pbkrtest(nitro, mean, se, df, low, high):
    table = oats()
    others = [f"n{i}" for i in range(4) if i != nitro]
    for name in others:
        table[name] = (table["nitro"] == int(name[1])) * 1.0
    found = fit_mixed(table, "y", ["golden", "marvellous", *others], slopes=False)
    row = found.terms.iloc[0]
    assert row["estimate"] == pytest.approx(mean, rel=1e-5)
    assert row["se"] == pytest.approx(se, rel=5e-5)
    assert row["df"] == pytest.approx(df, abs=5.1e-3)
    assert (row["ci_low"], row["ci_high"]) == pytest.approx((low, high), rel=1e-5)
    assert found.note == ""


def test_contrasts_between_and_within_trials_are_those_of_pbkrtest():
    # ibid.: Golden Rain - Victory 8.31, 6.71, 9.80 and Marvellous - Victory 11.54, 6.67, 9.80;
    # linear contrast of nitrogen (weights -3 -1 1 3) 152.69, 15.58, 43.2
    table = oats()
    table["golden"], table["marvellous"] = ((table["trial"] == i) * 1.0 for i in (1, 2))
    weights = np.array([[-3.0, -1, 1, 3], [1, -1, -1, 1], [-1, 3, -3, 1]])
    for name, w in zip(("linear", "square", "cubic"), weights, strict=True):
        table[name] = (w / (w @ w))[table["nitro"]]
    terms = ["golden", "marvellous", "linear", "square", "cubic"]
    found = fit_mixed(table, "y", terms, slopes=False).terms.set_index("term")
    assert found.loc["golden", "estimate"] == pytest.approx(8.31, abs=0.005)
    assert found.loc[["golden", "marvellous"], "se"].tolist() == pytest.approx(
        [6.71, 6.67], abs=0.005
    )
    assert found.loc[["golden", "marvellous"], "df"].tolist() == pytest.approx(
        [9.8, 9.8], abs=0.005
    )
    assert found.loc["linear", "estimate"] == pytest.approx(152.69, abs=0.005)
    assert found.loc["linear", "se"] == pytest.approx(15.58, abs=0.005)
    assert found.loc["linear", "df"] == pytest.approx(43.2, abs=0.05)


def balanced_slopes(seed, *, k, sd, effect=0.0, n=10):
    """Animals of n strides at the same x; their slopes differ by ``sd``."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-1.5, 1.5, n)
    own = rng.normal(0, 1, (k, 1)) + (effect + sd * rng.normal(0, 1, (k, 1))) * x
    y = own + rng.normal(0, 1, (k, n))
    who = np.repeat(np.arange(k), n)
    return pd.DataFrame({"animal": who, "x": np.tile(x, k), "y": y.ravel()})


@pytest.mark.parametrize("sd", [0.0, 2.0])
@pytest.mark.parametrize("k", [3, 8])
def test_slope_of_balanced_data_is_the_t_test_of_the_animals_slopes(sd, k):
    # whether or not a variance of slopes is found: exact for normal values
    methods = set()
    for seed in range(6):
        table = balanced_slopes(seed, k=k, sd=sd, effect=0.4)
        row = fit_mixed(table, "y", ["x"]).terms.iloc[1]
        one = slope_over_animals(table["x"], table["y"], animals=table["animal"].astype(str))
        assert (row["estimate"], row["p"]) == pytest.approx((one.b, one.p), rel=1e-3)
        assert row["df"] == pytest.approx(k - 1, rel=1e-3)
        methods.add(row["method"])
    assert "Kenward-Roger" in methods
    assert ("CR2 of animals" in methods) >= (sd == 0.0)


def test_error_of_animals_without_variance_between_them():
    # CR2 of a mean of unequal clusters, by hand: sum of (n_i e_i)^2 / (1 - n_i / N), over N^2,
    # e_i the mean residual of each
    rng = np.random.default_rng(3)
    counts = np.array([4, 9, 15, 6])
    table = pd.DataFrame({"animal": np.repeat(list("abcd"), counts), "y": rng.normal(0, 1, 34)})
    table["y"] -= 0.9 * table.groupby("animal")["y"].transform("mean")
    found = fit_mixed(table, "y")
    assert found.sd_animals == 0.0
    rest = (table["y"] - table["y"].mean()).groupby(table["animal"]).mean().to_numpy()
    error = math.sqrt(((counts * rest) ** 2 / (1 - counts / 34)).sum()) / 34
    row = found.terms.iloc[0]
    assert row["method"] == "CR2 of animals"
    assert row["se"] == pytest.approx(error)
    assert 2 < row["df"] < 3


def test_variances_that_are_not_told_apart_are_noted():
    # an animal of one stride beside one other: its level and its slope are one number
    table = balanced_slopes(2, k=2, sd=1.0).iloc[:11]
    found = fit_mixed(table, "y", ["x"])
    assert found.terms[["p", "ci_low", "ci_high"]].isna().all(axis=None)
    assert "do not tell the variances of animals, slopes and trials apart" in found.note
    assert "1 of 2 animals have one stride or one value of x" in found.note
    three = fit_mixed(balanced_slopes(2, k=3, sd=1.0).iloc[:21], "y", ["x"])
    assert three.terms["p"].notna().all()
    assert "1 of 3 animals have one stride" in three.note
    assert "apart" not in three.note


@pytest.mark.slow
@pytest.mark.parametrize("sd", [0.0, 1.0])
def test_level_of_slopes(sd):
    # 250 studies of 3 unequal animals, standard error 1.4 %; benchmarks/few_animals.py has more
    rng, k = np.random.default_rng(4), 3
    animal = np.repeat(np.arange(k), [10, 20, 6])
    low = np.zeros(2)
    for _ in range(250):
        x = rng.normal(0, 1, len(animal))
        y = rng.normal(0, 1, k)[animal] + sd * rng.normal(0, 1, k)[animal] * x
        y += rng.normal(0, 1, len(animal))
        terms = fit_mixed(pd.DataFrame({"animal": animal, "x": x, "y": y}), "y", ["x"]).terms
        low += terms.loc[1, ["p", "p_strides"]].to_numpy(dtype=float) <= 0.05
    assert 0.01 <= low[0] / 250 <= 0.08
    if sd:
        assert low[1] / 250 > 0.2


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
        (lambda t: (t.assign(speed=np.inf), ["speed"]), "column 'speed' is infinite in row 1"),
        (lambda t: (t, ["mass"]), "column 'mass' is missing"),
    ],
)
def test_bad_input_is_refused(change, message):
    table, terms = change(strides())
    with pytest.raises(InputError, match=message):
        fit_mixed(table, "duty", terms)
