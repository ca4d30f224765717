"""Calibrations of other programs: the same camera from every file, and coefficients of it."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

from pawnb import cli
from pawnb.core.dlt import project
from pawnb.core.lens import load_lenses
from pawnb.errors import CalibrationError, InputError
from pawnb.io.cameras import coefs_of_cameras, read_cameras
from pawnb.io.cameras_out import write_cameras, write_opencv_cameras
from pawnb.io.coefs import read_coefs, write_coefs

K = np.array([[900.0, 0.0, 310.5], [0.0, 905.0, 239.0], [0.0, 0.0, 1.0]])
D = np.array([-0.21, 0.05, 0.001, -0.002, 0.0])
RVEC = {"left": np.array([0.1, 0.4, -0.05]), "right": np.array([-0.1, -0.4, 0.02])}
T = {"left": np.array([5.0, -3.0, 400.0]), "right": np.array([-4.0, 2.0, 420.0])}
XYZ = np.random.default_rng(0).uniform(-50, 50, (30, 3))


def seen(name, distortion=None):
    """Where OpenCV itself shows the points."""
    return cv2.projectPoints(XYZ, RVEC[name], T[name], K, distortion)[0][:, 0]


def anipose(path):
    rows = [
        f'[cam_{i}]\nname = "{name}"\nsize = [640, 480,]\nmatrix = {K.tolist()}\n'
        f"distortions = {D.tolist()}\nrotation = {RVEC[name].tolist()}\n"
        f"translation = {T[name].tolist()}\n"
        for i, name in enumerate(RVEC)
    ]
    path.write_text("\n".join(rows) + "\n[metadata]\nadjusted = false\n")
    return [path]


def pose2sim(path):
    # Pose2Sim, Utilities: sections named by the camera, four coefficients, fisheye
    rows = [
        f'[{name}]\nname = "{name}"\nsize = [ 640.0, 480.0]\nmatrix = {K.tolist()}\n'
        f"distortions = {D[:4].tolist()}\nrotation = {RVEC[name].tolist()}\n"
        f"translation = {T[name].tolist()}\nfisheye = false\n"
        for name in RVEC
    ]
    path.write_text("\n".join(rows) + "\n[metadata]\nadjusted = false\nerror = 0.0\n")
    return [path]


def opencv(path, nested):
    """Written by OpenCV's own FileStorage."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name in RVEC:
        rotation = cv2.Rodrigues(RVEC[name])[0]
        values = {"K": K, "dist": D.reshape(1, 5), "Rot": rotation, "T": T[name].reshape(3, 1)}
        if nested:
            storage.startWriteStruct(name, cv2.FileNode_MAP)
            for word, value in zip(
                ("camera_matrix", "distortion_coefficients", "R", "T"), values.values(), strict=True
            ):
                storage.write(word, value)
            storage.endWriteStruct()
        else:
            for word, value in values.items():
                storage.write(f"{word}_{name}", value)
    storage.release()
    return [path]


def mayacam(folder):
    """As Camera::saveMayaCamVersion2 of XMALab's source lays it out: 12 digits."""
    paths = []
    for name in RVEC:
        parts = {
            "image size": [[640, 480]],
            "camera matrix": K,
            "rotation": cv2.Rodrigues(RVEC[name])[0],
            "translation": T[name].reshape(3, 1),
        }
        text = ""
        for head, rows in parts.items():
            text += head + "\n" + "\n".join(",".join(f"{x:.12g}" for x in row) for row in rows)
            text += "\n\n"
        paths.append(folder / f"{name}.txt")
        paths[-1].write_text(text)
    return paths


WRITERS = {
    "anipose": lambda folder: anipose(folder / "calibration.toml"),
    "pose2sim": lambda folder: pose2sim(folder / "Calib.toml"),
    "opencv": lambda folder: opencv(folder / "cameras.yaml", nested=False),
    "opencv sections": lambda folder: opencv(folder / "cameras.yml", nested=True),
    "xmalab": mayacam,
}


@pytest.mark.parametrize("kind", WRITERS)
def test_every_file_gives_the_cameras_that_opencv_shows(tmp_path, kind):
    cameras = read_cameras(*WRITERS[kind](tmp_path))
    assert [camera.name for camera in cameras] == ["left", "right"]
    coefs, origin = coefs_of_cameras(cameras)
    assert (origin == 0).all()
    for camera, column in zip(cameras, coefs.T, strict=True):
        np.testing.assert_allclose(project(column, XYZ)[:, 0], seen(camera.name), atol=1e-7)
        straight = "xmalab" in kind
        assert camera.is_straight is straight
        if not straight:
            np.testing.assert_array_equal(camera.distortion, D[: len(camera.distortion)])


