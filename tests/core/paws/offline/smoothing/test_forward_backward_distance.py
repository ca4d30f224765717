"""Passes forwards and backwards against a plain Kalman filter, and against fits by hand."""

import numpy as np
import pytest

from pawnb.core.paws.offline.smoothing.forward_backward_distance import (
    NormalEquations,
    forward_backward_distance,
    leave_one_out,
)
from pawnb.core.paws.offline.smoothing.smoother import covariances, smooth


def equations(W, z, jerk2, *, jerk_mean=None, axes=None):
    """Those of one track."""
    jerk_mean = np.zeros(z.shape) if jerk_mean is None else jerk_mean
    _, factor = smooth(W, z, jerk2, jerk_mean=jerk_mean, axes=axes)
    spread = covariances(factor, z.shape[1], axes=axes)
    return NormalEquations(
        W[:, None], z[:, None], jerk2[:, None], jerk_mean[:, None], axes, spread[:, None]
    )


def predictions(seen, R, jerk2, jerk_mean):
    """A textbook Kalman filter of three positions: predicted mean and covariance of each frame.

    ``seen`` (n, d) is NaN where nothing is measured; R (n, d, d) is its covariance; what joins
    frame t to those before has the variance jerk2[t] and the mean bend[t].
    """
    n, d = seen.shape
    eye, F = np.eye(d), np.kron([[0, 1, 0], [0, 0, 1], [1, -3, 3]], np.eye(d))
    H = np.hstack([0 * eye, 0 * eye, eye])
    x, P = np.zeros(3 * d), 1e7 * np.eye(3 * d)
    means, spreads = np.empty((n, d)), np.empty((n, d, d))
    for t in range(n):
        x, P = F @ x, F @ P @ F.T
        x[2 * d :] += jerk_mean[t]
        P[2 * d :, 2 * d :] += np.diag(jerk2[t]) + (1e7 * eye if t < 3 else 0)
        means[t], spreads[t] = H @ x, H @ P @ H.T
        if np.isfinite(seen[t, 0]):
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R[t])
            x, P = x + K @ (seen[t] - H @ x), (np.eye(3 * d) - K @ H) @ P
    return means, spreads


@pytest.mark.parametrize("d", [2, 3])
def test_agrees_with_a_kalman_filter_forwards_and_one_backwards(d):
    rng = np.random.default_rng(d)
    n = 24
    seen = np.cumsum(np.cumsum(rng.normal(size=(n, d)), axis=0), axis=0)
    J = rng.normal(size=(n, 4, d))
    W = np.einsum("nki,nkj->nij", J, J)
    gone = np.arange(n)[:, None] // 4 == 3
    seen[gone[:, 0]], R = np.nan, np.linalg.inv(W)
    W[gone[:, 0]] = 0.0
    # of frame t, as what joins it to the three before
    jerk2, jerk_mean = rng.uniform(0.1, 1.0, (n, d)), rng.normal(size=(n, d))
    forth = predictions(seen, R, jerk2, jerk_mean)
    # the last frame of four becomes the first: what joins them is the same, the other way
    turn = (n + 2 - np.arange(n)) % n
    back = predictions(seen[::-1], R[::-1], jerk2[turn], -jerk_mean[turn])
    back = [part[::-1] for part in back]
    away = forth[0] - back[0]
    square = np.einsum("ni,nij,nj->n", away, np.linalg.inv(forth[1] + back[1]), away)
    # in the tracker's counting they belong to the third frame of the four
    shifted = [np.roll(part, -2, axis=0) for part in (jerk2, jerk_mean)]
    z = np.einsum("nij,nj->ni", W, np.nan_to_num(seen))
    found = forward_backward_distance(equations(W, z, shifted[0], jerk_mean=shifted[1]))[:, 0]
    np.testing.assert_allclose(found[3:-3], np.sqrt(square / d)[3:-3], rtol=1e-3)
    assert np.isnan(found[[0, 1, 2, -3, -2, -1]]).all()
    # along other axes it is the same problem, turned
    axes = np.linalg.qr(rng.normal(size=(d, d)))[0]
    turned = equations(
        axes.T @ W @ axes, z @ axes, shifted[0], jerk_mean=shifted[1] @ axes, axes=axes
    )  # fmt: skip
    np.testing.assert_allclose(forward_backward_distance(turned)[:, 0], found, rtol=1e-6)


