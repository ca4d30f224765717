"""How an animal holds its legs: spreads of a few numbers by hand, and poses far from each other."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.pose.fit.learning import pose_prior
from pawnb.core.pose.fit.learning.parameters import LEARNING


def test_middle_and_spread_are_not_moved_by_one_odd_pose():
    """1, 2, 3, 4 and 50: middle 3; half of the five are within 1 of it, 1.4826 SD of a Gaussian."""
    own = np.array([[1.0, 3.0], [2.0, 3.0], [3.0, 3.0], [4.0, 3.0], [50.0, 3.0]])
    centre, sd = pose_prior._spread(own)
    np.testing.assert_array_equal(centre, [3.0, 3.0])
    assert sd[0] == pytest.approx(LEARNING.pose_prior_wider * 1.4826)
    assert sd[1] == LEARNING.least_sd  # a length that never changes may change a little


def test_the_most_usual_pose_comes_first_and_the_others_lie_apart():
    """On a line: 0.1 is nearest the middle, then the farthest from it, and so on; 40 is odd."""
    away = np.array([[0.1, 0.0], [2.0, 0.0], [1.9, 0.0], [-1.5, 0.0], [40.0, 0.0]])
    chosen = pose_prior._far_apart(away)
    np.testing.assert_array_equal(chosen[:3, 0], [0.1, 2.0, -1.5])
    assert len(chosen) == 4
    assert 40.0 not in chosen
    assert len(pose_prior._far_apart(np.full((3, 2), 40.0))) == 0
