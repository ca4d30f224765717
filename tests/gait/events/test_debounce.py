"""Slips of the hand in ground contact: taken out, and said."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.gait import EventSettings, analyse_events
from pawnb.gait.events.contacts import events_from_contacts


def contacts_of(state, *, leg="LF"):
    return pd.DataFrame({"frame": np.arange(len(state)), leg: state})


def test_a_wrong_frame_in_a_stance_makes_no_stride():
    # ten strides of 10 frames, 7 of them on the ground: 9 whole strides from touch-down
    state = ([1] * 7 + [0] * 3) * 10 + [1] * 4
    right = analyse_events(events_from_contacts(contacts_of(state), fps=100.0))
    for wrong in (33, 58):  # in the middle of a stance, and of a swing
        flipped = list(state)
        flipped[wrong] = 1 - flipped[wrong]
        tables = analyse_events(events_from_contacts(contacts_of(flipped), fps=100.0))
        pd.testing.assert_frame_equal(tables.strides, right.strides)
        (row,) = tables.dropped.itertuples()
        assert (row.leg, row.what) == ("LF", "swing" if wrong == 33 else "stance")
        # contact changes half way between frames
        assert (row.start_s, row.end_s) == pytest.approx(((wrong - 0.5) / 100, (wrong + 0.5) / 100))
        assert "taken for a slip of the scoring" in row.why


def test_limits_that_are_asked_for_go_before_those_of_the_leg():
    state = ([1] * 7 + [0] * 3) * 4 + [1] * 7 + [0] * 1 + ([1] * 7 + [0] * 3) * 4
    events = events_from_contacts(contacts_of(state), fps=100.0)
    kept = analyse_events(events, settings=EventSettings(min_stance_s=0.0, min_swing_s=0.0))
    assert kept.dropped.empty
    assert kept.strides["swing_s"].min() == pytest.approx(0.01)
    assert len(analyse_events(events).strides) == len(kept.strides) - 1


def test_events_of_another_kind_stay_unless_limits_are_asked_for():
    times = {"TD": [0.0, 0.2, 0.4, 0.6], "LO": [0.1, 0.3, 0.41, 0.7]}
    rows = [("L", event, t) for event, at in times.items() for t in at]
    events = pd.DataFrame(rows, columns=["leg", "event", "time_s"])
    assert analyse_events(events).dropped.empty
    asked = analyse_events(events, settings=EventSettings(min_stance_s=0.05))
    assert asked.dropped["what"].tolist() == ["stance"]
    assert asked.strides["period_s"].tolist() == pytest.approx([0.2, 0.4])


def test_six_wrong_frames_a_leg_of_a_real_fly(real_data):
    # 599 frames of a fly, contact of six legs by hand; the frequency with the slips left in
    # would be 20 to 30 % too high, and up to 50 Hz
    contacts = pd.read_csv(real_data("fly-6leg-contact") / "ground_truth_contact_fly1.csv")
    right = analyse_events(events_from_contacts(contacts, fps=100.0)).strides
    rng = np.random.default_rng(0)
    for leg in contacts.columns.drop("frame"):
        wrong = rng.choice(np.arange(5, 590), 6, replace=False)
        contacts.loc[wrong, leg] = 1 - contacts.loc[wrong, leg]
    found = analyse_events(events_from_contacts(contacts, fps=100.0)).strides
    assert len(found) == pytest.approx(len(right), abs=3)
    assert found["frequency_hz"].mean() == pytest.approx(right["frequency_hz"].mean(), rel=0.01)
    assert found["frequency_hz"].max() < 15.0
    kept = EventSettings(min_stance_s=0.0, min_swing_s=0.0)
    noisy = analyse_events(events_from_contacts(contacts, fps=100.0), settings=kept).strides
    assert noisy["frequency_hz"].mean() > 1.2 * right["frequency_hz"].mean()


def test_the_steps_of_a_real_tardigrade_all_stay(real_data):
    # 95 steps of eight legs, as published; the shortest is 0.62 of its leg's median
    events = pd.read_csv(real_data("tardigrade-8leg-events") / "events_long.csv")
    events["method"] = "contact by hand"
    tables = analyse_events(events, event_names={"down": "TD", "up": "LO"})
    assert len(tables.strides) == 95
    assert not tables.dropped["what"].isin(["stance", "swing"]).any()
