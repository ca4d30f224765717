"""How far paths of a network are believed: the formulas of the module, worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.offline.detection.point_tracking.reliability import PathEnd, find_reliability


@pytest.fixture(autouse=True)
def _round_numbers():
    with parameters_set({"point_tracker": {"right": 0.7, "worth_clicks": 2.0, "sd_px": 5.0}}):
        yield


def test_without_a_click_it_is_what_was_known_before():
    found = find_reliability([], [0, 3], near_px=15.0)
    assert found.trust == pytest.approx({0: 0.4, 3: 0.4})  # 2 x 0.7 - 1
    assert found.sd_px == 5.0


def test_points_share_what_clicks_say_and_have_their_own():
    ends = [
        PathEnd(0, 1.0, 3.0, 20),
        PathEnd(0, 1.0, 4.0, 20),
        PathEnd(1, 1.0, 40.0, 20),
        PathEnd(1, 0.5, 9.0, 20),
    ]
    found = find_reliability(ends, [0, 1, 2], near_px=15.0)
    of_all = (2 * 0.7 + 2.5) / (2 + 3.5)
    assert found.trust[0] == pytest.approx(2 * (2 * of_all + 2) / 4 - 1)
    assert found.trust[1] == pytest.approx(max(0, 2 * (2 * of_all + 0.5) / 3.5 - 1))
    assert found.trust[2] == pytest.approx(2 * of_all - 1)
    # of the three that are right; a distance has two axes
    square = (2 * 25 + 9 / 2 + 16 / 2 + 0.5 * 81 / 2) / (2 + 2.5)
    assert found.sd_px == pytest.approx(np.sqrt(square))


def test_what_is_as_often_wrong_as_right_says_nothing():
    ends = [PathEnd(0, 1.0, 3.0, 20)] + [PathEnd(0, 1.0, 50.0, 20)] * 4
    assert find_reliability(ends, [0], near_px=15.0).trust == {0: 0.0}


def test_what_the_network_itself_calls_hidden_is_no_fault_of_it():
    claimed = find_reliability([PathEnd(0, 0.9, 50.0, 20)], [0], near_px=15.0)
    hidden = find_reliability([PathEnd(0, 0.1, 50.0, 20)], [0], near_px=15.0)
    assert hidden.trust[0] > claimed.trust[0]


def test_nothing_is_believed_much_farther_from_a_click_than_it_was_right():
    ends = [PathEnd(0, 0.9, 3.0, 12), PathEnd(0, 0.9, 2.0, 25), PathEnd(0, 0.9, 50.0, 60)]
    assert find_reliability(ends, [0], near_px=15.0).rows == 50  # twice 25
    assert find_reliability([], [0], near_px=15.0).rows == 0
