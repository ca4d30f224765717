"""Tests of one sample against textbook and library answers, and their level.

Expected values: Zar, Biostatistical Analysis, 5th ed. (2010), examples 27.1-27.6 and 27.23,
as asserted by pycircstat2's tests; CircStat for MATLAB; pingouin. Exact p of Rayleigh's test:
importance sampling (relative error 0.1-0.3 %).
"""

from __future__ import annotations

import itertools
import math
import tracemalloc

import numpy as np
import pytest
from scipy.stats import vonmises
from zar_samples import D1, D2_COUNTS, D7, D8, D9, PG5, PIGEON, X5, nudged

from pawnb.errors import InputError
from pawnb.gait.circular import mean_interval, mean_vector, rayleigh_p, resultant_p
from pawnb.gait.circular.tests import (
    batschelet_test,
    chi2_uniform_test,
    hodges_ajne_test,
    mean_test,
    rayleigh_test,
    symmetry_test,
    v_test,
)


@pytest.mark.parametrize(
    ("sample", "z", "exact", "zar"),
    [
        (D1, 5.4478746109, 0.00165, 0.001851637508),  # Zar 27.1: 5.448, .001 < P < .002
        (D7, 9.0656433864, 6.13e-7, 5.3038588e-6),
        (D8, 7.6084653550, 2.88e-4, 2.953997e-4),
        (X5, 4.2343603235, 0.00477, 0.006915498353),
        (PIGEON, 0.6044898633, 0.5558, 0.5551509378),
        (PG5, 1.2361900797, 0.3088, 0.3048435877),
    ],
)
def test_rayleigh(sample, z, exact, zar):
    found, closed = rayleigh_test(sample), rayleigh_test(sample, method="zar")
    assert found.statistic == pytest.approx(z, rel=1e-9)
    assert found.p == pytest.approx(exact, rel=0.01, abs=0)
    assert closed.p == pytest.approx(zar, rel=2e-7, abs=0)
    assert (found.method, closed.method) == ("exact", "Zar's approximation")
    twin = nudged(sample)
    assert rayleigh_test(twin).statistic != pytest.approx(z, rel=1e-5)
    assert rayleigh_test(twin, method="zar").p != pytest.approx(zar, rel=1e-4, abs=0)


@pytest.mark.parametrize(
    ("n", "r", "zar"),
    [(9, 0.95598180, 1.766e-5), (25, 0.94232823, 2.13e-14), (6, 0.99, 4.43e-4)],
)
def test_zars_p_where_it_fails(n, r, zar):
    assert rayleigh_p(n, r, method="zar") == pytest.approx(zar, rel=2e-3, abs=0)
    assert rayleigh_p(n, r) < zar / 8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sample", "p"),
    # the column "series (AP, R)" of the worked examples: why astropy's is not followed
    [(D1, 0.001644197395), (D7, -1.01e-5), (X5, 0.006404180462), (PIGEON, 0.5554199322)],
)
def test_astropys_p_is_another_and_can_be_negative(sample, p):
    from astropy.stats import rayleightest

    theirs = float(rayleightest(2 * np.pi * sample))
    assert theirs == pytest.approx(p, rel=3e-3)
    assert rayleigh_test(sample).p > 0


def test_astropys_v_test_is_negative_in_zars_own_example():
    from astropy.stats import vtest

    assert float(vtest(2 * np.pi * D7, mu=np.pi / 2)) < 0 < v_test(D7, expected=0.25).p


@pytest.mark.parametrize(
    ("sample", "expected", "v", "normal"),
    [
        (D7, 0.25, 9.4976118941, 1.081033e-5),  # CircStat; Zar 27.2: 9.498, P < .0005
        (PG5, 1 / (2 * math.pi), 2.4859428599, 0.0579464873),  # CircStat, pingouin
    ],
)
def test_v(sample, expected, v, normal):
    found = v_test(sample, expected=expected, method="normal")
    assert found.statistic == pytest.approx(v, rel=1e-9)
    assert found.p == pytest.approx(normal, rel=1e-6, abs=0)
    assert found.statistic * math.sqrt(2 / len(sample)) == pytest.approx(
        {10: 4.248, 5: 1.5722}[len(sample)], abs=1e-3
    )  # Zar 27.2: u = 4.248, from V rounded to 9.498
    twin = v_test(nudged(sample), expected=expected, method="normal")
    assert twin.statistic != pytest.approx(v, rel=1e-5)
    assert twin.p != pytest.approx(normal, rel=1e-3, abs=0)


@pytest.mark.parametrize(
    ("n", "v", "p", "error"),
    # plain Monte Carlo of 1e6 samples, with its standard error
    [(2, 1.2, 0.142537, 0.00035), (3, 1.8, 0.077442, 0.00027), (5, 3.0, 0.027466, 0.00016),
     (10, 6.0, 0.002888, 0.000054), (10, -3.0, 0.908031, 0.0003)],
)  # fmt: skip
def test_exact_p_of_v(n, v, p, error):
    # n phases that give this V: all at one distance from the expected phase
    sample = np.full(n, math.acos(v / n) / (2 * math.pi))
    assert v_test(sample, expected=0.0).p == pytest.approx(p, abs=4 * error)


