"""Cameras that are known come back from the corners that OpenCV projects by them."""

import sys

import cv2
import numpy as np
import pytest
from board_scene import NAMES, SIZE, board_poses, seen_corners, shown, true_cameras

from pawnb.core.calibration.rig_from_boards import (
    Sightings,
    calibrate_by_boards,
    find_outlying_views,
    judge_by_boards,
    tell_disagreement,
)
from pawnb.errors import CalibrationError
from pawnb.io.boards import Board
from pawnb.io.cameras import Camera

BOARD = Board(columns=7, rows=5, square=40.0)
N = 12
NOISE_PX = 0.1


def sightings(*, names=NAMES, may_be_turned=False, change=None):
    """What three cameras see of twelve boards, with a little noise."""
    corners = BOARD.corners()
    uv = seen_corners(true_cameras(), board_poses(N, corners), corners)[: len(names)]
    uv += np.random.default_rng(1).normal(0.0, NOISE_PX, uv.shape)
    if change is not None:
        change(uv)
    return Sightings(
        names=names, sizes=(SIZE,) * len(names), corners=corners, uv=uv, may_be_turned=may_be_turned
    )


def truth_off_px(fit):
    """How far the cameras show points around the boards from where the true ones do."""
    R, T = board_poses(N, BOARD.corners())[fit.floor]
    xyz = np.random.default_rng(2).uniform(-100.0, 100.0, (200, 3))  # in the true axes
    on_board = (xyz - T) @ R
    off = []
    for camera, true in zip(fit.cameras, true_cameras(), strict=True):
        mine = (camera.matrix, np.array(camera.distortion or [0.0] * 5), camera.rotation,
                camera.translation)  # fmt: skip
        off.append(np.linalg.norm(shown(mine, on_board) - shown(true, xyz), axis=1))
    return np.array(off)


@pytest.mark.slow
def test_cameras_come_back():
    fit = calibrate_by_boards(sightings())
    # corners with 0.1 px of noise in u and v are 0.14 px off; each place is averaged over many
    for name in NAMES:
        assert fit.of_view(name)["rms_px"] == pytest.approx(NOISE_PX * np.sqrt(2), rel=0.1)
        assert fit.of_view(name)["n_corners"] == N * 24
    assert np.median(truth_off_px(fit)) < 0.3
    assert truth_off_px(fit).max() < 2.0
    focal = [camera.matrix[0, 0] for camera in fit.cameras]
    np.testing.assert_allclose(focal, (520.0, 560.0, 600.0), rtol=0.01)
    assert not fit.shots["set_aside"].any()


@pytest.mark.slow
def test_a_checkerboard_may_be_counted_from_either_end():
    def turn(uv):
        for v, s in ((0, 1), (1, 2), (2, 2), (2, 5), (1, 7)):
            uv[v, s] = uv[v, s, ::-1].copy()

    turned = calibrate_by_boards(sightings(may_be_turned=True, change=turn))
    assert not turned.shots["set_aside"].any()
    assert max(turned.of_view(name)["rms_px"] for name in NAMES) < 0.2
    # the same corners taken as they are do not fit

    def turn_more(uv):
        uv[1, :8] = uv[1, :8, ::-1].copy()

    with pytest.raises(CalibrationError, match="does not agree"):
        calibrate_by_boards(sightings(change=turn_more))


@pytest.mark.slow
def test_shots_that_do_not_agree_are_named_and_do_no_harm():
    def spoil(uv):
        uv[1, 3] += 6.0  # px
        uv[2, 8] = uv[2, 4]  # of another instant
        uv[0, 5] = np.nan  # not found

    fit = calibrate_by_boards(sightings(change=spoil))
    aside = fit.shots[fit.shots["set_aside"]]
    assert list(zip(aside["view"], aside["shot"], strict=True)) == [("middle", 3), ("right", 8)]
    assert fit.of_view("left")["n_shots"] == N - 1
    assert np.median(truth_off_px(fit)) < 0.3


@pytest.mark.slow
def test_a_view_of_other_instants_is_named():
    def late(uv):
        uv[2] = np.roll(uv[2], 1, axis=0)

    with pytest.raises(CalibrationError, match=r"^view 'right' does not agree with the others in"):
        calibrate_by_boards(sightings(change=late))


