"""CalibrationDigitiser without a browser: clicks, undo, what is written, and what is refused."""

from __future__ import annotations

import ball_scene as scene
import cv2
import numpy as np
import pandas as pd
import pytest
import tomli_w

from pawnb import cli
from pawnb.core.calibration.rig_from_boards import Sightings
from pawnb.errors import InputError
from pawnb.io.boards import Board
from pawnb.io.coefs import read_coefs
from pawnb.trial import Trial, load_trial
from pawnb.widgets import CalibrationDigitiser


@pytest.fixture
def opened(tmp_path):
    pictures = scene.write(tmp_path / "in")
    made = []

    def open_it(**options):
        options = {"points": tmp_path / "in" / "points.csv", "folder": tmp_path} | options
        made.append(CalibrationDigitiser(pictures, **options))
        return made[-1]

    yield open_it, tmp_path
    for widget in made:
        widget.close()


def click(widget, view, u, v):
    widget.edit("click", {"frame": 0, "view": view, "u": float(u), "v": float(v)})


def act(widget, action, value=None):
    widget.edit("action", {"frame": 0, "action": action, "value": value})


def click_all(widget, off_px=0.0, views=tuple(scene.VIEWS)):
    rng = np.random.default_rng(0)
    for view in views:
        for u, v in scene.seen(view, list(scene.PLACES.values())):
            du, dv = rng.uniform(-off_px, off_px, 2)
            click(widget, view, u + du, v + dv)


def test_clicks_on_known_points_give_the_cameras(opened, tmp_path):
    open_it, folder = opened
    widget = open_it()
    assert widget.status.startswith("Click b000 in left.")
    click_all(widget)
    assert "Every point is clicked in each view." in widget.status
    assert "left: 0.00 px RMS of 12 points" in widget.status
    (folder / "DLTcoefs.csv").write_text("an older one")
    act(widget, "save")
    act(widget, "save")
    assert (folder / "DLTcoefs.before.csv").read_text() == "an older one"
    assert not (folder / "DLTcoefs.before-2.csv").exists()
    assert "Wrote DLTcoefs.csv" in widget.status
    coefs = read_coefs(folder / "DLTcoefs.csv", tuple(scene.VIEWS))
    xyz = np.random.default_rng(1).uniform(-50.0, 50.0, (50, 3))
    for column, view in zip(coefs.T, scene.VIEWS, strict=True):
        below = xyz @ column[8:11] + 1.0
        uv = np.stack([xyz @ column[0:3] + column[3], xyz @ column[4:7] + column[7]], axis=1)
        np.testing.assert_allclose(uv / below[:, None], scene.seen(view, xyz), atol=0.01)
    # the same clicks, read by the command
    other = tmp_path / "other.csv"
    words = [str(folder / "in" / "points.csv"), str(folder / "calibration_clicks.csv")]
    assert cli.main(["calibrate", *words, "-o", str(other)]) == 0
    np.testing.assert_array_equal(read_coefs(other, tuple(scene.VIEWS)), coefs)


def test_clicks_snap_to_the_centre_of_the_ball(opened):
    open_it, _ = opened
    widget = open_it()
    act(widget, "snap")
    click_all(widget, off_px=4.0)
    for (view, point), uv in widget.session.clicks.items():
        expected = scene.seen(view, [scene.PLACES[point]])[0]
        np.testing.assert_allclose(uv, expected, atol=0.1)
    act(widget, "snap")
    widget.edit("moved", {"frame": 0, "view": "left", "point": "b000", "u": 300.0, "v": 5.0})
    assert widget.session.clicks["left", "b000"] == (300.0, 5.0)
    act(widget, "snap")
    widget.edit("moved", {"frame": 0, "view": "left", "point": "b000", "u": 310.0, "v": 5.0})
    assert "No ball or round mark is there" in widget.alarm


