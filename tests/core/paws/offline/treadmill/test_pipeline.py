"""Where paths pass of points clicked in the middle of a paw, and which unlabelled targets are
followed.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses, Volume
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.state import GapClosing
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.scene.views import SideViews, SingleView
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.smoothing.diagnostics import stated_sd
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.stride import learn
from pawnb.core.paws.offline.treadmill import pipeline, targets
from pawnb.core.paws.offline.treadmill.recording import Recording
from pawnb.core.paws.offline.treadmill.state import PipelineState

THICKNESS_PX = np.array([8.0, 8.0])
LINEAR = np.zeros((11, 2))
# one camera looks along y, the other along x, 4 px a unit
LINEAR[:8] = np.array([[4, 0, 0, 0, 0, 0, -4, 0], [0, 4, 0, 0, 0, 0, -4, 0]]).T
RIG = Projection(LINEAR)
UP, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
VIEWS = SideViews(
    RIG, 2.0, THICKNESS_PX, [(0.7, 0.7)] * 2, Volume(UP, ACROSS, (-9.0, 9.0), (-9.0, 9.0))
)
SCENE = SimpleNamespace(
    geometry=VIEWS, projection=RIG, paw_width=2.0, paw_width_px=THICKNESS_PX, is_learnt=False,
    body_scale=20.0,
)  # fmt: skip
TOES, HEEL, OTHER = np.array([3.5, 3.0, 1.0]), np.array([-3.5, -3.0, 1.0]), np.array([1.0, 9.0, 1])
MIDDLE = np.array([0.0, 0.0, 1.0])
MOTION = MotionModel(1.0, 0.1, 2.0, np.zeros(3), np.eye(3), 0.0, 20.0, 2.0)


def meetings(monkeypatch, click, *, cost):
    """Toes and heel say that the point is in the middle; the other paw says what it says."""
    ends = np.stack([TOES, HEEL, OTHER])
    said = np.stack([MIDDLE, MIDDLE, OTHER - 5.0])
    raw = np.swapaxes(RIG.project(ends), 0, 1)[None]
    at = np.swapaxes(RIG.project(said), 0, 1)[None, None]
    observations = Observations(raw, at, np.ones(raw.shape[:3]), np.ones(raw.shape[:3], bool))
    places = PointHypotheses(ends, np.array(cost))
    monkeypatch.setattr(SideViews, "hypotheses", lambda *_, **__: [places])
    return VIEWS.anchors_of_paths({0: click}, [], observations, most=9, likelihood=None)[0]


def test_the_better_looking_end_of_a_clicked_paw_is_passed(monkeypatch):
    click = MIDDLE + np.array([0.3, -0.2, 0.1])
    found = meetings(monkeypatch, click, cost=[0.9, 1.3, 0.0])
    np.testing.assert_array_equal(found, TOES)
    found = meetings(monkeypatch, click, cost=[1.3, 0.9, 0.0])
    np.testing.assert_array_equal(found, HEEL)


def test_a_point_that_no_place_speaks_of_stays_where_it_was_clicked(monkeypatch):
    click = MIDDLE + np.array([0.0, 0.0, 6.0])
    np.testing.assert_array_equal(meetings(monkeypatch, click, cost=[0.9, 1.3, 0.0]), click)


def recording(**settings):
    """One clicked front and hind paw."""
    return Recording(
        [], {0: {0: np.zeros(2), 1: np.zeros(2)}}, np.full((50, 2, 1, 2), np.nan), None,
        SimpleNamespace(
            geometry=SingleView(None, 2.0, np.ones(1), [(1.0, 0.0)], np.array([0.0, -1.0])),
            body_scale=20.0,
        ),
        SimpleNamespace(kinds=("front", "hind")), 250.0, OfflineSettings(**settings),
    )  # fmt: skip


def test_strangers_are_left_out_one_by_one(monkeypatch):
    """The far front paw is seen in most frames, the far hind paw in a fifth of them."""
    n, tried = 50, []

    def paths(_, followed):
        tried.append(followed.kinds)
        first = np.zeros((n, len(followed.kinds), 2))
        first[10:, 3:] = np.nan
        return SimpleNamespace(first=lambda: first, body=lambda x: x[:, 0])

    monkeypatch.setattr(
        targets, "learn_targets", lambda _, extra: SimpleNamespace(kinds=["front", "hind", *extra])
    )
    monkeypatch.setattr(targets, "build_paths", paths)
    followed, _, first = targets.choose_targets(recording())
    assert tried == [["front", "hind", "front", "hind"], ["front", "hind", "front"]]
    assert followed.kinds == tried[-1]
    assert first.shape == (n, 3, 2)


def test_seen_paws_are_stated_surer_than_told_ones_unless_all_cameras_are_on_one_side():
    sd, is_open = np.ones((2, 1, 3)), np.array([[False], [True]])
    seen, reference = stated_sd(sd, is_open, is_one_sided=False)
    assert (seen > 0.5).all()
    assert (seen < 1.0).all()
    np.testing.assert_array_equal(reference, sd[1])
    np.testing.assert_array_equal(stated_sd(sd, is_open, is_one_sided=True), sd)


def passes(monkeypatch, *, cycle, swings, forward=lambda _: 0.0, scene=SCENE):
    """Settle one paw that each time is found ``forward`` (n,) of where it began.

    Returns what was known each time, the trust that cycles were learnt with, and what is lost.
    """
    n, known, trusts, doubted = 20, [], [], []
    first = np.zeros((n, 1, 3))
    paths = SimpleNamespace(
        motion_model=MOTION, body=lambda x: x[:, 0], again=lambda _: np.ones((n, 1, 3)),
        doubting=lambda hopped: doubted.append(hopped) or paths, first=lambda: first,
    )  # fmt: skip
    followed = targets.Targets(
        ["front"], np.full((n, 1, 2, 2), np.nan), np.ones((1, 2), bool),
        Observations(*(np.zeros((n, *rest)) for rest in ((2, 3, 2), (1, 2, 3, 2), (2, 3), (2, 3)))),
        None, np.zeros(1), False,
    )  # fmt: skip
    given = replace(recording(n_iterations=2), scene=scene, anchors={})

    def bridge(state, *_, **__):
        known.append(state)
        return GapClosing(np.zeros((n, 1), bool), np.zeros(0), np.zeros(0), stances=[[]])

    def smoothed(*_, **__):
        x = np.zeros((n, 1, 3))
        x[:, 0, 0] = forward(len(known))
        return replace(
            SmoothedTracks.unknown(n, 1, 2, 3),
            x=x, sd=np.ones_like(x), measured=np.zeros((n, 1, 2, 2)),
        )  # fmt: skip

    monkeypatch.setattr(pipeline, "choose_targets", lambda _: (followed, paths, first))
    monkeypatch.setattr(pipeline, "close_gaps", bridge)
    monkeypatch.setattr(pipeline, "refine", smoothed)
    monkeypatch.setattr(SideViews, "tracked_points", lambda _, places, *__, **___: places.copy())
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(learn, "without_hops", lambda stances, *_: (stances, lost))
    monkeypatch.setattr(learn, "learn_cycle", lambda *_, trust, **__: trusts.append(trust) or cycle)
    monkeypatch.setattr(learn, "learn_duty_factor", lambda *_: None)
    monkeypatch.setattr(learn, "_swings", lambda *_, **__: swings)
    pipeline.run_pipeline(given)
    # what a choice got wrong is not chosen again in the same way
    assert len(doubted) == len(trusts)
    assert all(one is lost for one in doubted)
    return known, trusts, lost


def test_steps_leave_what_they_are_given_as_it_is(monkeypatch):
    """A step that wrote into a state would change what a later pass compares with."""
    kept = []
    for name in ("associate", "close", "smooth", "learn"):
        step = getattr(pipeline, name)

        def watched(state, step=step):
            before = {k: np.copy(v) for k, v in vars(state.smoothed).items() if v is not None}
            at = state.assignment.at.copy()
            after = step(state)
            for key, value in before.items():
                np.testing.assert_array_equal(getattr(state.smoothed, key), value)
            np.testing.assert_array_equal(state.assignment.at, at)
            assert after is not state
            kept.append(after)
            return after

        monkeypatch.setattr(pipeline, name, watched)
    passes(monkeypatch, cycle="cycle", swings=None)
    assert len(kept) == 3 * 3 + 2
    assert all(isinstance(state, PipelineState) for state in kept)


@pytest.mark.parametrize("is_learnt", [False, True])
def test_points_stay_about_the_body_where_colour_tells_them(monkeypatch, is_learnt):
    """A learnt look shows too little of swings to say how far points go."""
    scene = SimpleNamespace(**{**vars(SCENE), "is_learnt": is_learnt})
    states, _, _ = passes(monkeypatch, cycle="cycle", swings=None, scene=scene)
    assert len(states) == 3
    for state in states:
        assert state.body is not None
        assert state.are_apart != is_learnt


@pytest.mark.parametrize(
    ("cycle", "swings", "rounds"),
    [("cycle", "swings", 3), ("cycle", None, 3), (None, "swings", 3), (None, None, 2)],
)
def test_what_is_known_of_strides_is_used_without_a_cycle_too(monkeypatch, cycle, swings, rounds):
    """A recording of two strides tells a rhythm and swings, but no cycle."""
    reference, trusts, lost = passes(monkeypatch, cycle=cycle, swings=swings)
    assert len(reference) == rounds
    # while a point was on another paw it tells nothing of its cycle
    for trust in trusts:
        np.testing.assert_array_equal(trust > 0, ~lost)
    for state in reference[1:]:
        assert (state.stride.cycle, state.stride.swings) == (cycle, swings)
        np.testing.assert_array_equal(state.chosen, 1.0 if cycle else 0.0)


@pytest.mark.parametrize(
    ("frames", "thicknesses", "last", "rounds"),
    [(5, 2.1, 3, 4), (4, 2.1, 3, 3), (5, 1.9, 3, 3), (5, 2.1, 2, 3), (5, 2.1, 4, 4)],
)
def test_where_tracks_still_change_there_is_one_more_look(
    monkeypatch, frames, thicknesses, last, rounds
):
    """The paw is elsewhere for some frames in each look until the ``last`` that changes it."""

    def forward(iteration):
        moved = np.arange(20) < frames
        return np.where(moved, thicknesses * SCENE.paw_width * min(iteration, last), 0.0)

    reference, _, _ = passes(monkeypatch, cycle="cycle", swings=None, forward=forward)
    assert len(reference) == rounds


def test_a_swing_is_not_learnt_from_another_paw(monkeypatch):
    n, taught = 20, []
    gap_closing = GapClosing(
        np.zeros((n, 1), bool), np.zeros(0), np.zeros(0),
        substrate=SimpleNamespace(height=np.zeros(1)), stances=[[]],
    )  # fmt: skip
    result = replace(
        SmoothedTracks.unknown(n, 1, 2, 3),
        x=np.zeros((n, 1, 3)), sd=np.ones((n, 1, 3)), measured=np.zeros((n, 1, 2, 2)),
    )  # fmt: skip
    gait = learn.KnownGait(["front"], np.ones((1, 2), bool), MOTION, 100.0, (0.1, 1.0))
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(learn, "learn_swings", lambda x, weight, *_, **__: taught.append(weight))
    learn._swings(result, gap_closing, [[]], "duty_factor", lost=lost, gait=gait)
    np.testing.assert_array_equal(taught[0] > 0, ~lost)
