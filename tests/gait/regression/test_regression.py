"""Regression: against R's cars, the worked examples, Bland & Altman, and exact properties."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.gait.regression import (
    compare_slope,
    fit_line,
    fit_power,
    fit_rma,
    fit_within_animals,
    slope_over_animals,
    sprugel_factor,
)
from pawnb.gait.regression.covariates import fit_covariates

# R's data set cars (Ezekiel 1930): speed in mph, stopping distance in ft
SPEED = [4, 4, 7, 7, 8, 9, 10, 10, 10, 11, 11, 12, 12, 12, 12, 13, 13, 13, 13, 14, 14, 14, 14, 15,
         15, 15, 16, 16, 17, 17, 17, 18, 18, 18, 18, 19, 19, 19, 20, 20, 20, 20, 20, 22, 23, 24,
         24, 24, 24, 25]  # fmt: skip
DIST = [2, 10, 4, 22, 16, 10, 18, 26, 34, 17, 28, 14, 20, 24, 28, 26, 34, 34, 46, 26, 36, 60, 80,
        20, 26, 54, 32, 40, 32, 40, 50, 42, 56, 76, 84, 36, 46, 68, 32, 48, 52, 56, 64, 66, 54,
        70, 92, 93, 120, 85]  # fmt: skip
# Bland & Altman (1995) BMJ 310:446, Table I: intramural pH and PaCO2 of eight subjects
SUBJECT = [1] * 4 + [2] * 4 + [3] * 9 + [4] * 5 + [5] * 8 + [6] * 6 + [7] * 3 + [8] * 8
PH = [6.68, 6.53, 6.43, 6.33, 6.85, 7.06, 7.13, 7.17, 7.4, 7.42, 7.41, 7.37, 7.34, 7.35, 7.28, 7.3,
      7.34, 7.36, 7.33, 7.29, 7.3, 7.35, 7.35, 7.3, 7.3, 7.37, 7.27, 7.28, 7.32, 7.32, 7.38, 7.3,
      7.29, 7.33, 7.31, 7.33, 6.86, 6.94, 6.92, 7.19, 7.29, 7.21, 7.25, 7.2, 7.19, 6.77,
      6.82]  # fmt: skip
PACO2 = [3.97, 4.12, 4.09, 3.97, 5.27, 5.37, 5.41, 5.44, 5.67, 3.64, 4.32, 4.73, 4.96, 5.04, 5.22,
         4.82, 5.07, 5.67, 5.1, 5.53, 4.75, 5.51, 4.28, 4.44, 4.32, 3.23, 4.46, 4.72, 4.75, 4.99,
         4.78, 4.73, 5.12, 4.93, 5.03, 4.93, 6.85, 6.44, 6.52, 5.28, 4.56, 4.34, 4.32, 4.41, 3.69,
         6.09, 5.58]  # fmt: skip


def with_moments(n, slope, r2, *, seed=0, sd_x=0.2):
    """Return x and y with exactly this least-squares slope and share explained."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(n)
    x = sd_x * (x - x.mean()) / x.std()
    noise = rng.standard_normal(n)
    basis = np.column_stack((np.ones(n), x))
    noise -= basis @ np.linalg.lstsq(basis, noise, rcond=None)[0]
    noise *= abs(slope) * sd_x * math.sqrt((1 - r2) / r2) / noise.std()
    return x, slope * x + noise


def test_least_squares_is_that_of_r():
    # R: summary(lm(dist ~ speed, cars)) prints these digits
    line = fit_line(SPEED, DIST)
    assert (round(line.a, 4), round(line.b, 4)) == (-17.5791, 3.9324)
    assert (round(line.b_se, 4), round(line.t, 3), round(line.see, 2)) == (0.4155, 9.464, 15.38)
    assert round(line.r2, 4) == 0.6511
    assert line.p == pytest.approx(1.49e-12, rel=5e-3)
    # confint(): 3.096964 4.767853; -31.167850 -3.990340
    assert (line.b_low, line.b_high) == pytest.approx((3.096964, 4.767853), abs=1e-6)
    assert (line.a_low, line.a_high) == pytest.approx((-31.167850, -3.990340), abs=1e-6)
    assert line.significant
    # a perturbed twin
    other = fit_line(SPEED, [*DIST[:-1], DIST[-1] + 3])
    assert round(other.b, 4) != 3.9324
    assert other.b_high != pytest.approx(4.767853, abs=1e-4)