def test_a_wrong_click_is_named_set_aside_and_taken_back(opened):
    open_it, folder = opened
    widget = open_it()
    click_all(widget)
    wrong = scene.seen("left", [scene.PLACES["b010"]])[0] + [25.0, 0.0]
    widget.edit(
        "moved", {"frame": 0, "view": "left", "point": "b010", "u": wrong[0], "v": wrong[1]}
    )
    assert "⚠ b010 in left is " in widget.status
    widget.edit("select", {"frame": 0, "view": "left", "point": "b010"})
    act(widget, "aside")
    assert "⚠" not in widget.status
    assert "left: 0.00 px RMS of 11 points" in widget.status
    # how far the wrong click is from where the others say: as it was moved
    assert widget.session.residuals()["left", "b010"] == pytest.approx(25.0, abs=0.01)
    chips = {c["id"]: c for c in widget.overlay(0)["views"]["left"]["chips"]}
    assert chips["b010"]["state"] == "hidden"
    assert "set aside, 25.0" in chips["b010"]["title"]
    saved = pd.read_csv(folder / "calibration_clicks.csv").set_index(["view", "point"])
    assert saved["set_aside"].sum() == saved.loc[("left", "b010"), "set_aside"] == 1
    act(widget, "undo")
    assert "⚠ b010 in left" in widget.status
    act(widget, "undo")  # of the drag
    assert "left: 0.00 px RMS of 12 points" in widget.status
    act(widget, "redo")
    act(widget, "redo")
    assert "left: 0.00 px RMS of 11 points" in widget.status
    # opened again: the same clicks, and the same one set aside
    again = open_it()
    assert again.session.clicks == widget.session.clicks
    assert again.session.aside == {("left", "b010")}
    hide = {"frame": 0, "view": "left", "point": "b000"}
    again.edit("hide", hide)
    with pytest.raises(InputError, match="changed by another window"):
        widget.edit("hide", hide)


def test_axes_and_grid_lie_where_they_are_in_space(opened):
    open_it, _ = opened
    widget = open_it()
    click_all(widget, views=("left",))
    views = widget.overlay(0)["views"]
    assert views["right"]["lines"] == []  # not determined yet
    ends = {mark["id"]: (mark["u"], mark["v"]) for mark in views["left"]["hollow"]}
    # the points reach over 100 mm: squares of 20 mm, axes of 40
    for name, xyz in {"x": (40, 0, 0), "y": (0, 40, 0), "z": (0, 0, 40)}.items():
        np.testing.assert_allclose(ends[name], scene.seen("left", [xyz])[0], atol=0.1)
    grid = [line["at"] for line in views["left"]["lines"] if line["colour"] == "#f0e442"]
    corner = scene.seen("left", [(-20.0, -60.0, 0.0)])[0]
    assert min(np.hypot(*(np.array(at[0]) - corner)) for at in grid) < 0.1


@pytest.mark.slow
def test_a_lens_that_bends_is_found(opened):
    """Clicks bent by k1 = -2 about the middle of the picture (OpenCV's model)."""
    open_it, folder = opened
    widget = open_it()
    middle = np.array([319.5, 199.5])
    for view in scene.VIEWS:
        for uv in scene.seen(view, list(scene.PLACES.values())):
            ray = (uv - middle) / scene.FOCAL
            click(widget, view, *(middle + scene.FOCAL * ray * (1.0 - 2.0 * (ray @ ray))))
    straight = max(fit.residual_px.max() for fit in widget.session.fit().views.values())
    act(widget, "bends")
    bent = max(fit.residual_px.max() for fit in widget.session.fit().views.values())
    assert bent < 0.01 < straight
    act(widget, "save")
    assert (folder / "lenses.toml").exists()
    for fit in widget.session.fit().views.values():
        assert fit.camera.distortion[0] == pytest.approx(-2.0, abs=0.02)
        assert fit.camera.matrix[0, 0] == pytest.approx(scene.FOCAL, rel=0.01)


@pytest.mark.slow
def test_a_scale_is_measured_and_written_into_its_trial(opened):
    open_it, folder = opened
    (folder / "trial.toml").write_text(
        '[trial]\nkind = "pose"\nfps = 25.0\n[[views]]\nname = "left"\nvideo = "in/left"\n'
    )
    widget = open_it(points=None, trial=load_trial(folder))
    assert isinstance(widget.trial, Trial)
    click(widget, "left", 100.0, 50.0)
    click(widget, "left", 130.0, 90.0)  # 50 px
    act(widget, "known_length", 20.0)
    assert "2.5" in widget.status
    act(widget, "use_scale")
    assert load_trial(folder).calibration.px_per_unit == 2.5
    with pytest.raises(InputError, match="grid"):
        act(widget, "grid")  # there is none in that picture
    # lines 24 px, 10 units, apart
    picture = np.full(scene.SIZE[::-1], 200, np.uint8)
    picture[8::24], picture[:, 5::24] = 60, 60
    for path in (folder / "in" / "left").iterdir():
        cv2.imwrite(str(path), picture)
    act(widget, "known_length", 10.0)
    act(widget, "grid")
    act(widget, "use_scale")
    assert load_trial(folder).calibration.px_per_unit == pytest.approx(2.4, rel=1e-3)