def test_aniposelib_cameras_come_back_from_our_toml(tmp_path):
    cameras = read_cameras(*anipose(tmp_path / "a.toml"))
    again = read_cameras(write_cameras(cameras, tmp_path / "b.toml"))
    for one, two in zip(cameras, again, strict=True):
        assert (one.name, one.size, one.distortion) == (two.name, two.size, two.distortion)
        np.testing.assert_array_equal(one.matrix, two.matrix)
        np.testing.assert_allclose(one.rotation, two.rotation, atol=1e-15)
        np.testing.assert_array_equal(one.translation, two.translation)
    lib = pytest.importorskip("aniposelib")
    group = lib.cameras.CameraGroup.load(str(tmp_path / "b.toml"))
    for camera, own in zip(group.cameras, cameras, strict=True):
        np.testing.assert_allclose(camera.project(XYZ)[:, 0], seen(own.name, D), atol=1e-6)


def test_opencv_reads_what_we_write_for_it(tmp_path):
    cameras = read_cameras(*anipose(tmp_path / "calibration.toml"))
    path = write_opencv_cameras(cameras, tmp_path / "cameras.yaml")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    for camera, again in zip(cameras, read_cameras(path), strict=True):
        R, t, matrix, bent = (
            storage.getNode(f"{word}_{camera.name}").mat() for word in ("Rot", "T", "K", "dist")
        )
        shown = cv2.projectPoints(XYZ, cv2.Rodrigues(R)[0], t, matrix, bent)[0][:, 0]
        np.testing.assert_allclose(shown, seen(camera.name, D), atol=1e-9)
        for word in ("matrix", "rotation", "translation", "distortion"):
            np.testing.assert_array_equal(getattr(again, word), getattr(camera, word))
    odd = dataclasses.replace(cameras[0], name="cam 1")
    with pytest.raises(CalibrationError, match="camera 'cam 1': OpenCV's files take names"):
        write_opencv_cameras([odd], tmp_path / "odd.yaml")


def test_a_pair_whose_first_camera_is_the_origin_is_moved_and_says_so(tmp_path, capsys):
    # OpenCV's stereo calibration: M1, D1, M2, D2 and R, T of the second camera
    rotation, move = cv2.Rodrigues(np.array([0.0, -0.5, 0.0]))[0], np.array([150.0, 0.0, 60.0])
    storage = cv2.FileStorage(str(tmp_path / "stereo.yml"), cv2.FILE_STORAGE_WRITE)
    for name, value in (("M1", K), ("D1", D.reshape(1, 5)), ("M2", K), ("D2", D.reshape(1, 5)),
                        ("R", rotation), ("T", move.reshape(3, 1))):  # fmt: skip
        storage.write(name, value)
    storage.release()
    words = ["calibrate", str(tmp_path / "stereo.yml"), "-o", str(tmp_path / "DLTcoefs.csv")]
    assert cli.main(words) == 0
    said = capsys.readouterr().out
    assert "2 cameras: cam1, cam2" in said
    assert "a camera that stands at its origin has no DLT coefficients" in said
    coefs = read_coefs(tmp_path / "DLTcoefs.csv", ["cam1", "cam2"])
    _, origin = coefs_of_cameras(read_cameras(tmp_path / "stereo.yml"))
    xyz = XYZ + np.array([0, 0, 400])
    for i, (rvec, t) in enumerate(((np.zeros(3), np.zeros(3)), (cv2.Rodrigues(rotation)[0], move))):
        expected = cv2.projectPoints(xyz, rvec, t, K, None)[0][:, 0]
        np.testing.assert_allclose(project(coefs[:, i], xyz - origin)[:, 0], expected, atol=1e-6)


def test_the_command_takes_over_cameras_and_lenses(tmp_path, capsys):
    (path,) = anipose(tmp_path / "calibration.toml")
    out = tmp_path / "DLTcoefs.csv"
    assert cli.main(["calibrate", str(path), "-o", str(out), "--views", "right", "left"]) == 0
    said = capsys.readouterr().out
    assert 'dlt = "DLTcoefs.csv"; pixels = "file"; lens = "lenses.toml"' in said
    coefs = read_coefs(out, ["right", "left"])
    np.testing.assert_allclose(project(coefs[:, 0], XYZ)[:, 0], seen("right"), atol=1e-7)
    lens = load_lenses(tmp_path / "lenses.toml")["left"]
    np.testing.assert_allclose(lens.straighten(seen("left", D)), seen("left"), atol=0.05)
    assert cli.main(["calibrate", str(path), "-o", str(out), "--views", "top"]) == 2
    assert capsys.readouterr().err == "pawnb: no camera 'top'; there are left, right.\n"


