"""Which files are said to be of one recording, of one animal, or to lack their unit."""

from __future__ import annotations

import shutil

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from trotting import FPS, walking_tracks

from pawnb.errors import InputError
from pawnb.io.native import write_tracks
from pawnb.schema import make_tracks
from pawnb.synthetic import write_deeplabcut_sample
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.notes.source_notes import _same_recordings
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.gait.sources import read_source


@pytest.fixture
def sample(tmp_path):
    write_deeplabcut_sample(tmp_path / "s", animals=2)
    return tmp_path / "s"


def notes(files, out, **options):
    run = run_gait(files, out=out, figures="none", **options)
    return run, [str(note) for note in run.tables.notes]


@pytest.mark.slow
def test_two_files_of_one_recording_are_refused_by_name_and_told_by_what_they_hold(sample):
    one, two = sample / "m01DLC.csv", sample / "m02DLC.csv"
    smooth = sample / "m01DLC_resnet50_May1shuffle1_1000_filtered.csv"
    shutil.copy(one, smooth)
    with pytest.raises(InputError, match=r"m01DLC.csv and .*_filtered.csv are both trial 'm01' of"):
        run_gait([one, two, smooth], fps=200.0, out=sample / "out", figures="none")
    # as another program would call it, and with decimals cut off
    lines = one.read_text().splitlines()
    rounded = [",".join(cell[:6] for cell in line.split(",")) for line in lines[3:]]
    (sample / "again.csv").write_text("\n".join([*lines[:3], *rounded]) + "\n")
    _, said = notes([one, two, sample / "again.csv"], sample / "out", fps=200.0)
    same = [note for note in said if "hold the same tracks" in note]
    assert len(same) == 1
    assert same[0].startswith("m01DLC.csv (m01) and again.csv (again) hold the same tracks")


@pytest.mark.slow
def test_of_many_copies_of_one_recording_there_is_one_sentence(tmp_path):
    tracks = walking_tracks("t1", "m1").isel(time=slice(0, 100))
    other = tracks.copy(deep=True)
    other["position"] += np.linspace(0.0, 90.0, 100)[:, None, None, None]
    for name, one in {"a": tracks, "x": other, "b": tracks, "c": tracks}.items():
        write_tracks(one, tmp_path / f"{name}.nc")
    sources = [read_source(tmp_path / f"{name}.nc") for name in "axbc"]
    (said,) = _same_recordings(sources)
    assert said.startswith(
        "a.nc (t1), b.nc (t1) and c.nc (t1) hold the same tracks and count as 3 "
    )


@pytest.mark.slow
def test_the_first_lines_count_animals_and_not_strides(sample):
    """m02 is given half of its frame rate, and repeats: most strides are at half the frequency."""
    rows = ["file,animal,fps", "m01DLC.csv,m01,200", "m02DLC.csv,m02,100"]
    rows += [f"m02-{k}DLC.csv,m02,100" for k in range(2)]
    for k in range(2):
        shutil.copy(sample / "m02DLC.csv", sample / f"m02-{k}DLC.csv")
    (sample / "study.csv").write_text("\n".join(rows) + "\n")
    run = run_gait(sample / "study.csv", out=sample / "out", figures="none")
    own = run.tables.strides.groupby("animal")["frequency_hz"].median()
    assert own["m01"] == pytest.approx(2 * own["m02"], rel=0.05)
    middle = f"{own.mean():.2f} (animals: {own['m02']:.2f} to {own['m01']:.2f}) Hz"
    assert f"median stride frequency {middle}" in run.text()


@pytest.mark.slow
def test_animals_of_several_files_with_several_are_named_apart(real_data, tmp_path):
    files = [tmp_path / f"{name}DLC.csv" for name in ("v1", "v2")]
    for file in files:
        shutil.copy(real_data("peer-files") / "dlc_multi.csv", file)
    run, said = notes(files, tmp_path / "a", fps=100.0)
    who = run.tables.events[["animal", "trial"]].drop_duplicates().to_numpy().tolist()
    assert who == [[m, v] for v in ("v1", "v2") for m in ("mouse1", "mouse2")]
    assert any(note.startswith("mouse1, mouse2: in several files, and counted") for note in said)
    run, said = notes(files, tmp_path / "b", fps=100.0, animals=["a+b", "c+d"])
    assert run.tables.events["animal"].unique().tolist() == ["a", "b", "c", "d"]
    assert not any("in several files" in note for note in said)
    for wrong in ("a", "a+a", "a+"):
        with pytest.raises(InputError, match=r"have 2 animals, mouse1, mouse2; name each once"):
            run_gait(files, fps=100.0, out=tmp_path / "c", animals=[wrong, "c+d"])


