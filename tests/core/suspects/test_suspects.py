"""Suspects: faults planted in known tracks come first, with the right words."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from walking_tracks import RIG, put, walk

from pawnb.core.suspects.frames import SuspectSettings, find_suspects
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, SUSPECTS_COLUMNS, make_tracks


def first_row(tracks, **options):
    return find_suspects(tracks, **{"rig": RIG} | options).iloc[0]


def test_columns_order_and_distance_between_frames():
    tracks, _ = walk()
    table = find_suspects(tracks, rig=RIG, settings=SuspectSettings(least_score=0.2))
    assert tuple(table.columns) == SUSPECTS_COLUMNS
    assert len(table) > 5
    assert (np.diff(table["score"]) <= 0).all()
    frames = np.sort(table["frame"].unique())
    assert np.diff(frames).min() >= 25 / 4  # a quarter of apart_frames, as documented


def test_views_that_disagree_are_told_with_and_without_a_rig():
    tracks, uv = walk()
    hill = 25 * np.sin(np.linspace(0, np.pi, 61)) ** 2
    uv[90:151, 1, 0, 1] += hill  # v in one of two cameras side by side, slowly
    put(tracks, uv)
    row = first_row(tracks)
    assert abs(row["frame"] - 120) <= 15
    assert row["point"] == "FR"
    # the solution lies midway: up to 12.5 px in each view
    assert re.search(r"views disagree .*by (9|1\d) px", row["reason"]), row["reason"]
    alone = first_row(tracks, rig=None)  # from the residual of the tracks
    assert (alone["frame"], alone["point"]) == (row["frame"], "FR")
    assert re.search(r"views disagree .*by (9|1\d) px", alone["reason"]), alone["reason"]


def test_both_views_off_together_are_found_by_their_motion():
    tracks, uv = walk()
    uv[200, :, 1] += [0, 30]  # 30 mm down in both: the views agree
    put(tracks, uv)
    row = first_row(tracks)
    assert (row["frame"], row["point"]) == (200, "HR")
    assert "30 px off in this one frame only" in row["reason"]


def test_a_point_that_stays_on_another_is_a_crossing():
    tracks, uv = walk()
    share = np.sin(np.linspace(0, np.pi, 60))[:, None, None] ** 0.5  # comes, stays, and goes
    uv[150:210, :, 0] += share * (uv[150:210, :, 1] - uv[150:210, :, 0])
    put(tracks, uv)
    table = find_suspects(tracks, rig=RIG)
    assert table["frame"].iloc[0] in range(149, 211)
    inside = table[table["frame"].between(150, 209)]
    assert inside["reason"].str.contains("they may have been mistaken").any()


def test_predicted_stretches_count_to_their_end():
    tracks, _ = walk()
    tracks["image_origin"].values[80:121, :, 1, 0] = ORIGIN_CODE["predicted"]
    row = first_row(tracks)
    assert 110 <= row["frame"] <= 120
    assert row["point"] == "HR"
    assert "only predicted" in row["reason"]


def test_confidence_that_drops_and_a_paw_to_one_side():
    tracks, uv = walk()
    tracks["image_confidence"].values[60:63, 0, 0, 0] = 0.2
    row = first_row(tracks)
    assert 60 <= row["frame"] <= 62
    assert "confidence drops to 0.20" in row["reason"]
    ramp = 20 - np.abs(np.arange(-20, 20))  # slowly 40 mm across: both views agree about it
    uv[200:240, 0, 1, 0] += ramp
    uv[200:240, 1, 1, 0] -= ramp
    tracks["image_confidence"].values[60:63, 0, 0, 0] = 0.9
    put(tracks, uv)
    table = find_suspects(tracks, rig=RIG)
    assert table[table["frame"].between(200, 239)]["reason"].str.contains("to one side").any()


def test_a_second_pass_that_disagrees():
    tracks, uv = walk()
    other = tracks.copy(deep=True)
    away = uv.copy()
    away[90:110, :, 0] += [9.0, 0.0]
    put(other, away)
    row = first_row(tracks, other=other)
    assert 90 <= row["frame"] < 110
    assert "two passes through the recording disagree by 9 px" in row["reason"]
    # frames that the other pass lacks say nothing
    assert len(find_suspects(tracks, rig=RIG, other=other.isel(time=slice(0, 90)))) == len(
        find_suspects(tracks, rig=RIG)
    )
    with pytest.raises(InputError, match="share no view and point"):
        find_suspects(tracks, other=other.assign_coords(keypoint=["a", "b"]))


def test_what_was_placed_by_hand_is_not_doubted():
    tracks, uv = walk()
    uv[120, 1, 0] += [0, 25]
    put(tracks, uv)
    tracks["image_origin"].values[117:124, :, 0, 0] = ORIGIN_CODE["edited"]
    table = find_suspects(tracks, rig=RIG)
    assert not ((table["point"] == "FR") & table["frame"].between(117, 123)).any()


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10_000))
def test_frame_numbers_need_not_begin_with_0(first):
    here, there = (find_suspects(walk(n)[0], rig=RIG) for n in (0, first))
    assert len(here) > 0
    np.testing.assert_array_equal(here["frame"] + first, there["frame"])
    np.testing.assert_array_equal(here["score"], there["score"])


def test_tracks_without_anything_have_no_suspects():
    empty = make_tracks(range(50), ["FR", "HR"], fps=250.0, views=["cam1", "cam2"])
    assert len(find_suspects(empty, rig=RIG)) == 0
    assert len(find_suspects(empty.isel(time=slice(0, 1)), rig=None)) == 0


def test_bad_input_is_named():
    with pytest.raises(InputError, match="no image positions"):
        find_suspects(make_tracks(range(5), ["FR"], fps=250.0))
    with pytest.raises(InputError, match="'apart_frames' is 0"):
        SuspectSettings(apart_frames=0)


def test_points_on_one_place_in_every_frame_are_doubted_without_a_warning():
    tracks = make_tracks(range(60), ["FR", "FL"], fps=200.0, views=["cam1"], space=("x", "y"))
    along = np.stack([np.linspace(0, 300, 60), np.full(60, 100.0)], axis=-1)
    for point in range(2):
        tracks["image_position"].values[:, 0, :, point, 0] = along
    tracks["image_origin"].values[:] = ORIGIN_CODE["measured"]
    table = find_suspects(tracks)
    assert table["reason"].str.contains("0 px from").any()
