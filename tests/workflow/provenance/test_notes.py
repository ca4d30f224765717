"""Notes and warnings of a run: collected, shown as ever, and written beside the tables."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputWarning, ResumptionWarning
from pawnb.gait.analysis.notes import Note
from pawnb.input_warnings import warn_of_input
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.provenance.notes import (
    NOTES_COLUMNS,
    noted_warnings,
    notes_table,
    without_folders,
)
from pawnb.workflow.tracking.track import track


def test_a_note_reads_where_and_what():
    note = Note("no stride.", where="t1")
    assert note == "t1: no stride."
    assert (note.where, note.what, note.rows) == ("t1", "no stride.", "")
    again = Note(note, where="elsewhere")  # what it says already stays
    assert again == note
    assert Note("all of them.") == "all of them."


def test_the_table_says_which_rows():
    legs = pd.DataFrame({"leg": list("abcde"), "note": ["one", "one", "", "one", np.nan]})
    table = notes_table(["plain", Note("told", where="t1"), "plain"], {"legs.csv": legs})
    assert tuple(table.columns) == NOTES_COLUMNS
    assert table.to_numpy().tolist() == [
        ["", "plain", ""],
        ["t1", "told", ""],
        ["legs.csv", "one", "1-2, 4"],
    ]


def test_of_very_many_rows_the_first_are_named():
    own = ["", "few", "few"] * 10  # as of three groups of which one is small
    table = notes_table([], {"groups.csv": pd.DataFrame({"note": own})})
    assert table["rows"].tolist() == ["2-3, 5-6, 8-9, 11-12, 14-15, 17-18, 20-21, 23-24 and 4 more"]


def test_warnings_are_collected_and_shown():
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        with noted_warnings() as said:
            for _ in range(2):
                warn_of_input("/data/m07/cam1.avi: cut short")
            warn_of_input("going on", ResumptionWarning)
    assert said == ["cam1.avi: cut short"]
    assert [str(w.message) for w in shown] == ["/data/m07/cam1.avi: cut short"] * 2 + ["going on"]


def test_what_another_thread_does_with_warnings_takes_no_note_away():
    """pandas saves and restores the filters of the process on every thread."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        meanwhile = warnings.catch_warnings()
        meanwhile.__enter__()
        with noted_warnings() as said:
            meanwhile.__exit__(None, None, None)
            warn_of_input("cut short")
    assert said == ["cut short"]


def test_warnings_turned_into_errors_stay_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        with noted_warnings(), pytest.raises(InputWarning):
            warn_of_input("cut short")


@pytest.mark.parametrize(
    ("said", "kept"),
    [
        ("/a/b/cam1.avi: 3 frames", "cam1.avi: 3 frames"),
        (r"C:\lab\cam1.avi, /x/y.toml", "cam1.avi, y.toml"),
        ("m07/tracks.nc at 3 mm/s, 1/2", "m07/tracks.nc at 3 mm/s, 1/2"),
    ],
)
def test_folders_of_a_machine_are_cut(said, kept):
    assert without_folders(said) == kept


@pytest.mark.slow
def test_notes_of_a_gait_run_are_written(tmp_path):
    # three animals of five strides; one has a single leg, so no pairs
    for name, legs in (("a", "LR"), ("b", "LR"), ("c", "L")):
        rows = [
            (leg, event, 0.2 * k + late + 0.1 * (leg == "R") + 0.01 * k * (name == "b"))
            for leg in legs
            for k in range(6)
            for event, late in (("TD", 0.0), ("LO", 0.12))
        ]
        pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(tmp_path / f"{name}.csv")
    run = run_gait([tmp_path / f"{n}.csv" for n in "abc"], figures="none", out=tmp_path / "out")
    notes = pd.read_csv(tmp_path / "out" / "notes.csv", keep_default_na=False)
    assert tmp_path / "out" / "notes.csv" in run.files
    told = set(notes[["where", "what"]].itertuples(index=False, name=None))
    assert ("c", "no pair of legs by name; name them with pairs for phases.") in told
    # single quotes outside are letters to the shells of Windows, and double ones inside are lost
    how = (
        """(--set "pairs=[['L','R']]"), or call them as a left and a right one with legs (--legs"""
    )
    assert any(where == "a" and how in what for where, what in told)
    assert any(where == "" and "each counts as one of its own" in what for where, what in told)
    # what stands in the rows of a table is there with its rows
    summary = pd.read_csv(tmp_path / "out" / "animals.csv", keep_default_na=False)
    of_table = notes[notes["where"] == "animals.csv"]
    assert len(of_table) == summary.loc[summary["note"] != "", "note"].nunique()
    for line in run.text().splitlines():
        if line.startswith("note: "):
            words = line.removeprefix("note: ")
            assert any(words == (f"{w}: {t}" if w else t) for w, t in told), words


@pytest.mark.slow
def test_what_tracking_warns_of_stands_beside_its_results_and_those_of_gait(small_trial):
    toml = small_trial / "trial.toml"
    start = small_trial / "start.csv"
    clicks = pd.read_csv(start)
    clicks.assign(frame=clicks["frame"] + 3).to_csv(start, index=False)
    assert "start.csv" in toml.read_text()
    with pytest.warns(InputWarning, match="frames 0 to .* lie before the first click"):
        track(small_trial, method="slic-3d", frames=(0, 12), out=small_trial / "results")
    notes = pd.read_csv(small_trial / "results" / "notes.csv")
    row = notes[notes["what"].str.contains("lie before the first click")].iloc[0]
    assert row["where"].startswith("track ")
    run_gait([small_trial / "results"], figures="none")
    again = pd.read_csv(small_trial / "results" / "notes.csv")
    assert row["what"] in set(again["what"])
