"""Corrections of events: what follows from them, and that nothing entered is lost."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from pandas.testing import assert_frame_equal

from pawnb import gait
from pawnb.errors import InputError
from pawnb.gait.analysis.stride_support import SUPPORT_MEASURES
from pawnb.gait.events.event_edits import (
    AddEvent,
    DeleteEvent,
    EventEdits,
    ExcludeStride,
    MoveEvent,
    apply_event_edits,
    replay_event_edits,
)
from pawnb.synthetic.spider_study import simulate_spider_study

WHO = {"animal": "m1", "trial": "t1"}
TABLES = ("events", "strides", "phases", "phase_summary", "dropped")


@pytest.fixture
def tables():
    """Two legs, six strides of 0.2 s, stance 0.12 s; L1 is half a stride after R1; 100 Hz."""
    rows = [
        {**WHO, "leg": leg, "event": event, "time_s": lag + 0.2 * k + after}
        for leg, lag in (("L1", 0.1), ("R1", 0.0))
        for k in range(7)
        for event, after in (("AEP", 0.0), ("PEP", 0.12))
    ]
    events = pd.DataFrame(rows).assign(frame=lambda t: 100 * t["time_s"])
    return gait.analyse_events(events)


@pytest.fixture(scope="module")
def tracked():
    """An analysis of tracks, with motion and signals."""
    run = simulate_spider_study(animals=1, trials=1, seed=3).runs[0]
    return gait.analyse(run.tracks(noise_px=0.2), trial=run.trial)


def move(to_s, *, time_s=0.4, leg="R1", event="AEP"):
    return MoveEvent(**WHO, leg=leg, event=event, time_s=time_s, to_s=to_s)


def strides_of(tables, leg):
    return tables.strides[tables.strides["leg"] == leg].reset_index(drop=True)


def same(a, b):
    for name in TABLES:
        assert_frame_equal(getattr(a, name), getattr(b, name))


def test_a_moved_event_changes_its_strides_and_phases(tables):
    out = apply_event_edits(tables, [move(0.42)])
    np.testing.assert_allclose(strides_of(out, "R1")["period_s"], [0.2, 0.22, 0.18, 0.2, 0.2, 0.2])
    np.testing.assert_allclose(strides_of(out, "R1")["stance_s"][2], 0.10)
    np.testing.assert_allclose(strides_of(out, "L1")["period_s"], 0.2)
    # L1 lands 0.1 s after 0.2 in a stride of 0.22 s, and 0.08 s after 0.42 in one of 0.18 s
    phases = out.phases[out.phases["leg"] == "L1"]["phase"].to_numpy()
    np.testing.assert_allclose(phases[1:3], [0.1 / 0.22, 0.08 / 0.18])
    moved = out.events[out.events["method"] == "hand"]
    assert len(moved) == 1
    assert moved["frame"].iloc[0] == pytest.approx(42.0)
    # what was found is as it was
    assert "hand" not in set(tables.events["method"])


def test_a_deleted_event_takes_its_strides_along(tables):
    gone = DeleteEvent(**WHO, leg="R1", event="PEP", time_s=0.52)
    out = apply_event_edits(tables, [gone])
    assert len(strides_of(out, "R1")) == 5
    assert "no PEP between two AEP; expected one" in set(out.dropped["why"])
    assert len(out.events) == len(tables.events) - 1


def test_an_event_that_was_deleted_and_added_again_is_where_it_was(tables, tmp_path):
    edits = EventEdits(tables, tmp_path / "event_edits.jsonl")
    edits.apply(DeleteEvent(**WHO, leg="R1", event="PEP", time_s=0.52))
    edits.apply(AddEvent(**WHO, leg="R1", event="PEP", time_s=0.53))
    new = edits.tables.events[edits.tables.events["method"] == "hand"]
    assert new[["leg", "event", "time_s", "frame"]].to_numpy().tolist() == [
        ["R1", "PEP", 0.53, pytest.approx(53.0)]
    ]
    own = edits.tables.events[edits.tables.events["leg"] == "R1"]["time_s"].to_numpy()
    assert (np.diff(own) > 0).all()
    stance = strides_of(edits.tables, "R1")["stance_s"]
    np.testing.assert_allclose(stance, [0.12, 0.12, 0.13, 0.12, 0.12, 0.12])
    same(replay_event_edits(tables, tmp_path / "event_edits.jsonl"), edits.tables)
    edits.undo()
    assert len(strides_of(edits.tables, "R1")) == 5
    for event, time_s, why in (
        ("AEP", 0.4, "already"),
        ("AEP", 9.0, "0.0000 to"),
        ("TD", 0.3, "no"),
    ):
        with pytest.raises(InputError, match=why):
            edits.apply(AddEvent(**WHO, leg="R1", event=event, time_s=time_s))


def test_an_excluded_stride_is_dropped_with_its_reason(tables):
    edit = ExcludeStride(**WHO, leg="R1", start_s=0.6, reason="stumbled")
    out = apply_event_edits(tables, [edit])
    assert not np.isclose(strides_of(out, "R1")["start_s"], 0.6).any()
    assert len(strides_of(out, "R1")) == 5
    row = out.dropped[out.dropped["why"] == "excluded by hand: stumbled"].iloc[0]
    assert (row["leg"], row["what"]) == ("R1", "stride")
    assert row["start_s"] == pytest.approx(0.6)
    # phases within it are gone, its events are not
    assert len(out.phases) == len(tables.phases) - 1
    assert len(out.events) == len(tables.events)


def test_a_stride_stays_excluded_when_its_ends_move(tables):
    edits = [ExcludeStride(**WHO, leg="R1", start_s=0.4, reason="x"), move(0.41)]
    out = apply_event_edits(tables, edits)
    assert not np.isclose(strides_of(out, "R1")["start_s"], 0.41).any()


def test_lengths_speeds_and_angles_are_made_again(tracked):
    """A stride whose end moves is as much longer as the body ran in that time."""
    own = tracked.strides[tracked.strides["leg"] == "L3"].iloc[1]
    who = {"animal": own["animal"], "trial": own["trial"], "leg": "L3"}
    end = own["start_s"] + own["period_s"]
    out = apply_event_edits(tracked, [MoveEvent(**who, event="AEP", time_s=end, to_s=end + 0.01)])
    new = out.strides[out.strides["leg"] == "L3"].iloc[1]
    more = new["stride_length"] - own["stride_length"]
    assert more == pytest.approx(0.01 * own["speed"], rel=0.3)
    assert new["excursion_deg"] != own["excursion_deg"]
    others = out.strides[out.strides["leg"] == "R2"].reset_index(drop=True)
    before = tracked.strides[tracked.strides["leg"] == "R2"].reset_index(drop=True)
    # support is of all feet together; everything else is a leg's own
    own_measures = [name for name in before if name not in SUPPORT_MEASURES]
    assert_frame_equal(others[own_measures], before[own_measures])
    event = out.events[out.events["method"] == "hand"].iloc[0]
    assert np.isfinite(event["position"])
    assert event["frame"] == pytest.approx(125.0 * (end + 0.01))
    assert out.notes == tracked.notes


def test_no_edits_rebuilt_are_the_same_tables(tracked):
    """Moving an event to where it stands makes everything again, and changes its method only."""
    own = tracked.events[tracked.events["event"] == "AEP"].iloc[3]
    who = {name: own[name] for name in ("animal", "trial", "leg", "event")}
    out = apply_event_edits(tracked, [MoveEvent(**who, time_s=own["time_s"], to_s=own["time_s"])])
    for name in ("strides", "phases", "phase_summary", "dropped"):
        assert_frame_equal(getattr(out, name), getattr(tracked, name))
    assert len(out.signals) == len(tracked.signals)


def test_other_trials_are_left_alone(tables):
    other = gait.analyse_events(tables.events.assign(trial="t2"))
    both = gait.pool([tables, other])
    out = apply_event_edits(both, [move(0.42)])
    second = out.strides[out.strides["trial"] == "t2"]["period_s"]
    np.testing.assert_allclose(second, 0.2)
    assert out.phase_summary["n"].sum() == both.phase_summary["n"].sum()


@pytest.mark.slow
def test_only_corrected_trials_are_made_again_and_the_rest_is_the_same(tracked):
    """All trials made again by build_tables, and only the one corrected, give the same tables."""
    run = simulate_spider_study(animals=1, trials=1, seed=4).runs[0]
    other = gait.analyse(run.tracks(noise_px=0.2), trial=replace(run.trial, name="second"))
    both = gait.pool([tracked, other])
    own = other.strides.iloc[4]
    edit = ExcludeStride(animal=own["animal"], trial="second", leg=own["leg"],
                         start_s=own["start_s"], reason="x")  # fmt: skip
    out = apply_event_edits(both, [edit])
    same(out, gait.pool([tracked, apply_event_edits(other, [edit])]))
    assert len(out.strides) == len(both.strides) - 1
    assert len(out.signals) == len(both.signals)


def test_corrections_are_made_in_what_was_found_not_twice(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    log = EventEdits(tables, path)
    log.apply(move(0.42))
    once = replay_event_edits(tables, path)
    same(replay_event_edits(once, path), once)
    assert replay_event_edits(once, path).notes == once.notes
    # opened on corrected tables, pooled with others, they can still be undone
    other = gait.analyse_events(tables.events.assign(trial="t2"))
    again = EventEdits(gait.pool([once, other]), path)
    assert len(again.active) == 1
    same(again.undo(), gait.pool([tables, other]))


@pytest.mark.slow
def test_corrections_of_other_trials_and_legs_are_left_out_and_said(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    both = gait.pool([tables, gait.analyse_events(tables.events.assign(trial="t2"))])
    log = EventEdits(both, path)
    log.apply(move(0.42))
    log.apply(replace(move(0.38), trial="t2"))
    out = replay_event_edits(tables, path)
    same(out, apply_event_edits(tables, [move(0.42)]))
    assert out.notes[-2:] == (
        "event_edits.jsonl: corrections by hand in force: 1 (1 event moved).",
        "event_edits.jsonl: corrections left out, as their trial or leg is not in this analysis: "
        "1 (the first is of R1 of m1, t2). Where an animal, a trial or a leg was renamed since, "
        "its name is changed in that file, too, by pawnb.gait.rename_event_edits.",
    )
    assert replay_event_edits(tables, tmp_path / "none.jsonl").notes == tables.notes
    # one file for each trial: both count
    second = tmp_path / "second.jsonl"
    EventEdits(both, second).apply(ExcludeStride(**WHO, leg="L1", start_s=0.3, reason="x"))
    twice = replay_event_edits(tables, [path, second])
    assert len(twice.strides) == len(tables.strides) - 1
    assert np.isclose(strides_of(twice, "R1")["start_s"], 0.42).any()


@pytest.mark.slow
def test_events_found_anew_keep_their_corrections(tables, tmp_path):
    """Tracks that are corrected elsewhere move every event a little."""
    path = tmp_path / "event_edits.jsonl"
    log = EventEdits(tables, path)
    log.apply(move(0.42))
    log.apply(ExcludeStride(**WHO, leg="R1", start_s=0.8, reason="x"))
    log.apply(DeleteEvent(**WHO, leg="L1", event="PEP", time_s=0.22))
    shifted = tables.events.assign(time_s=tables.events["time_s"] + 0.003)
    again = replay_event_edits(gait.analyse_events(shifted), path)
    assert np.isclose(strides_of(again, "R1")["start_s"], 0.42).any()
    assert not np.isclose(strides_of(again, "R1")["start_s"], 0.803).any()
    assert len(again.events) == len(tables.events) - 1
    assert any("in force: 3" in note for note in again.notes)
    assert not any("left out" in note for note in again.notes)


def test_notes_of_before_the_corrections_are_marked(tables, tmp_path):
    """Beside corrected tables they read as if they were of these."""
    path = tmp_path / "event_edits.jsonl"
    noted = replace(tables, notes=("strides of one leg differ",))
    marked = "are of the events as they were found, before the corrections by hand"
    assert not any(marked in note for note in replay_event_edits(noted, path).notes)
    log = EventEdits(noted, path)
    log.apply(move(0.42))
    out = replay_event_edits(noted, path)
    assert sum(marked in note for note in out.notes) == 1
    log.undo()
    assert replay_event_edits(noted, path).notes == noted.notes


@pytest.mark.slow
def test_what_fits_no_event_any_more_is_left_out_and_said(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    log = EventEdits(tables, path)
    log.apply(move(0.42))
    log.apply(ExcludeStride(**WHO, leg="R1", start_s=0.8, reason="x"))
    before = path.read_text()
    events = tables.events
    gone = (events["leg"] == "R1") & (events["event"] == "AEP") & (events["time_s"] < 0.5)
    other = gait.analyse_events(events[~gone])
    again = replay_event_edits(other, path)
    assert not np.isclose(strides_of(again, "R1")["start_s"], 0.42).any()
    assert "event_edits.jsonl: corrections by hand in force: 1 (1 stride excluded)." in again.notes
    (said,) = (note for note in again.notes if "left out" in note)
    assert "1 (the first is of the AEP of R1 at 0.400 s); look at them" in said
    opened = EventEdits(other, path)
    assert [edit.to_s for edit in opened.left_out] == [0.42]
    same(opened.tables, again)
    assert path.read_text() == before
    # what is done now must fit, and takes nothing else away
    with pytest.raises(InputError, match=r"R1 has no AEP at 0\.4000 s"):
        opened.apply(move(0.42))
    opened.undo()
    opened.undo()
    assert not opened.left_out


@pytest.mark.slow
def test_undo_redo_and_replay(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    log = EventEdits(tables, path)
    assert not path.exists()
    log.apply(move(0.42))
    one = log.tables
    log.apply(ExcludeStride(**WHO, leg="L1", start_s=0.3, reason="edge"))
    two = log.tables
    assert len(path.read_text().splitlines()) == 2
    same(log.undo(), one)
    same(log.redo(), two)
    log.undo()
    log.undo()
    same(log.tables, tables)
    assert not log.can_undo
    assert log.can_redo
    same(replay_event_edits(tables, path), tables)
    log.redo()
    same(replay_event_edits(tables, path), one)
    # a new correction ends what could be redone
    log.apply(move(0.38, time_s=0.42))
    assert not log.can_redo
    again = EventEdits(tables, path)
    same(again.tables, log.tables)
    assert again.active == log.active
    kinds = [json.loads(line)["edit"] for line in path.read_text().splitlines()]
    assert kinds == ["move", "exclude", "undo", "redo", "undo", "undo", "redo", "move"]
    with pytest.raises(InputError, match="no correction to make again"):
        log.redo()


def test_a_half_written_line_is_left_out_and_kept(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    EventEdits(tables, path).apply(move(0.42))
    with path.open("a") as file:
        file.write('{"edit": "mo')
    log = EventEdits(tables, path)
    assert len(log.active) == 1
    assert "half written" in log.notes[0]
    log.apply(move(0.41, time_s=0.42))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines[1] == {"edit": "unfinished", "text": '{"edit": "mo'}
    assert len(EventEdits(tables, path).active) == 2


def test_another_window_is_noticed(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    first, second = EventEdits(tables, path), EventEdits(tables, path)
    first.apply(move(0.42))
    with pytest.raises(InputError, match="changed by another window"):
        second.apply(move(0.43))
    same(second.tables, tables)
    assert len(path.read_text().splitlines()) == 1


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (move(0.55), "cannot go to 0.5500 s; expected a time between its neighbours, 0.3200"),
        (move(0.3), "cannot go to 0.3000"),
        (move(0.42, time_s=0.41), "R1 has no AEP at 0.4100 s"),
        (move(0.42, leg="L9"), "no events of leg 'L9'"),
        (ExcludeStride(**WHO, leg="R1", start_s=1.2, reason="x"), "no stride of R1 begins at 1.2"),
        (ExcludeStride(**WHO, leg="R1", start_s=0.4, reason=" "), "say why"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_and_not_written(tables, tmp_path, edit, message):
    path = tmp_path / "event_edits.jsonl"
    log = EventEdits(tables, path)
    with pytest.raises(InputError, match=message):
        log.apply(edit)
    same(log.tables, tables)
    assert not path.exists()


def test_a_stride_is_excluded_once(tables):
    edit = ExcludeStride(**WHO, leg="R1", start_s=0.4, reason="x")
    with pytest.raises(InputError, match="excluded already"):
        apply_event_edits(tables, [edit, edit])


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("move it", "line 1: not a JSON object"),
        ('{"edit": "moved"}', "unknown kind of edit 'moved' .did you mean 'move'"),
        ('{"edit": "delete", "leg": "R1"}', "a delete needs 'animal'"),
        ('{"edit": "exclude", "animal": "a", "trial": "t", "leg": "R1", "start_s": "0", '
         '"reason": "x"}',
         "start_s is '0'; expected a number"),
    ],
)  # fmt: skip
def test_a_line_that_cannot_be_read_is_told(tables, tmp_path, line, message):
    path = tmp_path / "event_edits.jsonl"
    path.write_text(line + "\n")
    with pytest.raises(InputError, match=message):
        EventEdits(tables, path)


@pytest.mark.slow
def test_corrections_stay_with_their_frames_where_the_frame_rate_is_mended(tables, tmp_path):
    """The recording had 125 frames a second, not 100: its frames are those they were."""
    path = tmp_path / "event_edits.jsonl"
    edits = EventEdits(tables, path)
    edits.apply(move(0.42))
    edits.apply(DeleteEvent(**WHO, leg="R1", event="PEP", time_s=0.92))
    edits.apply(AddEvent(**WHO, leg="L1", event="PEP", time_s=0.15))
    edits.apply(ExcludeStride(**WHO, leg="L1", start_s=0.7, reason="stumbled"))
    events = tables.events.assign(time_s=tables.events["time_s"] / 1.25)
    mended = gait.analyse_events(events[["animal", "trial", "leg", "event", "time_s", "frame"]])
    again = replay_event_edits(mended, path)
    was, now = edits.tables.events, again.events
    np.testing.assert_allclose(now["frame"], was["frame"])
    np.testing.assert_allclose(now["time_s"], was["time_s"] / 1.25)
    assert list(now["method"] == "hand") == list(was["method"] == "hand")
    assert len(again.strides) == len(edits.tables.strides)
    assert any("taken to the same frames: 4" in note for note in again.notes)
    reopened = EventEdits(mended, path)
    assert not reopened.left_out
    same(reopened.tables, again)


def test_a_file_of_before_without_frame_rates_is_read(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    EventEdits(tables, path).apply(move(0.42))
    line = json.loads(path.read_text())
    assert line.pop("fps") == pytest.approx(100.0)
    path.write_text(json.dumps(line) + "\n")
    again = replay_event_edits(tables, path)
    assert again.events["time_s"].isin([0.42]).sum() == 1


def test_events_without_frames_have_no_frame_rate(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    columns = ["animal", "trial", "leg", "event", "time_s"]
    EventEdits(gait.analyse_events(tables.events[columns]), path).apply(move(0.42))
    assert "fps" not in json.loads(path.read_text())


def test_a_renamed_animal_and_leg_keep_their_corrections_once_the_file_is_renamed(tables, tmp_path):
    """The same tables under other names have the same strides."""
    path = tmp_path / "event_edits.jsonl"
    made = EventEdits(tables, path)
    made.apply(move(0.42))
    made.apply(move(0.48, time_s=0.5, leg="L1"))
    corrected = made.undo()
    before = path.read_bytes() + b'{"edit": "mo'  # a crash left half a line
    path.write_bytes(before)
    legs = {"R1": "L1", "L1": "R1"}
    events = tables.events.assign(animal="mouse 1", leg=tables.events["leg"].map(legs))
    renamed = gait.analyse_events(events)
    (note,) = (n for n in replay_event_edits(renamed, path).notes if "left out, as their" in n)
    assert "pawnb.gait.rename_event_edits" in note
    assert gait.rename_event_edits(path, animals={"m1": "mouse 1"}, legs=legs) == 2
    again = replay_event_edits(renamed, path)
    assert not any("left out" in note for note in again.notes[-2:-1])
    for leg, other in legs.items():
        own, theirs = strides_of(corrected, leg), strides_of(again, other)
        np.testing.assert_allclose(theirs["start_s"], own["start_s"])
    with pytest.raises(InputError, match="no correction is of animal 'm1'; there are mouse 1"):
        gait.rename_event_edits(path, animals={"m1": "m2"})
    assert gait.rename_event_edits(path, animals={"mouse 1": "m1"}, legs=legs) == 2
    assert path.read_bytes() == before


def test_whoever_has_corrections_open_hears_of_a_renaming(tables, tmp_path):
    path = tmp_path / "event_edits.jsonl"
    made = EventEdits(tables, path)
    made.apply(move(0.42))
    gait.rename_event_edits(path, legs={"R1": "R2"})
    with pytest.raises(InputError, match="changed by another window"):
        made.apply(move(0.62, time_s=0.6))
    with pytest.raises(InputError, match="none"):
        gait.rename_event_edits(tmp_path / "none.jsonl", legs={"R1": "R2"})


def test_corrections_of_another_file_are_said_where_one_is_opened(tables, tmp_path):
    """Those of a trial by itself are not in the file of its study."""
    own, study = tmp_path / "own.jsonl", tmp_path / "study.jsonl"
    EventEdits(tables, own).apply(move(0.42))
    both = replay_event_edits(tables, [own, study])
    (said,) = EventEdits(both, study).notes
    assert "corrections that are not in" in said
    assert not EventEdits(both, own).notes
