"""Overview of measures: principal components as R's prcomp gives them, and what is left out."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.overview import measures_by_animal, principal_components, standardise

# R's USArrests: Murder, Assault, UrbanPop, Rape of fifty states, in alphabetical order
ARRESTS = """
13.2 236 58 21.2 10.0 263 48 44.5 8.1 294 80 31.0 8.8 190 50 19.5 9.0 276 91 40.6
7.9 204 78 38.7 3.3 110 77 11.1 5.9 238 72 15.8 15.4 335 80 31.9 17.4 211 60 25.8
5.3 46 83 20.2 2.6 120 54 14.2 10.4 249 83 24.0 7.2 113 65 21.0 2.2 56 57 11.3
6.0 115 66 18.0 9.7 109 52 16.3 15.4 249 66 22.2 2.1 83 51 7.8 11.3 300 67 27.8
4.4 149 85 16.3 12.1 255 74 35.1 2.7 72 66 14.9 16.1 259 44 17.1 9.0 178 70 28.2
6.0 109 53 16.4 4.3 102 62 16.5 12.2 252 81 46.0 2.1 57 56 9.5 7.4 159 89 18.8
11.4 285 70 32.1 11.1 254 86 26.1 13.0 337 45 16.1 0.8 45 44 7.3 7.3 120 75 21.4
6.6 151 68 20.0 4.9 159 67 29.3 6.3 106 72 14.9 3.4 174 87 8.3 14.4 279 48 22.5
3.8 86 45 12.8 13.2 188 59 26.9 12.7 201 80 25.5 3.2 120 80 22.9 2.2 48 32 11.2
8.5 156 63 20.7 4.0 145 73 26.2 5.7 81 39 9.3 2.6 53 66 10.8 6.8 161 60 15.6
"""
STATES = pd.DataFrame(
    np.loadtxt(io.StringIO(ARRESTS)).reshape(50, 4),
    columns=["Murder", "Assault", "UrbanPop", "Rape"],
)


def test_components_are_those_of_prcomp():
    """prcomp(USArrests, scale. = TRUE), as printed in James et al. (2013), section 10.4."""
    found = principal_components(standardise(STATES).z)
    np.testing.assert_allclose(
        found.scores.std(ddof=1), [1.5748783, 0.9948694, 0.5971291, 0.4164494], atol=1e-6
    )
    expected = {
        "PC1": [0.5358995, 0.5831836, 0.2781909, 0.5434321],
        "PC2": [-0.4181809, -0.1879856, 0.8728062, 0.1673186],
    }
    for name, loadings in expected.items():
        np.testing.assert_allclose(found.loadings[name], loadings, atol=1e-6)
    np.testing.assert_allclose(found.explained, [0.62006, 0.24744, 0.08914, 0.04336], atol=1e-5)
    assert found.note == ""
    # scores and loadings give the measures back
    np.testing.assert_allclose(found.scores @ found.loadings.T, standardise(STATES).z, atol=1e-9)


def test_few_animals_have_few_components_and_a_note():
    z = standardise(STATES.iloc[:3]).z
    found = principal_components(z)
    assert found.scores.columns.tolist() == ["PC1", "PC2"]
    assert found.explained.sum() == pytest.approx(1.0)
    assert found.note.startswith("3 animals and 4 measures: 2 components always hold all")


def test_what_an_animal_lacks_or_all_have_alike_is_left_out_and_said():
    table = STATES.iloc[:5].assign(same=2.0, lost=[1.0, np.nan, 3.0, 4.0, 5.0])
    found = standardise(table)
    assert found.z.columns.tolist() == STATES.columns.tolist()
    assert found.left_out == {"same": "the same in all animals", "lost": "not known of 1"}
    np.testing.assert_allclose(found.z.std(ddof=1), 1.0)
    np.testing.assert_allclose(found.z * found.sd + found.mean, STATES.iloc[:5])
    with pytest.raises(InputError, match="2 animals; expected 3 or more"):
        standardise(STATES.iloc[:2])
    with pytest.raises(InputError, match="1 measures that all animals have and that differ"):
        standardise(table[["Murder", "same"]])


def test_legs_count_alike_however_many_strides_they_made():
    strides = pd.DataFrame(
        {"animal": ["b", "b", "b", "a", "a"], "leg": ["FR", "FR", "HR", "FR", "HR"],
         "duty_factor": [0.4, 0.6, 0.7, 0.3, 0.5]}
    )  # fmt: skip
    found = measures_by_animal(strides, ["duty_factor"])
    np.testing.assert_allclose(found["duty_factor"], [0.4, 0.6])
    assert found.index.tolist() == ["a", "b"]
    with pytest.raises(InputError, match="there is no stride"):
        measures_by_animal(strides.head(0), ["duty_factor"])
