"""Paths chosen among places of a made-up walk of four paws, with what is no paw between them."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.priors.positional_prior import (
    first_positional_cost,
    where_kinds_are,
)
from pawnb.core.paws.offline.association.network_flow.tracklet_association import TrackletAssociator
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses, Volume
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.scene.views import SideViews, observed_elsewhere
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.stride.cycle import learn_cycle

LINEAR = np.zeros((11, 3))
LINEAR[:8] = np.array(
    [[4, 0, 0, 300, 0, 0, -4, 100], [2.8, 2.8, 0, 300, 0, 0, -4, 200], [3, -2, 1, 300, 1, 0, -4, 9]]
).T
RIG = Projection(LINEAR)
SPAN, THICKNESS, N, STRIDE = 60.0, 4.0, 160, 32.0
HOME = np.array([[20, 10, 0], [-20, 10, 0], [20, -10, 0], [-20, -10, 0.0]])
LAG = np.array([0.0, 0.5, 0.5, 0.0])
KINDS = ("front", "hind", "front", "hind")
VOLUME = Volume(np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), (-10.0, 20.0), (-40.0, 40.0))
FPS = 250.0


def walk():
    """Truth (n, 4, 3): stance at the belt's speed, swing forward and up."""
    phase = (np.arange(N)[:, None] / STRIDE + LAG) % 1.0
    s = np.clip((phase - 0.65) / 0.35, 0.0, 1.0)
    swing = 10 * s**3 - 15 * s**4 + 6 * s**5
    ahead = np.where(phase < 0.65, 12 - 24 * phase / 0.65, -12 + 24 * swing)
    up = 16 * s**2 * (1 - s) ** 2 * 4.0
    return HOME + np.stack([ahead, 0 * ahead, up], axis=-1)


def scene(truth, clicked=0):
    anchors = {clicked: dict(enumerate(truth[clicked]))}
    return Scene(
        SideViews(RIG, THICKNESS, np.full(3, 16.0), [(0.6, 0.8)] * 3, VOLUME), min(anchors),
        anchors, SPAN, [], [], VOLUME.up, np.array([1.0, 0.0, 0.0]),
    )  # fmt: skip


def candidates(truth, hidden, seed=0, share=0.22, thing=None, n=N):
    """Detections of every frame and view: the paws, and things that come and go.

    ``thing``: first frame and position of one that stays to the end.
    """
    rng = np.random.default_rng(seed)
    uv = RIG.project(truth)
    found = []
    for t in range(n):
        here = []
        for v in range(3):
            at = [uv[t, p, v] for p in range(4) if not hidden[t, p]]
            if thing is not None and t >= thing[0]:
                at.append(RIG.project(thing[1])[v])
            at = np.array([*at, *rng.uniform([150, 50], [450, 250], (3, 2))])
            rows = np.zeros((len(at), 8), np.float32)
            rows[:, :2] = at + 0.8 * rng.normal(size=at.shape)
            rows[:, 2:6] = 3.0, 4.0, share, 4.0
            rng.shuffle(rows)
            here.append(ColourDetections(rows))
        found.append(here)
    return found


def choice(truth, hidden, clicked=0, **looks):
    what = scene(truth, clicked)
    return TrackletAssociator(
        candidates(truth, hidden, **looks),
        what.anchors,
        what,
        fps=FPS,
        settings=OfflineSettings(),
        kinds=KINDS,
        likelihood=AppearanceLikelihood([(0.6, 0.8)] * 3, np.full(3, 16.0)),
        tracked_in_view=np.ones((4, 3), bool),
    )


@pytest.fixture(scope="module")
def walked():
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    hidden[40:48, 0] = hidden[90:101, 1] = hidden[92:97, 2] = True
    paths = choice(truth, hidden)
    return truth, hidden, paths, paths.first()


def agreement(x, truth, hidden):
    """Share of places chosen where paws are seen, and the farthest of all chosen from its paw."""
    chosen = np.isfinite(x[..., 0])
    away = np.linalg.norm(x - truth, axis=-1)
    return chosen[~hidden].mean(), away[chosen].max()


def test_paws_that_look_poor_at_the_clicks_are_followed_all_the_same():
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    paths = choice(truth, hidden, share=0.35)  # toes spread: hardly an end
    seen, farthest = agreement(paths.first(), truth, hidden)
    assert seen > 0.9
    assert farthest < THICKNESS


