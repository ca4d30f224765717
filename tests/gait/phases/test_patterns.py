"""Distances to ideal gaits: definitions by hand, properties, and the thesis's own phases."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.gait.phases.patterns import METACHRONAL, hildebrand_table, pattern_distances

TROT = {("FL", "FR"): 0.5, ("HL", "HR"): 0.5, ("FR", "HR"): 0.5, ("FL", "HL"): 0.5,
        ("FR", "HL"): 0.0, ("FL", "HR"): 0.0}  # fmt: skip


def table(means, animal="a"):
    return pd.DataFrame(
        [
            {"animal": animal, "trial": "t", "leg": leg, "reference": ref, "stride": 1, "phase": p}
            for (leg, ref), p in means.items()
        ]
    )


def test_an_exact_trot_has_distance_0_to_the_trot_only():
    found = pattern_distances(table(TROT)).set_index("pattern")
    assert found.loc["trot", "distance"] == pytest.approx(0.0, abs=1e-12)
    assert found.loc["trot", "nearest"]
    # pace: fore-hind of a side are half a cycle off, diagonals too: 4 of 6 pairs by 0.5
    assert found.loc["pace", "distance"] == pytest.approx(np.sqrt(4 / 6 * 0.25))
    # walk: ipsilateral and diagonal pairs a quarter off
    assert found.loc["lateral-sequence walk", "distance"] == pytest.approx(np.sqrt(4 / 6) / 4)


@pytest.mark.slow
@given(shift=st.floats(-0.2, 0.2))
def test_distance_is_the_common_shift(shift):
    moved = {pair: (phase + shift) % 1.0 for pair, phase in TROT.items()}
    found = pattern_distances(table(moved)).set_index("pattern")
    assert found.loc["trot", "distance"] == pytest.approx(abs(shift), abs=1e-9)


def test_metachronal_wave_of_an_insect_is_fitted():
    # each leg a fifth of a cycle after the one behind it, sides alternate
    legs = {"LF": 0.4, "LM": 0.2, "LH": 0.0, "RF": 0.9, "RM": 0.7, "RH": 0.5}
    pairs = [("LF", "RF"), ("LM", "RM"), ("LH", "RH"), ("LF", "LM"), ("LM", "LH"), ("RF", "RM")]
    means = {(a, b): (legs[a] - legs[b]) % 1.0 for a, b in pairs}
    found = pattern_distances(table(means)).set_index("pattern")
    assert found.loc[METACHRONAL, "free_lag"] == pytest.approx(0.2, abs=1e-3)
    assert found.loc[METACHRONAL, "distance"] == pytest.approx(0.0, abs=1e-3)
    # by hand: contralateral fit exactly, three ipsilateral pairs are 0.3 off
    assert found.loc["alternating tripod", "distance"] == pytest.approx(np.sqrt(3 / 6) * 0.3)


def test_the_thesis_spider_is_near_the_alternating_tetrapod():
    # Pullar 2009, section 4.2.4: mean phases of pairs 2 to 4
    means = {("L2", "R2"): 0.498, ("L3", "R3"): 0.485, ("L4", "R4"): 0.510, ("L2", "L3"): 0.437,
             ("R2", "R3"): 0.461, ("L3", "L4"): 0.493, ("R3", "R4"): 0.512, ("L2", "L4"): 0.936,
             ("R2", "R4"): 0.972}  # fmt: skip
    found = pattern_distances(table(means)).set_index("pattern")
    differences = np.array([-0.002, -0.015, 0.01, -0.063, -0.039, -0.007, 0.012, -0.064, -0.028])
    expected = np.sqrt(np.mean(differences**2))
    assert found.loc["alternating tetrapod", "distance"] == pytest.approx(expected, abs=1e-6)


def test_each_animal_is_told_apart_and_own_patterns_are_taken():
    both = pd.concat([table(TROT, "a"), table(dict.fromkeys(TROT, 0.0), "b")])
    found = pattern_distances(both)
    nearest = found[found["nearest"]].set_index("animal")["pattern"]
    assert nearest.to_dict() == {"a": "trot", "b": "pronk"}
    own = {"half": {"L1": 0.5, "R1": 0.0, "L2": 0.0, "R2": 0.5}}
    assert pattern_distances(table(TROT), patterns=own)["distance"].tolist() == [0.0]
    with pytest.raises(InputError, match="says no phase for leg L2"):
        pattern_distances(table(TROT), patterns={"x": {"L1": 0.0, "R1": 0.0, "R2": 0.0}})
    with pytest.raises(InputError, match="'left' does not say its side and place"):
        pattern_distances(table({("left", "right"): 0.5}))


def test_hildebrand_takes_the_hind_foot_and_the_fore_lag():
    strides = pd.DataFrame(
        {"animal": "a", "trial": "t", "leg": ["HL", "HR"], "stride": 1, "duty_factor": [0.6, 0.7]}
    )
    found = hildebrand_table(strides, table(TROT))
    assert found["duty_percent"].tolist() == pytest.approx([60.0, 70.0])
    assert found["lag_percent"].tolist() == [50.0, 50.0]
    # Hildebrand 1965: the fore foot a fifth of a stride after the hind foot has a lag of 20, not 80
    late = table({("FL", "HL"): 0.2, ("FR", "HR"): 0.3})
    trials = pd.concat([late, late.assign(trial="u")])
    longer = strides.assign(trial="u", duty_factor=[0.3, 0.4])
    found = hildebrand_table(pd.concat([strides, longer]), trials)
    assert found["trial"].tolist() == ["t", "u", "t", "u"]
    assert found["lag_percent"].tolist() == pytest.approx([20.0, 20.0, 30.0, 30.0])
    assert found["duty_percent"].tolist() == pytest.approx([60.0, 30.0, 70.0, 40.0])
    with pytest.raises(InputError, match="for four legs"):
        hildebrand_table(strides, table({("L1", "R1"): 0.5}))


def test_patterns_that_the_pairs_cannot_tell_apart_are_equally_near():
    # one side alone: fore against hind is half a cycle apart in trot and in bound
    phases = pd.DataFrame(
        {"animal": "a", "leg": "FR", "reference": "HR", "phase": [0.5, 0.48, 0.52]}
    )
    found = pattern_distances(phases).set_index("pattern")
    assert found.loc[["trot", "bound"], "nearest"].all()
    assert not found.loc["pace", "nearest"]
