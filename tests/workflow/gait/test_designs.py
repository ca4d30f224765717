"""Who is compared with whom: ids that groups share, partners that lack, conditions in groups."""

from __future__ import annotations

import unicodedata

import pandas as pd
import pytest
from trotting import walking_tracks

from pawnb.errors import InputError, InputWarning
from pawnb.io.native import write_tracks
from pawnb.workflow.gait.inputs import read_sources
from pawnb.workflow.gait.notes.group_notes import notes_on_fields, notes_on_groups
from pawnb.workflow.gait.notes.source_notes import notes_on_sources
from pawnb.workflow.gait.request import GaitRequest
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.sources import read_source

FPS = 100.0


def write_trial(path, *, period=20.0, stance=12.0, strides=6):
    """Two legs half a stride apart; durations in frames, all strides alike."""
    rows = []
    for leg, start in (("L1", 3.0), ("R1", 3.0 + period / 2.0)):
        for k in range(strides + 1):
            rows += [(leg, "TD", start + k * period), (leg, "LO", start + k * period + stance)]
    pd.DataFrame(rows, columns=["leg", "event", "frame"]).to_csv(path, index=False)


def analyse(folder, rows, **columns):
    """Return the notes, the methods paragraph and the comparison of the groups."""
    study = pd.DataFrame(rows).assign(**{"fps": FPS, **columns})
    study.to_csv(folder / "study.csv", index=False)
    run = run_gait(folder / "study.csv", figures="none")
    table = folder / "results" / "groups.csv"
    found = pd.read_csv(table) if table.exists() else pd.DataFrame()
    methods = (folder / "results" / "methods.txt").read_text()
    return [str(note) for note in run.tables.notes], methods, found


def write_study(folder, column, members, **own):
    """Write a trial of each animal of each group; stances differ from animal to animal."""
    rows = []
    for g, (group, animals) in enumerate(members.items()):
        for i, animal in enumerate(animals):
            file = f"{group}-{animal}.csv"
            write_trial(folder / file, stance=10.0 + i + 0.5 * g * (i + 1), **own)
            rows.append({"file": file, "animal": animal, column: group})
    return rows


@pytest.mark.slow
def test_numbers_that_groups_share_are_said_to_count_as_the_same_animals(tmp_path):
    rows = write_study(tmp_path, "group", {"wt": ["1", "2", "3"], "ko": ["1", "2", "3"]})
    notes, methods, found = analyse(tmp_path, rows)
    assert set(found["design"]) == {"paired"}
    (note,) = [note for note in notes if "count as the same animals" in note]
    assert note.startswith("1, 2, 3 count as the same animals in wt and ko: groups are compared")
    assert "Where these are different animals" in note
    assert "The design is paired (3 animals in both wt and ko)" in methods
    # under ids of their own they are six animals, and nothing is to be said
    apart = [{**row, "animal": f"{row['group']}{row['animal']}"} for row in rows]
    notes, methods, found = analyse(tmp_path, apart)
    assert set(found["design"]) == {"unpaired"}
    assert not [note for note in notes if "same animals" in note]
    assert "The design is unpaired;" in methods


@pytest.mark.slow
def test_a_trial_in_a_wrong_group_is_seen_in_the_notes(tmp_path):
    rows = write_study(tmp_path, "group", {"ctl": ["a", "b", "c"], "les": ["c", "d", "e"]})
    notes, _, _ = analyse(tmp_path, rows)
    (note,) = [note for note in notes if "count as the same animals" in note]
    assert note.startswith("c count as the same animals in ctl and les")
    assert "a, b, d, e, of one group only, left out" in note


@pytest.mark.slow
def test_strides_of_an_animal_without_partner_do_not_count(tmp_path):
    rows = write_study(tmp_path, "condition", {"before": ["a", "b", "c", "d"], "after": "abc"})
    notes, methods, found = analyse(tmp_path, rows)
    first = found[(found["measure"] == "stance_s") & (found["role"] == "measure")].iloc[0]
    # three animals, two legs, six strides of each: 36, where 48 are there before
    assert (first["n_animals_a"], first["n_a"], first["n_b"]) == (3, 36, 36)
    assert "no other condition is given for d: left out where conditions are compared." in notes
    (note,) = [note for note in notes if "together" in note]
    assert "and support_shares over all conditions of the animal. groups.csv has" in note
    assert not [note for note in notes if "same animals" in note]
    assert "The design is paired (3 animals in both before and after)" in methods


@pytest.mark.slow
def test_groups_that_share_no_animal_do_not_keep_others_from_being_compared(tmp_path):
    members = {"before": "abc", "after": "abc", "naive": "xyz"}
    _, _, found = analyse(tmp_path, write_study(tmp_path, "group", members))
    own = found[(found["measure"] == "stance_s") & (found["role"] == "measure")]
    assert own["p"].notna().tolist() == [True, False, False]
    # stances of 10, 11, 12 frames grow by 0.5, 1 and 1.5: R 4.2.2, t.test(c(105, 120, 135) / 1000,
    # c(100, 110, 120) / 1000, paired = TRUE): t = 3.4641, df = 2, p-value = 0.07418
    assert own["difference"].iloc[0] == pytest.approx(0.01)
    assert own["p"].iloc[0] == pytest.approx(0.07418, abs=5e-6)
    assert own["note"].iloc[1] == "no animal is in both conditions: not compared"


