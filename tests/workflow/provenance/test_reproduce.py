"""What a file carries is enough to make it again: elsewhere, in another process, byte for byte."""

from __future__ import annotations

import json
import ntpath
import os
import shutil
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb import figures, synthetic
from pawnb.cli import main
from pawnb.core.edits.log import EditLog
from pawnb.core.edits.records import Move
from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.gait.events.event_edits import EventEdits, ExcludeStride
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.trial import Animal, Calibration, Trial
from pawnb.widgets import PoseReviewer
from pawnb.workflow import save_figures
from pawnb.workflow.evaluation.compare import draw_comparison
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.provenance import labels
from pawnb.workflow.provenance.find_inputs import find_inputs
from pawnb.workflow.provenance.labels import label_inputs
from pawnb.workflow.provenance.recipes import read_recipe
from pawnb.workflow.provenance.record import file_checksum
from pawnb.workflow.provenance.reproduce import made_files, reproduce_all
from pawnb.workflow.provenance.results import (
    describe_trial,
    provenance_steps,
    write_track_results,
)
from pawnb.workflow.tracking.trial_views import trial_rig

FPS = 200.0


def trotting(trial: str, animal: str, *, lag: float = 0.5, seen: bool = False) -> object:
    """Two seconds at five strides a second on a belt, left and right half a stride apart.

    ``seen``: hind legs, too, and a camera from the side, 4 px a mm.
    """
    frames = np.arange(400)
    lags = {"FR": 0.0, "FL": lag} | ({"HR": lag, "HL": 0.0} if seen else {})
    tracks = make_tracks(frames, tuple(lags), fps=FPS, individual=animal, unit="mm",
                         views=["right"] if seen else ())  # fmt: skip
    for k, shift in enumerate(lags.values()):
        phase = (frames / FPS * 5.0 - shift) % 1.0
        swing = np.clip((phase - 0.6) / 0.4, 0, 1)
        back, forth = 30.0 * (0.5 - phase / 0.6), -15.0 * np.cos(np.pi * swing)
        tracks["position"][:, 0, k, 0] = np.where(phase < 0.6, back, forth)
        tracks["position"][:, 1, k, 0] = 10.0 * k
        tracks["position"][:, 2, k, 0] = np.where(phase < 0.6, 0, 8 * np.sin(np.pi * swing))
    if seen:
        tracks["image_position"].data[:, 0, 0] = 300.0 + 4.0 * tracks["position"].data[:, 0]
        tracks["image_position"].data[:, 0, 1] = 200.0 - 4.0 * tracks["position"].data[:, 2]
        tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 1.0
    described = Trial(
        kind="tracks", name=trial, fps=FPS, animal=Animal(id=animal), belt_speed=250.0,
        calibration=Calibration(unit="mm"), tracks_file="tracks.nc",
    )  # fmt: skip
    return describe_trial(tracks, described)


@pytest.fixture
def study(tmp_path):
    """Two animals' results, a correction of an event in one of them."""
    folders = []
    for name in ("m1", "m2"):
        folder = tmp_path / "study" / name / "results"
        folder.mkdir(parents=True)
        write_tracks(trotting(f"{name}-1", name), folder / "tracks.nc")
        folders.append(folder)
    found = run_gait(folders[0], figures="none")
    edits = EventEdits(found.tables, folders[0] / "event_edits.jsonl")
    first = found.tables.strides.iloc[1]
    who = {"animal": "m1", "trial": "m1-1", "leg": first["leg"]}
    edits.apply(ExcludeStride(**who, start_s=first["start_s"], reason="stumbled"))
    return folders


@pytest.mark.slow
def test_tables_are_made_again_with_corrections_wherever_they_lie(study, tmp_path, monkeypatch):
    out = tmp_path / "study" / "pooled"
    run = run_gait(study, out=out, figures="none", groups=["a", "b"], command=["pawnb", "gait"])
    assert "excluded by hand: stumbled" in (out / "dropped.csv").read_text()
    moved = tmp_path / "elsewhere" / "deeper"
    shutil.move(tmp_path / "study", moved)
    monkeypatch.chdir(tmp_path)
    tables = [moved / "pooled" / file.name for file in run.files if file.suffix == ".csv"]
    found = reproduce_all(tables)
    assert [one.text() for one in found] == [f"{path}: identical" for path in tables]


