"""Bridging of gaps: a paw hidden among distractors, and which frames are open at all."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.whole.cycle import Cycle
from pawnb.core.paws.whole.gaps import Known, bridge_gaps, open_frames, runs
from pawnb.core.paws.whole.geometry import Geometry
from pawnb.core.paws.whole.manner import Manner
from pawnb.core.paws.whole.sights import Sights

FLAT = Geometry(None)
THICKNESS = np.array([8.0])
MANNER = Manner(
    acceleration=1.0, jerk=0.6, speed=12.0, drift=np.zeros(2),
    axes=np.array([[1.0, 0.0], [0.0, -1.0]]), ground=-1000.0, span=150.0, thickness=8.0,
)  # fmt: skip


def bridge(chosen, at, is_there, *, fixed=None, quality=None, cycle=None):
    """Bridge the gaps of points (n, P, 2) by candidates (n, C, 2) of one view."""
    n, n_points = chosen.shape[:2]
    quality = np.ones(at.shape[:2]) if quality is None else quality
    sights = Sights(
        at[:, None], np.repeat(at[:, None, None], n_points, axis=1), quality[:, None],
        is_there[:, None],
    )  # fmt: skip
    fixed = np.zeros((n, n_points), bool) if fixed is None else fixed
    return bridge_gaps(
        Known(chosen, fixed, cycle=cycle), sights, geometry=FLAT, thickness_px=THICKNESS,
        own=np.ones((n_points, 1), bool), manner=MANNER,
    )  # fmt: skip


def hidden_paw():
    """A paw in steady motion, hidden twice, while another path crosses its own."""
    rng = np.random.default_rng(8)
    t = np.arange(50.0)
    paw = np.column_stack([3.0 * t, 0.05 * (t - 25) ** 2])
    other = np.column_stack([80 - 0.5 * t, 40.0 - 1.2 * t])
    at = np.stack([other, paw + 0.3 * rng.normal(size=paw.shape)], axis=1)
    chosen = paw[:, None].copy()
    chosen[15:35] = np.nan
    is_there = np.ones((50, 2), bool)
    is_there[18:22, 1] = is_there[28:31, 1] = False
    # the candidates that are there come first
    late = ~is_there[:, 1]
    assert is_there[late, 0].all()
    return chosen, at, is_there


def test_a_hidden_paw_is_found_again_beside_another_path():
    chosen, at, is_there = hidden_paw()
    bridged = bridge(chosen, at, is_there)
    np.testing.assert_array_equal(np.flatnonzero(bridged.is_open[:, 0]), np.arange(15, 35))
    expected = np.where(is_there[15:35, 1], 1, -1)
    np.testing.assert_array_equal(bridged.choice[15:35, 0, 0], expected)
    assert (bridged.choice[:15] == -1).all()


def test_the_certain_piece_that_follows_decides():
    t = np.arange(30.0)
    high = np.column_stack([2.0 * t, 0.06 * np.maximum(t - 10, 0) ** 2])
    low = high * [1.0, -1.0]
    at = np.stack([high, low], axis=1)
    for branch in (0, 1):
        chosen = at[:, branch : branch + 1].copy()
        chosen[8:22] = np.nan
        choice = bridge(chosen, at, np.ones((30, 2), bool)).choice[16:22, 0, 0]
        np.testing.assert_array_equal(choice, branch)


@pytest.mark.parametrize(("stop", "taken"), [(22, 0), (30, 1)])
def test_the_cycle_decides_only_where_nothing_follows(stop, taken):
    # the paw stands, and the cycle expects it where there is another candidate
    at = np.tile([[0.0, 0.0], [0.0, 7.0]], (30, 1, 1))
    chosen = at[:, :1].copy()
    chosen[8:stop] = np.nan
    cycle = Cycle(at[:, 1:], np.full((30, 1, 2), 0.5), np.zeros(30), np.eye(2), 20.0)
    choice = bridge(chosen, at, np.ones((30, 2), bool), cycle=cycle).choice
    np.testing.assert_array_equal(choice[12:18, 0, 0], taken)


def test_a_candidate_that_another_point_explains_is_left_to_it():
    # two standing points: the first is hidden, and the second's candidate is within its reach
    chosen = np.zeros((24, 2, 2))
    chosen[:, 1, 0] = 4.0
    chosen[8:16, 0] = np.nan
    at = chosen[:, 1:].copy()
    there = np.ones((24, 1), bool)
    assert (bridge(chosen, at, there).choice[:, 0] == -1).all()
    # alone it would be taken for the first
    assert (bridge(chosen[:, :1], at, there).choice[9:15, 0] == 0).any()


def test_what_looks_poor_is_left_for_what_looks_good():
    chosen = np.zeros((20, 1, 2))
    chosen[6:14] = np.nan
    at = np.tile([[0.8, 0.0], [-0.8, 0.0]], (20, 1, 1))
    for good in (0, 1):
        quality = np.full((20, 2), 0.1)
        quality[:, good] = 0.9
        choice = bridge(chosen, at, np.ones((20, 2), bool), quality=quality).choice[6:14, 0, 0]
        np.testing.assert_array_equal(choice, good)


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
    fixed = np.array([b for _, b in pairs], bool)
    is_open = open_frames(certain, fixed)
    for t in range(len(pairs)):
        around, length = t, 0
        while around >= 0 and certain[around]:
            around -= 1
        while around + 1 < len(pairs) and certain[around + 1]:
            around, length = around + 1, length + 1
        # uncertain, or in a certain stretch of less than four frames; never one placed by hand
        assert is_open[t] == (not certain[t] or (length < 4 and not fixed[t]))
