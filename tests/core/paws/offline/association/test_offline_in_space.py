"""One name a place in space, and none far beyond the body: worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.in_space import (
    beyond_body,
    misses_clicks,
    shared_places,
    surest_two,
)


def test_of_two_points_on_one_place_at_most_one_is_right():
    x = np.array([[[0.0, 0, 0], [0.5, 0, 0], [9.0, 0, 0]]])
    chance = np.array([[0.9, 0.3, 0.8]])
    left = chance * shared_places(x, chance, nearest=1.0)
    # P(first, not second | not both) = 0.9 * 0.7 / (1 - 0.9 * 0.3), by enumeration
    np.testing.assert_allclose(left, [[0.63 / 0.73, 0.1 * 0.3 / 0.73, 0.8]], atol=1e-6)


def test_two_sure_points_on_one_place_are_each_as_likely():
    x = np.zeros((1, 2, 3))
    assert shared_places(x, np.ones((1, 2)), nearest=1.0) == pytest.approx(0.5, abs=1e-3)


def test_where_a_place_is_unknown_nothing_is_shared():
    x = np.array([[[0.0, 0, 0], [np.nan] * 3]])
    np.testing.assert_allclose(shared_places(x, np.full((1, 2), 0.9), nearest=1.0), 1.0)


def test_a_point_in_space_is_as_likely_as_the_second_of_its_views():
    assert surest_two(np.array([[[0.2, 0.9, 0.6]]]))[0, 0] == 0.6
    assert surest_two(np.array([[[0.4]]]))[0, 0] == 0.4


def test_no_point_lies_farther_from_the_others_than_the_body_is_long():
    square = np.array([[0.0, 0, 0], [10, 0, 0], [0, 4, 0], [10, 4, 0]])
    x = np.repeat(square[None], 3, axis=0)
    x[1, 3] = (60, 4, 0)
    chance = np.full((3, 4), 0.9)
    chance[1, 3] = 0.1
    found = beyond_body(x, chance, sure=0.5, gate=1.25)
    assert np.argwhere(found).tolist() == [[1, 3]]


def test_without_other_sure_points_there_is_no_gate():
    x = np.array([[[0.0, 0, 0], [90.0, 0, 0]]])
    assert not beyond_body(x, np.full((1, 2), 0.2), sure=0.5, gate=1.25).any()
    assert not beyond_body(x[:, :1], np.full((1, 1), 0.9), sure=0.5, gate=1.25).any()


ROOT = np.sqrt(0.5)
AFFINE = np.array([
    [1.0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0],  # from the front: u = X, v = Z
    [0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0],  # from the side: u = Y, v = Z
    [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0],  # from above: u = X, v = Y
    [ROOT, ROOT, 0, 0, 0, 0, 1, 0, 0, 0, 0],  # from between front and side
]).T  # fmt: skip


def clicks_of(xyz):
    """What the four cameras show of points (P, 3), in one of two frames; (2, P, V, 2)."""
    X, Y, Z = np.asarray(xyz, float).T
    here = np.stack([[X, Z], [Y, Z], [X, Y], [ROOT * (X + Y), Z]]).transpose(2, 0, 1)
    return np.stack([here, np.full(here.shape, np.nan)])


def missed(uv, gates=(10.0,) * 4):
    clicked = np.isfinite(uv[..., 0])
    return misses_clicks(
        uv,
        clicked=clicked,
        chance=clicked.astype(float),
        coefs=AFFINE,
        sure=0.5,
        gates=np.array(gates),
    )


def test_clicks_that_agree_are_hit_by_the_other_views():
    uv = clicks_of([[30, 20, 10], [50, 60, 70]])
    uv[0, 0, 2] += 3.0  # a click is not exact
    assert not missed(uv).any()


def test_a_view_in_which_a_point_was_clicked_elsewhere_is_missed_by_the_others():
    uv = clicks_of([[30, 20, 10], [50, 60, 70]])
    uv[0, 1, 0] += (0.0, 12.0)  # the other three have Z, and agree: 12 px off, they 4 by their mean
    assert np.argwhere(missed(uv)).tolist() == [[1, 0]]
    assert not missed(uv, gates=(13.0, 10, 10, 10)).any()


def test_a_view_without_a_click_goes_by_the_median_of_the_others():
    uv = clicks_of([[30, 20, 10], [50, 60, 70]])
    uv[0, :, 3] = np.nan
    assert not missed(uv).any()
    uv[0, 0, 2] += (40.0, 40.0)  # three clicks of which no two others fit the third
    assert missed(uv).tolist() == [[True, True, True, True], [False] * 4]


def test_of_two_views_nothing_is_known():
    uv = clicks_of([[30, 20, 10]])
    uv[0, 0, 2:] = np.nan
    uv[0, 0, 0] += 50.0
    assert not missed(uv).any()
