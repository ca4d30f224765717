"""Strides from events: arithmetic that can be done by hand, and what is dropped and why."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.gait.strides import EXTRA_COLUMNS, Motion, build_strides, choose_stride_event
from pawnb.schema import DROPPED_COLUMNS, STRIDES_COLUMNS


def events(rows, leg="FR"):
    """Events of one leg from (event, time) pairs."""
    return pd.DataFrame(
        [
            {"animal": "m1", "trial": "t1", "leg": leg, "event": e, "frame": 250 * t, "time_s": t,
             "method": "test", "position": {"AEP": 20.0, "PEP": -10.0}.get(e, np.nan)}
            for e, t in rows
        ]
    )  # fmt: skip


STEADY = [("AEP", 0.1), ("PEP", 0.28), ("AEP", 0.4), ("PEP", 0.58), ("AEP", 0.7)]


def test_a_stride_by_hand():
    strides, dropped = build_strides(events(STEADY), start_event="AEP")
    assert list(strides.columns) == [*STRIDES_COLUMNS, *EXTRA_COLUMNS]
    assert dropped.empty
    assert list(dropped.columns) == list(DROPPED_COLUMNS)
    assert strides["stride"].tolist() == [1, 2]
    row = strides.iloc[0]
    assert row[["animal", "trial", "leg", "method"]].tolist() == ["m1", "t1", "FR", "AEP/PEP"]
    for name, value in {
        "start_s": 0.1, "period_s": 0.3, "frequency_hz": 1 / 0.3, "stance_s": 0.18,
        "swing_s": 0.12, "duty_factor": 0.6, "aep_position": 20.0, "pep_position": -10.0,
    }.items():  # fmt: skip
        assert row[name] == pytest.approx(value, rel=1e-9), name
    # without motion nothing is invented
    assert strides[["stride_length", "speed", "step_displacement"]].isna().all(axis=None)


def test_touch_down_and_lift_off_bound_strides_too():
    scored = events([("LO", 0.0), ("TD", 0.1), ("LO", 0.25), ("TD", 0.4), ("LO", 0.5)])
    strides, _ = build_strides(scored, start_event="TD")
    assert len(strides) == 1
    assert strides.loc[0, "method"] == "TD/LO"
    assert strides.loc[0, "duty_factor"] == pytest.approx(0.5)
    assert np.isnan(strides.loc[0, "aep_position"])


def test_length_speed_and_displacement():
    t = np.linspace(0, 1, 501)
    # the belt runs at 300 and the body drifts forward at 20; the foot lands every 96 + 1.5
    motion = Motion(time_s=t, body=320.0 * t, feet={"FR": 325.0 * t})
    strides, _ = build_strides(events(STEADY), start_event="AEP", motion={"FR": motion})
    np.testing.assert_allclose(strides["speed"], 320.0)
    np.testing.assert_allclose(strides["stride_length"], 320.0 * 0.3)
    np.testing.assert_allclose(strides["step_displacement"], 325.0 * 0.3)


def test_contact_within_a_stance_from_aep():
    rows = [*STEADY, ("TD", 0.13), ("LO", 0.25), ("TD", 0.43), ("LO", 0.55)]
    strides, _ = build_strides(events(rows), start_event="AEP")
    np.testing.assert_allclose(strides["contact_s"], 0.12)
    np.testing.assert_allclose(strides["contact_duty_factor"], 0.4)
    # without its touch-down the contact is not taken from the stride before
    gone, _ = build_strides(events([r for r in rows if r != ("TD", 0.43)]), start_event="AEP")
    assert np.isnan(gone["contact_s"].iloc[1])
    assert gone["contact_s"].iloc[0] == pytest.approx(0.12)


@pytest.mark.parametrize(
    ("rows", "gaps", "limit", "why"),
    [
        ([("AEP", 0.1), ("AEP", 0.4)], None, None, "no PEP between two AEP; expected one"),
        ([("AEP", 0.1), ("PEP", 0.2), ("PEP", 0.3), ("AEP", 0.4)], None, None,
         "2 PEP between two AEP; expected one"),
        ([("AEP", 0.1), ("PEP", 0.2), ("AEP", 0.9)], None, 0.5, "longer than 0.5 s (max_stride_s)"),
        ([("AEP", 0.1), ("PEP", 0.2), ("AEP", 0.4)], [("FR", 0.25, 0.35)], None,
         "not tracked for 0.100 s in it"),
    ],
)  # fmt: skip
def test_what_is_no_stride_is_dropped_with_its_reason(rows, gaps, limit, why):
    table = None if gaps is None else pd.DataFrame(gaps, columns=["leg", "start_s", "end_s"])
    strides, dropped = build_strides(
        events(rows), start_event="AEP", gaps=table, max_stride_s=limit
    )
    assert strides.empty
    assert dropped[["leg", "start_s", "end_s", "what", "why"]].to_numpy().tolist() == [
        ["FR", 0.1, rows[-1][1], "stride", why]
    ]


def test_gaps_of_other_legs_or_times_drop_nothing():
    gaps = pd.DataFrame(
        [("HR", 0.2, 0.3), ("FR", 0.7, 0.9), ("FR", 0.0, 0.1)], columns=["leg", "start_s", "end_s"]
    )
    strides, dropped = build_strides(events(STEADY), start_event="AEP", gaps=gaps)
    assert len(strides) == 2
    assert dropped.empty


def test_event_that_begins_a_stride():
    both = events([*STEADY, ("TD", 0.2)])
    assert choose_stride_event(both, "auto") == "AEP"
    assert choose_stride_event(both, "TD") == "TD"
    assert choose_stride_event(events([("TD", 0.2), ("LO", 0.3)]), "auto") == "TD"


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(0.02, 1.0), min_size=3, max_size=20),
    st.floats(-100, 100),
    st.floats(0.1, 10),
)
def test_strides_follow_time(durations, shift, stretch):
    times = np.cumsum(durations)
    names = ["AEP" if i % 2 == 0 else "PEP" for i in range(len(times))]
    one, _ = build_strides(events(zip(names, times, strict=True)), start_event="AEP")
    moved = stretch * times + shift
    two, _ = build_strides(events(zip(names, moved, strict=True)), start_event="AEP")
    assert len(one) == len(two) == (len(times) - 1) // 2
    np.testing.assert_allclose(two["duty_factor"], one["duty_factor"], atol=1e-6)
    np.testing.assert_allclose(two["period_s"], stretch * one["period_s"], atol=1e-6)
    assert ((one["duty_factor"] > 0) & (one["duty_factor"] < 1)).all()
    np.testing.assert_allclose(one["stance_s"] + one["swing_s"], one["period_s"])
