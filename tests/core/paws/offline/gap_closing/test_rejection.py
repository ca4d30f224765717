"""What is associated again: paths too short, drawn off, off their arcs, and stances no swing leads
to.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.offline.gap_closing.rejection import (
    drawn_off,
    frames_to_reassociate,
    hops,
    off_trajectory,
    open_frames,
    runs,
    without_hops,
)
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.stance import Stance
from pawnb.core.paws.offline.stride.swing import Swings

DRIFT = np.array([-1.0, 0.0, 0.0])
# 12 spans of 40 a second at 2 a frame are 240 frames a second
MANNER = MotionModel(
    acceleration=0.3,
    jerk=0.2,
    speed=2.0,
    substrate_velocity=DRIFT,
    axes=np.eye(3),
    substrate=0.0,
    body_scale=40.0,
    paw_width=3.0,
)
N = 100


masks = st.lists(st.booleans(), max_size=40).map(lambda m: np.array(m, bool))


@given(masks)
def test_runs_are_the_stretches_of_true(mask):
    again = np.zeros(len(mask), bool)
    found = runs(mask)
    for first, stop in found:
        assert first < stop
        assert not again[first:stop].any()
        again[first:stop] = True
    np.testing.assert_array_equal(again, mask)
    # no two of them touch
    assert all(a[1] < b[0] for a, b in itertools.pairwise(found))


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=40))
def test_open_frames_by_their_definition(pairs):
    certain = np.array([a for a, _ in pairs], bool)
    annotated = np.array([b for _, b in pairs], bool)
    is_open = open_frames(certain, annotated)
    for t in range(len(pairs)):
        around, length = t, 0
        while around >= 0 and certain[around]:
            around -= 1
        while around + 1 < len(pairs) and certain[around + 1]:
            around, length = around + 1, length + 1
        # uncertain, or in a certain stretch of less than four frames; never one placed by hand
        assert is_open[t] == (not certain[t] or (length < 4 and not annotated[t]))


def walk(*stances, n=N):
    """Return places (n, 1, 3) of a paw that stands from a frame to another, so far ahead.

    Between stances it goes straight, 4 up; ``stances`` are first frame, stop, and where in
    frame 0 the ground was.
    """
    t = np.arange(n, dtype=float)
    at = np.array([x for first, stop, x in stances for x in (x, x)], dtype=float)
    when = np.array([edge for first, stop, _ in stances for edge in (first, stop - 1)])
    x = np.zeros((n, 1, 3))
    x[:, 0, 0] = np.interp(t, when, at) + t * DRIFT[0]
    is_standing = np.zeros(n, bool)
    for first, stop, _ in stances:
        is_standing[first:stop] = True
    x[~is_standing, 0, 2] = 4.0
    return x


def told(x, *, annotated=None, **state):
    """Return the frames of one paw that are associated again."""
    annotated = np.zeros(x.shape[:2], bool) if annotated is None else annotated
    return frames_to_reassociate(x, annotated, motion_model=MANNER, **state)[:, 0]


RHYTHM = DutyFactor(share=np.array([0.6]), sd=np.array([0.02]), stride=50.0, spread=2.0)
"""A swing lasts for 20 frames."""


def test_a_walk_is_certain_and_a_paw_never_seen_is_not():
    x = walk((0, 30, 0.0), (50, 80, 50.0), (100, 101, 100.0))
    assert not told(x, duty_factor=RHYTHM).any()
    assert told(np.full((N, 1, 3), np.nan), duty_factor=RHYTHM).all()


@pytest.mark.parametrize("n", [1, 5])
def test_a_recording_of_a_few_frames_is_no_reason_to_fail(n):
    x = walk((0, n, 0.0), n=n)
    swings = Swings(x + np.nan, x + np.nan, x + np.nan, ())
    assert told(x, duty_factor=RHYTHM, swings=swings).all() == (n < 4)


def test_a_path_that_is_lost_soon_after_its_paw_stood_is_told_anew():
    x = walk((0, 30, 0.0), (50, 80, 50.0), (100, 101, 100.0))
    # 0.03 s are seven frames
    for lost, expected in ((37, range(30, 40)), (38, range(38, 40))):
        gap = x.copy()
        gap[lost:40] = np.nan
        np.testing.assert_array_equal(np.flatnonzero(told(gap)), expected)


@pytest.mark.parametrize(
    ("stances", "gaps", "lost"),
    [
        # the shorter of two is another paw's, with the path to the next gap
        ([(10, 40), (45, 60)], [(75, 80)], (40, 75)),
        ([(10, 40), (45, 60)], [], (40, N)),
        ([(30, 40), (45, 70)], [(15, 20)], (20, 45)),
        ([(30, 40), (45, 70)], [], (0, 45)),
        # of two alike the later one
        ([(10, 30), (35, 55)], [(60, 70)], (30, 60)),
        # the first one may be told from the first frame, the last one to the last
        ([(0, 40), (45, N)], [], (0, 45)),
        # nine frames of ten are hardly a swing, ten are one
        ([(10, 40), (49, 60)], [(70, 75)], (40, 70)),
        ([(10, 40), (50, 60)], [(70, 75)], (0, 0)),
        # a short one between two long ones, and not those
        ([(10, 40), (43, 50), (53, 80)], [(41, 42), (51, 52)], (40, 51)),
        # a gap between them is no swing either
        ([(10, 40), (45, 60)], [(41, 44), (75, 80)], (40, 75)),
        ([], [(10, 20)], (0, 0)),
        ([(10, 40)], [], (0, 0)),
    ],
)
def test_of_two_stances_without_a_swing_the_shorter_one_is_doubted(stances, gaps, lost):
    is_open = np.zeros(N, bool)
    for gap in gaps:
        is_open[slice(*gap)] = True
    found = hops([Stance(*one, np.zeros(3)) for one in stances], is_open, least=10.0)
    np.testing.assert_array_equal(np.flatnonzero(found), np.arange(*lost))


spans = st.lists(st.integers(0, N), min_size=4, max_size=4, unique=True).map(sorted)


@pytest.mark.slow
@given(spans, st.lists(st.booleans(), min_size=N, max_size=N))
def test_what_is_doubted_is_one_path_and_turns_round_with_time(at, is_open):
    is_open = np.array(is_open) & (np.arange(N) % 7 == 0)
    stances = [Stance(at[0], at[1], np.zeros(3)), Stance(at[2], at[3], np.zeros(3))]
    found = hops(stances, is_open, least=30.0)
    longer, shorter = sorted(stances, key=lambda one: one.stop - one.first, reverse=True)
    is_hop = at[2] - at[1] < 30
    assert found.any() == is_hop
    assert len(runs(found)) <= 1
    if shorter.stop - shorter.first == longer.stop - longer.first:
        return
    assert found[shorter.first : shorter.stop].all() == is_hop
    assert not found[longer.first : longer.stop].any()
    turned = [Stance(N - one.stop, N - one.first, one.origin) for one in stances[::-1]]
    np.testing.assert_array_equal(hops(turned, is_open[::-1], least=30.0), found[::-1])


def test_a_stance_that_no_swing_leads_to_is_told_anew_but_not_what_was_placed_by_hand():
    # after its stance the path goes over to the paw beside, which stands until frame 60
    x = walk((0, 30, 0.0), (36, 60, 6.0), (80, 100, 56.0))
    x[70:75] = np.nan
    np.testing.assert_array_equal(np.flatnonzero(told(x, duty_factor=RHYTHM)), np.arange(30, 75))
    np.testing.assert_array_equal(np.flatnonzero(told(x)), np.arange(70, 75))
    # swings of hind paws, which stand for 0.8 of a stride, are shorter: half of ten frames
    hind = replace(RHYTHM, share=np.array([0.8]))
    np.testing.assert_array_equal(np.flatnonzero(told(x, duty_factor=hind)), np.arange(70, 75))
    annotated = np.zeros((N, 1), bool)
    annotated[[45, 60, 71]] = True
    is_open = told(x, duty_factor=RHYTHM, annotated=annotated)
    # placed by hand without a place is still to be told
    expected = np.setdiff1d(np.arange(30, 75), [45, 60])
    np.testing.assert_array_equal(np.flatnonzero(is_open), expected)


def test_stances_that_no_swing_leads_to_are_left_out():
    stances = [
        [Stance(*one, np.zeros(3)) for one in ((10, 40), (45, 60), (90, N))],
        [Stance(*one, np.zeros(3)) for one in ((0, 30), (50, 80))],
        [],
    ]
    is_open = np.zeros((N, 3), bool)
    is_open[75:80] = True
    # swings last for 20 frames, and ten are one
    duty_factor = DutyFactor(np.full(3, 0.6), np.full(3, 0.02), 50.0, 3.0)
    kept, lost = without_hops(stances, is_open, duty_factor)
    assert kept == [[stances[0][0], stances[0][2]], stances[1], []]
    np.testing.assert_array_equal(np.flatnonzero(lost[:, 0]), np.arange(40, 75))
    assert not lost[:, 1:].any()
    kept, lost = without_hops(stances, is_open, None)
    assert kept == stances
    assert not lost.any()


def arcs(x, *, sd=0.5):
    """Return swings that go where ``x`` does, in frames 30 to 49."""
    place = np.full(x.shape, np.nan)
    place[30:50] = x[30:50]
    return Swings(place, np.where(np.isnan(place), np.nan, sd), np.full(x.shape, np.nan), ())


@pytest.mark.parametrize(
    ("off", "is_told_anew"),
    [
        # three of hypot(0.5, half a paw width) are 4.74: forward, up, and both together
        ([4.7, 0.0, 0.0], False),
        ([4.8, 0.0, 0.0], True),
        ([0.0, 0.0, 4.7], False),
        ([0.0, 0.0, -4.8], True),
        ([3.5, 0.0, 3.5], True),
        ([0.0, 50.0, 0.0], False),
    ],
)
def test_a_place_off_the_arc_of_its_swing_is_told_anew(off, is_told_anew):
    x = walk((0, 30, 0.0), (50, 80, 50.0), (100, 101, 100.0))
    swings = arcs(x)
    x[40:45, 0] += off
    found = off_trajectory(x, swings, MANNER)
    np.testing.assert_array_equal(
        np.flatnonzero(found[:, 0]), np.arange(40, 45) if is_told_anew else []
    )
    np.testing.assert_array_equal(told(x, swings=swings), found[:, 0])
    # the same along other axes
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    turned = replace(swings, place=swings.place @ turn)
    motion_model = replace(MANNER, axes=turn)
    np.testing.assert_array_equal(off_trajectory(x @ turn, turned, motion_model), found)


def test_off_its_arc_stays_what_was_placed_by_hand_and_what_no_arc_tells():
    x = walk((0, 30, 0.0), (50, 80, 50.0), (100, 101, 100.0))
    swings = arcs(x)
    x[:, 0, 0] += 20.0
    annotated = np.zeros((N, 1), bool)
    annotated[40] = True
    is_open = told(x, swings=swings, annotated=annotated)
    np.testing.assert_array_equal(np.flatnonzero(is_open), np.setdiff1d(np.arange(30, 50), 40))


def test_a_single_view_shows_forward_and_up():
    x = walk((0, 30, 0.0), (50, 80, 50.0), (100, 101, 100.0))[..., [0, 2]]
    swings = arcs(x)
    flat = replace(MANNER, axes=np.array([[1.0, 0.0], [0.0, -1.0]]), substrate_velocity=DRIFT[:2])
    for axis in (0, 1):
        moved = x.copy()
        moved[40:45, 0, axis] -= 5.0
        found = off_trajectory(moved, swings, flat)[:, 0]
        np.testing.assert_array_equal(np.flatnonzero(found), np.arange(40, 45))


@pytest.mark.parametrize(
    ("gap", "lost"),
    [
        ((22, 30), [20, 21]),  # lost two frames after it left its place
        ((20, 30), []),  # lost where it stood
        ((25, 30), []),  # seen to swing for too long
    ],
)
def test_a_path_that_is_lost_soon_after_a_stance_was_drawn_off(gap, lost):
    is_open = np.zeros(40, bool)
    is_open[slice(*gap)] = True
    stances = [Stance(4, 20, np.zeros(3)), Stance(34, 37, np.zeros(3))]
    found = drawn_off(stances, is_open, most=4)
    np.testing.assert_array_equal(np.flatnonzero(found), lost)


def test_a_path_is_drawn_off_soon_after_a_recording_begins():
    """A stance of three frames that began before the first one may have lasted for long."""
    is_open = np.zeros(40, bool)
    is_open[5:20] = True
    for first, lost in ((0, [3, 4]), (1, [])):
        found = drawn_off([Stance(first, 3, np.zeros(3))], is_open, most=4)
        np.testing.assert_array_equal(np.flatnonzero(found), lost)
