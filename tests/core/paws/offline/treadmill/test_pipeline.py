"""Where paths pass of points clicked in the middle of a paw, and which strangers are followed."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.triangulation import Places
from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.gap_closing.gap_closing import Bridged
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.smoothing.refinement import Refined
from pawnb.core.paws.offline.treadmill import pipeline

THICKNESS_PX = np.array([8.0, 8.0])
LINEAR = np.zeros((11, 2))
# one camera looks along y, the other along x, 4 px a unit
LINEAR[:8] = np.array([[4, 0, 0, 0, 0, 0, -4, 0], [0, 4, 0, 0, 0, 0, -4, 0]]).T
RIG = Geometry(LINEAR)
SCENE = SimpleNamespace(geometry=RIG, thickness=2.0, thickness_px=THICKNESS_PX)
TOES, HEEL, OTHER = np.array([3.5, 3.0, 1.0]), np.array([-3.5, -3.0, 1.0]), np.array([1.0, 9.0, 1])
MIDDLE = np.array([0.0, 0.0, 1.0])


def meetings(monkeypatch, click, *, cost):
    """Toes and heel say that the point is in the middle; the other paw says what it says."""
    ends = np.stack([TOES, HEEL, OTHER])
    said = np.stack([MIDDLE, MIDDLE, OTHER - 5.0])
    raw = np.swapaxes(RIG.project(ends), 0, 1)[None]
    at = np.swapaxes(RIG.project(said), 0, 1)[None, None]
    sights = Sights(raw, at, np.ones(raw.shape[:3]), np.ones(raw.shape[:3], bool))
    places = Places(ends, np.array(cost))
    monkeypatch.setattr(pipeline, "find_places", lambda *_, **__: [places])
    return pipeline._meetings({0: click}, [], sights, scene=SCENE, settings=None, judge=None)[0]


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
    result = Refined(*(np.zeros((n, 3, 2)) for _ in range(7)))

    def paths(found, fixed, ready, **_):
        tried.append(list(ready.kinds))
        first = np.zeros((n, len(ready.kinds), 2))
        first[10:, 3:] = np.nan
        return SimpleNamespace(first=lambda: first, body=lambda x: x[:, 0])

    def prepare(found, certain, told, *, scene, layout, extra):
        return SimpleNamespace(kinds=[*layout.kinds, *extra])

    monkeypatch.setattr(pipeline, "_prepare", prepare)
    monkeypatch.setattr(pipeline, "_paths", paths)
    monkeypatch.setattr(pipeline, "_settled", lambda *_, **__: result)
    x = pipeline.decide(
        [], {0: {0: np.zeros(2), 1: np.zeros(2)}}, np.full((n, 2, 1, 2), np.nan),
        scene=SimpleNamespace(volume=None), layout=SimpleNamespace(kinds=("front", "hind")),
        fps=250.0, settings=None,
    ).x  # fmt: skip
    assert tried == [["front", "hind", "front", "hind"], ["front", "hind", "front"]]
    assert x.shape == (n, 2, 2)


def test_seen_paws_are_stated_surer_than_told_ones_unless_all_cameras_are_on_one_side():
    sd, is_open = np.ones((2, 1, 3)), np.array([[False], [True]])
    seen, told = pipeline._stated(sd, is_open, one_sided=False)
    assert (seen > 0.5).all()
    assert (seen < 1.0).all()
    np.testing.assert_array_equal(told, sd[1])
    np.testing.assert_array_equal(pipeline._stated(sd, is_open, one_sided=True), sd)


def settle(monkeypatch, *, cycle, swings, forward=lambda _: 0.0):
    """Settle one paw that each time is found ``forward`` (n,) of where it began.

    Returns what was known each time, the trust that cycles were learnt with, and what is lost.
    """
    n, told, trusts = 20, [], []
    paths = SimpleNamespace(
        manner=SimpleNamespace(jerk=0.1, axes=np.eye(3)), body=lambda x: x[:, 0],
        again=lambda _: np.ones((n, 1, 3)),
    )  # fmt: skip
    ready = SimpleNamespace(
        certain=np.full((n, 1, 2, 2), np.nan), own=np.ones((1, 2), bool), unsure=np.zeros(1),
        sights=None, kinds=["front"], one_sided=False,
    )  # fmt: skip
    settings = SimpleNamespace(shortest_stride_s=0.1, longest_stride_s=1.0, looks=2)

    def bridge(known, *_, **__):
        told.append(known)
        return Bridged(np.zeros((n, 1), bool), np.zeros(0), np.zeros(0), stances=[[]])

    def refined(*_, **__):
        x = np.zeros((n, 1, 3))
        x[:, 0, 0] = forward(len(told))
        likeness, none = np.zeros((n, 1, 2)), np.zeros((n, 1))
        return Refined(
            x, np.ones_like(x), np.zeros((n, 1, 2, 2)), likeness, none, likeness, none.copy()
        )

    monkeypatch.setattr(pipeline, "bridge_gaps", bridge)
    monkeypatch.setattr(pipeline, "refine", refined)
    monkeypatch.setattr(pipeline, "_tracked", lambda places, *_: places)
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(pipeline, "without_hops", lambda stances, *_: (stances, lost))
    monkeypatch.setattr(
        pipeline, "learn_cycle", lambda *_, trust, **__: trusts.append(trust) or cycle
    )
    monkeypatch.setattr(pipeline, "learn_rhythm", lambda *_: None)
    monkeypatch.setattr(pipeline, "_swings", lambda *_, **__: swings)
    first = np.zeros((n, 1, 3))
    pipeline._settled(first, {}, paths, ready, scene=SCENE, fps=100.0, settings=settings)
    return told, trusts, lost


@pytest.mark.parametrize(
    ("cycle", "swings", "rounds"),
    [("cycle", "swings", 3), ("cycle", None, 3), (None, "swings", 3), (None, None, 1)],
)
def test_what_is_known_of_strides_is_used_without_a_cycle_too(monkeypatch, cycle, swings, rounds):
    """A recording of two strides tells a rhythm and swings, but no cycle."""
    told, trusts, lost = settle(monkeypatch, cycle=cycle, swings=swings)
    assert len(told) == rounds
    # while a point was on another paw it tells nothing of its cycle
    for trust in trusts:
        np.testing.assert_array_equal(trust > 0, ~lost)
    for known in told[1:]:
        assert (known.cycle, known.swings) == (cycle, swings)
        np.testing.assert_array_equal(known.chosen, 1.0 if cycle else 0.0)


@pytest.mark.parametrize(
    ("frames", "thicknesses", "last", "rounds"),
    [(5, 2.1, 3, 4), (4, 2.1, 3, 3), (5, 1.9, 3, 3), (5, 2.1, 2, 3), (5, 2.1, 4, 4)],
)
def test_where_tracks_still_change_there_is_one_more_look(
    monkeypatch, frames, thicknesses, last, rounds
):
    """The paw is elsewhere for some frames in each look until the ``last`` that changes it."""

    def forward(look):
        moved = np.arange(20) < frames
        return np.where(moved, thicknesses * SCENE.thickness * min(look, last), 0.0)

    told, _, _ = settle(monkeypatch, cycle="cycle", swings=None, forward=forward)
    assert len(told) == rounds


def test_a_swing_is_not_learnt_from_another_paw(monkeypatch):
    n, taught = 20, []
    manner = SimpleNamespace(axes=np.eye(3))
    ground = SimpleNamespace(height=np.zeros(1), manner=manner)
    bridged = Bridged(np.zeros((n, 1), bool), np.zeros(0), np.zeros(0), ground=ground, stances=[[]])
    result = Refined(
        np.zeros((n, 1, 3)), np.ones((n, 1, 3)), np.zeros((n, 1, 2, 2)), np.zeros((n, 1, 2)),
        np.zeros((n, 1)), np.zeros((n, 1, 2)), np.zeros((n, 1)),
    )  # fmt: skip
    ready = SimpleNamespace(own=np.ones((1, 2), bool), kinds=["front"])
    lost = np.arange(n)[:, None] < 5
    monkeypatch.setattr(pipeline, "learn_swings", lambda x, weight, *_, **__: taught.append(weight))
    pipeline._swings(result, bridged, "rhythm", ready, lost, 2.0, fps=100.0)
    np.testing.assert_array_equal(taught[0] > 0, ~lost)
