"""One file of tracks a view, triangulated with another program's cameras; and shown in them."""

from __future__ import annotations

import shutil

import numpy as np
import pandas as pd
import pytest

from pawnb import cli
from pawnb.core.dlt import project
from pawnb.core.rig import require_rig
from pawnb.core.video import open_views
from pawnb.errors import CalibrationError, InputError
from pawnb.io.cameras import coefs_of_cameras, read_cameras
from pawnb.io.cameras_out import write_lenses
from pawnb.io.coefs import read_coefs, write_coefs
from pawnb.io.formats import read_any_tracks
from pawnb.io.native import write_tracks
from pawnb.schema import absent_frames, make_tracks
from pawnb.trial import load_trial, save_trial
from pawnb.workflow.conversion.convert import convert_tracks
from pawnb.workflow.conversion.foreign_tracks import files_of_tracks, read_foreign_tracks

VIEWS = ("back", "mid", "side", "top")
HEAD = '[trial]\nkind = "tracks"\nname = "t"\nfps = 30.0\n'


def write_cage(folder, data, calibration):
    files = {}
    for i, view in enumerate(VIEWS, start=1):
        name = f"cam{i}_{view}_points2d.analysis.h5"
        shutil.copy(data / name, folder / name)
        files[view] = name
    named = ", ".join(f'{view} = "{name}"' for view, name in files.items())
    (folder / "trial.toml").write_text(
        f'{HEAD}[calibration]\n{calibration}\nunit = "mm"\n[tracks]\nfile = {{ {named} }}\n'
    )
    return load_trial(folder)


@pytest.fixture(params=["anipose", "dlt"])
def cage(request, real_data, tmp_path):
    data = real_data("mouse-4cam-cage")
    shutil.copy(data / "calibration_side_refitted.toml", tmp_path / "calibration.toml")
    calibration = 'anipose = "calibration.toml"'
    if request.param == "dlt":
        shutil.copy(data / "DLT_for_undistorted_images.csv", tmp_path / "DLTcoefs.csv")
        cameras = read_cameras(tmp_path / "calibration.toml")
        (tmp_path / "lenses.toml").write_text(
            "".join(
                f"[{c.name}]\nmatrix = {c.matrix.tolist()}\ndistortion = {list(c.distortion)}\n"
                for c in cameras
            )
        )
        calibration = 'dlt = "DLTcoefs.csv"\nlens = "lenses.toml"'
    return data, write_cage(tmp_path, data, calibration)


@pytest.mark.filterwarnings("ignore:.*are left out in space")
def test_a_mouse_in_four_cameras_is_within_a_millimetre_of_its_points(cage):
    data, trial = cage
    tracks = read_foreign_tracks(trial)
    assert tracks.attrs["units"] == "mm"
    # points3d_refitted.csv: made with other software from the same points and cameras
    table = pd.read_csv(data / "points3d_refitted.csv")
    off = []
    for point in tracks["keypoint"].to_numpy():
        expected = table[[f"{point}_{axis}" for axis in "xyz"]].to_numpy()
        found = tracks["position"].sel(keypoint=point).to_numpy()[..., 0]
        off.append(np.linalg.norm(found - expected, axis=1))
    off = np.array(off)
    assert np.isfinite(off).mean() > 0.9
    assert np.nanmedian(off) < 0.1  # mm; the issue asks for 1
    assert np.nanmax(off) < 1.0
    assert len(files_of_tracks(trial)) == (5 if trial.calibration.anipose else 6)
    assert load_trial(save_trial(trial, trial.folder / "again.toml")) == trial


