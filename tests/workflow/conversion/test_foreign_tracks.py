"""Trials of kind ``tracks``: what trial.toml says about a file made elsewhere is done to it."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.trial import Animal, Calibration, Trial, load_trial
from pawnb.workflow.conversion.foreign_tracks import files_of_tracks, read_foreign_tracks
from pawnb.workflow.gait.run import run_gait

VIEWS = "".join(f'[[views]]\nname = "cam{i}"\nvideo = "cam{i}.avi"\n' for i in (1, 2, 3, 4))


def trial_of(folder, file, *, head="", calibration="", views=""):
    (folder / "trial.toml").write_text(
        f'[trial]\nkind = "tracks"\nname = "made"\nfps = 100.0\n{head}\n[animal]\nid = "a"\n{views}'
        f'{calibration}\n[tracks]\nfile = "{file}"\n'
    )
    return load_trial(folder)


def write_points(folder):
    """Write points of one view, as a table of points side by side."""
    frame = np.arange(30)
    columns = {"frame": frame}
    for i, leg in enumerate(("FR", "HR", "FL", "HL")):
        columns |= {f"{leg}_x": 100.0 + 2 * frame + i, f"{leg}_y": 40.0 + i}
    pd.DataFrame(columns).to_csv(folder / "points.csv", index=False)


def test_frames_of_the_trial_are_used(tmp_path):
    write_points(tmp_path)
    tracks = read_foreign_tracks(trial_of(tmp_path, "points.csv", head="frames = [5, 12]"))
    assert tracks["frame"].to_numpy().tolist() == list(range(5, 12))
    with pytest.raises(InputError, match=r"frames 0 to 29, none of \[trial\] frames = \[40, 50\]"):
        read_foreign_tracks(trial_of(tmp_path, "points.csv", head="frames = [40, 50]"))


def test_px_per_unit_gives_real_units(tmp_path):
    write_points(tmp_path)
    trial = trial_of(
        tmp_path, "points.csv", calibration='[calibration]\npx_per_unit = 4.0\nunit = "cm"'
    )
    tracks = read_foreign_tracks(trial)
    assert tracks.attrs["units"] == tracks["position"].attrs["units"] == "cm"
    # FR is at u = 100 px in frame 0
    assert float(tracks["position"].sel(keypoint="FR", space="x")[0, 0]) == 25.0


@pytest.mark.parametrize("views", ["", VIEWS], ids=["views of the file", "views of the trial"])
def test_points_of_calibrated_views_are_triangulated(rendered_trial, tmp_path, views):
    # without points3d.csv beside it, tracks.csv holds places in the pictures only
    truth = rendered_trial / "truth"
    shutil.copy(truth / "tracks.csv", tmp_path)
    shutil.copy(rendered_trial / "DLTcoefs.csv", tmp_path)
    trial = trial_of(
        tmp_path, "tracks.csv", views=views,
        calibration='[calibration]\ndlt = "DLTcoefs.csv"\nunit = "mm"',
    )  # fmt: skip
    tracks = read_foreign_tracks(trial)
    assert tracks.attrs["units"] == "mm"
    # the truth of the renderer in space; places in pictures are written to 0.0001 px
    true = pd.read_csv(truth / "points3d.csv").query("point == 'FR'")
    for i, axis in enumerate("xyz"):
        found = tracks["position"].sel(keypoint="FR")[:, i, 0]
        np.testing.assert_allclose(found, true[axis], atol=0.01)


def test_the_unit_of_points_in_space_is_the_trials(tmp_path):
    (tmp_path / "points3d.csv").write_text(
        "frame,point,x,y,z,residual_px,origin\n0,FR,1,2,3,0.5,measured\n"
    )
    trial = trial_of(tmp_path, "points3d.csv", calibration='[calibration]\nunit = "cm"')
    assert read_foreign_tracks(trial).attrs["units"] == "cm"


def test_every_file_that_was_read_is_in_the_record(rendered_trial, tmp_path):
    shutil.copy(rendered_trial / "truth" / "tracks.csv", tmp_path)
    shutil.copy(rendered_trial / "DLTcoefs.csv", tmp_path)
    (tmp_path / "belt.csv").write_text("frame,speed\n0,300\n500,300\n")
    trial_of(
        tmp_path, "tracks.csv",
        calibration='[treadmill]\nbelt_speed = "belt.csv"\n[calibration]\ndlt = "DLTcoefs.csv"',
    )  # fmt: skip
    run_gait([tmp_path], figures="none")
    record = json.loads((tmp_path / "results" / "provenance.json").read_text())
    names = {name.rpartition("/")[2] for name in record["steps"][0]["inputs"]}
    # trial.toml holds settings of the analysis
    assert names == {"trial.toml", "tracks.csv", "DLTcoefs.csv", "belt.csv"}


def test_files_of_the_2019_authors_are_all_in_the_record(real_data):
    folder = real_data("rat-4cam-tracks")
    stamp = "2018-06-08_13_42_28"
    tail = f"rat2.week0.{stamp}.csv"
    trial = Trial(
        kind="tracks", name="r", fps=250.0, animal=Animal(id="rat2"), folder=folder,
        tracks_file=f"cam1.f.{tail}", belt_speed=f"speed_time.{tail}",
        calibration=Calibration(dlt=f"DLT.{tail}"),
    )  # fmt: skip
    names = [path.name for path in files_of_tracks(trial)]
    # two cameras, front and hind each, and what belongs to them
    assert len(names) == 6
    assert all(stamp in name for name in names)
