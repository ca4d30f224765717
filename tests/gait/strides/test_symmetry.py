"""Symmetry indices by hand."""

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.strides.symmetry import symmetry_table

STRIDES = pd.DataFrame(
    {
        "animal": ["a"] * 5 + ["b"] * 2,
        "leg": ["FL", "FL", "FR", "FR", "HL", "FL", "FR"],
        "stance_s": [0.11, 0.13, 0.09, 0.11, 0.2, 0.1, 0.1],
    }
)


def test_index_and_ratio():
    table = symmetry_table(STRIDES, measures=["stance_s"]).set_index("animal")
    # animal a: left 0.12, right 0.10: 200 * 0.02 / 0.22 = 18.18 %
    assert table.loc["a", "symmetry_index"] == pytest.approx(18.1818, abs=1e-3)
    assert table.loc["a", "ratio"] == pytest.approx(1.2)
    assert table.loc["b", "symmetry_index"] == 0.0
    assert list(table["pair"]) == ["FL:FR", "FL:FR"]  # HL has no partner here


def test_swapping_sides_turns_the_sign():
    swapped = STRIDES.assign(leg=STRIDES["leg"].replace({"FL": "FR", "FR": "FL"}))
    one = symmetry_table(STRIDES, measures=["stance_s"])["symmetry_index"].to_numpy()
    two = symmetry_table(swapped, measures=["stance_s"])["symmetry_index"].to_numpy()
    np.testing.assert_allclose(one, -two)


def test_an_unknown_measure_is_refused():
    with pytest.raises(InputError, match="column 'swing_s' is missing"):
        symmetry_table(STRIDES)