@pytest.mark.filterwarnings("ignore:.*are left out in space")
def test_points_in_space_are_shown_view_by_view(real_data, tmp_path):
    data = real_data("mouse-4cam-cage")
    shutil.copy(data / "calibration_side_refitted.toml", tmp_path / "calibration.toml")
    table = pd.read_csv(data / "points3d_refitted.csv")[["frame", "Nose_x", "Nose_y", "Nose_z"]]
    table.to_csv(tmp_path / "points.csv", index=False)
    (tmp_path / "trial.toml").write_text(
        f'{HEAD}[calibration]\nanipose = "calibration.toml"\n[tracks]\nfile = "points.csv"\n'
    )
    paths = convert_tracks(tmp_path, tmp_path / "noseDLC.csv")
    assert [path.name for path in paths] == [f"noseDLC_{view}.csv" for view in VIEWS]
    clicked = pd.read_csv(data / "points2d.csv")
    cameras = read_cameras(tmp_path / "calibration.toml")
    cv2 = pytest.importorskip("cv2")
    for i, (path, camera) in enumerate(zip(paths, cameras, strict=True), start=1):
        found = read_any_tracks(path, fps=30.0)["position"].to_numpy()[:, :, 0, 0]
        # where OpenCV shows them, without the distortion of the lens
        xyz = table[["Nose_x", "Nose_y", "Nose_z"]].to_numpy()
        rvec = cv2.Rodrigues(camera.rotation)[0]
        expected = cv2.projectPoints(xyz, rvec, camera.translation, camera.matrix, None)[0][:, 0]
        np.testing.assert_allclose(found, expected, atol=1e-6)
        own = clicked[(clicked["cam"] == i) & (clicked["point"] == "Nose")]
        assert len(own) > 100


def write_points(path, rows):
    path.write_text("frame,FR_x,FR_y\n" + "".join(f"{f},{x},{y}\n" for f, x, y in rows))


def write_pair(folder, *, offset=0, first="cam1", rows=range(4)):
    write_points(folder / "a.csv", [(i, 10 + i, 20) for i in rows])
    write_points(folder / "b.csv", [(i + offset, 30 + i, 40) for i in range(4)])
    views = "".join(
        f'[[views]]\nname = "{name}"\nvideo = "{name}.avi"\noffset = {o}\n'
        for name, o in (("cam1", 0), ("cam2", offset))
    )
    (folder / "trial.toml").write_text(
        f'{HEAD}[tracks]\nfile = {{ {first} = "a.csv", cam2 = "b.csv" }}\n{views}'
    )
    return folder


def test_frames_of_a_file_that_runs_ahead_are_those_of_the_trial(tmp_path):
    tracks = read_foreign_tracks(load_trial(write_pair(tmp_path, offset=7, rows=[0, 1, 3])))
    assert tracks["frame"].to_numpy().tolist() == [0, 1, 2, 3]
    uv = tracks["image_position"].to_numpy()[..., 0, 0]
    np.testing.assert_array_equal(uv[:, 0, 0], [10, 11, np.nan, 13])
    np.testing.assert_array_equal(uv[:, 1, 0], [30, 31, 32, 33])
    assert absent_frames(tracks) == []  # the other view has a row


def test_files_that_do_not_fit_are_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"file names view 'cam3' \(did you mean 'cam"):
        load_trial(write_pair(tmp_path, first="cam3"))
    text = write_pair(tmp_path).joinpath("trial.toml").read_text()
    (tmp_path / "trial.toml").write_text(text.replace('cam1 = "a.csv"', "cam1 = 3"))
    with pytest.raises(InputError, match=r"\[tracks\] file is .*; expected \{ view = "):
        load_trial(tmp_path)
    (tmp_path / "trial.toml").write_text(text)
    (tmp_path / "b.csv").write_text("frame,FR_x,FR_y,FR_z\n0,1,2,3\n")
    with pytest.raises(InputError, match=r"b.csv: points in space; \[tracks\] file names one v"):
        read_foreign_tracks(load_trial(tmp_path))


def test_cameras_are_called_as_the_views_are(tmp_path):
    folder = write_pair(tmp_path)
    text = (folder / "trial.toml").read_text()
    (folder / "trial.toml").write_text(
        text.replace("[tracks]", '[calibration]\nanipose = "c.toml"\n[tracks]')
    )
    section = (
        '[{0}]\nname = "{0}"\nmatrix = [[900, 0, 300], [0, 900, 200], [0, 0, 1]]\n'
        "rotation = [0, {1}, 0]\ntranslation = [0, 0, 500]\ndistortions = [0, 0, 0, 0, 0]\n"
    )
    (folder / "c.toml").write_text(section.format("A", 0.3) + section.format("B", -0.3))
    with pytest.raises(CalibrationError, match=r"c.toml: no camera 'cam1'; it has A, B: call the"):
        read_foreign_tracks(load_trial(folder))
    for name in ("anipose", "dlt"):
        (folder / "trial.toml").write_text(
            text.replace("[tracks]", f'[calibration]\n{name} = "c"\npx_per_unit = 2.0\n[tracks]')
        )
        with pytest.raises(InputError, match=r"has both .* and .*; keep the one that is meant"):
            load_trial(folder)


