"""``pawnb calibrate --board``: on pictures painted from known cameras, and on a real rig."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pandas as pd
import pytest
from board_scene import NAMES, board_poses, draw_board, paint, seen_corners, shown, true_cameras

from pawnb import cli
from pawnb.core.calibration.corners import CornerFinder
from pawnb.core.calibration.rig_from_boards import Sightings
from pawnb.core.dlt import project, triangulate
from pawnb.core.lens import load_lenses
from pawnb.errors import CalibrationError, InputError
from pawnb.io.boards import Board, read_board
from pawnb.io.coefs import read_coefs
from pawnb.workflow.calibration.board import calibrate_from_board, find_boards

TOML = "board_x = 7\nboard_y = 5\nsquare_length = 40.0\nmarker_length = 30.0\n"
BOARD = Board(columns=7, rows=5, square=40.0, marker=30.0)
N = 8


@pytest.fixture(scope="module")
def painted(tmp_path_factory):
    """Eight pictures of a ChArUco board for each of three cameras."""
    folder = tmp_path_factory.mktemp("board")
    (folder / "board.toml").write_text(TOML)
    for name, camera in zip(NAMES, true_cameras(), strict=True):
        (folder / name).mkdir()
        for s, pose in enumerate(board_poses(N, BOARD.corners(), seed=5)):
            cv2.imwrite(str(folder / name / f"{name}_{s:02d}.png"), paint(camera, pose, BOARD))
    return folder


@pytest.mark.slow
def test_painted_boards_give_the_cameras_that_painted_them(painted, tmp_path, capsys):
    out = tmp_path / "DLTcoefs.csv"
    pictures = [f"{name}={painted / name}" for name in NAMES]
    words = ["calibrate", "--board", str(painted / "board.toml"), *pictures, "-o", str(out)]
    assert cli.main([*words, "--floor", "2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["floor"] == 2
    assert [view["view"] for view in found["views"]] == list(NAMES)
    assert max(view["rms_px"] for view in found["views"]) < 0.15
    assert found["square_median"] == pytest.approx(40.0, abs=0.05)  # mm, as painted
    assert len(found["shots"]) == 3 * N
    # points beside the boards, by the true cameras, in the axes of the board of picture 2
    R, T = board_poses(N, BOARD.corners(), seed=5)[2]
    xyz = np.random.default_rng(0).uniform(-80.0, 80.0, (100, 3))
    lenses = load_lenses(tmp_path / "lenses.toml")
    filmed = np.stack([shown(camera, xyz) for camera in true_cameras()], axis=1)
    straight = np.stack([lenses[n].straighten(filmed[:, v]) for v, n in enumerate(NAMES)], axis=1)
    coefs = read_coefs(out, NAMES)
    on_board = (xyz - T) @ R
    off = np.linalg.norm(triangulate(coefs, straight, even=True).xyz - on_board, axis=1)
    assert np.median(off) < 0.3  # mm, 0.6 m from the cameras
    assert np.median(np.abs(project(coefs, on_board) - straight)) < 0.5  # px


@pytest.mark.slow
def test_what_is_wrong_with_the_pictures_is_one_sentence(tmp_path, capsys):
    (tmp_path / "board.toml").write_text(TOML)
    blank = np.full((60, 80), 128, np.uint8)
    for name, n in (("a", 3), ("b", 3), ("c", 2)):
        (tmp_path / name).mkdir()
        for s in range(n):
            cv2.imwrite(str(tmp_path / name / f"{s}.png"), blank)
    a, b, c = (str(tmp_path / name) for name in "abc")
    board = str(tmp_path / "board.toml")

    def said(*words):
        assert cli.main(["calibrate", *words]) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        return err

    assert "no board is found in view 'a' in any of 3 pictures; expected a ChArUco board of 7 x 5 squares" in said("--board", board, a, b)  # fmt: skip # noqa: E501
    assert "one view only (a)" in said("--board", board, a)
    assert "different numbers of pictures (a 3, c 2)" in said("--board", board, a, c)
    assert "two views are called 'a'" in said("--board", board, a, f"a={b}")
    assert "views x are named, but there are pictures of a, b" in said(
        "--board", board, a, b, "--views", "x"
    )
    assert "--floor needs the board" in said(a, "--floor", "1")
    assert "nowhere.mp4: no such file" in said("--board", board, a, "z=nowhere.mp4")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("square_length = [24.0, 25.0]", "all squares of a board are of one size"),
        ("square_length = -1.0", "square_length is -1.0; expected one number above 0"),
        ("board_x = 2", "board_x is 2; expected the number of squares along that side, 3 to 100"),
        ("marker_length = 40.0", "below the side of a square, 40"),
        ("marker_bits = 3", "marker_bits is 3; expected 4, 5, 6, 7"),
        ("marker_size = 3", "unknown field 'marker_size'"),
        ("board_y = true", "board_y is True"),
    ],
)
def test_a_board_that_is_none_is_refused(tmp_path, change, said):
    key = change.split(" ")[0]
    lines = [line for line in TOML.splitlines() if not line.startswith(key)]
    (tmp_path / "board.toml").write_text("\n".join([*lines, change]))
    with pytest.raises(InputError) as raised:
        read_board(tmp_path / "board.toml")
    assert str(raised.value).startswith("board.toml: ")
    assert said in str(raised.value)


def test_a_field_that_is_missing_is_named(tmp_path):
    (tmp_path / "board.toml").write_text("board_x = 7\nboard_y = 5\n")
    with pytest.raises(InputError, match="square_length is missing"):
        read_board(tmp_path / "board.toml")


VIEWS = {"back": "cam1_back", "mid": "cam2_mid", "side": "cam3_side", "top": "cam4_top"}


@pytest.fixture(scope="module")
def cage(real_data):
    """The real rig, and its board as seen."""
    data = real_data("mouse-4cam-cage")
    pictures = {view: data / "calibration_images" / name for view, name in VIEWS.items()}
    return data, pictures


@pytest.mark.slow
def test_a_real_rig_is_calibrated_by_its_own_pictures(cage, tmp_path):
    data, pictures = cage
    out = tmp_path / "DLTcoefs.csv"
    found = calibrate_from_board(data / "board.toml", pictures, out=out)
    assert found.is_sound
    assert found.remarks == ()
    views = found.views.set_index("view")
    # its authors' own calibration has 2.5 px (SOURCE.txt of the recording)
    assert views["rms_px"].max() < 0.6
    assert (views["n_shots"] == 21).all()
    assert np.median(found.sides) == pytest.approx(24.0, abs=0.05)  # board.toml, mm
    # 3D of the proofread points: within 1 mm of those refitted with other software
    lenses = load_lenses(tmp_path / "lenses.toml")
    coefs = read_coefs(out, tuple(VIEWS))
    expected, uv = proofread(data)
    straight = np.stack(
        [lenses[name].straighten(uv[..., v, :]) for v, name in enumerate(VIEWS)], axis=-2
    )
    xyz = triangulate(coefs, straight, even=True).xyz
    both = np.isfinite(xyz).all(axis=-1) & np.isfinite(expected).all(axis=-1)
    assert both.sum() > 1000
    assert np.median(off_after_turning(xyz[both], expected[both])) < 1.0


def proofread(data):
    """Points in space (frame, point, 3) and where four cameras saw them, px as filmed."""
    table, rows = pd.read_csv(data / "points3d_refitted.csv"), pd.read_csv(data / "points2d.csv")
    points = list(dict.fromkeys(name[:-2] for name in table.columns[1:]))
    expected = np.stack([table[[f"{p}_{a}" for a in "xyz"]].to_numpy() for p in points], axis=1)
    uv = np.full((*expected.shape[:2], 4, 2), np.nan)
    frame = np.searchsorted(table["frame"], rows["frame"])
    uv[frame, [points.index(p) for p in rows["point"]], rows["cam"] - 1] = rows[["x", "y"]]
    return expected, uv


def off_after_turning(xyz, expected):
    """Distances in mm after the rotation and shift that suit best: axes are those of the board."""
    a, b = xyz - xyz.mean(axis=0), expected - expected.mean(axis=0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    return np.linalg.norm(a @ (U * [1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt - b, axis=1)


@pytest.mark.slow
def test_the_camera_of_a_real_rig_that_is_a_copy_is_named(cage, capsys):
    data, pictures = cage
    words = [f"{view}={path}" for view, path in pictures.items()]
    words += ["--board", str(data / "board.toml"), "--shots", "6"]
    assert cli.main(["calibrate", *words, "--judge", str(data / "calibration.toml")]) == 3
    said = capsys.readouterr().out
    # 125 px over all 21 pictures: SOURCE.txt of the recording
    line = next(line for line in said.splitlines() if line.startswith("view 'side' does not"))
    error_px = float(line.split("corners ")[1].split(" px")[0])
    assert error_px == pytest.approx(125.0, rel=0.1)
    assert "is a copy of that of 'top'" in line
    assert "view 'top'" not in said


def test_a_copy_is_said_when_another_programs_file_is_taken_over(real_data, tmp_path, capsys):
    data = real_data("mouse-4cam-cage")
    out = str(tmp_path / "DLTcoefs.csv")
    assert cli.main(["calibrate", str(data / "calibration.toml"), "-o", out]) == 0
    assert "cameras 'side' and 'top' are the same" in capsys.readouterr().out


@pytest.mark.slow
def test_films_of_different_length_are_matched_by_frame(tmp_path):
    for name, n in (("a", 4), ("b", 6)):
        writer = cv2.VideoWriter(
            str(tmp_path / f"{name}.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10.0, (80, 60), False
        )
        for _ in range(n):
            writer.write(np.full((60, 80), 128, np.uint8))
        writer.release()
    pictures = {name: tmp_path / f"{name}.avi" for name in "ab"}
    with pytest.raises(CalibrationError, match=r"view 'a' in any of 4 pictures"):
        find_boards(BOARD, pictures)


@pytest.mark.slow
def test_squares_in_space_are_of_corners_counted_alike(tmp_path):
    """A checkerboard of even numbers of squares looks the same upside down.

    One of two cameras was mounted so; OpenCV counts the corners of some pictures from the other
    end there.
    """
    board = Board(columns=6, rows=4, square=40.0)
    upright, (K, bent, R, t) = true_cameras()[:2]
    turned = np.diag([-1.0, -1.0, 1.0])
    cameras = dict(zip(NAMES[:2], (upright, (K, bent, turned @ R, turned @ t)), strict=True))
    find, from_other_end = CornerFinder(board).find, 0
    for name, camera in cameras.items():
        (tmp_path / name).mkdir()
        for s, pose in enumerate(board_poses(6, board.corners(), seed=5)):
            picture = paint(camera, pose, board)
            cv2.imwrite(str(tmp_path / name / f"{s}.png"), picture)
            own = seen_corners([camera], [pose], board.corners())[0, 0]
            from_other_end += np.abs(find(picture) - own).max() > 10.0  # px
    assert 0 < from_other_end < 12
    found = calibrate_from_board(board, {name: tmp_path / name for name in NAMES[:2]})
    assert len(found.sides) == 6 * 4 * 3  # 5 x 3 corners have 12 sides along the rows
    assert np.abs(found.sides - 40.0).max() < 1.0  # mm; 200 where counted from two ends


@pytest.mark.slow
@pytest.mark.parametrize(("counted", "marker"), [((6, 4), None), ((6, 4), 30.0), ((5, 7), 30.0)])
def test_corners_counted_for_squares_are_said(tmp_path, counted, marker):
    board = Board(columns=7, rows=5, square=40.0, marker=marker)
    for name in NAMES[:2]:
        (tmp_path / name).mkdir()
        on_paper = np.pad(draw_board(board, per_square=40), 60, constant_values=255)
        cv2.imwrite(str(tmp_path / name / "0.png"), on_paper)
    wrong = Board(columns=counted[0], rows=counted[1], square=40.0, marker=marker)
    with pytest.raises(CalibrationError, match="but one of 7 x 5 is there: board_x and board_y"):
        find_boards(wrong, {name: tmp_path / name for name in NAMES[:2]})


@pytest.mark.slow
@pytest.mark.parametrize("late", [0, 1])
def test_a_film_that_is_a_frame_late_is_said(monkeypatch, late):
    """A board that is moved slowly, of which every eighth frame is looked at: one frame late
    bends all cameras a little."""
    corners = BOARD.corners()
    faces = board_poses(1, corners, seed=0)[0][0]

    def moved(a):
        R = cv2.Rodrigues(np.array([np.sin(2 * a), np.cos(3 * a), np.sin(a)]) * 0.2)[0] @ faces
        place = np.array([60.0 * np.sin(a), 40.0 * np.cos(2 * a), 40.0 * np.cos(a)])
        return R, place - R @ corners.mean(axis=0)

    frame = 2.0 * np.pi / 24 / 8
    uv = np.concatenate(
        [
            seen_corners([camera], [moved(frame * (8 * k - lag)) for k in range(24)], corners)
            for camera, lag in zip(true_cameras(), (0, late, 0), strict=True)
        ]
    )
    uv += np.random.default_rng(0).normal(0.0, 0.1, uv.shape)
    seen = Sightings(names=NAMES, sizes=((640, 480),) * 3, corners=corners, uv=uv)
    monkeypatch.setattr(
        "pawnb.workflow.calibration.board.find_boards", lambda *_, **__: (seen, np.arange(24), [])
    )
    found = calibrate_from_board(BOARD, dict.fromkeys(NAMES, "films"))
    assert found.is_sound is not bool(late)
    assert ("the views do not agree, though each alone" in found.text()) is bool(late)


@pytest.mark.parametrize(("marker", "said"), [(30.0, False), (22.0, True), (39.0, True)])
def test_a_length_of_markers_that_does_not_go_with_the_squares_is_said(tmp_path, marker, said):
    for name in NAMES[:2]:
        (tmp_path / name).mkdir()
        on_paper = np.pad(draw_board(BOARD, per_square=40), 60, constant_values=255)
        cv2.imwrite(str(tmp_path / name / "0.png"), on_paper)
    wrong = Board(columns=7, rows=5, square=40.0, marker=marker)
    _, _, notes = find_boards(wrong, {name: tmp_path / name for name in NAMES[:2]})
    # 30 px of which the corners are the outermost pixels
    words = f"markers are 29 long where squares are 40, and marker_length is {marker:g}"
    assert any(words in note for note in notes) is said