@pytest.mark.slow
def test_conditions_that_are_not_told_apart_are_named(tmp_path):
    rows = []
    for condition in ("before", "after"):
        for group, animals in (("ctl", "abc"), ("les", "xyz")):
            for i, animal in enumerate(animals):
                file = f"{animal}-{condition}.csv"
                write_trial(tmp_path / file, stance=10.0 + i)
                rows.append({"file": file, "animal": animal, "group": group})
                rows[-1]["condition"] = condition
    notes, _, _ = analyse(tmp_path, rows)
    (note,) = [note for note in notes if "not told apart" in note]
    assert note.startswith("groups are compared over several conditions (before, after)")
    assert "of another mix" not in note
    notes, _, _ = analyse(tmp_path, [row for row in rows if row["file"] != "z-after.csv"])
    (note,) = [note for note in notes if "not told apart" in note]
    assert "; z lack some of them, so that their means are of another mix. To" in note
    # one condition in each group is no mixture
    notes, _, _ = analyse(tmp_path, [row for row in rows if row["condition"] == "before"])
    assert not [note for note in notes if "not told apart" in note]


@pytest.mark.slow
def test_that_phases_are_over_all_groups_together_is_said(tmp_path):
    rows = write_study(tmp_path, "group", {"ctl": "abc", "les": "xyz"})
    notes, methods, _ = analyse(tmp_path, rows)
    (note,) = [note for note in notes if "together" in note]
    assert note.startswith("means, intervals and patterns of phase_summary, animals and legs, and")
    assert "over all groups together (ctl, les). groups.csv has the means of each group" in note
    assert "Mean phases are circular means over the animals of all groups together" in methods
    notes, methods, _ = analyse(tmp_path, rows[:3])
    assert not [note for note in notes if "together" in note]
    assert "Mean phases are circular means over animals, each" in methods


@pytest.mark.parametrize(
    ("names", "alike"),
    [
        (["007", "7"], "007 and 7"),  # a spreadsheet takes the zeros away
        (["m01", "M-1", "m10"], "m01 and M-1"),
        (["Mäx", unicodedata.normalize("NFD", "Mäx")], "Mäx and Mäx"),
        (["0.05 mg", "0.5 mg", "m1", "m10", "0", "00x"], None),
    ],
)
def test_names_of_one_animal_that_are_spelt_unlike_are_said(names, alike):
    notes = notes_on_groups([(name, "t") for name in names], {}, aside={}, compared="group")
    said = [unicodedata.normalize("NFC", note) for note in notes]
    assert [note.split(" count as")[0] for note in said] == ([] if alike is None else [alike])


def test_what_is_not_known_of_all_animals_or_contradicts_itself_is_said():
    fields = {(a, t): {"sex": "F", "mass_g": 20.0 + (t == "2")} for a in "abc" for t in "12"}
    assert notes_on_fields(fields) == []  # a mass that grows in most animals is no slip
    fields["b", "2"]["sex"] = "M"
    del fields["c", "1"]["mass_g"]
    slip, size = sorted(notes_on_fields(fields), reverse=True)
    assert slip.startswith("sex is one value in the trials of most animals, and several in")
    assert "those of b: F, M. Look whether" in slip
    assert size.startswith("gait is not compared with mass_g: it is not given for c 1; every")


@pytest.mark.slow
def test_an_animal_without_strides_is_counted_and_keeps_its_group(tmp_path):
    still = walking_tracks("t3", "m3").isel(time=slice(0, 200)).copy(deep=True)
    still["position"][:] = still["position"].isel(time=0)
    rows = []
    for k, tracks in enumerate((walking_tracks("t1", "m1"), walking_tracks("t2", "m2"), still)):
        write_tracks(tracks, tmp_path / f"{k}.nc")
        rows.append({"file": f"{k}.nc", "animal": f"m{k}", "group": "ab"[k > 0]})
    _, methods, _ = analyse(tmp_path, rows, name=["t0", "t1", "t2"], fps=250.0)
    assert methods.startswith("Gait was analysed in 3 trials of 3 animals: ")
    assert " No stride was found in 1 of these trials (t2); m2 is in no mean and no te" in methods
    listed = pd.read_csv(tmp_path / "results" / "trials.csv")
    assert listed["group"].tolist() == ["a", "b", "b"]
    assert listed["n_strides"].iloc[2] == 0


@pytest.mark.slow
def test_stances_by_position_beside_stances_by_contact_are_said(tmp_path):
    rows = write_study(tmp_path, "group", {"ctl": "abc", "les": "xyz"})
    notes, _, _ = analyse(tmp_path, rows)
    assert not [note for note in notes if note.startswith("stance is from")]
    for row in rows[3:]:
        path = tmp_path / row["file"]
        pd.read_csv(path).replace({"TD": "AEP", "LO": "PEP"}).to_csv(path, index=False)
    notes, _, _ = analyse(tmp_path, rows)
    (note,) = [note for note in notes if note.startswith("stance is from")]
    by_contact = "TD to LO in ctl-a, ctl-b, ctl-c"
    assert note.startswith(f"stance is from {by_contact} and AEP to PEP in les-x, les-y, les-z: ")