def test_v_of_one_phase_has_a_closed_form():
    assert v_test(np.array([0.1]), expected=0.0).p == pytest.approx(0.2)


def test_mean_against_an_expected_phase():
    # Zar 27.3: do not reject 90 degrees, which the interval 94.0 +- 12.7 holds
    found = mean_test(D7, expected=0.25)
    assert found.p > 0.05
    assert mean_test(D7, expected=107 / 360).p < 0.05
    # p is 0.05 just where the interval of Zar 26.24 or 26.25 ends
    for sample in (D7, D8, D1):
        for end in mean_interval(*mean_vector(sample)):
            assert mean_test(sample, expected=end).p == pytest.approx(0.05)
            assert mean_test(nudged(sample), expected=end).p != pytest.approx(0.05, abs=1e-4)
    assert mean_test(D7, expected=0.75).p < 1e-5


def test_hodges_ajne():
    found = hodges_ajne_test(D8)  # Zar 27.4: P .0043; CircStat m = 3
    assert found.statistic == 3
    assert found.p == pytest.approx(0.004343032837, rel=1e-9)
    twin = D8.copy()
    twin[5:7] = 0.45, 0.55  # more phases on the side of few
    assert hodges_ajne_test(twin).p != pytest.approx(0.004343032837, rel=0.1)


def test_hodges_ajne_where_the_book_has_no_formula():
    # 20,000 random samples of 9: P(m <= 2) = 0.709, P(m <= 3) = 0.996, standard error 0.003
    evenly = np.arange(9) / 9
    assert hodges_ajne_test(evenly).statistic == 4
    assert hodges_ajne_test(evenly).p == pytest.approx(1)
    sample = np.array([0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.55, 0.65])
    assert hodges_ajne_test(sample).statistic == 2
    assert hodges_ajne_test(sample).p == pytest.approx(0.709, abs=0.012)


def test_hodges_ajne_holds_no_phase_on_the_other_side():
    found = hodges_ajne_test(np.array([0.1, 0.2, 0.3, 0.35, 0.4]))
    assert found.statistic == 0
    assert found.p == pytest.approx(5 / 2**4)  # n / 2^(n - 1), Hodges 1955


@pytest.mark.parametrize("n", [3, 5, 8, 9])
def test_smallest_p_of_hodges_and_ajne(n):
    # n phases on one half circle: n / 2^(n - 1) (Wendel 1962)
    found = hodges_ajne_test(np.linspace(0.1, 0.3, n), animals=list(range(n)))
    assert found.smallest_p == pytest.approx(n / 2 ** (n - 1))
    assert found.p == pytest.approx(found.smallest_p)
    said = f"with {n} animals no p below {n / 2 ** (n - 1):.2g} is possible"
    assert found.note == (said if n < 9 else "")


def by_pairs(sample):
    """Return m of Hodges and Ajne from all pairs of phases."""
    ahead = np.mod(np.round(sample - sample[:, None], 9), 1.0)
    sides = [(ahead < 0.5).sum(1), ((ahead > 0) & (ahead <= 0.5)).sum(1)]
    return min(*(side.min() for side in sides), *(len(sample) - side.max() for side in sides))


def test_hodges_ajne_is_that_of_all_pairs():
    rng = np.random.default_rng(7)
    for n in (4, 7, 20, 61):
        for sample in (rng.random(n), np.round(rng.random(n), 1), rng.vonmises(0, 1, n) / 6.3):
            assert hodges_ajne_test(sample).statistic == by_pairs(np.mod(sample, 1))


def test_smallest_p_of_symmetry():
    # 8 distances, half on either side of the median: T is 1 + 2 + 3 + 4 at least, and 80 of the
    # 256 signs have a sum of ranks of at most 10 or at least 26
    signs = np.array(list(itertools.product((0, 1), repeat=8))) @ np.arange(1, 9)
    least = float(((signs <= 10) | (signs >= 26)).mean())
    near, far = np.array([0.01, 0.02, 0.03, 0.04]), np.array([0.1, 0.12, 0.15, 0.2])
    found = symmetry_test(np.concatenate(([0.5], 0.5 - near, 0.5 + far)), animals=list("abcdefghi"))
    assert found.p == pytest.approx(least)
    assert found.smallest_p == pytest.approx(least)
    assert found.note == f"with 9 animals no p below {least:.2g} is possible"
    other = symmetry_test(np.concatenate(([0.5], 0.5 - near, 0.5 + near[::-1] + 0.005)))
    assert other.p > other.smallest_p == pytest.approx(least)


