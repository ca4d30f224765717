"""Ground contact by hand: to events, and compared with events found in tracks."""

import numpy as np
import pandas as pd
import pytest

from pawnb import gait
from pawnb.errors import InputError
from pawnb.gait.events.contacts import contact_agreement, events_from_contacts, is_contact_table
from pawnb.gait.strides import build_strides

CONTACTS = pd.DataFrame(
    {
        "frame": range(12),
        "LF": [0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 0, 1],
        "RF": [1, 1, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1],
    }
)


def test_changes_lie_between_frames():
    events = events_from_contacts(CONTACTS, fps=10.0, animal="fly", trial="t")
    own = events[events["leg"] == "LF"]
    assert own["event"].tolist() == ["TD", "LO", "TD", "LO", "TD"]
    assert own["frame"].tolist() == [0.5, 3.5, 5.5, 8.5, 10.5]
    assert own["time_s"].tolist() == pytest.approx([0.05, 0.35, 0.55, 0.85, 1.05])
    strides, _ = build_strides(events, start_event="TD")
    # by hand: strides of 0.5 s with 0.3 s on the ground
    np.testing.assert_allclose(strides.loc[strides["leg"] == "LF", "period_s"], 0.5)
    np.testing.assert_allclose(strides.loc[strides["leg"] == "LF", "duty_factor"], 0.6)


def test_no_event_next_to_what_is_not_known():
    table = CONTACTS.drop(index=4).astype({"LF": float})  # frame 4 is missing
    table.loc[9, "LF"] = np.nan
    own = events_from_contacts(table, fps=10.0).query("leg == 'LF'")
    assert own["frame"].tolist() == [0.5, 5.5, 10.5]


def test_agreement_of_equal_and_of_late_events():
    events = events_from_contacts(CONTACTS, fps=10.0)
    same = contact_agreement(events, CONTACTS, fps=10.0).set_index("leg")
    assert same.loc["LF", "agreement"] == 1.0
    assert same.loc["LF", "kappa"] == 1.0
    late = events.assign(frame=events["frame"] + 1, time_s=events["time_s"] + 0.1)
    late = contact_agreement(late, CONTACTS, fps=10.0).set_index("leg")
    assert late.loc["LF", "td_shift_s"] == pytest.approx(0.1)
    # LF from frame 2 to 11: one frame wrong after each of 4 changes that are compared
    assert late.loc["LF", "agreement"] == pytest.approx(6 / 10)
    # each of these lies next to a change by hand
    assert late.loc["LF", "agreement_one_frame"] == 1.0
    assert (same[["td_missed", "td_extra", "lo_missed", "lo_extra"]] == 0).all(axis=None)


def test_missed_and_extra_events_are_counted():
    events = events_from_contacts(CONTACTS, fps=10.0).query("leg == 'LF'")
    # the stride in the middle is not found, and one is found at 2 s where the foot is down
    gone = events[~events["frame"].isin([3.5, 5.5])]
    row = contact_agreement(gone, CONTACTS, fps=10.0).set_index("leg").loc["LF"]
    assert row["td_missed"] == 1
    assert row["lo_missed"] == 0  # it lies before the only lift-off that is left
    assert (row["td_extra"], row["lo_extra"]) == (0, 0)
    assert row["agreement"] == pytest.approx(8 / 10)
    more = pd.DataFrame({"leg": "LF", "event": ["LO", "TD"], "frame": [6.7, 7.2],
                         "time_s": [0.67, 0.72]})  # fmt: skip
    row = (
        contact_agreement(pd.concat([events, more]), CONTACTS, fps=10.0).set_index("leg").loc["LF"]
    )
    assert (row["td_extra"], row["lo_extra"]) == (1, 1)
    assert (row["td_missed"], row["n_td"]) == (0, 3)


def test_tables_that_are_no_contacts_are_refused():
    assert is_contact_table(CONTACTS)
    assert not is_contact_table(pd.DataFrame({"frame": [0, 1], "x": [0.0, 2.5]}))
    assert not is_contact_table(pd.DataFrame({"time": [0, 1], "LF": [0, 1]}))
    with pytest.raises(InputError, match="leg LF is 2"):
        events_from_contacts(CONTACTS.replace({"LF": {1: 2}}), fps=10.0)
    with pytest.raises(InputError, match="column 'frame' is missing"):
        events_from_contacts(CONTACTS.drop(columns="frame"), fps=10.0)


def test_real_fly_contacts(real_data):
    # duty factors as shares of frames, from the data set's own notes
    folder = real_data("fly-6leg-contact")
    contacts = pd.read_csv(folder / "ground_truth_contact_fly1.csv")
    expected = {"LF": 0.753, "LM": 0.835, "LH": 0.571, "RF": 0.775, "RM": 0.853, "RH": 0.846}
    for leg, duty in expected.items():
        assert contacts[leg].mean() == pytest.approx(duty, abs=6e-4)
    tables = gait.analyse_events(events_from_contacts(contacts, fps=100.0))
    assert set(tables.strides["leg"]) == set(expected)
    # phase from lift-offs in the worked examples: RF relative to LF 0.544; from touch-downs
    # the same pair alternates too
    lag = tables.phase_summary.set_index(["leg", "reference"]).loc[("LF", "RF"), "mean"]
    assert 0.35 < lag < 0.65


def walk_by_hand():
    """Ten seconds at 100 frames a second, four strides a second, 60 % of each on the ground."""
    t = np.arange(1000) / 100
    phases = {"FR": 0.13, "HR": 0.63, "FL": 0.63, "HL": 0.13}
    return pd.DataFrame(
        {"frame": np.arange(1000)}
        | {leg: (((t * 4 + phase) % 1) < 0.6).astype(float) for leg, phase in phases.items()}
    )


@pytest.mark.parametrize("how", ["rows", "cells"])
def test_no_stride_goes_over_frames_that_nobody_scored(how):
    whole = walk_by_hand()
    gap = whole["frame"].between(400, 479)
    legs = list(whole)[1:]
    cut = whole[~gap] if how == "rows" else whole.assign(**whole[legs].mask(gap).to_dict("series"))
    tables = gait.analyse_events(events_from_contacts(cut, fps=100.0))
    # 0.8 s is gone: three strides and two that are cut; without the gap in the table one stride
    # of a second would stand there, with one lift-off like all others
    strides = tables.strides[tables.strides["leg"] == "FR"]
    assert len(strides) == 39 - 4
    np.testing.assert_allclose(strides["period_s"], 0.25, atol=0.011)
    rows = tables.dropped[(tables.dropped["leg"] == "FR") & (tables.dropped["what"] == "contact")]
    assert rows[["start_s", "end_s"]].to_numpy().tolist() == [[3.99, 4.8]]


def test_a_frame_not_scored_within_a_stance_is_no_gap():
    whole = walk_by_hand()
    middle = whole["FR"].rolling(9, center=True).sum() == 9
    cut = whole.assign(FR=whole["FR"].mask(middle & (whole["frame"] % 7 == 0)))
    assert cut["FR"].isna().sum() > 20
    strides = [
        gait.analyse_events(events_from_contacts(x, fps=100.0)).strides for x in (whole, cut)
    ]
    assert len(strides[0]) == len(strides[1])
