"""How many numbers a lens gets: as many as lower the error of pictures left out."""

import numpy as np
import pytest
from board_scene import BENT, SIZE, board_poses, seen_corners, true_cameras

from pawnb.core.calibration.intrinsics import fit_lens
from pawnb.errors import CalibrationError
from pawnb.io.boards import Board

CORNERS = Board(columns=7, rows=5, square=40.0).corners()


def seen(bent, n=12):
    K, _, R, t = true_cameras()[1]
    uv = seen_corners([(K, np.array(bent), R, t)], board_poses(n, CORNERS), CORNERS)[0]
    return uv + np.random.default_rng(3).normal(0.0, 0.1, uv.shape)


@pytest.mark.parametrize(
    ("bent", "model"),
    [((0.0,) * 5, "no distortion"), (tuple(BENT), "k1"), ((-0.35, 0.3, 0.004, -0.003, 0.0), "p1")],
)
def test_a_lens_gets_the_coefficients_that_it_needs(bent, model):
    fit = fit_lens(CORNERS, seen(bent), size=SIZE, view="v")
    assert model in fit.model
    assert ("p1" in fit.model) == ("p1" in model)
    assert fit.lens[1] == pytest.approx(560.0, rel=0.02)  # px, of the true camera
    assert fit.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.15)


def test_too_few_pictures_are_told():
    uv = np.full((4, len(CORNERS), 2), np.nan)
    uv[:2] = seen((0.0,) * 5, n=2)
    with pytest.raises(CalibrationError, match=r"view 'v': the board is found in 2 of 4 pictures"):
        fit_lens(CORNERS, uv, size=SIZE, view="v")