@pytest.mark.slow
def test_what_does_not_vary_between_animals_is_not_tested(tmp_path):
    """Whole frames at a low rate: all animals of a group have one duty factor."""
    rows = []
    for group, stance in (("a", 2.0), ("b", 3.0)):
        for i in range(3):
            write_trial(tmp_path / f"{group}{i}.csv", period=4.0, stance=stance, strides=5 + i)
            rows.append({"file": f"{group}{i}.csv", "animal": f"{group}{i}", "group": group})
    _, methods, found = analyse(tmp_path, rows)
    own = found[(found["measure"] == "duty_factor") & (found["role"] == "measure")].iloc[0]
    # R 4.2.2: t.test(c(.75, .75, .75), c(.5, .5, .5)): Error: data are essentially constant
    assert own["difference"] == pytest.approx(0.25)
    assert own[["p", "ci_low", "ci_high", "effect", "p_adjusted"]].isna().all()
    assert own["note"] == "no spread between animals beyond rounding: no interval and no p"
    assert "Differences between groups are described and not tested" in methods


@pytest.mark.slow
def test_a_file_that_says_another_group_than_the_study_is_named(tmp_path):
    rows = write_study(tmp_path, "group", {"ctl": "abc", "les": "xyz"})
    for row in rows:
        path = tmp_path / row["file"]
        own = "les" if row["animal"] == "b" else row["group"]
        pd.read_csv(path).assign(group=own).to_csv(path, index=False)
    notes, _, found = analyse(tmp_path, rows)
    (note,) = [note for note in notes if "as the file itself" in note]
    assert "itself: ctl-b.csv (trial) in ctl, not les. Look which" in note
    assert found["n_animals_a"].iloc[0] == 3


@pytest.mark.slow
def test_a_trial_that_names_another_animal_and_group_than_the_study_is_named(tmp_path):
    rows = []
    for animal, group in (("a", "ctl"), ("b", "les")):
        folder = tmp_path / animal
        folder.mkdir()
        write_tracks(walking_tracks("t", "x").isel(time=slice(0, 200)), folder / "own.nc")
        (folder / "trial.toml").write_text(
            f'[trial]\nkind = "tracks"\nname = "{animal}-1"\nfps = 250.0\n'
            f'[animal]\nid = "a"\nspecies = "mouse"\ngroup = "ctl"\n[tracks]\nfile = "own.nc"\n'
        )
        rows.append({"file": animal, "animal": animal, "group": group})
    pd.DataFrame(rows).to_csv(tmp_path / "study.csv", index=False)
    sources, _ = read_sources(GaitRequest(inputs=tmp_path / "study.csv"))
    groups, animals = [n for n in notes_on_sources(sources, None) if "as the file itself" in n]
    assert "itself: trial.toml (b-1) in les, not ctl. Look" in groups
    assert "itself: trial.toml (b-1) as b, not a. Look" in animals


def test_another_frame_rate_than_that_of_a_trial_is_said(tmp_path):
    write_tracks(walking_tracks("t", "x").isel(time=slice(0, 200)), tmp_path / "own.nc")
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "x"\nfps = 250.0\n[tracks]\nfile = "own.nc"\n'
    )
    with pytest.warns(
        InputWarning, match=r"trial\.toml says 250 .* and not the fps of 500 that is"
    ):
        source = read_source(tmp_path, fps=500.0)
    assert source.tracks is not None
    assert source.tracks.attrs["fps"] == 250.0
    read_source(tmp_path, fps=250.0)


def test_events_of_several_animals_or_trials_are_not_made_into_one(tmp_path):
    write_trial(tmp_path / "one.csv")
    write_trial(tmp_path / "two.csv", period=26.0)
    parts = [pd.read_csv(tmp_path / name).assign(trial=name) for name in ("one.csv", "two.csv")]
    pd.concat([p.assign(animal=a) for p, a in zip(parts, "ab", strict=True)]).to_csv(
        tmp_path / "animals.csv", index=False
    )
    pd.concat(parts).assign(animal="a").to_csv(tmp_path / "trials.csv", index=False)
    with pytest.raises(InputError, match=r"these events have 2 animals, a, b; name each once, joi"):
        analyse(tmp_path, [{"file": "animals.csv", "animal": "a"}])
    with pytest.raises(InputError, match=r"several trials of one animal, one.csv, two.csv; leave"):
        analyse(tmp_path, [{"file": "trials.csv", "animal": "a", "name": "x"}])
    source = read_source(tmp_path / "animals.csv", fps=FPS).of_animal("x+y")
    assert source.events is not None
    own = source.events.groupby("trial")["animal"].unique().map(list).to_dict()
    assert own == {"one.csv": ["x"], "two.csv": ["y"]}
