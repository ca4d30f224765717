"""Corrections of events after tracks were tracked again: neither a neighbour is hit, nor a double.

The truth is made: two legs, strides of 0.2 s and stances of 0.12 s, so a duty factor of 0.6.
"""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from pawnb import gait
from pawnb.gait.events.event_edits import (
    AddEvent,
    DeleteEvent,
    EventEdits,
    ExcludeStride,
    MoveEvent,
    replay_event_edits,
)

WHO = {"animal": "m1", "trial": "t1"}


def analyse(*, shift_s=0.0, wrong=(), without=()):
    """An analysis; ``wrong`` events of R1 are found as well, those ``without`` are not."""
    rows = [
        {**WHO, "leg": leg, "event": event, "time_s": lag + 0.2 * k + after + shift_s}
        for leg, lag in (("L1", 0.1), ("R1", 0.0))
        for k in range(7)
        for event, after in (("AEP", 0.0), ("PEP", 0.12))
        if (leg, event, k) not in without
    ]
    rows += [{**WHO, "leg": "R1", "event": event, "time_s": at + shift_s} for event, at in wrong]
    events = pd.DataFrame(rows).sort_values(["leg", "time_s"], ignore_index=True)
    return gait.analyse_events(events.assign(frame=100 * events["time_s"]))


def strides_of(tables, leg="R1"):
    return tables.strides[tables.strides["leg"] == leg].reset_index(drop=True)


WRONG = (("AEP", 0.43), ("PEP", 0.49))


def edits(tmp_path, tables, *made):
    log = EventEdits(tables, tmp_path / "event_edits.jsonl")
    for one in made:
        log.apply(one)
    return tmp_path / "event_edits.jsonl"


def delete(event, time_s):
    return DeleteEvent(**WHO, leg="R1", event=event, time_s=time_s)


def test_what_was_deleted_and_is_no_longer_found_takes_no_other_along(tmp_path):
    made = [delete(*one) for one in WRONG]
    path = edits(tmp_path, analyse(wrong=WRONG), *made)
    again = replay_event_edits(analyse(), path)
    strides = strides_of(again)
    assert strides["period_s"].to_numpy() == pytest.approx(np.full(6, 0.2))
    assert strides["duty_factor"].to_numpy() == pytest.approx(np.full(6, 0.6))
    assert any("left out, as they do not fit the events any more: 2" in n for n in again.notes)


def test_what_was_deleted_is_deleted_where_both_are_found_again(tmp_path):
    made = [delete(*one) for one in WRONG]
    path = edits(tmp_path, analyse(wrong=WRONG), *made)
    again = replay_event_edits(analyse(wrong=WRONG, shift_s=0.01), path)
    assert strides_of(again)["duty_factor"].to_numpy() == pytest.approx(np.full(6, 0.6))
    assert any("in force: 2 (2 events deleted)" in note for note in again.notes)


def test_a_stride_that_is_gone_excludes_no_other(tmp_path):
    wrong = (("AEP", 0.43), ("PEP", 0.41))
    short = ExcludeStride(**WHO, leg="R1", start_s=0.43, reason="no step")
    path = edits(tmp_path, analyse(wrong=wrong), short)
    again = replay_event_edits(analyse(), path)
    assert strides_of(again)["start_s"].to_numpy() == pytest.approx(0.2 * np.arange(6))
    assert any("of the stride of R1 at 0.430 s" in note for note in again.notes)


def test_a_moved_event_that_is_gone_moves_no_other(tmp_path):
    moved = MoveEvent(**WHO, leg="R1", event="AEP", time_s=0.43, to_s=0.47)
    path = edits(tmp_path, analyse(wrong=WRONG), moved)
    again = replay_event_edits(analyse(), path)
    assert strides_of(again)["period_s"].to_numpy() == pytest.approx(np.full(6, 0.2))


def test_what_was_added_and_is_found_by_now_is_there_once(tmp_path):
    added = AddEvent(**WHO, leg="R1", event="AEP", time_s=0.4)
    path = edits(tmp_path, analyse(without=[("R1", "AEP", 2)]), added)
    again = replay_event_edits(analyse(shift_s=0.01), path)
    strides = strides_of(again)
    # the others 0.01 s later, this one where the person saw it
    assert strides["start_s"].to_numpy() == pytest.approx([0.01, 0.21, 0.4, 0.61, 0.81, 1.01])
    assert again.dropped.empty
    assert any("in force: 1 (1 event added)" in note for note in again.notes)
    event = again.events[(again.events["leg"] == "R1") & (again.events["time_s"] == 0.4)]
    assert event["method"].tolist() == ["hand"]


def test_an_event_added_close_to_another_stays_beside_it(tmp_path):
    # the same events, read again: nothing may be taken for the one that was added
    made = [AddEvent(**WHO, leg="R1", event=event, time_s=at) for event, at in WRONG[::-1]]
    path = edits(tmp_path, analyse(), *made)
    again = replay_event_edits(analyse(), path)
    times = again.events.query("leg == 'R1' and event == 'AEP'")["time_s"].to_numpy()
    assert times == pytest.approx([0.0, 0.2, 0.4, 0.43, 0.6, 0.8, 1.0, 1.2])


@pytest.mark.slow
def test_times_beside_go_with_the_frame_rate(tmp_path):
    # 200 frames a second that were said to be 100: the same frames are at half the times
    path = edits(tmp_path, analyse(wrong=WRONG), *[delete(*one) for one in WRONG])
    events = analyse().events
    mended = gait.analyse_events(events.assign(time_s=events["time_s"] / 2))
    again = replay_event_edits(mended, path)
    assert strides_of(again)["period_s"].to_numpy() == pytest.approx(np.full(6, 0.1))


def test_a_file_of_before_is_read(tmp_path):
    path = edits(tmp_path, analyse(wrong=WRONG), delete("AEP", 0.43), delete("PEP", 0.49))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert [line.pop("beside_s") for line in lines] == pytest.approx([0.4, 0.52])
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    again = replay_event_edits(analyse(wrong=WRONG), path)
    assert strides_of(again)["duty_factor"].to_numpy() == pytest.approx(np.full(6, 0.6))


def test_of_recordings_without_names_none_takes_the_corrections_of_another(tmp_path):
    """Both were 'individual_0, trial': events of one were deleted in the other without a word."""

    def unnamed(shift_s):
        events = analyse(shift_s=shift_s).events
        return gait.analyse_events(events[["leg", "event", "frame", "time_s"]])

    one, other = unnamed(0.0), unnamed(0.0137)
    own = {"animal": "animal", "trial": "trial", "leg": "R1"}
    path = edits(
        tmp_path, one, DeleteEvent(**own, event="AEP", time_s=0.4),
        MoveEvent(**own, event="PEP", time_s=0.72, to_s=0.73),
        AddEvent(**own, event="AEP", time_s=0.41),
        ExcludeStride(**own, start_s=0.8, reason="slips"),
    )  # fmt: skip
    again = EventEdits(one, path)
    assert not again.left_out
    assert not again.notes
    assert len(again.tables.strides) == len(one.strides) - 1
    log = EventEdits(other, path)
    assert len(log.left_out) == 4
    assert log.tables.events.equals(other.events)
    assert "this recording has no name" in log.notes[0]
    replayed = replay_event_edits(other, path)
    assert replayed.events.equals(other.events)
    assert any("this recording has no name" in note for note in replayed.notes)
    assert any("left out, as they do not fit" in note for note in replayed.notes)
