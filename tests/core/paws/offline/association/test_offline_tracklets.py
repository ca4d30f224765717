"""Places joined from frame to frame, and cut where they meet."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.tracklets import (
    ViewTracklet,
    cut_at_meetings,
    cut_between_clicks,
    find_candidates,
    link,
)
from pawnb.core.paws.offline.parameters import IdentityParameters

PARAMETERS = IdentityParameters()
RADIUS = 2.5
SHAPE = (20, 60)


def peak(x, y, height=1.0):
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return (height * np.exp(-((u - x) ** 2 + (v - y) ** 2) / 4)).astype(np.float32)


def candidates(score, sure=(), most=5):
    return find_candidates(score, sure=sure, most=most, radius=RADIUS, parameters=PARAMETERS)


def linked(rows, flow=None):
    n = len(rows)
    still = np.zeros((n - 1, *SHAPE, 2), np.float32)
    forward = still if flow is None else flow
    places = [np.array(row, float).reshape(-1, 2) for row in rows]
    return link(places, forward, -forward, radius=RADIUS, parameters=PARAMETERS)


def test_peaks_are_found_between_nodes_highest_first_and_low_ones_not():
    found = candidates(peak(10.3, 8) + peak(30, 12.4, 0.6) + peak(50, 5, 0.05))
    np.testing.assert_allclose(found, [[10.3, 8], [30, 12.4]], atol=0.3)
    assert len(candidates(peak(10, 8) + peak(30, 12), most=1)) == 1


def test_clicks_are_kept_even_where_they_are_near_each_other_and_close_what_is_about_them():
    sure = [np.array([10.0, 8.0]), np.array([12.0, 8.0])]
    found = candidates(peak(11, 8) + peak(40, 8, 0.5), sure=sure)
    np.testing.assert_allclose(found, [*sure, [40, 8]], atol=0.2)


def test_what_passes_far_from_others_is_one_tracklet_with_its_velocity():
    rows = [[(10 + t, 5), (50 - 0.5 * t, 15)] for t in range(12)]
    one, other = linked(rows)
    np.testing.assert_allclose(one.places, [(10 + t, 5) for t in range(12)])
    np.testing.assert_allclose(one.last_step, [1, 0])
    np.testing.assert_allclose(other.first_step, [-0.5, 0])
    assert (other.begin, other.end) == (0, 11)


def test_two_that_cross_are_cut_where_they_meet():
    """One goes right and one left; at 30 they are one peak for three frames."""
    rows = []
    for t in range(21):
        left, right = (20 + t, 10), (40 - t, 10)
        rows.append([(30, 10)] if abs(t - 10) < 2 else [left, right])
    found = linked(rows)
    before = [one for one in found if one.begin == 0]
    after = [one for one in found if one.end == 20 and len(one.places) > 3]
    assert len(before) == len(after) == 2
    assert max(one.end for one in before) <= 10
    assert min(one.begin for one in after) >= 10
    assert sorted(one.last_step[0] for one in before) == pytest.approx([-1, 1], abs=0.3)


def test_flow_carries_one_over_frames_in_which_it_is_not_seen():
    flow = np.zeros((9, *SHAPE, 2), np.float32)
    flow[..., 0] = 1.5
    rows = [[(10 + 1.5 * t, 8)] if t not in (4, 5) else [] for t in range(10)]
    (one,) = linked(rows, flow)
    np.testing.assert_allclose(one.places[:, 0], 10 + 1.5 * np.arange(10), atol=1e-5)


def test_one_that_is_not_seen_any_more_ends_where_it_was_seen_last():
    rows = [[(10, 8)] if t < 5 else [] for t in range(15)]
    (one,) = linked(rows)
    assert one.end == 4


def lasting(begin, end, y):
    """A tracklet from one row to another that goes right by one place a row."""
    places = np.stack([np.arange(begin, end + 1.0), np.full(end - begin + 1, y)], axis=1)
    return ViewTracklet(begin, places, np.array([1.0, 0]), np.array([1.0, 0]))


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        # clicks beside the rows in which both last: cut at either end of those
        ((5, 25), [(0, 9), (10, 15), (10, 15), (16, 30)]),
        # clicks among those rows: each part has its own click, and only what lies between is free
        ((12, 14), [(0, 12), (10, 13), (13, 15), (14, 30)]),
    ],
)
def test_of_two_that_a_point_was_clicked_in_neither_lasts_beside_the_other(rows, expected):
    one, other = lasting(0, 15, 4.0), lasting(10, 30, 15.0)
    apart = lasting(8, 20, 9.0)
    clicked = [
        (row, np.array([row, own.places[0, 1]]))
        for row, own in zip(rows, (one, other), strict=True)
    ]
    found = cut_between_clicks([one, apart, other], clicked)
    spans = sorted((cut.begin, cut.end) for cut in found if cut is not apart)
    assert spans == expected
    assert any(cut is apart for cut in found)
    for cut in found:
        np.testing.assert_allclose(cut.places[:, 0], cut.rows)
        np.testing.assert_allclose([cut.first_step, cut.last_step], [(1, 0), (1, 0)])


def test_what_follows_without_lasting_beside_it_is_not_cut():
    some = [lasting(0, 9, 4.0), lasting(10, 30, 15.0)]
    assert cut_between_clicks(some, [(5, some[0].places[5]), (25, some[1].places[15])]) == some


def test_where_another_comes_out_beside_it_either_may_have_gone_on():
    """One hides the other in rows 10 to 14, and both go on; what is far off cuts nothing."""
    one, hidden, again = lasting(0, 30, 8.0), lasting(0, 9, 11.0), lasting(15, 30, 11.0)
    far = lasting(12, 20, 30.0)
    found = cut_at_meetings([one, hidden, far, again], RADIUS)
    parts = [cut for cut in found if cut.places[0, 1] == 8.0]
    assert [(cut.begin, cut.end) for cut in parts] == [(0, 9), (10, 14), (15, 30)]
    assert {cut.rows_before_cut for cut in parts} == {31}
    assert len(found) == 6
    assert all(any(cut is own for cut in found) for own in (hidden, again, far))