@pytest.mark.slow
def test_what_differs_is_said(study, tmp_path):
    out = study[0]
    run_gait(out, figures="none")
    table = pd.read_csv(out / "strides.csv")
    table.loc[2, "period_s"] += 0.25
    table.to_csv(out / "strides.csv", index=False)
    found = pawnb.reproduce(out / "strides.csv")
    assert not found.identical
    assert "period_s in 1 of" in found.text()
    assert "by 0.25 at most" in found.text()
    assert main(["reproduce", str(out / "strides.csv")]) == 3
    assert main(["reproduce", str(out / "phases.csv")]) == 0


@pytest.mark.slow
def test_an_input_that_changed_or_is_gone_is_one_sentence(study, tmp_path, capsys):
    out = study[1]
    run_gait(out, figures="none")
    write_tracks(trotting("m2-1", "m2", lag=0.4), out / "tracks.nc")
    assert main(["reproduce", str(out / "strides.csv")]) == 2
    said = capsys.readouterr().err
    assert f"{out / 'tracks.nc'} has changed since strides.csv was made of it" in said
    assert said.count("\n") == 1
    (out / "tracks.nc").unlink()
    with pytest.raises(InputError, match=r"results/tracks\.nc, of which .* is not there.*; name"):
        pawnb.reproduce(out / "strides.csv")
    with pytest.raises(InputError, match=r"no such folder; name the one that holds"):
        pawnb.reproduce(out / "strides.csv", inputs=tmp_path / "no")


@pytest.mark.slow
def test_a_folder_of_which_files_are_gone_is_made_again_as_far_as_it_can_be(study, capsys):
    """It ended at the first: a figure that was put away, and nothing was made."""
    out = study[1]
    run_gait(out, figures="none")
    (out / "phases.csv").unlink()
    (out / "methods.txt").unlink()
    n = len(made_files(out))
    assert main(["reproduce", str(out)]) == 2
    told = capsys.readouterr()
    assert f"{out / 'strides.csv'}: identical" in told.out
    assert f"{out / 'phases.csv'}: not made again" in told.out
    assert f"{n - 2} of {n} identical" in told.out
    assert told.err.count("\n") == 1
    assert f"2 of {n} files could not be made again: methods.txt, phases.csv: no such" in told.err
    (out / "tracks.nc").unlink()
    assert main(["reproduce", str(out), str(study[0] / "tracks.nc")]) == 2
    told = capsys.readouterr()
    assert "strides.csv: not made again" in told.out
    assert "results/tracks.nc, of which" in told.err
    assert "tracks.nc: nothing says how this file was made" in told.err


def test_every_input_that_has_changed_or_is_gone_is_named(tmp_path):
    (tmp_path / "a.csv").write_text("right")
    sums = {name: file_checksum(tmp_path / "a.csv") for name in ("a.csv", "b.csv", "c.csv")}
    (tmp_path / "a.csv").write_text("wrong")
    with pytest.raises(InputError) as said:
        find_inputs(sums, [tmp_path], of="strides.csv")
    assert "a.csv has changed since strides.csv was made of it" in str(said.value)
    assert "b.csv and c.csv, of which strides.csv was made, are not there; name" in str(said.value)


@pytest.mark.parametrize("name", ["x.csv", "x.png", "x.svg", "x.pdf"])
def test_files_without_a_recipe_are_refused(tmp_path, name):
    path = tmp_path / name
    if name == "x.png":
        from PIL import Image

        Image.new("RGB", (2, 2)).save(path)
    else:
        path.write_text("%PDF-1.4\n" if name == "x.pdf" else "<svg/>")
    with pytest.raises(InputError, match="nothing says how this file was made") as told:
        pawnb.reproduce(path)
    assert ("where pawnb.draw_figure saves them" in str(told.value)) == (name != "x.csv")
    with pytest.raises(InputError, match="no such file"):
        pawnb.reproduce(tmp_path / "none.png")


