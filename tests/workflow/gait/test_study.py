"""A study names trials, animals, groups, conditions and covariates; what is wrong is told."""

from __future__ import annotations

import dataclasses
import json
import unicodedata

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.gait import pool
from pawnb.gait.events.event_edits import EventEdits, ExcludeStride
from pawnb.synthetic import write_deeplabcut_sample
from pawnb.workflow.gait import study_tables
from pawnb.workflow.gait.inputs import analyse_source, check_alike, read_pairs, read_sources
from pawnb.workflow.gait.request import GaitRequest
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.sources import read_source
from pawnb.workflow.gait.study import is_study, read_study
from pawnb.workflow.provenance.report.report import write_report

STUDY = """
[gait]
min_stance_s = 0.01
[[animals]]
id = "m1"
group = "control"
mass_g = 20.5
[[animals]]
id = "m2"
group = "lesion"
mass_g = 24.0
[[trials]]
file = "one.csv"
animal = "m1"
fps = 200.0
[[trials]]
file = "sub/two.csv"
animal = "m2"
name = "late"
condition = "after"
incline_deg = 5
gait = { min_stance_s = 0.02 }
"""


def test_a_study_without_its_column_is_told_what_it_lacks(tmp_path):
    (tmp_path / "study.csv").write_text("recording,animal,fps\na.csv,m1,200\n")
    with pytest.raises(InputError, match=r"A study needs the columns 'file' .* found recording, "):
        run_gait(tmp_path / "study.csv")


