"""Files with pixels of their own: points and coefficients are moved alike."""

from __future__ import annotations

import shutil

import numpy as np
import pandas as pd
import pytest

from pawnb.core import dlt
from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig
from pawnb.errors import CalibrationError, InputWarning
from pawnb.io import authors2019
from pawnb.io.coefs import read_coefs, write_coefs
from pawnb.trial import load_trial
from pawnb.workflow.conversion.convert import convert_tracks
from pawnb.workflow.conversion.foreign_tracks import read_foreign_tracks

POINTS = ("FR", "HR")
HEIGHT = 700


def write_trial(folder, file, *, v="down", views="", calibration='dlt = "DLTcoefs.csv"'):
    (folder / "trial.toml").write_text(
        f'[trial]\nkind = "tracks"\nname = "made"\nfps = 100.0\n{views}\n[calibration]\n'
        f'{calibration}\nunit = "mm"\nv = "{v}"\n[tracks]\nfile = "{file}"\n'
    )
    return load_trial(folder)


def write_digitised(folder, rendered_trial, *, v):
    """Points as DLTdv has them: pixels from 1, Y down (DLTdv 8) or up from the bottom edge (7).

    Points, coefficients and answers come from the rendered rig, in pawnb's pixels.
    """
    names = [f"cam{i}" for i in range(1, 5)]
    coefs = read_coefs(rendered_trial / "DLTcoefs.csv", names)
    rng = np.random.default_rng(3)
    xyz = rng.uniform(-20, 20, size=(6, 2, 3))
    uv = dlt.project(coefs, xyz)
    up = np.array([[1, 0, 1.0], [0, -1, HEIGHT], [0, 0, 1]])
    H = up if v == "up" else np.array([[1, 0, 1.0], [0, 1, 1], [0, 0, 1]])
    theirs = uv @ H[:2, :2].T + H[:2, 2]
    columns = {
        f"{p}_cam{c + 1}_{axis}": theirs[:, k, c, j]
        for k, p in enumerate(POINTS)
        for c in range(4)
        for j, axis in enumerate("XY")
    }
    pd.DataFrame(columns).to_csv(folder / "clip_xypts.csv", index=False)
    moved = np.stack([dlt.transform_image(coefs[:, i], H) for i in range(4)], axis=1)
    write_coefs(moved, folder / "DLTcoefs.csv")
    return xyz, uv


def places(tracks):
    return tracks["position"].transpose("time", "keypoint", "space", ...).to_numpy()[..., 0]


def test_points_counted_from_1_and_their_coefficients(rendered_trial, tmp_path):
    xyz, uv = write_digitised(tmp_path, rendered_trial, v="down")
    tracks = read_foreign_tracks(write_trial(tmp_path, "clip_xypts.csv"))
    np.testing.assert_allclose(places(tracks), xyz, atol=1e-8)
    image = tracks["image_position"].transpose("time", "keypoint", "view", "image_space", ...)
    np.testing.assert_allclose(image.to_numpy()[..., 0], uv, atol=1e-9)
    assert np.nanmax(tracks["residual"]) < 1e-8


def test_points_counted_upwards_need_no_video_in_space(rendered_trial, tmp_path):
    xyz, _ = write_digitised(tmp_path, rendered_trial, v="up")
    trial = write_trial(tmp_path, "clip_xypts.csv", v="up")
    with pytest.warns(InputWarning, match=r"positions in the pictures are left out. Give crop ="):
        tracks = read_foreign_tracks(trial)
    np.testing.assert_allclose(places(tracks), xyz, atol=1e-8)
    assert "image_position" not in tracks
    assert np.nanmax(tracks["residual"]) < 1e-8


