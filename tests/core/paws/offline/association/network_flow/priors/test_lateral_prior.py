"""Paws keep to their sides where fewer than two views see them."""

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.priors.lateral_prior import (
    learn_lateral_prior,
)
from pawnb.core.paws.offline.smoothing.smoother import smooth

ACROSS = np.array([0.0, 1.0, 0.0])
SPAN = 40.0


def walk(n=60):
    """A body that drifts to the side, and two paws 9 to one and 16 to the other side of it."""
    t = np.arange(n)
    body = np.column_stack([0.1 * t, 0.05 * t, np.zeros(n)])
    paws = np.stack(
        [body + np.array([20.0, -9.0, 1.0]), body + np.array([-20.0, 16.0, 1.0])], axis=1
    )
    return body, paws


def test_the_usual_way_follows_the_body_and_is_no_further_off_for_a_few_wrong_places():
    body, paws = walk()
    places = paws.copy()
    places[10:30, 0] = np.nan
    places[40:45, 0] += (0.0, 30.0, 0.0)
    found = learn_lateral_prior(places, body, ACROSS, body_scale=SPAN)
    np.testing.assert_allclose(found.usual, paws[..., 1], atol=1e-9)
    # exactly at its place in most frames: what is left is how far paws wander, 0.1 spans
    np.testing.assert_allclose(found.information, 1.0 / 4.0**2)


def test_of_a_point_that_was_never_met_nothing_is_told():
    body, paws = walk()
    paws[:, 1] = np.nan
    found = learn_lateral_prior(paws, body, ACROSS, body_scale=SPAN)
    assert found.information[1] == 0.0
    W, z = np.zeros((60, 2, 3, 3)), np.zeros((60, 2, 3))
    found.add(W, z, np.ones((60, 2), int))
    assert np.isfinite(z).all()
    assert (W[:, 1] == 0.0).all()
    assert (z[:, 1] == 0.0).all()


@pytest.mark.parametrize("views", [0, 1, 2])
def test_only_the_side_is_told_and_only_where_fewer_than_two_views_see(views):
    body, paws = walk()
    found = learn_lateral_prior(paws, body, ACROSS, body_scale=SPAN)
    W, z = np.zeros((60, 2, 3, 3)), np.zeros((60, 2, 3))
    found.add(W, z, np.full((60, 2), views))
    told = 0.0 if views == 2 else 1.0 / 16.0
    np.testing.assert_allclose(W, np.broadcast_to(told * np.diag(ACROSS), W.shape))
    np.testing.assert_allclose(z[..., 1], told * paws[..., 1])


def test_a_sight_line_alone_no_longer_draws_a_paw_to_the_far_side():
    """One view looks along (0, 0.8, 0.6) and is right: only the depth is open."""
    body, paws = walk()
    true = paws[:, 0]
    observation = np.array([0.0, 0.8, 0.6])
    flat = (np.eye(3) - np.outer(observation, observation)) / 0.2**2
    single = (np.arange(60) >= 15) & (np.arange(60) < 45)
    W = np.where(single[:, None, None], flat, np.eye(3) / 0.2**2)
    z = np.einsum("nij,nj->ni", W, true)
    # what is seen before the gap leads away along the sight line
    z[10:15] += 2.0 * observation / 0.2**2 * (np.arange(5) / 5.0)[:, None]
    jerk2 = np.full(60, 1.0)
    alone, _ = smooth(W, z, jerk2)
    W, z = W[:, None].copy(), z[:, None].copy()
    found = learn_lateral_prior(
        np.where(single[:, None, None], np.nan, paws[:, :1]), body, ACROSS, body_scale=SPAN
    )
    found.add(W, z, np.where(single, 1, 2)[:, None])
    held, _ = smooth(W[:, 0], z[:, 0], jerk2)
    away = [np.abs(x[single] - true[single]).max() for x in (alone, held)]
    assert away[1] < 0.5 * away[0]