def scored(path, *, legs=("FR", "FL"), period_s=0.2, duty=0.6, strides=6):
    """Events that a person might have scored: left legs half a stride after right ones."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [
        (leg, event, period_s * k + late + 0.5 * period_s * leg.endswith("L"))
        for leg in legs
        for k in range(strides)
        for event, late in (("TD", 0.0), ("LO", duty * period_s))
    ]
    pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(path, index=False)
    return path


@pytest.fixture
def study(tmp_path):
    scored(tmp_path / "one.csv")
    scored(tmp_path / "sub" / "two.csv", period_s=0.25)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_a_study_is_read_as_it_says(study):
    found = read_study(study)
    one, two = found.trials
    assert (one.animal, one.group, one.fps, one.name) == ("m1", "control", 200.0, None)
    assert (two.name, two.condition, two.group) == ("late", "after", "lesion")
    assert dict(two.fields) == {"mass_g": 24.0, "incline_deg": 5}
    assert dict(two.settings) == {"min_stance_s": 0.02}
    assert found.compare == "group"
    assert two.path == study.parent / "sub" / "two.csv"


def test_a_csv_says_the_same_and_keeps_ids_as_they_are_written(tmp_path):
    path = tmp_path / "study.csv"
    path.write_text(
        "file,animal,condition,mass_g,sex,gait.min_stance_s\n"
        "a.csv,007,before,20.5,f,0.02\nb.csv,007,after,20.5,f,\n"
    )
    found = read_study(path)
    assert [trial.animal for trial in found.trials] == ["007", "007"]
    assert dict(found.trials[0].fields) == {"mass_g": 20.5, "sex": "f"}
    assert [dict(t.settings) for t in found.trials] == [{"min_stance_s": 0.02}, {}]
    assert found.compare == "condition"


def test_names_with_umlauts_are_found_as_they_are_on_the_disk(tmp_path):
    two_signs = unicodedata.normalize("NFD", "Mäuse 1.csv")  # as macOS writes them
    scored(tmp_path / two_signs)
    (tmp_path / "study.csv").write_text("file,animal\nMäuse 1.csv,Mäx\nlost.csv,m2\n")
    one, lost = read_study(tmp_path / "study.csv").trials
    assert one.path.exists()
    assert lost.path == tmp_path / "lost.csv"


@pytest.mark.parametrize("ending", ["tsv", "txt"])
def test_a_study_under_another_ending_is_told_to_be_called_csv(tmp_path, ending):
    path = tmp_path / f"study.{ending}"
    path.write_text("file\tanimal\tgroup\none.csv\tm1\ta\n")
    with pytest.raises(InputError, match=r"a study is a \.csv; call it study\.csv"):
        run_gait(path)


def test_an_animal_without_a_trial_is_said(study):
    study.write_text(study.read_text() + '[[animals]]\nid = "m3"\ngroup = "lesion"\n')
    with pytest.warns(InputWarning, match=r"m3 of \[\[animals\]\] have no trial in \[\[trials\]\]"):
        assert len(read_study(study).trials) == 2


def test_what_is_a_study(study, tmp_path):
    assert is_study(study)
    assert not is_study(tmp_path)
    assert not is_study(tmp_path / "one.csv")
    (tmp_path / "trial.toml").write_text("[trial]\nfps = 250.0\n")
    assert not is_study(tmp_path / "trial.toml")
    (tmp_path / "broken.toml").write_text("[[trials")
    assert not is_study(tmp_path / "broken.toml")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[gait]", "[giat]", r"unknown section \[giat\] \(did you mean 'gait'\?\)"),
        ('animal = "m2"', 'animal = "m3"', "is of animal 'm3', which"),
        ('file = "sub/two.csv"', 'file = "one.csv"', "one.csv is there twice"),
        ('id = "m2"', 'id = "m1"', "expected an id of its own for each"),
        ("fps = 200.0", 'fps = "fast"', "fps is 'fast'; expected a number"),
        ("[gait]", '[study]\ncompare = "groups"\n[gait]', "did you mean 'group'"),
        ("[gait]", '[study]\nname = "x"\n[gait]', "unknown field 'name'"),
        ('file = "one.csv"', "", r"every trial needs file = \.\.\. and animal"),
    ],
)
def test_what_is_wrong_with_a_study_is_one_sentence(study, old, new, said):
    study.write_text(STUDY.replace(old, new))
    with pytest.raises(InputError, match=said):
        read_study(study)


def test_a_study_stands_alone(study):
    with pytest.raises(InputError, match="name nothing beside it"):
        read_sources(GaitRequest(inputs=[study, study.parent / "one.csv"]))


def test_settings_by_hand_go_before_the_trials_and_these_before_the_studys(study):
    (one, two), _ = read_sources(GaitRequest(inputs=study))
    settings = {"bouts": False}
    of = [analyse_source(source, settings=settings).settings for source in (one, two)]
    assert [s.min_stance_s for s in of] == [0.01, 0.02]
    assert not of[0].bouts
    assert analyse_source(two, settings={"min_stance_s": "0.03"}).settings.min_stance_s == 0.03
    for typed in ('[["FR", "FL"]]', "[['FR','FL']]"):  # shells of Windows take double quotes away
        pairs = analyse_source(one, settings={"pairs": typed}).phases
        assert set(zip(pairs["leg"], pairs["reference"], strict=True)) == {("FR", "FL")}


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("min_stance_s = 0.01", "min_stanse_s = 0.01", r"study\.toml: \[gait\]: unknown setting "
         r"'min_stanse_s' \(did you mean 'min_stance_s'\?\)"),
        ("gait = { min_stance_s", "gait = { min_stanse_s", r"study\.toml: gait of two\.csv: "
         r"unknown setting 'min_stanse_s' \(did you mean 'min_stance_s'\?\)"),
        ("[gait]", '[gait]\npair = [["FR", "FL"]]', r"study\.toml: .* \(did you mean 'pairs'\?\)"),
        ("min_stance_s = 0.01", "min_stance_s = -1", r"study\.toml: \[gait\]: .*min_stance_s"),
        ("[gait]", '[gait]\npairs = "FL"', r"study\.toml: \[gait\]: setting pairs is 'FL'"),
    ],
)  # fmt: skip
def test_a_wrong_setting_names_the_file_it_stands_in(study, old, new, where):
    study.write_text(STUDY.replace(old, new))
    with pytest.raises(InputError, match=where):
        read_sources(GaitRequest(inputs=study))


def test_a_wrong_setting_of_a_trial_of_a_study_names_its_trial_toml(tmp_path):
    scored(tmp_path / "e.csv")
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nfps = 200.0\n[animal]\nid = "m1"\n[tracks]\nfile = "e.csv"\n'
        "[gait]\ncutof_hz = 9.0\n"
    )
    (tmp_path / "study.csv").write_text("file,animal\ntrial.toml,m1\n")
    with pytest.raises(InputError, match=r"trial\.toml: \[gait\]: .*did you mean 'cutoff_hz'"):
        read_sources(GaitRequest(inputs=tmp_path / "study.csv"))


def test_every_kind_of_drop_is_counted_in_trials_csv(tmp_path):
    """One stride, two pauses, two phases and one extreme position of m1; nothing of m2."""
    parts = [
        analyse_source(read_source(scored(tmp_path / f"{name}.csv")).of_animal(name))
        for name in ("m1", "m2")
    ]
    tables = pool(parts)
    who = {"animal": "m1", "trial": "m1", "leg": "FR", "start_s": 0.0, "end_s": 1.0, "why": "x"}
    kinds = ["stride", "pause", "pause", "phase to FL", "phase to HR", "AEP and PEP"]
    dropped = pd.DataFrame([{**who, "what": kind} for kind in kinds])
    table = study_tables.trials_table(
        dataclasses.replace(tables, dropped=dropped), groups={}, fields={}
    )
    counted = table.set_index("animal").loc[:, "n_strides":]
    assert counted.loc["m1"].to_dict() == {
        "n_strides": 10, "n_dropped": 1, "n_dropped_aep_and_pep": 1, "n_dropped_pause": 2,
        "n_dropped_phase": 2,
    }  # fmt: skip
    assert counted.loc["m2"].tolist() == [10, 0, 0, 0, 0]
    assert counted.dtypes.astype(str).eq("int64").all()


@pytest.mark.parametrize("value", ["FL", '["FL", "FR"]', "[[1, 2]]", [], 3])
def test_pairs_that_are_none_are_refused(value):
    with pytest.raises(InputError, match="expected pairs of legs"):
        read_pairs(value)


def test_trial_toml_may_hold_settings_of_the_gait(tmp_path):
    scored(tmp_path / "e.csv")
    text = '[trial]\nkind = "tracks"\nfps = 200.0\n[animal]\nid = "m1"\nmass_g = 3.0\n'
    toml = tmp_path / "trial.toml"
    toml.write_text(text + '[tracks]\nfile = "e.csv"\n[gait]\nmin_stance_s = 0.02\n')
    source = read_source(toml)
    assert analyse_source(source).settings.min_stance_s == 0.02
    assert dict(source.fields) == {"mass_g": 3.0}
    toml.write_text(text + '[tracks]\nfile = "e.csv"\n[gait]\nmin_stanse_s = 0.02\n')
    with pytest.raises(InputError, match=r"did you mean 'min_stance_s'"):
        analyse_source(read_source(toml))


def test_legs_by_several_kinds_of_names_are_not_pooled(tmp_path):
    parts = [
        analyse_source(read_source(scored(tmp_path / f"{name}.csv", legs=legs)))
        for name, legs in (("a", ("FR", "FL")), ("b", ("R1", "L1")))
    ]
    with pytest.raises(InputError, match=r"legs are called FR, FL in a and L1, R1 in b; call"):
        check_alike(parts)
    check_alike(parts[:1])


def test_one_trial_may_name_some_legs_its_own_way(tmp_path):
    """Its legs were said to be called otherwise than themselves."""
    mixed = [
        analyse_source(read_source(scored(tmp_path / f"{name}.csv", legs=("FR", "tail"))))
        for name in ("a", "b")
    ]
    check_alike(mixed)
    plain = analyse_source(read_source(scored(tmp_path / "c.csv")))
    with pytest.raises(InputError, match="legs are called FR, tail in a and FR, FL in c; call"):
        check_alike([mixed[0], plain])


def test_sizes_must_be_numbers_and_differ():
    strides = pd.DataFrame({"animal": list("abc"), "trial": "t"})
    fields = {(name, "t"): {"mass_g": 2.0 + k} for k, name in enumerate("abc")}
    assert study_tables.with_sizes(strides, fields)[1] == ["mass_g"]
    same = {key: {"mass_g": 2.0} for key in fields}
    assert study_tables.with_sizes(strides, same)[1] == []
    assert study_tables.with_sizes(strides, {**fields, ("c", "t"): {}})[1] == []
    with pytest.raises(InputError, match="mass_g is 'heavy'; expected a number above 0"):
        study_tables.with_sizes(strides, {**fields, ("c", "t"): {"mass_g": "heavy"}})


def test_powers_of_size_are_found():
    """Frequency made as 12 m^-0.25 and stride length as 30 m^0.33, without any scatter."""
    mass = np.array([1.0, 2.0, 4.0, 9.0])
    strides = pd.DataFrame(
        {"animal": list("abcd"), "trial": "t", "speed": 360 * mass**0.08, "speed_bl": 1.0,
         "frequency_hz": 12 * mass**-0.25, "stride_length": 30 * mass**0.33}
    )  # fmt: skip
    fields = {(name, "t"): {"mass_g": m} for name, m in zip("abcd", mass, strict=True)}
    found = study_tables.size_tables(strides.drop(columns="speed_bl"), fields)
    slopes = found["scaling"].query("statistic == 'mean'").set_index("parameter")["b"]
    np.testing.assert_allclose(
        slopes[["frequency_hz", "stride_length", "speed"]], [-0.25, 0.33, 0.08], rtol=1e-9
    )
    assert set(found["expected_exponents"]["parameter"]) == {
        "speed", "frequency_hz", "stride_length",
    }  # fmt: skip


def test_speed_in_body_lengths_is_compared_with_size():
    """Rows of normalised speed in Pullar's (2009) Table 4.3, and Fig. 4.1 c and d."""
    mass = np.array([1.0, 2.0, 4.0, 9.0])
    strides = pd.DataFrame(
        {"animal": list("abcd"), "trial": "t", "speed": 360 * mass**0.24,
         "speed_bl": 20 * mass**-0.09, "frequency_hz": 12 * mass**-0.14,
         "stride_length": 30 * mass**0.38}
    )  # fmt: skip
    fields = {(name, "t"): {"mass_g": m} for name, m in zip("abcd", mass, strict=True)}
    rows = study_tables.size_tables(strides, fields)["scaling"].query("parameter == 'speed_bl'")
    assert rows["statistic"].tolist() == ["mean", "min", "max"]
    np.testing.assert_allclose(rows["b"], -0.09, rtol=1e-9)
    np.testing.assert_allclose(rows["a"], 20.0, rtol=1e-9)
    drawing = next(study_tables.size_drawings(strides, fields, unit="mm"))
    table, _ = drawing.draw()
    assert set(table["outcome"]) == {"speed", "speed_bl", "frequency_hz", "stride_length"}


