"""Suspects of tracks that carry their uncertainty: planted doubts come first, in words."""

import re

import numpy as np
from walking_tracks import RIG, put, walk

from pawnb.core.suspects.frames import SuspectSettings, find_suspects
from pawnb.core.suspects.uncertainty import collect_doubts, off_cycle, states_uncertainty
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
    tracks["image_confidence"].values[200:212, :, 1, 0] = 0.3
    row = first_row(tracks)
    assert 200 <= row["frame"] <= 211
    assert row["point"] == "HR"
    told = re.search(r"hardly recognised here \(confidence ([\d.]+)\)", row["reason"])
    assert told is not None
    assert 0.3 <= float(told[1]) < 0.65  # averaged over 9 frames, 5 of them within at least
    # one poor frame is no doubt: paws flicker
    tracks["image_confidence"].values[60, :, 0, 0] = 0.1
    assert 200 <= first_row(tracks)["frame"] <= 211


def test_a_vague_place():
    tracks, _ = sure_walk()
    tracks["sd"].values[100:110, :, 0, 0] = 3.0
    row = first_row(tracks)
    assert 100 <= row["frame"] <= 109
    # three axes of 3 mm and of about 0.3 mm: times the square root of 3
    assert "only known to 5.2 mm (usually 0.5)" in row["reason"], row["reason"]


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
    # the reason may be that of a frame some before or later, and says so
    when = re.match(r"in frame (\d+), ", row["reason"])
    frame = row["frame"] if when is None else int(when[1])
    assert abs(float(told[1]) - aside[frame - 150]) < 3.0


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
    tracks["image_confidence"].values[200:212, :, 1, 0] = 0.3
    for hidden, shown in (("cam1", "cam2"), ("cam2", "cam1")):
        one = tracks.copy(deep=True)
        v = RIG.names.index(hidden)
        one["image_origin"].values[200:212, v, 1, 0] = ORIGIN_CODE["reprojected"]
        one["image_confidence"].values[200:212, v, 1, 0] = 0.0
        assert first_row(one)["view"] == shown
        # only in the frame that is listed, whose doubt may be that of a frame beside it
        one = tracks.copy(deep=True)
        one["image_confidence"].values[200:212, v, 1, 0] = 0.2
        listed = first_row(one)["frame"]
        one["image_origin"].values[listed, v, 1, 0] = ORIGIN_CODE["reprojected"]
        row = first_row(one)
        assert (row["frame"], row["view"]) == (listed, shown)


def test_points_that_meet_are_told():
    tracks, uv = sure_walk()
    uv[100:105, :, 0] = uv[100:105, :, 1] + 3.0
    put(tracks, uv)
    found = collect_doubts(tracks, rig=RIG, other=None, paw_px=40.0)
    [meeting] = [x for x in found if "near" in x.measures]
    near = meeting.measures["near"][:, 0]
    assert set(np.flatnonzero(near < 0.12)) == set(range(100, 105))
    # 3 px to the right and 3 px down, of 40
    np.testing.assert_allclose(near[102], np.hypot(3, 3) / 40)
    assert meeting.words(102, 0) == "it is 4 px from HR: they may be mistaken"


def test_landmarks_neither_cross_nor_lift_off():
    """An ear is always near the other one, and does not go with the ground."""
    tracks, uv = sure_walk()
    uv[:, :, 0] = uv[:, :, 1] + 3.0
    put(tracks, uv)
    names = tracks["keypoint"].to_numpy().tolist()
    as_ears = tracks.assign_coords(keypoint=["ear_L", "ear_R", *names[2:]])
    for one, known in ((tracks, True), (as_ears, False)):
        for doubt in collect_doubts(one, rig=RIG, other=None, paw_px=40.0):
            if {"near", "pace"} & set(doubt.measures):
                for measure in doubt.measures.values():
                    assert (np.isfinite(measure[:, :2]).all() if known
                            else np.isnan(measure[:, :2]).all())  # fmt: skip


def test_a_point_moved_when_the_stride_was_known():
    tracks, _ = sure_walk()
    tracks["revision"] = tracks["residual"].copy()

    def row_near_107(moved):
        tracks["revision"].values[104:112, 0, 0] = moved
        table = find_suspects(tracks, rig=RIG, settings=SuspectSettings(least_score=1e-4))
        [row] = table[table["frame"].between(101, 114) & (table["point"] == "FR")].to_dict(
            "records"
        )[:1]
        return row

    tracks["revision"].values[:] = 0.0
    calm, moved, unknown = row_near_107(0.0), row_near_107(80.0), row_near_107(np.nan)
    assert "a first look, before the stride was known, had it 80.0" in moved["reason"]
    assert "a first look" not in calm["reason"]
    # 80 mm are more than four paws here, and eight in eleven frames that one look shows
    assert moved["score"] > 2 * calm["score"]
    assert unknown["score"] < 1.2 * calm["score"]


def with_measures():
    """A walk whose candidates are well ahead of others, and whose passes agree as is usual.

    FR is vague from 64 to 67, and from 214 to 217: the second half is as the first, six strides.
    """
    tracks, uv = sure_walk()
    uv[150:] = uv[:150]
    put(tracks, uv)
    tracks["sd"].values[64:68, :, 0, 0] = 3.0
    tracks["sd"].values[150:] = tracks["sd"].values[:150]
    tracks["image_separation"] = tracks["image_confidence"].copy()
    tracks["image_separation"].values[:] = 6.0
    tracks["passes_apart"] = tracks["residual"].copy()
    tracks["passes_apart"].values[:] = 0.2
    return tracks


