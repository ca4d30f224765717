"""Clicks on four paws tell axes of a board or wand that are not those of the animal."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from pawnb.core.rig import Rig
from pawnb.workflow.start.turned_axes import tell_turned_axes

VIEWS = ("left", "right")
# affine views from two sides, px per mm
COEFS = np.array(
    [
        [4.0, 1.0, 0.0, 200.0, 0.0, 0.5, -4.0, 300.0, 0.0, 0.0, 0.0],
        [4.0, -1.0, 0.0, 200.0, 0.0, 0.7, -4.0, 300.0, 0.0, 0.0, 0.0],
    ]
).T
# of a trotting mouse along x, mm
PLACES = {"FR": (20.0, -8.0, 1.0), "HR": (-40.0, -12.0, 1.0), "FL": (-5.0, 7.0, 6.0),
          "HL": (-9.0, 12.0, 1.0)}  # fmt: skip


def told(turn, places=PLACES):
    """What is said where the axes are turned by a rotation, of clicks of frame 7."""
    R = Rotation.from_euler("zyx", turn, degrees=True).as_matrix()
    rows = []
    for point, xyz in places.items():
        uv = COEFS.T.reshape(2, 11)[:, :8].reshape(2, 2, 4) @ np.append(xyz, 1.0)
        rows += [(7, view, point, *uv[k]) for k, view in enumerate(VIEWS)]
    coefs = COEFS.copy()
    for k in (0, 1):
        for row in (0, 4):
            coefs[row : row + 3, k] = R @ COEFS[row : row + 3, k]
    clicks = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    return tell_turned_axes(Rig(VIEWS, coefs, unit="mm"), clicks)


@pytest.mark.parametrize("turn", [(0, 0, 0), (20, 0, 0), (-30, 10, 0)])
def test_nothing_is_said_of_axes_along_the_animal(turn):
    assert told(turn) == []


@pytest.mark.parametrize("turn", [(90, 0, 0), (-70, 0, 0), (0, 80, 0), (150, 0, 170)])
def test_axes_that_are_turned_are_said(turn):
    """(150, 0, 170): both ways are reversed, so that right stays on the right."""
    (said,) = told(turn)
    assert said.startswith("in frame 7 front paws lie towards (")
    assert "degrees from [calibration] forward: the axes are those of the board or wand" in said


def test_paws_that_meet_in_a_gallop_are_no_reason():
    x = {"FR": -10.0, "HR": 4.0, "FL": -12.0, "HL": 2.0}
    gallop = {paw: (x[paw], *PLACES[paw][1:]) for paw in PLACES}
    assert told((0, 0, 0), gallop) == []


def test_axes_that_are_reversed_are_said_as_before():
    (said,) = told((180, 0, 0), {p: (-x, y, z) for p, (x, y, z) in PLACES.items()})
    assert said.startswith("in frame 7 left paws lie")
