"""Places joined from frame to frame, and cut where they meet."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.tracklets import find_candidates, link
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
