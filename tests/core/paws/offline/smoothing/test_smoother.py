"""Smoothing by a banded system against the same problem written out densely."""

import numpy as np
import pytest

from pawnb.core.paws.offline.smoothing.smoother import smooth, variances


def dense(information, target, jerk2):
    """Solve with plain matrices: the definition, term by term."""
    n, d = target.shape
    A = np.zeros((n * d, n * d))
    for t in range(n):
        A[t * d : t * d + d, t * d : t * d + d] += information[t]
    for t in range(1, n - 2):
        for c in range(d):
            row = np.zeros(n * d)
            row[[(t - 1) * d + c, t * d + c, (t + 1) * d + c, (t + 2) * d + c]] = [-1, 3, -3, 1]
            A += np.outer(row, row) / jerk2[t]
    x = np.linalg.solve(A, target.ravel()).reshape(n, d)
    return x, np.diag(np.linalg.inv(A)).reshape(n, d)


@pytest.mark.parametrize("d", [2, 3])
def test_agrees_with_the_dense_solution(d):
    rng = np.random.default_rng(d)
    n = 25
    J = rng.normal(size=(n, 4, d))
    information = np.einsum("nki,nkj->nij", J, J)
    information[8:14] = 0.0
    target = np.einsum("nij,nj->ni", information, rng.normal(size=(n, d)))
    jerk2 = rng.uniform(0.01, 1.0, n)
    x, factor = smooth(information, target, jerk2)
    expected_x, expected_var = dense(information, target, jerk2)
    np.testing.assert_allclose(x, expected_x, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(variances(factor, d), expected_var, rtol=1e-4)


def test_an_expected_bend_is_made_in_a_gap():
    t = np.arange(30.0)
    # 2 a frame backwards until 12.5, then 3 a frame forwards: no jerk but that
    x = np.column_stack([-2.0 * t + 5.0 * np.maximum(t - 12.5, 0.0), np.zeros(30)])
    jerk_mean = np.zeros_like(x)
    jerk_mean[1:-2] = x[3:] - 3 * x[2:-1] + 3 * x[1:-2] - x[:-3]
    seen = (t < 10) | (t > 20)
    W = seen[:, None, None] * np.eye(2)
    found, _ = smooth(W, seen[:, None] * x, np.full(30, 0.01), jerk_mean=jerk_mean)
    np.testing.assert_allclose(found, x, atol=1e-2)
    without, _ = smooth(W, seen[:, None] * x, np.full(30, 0.01))
    assert np.abs(without - x).max() > 1.0


def test_along_turned_axes_it_is_the_turned_problem():
    rng = np.random.default_rng(4)
    n, d = 25, 3
    axes = np.linalg.qr(rng.normal(size=(d, d)))[0]
    J = rng.normal(size=(n, 4, d))
    information = np.einsum("nki,nkj->nij", J, J)
    information[8:14] = 0.0
    target = np.einsum("nij,nj->ni", information, rng.normal(size=(n, d)))
    jerk_mean, alike = 0.1 * rng.normal(size=(n, d)), rng.uniform(0.01, 1.0, n)
    plain, factor = smooth(information, target, alike, jerk_mean=jerk_mean)
    turned, turned_factor = smooth(information, target, alike, jerk_mean=jerk_mean, axes=axes)
    np.testing.assert_allclose(turned, plain, atol=1e-6)
    expected = variances(factor, d)
    np.testing.assert_allclose(variances(turned_factor, d, axes=axes), expected, rtol=1e-5)
    # another variance along each axis: along the axes that are the coordinates' own, turned
    jerk2 = rng.uniform(0.01, 1.0, (n, d))
    inside = axes @ information @ axes.T
    straight, factor = smooth(inside, target @ axes.T, jerk2, jerk_mean=jerk_mean @ axes.T)
    found, _ = smooth(information, target, jerk2, jerk_mean=jerk_mean, axes=axes)
    np.testing.assert_allclose(found @ axes.T, straight, atol=1e-6)


def test_each_axis_has_its_own_jerk():
    t = np.arange(40.0)
    seen = (t < 15) | (t > 25)
    W = seen[:, None, None] * np.eye(2)
    x = np.column_stack([np.sin(0.6 * t), np.sin(0.6 * t)])
    jerk2 = np.tile([1e-1, 1e-2], (40, 1))
    found, factor = smooth(W, seen[:, None] * x, jerk2)
    for axis in (0, 1):
        alone, tracked_in_view = smooth(W, seen[:, None] * x, jerk2[:, axis])
        # but for the trace of prior, which is that of the stiffest axis
        np.testing.assert_allclose(found[:, axis], alone[:, axis], atol=1e-3)
        expected = variances(tracked_in_view, 2)[:, axis]
        np.testing.assert_allclose(variances(factor, 2)[:, axis], expected, rtol=1e-3)
    assert np.abs(found[:, 0] - found[:, 1]).max() > 0.05


def test_a_parabola_crosses_a_gap_unchanged():
    t = np.arange(30.0)
    path = np.column_stack([0.1 * t**2 - t, 3.0 - 0.05 * t**2])
    seen = (t < 10) | (t > 20)
    information = seen[:, None, None] * np.eye(2) * 4.0
    x, factor = smooth(information, np.einsum("nij,nj->ni", information, path), np.full(30, 0.1))
    np.testing.assert_allclose(x, path, atol=1e-3)
    sd = np.sqrt(variances(factor, 2))
    assert sd[15, 0] > 2 * sd[5, 0]


def test_variances_of_several_long_tracks_do_not_drift():
    # one rounding error that grows from frame to frame would show after 100 of them
    rng = np.random.default_rng(5)
    n, d = 150, 3
    factors, expected = [], []
    for _ in range(2):
        J = rng.normal(size=(n, 4, d))
        information = np.einsum("nki,nkj->nij", J, J)
        information[40:46] = 0.0
        jerk2 = rng.uniform(0.01, 1.0, n)
        factors.append(smooth(information, np.zeros((n, d)), jerk2)[1])
        expected.append(dense(information, np.zeros((n, d)), jerk2)[1])
    np.testing.assert_allclose(variances(np.stack(factors), d), expected, rtol=1e-4)


@pytest.mark.parametrize("n", [1, 3, 4])
def test_a_track_without_any_measurement_is_solved_and_unsure(n):
    """Up to three frames nothing says how it moves, either: whatever comes out says so."""
    x, factor = smooth(np.zeros((n, 2, 2)), np.zeros((n, 2)), np.full(n, 0.1))
    np.testing.assert_array_equal(x, 0.0)
    assert variances(factor[None], 2).min() > 1e6
