"""Where a point usually is: about its clicks, and where it was found."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.positional_prior import (
    prior_from_clicks,
    prior_from_tracks,
)
from pawnb.core.paws.offline.parameters import (
    AssociationParameters,
    OfflineParameters,
    SceneParameters,
)

PARAMETERS = OfflineParameters(
    scene=SceneParameters(extent=60.0), association=AssociationParameters(anywhere=0.3)
)


@pytest.fixture
def stack(make_stack):
    return make_stack(np.zeros((5, 90, 120), np.uint8))


def clicks(rows):
    """Point 2 at place (20, 12) of the grid of 3 px in so many rows; point 0 once."""
    places = {row: {2: np.array([61.0, 37.0])} for row in range(rows)}
    places[0][0] = np.array([4.0, 4.0])
    return Annotations(places)


def test_it_sums_to_one_and_is_highest_at_the_click(stack):
    priors = prior_from_clicks(stack, clicks(1), radius=1.0, parameters=PARAMETERS)
    assert sorted(priors) == [0, 2]
    for prior in priors.values():
        assert prior.sum() == pytest.approx(1, abs=1e-5)
    assert np.unravel_index(priors[2].argmax(), (30, 40)) == (12, 20)
    assert np.unravel_index(priors[0].argmax(), (30, 40)) == (1, 1)


def test_far_from_clicks_the_even_share_is_left(stack):
    """30 % of the probability over 1200 places; (39, 29) is five standard deviations away."""
    prior = prior_from_clicks(stack, clicks(1), radius=1.0, parameters=PARAMETERS)[2]
    assert prior[29, 39] == pytest.approx(0.3 / 1200, rel=0.01)


def test_more_clicks_make_it_narrower(stack):
    highest = [
        prior_from_clicks(stack, clicks(n), radius=1.0, parameters=PARAMETERS)[2].max()
        for n in (1, 2, 4)
    ]
    assert highest[0] * 1.2 < highest[1]
    assert highest[1] * 1.2 < highest[2]


def test_a_prior_learns_where_the_point_was_found(stack):
    """Always found at (30, 20): half of the new prior, less 15 % of it, lies about there."""
    old = prior_from_clicks(stack, clicks(1), radius=1.0, parameters=PARAMETERS)
    posterior = np.zeros(stack.shape, np.float32)
    posterior[:, 20, 30] = 1
    new = prior_from_tracks({2: posterior.mean(axis=0)}, old, 1.0)
    assert list(new) == [2]
    assert new[2].sum() == pytest.approx(1, abs=1e-5)
    part = np.s_[15:26, 25:36]
    even = 0.15 * 121 / 1200
    assert new[2][part].sum() == pytest.approx(0.5 * old[2][part].sum() + 0.5 * (0.85 + even), 1e-3)