def test_coefficients_and_points_for_dltdv_are_moved_together(tmp_path):
    cameras = {"cam1": 0.3, "cam2": -0.3}
    section = (
        '[{0}]\nname = "{0}"\nmatrix = [[900, 0, 300], [0, 900, 200], [0, 0, 1]]\n'
        "rotation = [0, {1}, 0]\ntranslation = [0, 0, 500]\nsize = [640, 480]\n"
    )
    (tmp_path / "c.toml").write_text("".join(section.format(n, a) for n, a in cameras.items()))
    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y,FR_z\n0,1,2,3\n1,-4,5,6\n")
    (tmp_path / "trial.toml").write_text(
        f'{HEAD}[calibration]\nanipose = "c.toml"\n[tracks]\nfile = "points.csv"\n'
    )
    crops = "".join(
        f'[[views]]\nname = "{name}"\nvideo = ""\ncrop = [0, 0, 640, 480]\n' for name in cameras
    )
    for program, name, more in (
        ("dltdv", "clip_xypts.csv", ""),
        ("argus", "clip-xypts.csv", crops),
    ):
        paths = convert_tracks(tmp_path, tmp_path / name, to=program)
        assert paths[1].name == name.replace("xypts", "DLTcoefs")
        own = tmp_path / program
        own.mkdir()
        (own / "trial.toml").write_text(
            f'{HEAD}[calibration]\ndlt = "../{paths[1].name}"\n[tracks]\nfile = "../{name}"\n{more}'
        )
        back = read_foreign_tracks(load_trial(own))
        np.testing.assert_allclose(
            back["position"].to_numpy()[..., 0, 0], [[1, 2, 3], [-4, 5, 6]], atol=1e-6
        )


@pytest.mark.slow
def test_check_and_gait_take_a_file_a_view(tmp_path, capsys):
    n = 200
    t = np.arange(n) / 100.0
    for name, shift in (("a", 0.0), ("b", 3.0)):
        columns = {"frame": np.arange(n)}
        for k, leg in enumerate(("FR", "HR", "FL", "HL")):
            columns[f"{leg}_x"] = 300 + shift + 40 * np.sin(2 * np.pi * (4 * t + k / 2))
            columns[f"{leg}_y"] = 200 - 5 * np.maximum(0, np.cos(2 * np.pi * (4 * t + k / 2)))
        pd.DataFrame(columns).to_csv(tmp_path / f"{name}.csv", index=False)
    section = (
        '[{0}]\nname = "{0}"\nmatrix = [[900, 0, 300], [0, 900, 200], [0, 0, 1]]\n'
        "rotation = [0, {1}, 0]\ntranslation = [0, 0, 500]\n"
    )
    (tmp_path / "c.toml").write_text(section.format("A", 0.01) + section.format("B", -0.01))
    (tmp_path / "trial.toml").write_text(
        HEAD.replace("30.0", "100.0") + '[calibration]\nanipose = "c.toml"\n'
        '[tracks]\nfile = { A = "a.csv", B = "b.csv" }\n'
    )
    cli.main(["check", str(tmp_path)])
    said = capsys.readouterr().out
    assert "tracks in a.csv, b.csv: 200 frames, positions in mm" in said
    words = ["gait", str(tmp_path), "--out", str(tmp_path / "out"), "--figures", "none"]
    assert cli.main(words) == 0
    strides = pd.read_csv(tmp_path / "out" / "strides.csv")
    assert strides["period_s"].median() == pytest.approx(0.25, abs=0.002)  # 4 strides a second
    (tmp_path / "b.csv").unlink()
    assert cli.main(["check", str(tmp_path)]) == 2
    assert "b.csv: no such tracks; check [tracks] file." in capsys.readouterr().out