def test_a_crop_says_how_high_the_picture_is(rendered_trial, tmp_path):
    xyz, uv = write_digitised(tmp_path, rendered_trial, v="up")
    views = "".join(
        f'[[views]]\nname = "cam{i}"\nvideo = ""\ncrop = [0, 0, 2048, {HEIGHT}]\n'
        for i in range(1, 5)
    )
    tracks = read_foreign_tracks(write_trial(tmp_path, "clip_xypts.csv", v="up", views=views))
    np.testing.assert_allclose(places(tracks), xyz, atol=1e-8)
    image = tracks["image_position"].transpose("time", "keypoint", "view", "image_space", ...)
    np.testing.assert_allclose(image.to_numpy()[..., 0], uv, atol=1e-9)


def test_videos_say_how_high_their_pictures_are(rendered_trial, tmp_path):
    xyz, _ = write_digitised(tmp_path, rendered_trial, v="up")
    views = ""
    for i in range(1, 5):
        shutil.copy(rendered_trial / f"cam{i}.avi", tmp_path)
        views += f'[[views]]\nname = "cam{i}"\nvideo = "cam{i}.avi"\n'
    tracks = read_foreign_tracks(write_trial(tmp_path, "clip_xypts.csv", v="up", views=views))
    np.testing.assert_allclose(places(tracks), xyz, atol=1e-8)
    assert np.isfinite(tracks["image_position"]).all()


def test_one_camera_upwards_needs_the_height(tmp_path):
    (tmp_path / "one_xypts.csv").write_text("FR_cam1_X,FR_cam1_Y\n11,21\n12,22\n")
    trial = write_trial(tmp_path, "one_xypts.csv", v="up", calibration="px_per_unit = 4.0")
    with pytest.raises(CalibrationError, match=r"one_xypts.csv counts v upwards .* give crop = "):
        read_foreign_tracks(trial)
    views = '[[views]]\nname = "cam1"\nvideo = ""\ncrop = [0, 0, 200, 100]\n'
    trial = write_trial(
        tmp_path, "one_xypts.csv", v="up", calibration="px_per_unit = 4.0", views=views
    )
    tracks = read_foreign_tracks(trial)
    # the lowest row of a picture 100 px high, 1 in the file, is v = 99
    assert tracks["image_position"].to_numpy()[0, 0, :, 0, 0].tolist() == [10.0, 79.0]


def test_coefficients_upwards_for_points_downwards_need_the_height(rendered_trial, tmp_path):
    shutil.copy(rendered_trial / "truth" / "tracks.csv", tmp_path)
    shutil.copy(rendered_trial / "DLTcoefs.csv", tmp_path)
    with pytest.raises(CalibrationError, match=r"'cam1': the size .* or give crop = \[0, 0, width"):
        read_foreign_tracks(write_trial(tmp_path, "tracks.csv", v="up"))


def test_a_digitised_point_is_kept_and_doubted(rendered_trial, tmp_path):
    write_digitised(tmp_path, rendered_trial, v="down")
    table = pd.read_csv(tmp_path / "clip_xypts.csv")
    table.loc[3, "HR_cam2_Y"] += 90
    table.to_csv(tmp_path / "clip_xypts.csv", index=False)
    trial = write_trial(tmp_path, "clip_xypts.csv")
    with pytest.warns(InputWarning, match=r"disagree about 1 of 12 points .* about HR in frame 3"):
        tracks = read_foreign_tracks(trial)
    assert np.isfinite(places(tracks)).all()


def test_points_of_programs_that_are_left_out_are_said(rendered_trial, tmp_path):
    table = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    row = table.index[(table["point"] == "FR") & (table["frame"] == 5)][0]
    table.loc[row, "v"] += 300
    table.to_csv(tmp_path / "tracks.csv", index=False)
    shutil.copy(rendered_trial / "DLTcoefs.csv", tmp_path)
    trial = write_trial(tmp_path, "tracks.csv")
    with pytest.warns(InputWarning, match=r"tracks.csv: 1 of \d+ points are left out in space"):
        read_foreign_tracks(trial)


