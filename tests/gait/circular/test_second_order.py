"""Second-order tests against Zar (2010), examples 26.8 and 27.12, and their level."""

from __future__ import annotations

import math

import numpy as np
import pytest
from zar_samples import D4_LENGTHS, D4_MEANS, nudged

from pawnb.errors import InputError
from pawnb.gait.circular.second_order import (
    animal_vectors,
    hotelling_test,
    mean_of_means,
    moore_test,
)
from pawnb.gait.circular.tests import rayleigh_test


def test_mean_of_means():
    found = mean_of_means(D4_MEANS, D4_LENGTHS)  # Zar 26.8: 152 degrees, .59634
    assert found.mean * 360 == pytest.approx(152.16592199, abs=5e-9)
    assert found.r == pytest.approx(0.59634, abs=5e-6)
    x, y = (
        found.r * math.cos(2 * math.pi * found.mean),
        found.r * math.sin(2 * math.pi * found.mean),
    )
    assert (x, y) == pytest.approx((-0.52734, 0.27844), abs=1e-5)
    assert mean_of_means(nudged(D4_MEANS), D4_LENGTHS).mean * 360 != pytest.approx(
        152.166, abs=0.05
    )


def test_hotelling():
    # F and p worked from Zar's formula; critical F(2, 5) is 5.786
    found = hotelling_test(D4_MEANS, D4_LENGTHS, method="f")
    assert found.statistic == pytest.approx(16.662786096, abs=5e-9)
    assert found.p == pytest.approx(0.006147569, abs=5e-10)
    twin = hotelling_test(nudged(D4_MEANS), D4_LENGTHS, method="f")
    assert twin.statistic != pytest.approx(16.662786096, abs=0.01)
    turned = hotelling_test(D4_MEANS, D4_LENGTHS)
    assert turned.statistic == pytest.approx(found.statistic)
    assert 0.0005 < turned.p < 0.02


def test_moore():
    found = moore_test(D4_MEANS, D4_LENGTHS)
    assert found.statistic == pytest.approx(1.428141423, abs=5e-10)
    assert found.p == pytest.approx(2.1e-4, rel=0.05, abs=0)  # Monte Carlo
    assert moore_test(nudged(D4_MEANS), D4_LENGTHS).statistic != pytest.approx(1.428141, abs=1e-4)
    # the order of the animals is not their rank
    order = np.array([3, 0, 6, 2, 5, 1, 4])
    assert moore_test(D4_MEANS[order], D4_LENGTHS[order]).statistic == pytest.approx(1.428141423)


@pytest.mark.parametrize(("r", "p"), [(1.067, 0.05), (1.239, 0.01)])
def test_critical_values_of_moore(r, p):
    # Monte Carlo for k = 7; vectors of ranks 1 to 7 with this resultant: r k^1.5 = |sum|
    from pawnb.gait.circular import resultant_p

    assert resultant_p(np.arange(1.0, 8.0), r * 7**1.5) == pytest.approx(p, rel=0.02)


def test_the_naive_test_of_the_means_ignores_lengths():
    found = rayleigh_test(D4_MEANS, method="zar")
    assert found.statistic == pytest.approx(5.98646055, abs=5e-9)
    assert found.p == pytest.approx(5.961e-4, abs=5e-8)
    assert rayleigh_test(nudged(D4_MEANS), method="zar").p != pytest.approx(5.961e-4, abs=1e-6)


def test_vectors_of_animals():
    found = animal_vectors(np.array([0.1, 0.2, 0.9, 0.0, 0.5]), list("bbacc"))
    assert found.animals == ("a", "b", "c")
    assert found.n.tolist() == [1, 2, 2]
    assert found.means[:2] == pytest.approx([0.9, 0.15])
    assert found.lengths == pytest.approx([1, math.cos(0.1 * math.pi), 0], abs=1e-12)
    assert math.isnan(found.means[2])


@pytest.mark.parametrize("test", [hotelling_test, moore_test])
@pytest.mark.slow
def test_level_under_random_phases_of_animals(test):
    # every animal regular, its phase random: 5 % expected, standard error 1 %
    rng = np.random.default_rng(1)
    options = {"n_rotations": 199} if test is hotelling_test else {}
    low = [test(rng.random(5), 0.9 + 0.05 * rng.random(5), **options).p <= 0.05 for _ in range(300)]
    assert np.mean(low) <= 0.08


def test_hotellings_f_does_not_hold_its_level_there():
    rng = np.random.default_rng(1)
    low = [
        hotelling_test(rng.random(5), 0.9 + 0.05 * rng.random(5), method="f").p <= 0.05
        for _ in range(1000)
    ]
    assert np.mean(low) > 0.08


@pytest.mark.parametrize("test", [hotelling_test, moore_test])
def test_too_few_animals(test):
    found = test(np.array([0.2]), np.array([0.9]))
    assert math.isnan(found.p)
    assert "one animal" in found.note
    assert str(found).endswith("one animal: nothing can be said of animals")


def test_vectors_on_a_line_have_no_hotelling():
    found = hotelling_test(np.array([0.1, 0.1, 0.6]), np.array([0.9, 0.5, 0.3]))
    assert math.isnan(found.p)
    assert "on a line" in found.note


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: moore_test(D4_MEANS, 0 * D4_LENGTHS), "^a mean vector of length 0 has no direct"),
        (lambda: moore_test(D4_MEANS, D4_LENGTHS[:3]), "^lengths: expected 7 numbers from 0 to 1"),
        (lambda: moore_test(D4_MEANS, D4_LENGTHS * 2), "^lengths: expected 7 numbers from 0 to 1"),
        (lambda: hotelling_test(D4_MEANS, D4_LENGTHS, method="x"), "^method is 'x'; expected"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