def test_band_is_that_of_r():
    # R: predict(lm(dist ~ speed, cars), data.frame(speed = c(12, 19, 24)), "confidence")
    band = fit_line(SPEED, DIST).predict(np.array([12.0, 19.0, 24.0]))
    expected = [
        [29.60981, 24.39514, 34.82448],
        [57.13667, 51.82913, 62.44421],
        [76.79872, 68.38765, 85.20978],
    ]
    np.testing.assert_allclose(band[["fit", "low", "high"]], expected, atol=6e-6)
    other = fit_line(SPEED, DIST, level=0.94).predict(np.array([12.0, 19.0, 24.0]))
    assert not np.allclose(other["low"], [row[1] for row in expected], atol=0.05)


@pytest.mark.parametrize(
    ("slope", "r2", "se", "low", "high", "p", "rma"),
    # log10-log10 regressions of 21 mice on speed (worked examples, MouseWalker rows)
    [
        (-0.92194326, 0.657241, 0.15274233, -1.241637, -0.602250, 8.32e-06, -1.13721307),
        (-0.81099116, 0.687244, 0.12551252, -1.073692, -0.548290, 3.418e-06, -0.97827455),
        (-1.01627629, 0.617029, 0.18368125, -1.400726, -0.631827, 2.453e-05, -1.29377539),
        (-0.35827637, 0.323200, 0.11894224, -0.607225, -0.109327, 0.007166, -0.63020617),
    ],
)
def test_power_laws_of_the_worked_examples(slope, r2, se, low, high, p, rma):
    x, y = with_moments(21, slope, r2)
    line = fit_power(10**x, 10**y)
    assert line.b == pytest.approx(slope, abs=1e-8)
    assert line.b_se == pytest.approx(se, rel=3e-6)
    assert (line.b_low, line.b_high) == pytest.approx((low, high), abs=3e-6)
    assert line.p == pytest.approx(p, rel=1e-3)
    axis = fit_rma(10**x, 10**y, kind="power")
    assert axis.b == pytest.approx(rma, rel=3e-6)
    assert axis.p == pytest.approx(line.p)
    # a perturbed twin: 20 mice
    fewer = fit_power(*(10**v for v in with_moments(20, slope, r2)))
    assert fewer.b_se != pytest.approx(se, rel=1e-3)
    turned = fit_rma(10**x, 10**y, kind="linear")
    assert turned.b != pytest.approx(rma, rel=1e-3)


def test_interval_of_the_reduced_major_axis():
    # R lmodel2 on 20 points with r2 = 0.3722 and OLS slope 0.2591 prints SMA 0.4247, interval
    # 0.28957 to 0.6228 (rstudio-pubs 22815)
    x, y = with_moments(20, 0.2591, 0.3722, sd_x=9.0)
    axis = fit_rma(x, y)
    assert axis.b == pytest.approx(0.4247, abs=5e-5)
    assert (axis.b_low, axis.b_high) == pytest.approx((0.28957, 0.6228), abs=1e-4)
    assert fit_rma(x, y, level=0.9).b_low != pytest.approx(0.28957, abs=1e-3)
    # the test against an expected slope agrees with the interval at its ends
    for end in (axis.b_low, axis.b_high):
        assert compare_slope(axis, end).p == pytest.approx(0.05, abs=1e-9)


@pytest.mark.parametrize(
    ("b", "low", "high", "r2"),
    # paper 2009, Table 4.3, n = 15: maximum and minimum speed and mean stride length on mass
    [(0.243, -0.174, 0.659, 0.109), (0.409, -0.524, 1.341, 0.065), (0.433, 0.150, 0.716, 0.457)],
)
def test_intervals_of_the_paper(b, low, high, r2):
    x, y = with_moments(15, b, r2)
    line = fit_power(np.exp(x), np.exp(y))
    assert (line.b_low, line.b_high) == pytest.approx((low, high), abs=5e-3)
    assert line.significant == (low > 0)
    twin = fit_power(*(np.exp(v) for v in with_moments(17, b, r2)))
    assert (twin.b_low, twin.b_high) != pytest.approx((low, high), abs=5e-3)


def test_slopes_against_expected_ones():
    # paper 2009, Table 4.4: 0.24 (table 4.3: 0.243) does not differ from 0 (Hill) nor from 0.24
    x, y = with_moments(15, 0.243, 0.109)
    line = fit_power(np.exp(x), np.exp(y))
    hill, heglund = compare_slope(line, 0.0), compare_slope(line, 0.24)
    # se from the paper's own interval: (0.659 + 0.174) / 2 / t(13) with t(13) = 2.1604
    assert hill.t == pytest.approx(0.243 / (0.4165 / 2.1604), rel=0.01)
    assert hill.df == 13
    assert hill.p == pytest.approx(line.p)
    assert not hill.differs
    assert heglund.p > 0.98
    for end in (line.b_low, line.b_high):
        assert compare_slope(line, end).p == pytest.approx(0.05, abs=1e-9)
    assert compare_slope(line, line.b_high + 0.01).differs


