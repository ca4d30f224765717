"""Clicks that are exchanged with each other: of two points in one view, or of two views."""

import numpy as np
import pandas as pd
import pytest

from pawnb.core.rig import Rig
from pawnb.workflow.start.exchanged_clicks import (
    solve_clicks,
    tell_disagreeing_clicks,
    tell_exchanged,
    tell_exchanged_clicks,
    tell_one_place,
)

VIEWS = ("cam1", "cam2", "cam3", "cam4")
# the four cameras of the rendered mouse, two at each side
COEFS = np.array(
    [
        [
            1.90677,
            1.74995,
            -0.24098,
            514.692,
            0.0831166,
            -0.223927,
            -2.4084,
            249.219,
            -0.000664518,
            0.00179547,
            -0.000471551,
        ],
        [
            2.59353,
            -0.0194002,
            -0.255753,
            514.055,
            -0.11238,
            -0.243416,
            -2.42064,
            249.081,
            0.000700456,
            0.00173405,
            -0.000475315,
        ],
        [
            -2.58827,
            -0.0803931,
            -0.294163,
            512.1,
            0.127202,
            0.319668,
            -2.40081,
            248.17,
            -0.000658823,
            -0.00178592,
            -0.000558771,
        ],
        [
            -1.93307,
            -1.74071,
            -0.224027,
            511.225,
            -0.0553775,
            0.178485,
            -2.42901,
            249.838,
            0.000653039,
            -0.00179212,
            -0.000420649,
        ],
    ]
).T
# its paws in the first frame of seed 3, mm
PLACES = {"FR": (18.7, -9.0, 1.2), "HR": (-39.6, -14.2, 1.2),
          "FL": (-6.0, 6.4, 1.9), "HL": (-9.1, 12.5, 1.2)}  # fmt: skip
RIGHT_PAWS = ("FR", "HR")


@pytest.fixture
def rig():
    return Rig(VIEWS, COEFS, unit="mm")


def clicked(*, all_views, noise_px=1.0):
    """Click the paws: right ones in cam1 and cam2, left ones in cam3 and cam4, or all in all."""
    rng, clicks = np.random.default_rng(1), {}
    for k, view in enumerate(VIEWS):
        for point, xyz in PLACES.items():
            if all_views or (point in RIGHT_PAWS) == (k < 2):
                c = COEFS[:, k]
                w = np.dot(c[8:11], xyz) + 1
                uv = np.array([np.dot(c[:3], xyz) + c[3], np.dot(c[4:7], xyz) + c[7]]) / w
                clicks[view, point] = tuple(uv + rng.normal(0, noise_px, 2))
    return clicks


def exchanged(clicks, one, other):
    return {**clicks, one: clicks[other], other: clicks[one]}


@pytest.mark.parametrize("all_views", [False, True])
def test_nothing_is_said_of_clicks_that_are_right(rig, all_views):
    assert tell_exchanged(rig, clicked(all_views=all_views)) == []


def test_points_exchanged_in_one_of_two_views_agree_within_3_px_but_lie_far_apart(rig):
    clicks = exchanged(clicked(all_views=False), ("cam1", "FR"), ("cam1", "HR"))
    (said,) = tell_exchanged(rig, clicks)
    assert said.startswith("FR and HR seem to be exchanged in cam1 or cam2")


def test_of_more_views_the_one_is_named(rig):
    clicks = exchanged(clicked(all_views=True), ("cam3", "FR"), ("cam3", "HR"))
    (said,) = tell_exchanged(rig, clicks)
    assert said.startswith("FR and HR seem to be exchanged in cam3:")


def test_views_that_are_exchanged_are_named(rig):
    clicks = clicked(all_views=False)
    for point in RIGHT_PAWS:
        clicks = exchanged(clicks, ("cam1", point), ("cam2", point))
    (said,) = tell_exchanged(rig, clicks)
    assert said.startswith("views cam1 and cam2 fit each other's calibration")


def test_one_wrong_click_is_no_exchange_of_views(rig):
    clicks = clicked(all_views=False)
    u, v = clicks["cam1", "FR"]
    assert tell_exchanged(rig, {**clicks, ("cam1", "FR"): (u, v + 40.0)}) == []


def test_points_whose_clicks_disagree_are_named_once_a_frame(rig):
    clicks = clicked(all_views=True)
    far = {
        key: (uv[0], uv[1] + (40.0 if key in {("cam1", "FR"), ("cam1", "HL")} else 0.0))
        for key, uv in clicks.items()
    }
    rows = [(t, *key, *uv) for t, own in ((3, clicks), (7, far)) for key, uv in own.items()]
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    (said,) = tell_disagreeing_clicks(solve_clicks(rig, table))
    assert "start clicks of FR, HL in frame 7 disagree between the views by up to " in said
    assert tell_disagreeing_clicks(solve_clicks(rig, table[table["frame"] == 3])) == []


def test_the_frame_of_the_clicks_is_said(rig):
    clicks = exchanged(clicked(all_views=False), ("cam1", "FR"), ("cam1", "HR"))
    rows = [(7, view, point, *uv) for (view, point), uv in clicks.items()]
    table = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    (said,) = tell_exchanged_clicks(rig, table)
    assert said.startswith("start clicks of frame 7: FR and HR seem to be exchanged")
    assert tell_exchanged_clicks(rig, table[table["point"] == "FR"]) == []


def test_two_points_that_are_clicked_on_one_place_are_said():
    """The second click did not go to the other paw; both were tracked as one, called good."""
    rows = [
        (0, "cam1", "FR", 50.0, 60.0), (0, "cam1", "FL", 50.4, 60.3), (0, "cam1", "HR", 20.0, 61.0),
        (0, "cam2", "FR", 80.0, 60.0), (0, "cam2", "FL", 80.0, 60.0),
        (7, "cam1", "FR", 50.0, 60.0), (7, "cam1", "FL", 50.0, 60.0),
        (7, "cam2", "FR", 80.0, 60.0), (7, "cam2", "FL", 95.0, 60.0),  # one behind the other
    ]  # fmt: skip
    clicks = pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])
    (said,) = tell_one_place(clicks)
    assert said.startswith("start clicks of frame 0: FR and FL lie on one place in cam1 and cam2")
    assert tell_one_place(clicks[clicks["point"] != "FL"]) == []
