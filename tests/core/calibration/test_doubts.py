"""Clicks of other points and mirrored views are named; good clicks are left alone."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.core.calibration.doubts import doubt_points, tell_mirrored

XYZ = np.array([[x, y, z] for x in (-60, 0, 60) for y in (-40, 40) for z in (0, 40)], float)
NAMES = [f"p{i}" for i in range(len(XYZ))]
MATRIX = np.array([[1500.0, 0.0, 639.5], [0.0, 1500.0, 511.5], [0.0, 0.0, 1.0]])


def clicks(seed, bend=0.0):
    """Show the points by OpenCV, with errors of 0.5 px."""
    tilt, _ = cv2.Rodrigues(np.array([-2.0, 0.3, 0.2]))
    uv, _ = cv2.projectPoints(
        XYZ,
        cv2.Rodrigues(tilt)[0],
        np.array([5.0, 10.0, 500.0]),
        MATRIX,
        np.array([bend, 0, 0, 0.0]),
    )
    return uv[:, 0] + np.random.default_rng(seed).normal(0.0, 0.5, (len(XYZ), 2))


@pytest.mark.slow
@pytest.mark.parametrize("bend", [0.0, -0.2])
def test_good_clicks_are_not_doubted(bend):
    said = [doubt_points(NAMES, XYZ, clicks(seed, bend), view="side") for seed in range(40)]
    assert [one for one in said if one] == []


def test_a_click_that_is_off_is_named_with_how_far():
    uv = clicks(1)
    uv[3, 0] += 10.0
    (said,) = doubt_points(NAMES, XYZ, uv, view="side")
    assert said.startswith("view 'side': point 'p3' lies ")
    assert float(said.split("lies ")[1].split(" px")[0]) == pytest.approx(10.0, abs=1.5)


def test_two_clicks_that_are_exchanged_are_named():
    uv = clicks(2)
    uv[[3, 4]] = uv[[4, 3]]
    (said,) = doubt_points(NAMES, XYZ, uv, view="side")
    assert said.startswith("view 'side': the clicks of 'p3' and 'p4' are exchanged")


def test_points_of_which_none_can_be_blamed_are_said_not_to_fit():
    uv = clicks(3)
    uv += np.random.default_rng(0).normal(0.0, 30.0, uv.shape)
    (said,) = doubt_points(NAMES, XYZ, uv, view="side")
    assert "its points fit no camera well" in said
    assert (
        "its points fit no camera well" in doubt_points(NAMES[:7], XYZ[4:11], uv[4:11], view="a")[0]
    )


def test_which_views_are_mirrored_is_said():
    assert tell_mirrored(["a", "b", "c"], np.array([1, 0, 1])) == []
    (one,) = tell_mirrored(["a", "b", "c"], np.array([1, -1, 0]))
    assert "mirrored in b and as it is in a" in one
    (all_of_them,) = tell_mirrored(["a", "b"], np.array([-1, -1]))
    assert (
        "mirrored in a, b: its axes x, y, z are left-handed, or v was counted upwards"
        in all_of_them
    )