def test_sprugel_gives_the_mean_back():
    # exact for normal residuals: the mean of exp(N(mu, s)) is exp(mu + s^2 / 2)
    rng = np.random.default_rng(2)
    x = np.exp(rng.uniform(0, 2, 40000))
    y = 3.0 * x**0.7 * np.exp(0.6 * rng.standard_normal(len(x)))
    line = fit_power(x, y)
    assert line.correction == pytest.approx(math.exp(0.6**2 / 2), rel=0.01)
    assert line.a == pytest.approx(3.0 * math.exp(0.18), rel=0.02)
    near = np.abs(x - 3.0) < 0.2
    fit = line.predict(np.array([3.0]))["fit"].iloc[0]
    assert fit == pytest.approx(y[near].mean(), rel=0.03)
    plain = fit_power(x, y, corrected=False)
    assert plain.predict(np.array([3.0]))["fit"].iloc[0] == pytest.approx(
        np.median(y[near]), rel=0.05
    )
    assert plain.a < 0.9 * line.a


def test_sprugel_in_both_bases():
    # Sprugel (1983): with logarithms to base 10 the standard error is first multiplied by 2.303
    assert sprugel_factor(0.1, base=10.0) == pytest.approx(math.exp((2.303 * 0.1) ** 2 / 2), 1e-4)
    assert sprugel_factor(0.1 * math.log(10)) == pytest.approx(sprugel_factor(0.1, base=10.0))
    assert sprugel_factor(0.0) == 1.0


def test_slope_within_subjects_is_that_of_bland_and_altman():
    # Bland & Altman (1995): r = -0.51, p = 0.0008 within subjects; pingouin's rm_corr on the
    # same data: r -0.50677, 38 degrees of freedom, p 0.000847
    line = fit_within_animals(PACO2, PH, animals=SUBJECT)
    assert round(line.r, 5) == -0.50677
    assert line.df == 38
    assert round(line.p, 6) == 0.000847
    assert (line.n, line.n_animals) == (47, 8)
    assert line.significant
    plain = fit_line(PACO2, PH)
    assert plain.p > 0.5  # through all points there is nothing to see
    twin = fit_within_animals(PACO2, PH, animals=[*SUBJECT[:-1], 7])
    assert round(twin.r, 5) != -0.50677


def test_mean_slope_of_animals_is_a_one_sample_t_test():
    # Student's (1908) sleep data: extra hours under drug 2 minus drug 1; R: t.test(extra, paired)
    # gives t = 4.0621, df = 9, p = 0.002833, interval 0.7001142 to 2.4598858, mean 1.58
    one = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
    two = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
    x, animals = np.repeat([0.0, 1.0], 10), list("abcdefghij") * 2
    found = slope_over_animals(x, [*one, *two], animals=animals)
    assert (round(found.b, 2), round(found.t, 4), found.df) == (1.58, 4.0621, 9)
    assert round(found.p, 6) == 0.002833
    assert (found.b_low, found.b_high) == pytest.approx((0.7001142, 2.4598858), abs=1e-7)
    assert found.n_animals == 10
    twin = slope_over_animals(x, [*one, *two[:-1], 4.4], animals=animals)
    assert round(twin.t, 4) != 4.0621
    more = slope_over_animals([*x, 5.0], [*one, *two, 9.0], animals=[*animals, "k"])
    assert more.left_out == ("k",)
    assert more.p == found.p


def test_what_never_varies_has_no_slope_and_no_nan():
    x, animals = np.arange(6.0), list("aaabbb")
    line, inside = fit_line(x, 0 * x), fit_within_animals(x, 0 * x, animals=animals)
    over = slope_over_animals(x, 0 * x, animals=animals)
    for found in (line, inside, over):
        assert (found.b, found.t, found.p, found.significant) == (0.0, 0.0, 1.0, False)
    assert compare_slope(line, 1.0).differs
    assert not compare_slope(line, 0.0).differs


def test_animals_are_counted():
    line = fit_line(PACO2, PH, animals=SUBJECT)
    assert (line.n, line.n_animals) == (47, 8)
    assert fit_line(PACO2, PH).n_animals is None
    missing = [*PH[:-1], math.nan]
    assert fit_line(PACO2, missing, animals=SUBJECT).n == 46