def test_views_that_do_not_agree_at_all_are_refused_with_what_to_look_at(rendered_trial, tmp_path):
    """Else one view in px would stand in for space: here the cameras are in the wrong order."""
    shutil.copy(rendered_trial / "truth" / "tracks.csv", tmp_path)
    rows = (rendered_trial / "DLTcoefs.csv").read_text().split()
    cells = [row.split(",") for row in rows]
    swapped = [",".join([*row[1:], row[0]]) for row in cells]
    (tmp_path / "DLTcoefs.csv").write_text("\n".join(swapped) + "\n")
    with pytest.raises(CalibrationError, match=r"Is each file that of its view, .* --judge"):
        read_foreign_tracks(write_trial(tmp_path, "tracks.csv"))


# --- real digitised trials ------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pawnb.errors.InputWarning")
@pytest.mark.parametrize("v", ["down", "up"])
def test_real_spiders_are_where_dltdv_says(real_data, tmp_path, v):
    # DLTdv wrote xyzpts to 1e-6 beside xypts and DLTcoefs; linear triangulation is the same
    # whichever way v is counted
    folder = real_data("salticid-4cam-dlt")
    names = sorted(path.name.removesuffix("_xypts.csv") for path in folder.glob("*_xypts.csv"))
    assert names
    for name in names:
        own = tmp_path / name
        own.mkdir()
        shutil.copy(folder / f"{name}_xypts.csv", own)
        shutil.copy(folder / f"{name}_DLTcoefs.csv", own / "DLTcoefs.csv")
        trial = write_trial(own, f"{name}_xypts.csv", v=v)
        found = pd.read_csv(*convert_tracks(trial.folder, own / "points3d.csv"))
        truth = pd.read_csv(folder / f"{name}_xyzpts.csv")
        points = [column.removesuffix("_X") for column in truth if column.endswith("_X")]
        for point in points:
            at = truth["frame0"]
            own_rows = found[found["point"] == point].set_index("frame").loc[at, ["x", "y", "z"]]
            expected = truth[[f"{point}_{axis}" for axis in "XYZ"]].to_numpy()
            np.testing.assert_allclose(own_rows.to_numpy(), expected, atol=1e-6)


@pytest.mark.slow
def test_real_rats_are_where_their_authors_pixels_put_them(real_data):
    # the authors triangulate with v = 700 - Y and, for cameras 3 and 4, u = 2048 - X: solved
    # here from the file's own numbers and coefficients
    folder = real_data("rat-4cam-tracks")
    stamp = "2018-06-08_13_42_28"
    tracks = authors2019.read_authors_trial(folder, stamp, row_px=None)
    path = next(folder.glob(f"DLT.*{stamp}.csv"))
    rig = Rig(authors2019.VIEWS, authors2019.read_authors_dlt(path))
    tracks = triangulate_tracks(tracks, rig)
    raw = np.loadtxt(path, delimiter=",")
    for cam, leg, (a, b) in ((1, "FL", (0, 1)), (3, "FR", (2, 3))):
        table = pd.read_csv(next(folder.glob(f"cam{cam}.f.*{stamp}.csv")), skiprows=5)
        table.columns = table.columns.str.strip()
        frames = table["Frames"].to_numpy()[::50]
        for i in frames:
            row = table[table["Frames"] == i].iloc[0]
            A, y = [], []
            for column, ending in ((a, ""), (b, "2")):
                L = raw[:, column]
                x = float(row[f"X Coordinate O{ending}"])
                u = 2048 - x if cam == 3 else x
                v = 700 - float(row[f"Y Coordinate O{ending}"])
                A += [L[0:3] - u * L[8:11], L[4:7] - v * L[8:11]]
                y += [u - L[3], v - L[7]]
            expected = np.linalg.lstsq(np.array(A), np.array(y), rcond=None)[0]
            found = tracks["position"].sel(keypoint=leg)[tracks["frame"] == i]
            np.testing.assert_allclose(found.to_numpy().ravel(), expected, atol=1e-6)
