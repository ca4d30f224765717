"""Legs without a stride are said, with what was found of them instead."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from walking import Walk

from pawnb.gait import analyse, analyse_events, pool
from pawnb.gait.analysis.missing_strides import say_no_strides


def test_a_trial_without_a_stride_says_what_was_found_and_what_is_needed():
    rows = [("FR", "TD", 0.01), ("FR", "LO", 0.09), ("HR", "LO", 0.02), ("HR", "TD", 0.06)]
    short = pd.DataFrame(rows, columns=["leg", "event", "time_s"])
    (said,) = say_no_strides(analyse_events(short.assign(animal="m", trial="short")))
    assert said == (
        "short: no stride, for one runs from TD to TD of the same leg, with one LO between; found "
        "TD: 1 of FR, 1 of HR; a longer recording is needed, or other settings of the event "
        "detection."
    )
    again = pd.DataFrame(
        [*rows, ("FR", "TD", 0.12), ("HR", "LO", 0.11), ("HR", "TD", 0.16)], columns=short.columns
    )
    assert say_no_strides(analyse_events(again.assign(animal="m", trial="long"))) == []
    both = pool(
        [analyse_events(t.assign(animal="m", trial=n)) for n, t in (("a", short), ("b", again))]
    )
    assert [text.split(":")[0] for text in say_no_strides(both)] == ["a"]
    no_lift_off = again[again["event"] == "TD"]
    (said,) = say_no_strides(analyse_events(no_lift_off.assign(animal="m", trial="t")))
    assert "found TD: 2 of FR, 2 of HR (2 from TD to TD dropped: see dropped.csv); a longer" in said


def test_a_leg_without_a_stride_is_said_where_others_have_some():
    rows = [("FR", "TD", 0.01), ("FR", "LO", 0.09), ("FR", "TD", 0.12), ("HR", "TD", 0.06)]
    scored = pd.DataFrame(rows, columns=["leg", "event", "time_s"]).assign(animal="m", trial="t")
    (said,) = say_no_strides(analyse_events(scored))
    assert said.startswith("t: no stride of HR, for one runs from TD to TD")
    assert "found TD: 1 of HR; a longer recording" in said
    # of two animals in one trial it says whose, once where it is the same of both
    both = pd.concat([scored, scored.assign(animal="n")])
    assert [text[:24] for text in say_no_strides(analyse_events(both))] == [
        "t: m, n: no stride of HR"
    ]
    other = pd.concat([scored[scored["leg"] == "FR"], scored.assign(animal="n")])
    (said,) = say_no_strides(analyse_events(other))
    assert said.startswith("t: n: no stride of HR, for")


def test_a_leg_without_a_stride_that_was_never_seen_is_said_so():
    tracks = Walk().tracks(treadmill=True)
    tracks["position"].loc[{"keypoint": "HL"}] = np.nan
    (said,) = say_no_strides(analyse(tracks, belt_speed=300.0))
    assert said.startswith("trial: no stride of HL, for")
    assert "found AEP: 0 of HL (no position in any frame)" in said


def test_feet_that_stand_still_say_why_none_of_their_turns_count():
    """A longer recording of the same would not help; what was found was in dropped.csv only."""
    tracks = Walk().tracks(treadmill=True)
    tracks["position"].data[:] = tracks["position"].data[:1]
    (said,) = say_no_strides(analyse(tracks, belt_speed=300.0))
    assert said.startswith("trial: no stride, for one runs")
    assert " left out, most often as " in said
    assert "frames is shorter than" in said


@pytest.mark.slow
def test_an_animal_that_was_never_seen_does_not_take_the_others_with_it():
    tracks = Walk().tracks(treadmill=True)
    alone = analyse(tracks, belt_speed=300.0)
    unseen = tracks.copy(deep=True).assign_coords(individual=["ghost"])
    unseen["position"].data[:] = np.nan
    both = xr.concat([tracks, unseen], dim="individual", combine_attrs="override")
    found = analyse(both, belt_speed=300.0)
    pd.testing.assert_frame_equal(found.strides, alone.strides)
    assert say_no_strides(found) == [
        "trial: ghost: left out, as no leg has a position in any frame."
    ]
    assert found.notes == alone.notes  # what is said of all that are seen is said of nobody by name
    own = found.dropped[found.dropped["animal"] == "ghost"]
    assert set(own["leg"]) == {"FR", "HR", "FL", "HL"}


@pytest.mark.slow
def test_what_is_shown_of_an_analysis_names_the_legs_without_a_stride():
    tracks = Walk().tracks(treadmill=True)
    assert "no stride" not in repr(analyse(tracks, belt_speed=300.0))
    tracks["position"].loc[{"keypoint": ["HL", "FR"]}] = np.nan
    assert "notes, no stride of FR, HL)" in repr(analyse(tracks, belt_speed=300.0))
