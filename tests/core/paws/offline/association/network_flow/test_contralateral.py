"""Paws of the other side that nobody clicked, followed as points of their own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline.association.network_flow.contralateral import (
    assign_near_side,
    near_side_cost,
    share_observed,
    side_cost,
    with_contralateral,
)
from pawnb.core.paws.offline.association.network_flow.links import FlowCosts
from pawnb.core.paws.offline.association.network_flow.min_cost_flow import MinCostFlow
from pawnb.core.paws.offline.association.network_flow.tracklet_association import TrackletAssociator
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet
from pawnb.core.paws.offline.association.network_flow.triangulation import Volume
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.bottom_view import BottomView
from pawnb.core.paws.offline.scene.clicks import unlabelled_kinds
from pawnb.core.paws.offline.scene.geometry import lateral_offset
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.scene.views import SideViews, SingleView
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial
from pawnb.workflow.evaluation.errors import count_errors

UP, FORWARD = np.array([0.0, -1.0]), np.array([1.0, 0.0])
COSTS = FlowCosts(0.5, 0.3, 2.0, np.zeros(2), 3.0, 2.0, 30, 16)
N, STRIDE, SPAN = 240, 32.0, 90.0


def tracklet(path, first, last):
    frames = np.arange(first, last + 1)
    return Tracklet(first, list(frames), path[first : last + 1], np.zeros(len(frames)))


def walk():
    """Four paws in a side view (n, 4, 2): near front, near hind, far front, far hind."""
    phase = (np.arange(N)[:, None] / STRIDE + np.array([0.0, 0.5, 0.5, 0.0])) % 1.0
    s = np.clip((phase - 0.6) / 0.4, 0.0, 1.0)
    swing = 10 * s**3 - 15 * s**4 + 6 * s**5
    ahead = np.where(phase < 0.6, 25 - 50 * phase / 0.6, -25 + 50 * swing)
    home = np.array([[340.0, 200.0], [260.0, 200.0], [345.0, 190.0], [265.0, 190.0]])
    return home + np.stack([ahead, -16 * s**2 * (1 - s) ** 2 * 8.0], axis=-1)


def scene(truth):
    return Scene(
        SingleView(Projection(None), 6.0, np.full(1, 6.0), [(0.7, 0.7)], UP),
        0, {0: {0: truth[0, 0], 1: truth[0, 1]}}, SPAN, [], [], UP, FORWARD,
    )  # fmt: skip


def test_only_kinds_clicked_once_have_strangers():
    assert unlabelled_kinds(["front", "hind"]) == ["front", "hind"]
    assert unlabelled_kinds(["front", "hind", "front", "hind"]) == []
    assert unlabelled_kinds(["hind", "other", "other"]) == ["hind"]


def test_strangers_are_seen_by_the_views_of_their_kind():
    tracked = np.array([[True, False], [True, True]])
    own = with_contralateral(tracked, ("front", "hind"), ["hind"])
    np.testing.assert_array_equal(own, [[True, True], [False, True], [False, True]])


def test_a_stranger_takes_the_pieces_that_are_left_from_anywhere():
    t = np.arange(40.0)
    own, other = np.column_stack([t, 0 * t]), np.column_stack([30.0 - t, 0 * t + 5.0])
    tracklets = [tracklet(own, 1, 39), tracklet(other, 4, 20), tracklet(other, 23, 39)]
    flow = MinCostFlow(tracklets, {0: {0: own[0]}}, 40, COSTS, contralateral=1)
    assert flow.assign() == [[0], [1, 2]]
    # without one they stay over
    assert MinCostFlow(tracklets, {0: {0: own[0]}}, 40, COSTS).assign() == [[0]]


def test_paths_through_the_crossings_of_near_and_far_paws():
    truth = walk()
    found = []
    for at in truth:
        rows = np.zeros((4, 8), np.float32)
        rows[:, :2], rows[:, 2:6] = at, (3.0, 4.0, 0.22, 4.0)
        found.append([ColourDetections(rows)])
    setting = scene(truth)
    kinds = ["front", "hind", "front", "hind"]
    shares = []
    for count in (4, 2):
        paths = TrackletAssociator(
            found,
            setting.anchors,
            setting,
            fps=250.0,
            settings=OfflineSettings(),
            kinds=kinds[:count],
            likelihood=AppearanceLikelihood(setting.limb_direction, setting.paw_width_px),
            tracked_in_view=np.ones((count, 1), bool),
        )
        x = paths.first()[:, :2]
        seen = np.isfinite(x[..., 0])
        right = np.linalg.norm(x - truth[:, :2], axis=-1)[seen] < 3.0
        shares.append((right.mean(), seen.mean()))
    assert shares[0][0] > 0.97
    assert shares[0][1] > 0.8
    assert shares[1][0] < 0.9


def test_the_lower_path_of_a_kind_is_that_of_the_clicked_point():
    truth = walk()
    changed = truth[:, [2, 1, 0, 3]].copy()
    kinds = ["front", "hind", "front", "hind"]
    back = assign_near_side(
        changed, scene(truth).anchors, scene(truth), body=truth.mean(axis=1), kinds=kinds, clicked=2
    )
    np.testing.assert_array_equal(back[1:], truth[1:])
    np.testing.assert_array_equal(back[0, :2], truth[0, :2])
    assert np.isnan(back[0, 2:]).all()


# the animal faces +x, its left side is at +y, and it drifts to its right by a quarter of what its
# left and right paws are apart
ACROSS, WIDE, LONG = np.array([0.0, 1.0, 0.0]), 20.0, 50.0
BODY = np.column_stack(
    [0.5 * np.arange(40.0), 7.0 - 0.25 * WIDE * np.arange(40.0) / 39.0, np.zeros(40)]
)
LEFT, RIGHT = BODY + 0.5 * WIDE * ACROSS, BODY - 0.5 * WIDE * ACROSS
CLICKED = {0: {0: LEFT[0], 1: LEFT[0] - [LONG, 0, 0]}}
KINDS = ["front", "hind", "front", "hind"]


BEFORE, BEHIND = ([0.0, 300.0, 20.0], [40.0, 320.0, 30.0]), [0.0, -300.0, 20.0]


def scene_in_space(*below, cameras=(BEFORE[0], BEHIND)):
    """Views from the side; with the number and height of a view from below, that one leads."""
    volume = Volume(np.array([0.0, 0.0, 1.0]), ACROSS, (-9.0, 9.0), (-60.0, 60.0))
    rig = Projection(np.stack([camera(at) for at in cameras], axis=1))
    geometry = BottomView if below else SideViews
    return SimpleNamespace(
        geometry=geometry(rig, 1.0, np.ones(2), [(0.7, 0.7)] * 2, volume, *below),
        body_scale=LONG, up=volume.up, anchors=CLICKED,
    )  # fmt: skip


def camera(at):
    """DLT coefficients of a camera that looks at the animal along the way across."""
    ahead = -np.sign(at[1])
    look = np.array([[ahead, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, ahead, 0.0]])
    P = np.diag([900.0, 900.0, 1.0]) @ np.column_stack([look, -look @ np.asarray(at)])
    return (P / P[2, 3]).ravel()[:11]


def test_how_far_aside_a_place_is_is_told_from_the_body():
    since = {0: {0: LEFT[0] - BODY[0]}, 9: {0: LEFT[9] - BODY[9]}}
    away = [
        lateral_offset(side, since, body=BODY, point=0, across=ACROSS)
        for side in (LEFT, RIGHT, LEFT + 3.0 * ACROSS)
    ]
    np.testing.assert_allclose(away, np.repeat([[0.0], [-WIDE], [3.0]], 40, axis=1), atol=1e-9)


def test_it_costs_a_clicked_paw_to_go_to_the_other_side():
    tracklets = [tracklet(LEFT, 30, 39), tracklet(RIGHT, 30, 39), tracklet(RIGHT, 20, 24)]
    cost = side_cost(tracklets, CLICKED, scene_in_space(), body=BODY, kinds=KINDS)
    # the other side is 20 = 4 standard deviations of 0.1 spans away, which 6 squared ones limit
    np.testing.assert_allclose(cost, [[0, 30, 15], [0, 30, 15], [0, 0, 0], [0, 0, 0]], atol=1e-9)


@pytest.mark.parametrize("mirrored", [False, True])
def test_it_costs_a_stranger_to_be_on_the_side_of_the_clicks_and_of_all_cameras(mirrored):
    """Left paws are clicked and the cameras stand to the left; or all of it the other way round."""
    mirror = np.array([1.0, -1.0, 1.0]) if mirrored else np.ones(3)
    at = [LEFT, RIGHT, LEFT - 0.3 * WIDE * ACROSS, LEFT + WIDE * ACROSS]
    tracklets = [tracklet(one * mirror, 30, 39) for one in at]
    clicked = {0: {p: one * mirror for p, one in CLICKED[0].items()}}
    beside = scene_in_space(cameras=[np.array(one) * mirror for one in BEFORE])
    cost = near_side_cost(tracklets, clicked, beside, body=BODY * mirror, kinds=KINDS)
    # it is 0.2 spans = 10 short of the far side on the near one, two standard deviations; 4 short
    # where it is 6 away; three squared ones at most; for ten frames
    expected = [20.0, 0.0, 10 * 0.5 * 0.8**2, 30.0]
    np.testing.assert_allclose(cost, [[0] * 4] * 2 + [expected] * 2, atol=1e-9)
    both = side_cost(tracklets, clicked, beside, body=BODY * mirror, kinds=KINDS)
    np.testing.assert_allclose(both[2:], cost[2:])
    assert (both[:2, 1] == 30.0).all()


def test_strangers_have_no_side_with_cameras_on_both_or_without_depth():
    tracklets = [tracklet(LEFT, 30, 39)]
    assert not near_side_cost(tracklets, CLICKED, scene_in_space(), body=BODY, kinds=KINDS).any()
    from_below = scene_in_space(1, 0.0, cameras=BEFORE)
    assert not near_side_cost(tracklets, CLICKED, from_below, body=BODY, kinds=KINDS).any()
    assert near_side_cost([], CLICKED, scene_in_space(), body=BODY, kinds=KINDS).shape == (4, 0)


def test_the_side_costs_nothing_where_both_paws_are_clicked_or_no_depth_tells():
    tracklets = [tracklet(RIGHT, 30, 39)]
    both = {0: {**CLICKED[0], 2: RIGHT[0], 3: RIGHT[0] - [LONG, 0, 0]}}
    assert not side_cost(tracklets, both, scene_in_space(), body=BODY, kinds=KINDS).any()
    from_below = scene_in_space(1, 0.0)
    assert not side_cost(tracklets, CLICKED, from_below, body=BODY, kinds=KINDS).any()
    assert side_cost([], CLICKED, scene_in_space(), body=BODY, kinds=KINDS).shape == (4, 0)


def test_a_stranger_on_the_side_of_the_clicks_is_not_a_paw_of_its_own():
    x = np.full((40, 4, 3), np.nan)
    x[:, 2] = RIGHT
    x[10:, 3] = LEFT[10:] - [LONG, 0, 0]
    x[30:, 3] = RIGHT[30:] - [LONG, 0, 0]
    share = share_observed(x, CLICKED, scene_in_space(), body=BODY, kinds=KINDS)
    np.testing.assert_allclose(share, [1.0, 0.25])
    # without depth all that is seen counts
    flat = share_observed(x, CLICKED, scene_in_space(1, 0.0), body=BODY, kinds=KINDS)
    np.testing.assert_allclose(flat, [1.0, 0.75])


def test_paths_are_exchanged_by_their_side_of_an_animal_that_drifts():
    # the clicked paw is seen late only: then it is farther from its click than the other one was
    # in most frames
    substrate_velocity = BODY + np.linspace(0.0, 1.25 * WIDE, 40)[:, None] * ACROSS
    left, right = substrate_velocity + 0.5 * WIDE * ACROSS, substrate_velocity - 0.5 * WIDE * ACROSS
    x = np.full((40, 4, 3), np.nan)
    x[30:, 0], x[:, 2] = left[30:], right
    x[:, 1] = x[:, 3] = left - [LONG, 0, 0]
    anchors = {0: {0: left[0], 1: left[0] - [LONG, 0, 0]}}
    kept = assign_near_side(
        x, anchors, scene_in_space(), body=substrate_velocity, kinds=KINDS, clicked=2
    )
    np.testing.assert_array_equal(kept[1:], x[1:])
    x[:, [0, 2]] = x[:, [2, 0]]
    back = assign_near_side(
        x, anchors, scene_in_space(), body=substrate_velocity, kinds=KINDS, clicked=2
    )
    np.testing.assert_array_equal(back[1:], kept[1:])


def track_one_view(trial, view):
    """Track one view of a trial by itself; return how its labels compare with the truth."""
    start = pd.read_csv(trial.folder / "start.csv")
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    points = {view.name: view.points}
    rig = load_rig(trial)
    with open_views(replace(trial, views=(view,), calibration=None)) as views:
        facing = {view.name: rig.facing(view.name)}
        task = TrackingRequest(points_by_view=points, fps=trial.fps, frames=(0, 200), facing=facing)
        clicks = start[start["view"] == view.name]
        tracks = track_treadmill(views, clicks, task, settings=OfflineSettings())
    # 20 px in a picture 2048 px wide is the evaluation's limit of a wrong label
    return count_errors(tracks, truth[truth["view"] == view.name], points_by_view=points,
                        threshold_px=20 * 0.35, hidden_px=10 * 0.35)  # fmt: skip


@pytest.mark.slow
def test_one_view_of_a_rendered_mouse_without_a_calibration(tmp_path):
    """Without a second picture some recordings go wrong for a long while (up to half of the
    labels), others hardly: what holds is the middle of several, here two scenes of four
    cameras, each by itself (2 % when this was last measured; 14 % with colours learnt as
    close to two clicks as to eight)."""
    reports = []
    for seed in (1, 2):
        folder = render_mouse_trial(tmp_path / str(seed), frames=200, scale=0.35, seed=seed)
        trial = load_trial(folder)
        reports += [track_one_view(trial, view) for view in trial.views]
    assert np.median([report.share_wrong for report in reports]) < 0.12
    assert np.median([report.median_px for report in reports]) < 2.0