def scores_at(tracks):
    """The scores of the two places, as they are listed."""
    table = find_suspects(tracks, rig=RIG, settings=SuspectSettings(least_score=1e-6))
    table = table[table["point"] == "FR"]
    return [table[table["frame"].between(t - 5, t + 8)]["score"].max() for t in (64, 214)]


def test_a_frame_whose_candidates_are_not_separated_ranks_higher():
    scores = []
    for separation in (6.0, 1.5, 0.0, -2.0):
        tracks = with_measures()
        # in one of two views, all else equal
        tracks["image_separation"].values[64:68, 1, 0, 0] = separation
        scores.append(scores_at(tracks))
    assert (np.diff(np.array(scores)[:, 0]) > 0).all(), scores
    np.testing.assert_allclose(np.array(scores)[:, 1], scores[0][1], rtol=0.01)
    # what comes first is told by nothing else
    for first in (64, 214):
        one = with_measures()
        one["image_separation"].values[first : first + 4, 1, 0, 0] = -2.0
        assert first <= first_row(one)["frame"] < first + 4
    doubt = next(x for x in collect_doubts(tracks, rig=RIG, other=None, paw_px=None)
                 if "separation" in x.measures)  # fmt: skip
    np.testing.assert_array_equal(np.flatnonzero(doubt.measures["separation"][:, 0] < 6),
                                  range(64, 68))  # fmt: skip
    # exp(2) is 7
    assert doubt.words(65, 0) == "in cam2 another candidate fits it better by itself (7 to 1)"
    assert doubt.words(90, 0) == "in cam1 its candidate is little ahead of another (403 to 1)"
    # exp(30) is 1e13, which says no more than that it is much
    tracks["image_separation"].values[65, 1, 0, 0] = -30.0
    doubt = next(x for x in collect_doubts(tracks, rig=RIG, other=None, paw_px=None)
                 if "separation" in x.measures)  # fmt: skip
    assert doubt.words(65, 0).endswith("fits it better by itself (over 1000 to 1)")
    # the view that is least separated counts, and one that took none does not
    tracks["image_separation"].values[50, 0, 0, 0] = np.nan
    doubt = next(x for x in collect_doubts(tracks, rig=RIG, other=None, paw_px=None)
                 if "separation" in x.measures)  # fmt: skip
    assert doubt.measures["separation"][50, 0] == 6.0


def test_a_frame_whose_passes_are_apart_ranks_higher():
    scores = []
    for apart in (0.2, 0.6, 1.5):
        tracks = with_measures()
        tracks["passes_apart"].values[64:68, 0, 0] = apart
        scores.append(scores_at(tracks)[0])
    assert (np.diff(scores) > 0).all(), scores
    for first in (64, 214):
        one = with_measures()
        one["passes_apart"].values[first : first + 4, 0, 0] = 1.5
        assert first <= first_row(one)["frame"] < first + 4
    doubt = next(x for x in collect_doubts(tracks, rig=RIG, other=None, paw_px=None)
                 if "apart" in x.measures)  # fmt: skip
    said = "passes forwards and backwards are 1.5 standard deviations apart (usually 0.2)"
    assert doubt.words(65, 0) == said


def test_tracks_without_the_two_measures_are_listed_as_before():
    tracks = with_measures()
    without = tracks.drop_vars(["image_separation", "passes_apart"])
    for name in ("image_separation", "passes_apart"):
        tracks[name].values[:] = np.nan
    np.testing.assert_array_equal(
        find_suspects(tracks, rig=RIG)["frame"], find_suspects(without, rig=RIG)["frame"]
    )


def test_two_passes_that_disagree_are_told_in_px():
    tracks, uv = sure_walk()
    other = tracks.copy(deep=True)
    away = uv.copy()
    away[200:206, :, 1] += [0.0, 40.0]
    put(other, away)
    row = find_suspects(tracks, rig=RIG, other=other).iloc[0]
    assert 200 <= row["frame"] <= 205
    assert row["point"] == "HR"
    assert "two passes through the recording disagree by 40 px" in row["reason"]


def test_a_doubt_beside_the_listed_frame_is_told_where_it_is():
    tracks, _ = sure_walk()
    # FR and HR are vague one after the other, and one look shows both
    tracks["sd"].values[100, :, 0, 0] = 30.0
    tracks["sd"].values[103, :, 1, 0] = 30.0
    rows = find_suspects(tracks, rig=RIG)
    rows = rows[rows["frame"] == rows["frame"].iloc[0]]
    assert rows["frame"].iloc[0] in (100, 103)
    told = dict(zip(rows["point"], rows["reason"], strict=True))
    here, there = ("FR", "HR") if rows["frame"].iloc[0] == 100 else ("HR", "FR")
    assert told[here].startswith("its place is only known to 52.0 mm")
    way = "in frame 103, 3 later" if here == "FR" else "in frame 100, 3 before"
    assert told[there].startswith(f"{way}: its place is only known to 52.0 mm")


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