def test_the_three_formats_carry_the_same_recipe_whatever_signs_it_has(tmp_path):
    """Brackets, backslashes, quotes, angle brackets and letters that are no Latin-1."""
    import matplotlib.pyplot as plt

    record = {
        "step": "gait", "inputs": {r"a (b) \c <d> & 'e' \"f\" ü Ω/tracks.nc": "sha256:0"},
        "figure": "one", "name": "one",
    }  # fmt: skip
    _, ax = plt.subplots()
    files = save_figures.save_figure(ax, tmp_path / "one", record=record)
    for file in files:
        assert read_recipe(file).step == {"step": "gait", "inputs": record["inputs"]}, file.suffix


def test_labels_tell_inputs_of_one_name_apart_and_hold_no_absolute_path(tmp_path):
    paths = [tmp_path / name / "results" / "tracks.nc" for name in ("a", "b")]
    assert list(label_inputs(paths).values()) == ["a/results/tracks.nc", "b/results/tracks.nc"]
    assert list(label_inputs(paths[:1]).values()) == ["results/tracks.nc"]
    assert label_inputs([]) == {}


class _OnADrive(PureWindowsPath):
    """A path of Windows that needs no Windows to be resolved."""

    def resolve(self):
        return self


def _labels_on_drives(monkeypatch, *paths):
    monkeypatch.setattr(labels.os, "path", ntpath)
    return list(label_inputs([_OnADrive(path) for path in paths]).values())


def test_labels_tell_inputs_on_several_drives_apart(monkeypatch):
    """Results of every trial are called tracks.nc; one stood for all of them in the record."""
    two = _labels_on_drives(monkeypatch, r"D:\lab\m1\results\tracks.nc", r"E:\m2\results\tracks.nc")
    assert two == ["m1/results/tracks.nc", "m2/results/tracks.nc"]
    copies = _labels_on_drives(monkeypatch, r"D:\m1\tracks.nc", r"\\pc\films\m1\tracks.nc")
    assert copies == ["d/m1/tracks.nc", "films/m1/tracks.nc"]
    other = _labels_on_drives(monkeypatch, r"D:\m1\tracks.nc", r"E:\m1\events.csv")
    assert other == ["m1/tracks.nc", "m1/events.csv"]


def test_inputs_are_told_by_their_checksums_though_folders_were_renamed(tmp_path):
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "tracks.nc").write_text("right")
    sums = {"old/tracks.nc": file_checksum(tmp_path / "new" / "tracks.nc")}
    found = find_inputs(sums, [tmp_path / "new", tmp_path], of="x.png")
    assert found == {"old/tracks.nc": tmp_path / "new" / "tracks.nc"}


def test_inputs_are_found_in_a_folder_of_data_beside_the_results(tmp_path):
    """As of ``pawnb gait data/*/*.csv --out results``, whose labels begin below ``data``."""
    data = tmp_path / ("data [a]" if os.name == "nt" else "data [a] *") / "day 1" / "x.csv"
    data.parent.mkdir(parents=True)
    data.write_text("right")
    places = list((tmp_path / "results" / "strides.csv").parents)
    sums = {"day 1/x.csv": file_checksum(data)}
    assert find_inputs(sums, places, of="strides.csv") == {"day 1/x.csv": data}
    data.write_text("wrong")
    with pytest.raises(InputError, match=r"is not there \(.*x\.csv has another content\); name"):
        find_inputs(sums, places, of="strides.csv")


