"""Messages along a chain of frames give the posterior of the whole chain."""

import numpy as np
import pytest

from pawnb.core.pose.fit.sequence.messages import from_neighbours


def spread(rng, d):
    root = rng.normal(size=(d, d))
    return root @ root.T + 0.1 * np.eye(d)


@pytest.mark.parametrize("n", [3, 4, 9])
def test_with_its_own_picture_each_frame_has_the_posterior_of_the_whole_chain(n):
    """Expected: the joint normal distribution of all frames, inverted as one dense matrix."""
    rng = np.random.default_rng(n)
    d = 4
    own = np.array([spread(rng, d) for _ in range(n)])
    vector, steady = rng.normal(size=(n, d)), spread(rng, d)
    second = np.kron(np.diff(np.eye(n), 2, axis=0), np.eye(d))
    whole = second.T @ np.kron(np.eye(n - 2), steady) @ second
    for t in range(n):
        whole[t * d : t * d + d, t * d : t * d + d] += own[t]
    covariance = np.linalg.inv(whole)
    mean = (covariance @ vector.ravel()).reshape(n, d)
    others, row = from_neighbours(own, vector, steady)
    for t in range(n):
        here = slice(t * d, t * d + d)
        both = others[t] + own[t]
        np.testing.assert_allclose(np.linalg.inv(both), covariance[here, here], atol=1e-9)
        np.testing.assert_allclose(np.linalg.solve(both, row[t] + vector[t]), mean[t], atol=1e-9)


def test_precision_stays_symmetric_and_positive_over_many_frames():
    """Errors of symmetry grew from frame to frame, to more than the precision itself."""
    rng = np.random.default_rng(0)
    own = np.array([spread(rng, 10) * 10 ** rng.uniform(0, 5) for _ in range(300)])
    steady = 50.0 * spread(rng, 10)
    others, _ = from_neighbours(own, rng.normal(size=(300, 10)), steady)
    np.testing.assert_allclose(others, np.swapaxes(others, 1, 2), atol=1e-6)
    assert np.linalg.eigvalsh(others).min() > 0


def test_two_frames_say_nothing_of_each_other():
    others, row = from_neighbours(np.ones((2, 1, 1)), np.ones((2, 1)), np.eye(1))
    assert not others.any()
    assert not row.any()