@pytest.mark.slow
def test_a_unit_that_a_file_does_not_say_is_said_to_be_taken_and_can_be_told(real_data, tmp_path):
    file = real_data("peer-files") / "anipose_3d.csv"
    taken = "lengths of anipose_3d.csv are taken to be in mm"
    run = run_gait([file], fps=100.0, out=tmp_path / "a", figures="none")
    assert [note for note in run.tables.notes if taken in str(note)]
    (tmp_path / "trial.toml").write_text(
        '[trial]\nname = "t"\nkind = "tracks"\nfps = 100\n[animal]\nid = "t"\nspecies = "mouse"\n'
        f'[tracks]\nfile = "{file}"\n[calibration]\nunit = "m"\n'
    )
    told = run_gait([tmp_path], out=tmp_path / "b", figures="none")
    assert not [note for note in told.tables.notes if "are taken to be" in str(note)]
    assert any(" m/s" in str(note) for note in told.tables.notes)


@pytest.mark.slow
def test_what_makes_trials_unlike_is_said_and_what_all_share_once(tmp_path):
    files = write_deeplabcut_sample(tmp_path / "s", animals=5, seconds=1.5)
    lines = files[1].read_text().splitlines()
    last = {k for k, name in enumerate(lines[1].split(",")) if name == "hindpaw_L"}
    kept = [[c for k, c in enumerate(line.split(",")) if k not in last] for line in lines]
    files[1].write_text("\n".join(",".join(cells) for cells in kept) + "\n")
    rows = ["file,animal,group,fps"]
    for k, file in enumerate(files):
        rows.append(f"{file.name},m{k},{'ab'[k > 2]},{200 - 50 * (k > 2)}")
    (tmp_path / "s" / "study.csv").write_text("\n".join(rows) + "\n")
    run, said = notes(tmp_path / "s" / "study.csv", tmp_path / "out")
    assert "HL has no event in m02: what is said of it counts 4 of 5 animals." in said
    # that of the trial which lacks it is not on the pages of other animals
    assert any(note.startswith("m02: legs were guessed from the names") for note in said)
    assert any("(a at 200, b at 150 frames a second)" in note for note in said)
    # in the first lines what is said of every trial stands once; in notes.csv of each
    low = "positions with a confidence below 0.6 count as missing."
    assert run.text().count(low) == 1
    assert f"m01: {low} The like is said of 4 more trials (notes.csv)." in run.text()
    assert (tmp_path / "out" / "notes.csv").read_text().count(low) == 5


@pytest.mark.slow
def test_a_leg_without_a_place_in_space_is_named_with_what_to_do(tmp_path):
    walk = walking_tracks("t1", "m1")
    frames, points = walk["frame"].to_numpy(), [str(p) for p in walk["keypoint"].to_numpy()]
    tracks = make_tracks(frames, points, fps=FPS, individual="m1", unit="mm", views=["cam1"])
    tracks["position"][:] = walk["position"].to_numpy()
    tracks["confidence"][:] = 1.0
    tracks["position"][:, :, 3] = np.nan
    tracks["image_position"][:] = np.random.default_rng(0).normal(
        100.0, 9.0, tracks["image_position"].shape
    )
    tracks["image_confidence"][:] = 1.0
    write_tracks(tracks, tmp_path / "tracks.nc")
    with pytest.raises(InputError, match=rf"in space there is no place of {points[3]},") as error:
        run_gait(tmp_path / "tracks.nc", figures="none")
    kept = str(error.value).partition("--legs ")[2].partition(")")[0].split()
    run = run_gait(tmp_path / "tracks.nc", figures="none", legs=kept)
    assert set(run.tables.strides["leg"]) == set(kept)


def bare_tracks():
    """Tracks of a trot that do not say of what trial they are."""
    tracks = walking_tracks("t", "m")
    tracks.attrs.pop("trial")
    return tracks


@pytest.mark.slow
def test_pieces_of_one_track_are_told_as_they_would_count_as_animals(tmp_path):
    both = bare_tracks().isel(individual=[0, 0]).copy(deep=True)
    both = both.assign_coords(individual=["track_0", "track_1"])
    file = write_tracks(both, tmp_path / "whole.nc")
    assert not any("never seen in one frame" in note for note in notes(file, tmp_path / "a")[1])
    half = both.sizes["time"] // 2
    both["position"].data[half:, ..., 0] = np.nan
    both["position"].data[:half, ..., 1] = np.nan
    _, said = notes(write_tracks(both, tmp_path / "pieces.nc"), tmp_path / "b")
    assert any("pieces.nc: track_0 and track_1 are never seen in one frame" in n for n in said)


