"""``pawnb calibrate FILE --to PROGRAM``: cameras as other programs count their pixels."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb import cli
from pawnb.cli import calibration
from pawnb.core.dlt import project
from pawnb.io.cameras import Camera, read_cameras
from pawnb.io.cameras_out import write_cameras
from pawnb.io.coefs import read_coefs
from pawnb.workflow.calibration.export_file import TARGETS

K = np.array([[900.0, 0.0, 310.5], [0.0, 905.0, 239.0], [0.0, 0.0, 1.0]])
RVEC = {"left": np.array([0.1, 0.4, -0.05]), "right": np.array([-0.1, -0.4, 0.02])}
T = {"left": np.array([5.0, -3.0, 400.0]), "right": np.array([-4.0, 2.0, 420.0])}
HEIGHTS = {"left": 480, "right": 600}
XYZ = np.random.default_rng(0).uniform(-50, 50, (30, 3))
DLTS = ("dltdv", "dltdv7", "easywand", "argus", "xmalab", "pawnb")


@pytest.fixture
def toml(tmp_path):
    return write_cameras(cameras(), tmp_path / "calibration.toml")


def cameras(distortion=()):
    return [
        Camera(name=name, matrix=K, distortion=distortion, rotation=cv2.Rodrigues(RVEC[name])[0],
               translation=T[name], size=(640, HEIGHTS[name]))
        for name in RVEC
    ]  # fmt: skip


def counted(program, uv, height):
    """Pixels as a program counts them: DLTdv 8 down from 1, DLTdv 7 and Argus as their own sources
    were seen to (benchmarks/format_programs.py), easyWand as DLTdv 7 by its description; XMALab as
    its Camera::getDLT makes them: (height - 1) - v, and 1 added to both."""
    u, v = uv.T
    return np.column_stack({
        "dltdv": (u + 1, v + 1), "dltdv7": (u + 1, height - v), "easywand": (u + 1, height - v),
        "argus": (u, height - v), "xmalab": (u + 1, (height - 1) - v + 1), "pawnb": (u, v),
    }[program])  # fmt: skip


@pytest.mark.parametrize("program", DLTS)
def test_coefficients_show_points_as_the_program_counts_them(tmp_path, toml, program, capsys):
    out = tmp_path / "theirs.csv"
    assert cli.main(["calibrate", str(toml), "-o", str(out), "--to", program]) == 0
    assert capsys.readouterr().out == f"2 cameras: left, right\nwrote {out}\n"
    rows = np.loadtxt(out, delimiter=",")  # as Argus' loadDLT and DLTdv read them
    assert rows.shape == (11, 2)
    for L, name in zip(rows.T, RVEC, strict=True):
        w = XYZ @ L[8:] + 1.0  # the DLT as all of them define it
        uv = np.column_stack([(XYZ @ L[:3] + L[3]) / w, (XYZ @ L[4:7] + L[7]) / w])
        seen = cv2.projectPoints(XYZ, RVEC[name], T[name], K, None)[0][:, 0]
        np.testing.assert_allclose(uv, counted(program, seen, HEIGHTS[name]), atol=1e-9)
    # and back
    words = ["calibrate", str(out), "--from", program, "--views", *RVEC, "-o"]
    assert cli.main([*words, str(tmp_path / "ours.csv"), "--heights", "480", "600"]) == 0
    for L, name in zip(read_coefs(tmp_path / "ours.csv", [*RVEC]).T, RVEC, strict=True):
        seen = cv2.projectPoints(XYZ, RVEC[name], T[name], K, None)[0][:, 0]
        np.testing.assert_allclose(project(L, XYZ)[:, 0], seen, atol=1e-9)


def test_coefficients_of_one_program_go_to_another(tmp_path, toml):
    ours, theirs, again = (tmp_path / f"{name}.csv" for name in ("ours", "theirs", "again"))
    assert cli.main(["calibrate", str(toml), "-o", str(ours)]) == 0
    heights = ["--heights", "480", "600"]
    words = ["calibrate", str(ours), "--from", "pawnb", "-o", str(theirs), "--to", "argus"]
    assert cli.main([*words, *heights]) == 0
    words = ["calibrate", str(theirs), "--from", "argus", "-o", str(again), "--to", "pawnb"]
    assert cli.main([*words, *heights]) == 0
    np.testing.assert_allclose(np.loadtxt(again, delimiter=","), np.loadtxt(ours, delimiter=","))


@pytest.mark.parametrize(
    ("to", "out", "names"),
    [
        ("anipose", "a.toml", ["a.toml"]),
        ("opencv", "a.yaml", ["a.yaml"]),
        ("mayacam", "cams", ["cams/left.txt", "cams/right.txt"]),
    ],
)
def test_cameras_come_back_from_the_file_of_another_program(tmp_path, toml, to, out, names):
    assert cli.main(["calibrate", str(toml), "-o", str(tmp_path / out), "--to", to]) == 0
    for one, other in zip(
        read_cameras(*(tmp_path / name for name in names)), read_cameras(toml), strict=True
    ):
        assert one.name == other.name
        np.testing.assert_array_equal(one.matrix, other.matrix)
        np.testing.assert_allclose(one.rotation, other.rotation, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(one.translation, other.translation)
        assert one.size in (other.size, None)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--to", "argus"], "--to argus: name the file to write with -o."),
        (["--to", "dltdv", "-o", "a.csv"], "camera 'left': its lens bends the picture, which DLT"),
        (["--to", "mayacam", "-o", "a"], "camera 'left': its lens bends the picture, which Maya"),
        (["--to", "mayacam", "-o", "a.txt"], "a.txt: name a folder, for MayaCam has one file a"),
        (["--to", "opencv", "-o", "a.toml"], "a.toml: name a file .yaml or .yml with -o for"),
        (["--to", "opencv", "-o", "bent.toml"], "bent.toml: that is the calibration itself; name"),
        (["--to", "opencv", "--wand", "5", "-o", "a.yml"], "--to takes a FILE: calibrate first"),
    ],
)
def test_what_a_file_cannot_hold_is_one_sentence(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    write_cameras(cameras(distortion=(-0.2, 0.05, 0.0, 0.0, 0.0)), "bent.toml")
    assert cli.main(["calibrate", "bent.toml", *words]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"pawnb: {message}"), said
    assert said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["bent.toml"]


def test_coefficients_make_no_cameras(tmp_path, toml, capsys):
    assert cli.main(["calibrate", str(toml), "-o", str(tmp_path / "a.csv")]) == 0
    words = [
        "calibrate",
        str(tmp_path / "a.csv"),
        "--from",
        "pawnb",
        "--to",
        "opencv",
        "-o",
        "b.yml",
    ]
    capsys.readouterr()
    assert cli.main(words) == 2
    assert "a.csv: DLT coefficients say neither lenses nor the size" in capsys.readouterr().err


def test_a_name_that_is_no_file_is_refused(tmp_path, toml, capsys):
    toml.write_text(toml.read_text().replace('"right"', '"../right"'))
    (tmp_path / "sub").mkdir()
    words = ["calibrate", str(toml), "-o", str(tmp_path / "sub" / "cams"), "--to", "mayacam"]
    assert cli.main(words) == 2
    assert "camera '../right': its name cannot be one of a file" in capsys.readouterr().err
    assert not list((tmp_path / "sub").iterdir())


def test_the_help_names_every_program():
    assert TARGETS == calibration._TARGETS
    assert set(DLTS) < set(TARGETS)
