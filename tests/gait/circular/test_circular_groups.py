"""Tests between samples of phases against textbook and library answers.

Expected values: Zar, Biostatistical Analysis, 5th ed. (2010), examples 27.7-27.11, as
asserted by pycircstat2's tests; CircStat for MATLAB; R's package circular 0.4-95.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from zar_samples import D10, D11, D12, labelled, nudged

from pawnb.errors import InputError
from pawnb.gait.circular import mean_vector
from pawnb.gait.circular.describe import concentration
from pawnb.gait.circular.groups import watson_u2_test, watson_williams_test, wheeler_watson_test


def other_kappa(samples):
    """Ratio of K with R's choice of kappa (all phases together) to K with ours."""
    n = sum(len(s) for s in samples)
    ours = sum(len(s) * mean_vector(s).r for s in samples) / n
    theirs = mean_vector(np.concatenate(samples)).r
    k = [1 + 3 / (8 * concentration(r, method="fisher")) for r in (theirs, ours)]
    return k[0] / k[1]


@pytest.mark.parametrize(
    ("samples", "f", "p", "tolerance", "in_r"),
    [
        (D10, 1.612782703, 0.2202734119, 1e-9, 1.6173369),  # CircStat; Zar 27.7: 1.61, .22
        (D11, 1.865, 0.18701, 5e-4, 1.884977),  # pycircstat2; Zar 27.8: 1.86, .19
    ],
)
def test_watson_williams(samples, f, p, tolerance, in_r):
    found = watson_williams_test(*labelled(samples))
    assert found.statistic == pytest.approx(f, abs=tolerance)
    assert found.p == pytest.approx(p, abs=max(tolerance / 5, 1e-9))
    assert found.statistic * other_kappa(samples) == pytest.approx(in_r, abs=5e-7)
    twin = (nudged(samples[0]), *samples[1:])
    assert watson_williams_test(*labelled(twin)).statistic != pytest.approx(f, abs=1e-3)


def test_watson_williams_says_where_phases_are_too_scattered():
    phases = np.array([0.0, 0.3, 0.6, 0.1, 0.5, 0.8])
    found = watson_williams_test(phases, list("aaabbb"))
    assert "below 0.55: too scattered" in found.note
    assert math.isnan(found.p)
    assert "too scattered" not in watson_williams_test(*labelled(D10)).note


def test_watson_williams_finds_nothing_in_phases_at_random():
    """Two groups of 10 uniform phases: p was below 0.05 in 44 % of 200 studies."""
    rng = np.random.default_rng(0)
    groups = np.repeat(["a", "b"], 10)
    found = [watson_williams_test(rng.random(20), groups).p for _ in range(200)]
    assert np.isnan(found).mean() > 0.9
    assert (np.array(found) < 0.05).mean() < 0.05


@pytest.mark.parametrize(("size", "least"), [(11, 0.45), (7, 0.5), (6, 0.55), (3, 0.55)])
def test_least_r_of_watson_williams_is_that_of_circstat(size, least):
    for r, is_there in ((least + 0.01, True), (least - 0.01, False)):
        # as many phases before the mean as after it, so far away that r is as wanted
        away = np.arccos(r) / (2.0 * np.pi)
        one = np.resize([away, -away], size)
        if size % 2:  # the odd one stands at the mean; the others are wider apart for it
            wider = np.arccos((r * size - 1.0) / (size - 1.0)) / (2.0 * np.pi)
            one = np.append(np.resize([wider, -wider], size - 1), 0.0)
        phases = np.mod(np.concatenate((one, one + 0.1)), 1.0)
        found = watson_williams_test(phases, np.repeat(["a", "b"], size))
        assert math.isfinite(found.p) == is_there


def test_watson_u2():
    found = watson_u2_test(*labelled(D12))
    # R .1457; Zar 27.9 .1458 from rounded parts, .1 < P < .2
    assert found.statistic == pytest.approx(0.1457, abs=5e-5)
    assert 0.1 < found.p < 0.2
    twin = (D12[0], D12[1] - 30 / 360)
    assert watson_u2_test(*labelled(twin)).statistic != pytest.approx(0.1457, abs=5e-3)


def test_watson_u2_with_ties_by_hand():
    # 0.1 0.1 | 0.1 0.3: steps at 0.1 (3 phases) d = 1 - 1/2, at 0.3 (1 phase) d = 0;
    # U2 = 2 * 2 / 16 * (3 / 4 - 1.5^2 / 4) = 0.046875
    found = watson_u2_test(np.array([0.1, 0.1, 0.1, 0.3]), list("aabb"))
    assert found.statistic == pytest.approx(0.046875)
    assert found.method == "all permutations"
    assert found.p == pytest.approx(1.0)  # half of the 6 arrangements mirror the other half


def test_wheeler_watson():
    found = wheeler_watson_test(*labelled(D12), method="chi2")
    assert found.statistic == pytest.approx(3.67827, abs=5e-6)  # R; Zar 27.11: 3.678
    assert found.p == pytest.approx(0.1589549, abs=5e-8)  # R; Zar .1 < P < .25
    by_permutation = wheeler_watson_test(*labelled(D12))
    assert by_permutation.statistic == pytest.approx(found.statistic)
    assert by_permutation.p == pytest.approx(found.p, abs=0.015)
    twin = (D12[0], D12[1] - 30 / 360)
    assert wheeler_watson_test(*labelled(twin)).statistic != pytest.approx(3.67827, abs=0.05)


