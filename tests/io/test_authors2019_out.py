"""The four files of a trial of the 2019 authors, written: theirs come back without a change."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.io.authors2019 import list_authors_trials, read_authors_trial
from pawnb.io.authors2019_out import write_authors_trial
from pawnb.io.formats import read_any_tracks, recognise_format, write_any_tracks
from pawnb.schema import ORIGIN_CODE, make_tracks

NAME = "cam1.f.rat9.Week1.2020-01-02_03_04_05.csv"
FILES = [NAME.replace("cam1.f", f"cam{cam}.{part}") for cam in (1, 3) for part in "fh"]


def trial(**more):
    """Feet only: FL in the left views, HR in the right, a frame without a row."""
    tracks = make_tracks(
        [3, 4, 6, 7], ["FL", "HR"], fps=250.0, views=["cam1", "cam2", "cam3", "cam4"],
        individual="rat9", **more,
    )  # fmt: skip
    for views, point, u in ((slice(0, 2), 0, 100.5), (slice(2, 4), 1, 300.25)):
        tracks["image_position"][:, views, 0, point] = u
        tracks["image_position"][:, views, 1, point] = 50.125
        tracks["image_origin"][:, views, point] = ORIGIN_CODE["measured"]
    return tracks


def test_files_are_laid_out_as_the_authors_published_theirs(tmp_path):
    """The header of ``cam1.f.rat2.Week0.2018-06-08_13_30_12.csv``, and their pictures of cameras
    3 and 4, 2048 px wide, that are mirrored: X = 2047 - u."""
    written = write_any_tracks(trial(), tmp_path / NAME, program="authors2019")
    assert [path.name for path in written] == FILES
    assert sorted(path.name for path in tmp_path.iterdir()) == FILES
    lines = (tmp_path / NAME).read_text().split("\n")
    assert lines[1] == "Number of markers 3"
    assert lines[5] == (
        "Frames,First Camera Frames Name,Second Camera Frames Name,Y Coordinate M,X Coordinate M,"
        "Y Coordinate M2,X Coordinate M2,Y Coordinate N,X Coordinate N,Y Coordinate N2,"
        "X Coordinate N2,Y Coordinate O,X Coordinate O,Y Coordinate O2,X Coordinate O2"
    )
    assert lines[6] == "3,,,,,,,,,,,50.125,100.5,50.125,100.5"
    hind = pd.read_csv(tmp_path / FILES[3], skiprows=5)
    assert hind["Frames"].tolist() == [3, 4, 6, 7]
    assert (hind[["X Coordinate Q", "X Coordinate Q2"]] == 2047 - 300.25).all(axis=None)
    assert hind[["X Coordinate M", "Y Coordinate P2"]].isna().all(axis=None)


def test_what_was_written_is_read(tmp_path):
    write_any_tracks(trial(), tmp_path / NAME, program="authors2019")
    assert recognise_format(tmp_path / NAME) == "authors2019"
    found = read_any_tracks(tmp_path / NAME, fps=250.0)
    assert found["frame"].to_numpy().tolist() == [3, 4, 5, 6, 7]
    assert found["individual"].item() == "rat9"
    at = found.sel(keypoint=["FL", "HR"]).isel(time=[0, 1, 3, 4])
    np.testing.assert_array_equal(at["image_position"], trial()["image_position"])
    assert np.isnan(found["image_position"].isel(time=2)).all()


@pytest.mark.slow
def test_their_own_trials_come_back(real_data, tmp_path):
    folder = real_data("rat-4cam-tracks")
    stamps = list_authors_trials(folder)
    assert len(stamps) == 4
    for stamp in stamps:
        theirs = read_authors_trial(folder, stamp, row_px=None)
        name = next(folder.glob(f"cam1.f.*{stamp}.csv")).name
        assert len(write_authors_trial(theirs, tmp_path / name)) == 4
        ours = read_authors_trial(tmp_path, stamp, row_px=None)
        np.testing.assert_allclose(
            ours["image_position"], theirs["image_position"], rtol=0, atol=5e-13
        )
        np.testing.assert_array_equal(ours["image_origin"], theirs["image_origin"])


@pytest.mark.parametrize(
    ("change", "name", "message"),
    [
        (lambda t: t, "cam1.csv", r"^cam1\.csv: the 2019 authors name a file cam1\.f"),
        (lambda t: t.assign_coords(view=["a", "cam2", "cam3", "cam4"]), NAME, "these tracks a;"),
        (lambda t: t.assign_coords(keypoint=["FL", "tail"]), NAME, "no marker 'tail'; they have"),
        (
            lambda t: t.assign_coords(keypoint=["FR", "HR"]),
            NAME,
            "FR was tracked in cam1, where the 2019 authors have the left legs only",
        ),
    ],
)
def test_what_has_no_column_is_refused(tmp_path, change, name, message):
    with pytest.raises(InputError, match=message):
        write_any_tracks(change(trial()), tmp_path / name, program="authors2019")
    assert not list(tmp_path.iterdir())


def test_what_was_predicted_in_views_of_the_other_side_has_no_column(tmp_path):
    tracks = trial()
    tracks["image_position"][:, 2, :, 0] = 700.0
    tracks["image_origin"][:, 2, 0] = ORIGIN_CODE["predicted"]
    write_any_tracks(tracks, tmp_path / NAME, program="authors2019")
    found = read_any_tracks(tmp_path / NAME, fps=250.0)
    assert np.isnan(found["image_position"].sel(view="cam3", keypoint="FL")).all()
