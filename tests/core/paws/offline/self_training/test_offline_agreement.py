"""A kind that agrees with the others is trusted."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.estimates import Estimates
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.self_training.agreement import agreeing_share, trust_by_agreement

N, RADIUS = 16, 2.5


@pytest.fixture
def stack(make_stack):
    return make_stack(np.zeros((N, 60, 90), np.uint8))


def estimates(place):
    return Estimates(np.tile(np.array(place, float), (N, 1)), np.ones(N), np.ones(N))


def detections(stack, places, point=0, log_odds=1.5):
    rows = np.arange(N)
    uv = np.array(
        [stack.picture_of(np.array(p, float), t) for t, p in zip(rows, places, strict=True)]
    )
    return Detections(rows, np.full(N, point), uv, np.full(N, log_odds), np.ones(N))


@pytest.mark.parametrize("right", [16, 8, 0])
def test_ratios_are_scaled_by_the_share_of_rows_that_agree(stack, right):
    """Four rows that do not agree are reckoned with beforehand."""
    found = detections(stack, [(10, 8)] * right + [(20, 8)] * (N - right))
    shares = agreeing_share(found, stack, {0: estimates((11, 9))}, radius=RADIUS)
    scaled = trust_by_agreement(found, shares)
    expected = np.exp(1.5) * right / (N + 4)
    np.testing.assert_allclose(np.exp(scaled.log_odds), expected, atol=1e-4)
    np.testing.assert_array_equal(scaled.uv, found.uv)


def test_only_the_best_place_of_a_row_counts_and_points_are_told_apart(stack):
    here, there = detections(stack, [(10, 8)] * N), detections(stack, [(20, 8)] * N, log_odds=0.5)
    other = detections(stack, [(25, 15)] * N, point=1)
    both = Detections(
        *(
            np.concatenate([getattr(one, name) for one in (there, here, other)])
            for name in ("row", "point", "uv", "log_odds", "sd_px")
        )
    )
    shares = agreeing_share(
        both, stack, {0: estimates((10, 8)), 1: estimates((0, 0))}, radius=RADIUS
    )
    scaled = trust_by_agreement(both, shares)
    share = N / (N + 4)
    np.testing.assert_allclose(scaled.log_odds[:N], 0.5 + np.log(share))
    np.testing.assert_allclose(scaled.log_odds[N : 2 * N], 1.5 + np.log(share))
    assert (scaled.log_odds[2 * N :] < -5).all()
