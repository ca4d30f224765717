"""Circular statistics against textbook and library answers.

Sources of the expected values: Zar, Biostatistical Analysis, 5th ed. (2010), examples
26.4-26.8 and 27.1, as asserted by pycircstat2's tests; CircStat for MATLAB; R's package
circular. The exact p of Rayleigh's test were found by importance sampling (relative
error 0.1-0.3 %), checked against plain Monte Carlo.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from zar_samples import D1, D7, M6

from pawnb.errors import InputError
from pawnb.gait.circular import circular_sd, mean_interval, mean_vector, rayleigh_p, wrap

phases = st.lists(st.floats(0, 1, exclude_max=True), min_size=2, max_size=30)


@pytest.mark.parametrize(
    ("sample", "degrees", "r", "tolerance"),
    [
        (D1, 98.9877519504, 0.8252177448, 1e-9),  # Zar 26.4: 99 degrees, .82522
        (M6, 48.63, 1 - 0.1635635, 1e-4),
    ],
)
def test_mean_vector(sample, degrees, r, tolerance):
    found = mean_vector(sample)
    assert found.mean * 360 == pytest.approx(degrees, rel=max(tolerance, 1e-9), abs=5e-3)
    assert found.r == pytest.approx(r, abs=max(tolerance, 1e-9))
    assert found.n == len(sample)
    # a perturbed twin is noticed
    twin = sample.copy()
    twin[0] += 1 / 360
    assert mean_vector(twin).r != pytest.approx(r, abs=max(tolerance, 1e-9))


def test_phases_across_zero_average_to_zero():
    found = mean_vector(np.array([0.98, 0.02]))
    assert min(found.mean, 1 - found.mean) < 1e-12
    assert 0 <= found.mean < 1


def test_opposite_phases_have_no_mean():
    found = mean_vector(np.array([0.1, 0.6]))
    assert math.isnan(found.mean)
    assert found.r == 0.0


def test_circular_sd_is_mardias():
    # Zar 26.4: 36 degrees (CircStat 35.514880); the angular deviation would be 33.88
    assert circular_sd(0.8252177448) * 360 == pytest.approx(35.514880, abs=1e-5)
    assert circular_sd(1.0) == 0.0
    assert circular_sd(0.0) == math.inf


@pytest.mark.parametrize(
    ("n", "r", "p"),
    [
        (8, 0.8252177448, 0.00165),
        (10, 0.9521367227, 6.13e-7),  # the series gives a negative p here
        (24, 0.5630447494, 2.88e-4),
        (5, 0.9202565211, 0.00477),
        (13, 0.2156367785, 0.5558),
        (5, 0.4972303450, 0.3088),
        (9, 0.95598180, 2.12e-6),
        (25, 0.94232823, 3.1e-16),  # Zar's formula is 70 times larger
        (6, 0.99, 6.6e-6),
    ],
)
def test_exact_rayleigh_p(n, r, p):
    assert rayleigh_p(n, r) == pytest.approx(p, rel=0.01, abs=0.0)
    assert rayleigh_p(n, r) != pytest.approx(1.05 * p, rel=0.01, abs=0.0)


def test_two_phases_have_a_closed_form():
    # r = |cos(d / 2)| for a difference d that is uniform on the circle
    assert rayleigh_p(2, 0.5) == pytest.approx(2 / 3, rel=1e-12)


def test_three_phases_against_monte_carlo():
    # 2e6 draws: 0.48786 +- 0.00035 at r = 0.5, 0.04192 +- 0.00014 at r = 0.95
    assert rayleigh_p(3, 0.5) == pytest.approx(0.4883, abs=0.001)
    assert rayleigh_p(3, 0.95) == pytest.approx(0.0419, abs=0.0004)


def test_p_of_nearly_equal_phases_goes_as_a_power():
    # n - 1 differences near 0: p goes as (1 - r)^((n - 1) / 2)
    for far, near in ((4e-6, 1e-6), (1.1e-5, 0.9e-5), (4e-4, 3.9e-4)):
        ratio = rayleigh_p(5, 1 - far) / rayleigh_p(5, 1 - near)
        assert ratio == pytest.approx((far / near) ** 2, rel=1e-3)


def test_many_phases_approach_exp_minus_z():
    # Rayleigh's own limit for large n
    assert rayleigh_p(5000, 0.03) == pytest.approx(math.exp(-5000 * 0.03**2), rel=0.01)


@settings(deadline=None)
@given(st.integers(3, 60), st.floats(0.0, 1.0), st.floats(0.0, 0.2))
def test_p_is_a_probability_and_falls_with_r(n, r, more):
    p = rayleigh_p(n, r)
    assert 0 < p <= 1
    assert rayleigh_p(n, min(1.0, r + more)) <= p * (1 + 1e-5)


def test_interval_of_the_mean():
    # Zar 26.6 (r <= 0.9): 68 to 130 degrees; CircStat half-width 30.9335080837
    mean, r, n = mean_vector(D1)
    low, high = mean_interval(mean, r, n)
    assert (high - low) * 180 == pytest.approx(30.9335080837, abs=1e-6)
    assert low * 360 == pytest.approx(68.05424387, abs=1e-6)
    # r > 0.9: CircStat mean 94.048171, half-width 12.691909
    low, high = mean_interval(*mean_vector(D7))
    assert (low + high) * 180 == pytest.approx(94.048171, abs=1e-5)
    assert (high - low) * 180 == pytest.approx(12.691909, abs=1e-5)


def test_interval_may_wrap():
    low, high = mean_interval(0.01, 0.8252177448, 8)
    assert low > high
    assert (high - low) % 1.0 * 180 == pytest.approx(30.9335080837, abs=1e-6)


@pytest.mark.parametrize(("r", "n"), [(0.1, 10), (0.6, 4)])
def test_interval_of_a_mean_that_may_be_any_is_95_percent_of_the_cycle(r, n):
    assert mean_interval(0.2, r, n) == pytest.approx((0.725, 0.675))
    assert mean_interval(math.nan, 0.0, n) == (0.0, 1.0)


def test_one_phase_has_no_interval():
    assert all(math.isnan(v) for v in mean_interval(0.2, 1.0, 1))


@pytest.mark.parametrize("bad", [200.0, 6.1, -180.0, 1e308])
def test_degrees_and_radians_are_refused(bad):
    with pytest.raises(InputError, match=r"^phases: 1 of 3 are far from a cycle, such as .*360"):
        mean_vector(np.array([0.1, bad, 0.3]))


@settings(deadline=None)
@given(phases, st.floats(0, 1))
def test_mean_turns_with_the_phases(values, turn):
    values = np.array(values)
    before, after = mean_vector(values), mean_vector(values + turn)
    assert after.r == pytest.approx(before.r, abs=1e-9)
    if before.r > 1e-3:
        difference = (after.mean - before.mean - turn + 0.5) % 1.0 - 0.5
        assert difference == pytest.approx(0.0, abs=1e-9)


@settings(deadline=None)
@given(phases)
def test_mean_mirrors_with_the_phases(values):
    values = np.array(values)
    before, after = mean_vector(values), mean_vector(-values)
    if before.r > 1e-3:
        assert (after.mean + before.mean + 0.5) % 1.0 - 0.5 == pytest.approx(0.0, abs=1e-9)


@settings(deadline=None)
@given(st.floats(-5, 5))
def test_wrapped_phases_are_in_the_cycle(phase):
    assert 0.0 <= wrap(phase) < 1.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mean_vector(np.array([])), "^phases: none was given; expected at least"),
        (lambda: mean_vector(np.array([0.1, np.nan])), "^phases: 1 of 2 are not finite; expected"),
        (lambda: circular_sd(1.2), r"^r is 1\.2; expected the length of a mean vector, 0 to 1\.$"),
        (lambda: rayleigh_p(0, 0.5), "^n is 0; expected a whole number of phases"),
        (lambda: mean_interval(0.1, 0.5, 9, level=95), "^level is 95; expected between 0 and 1"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