def test_reference_lines_follow_mass_unit_and_legs():
    """A mouse of 30 g: 0.66 m/s and 7.32 Hz by the laws of Heglund et al. (1974)."""
    strides = pd.DataFrame({"leg": ["FL", "FR", "HL", "HR"]})
    fields = {("a", "t"): {"mass_g": 20.0}, ("b", "t"): {"mass_g": 40.0}}
    found = study_tables.reference_lines(strides, fields, unit="mm")
    assert found["frequency_hz"][0] == pytest.approx(269 / 60 * 0.03**-0.14)
    assert found["speed"][0] == pytest.approx(1527.8 * 0.03**0.24, rel=1e-3)
    assert found["stride_length"][0] == pytest.approx(350.0 * 0.03**0.38)
    assert found["duty_factor"][0] == 0.75
    assert set(study_tables.reference_lines(strides, fields, unit="px")) == {
        "frequency_hz", "duty_factor",
    }  # fmt: skip
    without = {**fields, ("b", "t"): {"mass": 40.0}}  # no unit
    assert set(study_tables.reference_lines(strides, without, unit="mm")) == {"duty_factor"}
    assert study_tables.reference_lines(strides.iloc[:3], {}, unit="mm") == {}
    spider = pd.DataFrame({"leg": [f"{side}{k}" for side in "LR" for k in range(1, 5)]})
    assert study_tables.reference_lines(spider, {}, unit="mm")["duty_factor"][0] == 0.375


