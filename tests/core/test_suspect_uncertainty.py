"""Suspects of tracks that carry their uncertainty: planted doubts come first, in words."""

import re

import numpy as np
from walking_tracks import RIG, put, walk

from pawnb.core.suspect_uncertainty import collect_uncertainty, off_cycle, states_uncertainty
from pawnb.core.suspects import find_suspects
from pawnb.schema import ORIGIN_CODE, make_tracks


def sure_walk():
    """The trot of walk(), from a tracker that knows every place to about 0.3 mm."""
    tracks, uv = walk()
    rng = np.random.default_rng(1)
    tracks.attrs["units"] = "mm"
    tracks["sd"] = tracks["position"].copy()
    tracks["sd"].values[:] = rng.uniform(0.25, 0.35, tracks["sd"].shape)
    return tracks, uv


def first_row(tracks):
    return find_suspects(tracks, rig=RIG).iloc[0]


def test_a_point_hardly_recognised_for_a_while():
    tracks, _ = sure_walk()
    tracks["image_confidence"].values[200:207, :, 1, 0] = 0.3
    row = first_row(tracks)
    assert 200 <= row["frame"] <= 206
    assert row["point"] == "HR"
    assert "hardly recognised here (confidence 0.30)" in row["reason"]
    # one poor frame is no doubt: paws flicker
    tracks, _ = sure_walk()
    tracks["image_confidence"].values[200:207, :, 1, 0] = 0.5
    tracks["image_confidence"].values[60, :, 0, 0] = 0.1
    assert 200 <= first_row(tracks)["frame"] <= 206


def test_a_vague_place():
    tracks, _ = sure_walk()
    tracks["sd"].values[100:110, :, 0, 0] = 3.0
    row = first_row(tracks)
    assert 100 <= row["frame"] <= 109
    # three axes of 3 mm and of about 0.3 mm: times the square root of 3
    assert "only known to 5.2 mm (usually 0.5)" in row["reason"], row["reason"]


def test_views_that_disagree_for_a_while():
    tracks, _ = sure_walk()
    tracks["residual"].values[100:110, 0, 0] = 4.0
    row = first_row(tracks)
    assert 100 <= row["frame"] <= 109
    assert "the views disagree for a while (by 4.0 px" in row["reason"]


def test_a_smooth_step_aside_that_all_views_agree_on():
    tracks, uv = sure_walk()
    aside = 12.0 * np.sin(np.linspace(0, np.pi, 21)) ** 2
    uv[150:171, :, 0, 1] -= aside[:, None]  # v = 300 - z: up
    put(tracks, uv)
    row = first_row(tracks)
    assert 153 <= row["frame"] <= 167
    assert row["point"] == "FR"
    told = re.search(r"it is ([\d.]+) mm from where it is in other strides", row["reason"])
    assert told is not None
    assert abs(float(told[1]) - aside[row["frame"] - 150]) < 3.0


def test_off_cycle_measures_what_was_planted():
    tracks, uv = sure_walk()
    uv[120, :, 1, 1] -= 9.0
    put(tracks, uv)
    away, off = off_cycle(tracks, RIG)
    assert np.median(off) < 2.0
    assert abs(off[120, 1] - 9.0) < 2.0
    assert away[120].argmax() == 1
    still = tracks.copy(deep=True)
    still["position"].values[:] = still["position"].values[:1]
    assert np.isnan(off_cycle(still, RIG)[0]).all()


def test_what_no_view_shows_counts_less():
    tracks, _ = sure_walk()
    for first in (60, 200):
        tracks["sd"].values[first : first + 8, :, 0, 0] = 3.0
        tracks["image_confidence"].values[first : first + 8, :, 0, 0] = 0.5
    tracks["image_origin"].values[60:68, :, 0, 0] = ORIGIN_CODE["predicted"]
    table = find_suspects(tracks, rig=RIG)
    frames = table["frame"].to_numpy()
    hidden = frames[(frames >= 55) & (frames < 73)]
    assert 200 <= frames[0] < 208
    assert len(hidden)
    assert table["score"].iloc[0] > 1.3 * table.loc[table["frame"] == hidden[0], "score"].iloc[0]


def test_what_swings_counts_less_than_what_stands():
    """FR is as vague twice, 6 frames in stance and 6 in swing: only swing moves against
    the ground, which standing paws go with."""
    tracks, _ = sure_walk()
    # 15 frames back with the belt, 2 mm each, then 10 forward, 3 mm each
    x = np.interp((np.arange(300)[:, None] + [0, 12]) % 25, [0, 15, 25], [15.0, -15.0, 15.0])
    xyz = np.stack([np.add(x, [150, 90]), np.full(x.shape, 20.0), np.zeros(x.shape)], axis=-1)
    put(tracks, np.moveaxis(RIG.project(xyz), 1, 2))
    for stance, swing in ((104, 217), (204, 117)):  # whichever comes first
        both = tracks.copy(deep=True)
        for first in (stance, swing):
            both["sd"].values[first : first + 6, :, 0, 0] = 3.0
        frames = find_suspects(both, rig=RIG)["frame"].to_numpy()
        assert stance <= frames[0] < stance + 6
        assert ((frames >= swing) & (frames < swing + 6)).any()


def test_the_view_told_is_one_that_shows_the_point():
    tracks, _ = sure_walk()
    tracks["image_confidence"].values[200:207, :, 1, 0] = 0.3
    for hidden, shown in (("cam1", "cam2"), ("cam2", "cam1")):
        one = tracks.copy(deep=True)
        v = RIG.names.index(hidden)
        one["image_origin"].values[200:207, v, 1, 0] = ORIGIN_CODE["reprojected"]
        one["image_confidence"].values[200:207, v, 1, 0] = 0.0
        assert first_row(one)["view"] == shown


def test_points_that_meet_are_told():
    tracks, uv = sure_walk()
    uv[100:105, :, 0] = uv[100:105, :, 1] + 3.0
    put(tracks, uv)
    found = collect_uncertainty(tracks, rig=RIG, other=None, paw_px=None)
    [meeting] = [x for x in found if "mistaken" in x.words((102, 0, 0))]
    assert set(np.flatnonzero(meeting.score[:, 0, 0] > 0.9 * meeting.score.max())) == set(
        range(100, 105)
    )
    # 3 px to the right and 3 px down
    assert meeting.words((102, 0, 0)) == "it is 4 px from HR: they may be mistaken"


def test_a_point_placed_by_hand_in_one_view_is_not_doubted():
    tracks, _ = sure_walk()
    tracks["image_confidence"].values[200:207, :, 1, 0] = 0.3
    tracks["image_origin"].values[198:209, 0, 1, 0] = ORIGIN_CODE["edited"]
    table = find_suspects(tracks, rig=RIG)
    assert not ((table["point"] == "HR") & table["frame"].between(198, 208)).any()


def test_tracks_without_positions():
    empty = make_tracks(range(50), ["FR", "HR"], fps=250.0, views=["cam1", "cam2"])
    empty["sd"] = empty["position"].copy()
    assert not states_uncertainty(empty)
    tracks, _ = sure_walk()
    assert states_uncertainty(tracks)
    for name in ("position", "image_position", "sd"):
        tracks[name].values[50:] = np.nan
        tracks[name].values[:, ..., 1, :] = np.nan
    tracks["image_origin"].values[50:] = ORIGIN_CODE["missing"]
    tracks["sd"].values[20:26, :, 0, 0] = 3.0
    table = find_suspects(tracks, rig=RIG)
    assert 20 <= table["frame"].iloc[0] <= 25
    assert (table["point"] == "FR").all()