@pytest.mark.slow
def test_mean_of_w_over_permutations_is_its_degrees_of_freedom():
    rng = np.random.default_rng(0)
    phases = rng.random(9)
    w = [
        wheeler_watson_test(phases[rng.permutation(9)], list("aaabbbccc"), method="chi2").statistic
        for _ in range(2000)
    ]
    assert np.mean(w) == pytest.approx(4, abs=0.15)


TESTS = [watson_williams_test, watson_u2_test, wheeler_watson_test]


@pytest.mark.parametrize("test", TESTS)
def test_groups_turned_together_give_the_same(test):
    phases, groups = labelled(D10)
    assert test(phases + 0.37, groups).statistic == pytest.approx(
        test(phases, groups).statistic, abs=1e-9
    )


@pytest.mark.parametrize("test", TESTS)
def test_animals_count_once(test):
    rng = np.random.default_rng(3)
    animals = np.repeat(list("abcdefghij"), 8)
    groups = np.repeat(["x", "y"], 40)
    phases = np.repeat(rng.normal(0.5, 0.08, 10), 8) + rng.normal(0, 0.02, 80)
    found = test(phases, groups, animals=animals)
    assert (found.n, found.n_animals) == (80, 10)
    again = test(np.tile(phases, 3), np.tile(groups, 3), animals=np.tile(animals, 3))
    assert again.p == pytest.approx(found.p)
    # the naive p of strides is far smaller here: the animals differ, the groups do not
    assert test(phases, groups).p < found.p


def test_all_arrangements_are_counted_where_they_are_few():
    # 5 against 5, wholly apart: neighbours on the circle begin at any of 10 of 252 arrangements
    phases = np.concatenate((np.arange(5) * 0.01, 0.5 + np.arange(5) * 0.01))
    found = watson_u2_test(phases, ["x"] * 5 + ["y"] * 5)
    assert found.p == pytest.approx(10 / 252)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: watson_u2_test(*labelled(D11)), "^groups: found 3; Watson's U² compares two"),
        (lambda: watson_williams_test(D10[0], ["a"] * 11), "^groups: found only"),
        (lambda: watson_williams_test(D10[0], ["a"]), "^groups: found 1 for 11 phases"),
        (lambda: watson_williams_test(np.array([0.1, 0.1, 0.2, 0.2]), list("aabb")),
         "^groups: the phases do not vary within groups"),
        (lambda: watson_u2_test(D10[0][:4], list("xxyy"), animals=list("abbc")),
         "^animal b is in more than one group"),
        (lambda: wheeler_watson_test(*labelled(D10), method="f"), "^method is 'f'; expected"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize("test", [watson_u2_test, wheeler_watson_test])
@pytest.mark.parametrize("k", [3, 4, 5])
def test_smallest_p_that_two_groups_allow(test, k):
    # 2k rotations keep both groups together, of C(2k, k) arrangements
    least = 2 * k / math.comb(2 * k, k)
    rng = np.random.default_rng(k)
    for apart in (0.0, 0.5):
        phases = np.concatenate((rng.uniform(0, 0.4, k), rng.uniform(0, 0.4, k) + apart))
        found = test(phases, ["a"] * k + ["b"] * k, animals=list(range(2 * k)))
        assert found.smallest_p == pytest.approx(least)
        assert found.p >= least - 1e-12
    assert found.p == pytest.approx(least)  # nothing could be further apart
    said = f"with {k} and {k} animals no p below {least:.2g} is possible"
    assert (said in found.note) == (k < 5)
    assert (said in str(found)) == (k < 5)


def test_p_of_three_groups_is_the_share_of_all_arrangements():
    """Every order of nine phases, by the statistic that takes no permutation."""
    phases = np.array([0.05, 0.1, 0.3, 0.15, 0.4, 0.45, 0.6, 0.7, 0.2])
    groups = np.repeat([0, 1, 2], 3)
    around = np.exp(2j * np.pi * np.argsort(np.argsort(phases)) / 9)
    every = [
        sum(abs(around[list(one)].sum()) ** 2 for one in (a, b, set(range(9)) - {*a, *b}))
        for a in itertools.combinations(range(9), 3)
        for b in itertools.combinations(sorted(set(range(9)) - set(a)), 3)
    ]
    own = sum(abs(around[groups == k].sum()) ** 2 for k in range(3))
    share = np.mean(np.array(every) >= own - 1e-9)
    found = wheeler_watson_test(phases, [f"g{k}" for k in groups], n_permutations=5000)
    # three standard errors of a share of 5000
    assert found.p == pytest.approx(share, abs=3 * np.sqrt(share * (1 - share) / 5000))


def test_smallest_p_of_three_groups():
    # 9 rotations of both orders of the groups, of 9! / 3!^3 arrangements
    groups = np.repeat(["a", "b", "c"], 3).tolist()
    found = wheeler_watson_test(np.arange(9) / 9, groups, n_permutations=99)
    assert found.smallest_p == pytest.approx(18 / 1680)
    assert "possible" not in found.note
    few = wheeler_watson_test(np.arange(6) / 6, np.repeat(["a", "b", "c"], 2), n_permutations=99)
    assert "with 2 and 2 and 2 phases no p below 0.13 is possible" in few.note


def test_permutations_of_large_samples_are_made_in_blocks(monkeypatch):
    rng = np.random.default_rng(1)
    phases, groups = rng.random(40), ["a"] * 15 + ["b"] * 25
    whole = watson_u2_test(phases, groups, n_permutations=500)
    monkeypatch.setattr("pawnb.gait.inference.permutations._BLOCK_OF_VALUES", 400)
    assert watson_u2_test(phases, groups, n_permutations=500) == whole