@pytest.mark.slow
def test_groups_of_hand_scored_events_are_compared(tmp_path):
    """Lesioned animals take 0.25 s a stride, controls 0.2 s: a difference of exactly 0.05 s."""
    rows = ["file,animal,group"]
    for k, group in enumerate(["control"] * 3 + ["lesion"] * 3):
        period = (0.2 if group == "control" else 0.25) + 0.001 * (k % 3 - 1)
        scored(tmp_path / f"m{k}.csv", period_s=period)
        rows.append(f"m{k}.csv,m{k},{group}")
    (tmp_path / "study.csv").write_text("\n".join(rows) + "\n")
    run = run_gait(tmp_path / "study.csv", figures="none")
    assert run.out == tmp_path / "results"
    groups = pd.read_csv(run.out / "groups.csv").query("measure == 'period_s' and leg == 'all'")
    np.testing.assert_allclose(groups["difference"].abs(), 0.05, atol=1e-9)
    assert groups["n_animals_a"].item() == 3
    trials = pd.read_csv(run.out / "trials.csv")
    assert trials["group"].tolist() == ["control"] * 3 + ["lesion"] * 3
    assert (trials["n_strides"] == 10).all()
    step = json.loads((run.out / "provenance.json").read_text())["steps"][0]
    assert step["given"] == [f"{tmp_path.name}/study.csv"]


@pytest.fixture
def corrected(tmp_path):
    """A study of files in a folder of their own, a stride of which is excluded beside it."""
    for name in ("m1.csv", "m2.csv"):
        scored(tmp_path / "data" / name)
    study = tmp_path / "study.csv"
    study.write_text("file,animal\ndata/m1.csv,m1\ndata/m2.csv,m2\n")
    exclude_one(run_gait(study, figures="none"))
    return study


def exclude_one(run):
    """Exclude a stride in the folder of an analysis, as the explorer does."""
    stride = run.tables.strides.iloc[2]
    edits = EventEdits(run.tables, run.out / "event_edits.jsonl")
    who = {name: str(stride[name]) for name in ("animal", "trial", "leg")}
    edits.apply(ExcludeStride(**who, start_s=float(stride["start_s"]), reason="stumbled"))