def test_coefficients_of_xmalab_show_points_where_its_mayacam_files_do(tmp_path):
    """As Camera::getDLT of XMALab's source makes them: two axes of the camera turned round, rows
    counted from the lower edge, and both from 1; written with 12 digits."""
    theirs = []
    for name in RVEC:
        turned = np.diag([-1.0, 1.0, -1.0])
        pose = turned @ np.column_stack([cv2.Rodrigues(RVEC[name])[0], T[name]])
        flipped = K.copy()
        flipped[1, 2] = (480 - 1) - K[1, 2]
        P = flipped @ pose
        theirs.append(np.concatenate([P[0] + P[2], P[1] + P[2], P[2]])[:11] / P[2, 3])
    text = "\n".join(",".join(f"{x:.12g}" for x in row) for row in np.array(theirs).T)
    (tmp_path / "MergedDlts_Frame0.csv").write_text(text + "\n")
    words = ["calibrate", str(tmp_path / "MergedDlts_Frame0.csv"), "--from", "xmalab"]
    out = tmp_path / "DLTcoefs.csv"
    assert cli.main([*words, "-o", str(out), "--heights", "480", "--views", "left", "right"]) == 0
    coefs = read_coefs(out, ["left", "right"])
    for column, name in zip(coefs.T, RVEC, strict=True):
        np.testing.assert_allclose(project(column, XYZ)[:, 0], seen(name), atol=1e-6)


@pytest.mark.parametrize(
    ("program", "move"),
    [
        ("dltdv", lambda uv: uv + 1),
        ("dltdv7", lambda uv: np.stack([uv[:, 0] + 1, 480 - uv[:, 1]], axis=1)),
        ("easywand", lambda uv: np.stack([uv[:, 0] + 1, 480 - uv[:, 1]], axis=1)),
        ("argus", lambda uv: np.stack([uv[:, 0], 480 - uv[:, 1]], axis=1)),
    ],
)
def test_coefficients_of_a_program_are_moved_to_our_pixels(tmp_path, capsys, program, move):
    # the DLT of points as that program counts their pixels, by ordinary least squares
    uv = move(seen("left"))
    rows, right = [], []
    for (x, y, z), (u, v) in zip(XYZ, uv, strict=True):
        rows += [[x, y, z, 1, 0, 0, 0, 0, -u * x, -u * y, -u * z],
                 [0, 0, 0, 0, x, y, z, 1, -v * x, -v * y, -v * z]]  # fmt: skip
        right += [u, v]
    theirs = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0]
    write_coefs(theirs[:, None], tmp_path / "theirs.csv")
    words = ["calibrate", str(tmp_path / "theirs.csv"), "-o", str(tmp_path / "out.csv")]
    assert cli.main(words) == 2
    assert "say whose with --from dltdv, dltdv7, easywand, argus, xmalab" in capsys.readouterr().err
    if program != "dltdv":
        assert cli.main([*words, "--from", program]) == 2
        assert "counts v upwards from the lower edge; give the height" in capsys.readouterr().err
    assert cli.main([*words, "--from", program, "--heights", "480"]) == 0
    ours = read_coefs(tmp_path / "out.csv", ["cam1"])
    np.testing.assert_allclose(project(ours[:, 0], XYZ)[:, 0], seen("left"), atol=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("900.0", "-900.0", r"c.toml: \[cam_0\]: matrix is none of a camera"),
        ("900.0", '"x"', r"matrix is missing or no numbers"),
        ("distortions = [-0.21, ", "distortions = [", r"\[cam_0\]: 4 distortion|none of a camera|"),
        ("rotation = [0.1, ", "rotation = [", r"\[cam_0\]: rotation is none"),
        ("rotation = [0.1, ", "rotation = [50.1, ", r"rotation is a vector 50.* in radians"),
        ("translation = [5.0, ", "translation = [", r"\[cam_0\]: translation has 2 numbers"),
        ("[cam_0]", "[cam_0]\nfisheye = true", r"\[cam_0\] is a fisheye lens"),
        ('name = "right"', 'name = "left"', "two cameras are called 'left'"),
        ("[cam_0]", "[cam_0", "not a TOML file"),
    ],
)
def test_a_file_that_is_no_calibration_says_why(tmp_path, old, new, message):
    (path,) = anipose(tmp_path / "c.toml")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    if "distortion" in old:
        assert len(read_cameras(path)[0].distortion) == 4  # four are fine
        return
    with pytest.raises(CalibrationError, match=message) as caught:
        read_cameras(path)
    assert "\n" not in str(caught.value)


