"""Clicks that those of other frames contradict are named; those that are only hard to find are not.

What is right is known: which clicks were exchanged or moved. On the real clips that is done with
marks that others made by hand.
"""

from __future__ import annotations

import tomllib

import numpy as np
import pandas as pd
import pytest
import tomli_w

import pawnb
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.quality.left_out import LeftOutClick
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.core.paws.offline.quality.signs import SIGNS
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    doubted_as_attributes,
    doubted_clicks_in_words,
    doubted_clicks_of,
    find_doubted_clicks,
)
from pawnb.core.suspects.frames import find_suspects
from pawnb.errors import InputWarning
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.workflow.reviewing.quality import assess_quality

POINTS = ["HL", "HR", "FL", "FR"]
ROWS = (0, 20, 40)
PLACED = {
    view: Annotations({r: {p: np.array([10.0 * p, 5.0]) for p in range(4)} for r in ROWS})
    for view in ("left", "right")
}


def left_out(point, row, *, sure=0.99, off=20.0, taken=None, found=0.0, view="left"):
    """A click that the others lead ``off`` halves of a paw away from, ``sure`` of it."""
    signs = np.zeros(len(SIGNS))
    # the logit of the calibration is a weighted sum: one sign alone gives any probability
    signs[0] = (np.log(sure / (1 - sure)) - QUALITY.offset) / QUALITY.weights[0]
    return LeftOutClick(
        point, found, off < 1.5, signs, view=view, row=row, off=off, taken=taken
    )  # fmt: skip


def right(point, row, view="left"):
    return left_out(point, row, off=0.3, found=0.99, view=view)


def doubted(*clicks, rig=None, rows=(100, 0), placed=PLACED):
    return find_doubted_clicks(clicks, points=POINTS, placed=placed, rows=rows, rig=rig)


def said(*clicks, **more):
    return doubted_clicks_in_words(doubted(*clicks, **more))


def test_two_points_that_are_led_to_each_others_click_are_exchanged():
    here = [left_out(0, 20, sure=0.65, taken=1), left_out(1, 20, sure=0.75, taken=0), right(2, 20)]
    assert said(*here) == [
        "HL and HR seem to be clicked under each other's names in frame 120 (if not in 100 or 140)"
    ]
    # where the tracker is not sure of it, legs that look alike are lost by themselves
    assert not doubted(left_out(0, 20, sure=0.4, taken=1), left_out(1, 20, sure=0.8, taken=0))


def test_a_point_that_is_surely_led_to_the_click_of_one_that_is_not_found_there():
    (one,) = doubted(left_out(0, 20, sure=0.9, taken=1), left_out(1, 20, sure=0.1, off=30.0))
    assert (one.point, one.other, one.frame, one.beside) == ("HL", "HR", 120, (100, 140))
    # both cannot be there: the one that is found stays, and the other is not known
    assert not doubted(left_out(0, 20, sure=0.9, taken=1), right(1, 20))


def test_a_click_far_from_where_others_surely_lead():
    words = "HL is clicked far from where the clicks of other frames lead in frame 140"
    assert said(left_out(0, 40), right(1, 40)) == [f"{words} (if not in 120)"]
    assert not said(left_out(0, 40, sure=0.7))
    assert not said(left_out(0, 40, off=4.0))
    assert not said(left_out(0, 40, found=0.3))


def test_all_clicks_of_a_frame_that_were_made_in_another():
    far = [left_out(p, row, sure=0.8) for row in (20, 40) for p in range(4)]
    assert said(*far) == [
        "the clicks of HL, HR, FL, FR in frame 120 (if not in 140 or 100) lie far from where those "
        "of other frames lead, as if they were made in another frame or not on the animal"
    ]
    # half of them is no frame, and 0.8 is not sure enough of one point
    assert not said(*far[:2], right(2, 20), right(3, 20))


def test_a_click_that_another_calibrated_view_finds_is_not_doubted():
    clicks = [left_out(0, 20), right(0, 20, view="right")]
    assert [one.view for one in doubted(*clicks)] == ["left"]
    assert not doubted(*clicks, rig=object())


def test_what_an_earlier_stretch_handed_on_is_no_click_of_a_person():
    assert not doubted(left_out(0, 10))
    assert [one.frame for one in doubted(left_out(0, 10), rows=(100, 10))] == [120]


@pytest.fixture
def tracks():
    """Four points that are found in all of 50 frames, and pass through their clicks."""
    tracks = make_tracks(range(100, 150), POINTS, fps=50.0, views=["left"], space=("x", "y"))
    for name in ("position", "image_position"):
        for p in range(4):
            tracks[name][..., 0, p, :] = 10.0 * p
            tracks[name][..., 1, p, :] = 5.0
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][:] = 0.99
    tracks["image_confidence"].attrs["is_probability"] = 1
    for row in ROWS:
        tracks["image_origin"][row] = ORIGIN_CODE["edited"]
    found = doubted(left_out(0, 20, taken=1), left_out(1, 20, taken=0))
    return tracks.assign_attrs(doubted_as_attributes(found))


def test_the_verdict_and_the_first_suspect_name_the_click(tracks):
    quality = assess_quality(tracks)
    assert quality.verdict == "look"
    assert quality.line().startswith("look: HL and HR seem to be clicked under each other's names")
    first = find_suspects(tracks).iloc[0]
    assert (first["frame"], first["view"]) == (120, "left")
    assert first["reason"] == "clicks in other frames lead to the click of HR"
    # frames 111 to 129 are nearer to this click than to those in 100 and 140
    assert first["score"] == pytest.approx(0.99 * 19, rel=1e-3)
    del tracks.attrs["doubted_clicks"]
    assert assess_quality(tracks).verdict == "good"


def test_a_click_that_was_corrected_since_is_not_doubted(tracks):
    tracks["image_position"][20, 0, 0, 0, 0] = 10.0
    assert [one.point for one in doubted_clicks_of(tracks)] == ["HR"]
    for part in (tracks.isel(time=slice(20)), tracks.sel(keypoint=["HL"]), tracks.sel(view=[])):
        assert not doubted_clicks_of(part)
    in_space = tracks.drop_vars([name for name in tracks if str(name).startswith("image")])
    assert not doubted_clicks_of(in_space)


@pytest.mark.slow
def test_ears_of_a_real_mouse_exchanged_in_one_of_three_frames_are_named(real_data, tmp_path):
    """As it is nothing is said: it was *good* both times, and half of its labels were wrong."""
    clip = real_data("real-clips") / "mouse_openfield_top"
    document = tomllib.loads((clip / "trial.toml").read_text())
    document["trial"]["frames"] = [640, 725]
    document["views"][0]["video"] = str(clip / "top.mp4")
    document["start"] = {"points": "start.csv"}
    marks = pd.read_csv(clip / "marks.csv")
    clicks = marks.loc[marks["frame"].isin([640, 680, 720]), ["frame", "view", "point", "u", "v"]]
    names = {"ear_L": "ear_R", "ear_R": "ear_L"}
    (tmp_path / "trial.toml").write_text(tomli_w.dumps(document))
    for exchanged in (False, True):
        own = clicks.copy()
        if exchanged:
            here = own["frame"] == 680
            own.loc[here, "point"] = own.loc[here, "point"].replace(names)
        own.to_csv(tmp_path / "start.csv", index=False)
        words = "ear_L and ear_R seem to be clicked under each other's names in frame 680"
        if exchanged:
            with pytest.warns(InputWarning, match=words):
                tracks = pawnb.track(tmp_path)
        else:
            tracks = pawnb.track(tmp_path)
        assert (words in assess_quality(tracks).line()) == exchanged