@pytest.mark.slow
def test_a_study_written_elsewhere_has_the_corrections_beside_it(corrected, tmp_path):
    run = run_gait(corrected, figures="none", out=tmp_path / "paper")
    assert "excluded by hand: stumbled" in set(run.tables.dropped["why"])


@pytest.mark.slow
def test_the_report_of_a_study_has_its_corrections(corrected):
    page = write_report(corrected).read_text()
    assert "excluded by hand: stumbled" in page
    assert "Corrected by hand: 1 stride excluded." in page


@pytest.mark.slow
def test_the_report_of_files_has_the_corrections_beside_it(tmp_path):
    files = [scored(tmp_path / name) for name in ("m1.csv", "m2.csv")]
    run = run_gait(files, figures="none", out=tmp_path / "out")
    exclude_one(run)
    assert "stumbled" in write_report(files, out=tmp_path / "out" / "r.html").read_text()


def test_rows_that_a_spreadsheet_leaves_empty_are_no_trials(tmp_path):
    scored(tmp_path / "one.csv")
    (tmp_path / "study.csv").write_text("file,animal,mass_g\none.csv,m1,20\n,,\n,,\n")
    assert [trial.animal for trial in read_study(tmp_path / "study.csv").trials] == ["m1"]


def test_a_trial_without_its_file_is_named_by_its_line(tmp_path):
    scored(tmp_path / "one.csv")
    (tmp_path / "study.csv").write_text("file,animal,mass_g\none.csv,m1,20\n,m2,21\n")
    with pytest.raises(InputError, match=r"line 3: file is empty; every trial needs"):
        read_study(tmp_path / "study.csv")


@pytest.mark.parametrize(
    ("text", "fields"),
    [
        ("file;animal;mass_g\none.csv;m1;20,5\n", {"mass_g": 20.5}),
        ("file;animal;note, mine\none.csv;m1;slow, fast\n", {"note, mine": "slow, fast"}),
        ("sep=;\nfile;animal\none.csv;m1\n", {}),
        ("file\tanimal\tmass_g\none.csv\tm1\t20.5\n", {"mass_g": 20.5}),
    ],
)
def test_a_study_of_a_spreadsheet_of_another_region_is_read(tmp_path, text, fields):
    scored(tmp_path / "one.csv")
    (tmp_path / "study.csv").write_text(text)
    assert is_study(tmp_path / "study.csv")
    (trial,) = read_study(tmp_path / "study.csv").trials
    assert (trial.path.name, trial.animal, dict(trial.fields)) == ("one.csv", "m1", fields)


def test_events_of_a_spreadsheet_of_another_region_are_read(tmp_path):
    scored(tmp_path / "one.csv")
    plain = read_source(tmp_path / "one.csv", fps=200.0).events
    text = (tmp_path / "one.csv").read_text()
    (tmp_path / "one.csv").write_text(text.replace(",", ";").replace(".", ","))
    told = read_source(tmp_path / "one.csv", fps=200.0).events
    pd.testing.assert_frame_equal(plain, told)


def test_a_study_whose_columns_are_in_capitals_is_told_their_names(tmp_path):
    (tmp_path / "study.csv").write_text("File,Animal,Group\none.csv,m1,a\n")
    with pytest.raises(InputError, match=r"A study needs the columns 'file' .* found File, "):
        run_gait(tmp_path / "study.csv")
    (tmp_path / "study.csv").write_text("file,animal,Group\none.csv,m1,a\n")
    with pytest.raises(InputError, match=r"'Group' would not be read; write 'group'\.$"):
        read_study(tmp_path / "study.csv")


@pytest.mark.slow
def test_corrections_of_a_file_by_itself_count_in_a_study_that_names_its_animal(tmp_path):
    """The file says no animal: by itself it is called as the file, in the study m1 and first."""
    one, two = write_deeplabcut_sample(tmp_path, animals=2)
    exclude_one(run_gait(one, fps=200.0, figures="none"))
    study = tmp_path / "study.csv"
    rows = [f"{one.name},m1,first,200", f"{two.name},m2,second,200"]
    study.write_text("\n".join(["file,animal,name,fps", *rows]) + "\n")
    run = run_gait(study, figures="none", out=tmp_path / "out")
    (row,) = run.tables.dropped.query("why == 'excluded by hand: stumbled'").to_dict("records")
    assert (row["animal"], row["trial"]) == ("m1", "first")
    assert not any("left out" in note for note in run.tables.notes)
