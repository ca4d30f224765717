"""Where paths pass of points clicked in the middle of a paw, and which unlabelled targets are
followed.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.gap_closing import GapClosing
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing.refinement import SmoothedTracks
from pawnb.core.paws.offline.treadmill import pipeline

THICKNESS_PX = np.array([8.0, 8.0])
LINEAR = np.zeros((11, 2))
# one camera looks along y, the other along x, 4 px a unit
LINEAR[:8] = np.array([[4, 0, 0, 0, 0, 0, -4, 0], [0, 4, 0, 0, 0, 0, -4, 0]]).T
RIG = Projection(LINEAR)
SCENE = SimpleNamespace(geometry=RIG, paw_width=2.0, paw_width_px=THICKNESS_PX, is_learnt=False)
TOES, HEEL, OTHER = np.array([3.5, 3.0, 1.0]), np.array([-3.5, -3.0, 1.0]), np.array([1.0, 9.0, 1])
MIDDLE = np.array([0.0, 0.0, 1.0])


def meetings(monkeypatch, click, *, cost):
    """Toes and heel say that the point is in the middle; the other paw says what it says."""
    ends = np.stack([TOES, HEEL, OTHER])
    said = np.stack([MIDDLE, MIDDLE, OTHER - 5.0])
    raw = np.swapaxes(RIG.project(ends), 0, 1)[None]
    at = np.swapaxes(RIG.project(said), 0, 1)[None, None]
    observations = Observations(raw, at, np.ones(raw.shape[:3]), np.ones(raw.shape[:3], bool))
    places = PointHypotheses(ends, np.array(cost))
    monkeypatch.setattr(pipeline, "find_hypotheses", lambda *_, **__: [places])
    return pipeline._meeting_detections(
        {0: click}, [], observations, scene=SCENE, settings=None, likelihood=None
    )[0]


def test_the_better_looking_end_of_a_clicked_paw_is_passed(monkeypatch):
    click = MIDDLE + np.array([0.3, -0.2, 0.1])
    found = meetings(monkeypatch, click, cost=[0.9, 1.3, 0.0])
    np.testing.assert_array_equal(found, TOES)
    found = meetings(monkeypatch, click, cost=[1.3, 0.9, 0.0])
    np.testing.assert_array_equal(found, HEEL)


def test_a_point_that_no_place_speaks_of_stays_where_it_was_clicked(monkeypatch):
    click = MIDDLE + np.array([0.0, 0.0, 6.0])
    np.testing.assert_array_equal(meetings(monkeypatch, click, cost=[0.9, 1.3, 0.0]), click)


def test_strangers_are_left_out_one_by_one(monkeypatch):
    """The far front paw is seen in most frames, the far hind paw in a fifth of them."""
    n, tried = 50, []
    result = SmoothedTracks(*(np.zeros((n, 3, 2)) for _ in range(7)))

    def paths(found, anchors, prepared, **_):
        tried.append(list(prepared.kinds))
        first = np.zeros((n, len(prepared.kinds), 2))
        first[10:, 3:] = np.nan
        return SimpleNamespace(first=lambda: first, body=lambda x: x[:, 0])

    def prepare(found, certain, reference, *, scene, layout, extra):
        return SimpleNamespace(kinds=[*layout.kinds, *extra])

    monkeypatch.setattr(pipeline, "_prepare", prepare)
    monkeypatch.setattr(pipeline, "_paths", paths)
    monkeypatch.setattr(pipeline, "_iterate_until_converged", lambda *_, **__: result)
    x = pipeline.run_pipeline(
        [], {0: {0: np.zeros(2), 1: np.zeros(2)}}, np.full((n, 2, 1, 2), np.nan),
        scene=SimpleNamespace(volume=None), layout=SimpleNamespace(kinds=("front", "hind")),
        fps=250.0, settings=None,
    ).x  # fmt: skip
    assert tried == [["front", "hind", "front", "hind"], ["front", "hind", "front"]]
    assert x.shape == (n, 2, 2)


def test_seen_paws_are_stated_surer_than_told_ones_unless_all_cameras_are_on_one_side():
    sd, is_open = np.ones((2, 1, 3)), np.array([[False], [True]])
    seen, reference = pipeline._stated(sd, is_open, is_one_sided=False)
    assert (seen > 0.5).all()
    assert (seen < 1.0).all()
    np.testing.assert_array_equal(reference, sd[1])
    np.testing.assert_array_equal(pipeline._stated(sd, is_open, is_one_sided=True), sd)


def close_and_smooth(monkeypatch, *, cycle, swings, forward=lambda _: 0.0, scene=SCENE):
    """Settle one paw that each time is found ``forward`` (n,) of where it began.

    Returns what was known each time, the trust that cycles were learnt with, and what is lost.
    """
    n, reference, trusts, doubted = 20, [], [], []
    first = np.zeros((n, 1, 3))
    paths = SimpleNamespace(
        motion_model=SimpleNamespace(jerk=0.1, axes=np.eye(3)), body=lambda x: x[:, 0],
        again=lambda _: np.ones((n, 1, 3)), doubt=doubted.append, first=lambda: first,
    )  # fmt: skip
    prepared = SimpleNamespace(
        certain=np.full((n, 1, 2, 2), np.nan),
        tracked_in_view=np.ones((1, 2), bool),
        unsure=np.zeros(1),
        observations=None,
        kinds=["front"],
        is_one_sided=False,
    )
    settings = SimpleNamespace(shortest_stride_s=0.1, longest_stride_s=1.0, n_iterations=2)

    def bridge(state, *_, **__):
        reference.append(state)
        return GapClosing(np.zeros((n, 1), bool), np.zeros(0), np.zeros(0), stances=[[]])

    def smoothed(*_, **__):
        x = np.zeros((n, 1, 3))
        x[:, 0, 0] = forward(len(reference))
        likeness, none = np.zeros((n, 1, 2)), np.zeros((n, 1))
        return SmoothedTracks(
            x, np.ones_like(x), np.zeros((n, 1, 2, 2)), likeness, none, likeness, none.copy()
        )

    monkeypatch.setattr(pipeline, "close_gaps", bridge)
    monkeypatch.setattr(pipeline, "refine", smoothed)
    monkeypatch.setattr(pipeline, "_tracked", lambda places, *_: places)
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(pipeline, "without_hops", lambda stances, *_: (stances, lost))
    monkeypatch.setattr(
        pipeline, "learn_cycle", lambda *_, trust, **__: trusts.append(trust) or cycle
    )
    monkeypatch.setattr(pipeline, "learn_duty_factor", lambda *_: None)
    monkeypatch.setattr(pipeline, "_swings", lambda *_, **__: swings)
    pipeline._iterate_until_converged(
        first, {}, paths, prepared, scene=scene, fps=100.0, settings=settings
    )
    # what a choice got wrong is not chosen again in the same way
    assert len(doubted) == len(reference) - 1
    assert all(one is lost for one in doubted)
    return reference, trusts, lost


@pytest.mark.parametrize("is_learnt", [False, True])
def test_points_stay_about_the_body_where_colour_tells_them(monkeypatch, is_learnt):
    """A learnt look shows too little of swings to say how far points go."""
    scene = SimpleNamespace(**{**vars(SCENE), "is_learnt": is_learnt})
    states, _, _ = close_and_smooth(monkeypatch, cycle="cycle", swings=None, scene=scene)
    assert len(states) == 3
    for state in states:
        assert (state.body is None) == is_learnt


@pytest.mark.parametrize(
    ("cycle", "swings", "rounds"),
    [("cycle", "swings", 3), ("cycle", None, 3), (None, "swings", 3), (None, None, 1)],
)
def test_what_is_known_of_strides_is_used_without_a_cycle_too(monkeypatch, cycle, swings, rounds):
    """A recording of two strides tells a rhythm and swings, but no cycle."""
    reference, trusts, lost = close_and_smooth(monkeypatch, cycle=cycle, swings=swings)
    assert len(reference) == rounds
    # while a point was on another paw it tells nothing of its cycle
    for trust in trusts:
        np.testing.assert_array_equal(trust > 0, ~lost)
    for state in reference[1:]:
        assert (state.cycle, state.swings) == (cycle, swings)
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

    reference, _, _ = close_and_smooth(monkeypatch, cycle="cycle", swings=None, forward=forward)
    assert len(reference) == rounds


def test_a_swing_is_not_learnt_from_another_paw(monkeypatch):
    n, taught = 20, []
    motion_model = SimpleNamespace(axes=np.eye(3))
    substrate = SimpleNamespace(height=np.zeros(1), motion_model=motion_model)
    gap_closing = GapClosing(
        np.zeros((n, 1), bool), np.zeros(0), np.zeros(0), substrate=substrate, stances=[[]]
    )
    result = SmoothedTracks(
        np.zeros((n, 1, 3)),
        np.ones((n, 1, 3)),
        np.zeros((n, 1, 2, 2)),
        np.zeros((n, 1, 2)),
        np.zeros((n, 1)),
        np.zeros((n, 1, 2)),
        np.zeros((n, 1)),
    )
    prepared = SimpleNamespace(tracked_in_view=np.ones((1, 2), bool), kinds=["front"])
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(pipeline, "learn_swings", lambda x, weight, *_, **__: taught.append(weight))
    pipeline._swings(result, gap_closing, "duty_factor", prepared, lost, 2.0, fps=100.0)
    np.testing.assert_array_equal(taught[0] > 0, ~lost)