@pytest.mark.slow
def test_what_pawnb_tracked_is_shown_in_the_views_that_did_not_track_it(small_trial):
    # a point that two of four views track; the others get it from its place in space
    trial = load_trial(small_trial)
    with pytest.raises(InputError, match=r"tracks\.nc: trial .* is not tracked yet; run pawnb tra"):
        convert_tracks(small_trial, small_trial / "outDLC.csv")
    truth = read_any_tracks(small_trial / "truth" / "points3d.csv", fps=trial.fps)
    coefs = read_coefs(small_trial / "DLTcoefs.csv", [view.name for view in trial.views])
    xyz = truth["position"].sel(keypoint="FR").to_numpy()[..., 0]
    uv = project(coefs, xyz)
    names = [view.name for view in trial.views]
    tracks = make_tracks(truth["frame"].to_numpy(), ["FR"], fps=trial.fps, views=names, unit="mm")
    tracks["position"][..., 0, 0], tracks["origin"][..., 0, 0] = xyz, 1
    tracks["confidence"][:] = 1.0
    tracks["image_position"][:, :2, :, 0, 0] = uv[:, :2]
    tracks["image_origin"][:, :2] = 1
    (small_trial / "results").mkdir()
    write_tracks(tracks, small_trial / "results" / "tracks.nc")
    paths = convert_tracks(small_trial, small_trial / "outDLC.csv")
    assert [path.name for path in paths] == [f"outDLC_{name}.csv" for name in names]
    for i, path in enumerate(paths):
        found = read_any_tracks(path, fps=trial.fps)["position"].to_numpy()[..., 0, 0]
        np.testing.assert_allclose(found, uv[:, i], atol=1e-6)


def test_videos_are_straightened_by_the_cameras_of_anipose(real_data, tmp_path):
    data = real_data("mouse-4cam-cage")
    views = "".join(
        f'[[views]]\nname = "{view}"\nvideo = "{data / name}"\ncrop = [100, 50, 900, 800]\n'
        for view, name in (("back", "cam1_back.mp4"), ("top", "cam4_top.mp4"))
    )
    rigs = []
    cameras = read_cameras(data / "calibration_side_refitted.toml")
    write_lenses(cameras, tmp_path / "lenses.toml")
    coefs, _ = coefs_of_cameras([cameras[0], cameras[3]])
    write_coefs(coefs, tmp_path / "DLTcoefs.csv")
    for said in (
        f'anipose = "{data / "calibration_side_refitted.toml"}"',
        'dlt = "DLTcoefs.csv"\nlens = "lenses.toml"\npixels = "file"',
    ):
        (tmp_path / "trial.toml").write_text(
            f'[trial]\nkind = "paws"\nname = "t"\nfps = 30.0\n{views}[calibration]\n{said}\n'
        )
        trial = load_trial(tmp_path)
        with open_views(trial) as opened:
            lenses = {name: reader.lens for name, reader in opened.readers.items()}
            picture = opened.readers["back"].read(0)
        rigs.append((require_rig(trial), lenses, picture))
    (one, one_lens, one_picture), (two, two_lens, two_picture) = rigs
    assert one == two
    assert one_lens == two_lens
    assert one_lens["back"].distortion[0] == pytest.approx(-0.2853406)  # calibration.toml
    np.testing.assert_array_equal(one_picture, two_picture)


def test_points_in_space_need_no_views_but_pictures_do(tmp_path):
    (tmp_path / "points.csv").write_text("frame,FR_x,FR_y,FR_z\n0,1,2,3\n1,-4,5,6\n")
    (tmp_path / "DLTcoefs.csv").write_text("1,2\n" * 11)
    (tmp_path / "trial.toml").write_text(
        f'{HEAD}[calibration]\ndlt = "DLTcoefs.csv"\n[tracks]\nfile = "points.csv"\n'
    )
    (path,) = convert_tracks(tmp_path, tmp_path / "pose.csv", to="anipose")
    assert read_any_tracks(path, fps=30.0)["position"].to_numpy()[1, :, 0, 0].tolist() == [-4, 5, 6]
    with pytest.raises(CalibrationError, match=r"in space only; name the views of its calibration"):
        convert_tracks(tmp_path, tmp_path / "poseDLC.csv")