def _in_another_process(files, tmp_path, *options):
    """Make files again in a fresh process and another folder; return what it said."""
    elsewhere = tmp_path / "cwd"
    elsewhere.mkdir(exist_ok=True)
    words = [sys.executable, "-m", "pawnb", "reproduce", *map(str, files), *options]
    root = str(Path(pawnb.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": root}
    return subprocess.run(
        words, cwd=elsewhere, capture_output=True, text=True, check=False, env=environment
    )


@pytest.mark.slow
def test_every_figure_of_a_run_is_identical_elsewhere_and_in_another_process(tmp_path):
    """Spiders with joints and paths in space, sizes, two groups, other species; and a mouse."""
    made = synthetic.simulate_spider_study(animals=3, trials=1, seed=3)
    study = ["[[species]]", 'file = "others.csv"', 'name = "own"', 'group = "Lycosidae"']
    for animal, group in zip(made.animals.itertuples(), ("a", "a", "b"), strict=True):
        sizes = f"mass_g = {animal.mass_g}\nbody_length_mm = {animal.body_length_mm}"
        study += ["[[animals]]", f'id = "{animal.animal}"', f'group = "{group}"', sizes]
    for run in made.runs:
        folder = tmp_path / "study" / run.trial.name
        folder.mkdir(parents=True)
        write_tracks(describe_trial(run.tracks(), run.trial), folder / "tracks.nc")
        study += ["[[trials]]", f'file = "{folder.name}"', f'animal = "{run.trial.animal.id}"']
    others = [f"s{k},Lycosidae,{10.0 * k},{7.0 * k}" for k in (1, 2, 4)]
    table = "\n".join(["name,group,mass_g,speed_cm_s", *others])
    (tmp_path / "study" / "others.csv").write_text(table)
    (tmp_path / "study" / "study.toml").write_text("\n".join(study))
    out = tmp_path / "study" / "gait"
    mouse = tmp_path / "study" / "mouse" / "results"
    mouse.mkdir(parents=True)
    write_tracks(trotting("t1", "m1", seen=True), mouse / "tracks.nc")
    with figures.style(dpi=60):  # a seventh of the time
        run_gait(tmp_path / "study" / "study.toml", out=out)
        run_gait(mouse)
    moved = shutil.move(tmp_path / "study", tmp_path / "moved")
    files = sorted((Path(moved) / "gait" / "figures").iterdir())
    kinds = {read_recipe(f).step["step"] for f in files if f.suffix != ".csv"}
    assert kinds == {"gait"}
    drawn = {file.stem for file in files}
    assert drawn > {
        "species_others",
        "against_mass_g",
        "against_body_length_mm",
        "estimation_speed",
    }
    of_mouse = Path(moved) / "mouse" / "results" / "figures"
    paws = [of_mouse / f"{name}.{ending}" for name in ("hildebrand_diagram", "template_fit_m1_t1")
            for ending in ("png", "svg", "pdf", "csv")]  # fmt: skip
    done = _in_another_process([Path(moved) / "gait", *paws], tmp_path)
    assert [line for line in done.stdout.splitlines() if "differs" in line] == []
    listed = {line.removesuffix(": identical") for line in done.stdout.splitlines()}
    assert listed >= {str(file) for file in (*files, *paws)}
    assert len(files) > 40
    number = len(done.stdout.splitlines()) - 1
    assert done.stdout.splitlines()[-1] == f"{number} of {number} identical"
    assert done.returncode == 0, done.stderr
    # a figure that travels alone and was renamed; folders beside the three nearest are looked into,
    # so it lies deep enough that no other run of this test does
    far = tmp_path / "mail" / "of" / "a friend"
    far.mkdir(parents=True)
    alone = shutil.copy(Path(moved) / "gait" / "figures" / "phase_rose.pdf", far / "Fig2.pdf")
    assert _in_another_process([alone], tmp_path).returncode == 2
    assert _in_another_process([alone], tmp_path, "--inputs", moved).returncode == 0


@pytest.mark.slow
def test_tracks_and_their_tables_are_made_again(rendered_spider, tmp_path):
    trial = shutil.copytree(rendered_spider, tmp_path / "trial")
    pawnb.track(trial, out=trial / "results", frames=(8, 14))
    for name in ("tracks.nc", "pose.csv", "quality.json"):
        assert pawnb.reproduce(trial / "results" / name).identical, name
    toml = trial / "trial.toml"
    toml.write_text(toml.read_text().replace("name = ", 'name = "other" # ', 1))
    with pytest.raises(InputError, match=r"trial\.toml has changed since tracks\.csv was made"):
        pawnb.reproduce(trial / "results" / "tracks.csv")


@pytest.mark.slow
def test_corrections_of_tracks_are_made_again(small_trial):
    out = small_trial / "results"
    tracks = pawnb.track(small_trial, out=out)
    view, point = str(tracks["view"].to_numpy()[0]), str(tracks["keypoint"].to_numpy()[0])
    frame = int(tracks["frame"][5])
    trial = pawnb.load_trial(small_trial)
    with open_views(trial) as views:
        rig = trial_rig(trial, views)
    log = EditLog(tracks, out / "edits.jsonl", rig=rig)
    log.apply(Move(frame=frame, view=view, point=point, u=40.0, v=30.0))
    write_track_results(log.stamped(), out, rig=rig)
    moved = pd.read_csv(out / "tracks.csv").query("frame == @frame and view == @view")
    assert moved.set_index("point").loc[point, "u"] == 40.0
    files = [out / name for name in ("tracks.nc", "tracks.csv", "points3d.csv")]
    assert [one.text() for one in reproduce_all(files)] == [f"{f}: identical" for f in files]
    (out / "edits.jsonl").unlink()
    with pytest.raises(InputError, match=r"edits\.jsonl: no such file"):
        pawnb.reproduce(files[0])


@pytest.mark.slow
def test_tracks_saved_in_a_review_are_made_again(small_spider):
    """How often a review saved and how long it took cannot be: it was told as a difference."""
    out = small_spider / "results"
    pawnb.track(small_spider, out=out, settings={"choose_path": False})
    for frame in (13, 17):
        reviewer = PoseReviewer(small_spider, read_tracks(out / "tracks.nc"), frame=frame)
        u, v = reviewer.session.pose_at(frame).places("L2")[-1] + (9.0, -6.0)
        reviewer.edit("moved", {"frame": frame, "point": "L2", "u": u, "v": v, "whole": True})
        reviewer.edit("action", {"frame": frame, "action": "save"})
        reviewer.close()
    steps = [step["step"] for step in provenance_steps(read_tracks(out / "tracks.nc"))]
    assert steps.count("review") >= 1
    files = [out / name for name in ("tracks.nc", "tracks.csv", "pose.csv", "quality.json")]
    assert [one.text() for one in reproduce_all(files)] == [f"{f}: identical" for f in files]
    # other corrections than those that were saved are a difference
    lines = (out / "edits.jsonl").read_text().splitlines(keepends=True)
    (out / "edits.jsonl").write_text("".join(lines[:1]))
    assert not pawnb.reproduce(files[0]).identical


@pytest.mark.slow
def test_the_comparison_is_drawn_again_from_its_tables(tmp_path):
    rates = {"major_per_1000": [3.1, 8.0], "minor_per_1000": [5.0, 1 / 3],
             "major_alone_per_1000": [4.0, 9.0], "minor_alone_per_1000": [6.0, 9.0],
             "time_s_per_1000": [60.0, 40.0]}  # fmt: skip
    trials = pd.DataFrame({"trial": "1", "method": ["paper", "slic-3d"], **rates})
    errors = pd.DataFrame(
        {"trial": "1", "method": "paper", "view": "cam1", "point": ["FR", "HR"],
         "kind": ["front", "hind"], "n": 100, "mean_px": [3.0, 2.0], "sd_px": 1.0}
    )  # fmt: skip
    tables = [tmp_path / "comparison.csv", tmp_path / "reprojection.csv"]
    for path, table in zip(tables, (trials, errors), strict=True):
        table.to_csv(path, index=False)
    draw_comparison(tables, tmp_path, settings={"paper.n_superpixels": 150})
    for ending in ("png", "svg", "pdf"):
        assert pawnb.reproduce(tmp_path / f"compare_methods.{ending}").identical, ending
    tables[0].write_text(tables[0].read_text().replace("60.0", "61.0"))
    with pytest.raises(InputError, match=r"comparison\.csv has changed"):
        pawnb.reproduce(tmp_path / "compare_methods.png")
    assert json.loads(json.dumps(read_recipe(tmp_path / "compare_methods.svg").step["settings"]))
