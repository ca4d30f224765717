"""The min-cut against every labelling of small grids, and against a cut without shortcuts."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_flow

from pawnb.core.pose.pullar2009.mincut import cut_grid, decide, grid_energy


def problem(rng, shape, *, pull):
    """Return random whole costs; a small pull leaves much to the cut."""
    height, width = shape
    own = rng.integers(-pull, pull + 1, shape)
    right = rng.integers(0, 6, (height, width - 1))
    down = rng.integers(0, 6, (height - 1, width))
    return own.astype(float), right.astype(float), down.astype(float)


def least_energy_of_all(own, right, down):
    return min(
        sum(grid_energy(np.reshape(labels, own.shape), own, right=right, down=down))
        for labels in itertools.product([False, True], repeat=own.size)
    )


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32), st.sampled_from([2, 5, 12]), st.sampled_from([(3, 4), (4, 3), (2, 5)])
)
def test_no_labelling_of_a_small_grid_costs_less(seed, pull, shape):
    costs = problem(np.random.default_rng(seed), shape, pull=pull)
    own, right, down = costs
    assert sum(grid_energy(cut_grid(*costs), own, right=right, down=down)) == least_energy_of_all(
        *costs
    )


@pytest.mark.slow
@pytest.mark.parametrize("pull", [4, 9, 25])
def test_energy_is_that_of_the_maximum_flow_of_the_whole_grid(pull):
    own, right, down = problem(np.random.default_rng(pull), (31, 27), pull=pull)
    number = np.arange(own.size).reshape(own.shape)
    source, sink = own.size, own.size + 1
    edges = [(number[:, :-1], number[:, 1:], right), (number[1:], number[:-1], down)]
    edges += [(b, a, w) for a, b, w in edges]
    edges.append((np.full(own.shape, source), number, np.maximum(own, 0)))
    edges.append((number, np.full(own.shape, sink), np.maximum(-own, 0)))
    a, b, w = (np.concatenate([np.ravel(e[i]) for e in edges]) for i in range(3))
    graph = csr_array((w.astype(np.int32), (a, b)), shape=(sink + 1, sink + 1))
    # least energy = flow + what every pixel labelled 1 costs at least
    expected = maximum_flow(graph, source, sink).flow_value + np.minimum(own, 0).sum()
    assert sum(grid_energy(cut_grid(own, right, down), own, right=right, down=down)) == expected


def test_strong_pixels_are_decided_without_a_cut_and_weak_ones_are_not():
    own = np.array([[9.0, -1.0, -9.0]])
    right = np.array([[2.0, 2.0]], np.float32)
    label, rest = decide(own.astype(np.float32), right, np.empty((0, 3), np.float32))
    # the middle one is pulled by 2 from both sides and keeps its own -1: label 1
    assert label.tolist() == [[0, 1, 1]]
    label, _ = decide(np.array([[1, -1]], np.float32), right[:, :1], np.empty((0, 2), np.float32))
    assert label.tolist() == [[-1, -1]]
    assert rest[0, 1] == -1.0


def test_energy_counts_each_different_pair_once():
    labels = np.array([[True, False], [True, True]])
    own = np.array([[1.0, 10.0], [100.0, 1000.0]])
    right, down = np.array([[2.0], [3.0]]), np.array([[5.0, 7.0]])
    # by hand: pixels 1 + 100 + 1000; pairs top (2) and right column (7)
    assert grid_energy(labels, own, right=right, down=down) == (1101.0, 9.0)


def test_a_flat_picture_gets_one_label():
    own = np.full((20, 20), -0.001)
    assert cut_grid(own, np.full((20, 19), 5.0), np.full((19, 20), 5.0)).all()