def test_what_cannot_be_used_is_one_sentence(opened, tmp_path):
    open_it, folder = opened
    with pytest.raises(InputError, match="neither points, board nor wand is given"):
        open_it(points=None)
    with pytest.raises(InputError, match="points and board are given"):
        open_it(board="board.toml")
    with pytest.raises(InputError, match="no pictures are given"):
        CalibrationDigitiser({}, points=folder / "in" / "points.csv")
    table = pd.read_csv(folder / "in" / "points.csv")
    with pytest.raises(InputError, match="points: point 'b000' is there twice"):
        open_it(points=pd.concat([table, table.head(1)]))
    with pytest.raises(InputError, match="points: no column 'z'"):
        open_it(points=table.drop(columns="z"))
    with pytest.raises(InputError, match="points: point 'b000' has no position"):
        open_it(points=table.assign(x=np.nan))
    (folder / "calibration_clicks.csv").write_text("view,point,u,v\nleft,nose,1,2\n")
    with pytest.raises(InputError, match="there is no point 'nose' in view 'left'"):
        open_it()


def more_pictures(folder, n):
    """Let each view have n pictures, all the same."""
    for view in scene.VIEWS:
        first = folder / "in" / view / "0.png"
        for k in range(1, n):
            first.with_name(f"{k}.png").write_bytes(first.read_bytes())


@pytest.fixture
def boards(opened, monkeypatch):
    """The widget on two views of eight boards, whose corners are projected, not painted."""
    open_it, folder = opened
    more_pictures(folder, 8)
    board = Board(columns=7, rows=5, square=10.0)
    corners, rng = board.corners(), np.random.default_rng(2)
    uv = np.zeros((2, 8, len(corners), 2))
    for s in range(8):
        turned = turn(*rng.uniform(-0.5, 0.5, 3)) @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        xyz = (corners - corners.mean(axis=0)) @ turned.T
        for v, view in enumerate(scene.VIEWS):
            uv[v, s] = scene.seen(view, xyz)
    uv += rng.normal(0.0, 0.05, uv.shape)
    uv[1, 6] += 9.0  # one picture of other instants
    found = Sightings(names=tuple(scene.VIEWS), sizes=(scene.SIZE,) * 2, corners=corners, uv=uv)
    monkeypatch.setattr(
        "pawnb.widgets.calibration_pictures.find_boards",
        lambda *_args, **_more: (found, np.arange(8), []),
    )
    return lambda: open_it(points=None, board=board), folder


def turn(a, b, c):
    """A rotation by three angles, one axis after the other."""
    out = np.eye(3)
    for k, angle in enumerate((a, b, c)):
        one = np.eye(3)
        i, j = [n for n in range(3) if n != k]
        one[i, i] = one[j, j] = np.cos(angle)
        one[i, j], one[j, i] = -np.sin(angle), np.sin(angle)
        out = one @ out
    return out


