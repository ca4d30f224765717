"""Mean phases of animals that are all the same: nothing tells how far they may differ."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait.inference.animal_phases import ALL_THE_SAME, phase_of_animals
from pawnb.gait.phases.phase_table import summarise_phases


@pytest.mark.parametrize("phases", [[0.5, 0.5], [0.5, 0.5, 0.5 + 1e-15], [0.1, 0.1 + 1e-14]])
def test_phases_that_are_all_the_same_are_said(phases):
    # strides of 20 frames, lags of 10: exactly 0.5 in each animal. R's t.test refuses such data
    # as "essentially constant". Rayleigh's exact p is 0 then; R's circular: 0.1372, by a series
    found = phase_of_animals(np.array(phases), list(range(len(phases))))
    assert found.note == ALL_THE_SAME
    assert found.low == pytest.approx(found.high)


def test_phases_that_differ_by_a_frame_are_not():
    found = phase_of_animals(np.array([0.5, 0.49, 0.51]), list("abc"))
    assert ALL_THE_SAME not in found.note
    assert ALL_THE_SAME not in phase_of_animals(np.array([0.0, 0.5]), list("ab")).note
    assert ALL_THE_SAME not in phase_of_animals(np.array([0.3]), ["a"]).note


def test_the_summary_says_so():
    table = pd.DataFrame({"animal": list("aabb"), "trial": "t", "leg": "L1", "reference": "R1"})
    table = table.assign(stride=[1, 2, 1, 2], phase=[0.45, 0.55, 0.4, 0.6])
    assert ALL_THE_SAME in summarise_phases(table)["note"].iloc[0]
