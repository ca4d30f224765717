"""Rules of coupling on events and phases made to obey or to break them."""

import numpy as np
import pandas as pd
import pytest

from pawnb.gait.phases.coupling import (
    alternation_rule,
    coupling_strength,
    kind_of_pair,
    support_rule,
)


@pytest.mark.parametrize(
    ("leg", "reference", "kind"),
    [
        ("L2", "R2", "contralateral"), ("L2", "L3", "ipsilateral"), ("R4", "R3", "ipsilateral"),
        ("L1", "R2", "diagonal"), ("L1", "L3", "other"), ("L1", "R3", "other"),
        ("FL", "HL", "ipsilateral"), ("FL", "HR", "diagonal"), ("FL", "FR", "contralateral"),
        ("LF", "LM", "ipsilateral"), ("LF", "LH", "other"), ("LM", "RH", "diagonal"),
        ("left", "right", "other"),
    ],
)  # fmt: skip
def test_kinds_of_pairs(leg, reference, kind):
    assert kind_of_pair(leg, reference) == kind


def phases(animal, spread, seed=0):
    rng = np.random.default_rng(seed)
    means = {("L2", "R2"): 0.5, ("L3", "R3"): 0.48, ("L2", "L3"): 0.45, ("R2", "R3"): 0.47,
             ("L2", "R3"): 0.95}  # fmt: skip
    rows = []
    for (leg, reference), mean in means.items():
        for phase in (mean + spread[kind_of_pair(leg, reference)] * rng.normal(size=400)) % 1.0:
            rows.append({"animal": animal, "leg": leg, "reference": reference, "phase": phase})
    return pd.DataFrame(rows)


def test_coupling_recovers_the_spread_it_was_made_with():
    spread = {"contralateral": 0.05, "ipsilateral": 0.02, "diagonal": 0.08}
    found = coupling_strength(phases("a", spread)).set_index("kind")
    for kind, sd in spread.items():
        assert found.loc[kind, "circular_sd"] == pytest.approx(sd, rel=0.08)
    # pairs with different means of one kind do not add to the spread
    assert found.loc["contralateral", "n_pairs"] == 2


def test_alternation_is_measured_from_a_half():
    spread = {"contralateral": 0.01, "ipsilateral": 0.01, "diagonal": 0.01}
    found = alternation_rule(phases("a", spread)).set_index("leg")
    assert list(found.index) == ["L2", "L3"]
    assert found.loc["L3", "from_half"] == pytest.approx(-0.02, abs=2e-3)


def walk(lag, *, duty=0.6, n=20):
    """Leg L2 lands ``lag`` of a cycle after L3 behind it; stance from AEP to PEP."""
    rows = []
    for k in range(n):
        for leg, shift in (("L3", 0.0), ("L2", lag)):
            for event, t in (("AEP", k + shift), ("PEP", k + shift + duty)):
                rows.append({"animal": "a", "trial": "t", "leg": leg, "event": event, "time_s": t})
    return pd.DataFrame(rows)


def test_a_leg_that_waits_for_the_one_behind_obeys():
    # L3 is in stance from 0 to 0.6; L2's protraction begins at lag + 0.6
    obeying = support_rule(walk(0.45)).set_index("leg")  # begins at 0.05 of L3's next stance
    assert obeying.loc["L2", "share"] == 1.0
    assert obeying.loc["L2", "behind"] == "L3"
    breaking = support_rule(walk(0.1)).set_index("leg")  # begins at 0.7: L3 is in swing
    assert breaking.loc["L2", "share"] == 0.0
    assert breaking.loc["L2", "n_protractions"] > 15


def test_names_that_are_numbers_are_the_same_in_events_and_strides():
    """A csv of strides that is read again has animal 1 as a number."""
    events = walk(0.45).assign(animal="1", trial="7")
    strides = pd.DataFrame({"animal": 1, "trial": 7, "leg": "L3", "start_s": np.arange(20.0)})
    strides = strides.assign(period_s=1.0)
    (as_numbers,) = support_rule(events, strides=strides)["n_protractions"]
    words = strides.astype({"animal": str, "trial": str})
    assert as_numbers == support_rule(events, strides=words)["n_protractions"].item() > 15


def test_a_trial_scored_by_contact_counts_beside_one_scored_by_position():
    positions = walk(0.45)
    contacts = walk(0.45).assign(animal="b").replace({"AEP": "TD", "PEP": "LO"})
    found = support_rule(pd.concat([positions, contacts], ignore_index=True))
    assert found["animal"].tolist() == ["a", "b"]
    one, other = found["n_protractions"]  # the same walk, under other names of events
    assert one == other > 15
    assert found["share"].tolist() == [1.0, 1.0]


def test_a_leg_that_ignores_the_one_behind_scores_its_duty_factor():
    rng = np.random.default_rng(1)
    events = walk(0.0, n=4000)
    loose = events["leg"] == "L2"
    events.loc[loose, "time_s"] += np.repeat(rng.uniform(0, 1, loose.sum() // 2), 2)
    found = support_rule(events).set_index("leg")
    assert found.loc["L2", "share"] == pytest.approx(0.6, abs=0.03)
