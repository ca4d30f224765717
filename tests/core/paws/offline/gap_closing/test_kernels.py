"""Compiled loops against the same written with matrices, for cameras with perspective."""

import numba
import numpy as np
import pytest

from pawnb.core import dlt
from pawnb.core.paws.offline.association.network_flow import triangulation_kernels
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet
from pawnb.core.paws.offline.gap_closing import hypothesis_kernels, update_kernels
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing import refinement_kernels


def camera(angle):
    """Coefficients of a camera that looks at the origin from 60 away: perspective is strong."""
    forward = np.array([-np.sin(angle), -np.cos(angle), 0.0])
    right = np.array([-np.cos(angle), np.sin(angle), 0.0])
    rotation = np.stack([right, [0.0, 0.0, -1.0], forward])
    intrinsic = np.array([[600.0, 0.0, 500.0], [0.0, 600.0, 300.0], [0.0, 0.0, 1.0]])
    P = intrinsic @ np.column_stack([rotation, [0.0, 0.0, 60.0]])
    return (P / P[2, 3]).ravel()[:11]


COEFS = np.stack([camera(angle) for angle in (0.0, 0.5, 1.1)], axis=1)


def slope(project, x, step=1e-5):
    """Derivatives (..., V, 2, d) by differences."""
    d = x.shape[-1]
    return np.stack(
        [(project(x + e) - project(x - e)) / (2 * step) for e in step * np.eye(d)], axis=-1
    )


@pytest.mark.parametrize("views", [1, 3])
@pytest.mark.parametrize("order", ["C", "F"])
def test_cameras_are_of_one_type_for_loops(views, order):
    """Else what takes longest to compile is compiled once more for one view without a rig."""
    coefs = np.array(COEFS[:, :views], order=order)
    coefs.flags.writeable = False  # as those of a rig
    assert numba.typeof(Projection(coefs).rows) == numba.typeof(Projection(None).rows)
    np.testing.assert_array_equal(Projection(coefs).rows, coefs.T)


@pytest.mark.usefixtures("steps_of_loops")
@pytest.mark.parametrize("coefs", [None, COEFS])
def test_pictures_and_their_derivatives(coefs):
    geometry = Projection(coefs)
    d = geometry.n_coordinates
    mean = np.random.default_rng(1).uniform(-12, 12, (7, 3 * d))
    expected, derivative = geometry.project(mean[:, :d]), slope(geometry.project, mean[:, :d])
    hypotheses = hypothesis_kernels.allocate(9, d, 1)
    hypotheses.mean[:, :7], hypotheses.covariance[:] = mean.T, 0.0
    for v, L in enumerate(geometry.rows):
        seen = update_kernels.project_hypotheses(hypotheses, 7, L)
        np.testing.assert_allclose(seen.at.T, expected[:, v], rtol=1e-12)
        np.testing.assert_allclose(
            seen.slope.transpose(2, 0, 1), derivative[:, v], rtol=1e-6, atol=1e-6
        )


@pytest.mark.parametrize("coefs", [None, COEFS])
def test_normal_equations(coefs):
    rng = np.random.default_rng(2)
    geometry = Projection(coefs)
    x = rng.uniform(-12, 12, (5, 2, geometry.n_coordinates))
    uv, J = geometry.project(x), slope(geometry.project, x)
    measured = uv + rng.normal(size=uv.shape)
    weight = rng.uniform(0.5, 2.0, uv.shape[:-1])
    measured[1, 0], weight[1, 0] = np.nan, 0.0
    W, z = refinement_kernels.normal_equations(x, measured, weight, geometry.rows)
    assert (W[1, 0] == 0).all()
    assert (z[1, 0] == 0).all()
    for t, p in np.ndindex(5, 2):
        if (t, p) == (1, 0):
            continue
        A = J[t, p].reshape(-1, x.shape[-1])
        Q = np.diag(np.repeat(weight[t, p], 2))
        wanted = (measured[t, p] - uv[t, p]).ravel() + A @ x[t, p]
        np.testing.assert_allclose(W[t, p], A.T @ Q @ A, rtol=1e-6)
        np.testing.assert_allclose(z[t, p], A.T @ Q @ wanted, rtol=1e-6)


def test_points_seen_exactly_are_triangulated():
    x = np.random.default_rng(3).uniform(-12, 12, (20, 3))
    uv = dlt.project(COEFS, x)
    found = triangulation_kernels.triangulate(np.ascontiguousarray(COEFS.T), uv)
    np.testing.assert_allclose(found, x, atol=1e-6)


def test_kept_hypotheses_lie_apart_and_every_other_is_near_a_better_one():
    rng = np.random.default_rng(4)
    first = np.array([0, 30, 30, 75])
    xyz = rng.uniform(0, 10, (75, 3))
    keep = triangulation_kernels.distinct(xyz, first, 3.0, 100)
    for a, b in ((0, 30), (30, 75)):
        away = np.linalg.norm(xyz[a:b, None] - xyz[None, a:b], axis=-1)
        chosen = np.flatnonzero(keep[a:b])
        assert (away[np.ix_(chosen, chosen)] + 9 * np.eye(len(chosen)) >= 3.0).all()
        for i in np.flatnonzero(~keep[a:b]):
            assert away[i, chosen[chosen < i]].min() < 3.0
    assert triangulation_kernels.distinct(xyz, first, 3.0, 4).sum() == 8


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 9])
@pytest.mark.parametrize("head", [True, False])
def test_ends_of_pieces_are_those_of_a_fitted_line(n, head):
    at = np.random.default_rng(n).normal(size=(n, 3)).cumsum(axis=0)
    tracklet = Tracklet(4, list(range(n)), at, np.zeros(n))
    place, speed, parameters = tracklet.end(np.zeros(3), head=head)
    assert parameters == min(n, 6)
    part = at[:parameters] if head else at[-parameters:]
    fit = np.polyfit(np.arange(parameters), part, 1)
    end = 0 if head else parameters - 1
    np.testing.assert_allclose(place, [np.polyval(c, end) for c in fit.T])
    np.testing.assert_allclose(speed, [np.polyval(np.polyder(c), end) for c in fit.T])


@pytest.mark.parametrize("most", [1, 7, 40, 60])
def test_the_likeliest_stories_and_pairs_are_kept(most):
    rng = np.random.default_rng(most)
    # many cost the same: of those the first are kept
    missed, cost = (rng.integers(0, 9, n).astype(float) for n in (20, 31))
    kept, many = update_kernels.most_likely(missed, cost, most)
    expected = np.sort(np.argsort(np.concatenate([missed, cost]), kind="stable")[:most])
    np.testing.assert_array_equal(kept, expected)
    assert many == (expected < 20).sum()


@pytest.mark.parametrize("n", [1, 2, 3, 50, 51])
def test_a_value_at_its_place_among_sorted_ones(n):
    rng = np.random.default_rng(n)
    for values in (rng.normal(size=n), rng.integers(0, 3, n).astype(float), np.ones(n)):
        found = [update_kernels.nth(values.copy(), k) for k in range(n)]
        np.testing.assert_array_equal(found, np.sort(values))