def test_covariates_are_those_of_ancova():
    # a group that differs by 2 at equal speed, and is faster; checked by the normal equations
    rng = np.random.default_rng(4)
    group = np.repeat(["a", "b"], 12)
    speed = rng.uniform(10, 20, 24) + 6.0 * (group == "b")
    y = 1.0 + 0.5 * speed + 2.0 * (group == "b") + 0.1 * rng.standard_normal(24)
    table = pd.DataFrame({"animal": np.arange(24), "group": group, "speed": speed, "y": y})
    found = fit_covariates(table, "y", ["group", "speed"]).set_index("term")
    design = np.column_stack((np.ones(24), group == "b", speed)).astype(float)
    beta = np.linalg.solve(design.T @ design, design.T @ y)
    np.testing.assert_allclose(found["estimate"], beta, rtol=1e-9)
    assert found.index.tolist() == ["intercept", "group: b - a", "speed"]
    assert found.loc["group: b - a", "ci_low"] < 2.0 < found.loc["group: b - a", "ci_high"]
    assert set(found["n_animals"]) == {24}
    left = y - design @ beta
    se = np.sqrt(left @ left / 21 * np.linalg.inv(design.T @ design)[1, 1])
    assert found.loc["group: b - a", "se"] == pytest.approx(se)
    alone = fit_covariates(table, "y", ["group"]).set_index("term")
    assert alone.loc["group: b - a", "estimate"] > 4.0


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10_000), st.floats(0.1, 10), st.floats(-5, 5), st.integers(4, 30))
def test_stars_follow_the_interval_and_units_do_not_matter(seed, scale, shift, n):
    x, y = np.random.default_rng(seed).standard_normal((2, n))
    line, moved = fit_line(x, y), fit_line(scale * x + shift, y)
    assert line.significant == (line.p < 0.05)
    assert line.significant == (not line.b_low <= 0.0 <= line.b_high)
    assert moved.b == pytest.approx(line.b / scale, rel=1e-6, abs=1e-9)
    assert moved.p == pytest.approx(line.p, rel=1e-5)
    assume(abs(line.r) > 1e-6)
    # the reduced major axis is steeper than least squares by 1 / |r|, and symmetrical
    axis, swapped = fit_rma(x, y), fit_rma(y, x)
    assert axis.b == pytest.approx(line.b / abs(line.r), rel=1e-6)
    assert swapped.b == pytest.approx(1 / axis.b, rel=1e-6)
    assert compare_slope(axis, axis.b).p == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fit_line([1, 2], [1, 2]), r"^regression: 2 points; expected at least 3 points"),
        (lambda: fit_line([1, 1, 1], [1, 2, 3]), r"^regression: all x are equal; expected"),
        (
            lambda: fit_line([0.1 + 0.2, 0.3, 0.3, 0.3], [1, 2, 3, 4]),
            r"^regression: all x are equal; expected",
        ),
        (lambda: fit_line([1, 2, 3], [1, 2]), r"^regression: x has shape \(3,\), y \(2,\); exp"),
        (lambda: fit_line([1, 2, 3], [1, 2, 4], level=95), r"^level is 95; expected between 0"),
        (lambda: fit_power([1, 2, 0], [1, 2, 3]), r"^power law: 1 points are not above 0 in x"),
        (lambda: fit_rma([1, 2, 3], [1, 1, 1]), r"^reduced major axis: all y are equal; exp"),
        (lambda: fit_rma([1, 2, 3], [1, 2, 3], kind="log"), r"^kind is 'log'; expected 'linear'"),
        (
            lambda: fit_within_animals([1, 1, 2, 2], [1, 2, 3, 4], animals=list("aabb")),
            r"x that does not vary in them; expected more points than animals",
        ),
        (
            lambda: slope_over_animals([1, 2, 2, 2], [1, 2, 3, 4], animals=list("aabb")),
            r"^slopes of animals: 1 animals have two points of different x; expected",
        ),
        (lambda: compare_slope(fit_line([1, 2, 3], [1, 2, 4]), math.nan), r"^expected slope is n"),
        (lambda: compare_slope(fit_rma([1, 2, 3], [1, 2, 4]), 0.0), r"^expected slope is 0\.0;"),
        (
            lambda: fit_power([1, 2, 3], [1, 2, 4]).predict(np.array([0.0])),
            r"^predict: expected x above 0",
        ),
        (
            lambda: fit_covariates(pd.DataFrame({"y": [1.0, 2.0], "x": [1.0, 2.0]}), "y", ["x"]),
            r"^regression: 2 points for 2 coefficients; expected more points\.$",
        ),
        (
            lambda: fit_covariates(
                pd.DataFrame({"y": [1.0, 2, 4, 3], "x": [1.0, 2, 3, 4], "z": [2.0, 4, 6, 8]}),
                "y", ["x", "z"],
            ),
            r"^regression: the terms repeat one another or do not vary; leave one out\.$",
        ),
        (lambda: sprugel_factor(-1.0), r"^see is -1\.0, base"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
