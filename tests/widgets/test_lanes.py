"""What the lanes of the timeline show, worked out by hand from small tracks."""

import numpy as np
import pandas as pd
import pytest
import small_trial as scene

from pawnb import load_trial
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.widgets.lanes import (
    FULL,
    IS_EDITED,
    IS_PREDICTED,
    STANCE,
    SUSPECT,
    UNKNOWN_LEVEL,
    build_lanes,
    find_stances,
    sd_scale,
)


def tracks_of(frames=(3, 4, 6)):
    """Two points in two views, measured with confidence 0.8; frame 5 is absent."""
    tracks = make_tracks(list(frames), ["P", "Q"], fps=100.0, views=["a", "b"], unit="px")
    tracks["image_position"].to_numpy()[:] = 1.0
    tracks["image_origin"].to_numpy()[:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"].to_numpy()[:] = 0.8
    return tracks


def test_confidence_is_the_best_of_the_views_and_absent_frames_are_missing():
    tracks = tracks_of()
    tracks["image_confidence"].to_numpy()[1, :, 0, 0] = [0.2, 0.5]
    tracks["image_origin"].to_numpy()[2, 0, 0, 0] = ORIGIN_CODE["missing"]
    tracks["image_origin"].to_numpy()[2, 1, 0, 0] = ORIGIN_CODE["reprojected"]
    lanes = build_lanes(tracks, ["P", "Q"])
    assert lanes.shape == (2, 4, 3)
    # frames 3 to 6: 0.8 of 250, 0.5 of 250, absent, seen in no view
    assert lanes[0, :, 0].tolist() == [200, 125, UNKNOWN_LEVEL, UNKNOWN_LEVEL]
    assert lanes[1, :, 0].tolist() == [200, 200, UNKNOWN_LEVEL, 200]


def test_bits_say_what_was_done_and_doubted():
    tracks = tracks_of()
    tracks["image_origin"].to_numpy()[0, 1, 0, 0] = ORIGIN_CODE["edited"]
    tracks["image_origin"].to_numpy()[1, :, 1, 0] = ORIGIN_CODE["predicted"]
    tracks["image_origin"].to_numpy()[2, 0, 1, 0] = ORIGIN_CODE[
        "predicted"
    ]  # seen in the other view
    doubts = pd.DataFrame([[4, "a", "P, Q"], [99, "a", "P"]], columns=["frame", "view", "point"])
    stances = {"Q": [(0.025, 0.045)], "unknown": [(0.0, 1.0)]}
    lanes = build_lanes(tracks, ["P", "Q"], suspects=doubts, stances=stances)
    assert lanes[0, :, 2].tolist() == [IS_EDITED, SUSPECT, 0, 0]
    assert lanes[1, :, 2].tolist() == [STANCE, IS_PREDICTED | SUSPECT | STANCE, 0, 0]


def test_standard_deviations_fill_the_lane_at_the_scale_that_is_told():
    tracks = tracks_of()
    assert sd_scale(tracks) == 0.0
    assert (build_lanes(tracks, ["P"])[..., 1] == UNKNOWN_LEVEL).all()
    tracks["sd"] = tracks["position"].copy()
    tracks["sd"].to_numpy()[:] = np.array([3.0, 6.0, 12.0])[:, None, None, None]
    assert sd_scale(tracks) == pytest.approx(12.0, rel=0.02)
    # half of the scale, all of it, more than all
    assert build_lanes(tracks, ["P"], sd_full=6.0)[0, :, 1].tolist() == [
        125,
        FULL,
        UNKNOWN_LEVEL,
        FULL,
    ]


def test_a_foot_that_stands_has_a_stance_and_points_that_are_no_legs_none(tmp_path):
    """HR stands in the scene, FR glides without ever stopping: neither has events, so no bars."""
    trial = load_trial(scene.describe_trial(tmp_path))
    assert find_stances(scene.true_tracks(), trial) == {}
    walking = scene.true_tracks()
    # three strides of 12 frames: back at 2 mm a frame for 8 frames, forwards 4 mm for 4
    step = np.concatenate([np.full(8, -2.0), np.full(4, 4.0)])
    walking["position"].to_numpy()[:, 0, 0, 0] = np.cumsum(np.resize(step, scene.N_FRAMES))
    bars = find_stances(walking, trial)["FR"]
    lengths = [end - begin for begin, end in bars if begin > 0.01 and end < 0.145]
    assert lengths
    # 8 frames of 250 a second, smoothed by the low-pass: within a frame or so
    np.testing.assert_allclose(lengths, 8 / scene.FPS, atol=1.5 / scene.FPS)