def test_a_jump_is_told_where_it_is_and_by_how_much():
    """Where accelerations hardly change both passes are fits of parabolas."""
    n, jump, sd = 20, 3.0, 0.5
    x = np.where(np.arange(n) < 10, 0.0, jump)[:, None]
    W = np.full((n, 1, 1), 1.0 / sd**2)
    found = forward_backward_distance(equations(W, W[:, 0] * x, np.full((n, 1), 3e-7)))[:, 0]
    # frame 9: a parabola through 0 to 8, and one through 10 to 19, each carried on by a frame
    variance = 0.0
    for t in (np.arange(9), np.arange(10, 20)):
        A = np.vander(t - 9.0, 3)
        variance += sd**2 * np.linalg.inv(A.T @ A)[2, 2]
    np.testing.assert_allclose(found[9], jump / np.sqrt(variance), rtol=0.03)
    assert found[[9, 10]].min() > 1.5 * found[[5, 14]].max()
    still = forward_backward_distance(equations(W, 0.0 * x, np.full((n, 1), 3e-7)))
    np.testing.assert_allclose(still[3:-3], 0.0, atol=1e-9)


def test_a_bend_that_is_expected_keeps_both_passes_together():
    t = np.arange(40.0)
    x = 0.5 * np.maximum(t - 12.5, 0.0)[:, None] ** 1.5
    jerk_mean = np.zeros_like(x)
    jerk_mean[1:-2] = x[3:] - 3 * x[2:-1] + 3 * x[1:-2] - x[:-3]
    W, jerk2 = np.ones((40, 1, 1)), np.full((40, 1), 1e-3)
    informative = forward_backward_distance(equations(W, x, jerk2, jerk_mean=jerk_mean))
    np.testing.assert_allclose(informative[3:-3], 0.0, atol=1e-3)
    assert np.nanmax(forward_backward_distance(equations(W, x, jerk2))) > 0.2


def test_too_little_on_one_side_is_not_known():
    seen = np.isin(np.arange(30), [4, 9, 12, 15, 20, 21])
    W = seen[:, None, None] * np.eye(2)
    found = forward_backward_distance(equations(W, np.zeros((30, 2)), np.full((30, 2), 0.1)))[:, 0]
    # after 12, which is the third, and before 15, which is the third from the end
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(found)), [13, 14])
    for n in range(1, 5):
        empty = np.zeros((n, 2, 2)), np.zeros((n, 2)), np.ones((n, 2))
        assert np.isnan(forward_backward_distance(equations(*empty))).all()


def test_leaving_a_frame_out_is_smoothing_without_it():
    rng = np.random.default_rng(5)
    n, d = 25, 3
    J = rng.normal(size=(n, 4, d))
    W = np.einsum("nki,nkj->nij", J, J)
    W[8:14] = 0.0
    z = np.einsum("nij,nj->ni", W, rng.normal(size=(n, d)))
    jerk2 = rng.uniform(0.01, 1.0, (n, d))
    x, _ = smooth(W, z, jerk2)
    expected, spread = leave_one_out(x[:, None], equations(W, z, jerk2))
    for t in (0, 6, 10, 20, 24):
        others = (np.arange(n) != t)[:, None]
        without, factor = smooth(W * others[..., None], z * others, jerk2)
        np.testing.assert_allclose(expected[t, 0], without[t], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(spread[t, 0], covariances(factor, d)[t], rtol=1e-6, atol=1e-9)
