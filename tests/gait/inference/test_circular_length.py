"""Interval of the length of a mean vector: against Monte Carlo, Rayleigh's p and chi²."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ive
from scipy.stats import chi2

from pawnb.errors import InputError
from pawnb.gait.analysis.phase_patterns import name_pattern
from pawnb.gait.circular import rayleigh_p
from pawnb.gait.inference.circular_length import chance_of_length, kappa_of_length, length_interval


def length_of(kappa):
    """Length of the mean vector of a von Mises distribution."""
    return ive(1, kappa) / ive(0, kappa)


@pytest.mark.parametrize(("n", "kappa"), [(2, 1.0), (2, 20.0), (3, 0.5), (5, 4.0), (40, 2.0)])
@pytest.mark.parametrize("share", [0.025, 0.5, 0.975])
def test_chances_are_those_of_monte_carlo(n, kappa, share):
    # 20,000 samples: standard error at most 0.35 %
    rng = np.random.default_rng(n)
    r = np.quantile(abs(np.exp(1j * rng.vonmises(0, kappa, (20_000, n))).mean(1)), share)
    below, above = chance_of_length(float(r), n, kappa)
    assert below == pytest.approx(share, abs=0.012)
    assert below + above == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("n", "r"), [(2, 0.8), (3, 0.7), (10, 0.3), (300, 0.06)])
def test_without_concentration_it_is_rayleighs_test(n, r):
    assert chance_of_length(r, n, 1e-4)[1] == pytest.approx(rayleigh_p(n, r), rel=1e-3)


def test_concentrated_phases_follow_chi2():
    # 2 kappa (n - R) is chi² with n - 1 degrees of freedom (Zar 2010; Mardia & Jupp 2000, 4.8)
    low, high = length_interval(0.999, 8)
    limits = chi2.ppf([0.025, 0.975], 7) / (2 * 8 * 0.001)
    assert 1 - low == pytest.approx(1 - length_of(limits[0]), rel=0.01)
    assert 1 - high == pytest.approx(1 - length_of(limits[1]), rel=0.01)
    near = length_interval(1.0 - 2e-4, 8), length_interval(1.0 - 0.9e-4, 8)  # two ways
    assert (1 - near[0][0]) / (1 - near[1][0]) == pytest.approx(2 / 0.9, rel=1e-3)
    assert length_interval(1.0, 3) == pytest.approx((1.0, 1.0))


def test_many_phases_have_an_interval_too():
    # large samples: half a width of 1.96 standard errors of r, sqrt((1 - r² - r / kappa) / n)
    for n, kappa in ((9_000, 0.5), (9_000, 300.0), (200_000, 2.0), (200_000, 4000.0)):
        r = length_of(kappa)
        half = 1.96 * math.sqrt((1.0 - r**2 - r / kappa) / n)
        assert length_interval(r, n) == pytest.approx((r - half, r + half), abs=0.05 * half)


@pytest.mark.parametrize(("r", "n"), [(0.2, 3), (0.9, 3), (0.5, 12), (0.8, 200), (0.3, 4000)])
def test_ends_are_where_the_tails_are(r, n):
    low, high = length_interval(r, n)
    kappas = [1e-6, *np.geomspace(0.01, 1e4, 4000)]
    lengths = np.array([length_of(k) for k in kappas])
    above_end = kappas[int(np.argmin(abs(lengths - high)))]
    assert chance_of_length(r, n, above_end)[0] == pytest.approx(0.025, abs=0.004)
    if low:
        assert chance_of_length(r, n, kappas[int(np.argmin(abs(lengths - low)))])[
            1
        ] == pytest.approx(0.025, abs=0.004)
    else:
        assert rayleigh_p(n, r) >= 0.025


@pytest.mark.slow
def test_it_holds_the_truth_in_95_percent():
    # exact for von Mises phases: held where neither tail is below 2.5 %
    rng = np.random.default_rng(2)
    for n, kappa in ((4, 1.0), (6, 4.0)):
        lengths = abs(np.exp(1j * rng.vonmises(0, kappa, (150, n))).mean(1))
        held = [min(chance_of_length(float(r), n, kappa)) >= 0.025 for r in lengths]
        assert np.mean(held) == pytest.approx(0.95, abs=0.054)  # three standard errors
        some = [length_interval(float(r), n) for r in lengths[:5]]
        inside = [low <= length_of(kappa) <= high for low, high in some]
        assert inside == held[:5]


def test_what_cannot_be_has_no_interval():
    assert all(math.isnan(v) for v in length_interval(1.0, 1))
    assert length_interval(0.0, 5) == (0.0, 0.0)  # rarer than 2.5 % of phases at random
    with pytest.raises(InputError, match=r"^r is 1\.2; expected the length"):
        length_interval(1.2, 5)
    with pytest.raises(InputError, match=r"^level is 2; expected"):
        length_interval(0.5, 5, level=2)
    with pytest.raises(InputError, match=r"^r is 0\.5, n 1, kappa 1"):
        chance_of_length(0.5, 1, 1)


@pytest.mark.parametrize("apart", [1e-16, 1e-13, 1e-10, 1e-7, 1e-4])
def test_phases_that_are_all_but_one_have_a_kappa(apart):
    # Fisher (1993), p. 50: I1 / I0 = 1 - 1 / (2 kappa) + O(kappa ** -2); a recording whose every
    # stride has the same phase to rounding is no fault of its owner
    r = 1.0 - apart
    # to the digits that 1 - r has left
    assert kappa_of_length(r) == pytest.approx(0.5 / (1.0 - r), rel=1e-3 + 2e-16 / (1.0 - r))
    for n in (2, 8, 1000, 200_000):
        assert name_pattern(0.5, r, n) == "anti-phase"
        assert rayleigh_p(n, r) < 0.01
