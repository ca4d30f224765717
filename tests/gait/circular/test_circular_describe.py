"""Description of phases against textbook and library answers.

Expected values: Zar, Biostatistical Analysis, 5th ed. (2010), examples 26.4-26.8, as
asserted by pycircstat2's tests; CircStat for MATLAB; R's package circular; astropy's tests.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from zar_samples import D1, D2_CENTRES, D2_COUNTS, D3, D7, M6, W7, W7_WEIGHTS, nudged

from pawnb.errors import InputError
from pawnb.gait.circular import circular_sd, mean_vector
from pawnb.gait.circular.describe import (
    angular_deviation,
    axial_mean,
    circular_median,
    circular_moment,
    concentration,
    describe_circular,
    difference,
    grouped_mean,
)


def differs(found, expected, tolerance):
    return abs(found - expected) > tolerance


def test_spreads_of_zars_example():
    found = describe_circular(D1)
    expected = {
        "mean": 98.9877519504 / 360,  # CircStat, scipy, R
        "r": 0.8252177448,
        "variance": 0.1747822552,  # R var, scipy circvar, CircStat S
        "circular_sd": 0.6198515860 / (2 * math.pi),  # R, scipy; Zar 36 degrees
        "angular_deviation": 0.5912398078 / (2 * math.pi),  # CircStat, R; Zar 34 degrees
        "median": 103 / 360,  # Zar, CircStat, R
        "ci_low": 68.05424387 / 360,  # pycircstat2; Zar 68 and 130 degrees
        "ci_high": 129.92126003 / 360,
    }
    twin = describe_circular(nudged(D1))._asdict()
    for name, value in expected.items():
        assert found._asdict()[name] == pytest.approx(value, abs=2e-9), name
        if name != "median":  # the first phase is not in the middle
            assert differs(twin[name], value, 2e-5), name
    assert found.n == 8
    assert 2 * found.variance == pytest.approx(0.3495645104)  # R angular.variance
    assert math.degrees(0.5912398078) == pytest.approx(33.8755, abs=1e-4)  # astropy circstd


def test_median_is_the_nearest_of_all_phases():
    rng = np.random.default_rng(11)
    for n in (1, 2, 3, 8, 51, 200):
        for phases in (
            rng.random(n),
            np.mod(rng.vonmises(0, 3, n) / 6.28, 1),
            rng.integers(0, 9, n) / 16,
        ):
            apart = np.abs(phases[:, None] - phases)
            away = np.minimum(apart, 1 - apart).mean(axis=1)
            nearest = mean_vector(np.unique(phases[away <= away.min() + 1e-12]))
            if nearest.r > 1e-9:
                assert difference(np.array([circular_median(phases)]), nearest.mean) == (
                    pytest.approx(0, abs=1e-12)
                )
            else:
                assert math.isnan(circular_median(phases))


def test_median_of_a_large_sample():
    # symmetrical about 0.3: to 5 standard errors, sqrt(pi / 2) of that of the mean
    phases = np.random.default_rng(0).normal(0.3, 0.05, 200_000)
    assert circular_median(phases) == pytest.approx(0.3, abs=5 * 1.25 * 0.05 / math.sqrt(2e5))


def test_median_of_an_odd_and_of_an_even_number():
    assert circular_median(D1[1:]) * 360 == pytest.approx(110)  # Zar 26.6 without the first
    assert circular_median(np.delete(D1, 4)) * 360 == pytest.approx(96)
    assert circular_median(np.array([0.98, 0.02])) % 1 == pytest.approx(0, abs=1e-12)
    assert math.isnan(circular_median(np.array([0.0, 0.25, 0.5, 0.75])))


def test_interval_of_concentrated_phases():
    found = describe_circular(D7)  # CircStat: mean 94.048171, half-width 12.691909
    assert (found.ci_high - found.ci_low) * 180 == pytest.approx(12.691909, abs=1e-5)
    twin = describe_circular(nudged(D7))
    assert differs((twin.ci_high - twin.ci_low) * 180, 12.691909, 1e-3)


@pytest.mark.parametrize(
    ("n", "method", "kappa"),
    [
        (None, "fisher", 3.20725664629),  # R mle.vonmises
        (8, "fisher", 2.115556),  # R with bias=TRUE; CircStat 2.1155558263
        # solves I1 / I0 = r: I1(3.2231362) / I0(3.2231362) = 0.8252177 (tables)
        (None, "exact", 3.2231362),
    ],
)
def test_concentration(n, method, kappa):
    r = mean_vector(D1).r
    assert concentration(r, n=n, method=method) == pytest.approx(kappa, rel=3e-7)
    assert concentration(mean_vector(nudged(D1)).r, n=n, method=method) != pytest.approx(
        kappa, rel=1e-3
    )


def test_concentration_of_extremes():
    assert concentration(0.0) == 0.0
    assert concentration(1.0) == math.inf
    assert concentration(0.2, n=5) == 0.0  # corrected below 0
    # large kappa: r = 1 - 1 / (2 kappa) to first order
    assert concentration(0.9999) == pytest.approx(5000, rel=1e-3)


@given(st.floats(0.001, 0.999))
def test_fishers_kappa_is_near_the_exact_one(r):
    assert concentration(r, method="fisher") == pytest.approx(concentration(r), rel=0.025)


@pytest.mark.parametrize(
    ("width", "r", "angular", "circular"),
    [
        (None, 0.5506350714, 54.317180, 62.590650),  # CircStat; Zar 0.55064
        (30 / 360, 0.5569757223, 53.932604, 61.987235),  # Zar 54 and 63 degrees
    ],
)
def test_grouped_phases(width, r, angular, circular):
    found = grouped_mean(D2_CENTRES, D2_COUNTS, class_width=width)
    assert found.n == 105
    assert found.mean * 360 == pytest.approx(161.56505118, abs=1e-7)  # Zar 162
    assert found.r == pytest.approx(r, abs=2e-10)
    assert angular_deviation(found.r) * 360 == pytest.approx(angular, abs=1e-6)
    assert circular_sd(found.r) * 360 == pytest.approx(circular, abs=1e-6)
    counts = D2_COUNTS.copy()
    counts[0] += 1
    assert grouped_mean(D2_CENTRES, counts, class_width=width).r != pytest.approx(r, abs=1e-4)


def test_axial_phases():
    found = axial_mean(D3)  # Zar 26.7
    assert 2 * found.mean * 360 == pytest.approx(95.9, abs=0.05)
    assert found.mean * 360 == pytest.approx(48, abs=0.5)
    assert found.r == pytest.approx(0.94843, abs=5e-6)
    assert axial_mean(nudged(D3)).r != pytest.approx(0.94843, abs=5e-6)
    x, y = np.cos(4 * np.pi * D3).sum(), np.sin(4 * np.pi * D3).sum()
    assert (y, x) == pytest.approx((14.15098, -1.46386), abs=5e-6)  # Zar's sums
    assert math.hypot(x, y) / 15 == pytest.approx(found.r)


@pytest.mark.parametrize(
    ("order", "angle", "length"),
    # astropy's tests, answers from R CircStats
    [(2, 1.588121, 0.4800428), (3, 1.963919, 0.236541), (4, 2.685556, 0.2255761)],
)
def test_moments(order, angle, length):
    found = circular_moment(M6, order)
    assert found.mean * 2 * math.pi == pytest.approx(angle, abs=5e-6)
    assert found.r == pytest.approx(length, abs=5e-5)
    assert circular_moment(nudged(M6), order).r != pytest.approx(length, abs=5e-5)


@pytest.mark.slow
def test_moments_are_those_of_astropy():
    from astropy.stats import circmoment

    for order in (1, 2, 3):
        angle, length = circmoment(2 * math.pi * D1, p=order)
        found = circular_moment(D1, order)
        assert found.r == pytest.approx(float(length))
        assert found.mean == pytest.approx(float(angle) / (2 * math.pi) % 1)


def test_weights():
    assert mean_vector(W7, weights=W7_WEIGHTS).r == pytest.approx(0.766282, abs=5e-7)  # astropy
    assert mean_vector(nudged(W7), weights=W7_WEIGHTS).r != pytest.approx(0.766282, abs=1e-4)
    repeated = np.repeat(W7, W7_WEIGHTS)
    assert mean_vector(repeated).r == pytest.approx(mean_vector(W7, weights=W7_WEIGHTS).r)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_differences_go_the_short_way(a, b):
    found = float(difference(np.array([a]), b)[0])
    assert -0.5 <= found < 0.5
    assert math.cos(2 * math.pi * (found - a + b)) == pytest.approx(1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: angular_deviation(-0.1), r"^r is -0\.1; expected the length"),
        (lambda: concentration(0.5, method="x"), "^method is 'x'; expected 'exact' or 'fisher'"),
        (lambda: circular_moment(D1, 0), "^order is 0; expected a whole number"),
        (lambda: grouped_mean(D1, np.ones(8), class_width=0.6), r"^class_width is 0\.6; expected"),
        (lambda: mean_vector(D1, weights=np.ones(3)), "^weights: expected 8 numbers of 0 or more"),
        (lambda: mean_vector(D1, weights=np.zeros(8)), "^weights: expected 8 numbers of 0 or more"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
