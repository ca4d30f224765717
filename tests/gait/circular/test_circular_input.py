"""Phases that are none: every function of phases says in one sentence what was found."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.circular import mean_vector, rayleigh_p
from pawnb.gait.circular.correlation import angular_angular, angular_linear
from pawnb.gait.circular.describe import (
    axial_mean,
    circular_median,
    circular_moment,
    describe_circular,
    grouped_mean,
)
from pawnb.gait.circular.groups import watson_u2_test, watson_williams_test, wheeler_watson_test
from pawnb.gait.circular.second_order import (
    animal_vectors,
    hotelling_test,
    mean_of_means,
    moore_test,
)
from pawnb.gait.circular.tests import (
    batschelet_test,
    chi2_uniform_test,
    hodges_ajne_test,
    mean_test,
    rayleigh_test,
    symmetry_test,
    v_test,
)
from pawnb.gait.groups.animals import slope_of_animals
from pawnb.gait.groups.bootstrap import bootstrap_units
from pawnb.gait.inference.animal_phases import interval_of_phases, phase_of_animals
from pawnb.gait.phases import describe_phases, summarise_phases
from pawnb.gait.phases.patterns import pattern_distances

BAD = {
    "degrees": np.array([200.0, 190.0, 210.0, 205.0]),
    "infinite": np.array([0.1, np.inf, 0.2, 0.3]),
    "missing": np.array([0.1, np.nan, 0.2, 0.3]),
    "huge": np.array([1e308, 0.1, 0.2, 0.3]),
    "text": np.array(["a", "b", "c", "d"], dtype=object),
    "complex": np.array([1j, 0.1, 0.2, 0.3]),
}
WHO, GROUPS, LENGTHS = list("abcd"), list("xxyy"), np.array([0.5, 0.6, 0.7, 0.8])


def table(phases):
    """Phases of four animals."""
    who = {"animal": WHO, "trial": "t", "leg": "FL", "reference": "FR", "stride": [1, 2, 3, 4]}
    return pd.DataFrame({**who, "phase": phases})


FUNCTIONS = {
    "mean_vector": mean_vector,
    "describe_circular": describe_circular,
    "circular_median": circular_median,
    "circular_moment": lambda p: circular_moment(p, 2),
    "axial_mean": axial_mean,
    "grouped_mean": lambda p: grouped_mean(p, np.array([1, 2, 3, 4])),
    "rayleigh_test": lambda p: rayleigh_test(p, animals=WHO),
    "v_test": lambda p: v_test(p, expected=0.5),
    "mean_test": lambda p: mean_test(p, expected=0.5, animals=WHO),
    "hodges_ajne_test": hodges_ajne_test,
    "batschelet_test": lambda p: batschelet_test(p, expected=0.5),
    "symmetry_test": symmetry_test,
    "watson_williams_test": lambda p: watson_williams_test(p, GROUPS),
    "watson_u2_test": lambda p: watson_u2_test(p, GROUPS),
    "wheeler_watson_test": lambda p: wheeler_watson_test(p, GROUPS),
    "angular_linear": lambda p: angular_linear(p, np.arange(4.0)),
    "angular_angular": lambda p: angular_angular(p, np.array([0.1, 0.2, 0.3, 0.5])),
    "animal_vectors": lambda p: animal_vectors(p, WHO),
    "mean_of_means": lambda p: mean_of_means(p, LENGTHS),
    "hotelling_test": lambda p: hotelling_test(p, LENGTHS),
    "moore_test": lambda p: moore_test(p, LENGTHS),
    "phase_of_animals": lambda p: phase_of_animals(p, WHO),
    "interval_of_phases": interval_of_phases,
    "describe_phases": describe_phases,
    "summarise_phases": lambda p: summarise_phases(table(p)),
    "pattern_distances": lambda p: pattern_distances(table(p)),
    "bootstrap_units": lambda p: bootstrap_units(p, circular=True),
    "slope_of_animals": lambda p: slope_of_animals(np.arange(4.0), p, ["a"] * 4, circular=True),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("kind", BAD)
def test_what_is_no_phase_in_cycles_is_one_sentence(name, kind):
    with pytest.raises(InputError, match="expected"):
        FUNCTIONS[name](BAD[kind])


@pytest.mark.parametrize("kind", ["infinite", "huge", "text", "complex"])
def test_numbers_that_go_with_phases_are_checked_too(kind):
    four = np.array([0.1, 0.2, 0.3, 0.35])
    for call in (
        lambda bad: mean_vector(four, weights=np.concatenate((bad[:1], [np.inf] * 3))),
        lambda bad: chi2_uniform_test(bad),
        lambda bad: angular_linear(four, bad),
        lambda bad: moore_test(four, bad),
    ):
        with pytest.raises(InputError, match="expected"):
            call(BAD[kind])


def test_numbers_of_phases_are_whole():
    with pytest.raises(InputError, match=r"^n is 3\.5; expected a whole number"):
        rayleigh_p(3.5, 0.5)
    with pytest.raises(InputError, match=r"^order is 1\.5; expected a whole number"):
        circular_moment(np.array([0.1, 0.2]), 1.5)


def test_masked_phases_are_missing_ones():
    masked = np.ma.masked_array([0.1, 0.6, 0.2], mask=[False, True, False])
    with pytest.raises(InputError, match=r"^phases: 1 of 3 are not finite"):
        mean_vector(masked)
    assert mean_vector(masked.compressed()).mean == pytest.approx(0.15)