def test_large_samples_need_no_square_of_memory():
    phases = np.random.default_rng(0).vonmises(1.0, 2.0, 200_000) / (2 * np.pi)
    # m / n: the chance of the half circle away from the mean, to 5 standard errors
    away = float(vonmises.cdf(-np.pi / 2, 2.0) * 2.0)
    tracemalloc.start()
    found = [hodges_ajne_test(phases), symmetry_test(phases)]
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found[0].statistic / 200_000 == pytest.approx(away, abs=5 * math.sqrt(away / 200_000))
    assert found[1].p > 0.001
    assert peak < 200e6


def test_batschelet():
    found = batschelet_test(D8, expected=45 / 360)  # Zar 27.5
    assert found.statistic == 5
    assert found.p == pytest.approx(0.00661, abs=5e-6)
    twin = D8.copy()
    twin[0] = 0.5
    assert batschelet_test(twin, expected=45 / 360).p != pytest.approx(0.00661, abs=1e-3)


def test_smallest_p_of_batschelet():
    # all of 3 on one side, either way: 2 / 2^3
    found = batschelet_test(np.array([0.1, 0.12, 0.15]), expected=0.1, animals=list("abc"))
    assert found.p == found.smallest_p == pytest.approx(0.25)
    assert found.note == "with 3 animals no p below 0.25 is possible"


def test_symmetry_about_the_median():
    assert symmetry_test(D9).p > 0.5  # Zar 27.6
    skewed = np.array([0.0, 0.002, 0.004, 0.006, 0.008, 0.1, 0.15, 0.2, 0.24, 0.28, 0.3])
    assert symmetry_test(skewed).p < symmetry_test(D9).p


def test_uniform_classes():
    counts = np.concatenate(([0], D2_COUNTS, [0, 0]))
    found = chi2_uniform_test(counts)  # Zar 27.23
    assert found.statistic == pytest.approx(66.5429, abs=5e-5)
    assert found.p == pytest.approx(5.5e-10, rel=0.01, abs=0)
    assert found.n == 105
    counts[0] = 1
    assert chi2_uniform_test(counts).statistic != pytest.approx(66.5429, abs=0.1)


ONE_SAMPLE = [
    rayleigh_test,
    hodges_ajne_test,
    symmetry_test,
    lambda p, animals: v_test(p, expected=0.2, animals=animals),
    lambda p, animals: mean_test(p, expected=0.2, animals=animals),
    lambda p, animals: batschelet_test(p, expected=0.2, animals=animals),
]


@pytest.mark.parametrize("test", ONE_SAMPLE)
def test_animals_count_once(test):
    rng = np.random.default_rng(5)
    animals = np.repeat(list("abcde"), 6)
    phases = np.repeat(rng.random(5), 6) + rng.normal(0, 0.02, 30)
    found = test(phases, animals=animals)
    assert (found.n, found.n_animals) == (30, 5)
    assert "5 animals" in str(found)
    # repeating every stride changes nothing
    again = test(np.tile(phases, 3), animals=np.tile(animals, 3))
    assert again.p == pytest.approx(found.p)
    alone = test(phases, animals=None)
    assert alone.n_animals is None
    assert "independent" in str(alone)
    single = test(phases[:6] % 1, animals=["a"] * 6)
    assert math.isnan(single.p)
    assert "one animal" in str(single)


def test_resultant_of_unequal_vectors():
    # 1e7 random resultants, standard error at most 0.00016
    ranks, unequal = np.arange(1.0, 6.0), np.array([1.0, 1.0, 10.0])
    drawn = [(ranks, 2, 0.94113), (ranks, 9, 0.25203), (ranks, 14.5, 0.0011511),
             (unequal, 8.2, 0.97048), (unequal, 11.5, 0.09225)]  # fmt: skip
    for lengths, total, p in drawn:
        assert resultant_p(lengths, total) == pytest.approx(p, abs=7e-4 * math.sqrt(p))
    # two vectors: the law of cosines; 3 and 4 at a right angle make 5
    assert resultant_p(np.array([3.0, 4.0]), 5.0) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: rayleigh_test(D1, animals=["a"]), "^animals: found 1 names for 8 values"),
        (lambda: rayleigh_test(D1, method="x"), "^method is 'x'; expected 'exact' or 'zar'"),
        (lambda: v_test(D1, expected=math.nan), "^expected is nan; expected a phase in cycles"),
        (lambda: v_test(D1, expected=0.5, method="x"), "^method is 'x'; expected 'exact' or 'n"),
        (lambda: chi2_uniform_test(np.zeros(4)), "^counts: expected two classes or more"),
        (lambda: symmetry_test(np.array([0, 0.25, 0.5, 0.75])), "^the phases have no median"),
        (lambda: rayleigh_test(np.array([0.1, 0.6]), animals=["a", "a"]), "no animal has a mean"),
        (lambda: resultant_p(np.array([1.0, 1.0]), 3.0), "^the resultant is 3"),
        (lambda: resultant_p(np.array([1.0, 0.0]), 1.0), "^lengths of vectors: expected at least"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