def test_cameras_of_caliscope_are_called_as_its_films(tmp_path):
    """As caliscope 0.11.8 writes camera_array.toml; what it has not placed has no rotation."""
    (tmp_path / "camera_array.toml").write_text(
        "[cameras.0]\ncam_id = 0\nrotation_count = 1\nfisheye = false\nsize = [640, 480]\n"
        "matrix = [[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]\n"
        "distortions = [-0.2, 0.05, 0.001, 0.0, 0.0]\ntranslation = [0.0, 0.0, 0.404]\n"
        "rotation = [1.72, 0.0, 0.0]\n\n[cameras.3]\ncam_id = 3\nsize = [640, 480]\n"
        "matrix = [[800.0, 0.0, 319.5], [0.0, 800.0, 239.5], [0.0, 0.0, 1.0]]\n"
    )
    (camera,) = read_cameras(tmp_path / "camera_array.toml")
    assert (camera.name, camera.size) == ("cam_0", (640, 480))
    assert camera.distortion == (-0.2, 0.05, 0.001, 0.0, 0.0)
    np.testing.assert_allclose(camera.rotation, cv2.Rodrigues(np.array([1.72, 0.0, 0.0]))[0])
    np.testing.assert_allclose(camera.translation, [0.0, 0.0, 0.404])  # metres, as they stand


def test_a_camera_that_is_not_calibrated_yet_is_told(tmp_path):
    """As aniposelib 0.8 dumps cameras before they are calibrated."""
    (path,) = anipose(tmp_path / "c.toml")
    lines = [
        "matrix = [ [ 1.0, 0.0, 0.0,], [ 0.0, 1.0, 0.0,], [ 0.0, 0.0, 1.0,],]"
        if line.startswith("matrix") else line
        for line in path.read_text().splitlines()
    ]  # fmt: skip
    path.write_text("\n".join(lines))
    with pytest.raises(CalibrationError, match=r"\[cam_0\]: the camera is not calibrated yet"):
        read_cameras(path)


def test_a_rotation_that_mirrors_is_refused(tmp_path):
    (path,) = anipose(tmp_path / "c.toml")
    lines = path.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith("rotation"))
    lines[at] = "rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]"
    path.write_text("\n".join(lines))
    with pytest.raises(CalibrationError, match=r"\[cam_0\]: rotation mirrors space"):
        read_cameras(path)


def test_intrinsics_and_extrinsics_may_both_be_named(tmp_path):
    numbers = {
        "K": np.diag([900.0, 900.0, 1.0]),
        "Rot": np.eye(3),
        "T": np.array([[0.0, 0, 500]]).T,
    }
    for name, kinds in (("intri.yml", ("K",)), ("extri.yml", ("Rot", "T"))):
        file = cv2.FileStorage(str(tmp_path / name), cv2.FILE_STORAGE_WRITE)
        for kind in kinds:
            file.write(f"{kind}_left", numbers[kind])
        file.release()
    both = [tmp_path / "intri.yml", tmp_path / "extri.yml"]
    for paths in (both[:1], both, both[::-1]):
        (camera,) = read_cameras(*paths)
        assert camera.name == "left"
        assert camera.translation.tolist() == [0.0, 0.0, 500.0]


@pytest.mark.parametrize("kind", WRITERS)
def test_a_damaged_calibration_is_read_or_one_sentence(tmp_path, kind):
    paths = WRITERS[kind](tmp_path)
    whole = paths[0].read_bytes()
    rng = np.random.default_rng(1)
    sentences = []
    for seed in range(60):
        data = bytearray(whole)
        if seed % 2:
            del data[int(rng.integers(len(data))) :]
        for at in rng.integers(0, max(len(data), 1), 4) if data else ():
            data[at] = rng.integers(256) if seed % 3 else rng.choice(list(b"0123-.,[]eE\n"))
        paths[0].write_bytes(bytes(data))
        try:
            coefs_of_cameras(read_cameras(*paths))
        except InputError as error:
            sentences.append(str(error))
    assert len(sentences) > 10
    assert not any("\n" in sentence for sentence in sentences)
