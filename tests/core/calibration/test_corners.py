"""Corners of boards that were painted: where OpenCV's projection of the true board has them."""

import numpy as np
import pytest
from board_scene import board_poses, paint, shown, true_cameras

from pawnb.core.calibration.corners import CornerFinder
from pawnb.io.boards import Board

CHARUCO = Board(columns=7, rows=5, square=40.0, marker=30.0)
CHECKERS = Board(columns=7, rows=5, square=40.0)


@pytest.mark.slow
@pytest.mark.parametrize("board", [CHARUCO, CHECKERS], ids=["charuco", "checkerboard"])
def test_corners_are_found_to_a_fifth_of_a_pixel(board):
    camera, pose = true_cameras()[1], board_poses(1, board.corners(), seed=3)[0]
    finder = CornerFinder(board)
    found = finder.find(paint(camera, pose, board))
    expected = shown(camera, board.corners() @ pose[0].T + pose[1])
    off = np.linalg.norm(found - expected, axis=1)
    if finder.may_be_turned:
        off = min(off, np.linalg.norm(found[::-1] - expected, axis=1), key=np.nansum)
    assert np.isfinite(off).sum() >= 20  # of 24
    assert np.nanmax(off) < 0.2


@pytest.mark.parametrize("board", [CHARUCO, CHECKERS], ids=["charuco", "checkerboard"])
def test_nothing_is_found_where_there_is_no_board(board):
    grey = np.random.default_rng(0).integers(0, 255, (240, 320), dtype=np.uint8)
    assert np.isnan(CornerFinder(board).find(grey)).all()


@pytest.mark.slow
def test_a_board_of_other_squares_is_not_taken_for_this_one():
    painted = paint(true_cameras()[1], board_poses(1, CHECKERS.corners())[0], CHECKERS)
    assert np.isfinite(CornerFinder(CHECKERS).find(painted)).all()
    wider = CornerFinder(Board(columns=8, rows=5, square=40.0))
    assert np.isnan(wider.find(painted)).all()
