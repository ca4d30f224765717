"""Detections by name are the columns that loops and files hold."""

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.detections import ColourDetections, pad_and_stack


def some(n, seed=0):
    return ColourDetections(np.random.default_rng(seed).normal(size=(n, 8)).astype(np.float32))


def test_names_are_the_columns_of_the_file():
    """The order is that of ``detect`` as cached in files: u, v, du, dv, share, score, tip."""
    found = ColourDetections(np.arange(16, dtype=np.float32).reshape(2, 8))
    assert found.uv.tolist() == [[0, 1], [8, 9]]
    assert found.direction.tolist() == [[2, 3], [10, 11]]
    assert (found.coverage.tolist(), found.score.tolist()) == ([4, 12], [5, 13])
    assert found.tip.tolist() == [[6, 7], [14, 15]]
    again = ColourDetections.of(
        found.uv, direction=found.direction, coverage=found.coverage, score=found.score,
        tip=found.tip,
    )  # fmt: skip
    np.testing.assert_array_equal(again.table, found.table)


def test_side_by_side_each_frame_and_view_has_its_own():
    found = [[some(2, 1), some(0)], [some(1, 2), some(3, 3)]]
    every, is_there = pad_and_stack(found)
    assert is_there.sum(axis=-1).tolist() == [[2, 0], [1, 3]]
    for t, here in enumerate(found):
        for v, one in enumerate(here):
            np.testing.assert_array_equal(every.uv[t, v][is_there[t, v]], one.uv)
    np.testing.assert_array_equal(every.of_view(1).score.reshape(2, 3), every.score[:, 1])


def test_a_detection_cannot_be_put_in_another_table():
    with pytest.raises(AttributeError):
        some(1).table = np.zeros((1, 8))
