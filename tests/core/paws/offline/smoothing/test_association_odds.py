"""How far detections are ahead of others: known odds of made-up detections."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing.association_odds import association_log_odds

FLAT = Projection(None)
LINEAR = np.zeros((11, 2))
LINEAR[:8] = np.array([[4, 0, 0, 9, 0, 0, -4, 7], [0, 3, 1, -5, 1, 0, -4, 2]]).T
RIG = Projection(LINEAR)


def separate(
    at, taken, x, covariance, *, geometry=FLAT, sigma=1.0, negative_log_odds=None, there=None
):
    """Separations of one point in one frame; ``at`` (V, C, 2), ``taken`` (V, 2)."""
    at = np.asarray(at, float)[None]
    shape = at.shape[:3]
    is_there = np.ones(shape, bool) if there is None else np.asarray(there)[None]
    negative_log_odds = (
        np.zeros(shape) if negative_log_odds is None else np.asarray(negative_log_odds, float)[None]
    )
    return association_log_odds(
        np.asarray(taken, float)[None, None],
        (x[None, None], covariance[None, None]),
        Observations(at, at[:, None], np.ones(shape), is_there),
        negative_log_odds=negative_log_odds[:, None],
        sigma=np.broadcast_to(sigma, shape).astype(float),
        geometry=geometry,
        paw_width_px=np.full(at.shape[1], 8.0),
    )[0, 0]


def test_the_odds_of_two_candidates_by_where_the_point_is_expected():
    x, covariance = np.array([50.0, 40.0]), np.array([[3.0, 1.0], [1.0, 2.0]])
    at = [[[51.0, 40.0], [44.0, 43.0], [90.0, 90.0]]]
    # a detection twice as vague as the other
    sigma = np.array([[[1.0, 2.0, 1.0]]])
    negative_log_odds = [[0.3, 0.9, 0.0]]
    density = [
        multivariate_normal.logpdf(one, x, covariance + s**2 * np.eye(2))
        for one, s in zip(at[0][:2], (1.0, 2.0), strict=True)
    ]
    expected = density[0] - density[1] + 0.9 - 0.3
    found = separate(
        at, [at[0][0]], x, covariance, sigma=sigma, negative_log_odds=negative_log_odds
    )
    np.testing.assert_allclose(found, [expected])
    # had the other been taken, it would be behind by as much
    found = separate(
        at, [at[0][1]], x, covariance, sigma=sigma, negative_log_odds=negative_log_odds
    )
    np.testing.assert_allclose(found, [-expected])


def test_alike_on_both_sides_is_not_separated():
    x, covariance = np.array([50.0, 40.0]), 4.0 * np.eye(2)
    at = [[[46.0, 40.0], [54.0, 40.0]]]
    np.testing.assert_allclose(separate(at, [at[0][0]], x, covariance), [0.0], atol=1e-12)
    # what is vague tells nothing apart
    x = np.array([47.0, 40.0])
    gaps = [separate(at, [at[0][0]], x, s * np.eye(2))[0] for s in (1, 10, 1000)]
    assert gaps[0] > gaps[1] > gaps[2] > 0
    # 1 px from one and 7 px from the other: squares over twice 1000 + 1
    np.testing.assert_allclose(gaps[2], (49 - 1) / 2002)


def test_views_are_measured_by_themselves():
    x, covariance = np.array([1.0, 2.0, 3.0]), np.diag([0.5, 0.2, 1.0])
    uv = RIG.project(x)
    step = np.array([[0.0, 6.0], [5.0, 0.0]])
    at = np.stack([uv, uv + step], axis=1)
    found = separate(at, uv, x, covariance, geometry=RIG)
    for v, A in enumerate([[[4, 0, 0], [0, 0, -4]], [[0, 3, 1], [1, 0, -4]]]):
        S = A @ covariance @ np.transpose(A) + np.eye(2)
        np.testing.assert_allclose(found[v], 0.5 * step[v] @ np.linalg.inv(S) @ step[v])


@pytest.mark.parametrize(("away", "expected"), [(3.9, 30.0), (4.1, 0.5 * 4.1**2)])
def test_candidates_within_half_a_paw_say_the_same(away, expected):
    x, covariance = np.array([50.0, 40.0]), np.zeros((2, 2))
    found = separate([[[50.0, 40.0], [50.0 + away, 40.0]]], [x], x, covariance)
    np.testing.assert_allclose(found, [expected])


def test_what_is_alone_or_not_a_candidate():
    x, covariance = np.array([50.0, 40.0]), np.eye(2)
    at = [[[50.0, 40.0], [57.0, 40.0]]]
    assert separate(at, [x], x, covariance, there=[[True, False]]) == 30.0
    assert separate(at, [x], x, covariance, negative_log_odds=[[0.0, 99.0]]) == 30.0
    assert np.isnan(separate(at, [[np.nan, np.nan]], x, covariance)).all()
    # a person placed it where no detection is
    assert np.isnan(separate(at, [[50.5, 40.0]], x, covariance)).all()
