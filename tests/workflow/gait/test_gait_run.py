"""Gait from any input: tables, figures and provenance; several inputs pooled by animal."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from trotting import BELT, DUTY, FPS, PERIOD_S, walking_tracks

from pawnb import schema
from pawnb.errors import InputError, InputWarning
from pawnb.gait.events.event_edits import EventEdits, ExcludeStride, MoveEvent
from pawnb.io.native import points3d_table, write_tracks
from pawnb.io.tables import write_table
from pawnb.synthetic import write_deeplabcut_sample
from pawnb.workflow.gait.run import run_gait


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    write_tracks(walking_tracks("t1", "m1"), folder / "tracks.nc")
    return folder


@pytest.mark.slow
def test_tables_have_the_columns_of_the_contract(results):
    run = run_gait([results], figures="main")
    assert run.out == results
    for name in ("events", "strides", "phases", "phase_summary", "dropped"):
        columns = getattr(schema, f"{name.upper()}_COLUMNS")
        table = pd.read_csv(results / f"{name}.csv")
        assert tuple(table.columns[: len(columns)]) == columns, name
    strides = pd.read_csv(results / "strides.csv")
    assert set(strides["animal"]) == {"m1"}
    assert set(strides["trial"]) == {"t1"}
    # the motion is known: see walking_tracks
    assert strides["frequency_hz"].median() == pytest.approx(5.0, rel=0.01)
    # a low-pass filter moves the corner between stance and swing towards the flat swing
    assert strides["duty_factor"].median() == pytest.approx(DUTY, abs=0.03)
    assert strides["stride_length"].median() == pytest.approx(BELT * PERIOD_S, rel=0.02)
    summary = pd.read_csv(results / "phase_summary.csv").set_index(["leg", "reference"])
    assert summary.loc[("FL", "FR"), "mean_strides"] == pytest.approx(0.5, abs=0.01)
    # one animal: nothing to test between animals
    assert summary["n_animals"].eq(1).all()
    assert summary[["ci_low", "ci_high", "rayleigh_p"]].isna().all(axis=None)
    assert "median stride frequency 5.00 Hz, duty factor 0.6" in run.text()
    assert run.text().startswith(f"{len(strides)} strides of 4 legs of 1 animal; ")
    one = dataclasses.replace(run, tables=dataclasses.replace(run.tables, strides=strides[:1]))
    assert one.text().startswith("1 stride of 1 leg of 1 animal; ")
    none = dataclasses.replace(run, tables=dataclasses.replace(run.tables, strides=strides[:0]))
    assert none.text().startswith("no stride was found; ")


@pytest.mark.slow
def test_figures_carry_the_recipe_and_are_the_same_each_time(results, tmp_path):
    from PIL import Image

    run = run_gait([results], figures="main", command=["pawnb", "gait", str(results)])
    figures = sorted(p.name for p in (results / "figures").iterdir())
    assert figures == [
        "gait_diagram_m1_t1.csv",
        "gait_diagram_m1_t1.pdf",
        "gait_diagram_m1_t1.png",
        "gait_diagram_m1_t1.svg",
        "phase_rose.csv",
        "phase_rose.pdf",
        "phase_rose.png",
        "phase_rose.svg",
    ]
    with Image.open(results / "figures" / "phase_rose.png") as picture:
        recipe = json.loads(picture.text["Description"])
    assert recipe["figure"] == "phase_rose"
    assert recipe["command"] == "pawnb gait results"
    assert recipe["inputs"]["results/tracks.nc"].startswith("sha256:")
    again = run_gait(
        [results], figures="main", out=tmp_path / "again", command=["pawnb", "gait", str(results)]
    )
    for path in run.files:
        twin = again.out / path.relative_to(run.out)
        assert twin.read_bytes() == path.read_bytes(), path.name
    assert str(tmp_path) not in (results / "figures" / "phase_rose.svg").read_text()


@pytest.mark.slow
def test_inputs_are_pooled_by_animal(tmp_path):
    paths = []
    for trial, animal in (("t1", "m1"), ("t2", "m1"), ("t3", "m2")):
        path = tmp_path / trial / "tracks.nc"
        path.parent.mkdir()
        write_tracks(walking_tracks(trial, animal), path)
        paths.append(path)
    run = run_gait(paths, figures="main", out=tmp_path / "pooled")
    summary = run.tables.phase_summary.set_index(["leg", "reference"])
    assert (summary["n_animals"] == 2).all()
    assert run.tables.strides["animal"].nunique() == 2
    sources = json.loads((tmp_path / "pooled" / "provenance.json").read_text())["steps"][0]
    assert sorted(sources["inputs"]) == ["t1/tracks.nc", "t2/tracks.nc", "t3/tracks.nc"]


@pytest.mark.slow
def test_corrections_of_events_are_made_again(tmp_path):
    folders = [tmp_path / trial / "results" for trial in ("t1", "t2")]
    for trial, folder in zip(("t1", "t2"), folders, strict=True):
        folder.mkdir(parents=True)
        write_tracks(walking_tracks(trial, "m1"), folder / "tracks.nc")
    before = run_gait([folders[0]], figures="none")
    stride = before.tables.strides.iloc[2]
    edits = EventEdits(before.tables, folders[0] / "event_edits.jsonl")
    who = {"animal": "m1", "trial": "t1", "leg": stride["leg"]}
    edits.apply(ExcludeStride(**who, start_s=stride["start_s"], reason="stumbled"))
    end_s = stride["start_s"] + stride["period_s"]
    edits.apply(MoveEvent(**who, event="AEP", time_s=end_s, to_s=end_s + 0.01))
    run = run_gait([folders[0]], figures="none")
    assert len(run.tables.strides) == len(before.tables.strides) - 1
    dropped = pd.read_csv(folders[0] / "dropped.csv")
    assert dropped["why"].eq("excluded by hand: stumbled").sum() == 1
    events = pd.read_csv(folders[0] / "events.csv")
    np.testing.assert_allclose(events.loc[events["method"] == "hand", "time_s"], end_s + 0.01)
    said = "corrections by hand in force: 2 (1 event moved, 1 stride excluded)."
    assert f"note: event_edits.jsonl: {said}" in run.text()
    words = (folders[0] / "methods.txt").read_text()
    assert "Corrected by hand: 1 event moved, 1 stride excluded." in words
    inputs = json.loads((folders[0] / "provenance.json").read_text())["steps"][0]["inputs"]
    assert sorted(inputs) == ["results/event_edits.jsonl", "results/tracks.nc"]
    # what was found is still there: corrections are not made twice, and can be undone
    again = EventEdits(run.tables, folders[0] / "event_edits.jsonl")
    again.undo()
    assert not again.tables.events["method"].eq("hand").any()

    # pooled, beside corrections of the pooled analysis
    out = tmp_path / "pooled"
    pooled = run_gait(folders, figures="none", out=out)
    second = pooled.tables.strides.query("trial == 't2'").iloc[0]
    EventEdits(pooled.tables, out / "event_edits.jsonl").apply(
        ExcludeStride(
            animal="m1", trial="t2", leg=second["leg"], start_s=second["start_s"], reason="turned"
        )
    )
    pooled = run_gait(folders, figures="none", out=out)
    why = pooled.tables.dropped["why"].tolist()
    assert why.count("excluded by hand: stumbled") == why.count("excluded by hand: turned") == 1


@pytest.mark.slow
def test_events_scored_by_hand_will_do(tmp_path):
    """A foot lands every 50 frames and lifts 30 later: 5 Hz at 250 per second, duty 0.6."""
    rows = [
        (leg, event, 50 * k + shift + late)
        for leg, late in (("L1", 0), ("R1", 25))
        for k in range(6)
        for event, shift in (("TD", 0), ("LO", 30))
    ]
    path = tmp_path / "events.csv"
    pd.DataFrame(rows, columns=["leg", "event", "frame"]).to_csv(path, index=False)
    run = run_gait([path], figures="main", fps=250.0)
    assert run.out == tmp_path / "results"
    strides = run.tables.strides
    np.testing.assert_allclose(strides["period_s"], 0.2)
    np.testing.assert_allclose(strides["duty_factor"], 0.6)
    with pytest.raises(InputError, match=r"does not say its frame rate; give it with --fps"):
        run_gait([path])


@pytest.mark.slow
def test_points3d_of_another_program_need_only_a_frame_rate(tmp_path):
    write_table(points3d_table(walking_tracks("t1", "m1")), tmp_path / "points3d.csv")
    run = run_gait([tmp_path / "points3d.csv"], figures="main", fps=FPS, out=tmp_path / "out")
    assert run.tables.strides["frequency_hz"].median() == pytest.approx(5.0, rel=0.01)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nowhere", "no such file; expected a trial, a results folder, tracks or an events.csv."),
        ("empty", "neither a trial nor results; expected a trial.toml, a tracks.nc or an "
                  "events.csv in it, or tables of Tracker's points only."),
    ],
)  # fmt: skip
def test_what_is_no_input_is_refused(tmp_path, name, message):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError) as caught:
        run_gait([tmp_path / name])
    assert str(caught.value) == f"{tmp_path / name}: {message}"


def test_a_file_of_no_known_kind_is_refused(tmp_path):
    (tmp_path / "x.avi").write_bytes(b"RIFF")
    with pytest.raises(InputError, match=r"x\.avi: not tracks that are read here; expected tracks"):
        run_gait([tmp_path / "x.avi"])


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"", r"p\.csv: an empty file; copy it again"),
     ("frame,FR_x,FR_y\n0,1,2\n".encode("utf-16"), r"p\.csv: text in UTF-16, .* save it as UTF-8")],
)  # fmt: skip
def test_what_keeps_a_table_from_being_read_is_said(tmp_path, content, said):
    (tmp_path / "p.csv").write_bytes(content)
    with pytest.raises(InputError, match=said):
        run_gait([tmp_path / "p.csv"], fps=100.0)


def test_an_untracked_trial_says_so(rendered_trial):
    with pytest.raises(InputError, match=r"is not tracked yet; run pawnb track first"):
        run_gait([rendered_trial])


def test_all_inputs_that_cannot_be_used_are_named_at_once(rendered_trial, tmp_path):
    """Of 500 trials the first that was not tracked was named, then the next, run by run."""
    sample = write_deeplabcut_sample(tmp_path / "dlc", animals=1)[0]
    lost = tmp_path / "lost.csv"
    with pytest.raises(InputError) as caught:
        run_gait([sample, rendered_trial, lost], fps=200.0)
    said = str(caught.value)
    assert said.startswith(f"2 of 3 inputs cannot be used: {rendered_trial}, {lost}. Mend them")
    assert "is not tracked yet; run pawnb track first" in said


@pytest.mark.slow
def test_real_rats_trot(real_data, tmp_path):
    """The 2019 authors' tracks of a rat at 0.16 m/s: a few hertz, duty factor above a half,
    left and right half a cycle apart, diagonal legs together (Hildebrand 1965: trot)."""
    folder = real_data("rat-4cam-tracks")
    name = "rat2.Week0.2018-06-08_13_30_12.csv"
    (tmp_path / "trial.toml").write_text(
        f'[trial]\nkind = "tracks"\nname = "rat"\nfps = 250\n[animal]\nid = "rat2"\n'
        f'[treadmill]\nbelt_speed = "{(folder / f"Speed_Time.{name}").resolve()}"\n'
        f'[tracks]\nfile = "{(folder / f"cam1.f.{name}").resolve()}"\n'
        f'[calibration]\ndlt = "{(folder / f"DLT.{name}").resolve()}"\nunit = "mm"\n'
    )
    with pytest.warns(InputWarning, match="of 15421 points are left out in space"):
        run = run_gait([tmp_path], figures="main")
    # what is warned of stands beside the tables too
    assert "are left out in space" in (run.out / "notes.csv").read_text()
    middle = run.tables.strides.groupby("leg")[["frequency_hz", "duty_factor"]].median()
    assert middle["frequency_hz"].between(1, 3).all()
    assert middle["duty_factor"].between(0.5, 0.8).all()
    mean = run.tables.phase_summary.set_index(["leg", "reference"])["mean_strides"]
    assert mean[("FL", "FR")] == pytest.approx(0.5, abs=0.1)
    assert mean[("HL", "HR")] == pytest.approx(0.5, abs=0.1)
    assert (mean[("FR", "HL")] + 0.5) % 1 == pytest.approx(0.5, abs=0.15)


@pytest.mark.slow
def test_deeplabcut_csv_goes_straight_to_the_tables(tmp_path):
    # the same walk as a csv of DeepLabCut, with names in words: the same strides, legs told
    tracks = walking_tracks("t1", "m1")
    words = {"FR": "Front Paw R", "HR": "Hind Paw R", "FL": "Front Paw L", "HL": "Hind Paw L"}
    names = [str(k) for k in tracks["keypoint"].to_numpy()]
    xy = tracks["position"].isel(individual=0).to_numpy()[:, :2]
    rows = [
        ["scorer", *["net"] * (3 * len(names))],
        ["bodyparts", *[words[n] for n in names for _ in range(3)]],
        ["coords", *["x", "y", "likelihood"] * len(names)],
    ]
    for i in range(len(xy)):
        rows.append([i, *[v for k in range(len(names)) for v in (*xy[i, :, k], 0.99)]])
    path = tmp_path / "m1_run1DLC.csv"
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    run = run_gait([path], figures="main", fps=FPS, out=tmp_path / "out")
    own = run_gait_of(tracks, tmp_path)
    assert set(run.tables.strides["leg"]) == set(names)
    assert set(run.tables.strides["animal"]) == {"m1_run1"}
    assert any("FR is 'Front Paw R'" in note for note in run.tables.notes)
    np.testing.assert_allclose(
        run.tables.strides["period_s"].mean(), own.tables.strides["period_s"].mean(), rtol=0.01
    )
    with pytest.raises(InputError, match="give fps"):
        run_gait([path], out=tmp_path / "out")


def run_gait_of(tracks, folder):
    """Analyse tracks as pawnb writes them."""
    write_tracks(tracks, folder / "own.nc")
    return run_gait([folder / "own.nc"], figures="main", out=folder / "own")


@pytest.mark.slow
def test_contact_by_hand_is_read_as_events(tmp_path):
    down = [1] * 6 + [0] * 4
    rows = ["frame,LF,RF"] + [f"{i},{down[i % 10]},{down[(i + 5) % 10]}" for i in range(100)]
    (tmp_path / "fly.csv").write_text("\n".join(rows) + "\n")
    run = run_gait([tmp_path / "fly.csv"], figures="main", fps=100.0, out=tmp_path / "out")
    np.testing.assert_allclose(run.tables.strides["period_s"], 0.1)
    np.testing.assert_allclose(run.tables.strides["duty_factor"], 0.6)
    np.testing.assert_allclose(run.tables.phases["phase"], 0.5)


@pytest.mark.slow
def test_real_events_under_their_own_names(real_data, tmp_path):
    # a tardigrade's eight legs, "up" and "down" scored by hand: 95 steps, as published to 1e-3
    folder = real_data("tardigrade-8leg-events")
    names = {"down": "TD", "up": "LO"}
    run = run_gait(
        [folder / "events_long.csv"], event_names=names, figures="none", out=tmp_path / "out"
    )
    found = pd.read_csv(tmp_path / "out" / "strides.csv").sort_values(["leg", "start_s"])
    published = pd.read_csv(folder / "step_timing.csv").sort_values(["legID", "DownTime"])
    assert len(found) == 95 == len(run.tables.strides)
    for ours, theirs in (("stance_s", "stance"), ("period_s", "gait"), ("duty_factor", "duty")):
        np.testing.assert_allclose(found[ours], published[theirs], atol=1e-3)
    with pytest.raises(InputError, match=r"--event-names down=TD\.$"):
        run_gait([folder / "events_long.csv"], out=tmp_path / "out")


def test_legs_of_events_get_the_names_asked_for(tmp_path):
    rows = [
        (leg, event, 0.2 * k + late + 0.12 * (event == "off"))
        for leg, late in (("links", 0.0), ("rechts", 0.1), ("tail", 0.05))
        for k in range(5)
        for event in ("on", "off")
    ]
    path = tmp_path / "events.csv"
    pd.DataFrame(rows, columns=["leg", "event", "time_s"]).to_csv(path, index=False)
    options = {"event_names": {"on": "TD", "off": "LO"}, "figures": "none"}
    run = run_gait([path], legs={"HL": "links", "HR": "rechts"}, **options)
    assert set(run.tables.strides["leg"]) == {"HL", "HR"}
    np.testing.assert_allclose(run.tables.phases["phase"], 0.5)
    with pytest.raises(InputError, match=r"no leg 'link' .did you mean 'links'"):
        run_gait([path], legs={"HL": "link"}, **options)


def contact_csv(path, *, period=10):
    """Contact of two legs, half a stride apart, six tenths of the stride on the ground."""
    down = [i % period < 0.6 * period for i in range(2 * period)]
    rows = ["frame,LF,RF"]
    for i in range(100):
        rows.append(f"{i},{int(down[i % period])},{int(down[(i + period // 2) % period])}")
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.slow
def test_files_of_one_animal_count_once(tmp_path):
    paths = [contact_csv(tmp_path / f"{name}.csv") for name in ("a", "b", "c")]
    options = {"fps": 100.0, "figures": "none", "out": tmp_path / "out"}
    each = run_gait(paths, **options)
    assert each.tables.phase_summary["n_animals"].tolist() == [3]
    assert any("each counts as one of its own: a, b, c." in note for note in each.tables.notes)
    told = run_gait(paths, animals=["m1", "m1", "m2"], **options)
    assert told.tables.phase_summary["n_animals"].tolist() == [2]
    assert set(told.tables.strides["trial"]) == {"a", "b", "c"}
    assert not any("each counts as one" in note for note in told.tables.notes)
    with pytest.raises(InputError, match=r"^animals: 2 for 3 inputs; give the id of each"):
        run_gait(paths, animals=["m1", "m2"], **options)


@pytest.mark.slow
def test_one_input_needs_no_list(results):
    """A text is one input, and not its letters."""
    for inputs in (results, str(results)):
        run = run_gait(inputs, figures="none")
        assert set(run.tables.strides["trial"]) == {"t1"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": []}, "no inputs; name at least one."),
        ({"inputs": None}, "inputs is None; expected a path or a list"),
        ({"inputs": [3]}, "inputs holds 3; expected a list, each item a path."),
        ({"animals": "m"}, "animals is 'm'; expected a list of names."),
        ({"groups": "g"}, "groups is 'g'; expected a list of names."),
        ({"legs": "FR"}, "legs is 'FR'; expected a list of names"),
        ({"legs": []}, "none of the points FR, HR, FL, HL is named like a leg"),
        ({"legs": {"FR": "FR", "HR": "FR"}}, "two legs are the one point 'FR'"),
        ({"legs": ["FR", "FR"]}, "with one of them twice"),
        ({"fps": "250"}, "fps is '250'; expected"),
        ({"fps": float("inf")}, "expected"),
    ],
)
def test_what_is_no_list_of_inputs_animals_or_legs_is_one_sentence(results, arguments, message):
    with pytest.raises(InputError) as caught:
        run_gait(**{"inputs": [results], "figures": "none", **arguments})
    assert message in str(caught.value)


def test_one_trial_given_twice_is_refused(results):
    """Its strides would count twice."""
    with pytest.raises(InputError, match=r"tracks.nc is named twice"):
        run_gait([results, results], figures="none")