@pytest.mark.slow
def test_pictures_of_a_board_are_found_set_aside_and_taken_back(boards):
    open_it, folder = boards
    widget = open_it()
    assert widget.status == "Press Enter to find the board in every picture."
    act(widget, "find")
    widget.wait()
    # of two views that do not agree either may be the wrong one
    assert "Set aside: left 6 (" in widget.status or "Set aside: right 6 (" in widget.status
    assert widget.session.fitted.of_view("left")["rms_px"] < 0.1  # 0.05 px of noise in u and v
    widget.edit("action", {"frame": 3, "action": "floor", "value": None})
    widget.wait()
    assert "The yellow grid lies on the board of frame 3 in every view" in widget.status
    # the cameras of ball_scene.py stand 600 from (0, 0, 20), and each board lies about zero
    told = widget.status.split("so far from the board of frame 3: left ")[1].split(";")[0]
    away = [float(number) for number in told.split(", right ")]
    eyes = [600.0 * np.array([0.0, -np.cos(scene.DOWN), np.sin(scene.DOWN)]) + [0, 0, 20]]
    assert away == pytest.approx([np.linalg.norm(eyes[0])] * 2, rel=0.01)
    assert "the sides of squares of 10 come out 10" in widget.status
    assert "of 8 pictures" in widget.status
    assert "z for up" in widget.status
    widget.edit("select", {"frame": 2, "view": "left", "point": "board"})
    widget.edit("action", {"frame": 2, "action": "aside", "value": None})
    widget.wait()
    widget.overlay(7)  # the browser reads ahead: that is not where a person is
    assert widget.session.frame == 2
    (chip,) = widget.overlay(2)["views"]["left"]["chips"]
    assert chip["state"] == "hidden"
    assert "left 2 (" in widget.status
    widget.edit("action", {"frame": 2, "action": "save", "value": None})
    assert (folder / "DLTcoefs.csv").exists()
    act(widget, "undo")
    widget.wait()
    assert "left 2 (" not in widget.status
    act(widget, "redo")
    widget.wait()
    again = open_it()
    assert again.session.aside == {("left", 2)}
    assert again.session.floor == 3


@pytest.mark.slow
def test_a_wand_is_clicked_frame_by_frame(opened):
    open_it, folder = opened
    n, length = 14, 40.0
    more_pictures(folder, n)
    K = [[scene.FOCAL, 0.0, 319.5], [0.0, scene.FOCAL, 199.5], [0.0, 0.0, 1.0]]
    lens = {"matrix": K, "distortion": [0.0] * 5}
    (folder / "known.toml").write_text(tomli_w.dumps(dict.fromkeys(scene.VIEWS, lens)))
    widget = open_it(points=None, wand=length, lenses=folder / "known.toml")
    assert widget.status.startswith("Click end 1 of the wand in left.")
    rng = np.random.default_rng(4)
    for frame in range(n):
        middle, along = rng.uniform((-25, -25, -5), (25, 25, 45)), rng.normal(size=3)
        along *= length / 2 / np.linalg.norm(along)
        for view in scene.VIEWS:
            for u, v in scene.seen(view, [middle - along, middle + along]):
                off = 12.0 if (view, frame) == ("right", 5) else 0.0
                message = {"frame": frame, "view": view, "u": float(u), "v": float(v) + off}
                widget.edit("click", message)
    assert "Press Enter to calibrate." in widget.status
    act(widget, "fit")
    widget.wait()
    assert "left: 0.0" in widget.status
    told = widget.status.split("so far from where the axes are drawn: left ")[1].split(";")[0]
    assert [float(x) for x in told.split(", right ")] == pytest.approx([600.0, 600.0], rel=0.02)
    # of two views that do not agree either may be the wrong one
    assert "Set aside: left 5 (" in widget.status or "Set aside: right 5 (" in widget.status
    eyes = [-c.rotation.T @ c.translation for c in widget.session.fitted.cameras]
    expected = 600.0 * np.cos(scene.DOWN) * 2 * np.sin((0.5 + 0.5) / 2)  # as the scene is written
    assert np.linalg.norm(eyes[0] - eyes[1]) == pytest.approx(expected, rel=0.01)
    widget.edit("action", {"frame": 0, "action": "save", "value": None})
    assert (folder / "DLTcoefs.csv").exists()
    ends = str(folder / "calibration_wand.csv")
    words = ["calibrate", ends, "--wand", "40", "--size", "640x400", "-o", str(folder / "c.csv")]
    assert cli.main([*words, "--lenses", str(folder / "known.toml")]) == 0
    np.testing.assert_allclose(
        read_coefs(folder / "c.csv", tuple(scene.VIEWS)),
        read_coefs(folder / "DLTcoefs.csv", tuple(scene.VIEWS)),
    )
    again = open_it(points=None, wand=length)
    assert again.session.clicks == widget.session.clicks
    act(widget, "undo")
    assert len(widget.session.clicks) == 4 * n - 1