def test_a_hidden_paw_does_not_follow_what_only_the_views_of_the_other_side_show():
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    hidden[60:100, 1] = True
    found = candidates(truth, hidden)
    # beside the other hind paw, seen by the views that track that side; the first looks along y
    end = truth[:, 3] + [-9.0, 16.0, 0.0]
    beside = RIG.project(end)
    for t in range(60, 100):
        for v in (1, 2):
            row = np.zeros((1, 8), np.float32)
            row[0, :2], row[0, 2:6] = beside[t, v], (3.0, 4.0, 0.22, 4.0)
            found[t][v] = ColourDetections.joined([found[t][v], ColourDetections(row)])
    likelihood = AppearanceLikelihood([(0.6, 0.8)] * 3, np.full(3, 16.0))
    anchors = {0: dict(enumerate(truth[0]))}
    followed = []
    for tracked_in_view in (
        np.ones((4, 3)),
        np.array([[1, 0, 0], [1, 0, 0], [0, 1, 1], [0, 1, 1]]),
    ):
        x = TrackletAssociator(
            found,
            anchors,
            scene(truth),
            fps=FPS,
            settings=OfflineSettings(),
            kinds=KINDS,
            likelihood=likelihood,
            tracked_in_view=tracked_in_view.astype(bool),
        ).first()
        away = np.linalg.norm(x[60:100, 1] - end[60:100], axis=1)
        followed.append((away < THICKNESS).mean())
    assert followed[0] > 0.25
    assert followed[1] < 0.1


def test_a_place_is_seen_elsewhere_where_its_own_views_show_less_than_all():
    # by hand: both views of its own; none of them but two others; one of each; only one view
    seen = np.array([[1, 1, 0, 0], [0, 0, 1, 1], [1, 0, 1, 0], [0, 0, 0.5, 0]])
    tracked_in_view = np.array([[1, 1, 0, 0], [0, 0, 1, 0]], bool)
    np.testing.assert_allclose(
        observed_elsewhere(seen, tracked_in_view), [[0, 1, 0.5, 0.25], [1, 0, 0, 0]]
    )


def test_being_hidden_costs_as_much_whatever_the_frame_rate():
    truth = walk()
    chosen = []
    for every in (1, 2):
        some = np.zeros((N, 4), bool)
        paths = TrackletAssociator(
            candidates(truth, some)[::every],
            {0: dict(enumerate(truth[0]))},
            scene(truth),
            fps=FPS / every,
            settings=OfflineSettings(),
            kinds=KINDS,
            likelihood=AppearanceLikelihood([(0.6, 0.8)] * 3, np.full(3, 16.0)),
            tracked_in_view=np.ones((4, 3), bool),
        )
        chosen.append(paths._flow.costs.occlusion_frame_cost * len(range(0, N, every)))
    assert chosen[0] == pytest.approx(chosen[1])


def test_paws_of_an_animal_that_runs_through_the_picture_are_not_taken_for_each_other():
    # 1.2 spans farther at the end: hind paws then are where front paws were clicked
    truth = walk() + np.linspace(0.0, 1.2 * SPAN, N)[:, None, None] * np.array([1.0, 0.0, 0.0])
    usual = where_kinds_are(
        [PointHypotheses(x, np.zeros(4)) for x in truth],
        {0: dict(enumerate(truth[0]))},
        scene(truth),
        kinds=KINDS,
        frames=64,
    )
    for p in range(4):
        away = (usual[p] - truth[:, p, 0])[40:-40]
        assert np.abs(away).max() < 0.33 * SPAN  # nearer than this costs nothing


def test_every_paw_keeps_its_own_path(walked):
    truth, hidden, _, x = walked
    share, farthest = agreement(x, truth, hidden)
    assert share > 0.9
    # a paw is 4 thick, and no other is nearer than 20
    assert farthest < 2.5
    np.testing.assert_array_equal(x[0], truth[0])


def test_paths_are_chosen_again_by_the_stride(walked):
    truth, hidden, paths, _ = walked
    cycle = learn_cycle(
        np.where(hidden[..., None], np.nan, truth), paths.body(truth), axes=paths.motion_model.axes,
        frames=(16.0, 100.0), noise=1.0, trust=np.ones((N, 4)),
    )  # fmt: skip
    assert cycle.stride == pytest.approx(STRIDE, rel=0.03)
    share, farthest = agreement(paths.again(cycle), truth, hidden)
    assert share > 0.9
    assert farthest < 2.5


