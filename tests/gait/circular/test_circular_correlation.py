"""Correlations of phases against textbook and library answers.

Expected values: Zar, Biostatistical Analysis, 5th ed. (2010), examples 27.20 and 27.21, as
asserted by pycircstat2's tests; CircStat for MATLAB; R's package circular; astropy; pingouin.
"""

from __future__ import annotations

import numpy as np
import pytest
from zar_samples import (
    D20_INSECT,
    D20_LIGHT,
    D21_ANGLES,
    D21_VALUES,
    MILWAUKEE_PSI,
    MILWAUKEE_THETA,
    PG5,
    PG5_VALUES,
    nudged,
)

from pawnb.errors import InputError
from pawnb.gait.circular.correlation import angular_angular, angular_linear


def test_zars_angular_linear_example():
    found = angular_linear(D21_ANGLES, D21_VALUES)
    assert found.r == pytest.approx(0.9853567000, abs=5e-10)  # Zar .9854; CircStat, pingouin
    assert found.statistic == pytest.approx(6.79649478, abs=5e-9)
    assert found.p == pytest.approx(0.0334318115, abs=5e-10)  # Zar .025 < P < .05
    assert found.p_permutation == pytest.approx(0.00238095, abs=5e-9)  # 12 of 5040 orders
    f = angular_linear(D21_ANGLES, D21_VALUES, method="f")
    assert f.statistic == pytest.approx(66.7943, abs=5e-5)  # Mardia's F, df 2 and 4
    assert f.p == pytest.approx(8.45e-4, abs=5e-7)
    twin = angular_linear(nudged(D21_ANGLES), D21_VALUES)
    assert twin.r != pytest.approx(0.9853567000, abs=1e-6)
    assert twin.p != pytest.approx(0.0334318115, abs=1e-6)


def test_angular_linear_is_equation_3_26():
    c, s = np.cos(2 * np.pi * D21_ANGLES), np.sin(2 * np.pi * D21_ANGLES)
    xc, xs, cs = (np.corrcoef(*p)[0, 1] for p in ((D21_VALUES, c), (D21_VALUES, s), (c, s)))
    # Zar's parts
    assert (xc, xs, cs) == pytest.approx((0.1593924833, 0.9684455888, 0.3410285047), abs=1e-9)
    r = np.sqrt((xc**2 + xs**2 - 2 * xc * xs * cs) / (1 - cs**2))
    assert angular_linear(D21_ANGLES, D21_VALUES).r == pytest.approx(r)


def test_uncorrelated_and_the_known_limit():
    found = angular_linear(PG5, PG5_VALUES)  # pingouin, CircStat
    assert found.r == pytest.approx(0.1087053413, abs=5e-11)
    assert found.p == pytest.approx(0.9708899750, abs=5e-10)
    assert angular_linear(nudged(PG5), PG5_VALUES).r != pytest.approx(0.1087053413, abs=1e-5)
    # a phase that turns steadily once round: 0.78, not 1 (circstat-matlab, issue 8)
    turning = angular_linear(np.linspace(-0.5, 0.5, 1000), np.linspace(0, 10, 1000))
    assert turning.r == pytest.approx(0.7785253713, abs=5e-10)
    assert turning.p_permutation < 0.001


@pytest.mark.slow
def test_zars_angular_angular_example():
    fisher_lee = angular_angular(D20_INSECT, D20_LIGHT, method="fisher-lee")
    assert fisher_lee.r == pytest.approx(0.8945060857, abs=5e-11)  # pycircstat2; Zar .8945
    assert fisher_lee.p < 0.05  # Zar: reject
    other = angular_angular(D20_INSECT, D20_LIGHT)  # CircStat
    assert other.r == pytest.approx(0.8195405916, abs=5e-11)
    assert other.p == pytest.approx(0.106385048, abs=5e-10)
    for method, r in (("fisher-lee", 0.8945060857), ("jammalamadaka", 0.8195405916)):
        twin = angular_angular(nudged(D20_INSECT), D20_LIGHT, method=method)
        assert twin.r != pytest.approx(r, abs=1e-5)


def test_winds_of_milwaukee():
    found = angular_angular(MILWAUKEE_THETA, MILWAUKEE_PSI)  # R, CircStat, astropy
    assert found.r == pytest.approx(0.2704648827, abs=5e-11)
    assert found.statistic == pytest.approx(1.214024929, abs=5e-10)
    assert found.p == pytest.approx(0.2247382048, abs=5e-11)
    assert found.p_permutation == pytest.approx(found.p, abs=0.03)
    assert angular_angular(nudged(MILWAUKEE_THETA), MILWAUKEE_PSI).r != pytest.approx(
        0.2704648827, abs=1e-5
    )


def test_phases_that_follow_each_other_correlate_wholly():
    phases = np.array([0.1, 0.35, 0.5, 0.62, 0.9])
    assert angular_angular(phases, phases + 0.2, method="fisher-lee").r == pytest.approx(1)
    assert angular_angular(phases, 0.2 - phases, method="fisher-lee").r == pytest.approx(-1)
    assert angular_angular(phases, phases + 0.2).r == pytest.approx(1)
    assert angular_angular(phases, 0.2 - phases).r == pytest.approx(-1)


def test_animals_count_once():
    rng = np.random.default_rng(2)
    animals = np.repeat(list("abcdef"), 9)
    phases = np.repeat(rng.normal(0.5, 0.05, 6), 9) + rng.normal(0, 0.02, 54)
    speed = np.repeat(rng.normal(20, 5, 6), 9) + rng.normal(0, 1, 54)
    strides, found = angular_linear(phases, speed), angular_linear(phases, speed, animals=animals)
    assert (found.n, found.n_animals, strides.n_animals) == (54, 6, None)
    assert strides.p < found.p
    assert "independent" in strides.note
    # each animal's share is its mean phase and mean speed
    by_animal = angular_linear(
        np.angle(np.exp(2j * np.pi * phases).reshape(6, 9).mean(1)) / (2 * np.pi),
        speed.reshape(6, 9).mean(1),
    )
    assert found.r == pytest.approx(by_animal.r)
    pair = angular_angular(phases, phases + rng.normal(0, 0.02, 54), animals=animals)
    assert (pair.n, pair.n_animals) == (54, 6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: angular_linear(PG5, PG5_VALUES[:4]), "^values: found 4 for 5 phases"),
        (lambda: angular_linear(PG5, np.full(5, 2.0)), "numbers that are all the same"),
        (lambda: angular_linear(PG5[:3], PG5_VALUES[:3]), "^angular-linear correlation: found 3"),
        (lambda: angular_linear(np.array([0, 0, 0.5, 0.5]), np.arange(4)), "only one or two"),
        (lambda: angular_linear(PG5, PG5_VALUES, method="z"), "^method is 'z'"),
        (lambda: angular_angular(PG5, PG5[:4]), "^found 5 phases and 4 others"),
        (lambda: angular_angular(PG5, np.full(5, 0.2)), "^angular-angular correlation"),
        (lambda: angular_angular(PG5, PG5, method="z"), "^method is 'z'"),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
