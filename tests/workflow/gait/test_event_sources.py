"""Contact and events scored by hand: as files, in trials, in groups."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.gait.event_sources import (
    choose_event_legs,
    groups_of_events,
    read_scored_file,
)
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.sources import read_source

TRIAL = """[trial]
kind = "tracks"
name = "t1"
fps = 100.0
[animal]
id = "fly1"
group = "blind"
[tracks]
file = "hand.csv"
"""


def contact_rows(*, period=10, frames=100):
    """Two legs half a stride apart; six of ten frames on the ground: duty factor 0.6."""
    down = [int(i % period < 0.6 * period) for i in range(2 * period)]
    return [(i, down[i % period], down[(i + period // 2) % period]) for i in range(frames)]


def write_contacts(path, **how):
    pd.DataFrame(contact_rows(**how), columns=["frame", "LF", "RF"]).to_csv(path, index=False)
    return path


def test_a_trial_may_name_contact_scored_by_hand(tmp_path):
    (tmp_path / "trial.toml").write_text(TRIAL)
    write_contacts(tmp_path / "hand.csv")
    # LF changes after frames 6, 10, 16, ... 96, RF after 1, 5, 11, ... 95: 19 and 20 times
    assert "events in hand.csv: 39, of legs LF, RF" in check_trial(tmp_path).text()
    run = run_gait([tmp_path], figures="none")
    strides = run.tables.strides
    assert set(strides["animal"]) == {"fly1"}
    assert set(strides["trial"]) == {"t1"}
    np.testing.assert_allclose(strides["period_s"], 0.1)
    np.testing.assert_allclose(strides["duty_factor"], 0.6)


def test_frames_and_legs_of_the_trial_hold_for_events(tmp_path):
    # 10 strides a leg in 100 frames; frames 0 to 49 hold the first five
    text = TRIAL.replace("fps = 100.0", "fps = 100.0\nframes = [0, 50]")
    (tmp_path / "trial.toml").write_text(text + 'legs = { L1 = "LF" }\n')
    write_contacts(tmp_path / "hand.csv")
    run = run_gait([tmp_path], figures="none")
    assert set(run.tables.strides["leg"]) == {"L1"}
    assert run.tables.events["time_s"].max() < 0.5
    (tmp_path / "trial.toml").write_text(text.replace("[0, 50]", "[500, 900]"))
    with pytest.raises(InputError, match=r"no event in frames 500 to 899 of trial 't1'"):
        run_gait([tmp_path], figures="none")


def test_a_trial_refuses_events_of_another_animal(tmp_path):
    (tmp_path / "trial.toml").write_text(TRIAL)
    table = pd.DataFrame(contact_rows(), columns=["frame", "LF", "RF"]).assign(animal="fly2")
    table.to_csv(tmp_path / "hand.csv", index=False)
    with pytest.raises(InputError, match=r"animal 'fly2', where trial 't1' is of animal 'fly1'"):
        run_gait([tmp_path], figures="none")


def study(folder, *, column):
    """Six animals, a slow group (12 frames a stride) and a fast one (8), by hand."""
    parts, paths = [], []
    for i in range(6):
        period = 12 if i < 3 else 8
        own = pd.DataFrame(
            contact_rows(period=period + 2 * (i % 3 == 2), frames=120),
            columns=["frame", "LF", "RF"],
        )
        paths.append(folder / f"a{i}.csv")
        own.to_csv(paths[-1], index=False)
        parts.append(own.assign(animal=f"a{i}", group="slow" if i < 3 else "fast"))
    if not column:
        return paths
    pd.concat(parts).to_csv(folder / "all.csv", index=False)
    return [folder / "all.csv"]


@pytest.mark.slow
@pytest.mark.parametrize("column", [True, False], ids=["a column group", "--groups"])
def test_groups_of_animals_scored_by_hand_compare_in_one_command(tmp_path, column):
    paths = study(tmp_path, column=column)
    groups = None if column else ["slow"] * 3 + ["fast"] * 3
    out = tmp_path / "out"
    run = run_gait(paths, fps=100.0, groups=groups, figures="none", out=out)
    assert run.tables.strides["animal"].nunique() == 6
    table = pd.read_csv(out / "groups.csv")
    row = table[(table["measure"] == "period_s") & table["group_a"].eq("slow")].iloc[0]
    assert (row["n_animals_a"], row["n_animals_b"]) == (3, 3)
    # periods 0.12, 0.12, 0.14 s against 0.08, 0.08, 0.10 s
    assert row["difference"] == pytest.approx(-0.04, abs=1e-9)
    assert set(pd.read_csv(out / "strides.csv")["group"]) == {"slow", "fast"}
    # its own events.csv says the groups again
    run_gait([out / "events.csv"], figures="none", out=tmp_path / "again")
    again = pd.read_csv(tmp_path / "again" / "groups.csv")
    pd.testing.assert_frame_equal(again, table)


def test_groups_are_one_for_each_input(tmp_path):
    paths = study(tmp_path, column=False)
    with pytest.raises(InputError, match=r"^groups: 2 for 6 inputs; give the group of each"):
        run_gait(paths, fps=100.0, groups=["slow", "fast"], figures="none", out=tmp_path / "out")


def test_a_trial_is_in_one_group():
    events = pd.DataFrame({"animal": ["a", "a"], "trial": ["t", "t"], "group": ["wild", "mutant"]})
    with pytest.raises(InputError, match="trial 't' of animal 'a' is in group 'mutant' and in ano"):
        groups_of_events(events, where="events.csv")


def test_an_events_table_of_ours_is_read_again(tmp_path):
    # an events.csv of tracks has a column position, empty where a foot touches down
    rows = []
    for k in range(5):
        for event, late, position in (("AEP", 0.0, 4.0), ("TD", 0.01, ""), ("PEP", 0.12, -4.0),
                                      ("LO", 0.13, "")):  # fmt: skip
            rows.append(("m1", "t1", "FR", event, "", 0.2 * k + late, "foot position", position))
    names = ["animal", "trial", "leg", "event", "frame", "time_s", "method", "position"]
    path = tmp_path / "events.csv"
    pd.DataFrame(rows, columns=names).to_csv(path, index=False)
    strides = run_gait([path], figures="none", out=tmp_path / "out").tables.strides
    np.testing.assert_allclose(strides["period_s"], 0.2)
    np.testing.assert_allclose(strides["duty_factor"], 0.6)
    np.testing.assert_allclose(strides["aep_position"], 4.0)


def test_events_without_an_animal_are_called_as_their_file(tmp_path):
    for name in ("a", "b"):
        rows = [("L", e, 0.2 * k + t) for k in range(4) for e, t in (("TD", 0.0), ("LO", 0.1))]
        pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(tmp_path / f"{name}.csv")
    run = run_gait([tmp_path / "a.csv", tmp_path / "b.csv"], figures="none", out=tmp_path / "o")
    assert set(run.tables.strides["animal"]) == {"a", "b"}
    assert any("each counts as one of its own: a, b." in note for note in run.tables.notes)


def test_an_empty_name_and_frames_out_of_order_are_refused(tmp_path):
    path = tmp_path / "hand.csv"
    path.write_text("frame,animal,LF\n0,a,1\n1,,0\n")
    with pytest.raises(InputError, match=r"line 3, column 'animal' is empty"):
        read_scored_file(path, fps=100.0)
    path.write_text("frame,LF\n0,1\n2,0\n1,1\n")
    with pytest.raises(InputError, match=r"frame 1 follows frame 2; expected each frame once"):
        read_scored_file(path, fps=100.0)


@pytest.mark.slow
def test_a_folder_of_an_analysis_is_not_taken_for_events_scored_by_hand(tmp_path, monkeypatch):
    """Its events know no filter and no drops: what it was made from is named, as one types it."""
    paths = study(tmp_path, column=False)[:1]
    out = tmp_path / "out"
    run_gait(paths, fps=100.0, figures="none", out=out, command=["pawnb", "gait", "x.csv"])
    for here, made_from in ((tmp_path, paths[0].name), (tmp_path.parent, None), (out, paths[0])):
        monkeypatch.chdir(here)
        made_from = made_from or f"{tmp_path.name}/{paths[0].name}"
        said = rf"results of an analysis \(pawnb gait x\.csv\) .* name {made_from} instead"
        with pytest.raises(InputError, match=said):
            read_source(out)
    (out / "provenance.json").unlink()  # as while a run writes there, or in a copy without it
    with pytest.raises(InputError, match="name the trial, the study or the tracks instead"):
        read_source(out)
    assert read_source(out / "events.csv").events is not None


def test_a_folder_with_an_events_table_of_a_person_is_read(tmp_path):
    (tmp_path / "events.csv").write_text("leg,event,time_s\nFR,TD,0.1\nFR,LO,0.2\n")
    assert len(read_source(tmp_path).events) == 2


def test_two_legs_cannot_be_one_of_the_table():
    """One of them was lost without a word."""
    events = pd.DataFrame({"leg": ["LF", "RF"], "event": "TD", "time_s": [0.1, 0.2]})
    with pytest.raises(InputError, match=r"^e\.csv: FR and FL are both 'LF'; give each leg"):
        choose_event_legs(events, {"FR": "LF", "FL": "LF"}, where="e.csv")
    chosen = choose_event_legs(events, {"FR": "RF", "FL": "LF"}, where="e.csv")
    assert chosen["leg"].tolist() == ["FL", "FR"]


def test_rows_that_a_spreadsheet_leaves_empty_below_events_are_none(tmp_path):
    path = tmp_path / "scored.csv"
    path.write_text("leg,event,time_s\nFR,TD,0.1\nFR,LO,0.2\nFR,TD,0.3\n,,\n,,\n")
    assert len(read_scored_file(path, fps=None)) == 3