def test_a_paw_hidden_at_the_end_does_not_take_what_is_there():
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    hidden[150:, 1] = True
    beside = truth[150, 1] + [0.0, 3.0 * THICKNESS, 0.0]
    paths = choice(truth, hidden, thing=(150, beside))
    cycle = learn_cycle(
        np.where(hidden[..., None], np.nan, truth), paths.body(truth), axes=paths.motion_model.axes,
        frames=(16.0, 100.0), noise=1.0, trust=np.ones((N, 4)),
    )  # fmt: skip
    assert np.isnan(paths.again(cycle)[152:, 1]).all()


@pytest.mark.slow
def test_a_path_that_is_doubted_is_kept_unless_being_hidden_is_cheaper():
    truth, n = walk(), 40
    paths = choice(truth, np.zeros((N, 4), bool), n=n)
    kept = np.isfinite(paths.first()[..., 0])
    lost = np.zeros((n, 4), bool)
    lost[:, 2] = True
    doubted = paths.doubting(lost)  # no other paw wants it
    np.testing.assert_array_equal(np.isfinite(doubted.first()[..., 0]), kept)
    for _ in range(4):
        doubted = doubted.doubting(lost)
    x = doubted.first()
    assert np.isnan(x[1:, 2]).mean() > 0.9
    np.testing.assert_array_equal(np.isfinite(x[:, :2, 0]), kept[:, :2])
    np.testing.assert_array_equal(np.isfinite(paths.first()[..., 0]), kept)


def test_a_paw_may_have_wandered_farther_aside_where_only_its_side_was_clicked():
    """A place 6 = 0.1 spans aside of where a paw was clicked is one standard deviation off."""
    across, at = np.array([0.0, 1.0, 0.0]), np.tile([20.0, 16.0, 0.0], (10, 1))
    tracklets = [Tracklet(0, list(range(10)), at, np.zeros(10))]
    stage = SimpleNamespace(
        forward=np.array([1.0, 0.0, 0.0]), geometry=SimpleNamespace(across=across), body_scale=SPAN
    )
    anchors = {0: {0: HOME[0], 1: HOME[1]}}
    usual = [np.empty(0)] * 4
    assert first_positional_cost(tracklets, usual[:2], anchors, scene=stage)[0, 0] == pytest.approx(
        10 * 0.5
    )
    # with unlabelled targets it may be twice as far off
    assert first_positional_cost(tracklets, usual, anchors, scene=stage)[0, 0] == pytest.approx(
        10 * 0.5 / 4
    )


def test_the_manner_is_that_of_the_walk(walked):
    _, _, paths, _ = walked
    # the belt carries paws back by 24 in 0.65 strides
    np.testing.assert_allclose(
        paths.motion_model.substrate_velocity, [-24 / (0.65 * STRIDE), 0, 0], atol=0.15
    )
    np.testing.assert_allclose(paths.motion_model.axes, [[1, 0, 0], [0, 1, 0], [0, 0, 1]])


def test_the_body_is_the_middle_of_the_paws(walked):
    truth, _, paths, x = walked
    body = paths.body(x)
    assert body.shape == (N, 3)
    np.testing.assert_allclose(
        body[40:120, :2], truth.mean(axis=(0, 1))[:2] * np.ones((80, 2)), atol=2
    )


def test_places_seen_by_nobody_stay_open():
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    hidden[60:75] = True
    x = choice(truth, hidden).first()
    assert np.isnan(x[60:75]).mean() > 0.95
    assert agreement(x, truth, hidden)[1] < 2.5


def test_paths_go_both_ways_from_where_the_paws_were_clicked():
    """Also where front and hind paws are occluded, and one paw is, before the click and after."""
    truth = walk()
    hidden = np.zeros((N, 4), bool)
    hidden[40:48, 0] = hidden[90:101, 1] = hidden[92:97, 2] = hidden[:6, 3] = True
    paths = choice(truth, hidden, clicked=70)
    seen, farthest = agreement(paths.first(), truth, hidden)
    assert seen > 0.9
    assert farthest < THICKNESS
    x = paths.first()
    assert np.isfinite(x[0, :3, 0]).all()
    assert np.isnan(x[:6, 3, 0]).all()
    # the body is followed where nothing was clicked yet, too
    np.testing.assert_allclose(paths.body(x)[:, 0], 0.0, atol=6.0)
