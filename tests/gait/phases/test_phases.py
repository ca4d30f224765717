"""Phase lags and their summary: Eq. 3.21 by hand, published answers, animals as animals."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.gait.analysis.phase_patterns import length_needed, name_pattern
from pawnb.gait.phases import (
    build_phases,
    describe_phases,
    phase_lags,
    summarise_phases,
)
from pawnb.gait.strides import build_strides
from pawnb.schema import PHASE_SUMMARY_COLUMNS, PHASES_COLUMNS


def spans(times):
    return np.column_stack((times[:-1], times[1:]))


def test_phase_lag_by_hand():
    # (AEP_n - AEP_n') / P_n': 0.1 / 0.4 and 0.35 / 0.5
    which, phase = phase_lags(np.array([1.1, 1.75]), spans(np.array([1.0, 1.4, 1.9])))
    assert which.tolist() == [0, 1]
    np.testing.assert_allclose(phase, [0.25, 0.7])


def test_an_event_at_the_start_of_a_stride_is_phase_zero():
    which, phase = phase_lags(np.array([1.0, 1.4]), spans(np.array([1.0, 1.4, 1.9])))
    assert which.tolist() == [0, 1]
    assert phase.tolist() == [0.0, 0.0]


@settings(deadline=None)
@given(
    st.lists(st.floats(0, 100), max_size=30), st.lists(st.floats(0, 100), min_size=2, max_size=20)
)
def test_phases_are_in_the_cycle(times, reference):
    reference = np.unique(reference)
    which, phase = phase_lags(np.sort(times), spans(reference))
    assert ((phase >= 0) & (phase < 1)).all()
    inside = [t for t in times if len(reference) > 1 and reference[0] <= t < reference[-1]]
    assert len(which) == len(inside)


# lift-offs as cycles, all target lift-offs inside the cycle; computed with pingouin and
# pycircstat2 from the same events (data folder, circular-worked-examples.md)
TARDIGRADE = [
    ("R1", "L1", 11, 0.365842, 0.31170264),
    ("R2", "L2", 11, 0.420079, 0.10494213),
    ("R4", "L4", 13, 0.526831, 0.82670247),
    ("L2", "L3", 12, 0.466729, 0.74414618),
    ("R1", "R2", 11, 0.578410, 0.64479622),
]


@pytest.mark.parametrize(("leg", "reference", "n", "mean", "r"), TARDIGRADE)
def test_phases_of_a_real_tardigrade(real_data, leg, reference, n, mean, r):
    table = pd.read_csv(real_data("tardigrade-8leg-events") / "events_long.csv")
    up = table[table["event"] == "up"]
    own, base = (np.sort(up.loc[up["leg"] == x, "time_s"].to_numpy()) for x in (leg, reference))
    _, phase = phase_lags(own, spans(base))
    found = describe_phases(phase)
    assert len(phase) == n
    assert found["mean"] == pytest.approx(mean, abs=1e-5)
    assert found["r"] == pytest.approx(r, abs=1e-6)
    # a twin with one lift-off a frame later is noticed
    own[len(own) // 2] += 1 / 33
    assert describe_phases(phase_lags(own, spans(base))[1])["mean"] != pytest.approx(mean, abs=1e-5)


@pytest.mark.parametrize(
    ("leg", "reference", "n", "mean", "r"),
    [
        ("RF", "LF", 25, 0.544400, 0.94232823),
        ("RH", "LH", 26, 0.513412, 0.79663612),
        ("LF", "LM", 28, 0.310668, 0.81330273),
        ("RM", "LF", 26, 0.249330, 0.78251995),
    ],
)
def test_phases_of_a_real_fly(real_data, leg, reference, n, mean, r):
    # source as for the tardigrade: lift-offs of hand-scored contact
    contact = pd.read_csv(real_data("fly-6leg-contact") / "ground_truth_contact_fly1.csv")
    lift = {x: np.flatnonzero(np.diff(contact[x].to_numpy()) == -1) for x in (leg, reference)}
    _, phase = phase_lags(lift[leg], spans(lift[reference]))
    found = describe_phases(phase)
    assert len(phase) == n
    assert found["mean"] == pytest.approx(mean, abs=1e-5)
    assert found["r"] == pytest.approx(r, abs=1e-6)


def events(leg, start, period, n, duty=0.6):
    """Steady events of one leg."""
    rows = []
    for k in range(n):
        for event, at in (("AEP", 0.0), ("PEP", duty)):
            time = start + (k + at) * period
            rows.append({"animal": "m1", "trial": "t1", "leg": leg, "event": event,
                         "frame": time, "time_s": time, "method": "test"})  # fmt: skip
    return rows


def test_phase_table_and_strides_without_an_event():
    both = pd.DataFrame(events("FR", 0.0, 0.3, 6) + events("FL", 0.15, 0.3, 3))
    strides, _ = build_strides(both, start_event="AEP")
    phases, dropped = build_phases(both, strides, [("FL", "FR")], start_event="AEP")
    assert list(phases.columns) == list(PHASES_COLUMNS)
    np.testing.assert_allclose(phases["phase"], 0.5)
    assert phases["stride"].tolist() == [1, 2, 3]
    assert dropped["what"].tolist() == ["phase to FR"] * 2
    assert dropped["why"].tolist() == [
        "no AEP of FL within stride 4 of FR", "no AEP of FL within stride 5 of FR"
    ]  # fmt: skip
    np.testing.assert_allclose(dropped["start_s"], [0.9, 1.2])


def table(by_animal, leg="FL", reference="FR"):
    rows = [
        {"animal": a, "trial": "t", "leg": leg, "reference": reference, "stride": i, "phase": p}
        for a, values in by_animal.items()
        for i, p in enumerate(values)
    ]
    return pd.DataFrame(rows)


def test_animals_count_as_animals():
    # ten strides of one animal at 0.5, one each of two others at 0.4 and 0.6
    summary = summarise_phases(table({"a": [0.5] * 10, "b": [0.4], "c": [0.6]})).iloc[0]
    assert list(summarise_phases(table({"a": [0.5]})).columns) == list(PHASE_SUMMARY_COLUMNS)
    assert summary["n"] == 12
    assert summary["n_animals"] == 3
    assert summary["mean"] == pytest.approx(0.5)
    assert summary["mean_strides"] == pytest.approx(0.5)
    # mean of three unit vectors at 0.4, 0.5, 0.6: (1 + 2 cos 36 deg) / 3; of twelve likewise
    cosine = math.cos(0.2 * math.pi)
    assert summary["r"] == pytest.approx((1 + 2 * cosine) / 3)
    assert summary["r_strides"] == pytest.approx((10 + 2 * cosine) / 12)
    assert summary["rayleigh_z"] == pytest.approx(3 * summary["r"] ** 2)
    assert summary["rayleigh_z_strides"] == pytest.approx(12 * summary["r_strides"] ** 2)
    assert summary["rayleigh_p_strides"] < 1e-4 < summary["rayleigh_p"]
    assert summary["pattern_strides"] == "anti-phase"


def test_one_animal_says_nothing_about_animals():
    summary = summarise_phases(table({"a": [0.45, 0.5, 0.55, 0.5]})).iloc[0]
    assert summary["n_animals"] == 1
    assert summary["mean"] == pytest.approx(0.5)
    for name in ("ci_low", "ci_high", "r", "circular_sd", "rayleigh_z", "rayleigh_p"):
        assert math.isnan(summary[name]), name
    assert summary["pattern"] is None
    assert summary["r_strides"] > 0.9


@pytest.mark.slow
@settings(deadline=None)
@given(st.floats(0, 1, exclude_max=True), st.integers(1, 4))
def test_repeating_an_animals_strides_changes_no_animal_statistic(phase, times):
    base = {"a": [phase, phase + 0.05], "b": [phase + 0.1], "c": [phase - 0.02, phase]}
    wrapped = {k: list(np.mod(v, 1)) for k, v in base.items()}
    repeated = {k: v * (times if k == "a" else 1) for k, v in wrapped.items()}
    one = summarise_phases(table(wrapped)).iloc[0]
    two = summarise_phases(table(repeated)).iloc[0]
    for name in ("r", "rayleigh_z", "rayleigh_p"):
        assert one[name] == pytest.approx(two[name], rel=1e-9)
    assert (one["mean"] - two["mean"] + 0.5) % 1 - 0.5 == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("mean", "r", "n", "pattern"),
    [
        (0.5, 0.95, 6, "anti-phase"), (0.4, 0.95, 6, "anti-phase"), (0.6, 0.95, 6, "anti-phase"),
        (0.29, 0.95, 6, "shifted"), (0.39, 0.95, 6, "shifted"), (0.11, 0.95, 6, "shifted"),
        (0.1, 0.95, 6, "in-phase"), (0.98, 0.95, 6, "in-phase"), (0.9, 0.95, 6, "in-phase"),
        (0.507, 0.996, 2, "not determined"),  # Rayleigh's p of two animals so near: 0.057
        (0.507, 0.998, 2, "anti-phase"),  # 0.040
        (0.5, 0.4, 5, "not determined"), (0.5, 0.05, 30, "random"), (0.5, 0.05, 3, "random"),
        (0.5, 0.1, 8, "random"), (0.5, 0.3, 8, "not determined"), (0.5, 0.3, 400, "random"),
        (math.nan, 0.0, 20, "random"),
    ],
)  # fmt: skip
def test_pattern_follows_its_rule(mean, r, n, pattern):
    # within 0.1 cycle of 0 or of 0.5, or shifted; random only where r is surely below 0.5
    assert name_pattern(mean, r, n) == pattern


def test_a_pattern_that_is_not_determined_says_what_it_would_take():
    # two phases 0.06 cycle apart: Kluyver's p for n = 2 is their distance over half a cycle
    row = summarise_phases(table({"a": [0.48], "b": [0.54]})).iloc[0]
    assert row["pattern"] == "not determined"
    assert row["rayleigh_p"] == pytest.approx(0.12)
    # p 0.05 is a distance of 0.025 cycle, r = cos(pi 0.025)
    assert length_needed(2) == pytest.approx(math.cos(0.025 * math.pi))
    assert "2 animals reach p 0.05 only with an r of 0.997 or more" in row["note"]
    assert "smallest p possible" in row["note"]
    near = summarise_phases(table({"a": [0.50], "b": [0.51]})).iloc[0]
    assert (near["pattern"], near["note"]) == ("anti-phase", "")


def test_a_weak_preference_of_many_is_said():
    values = np.mod(np.arange(60) / 60 + 0.1 * np.sin(2 * np.pi * np.arange(60) / 60), 1)
    row = summarise_phases(table({f"m{i}": [v] for i, v in enumerate(values)})).iloc[0]
    assert row["rayleigh_p"] < 0.05 < 0.25 < row["r"] < row["r_high"] < 0.5
    assert row["pattern"] == "random"
    assert "weak preference" in row["note"]


def test_flies_legs_are_not_random(real_data):
    # one fly: its strides; LF to LM has a mean phase of 0.31, which is no anti-phase
    contact = pd.read_csv(real_data("fly-6leg-contact") / "ground_truth_contact_fly1.csv")
    names = {}
    for leg, reference in (("RF", "LF"), ("RH", "LH"), ("LF", "LM")):
        lift, base = (
            np.flatnonzero(np.diff(contact[x].to_numpy()) == -1) for x in (leg, reference)
        )
        names[leg] = describe_phases(phase_lags(lift, spans(base))[1])["pattern"]
    assert names == {"RF": "anti-phase", "RH": "anti-phase", "LF": "shifted"}


@pytest.mark.parametrize("bad", [np.inf, np.nan])
def test_times_that_are_not_finite_are_refused(bad):
    with pytest.raises(InputError, match=r"^times of events: some are not finite"):
        phase_lags(np.array([0.1, bad]), np.array([[0.0, 1.0]]))
    with pytest.raises(InputError, match=r"^strides of the reference: some are not finite"):
        phase_lags(np.array([0.1]), np.array([[0.0, bad]]))


def test_an_empty_table_has_its_columns():
    empty = summarise_phases(pd.DataFrame(columns=list(PHASES_COLUMNS)))
    assert empty.empty
    assert list(empty.columns) == list(PHASE_SUMMARY_COLUMNS)
    assert describe_phases(np.array([]))["pattern"] is None