@pytest.mark.slow
def test_what_does_not_determine_the_cameras_is_told():
    def rare(uv):
        uv[1, 2:] = np.nan

    def apart(uv):
        uv[0, ::2] = np.nan
        uv[1:, 1::2] = np.nan

    for change, said in (
        (rare, "view 'middle': the board is found in 2 of 12 pictures; at least 3 are needed"),
        (apart, "view 'middle' shares no picture of the board with"),
    ):
        with pytest.raises(CalibrationError, match=said):
            calibrate_by_boards(sightings(change=change))
    with pytest.raises(CalibrationError, match="one view only"):
        calibrate_by_boards(sightings(names=("left",)))
    with pytest.raises(CalibrationError, match="picture 99 gives no axes"):
        calibrate_by_boards(sightings(), floor=99)


def as_cameras():
    return [
        Camera(name=name, matrix=K, distortion=tuple(bent), rotation=R, translation=t, size=SIZE)
        for name, (K, bent, R, t) in zip(NAMES, true_cameras(), strict=True)
    ]


def test_a_camera_that_is_a_copy_of_another_has_all_of_the_error():
    right = as_cameras()
    fit = judge_by_boards(right, sightings())
    assert find_outlying_views(fit.shots) == []
    assert max(fit.of_view(name)["rms_px"] for name in NAMES) < 0.2
    wrong = [right[0], right[1], Camera(**{**vars(right[1]), "name": "right"})]
    fit = judge_by_boards(wrong, sightings())
    assert find_outlying_views(fit.shots) == ["right"]
    # how far the corners are shown from where they were filmed, by OpenCV
    seen = sightings().uv
    poses = board_poses(N, BOARD.corners())
    shown_by_copy = seen_corners([true_cameras()[1]], poses, BOARD.corners())[0]
    expected = np.sqrt(((shown_by_copy - seen[2]) ** 2).sum(axis=-1).mean())
    assert fit.of_view("right")["rms_px"] == pytest.approx(expected, rel=0.1)
    assert cv2.norm(wrong[2].translation - right[1].translation) == 0


@pytest.mark.slow
def test_a_board_as_wide_as_high_may_be_counted_from_any_corner(monkeypatch):
    board = Board(columns=6, rows=6, square=40.0)
    monkeypatch.setattr(sys.modules[__name__], "BOARD", board)
    quarter = np.rot90(np.arange(25).reshape(5, 5)).ravel()

    def turn(uv):
        for v, s in ((0, 1), (1, 2), (2, 2), (2, 5), (1, 7), (1, 9)):
            uv[v, s] = uv[v, s, quarter].copy()
        uv[2, 6] = uv[2, 6, ::-1].copy()

    fit = calibrate_by_boards(sightings(may_be_turned=True, change=turn))
    assert not fit.shots["set_aside"].any()
    assert np.isfinite(fit.uv).all()
    assert max(fit.of_view(name)["rms_px"] for name in NAMES) < 0.2


@pytest.mark.slow
def test_counting_is_told_for_views_that_share_a_shot_with_others_than_they_were_placed_by():
    def turn(uv):
        uv[0, 8:] = np.nan  # the left view shares shots 8 to 11 with none
        uv[2, :3] = np.nan
        uv[1, 7] = np.nan  # shot 7 is seen by the left and the right view only
        uv[2, 7] = uv[2, 7, ::-1].copy()

    fit = calibrate_by_boards(sightings(may_be_turned=True, change=turn))
    assert not fit.shots["set_aside"].any()


@pytest.mark.parametrize("n_shared", [1, 2, 3])
def test_a_view_that_hangs_on_few_shared_shots_is_said(n_shared):
    """Its corners fit whatever the few say: an error in px does not tell."""

    def rarely(uv):
        uv[0, N // 2 + n_shared :] = np.nan
        uv[1, : N // 2] = np.nan

    fit = calibrate_by_boards(sightings(names=NAMES[:2], change=rarely))
    assert max(fit.of_view(name)["rms_px"] for name in NAMES[:2]) < 0.2
    said = tell_disagreement(fit)
    if n_shared < 3:
        assert f"shares only {n_shared} picture{'s' * (n_shared > 1)} of the board" in said
    else:
        assert said is None


def test_one_shared_shot_of_a_checkerboard_is_refused():
    """It may be counted from either end: half of all such calibrations come out wrong."""

    def once(uv):
        uv[0, N // 2 + 1 :] = np.nan
        uv[1, : N // 2] = np.nan

    with pytest.raises(CalibrationError, match="shares one picture of the board with"):
        calibrate_by_boards(sightings(names=NAMES[:2], may_be_turned=True, change=once))