@pytest.mark.slow
def test_rows_that_are_no_frames_of_the_film_are_told(tmp_path):
    tracks = bare_tracks()
    table = tracks["position"].isel(individual=0)
    columns = {
        f"{leg}_{axis}": table.sel(keypoint=leg, space=axis).to_numpy()
        for leg in map(str, table["keypoint"].to_numpy())
        for axis in "xy"
    }
    ms = np.arange(tracks.sizes["time"]) * 5  # 200 frames a second, counted in ms
    pd.DataFrame({"frame": ms, **columns}).to_csv(tmp_path / "ms.csv", index=False)
    _, said = notes(tmp_path / "ms.csv", tmp_path / "a", fps=200.0)
    assert any("ms.csv: its rows are 5 frames apart, 40 a second of 200" in note for note in said)
    rows = [["scorer", *["me"] * 8], ["bodyparts", *[name[:2] for name in columns]]]
    rows += [["coords", *"xy" * 4]]
    places = np.stack(list(columns.values()), axis=1)
    rows += [[f"labeled-data/m/img{k:03d}.png", *row] for k, row in enumerate(places)]
    labels = tmp_path / "CollectedData_me.csv"
    labels.write_text("\n".join(",".join(map(str, row)) for row in rows))
    _, said = notes(labels, tmp_path / "b", fps=200.0)
    assert any("CollectedData_me.csv holds labels of single pictures" in note for note in said)
    assert not any("frames apart" in note for note in said)


@pytest.mark.slow
def test_points_of_views_are_in_px_and_nothing_is_said_of_mm(sample):
    file = sample / "m01DLC.csv"
    text = '[trial]\nkind = "tracks"\nname = "t"\nfps = 200.0\n[animal]\nid = "m01"\n[tracks]\n'
    (sample / "trial.toml").write_text(f'{text}file = {{ side = "{file.name}" }}\n')
    _, said = notes(sample, sample / "out")
    assert any("(side)" in note for note in said)
    assert not any("taken to be in mm" in note for note in said)


@pytest.mark.slow
def test_trials_of_one_name_are_told_apart_and_names_spelt_alike_are_told(tmp_path):
    """Every animal has a day1; of one its left hind paw was not labelled."""
    files = write_deeplabcut_sample(tmp_path / "s", animals=4, seconds=1.5)
    lines = files[1].read_text().splitlines()
    last = {k for k, name in enumerate(lines[1].split(",")) if name == "hindpaw_L"}
    kept = [[c for k, c in enumerate(line.split(",")) if k not in last] for line in lines]
    files[1].write_text("\n".join(",".join(cells) for cells in kept) + "\n")
    rows = ["file,animal,name,group,fps"]
    whose = (("m1", "control"), ("m2", "Control"), ("M-2", "lesion"), ("m3", ""))
    for file, (animal, group) in zip(files, whose, strict=True):
        rows.append(f"{file.name},{animal},day1,{group},200")
    (tmp_path / "s" / "study.csv").write_text("\n".join(rows) + "\n")
    run, said = notes(tmp_path / "s" / "study.csv", tmp_path / "out")
    assert any(note.startswith("HL has no event in m2 day1: what is said") for note in said)
    guessed = [note for note in said if "legs were guessed from the names" in note]
    assert [note.partition(": ")[0] for note in guessed] == [f"{a} day1" for a, _ in whose]
    where = pd.read_csv(tmp_path / "out" / "notes.csv")["where"]
    assert {"m1 day1", "m2 day1"} <= set(where)
    assert "day1" not in set(where)
    assert any(
        note.startswith("m2 and M-2 count as 2 animals: where they are one") for note in said
    )
    assert any(note.startswith("control and Control count as 2 groups: ") for note in said)
    assert any(note.startswith("no group is given for m3 day1: left out where") for note in said)
    drawings = gait_drawings(run.tables, notes=run.tables.notes)
    page = next(one for one in drawings if one.name == "summary_m3")
    whole = page.draw()[1].get_figure(root=True)
    told = " ".join(text.get_text() for text in whole.findobj(Text))
    assert "m3 day1: " in told
    assert "m1 day1: " not in told
