"""The damped Gauss-Newton fit: its linear algebra, its prior, and that it finds a painted pose."""

import numpy as np
import pytest

from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import about, anatomy, parameter_kinds
from pawnb.core.pose.fit.rendering import gauss_newton_kernels as loops
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint, picture_cost
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species


@pytest.mark.slow
def test_cholesky_solves_as_numpy_does():
    rng = np.random.default_rng(0)
    root = rng.normal(size=(12, 12))
    matrix, vector = root @ root.T + np.eye(12), rng.normal(size=12)
    expected = np.linalg.solve(matrix, vector)
    found = vector.copy()
    assert loops.solve_in_place(matrix.copy(), found)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert not loops.solve_in_place(-np.eye(3), np.ones(3))


def test_cholesky_of_blocks_that_meet_in_the_last_numbers():
    # as legs that meet in the body: zeros before a row's first number are not gone through
    rng = np.random.default_rng(4)
    root = np.zeros((14, 14))
    root[:6, :6], root[6:11, 6:11] = rng.normal(size=(6, 6)), rng.normal(size=(5, 5))
    root[11:] = rng.normal(size=(3, 14))
    matrix, vector = root.T @ root + np.eye(14), rng.normal(size=14)
    matrix[:6, 6:11] = matrix[6:11, :6] = 0.0
    matrix += 30.0 * np.eye(14)
    expected = np.linalg.solve(matrix, vector)
    assert loops.solve_in_place(matrix, vector)
    np.testing.assert_allclose(vector, expected, rtol=1e-9)


def prior_of_spider():
    animal = load_species("dolomedes")
    pose = pose_vectors(animal, natural_pose(animal, xy=(90.0, 90.0), scale=2.0))[0]
    return animal, pose, anatomy(animal, pose, foreshortening_sd=0.1)


@pytest.mark.slow
def test_prior_gradient_and_matrix_are_those_of_its_cost():
    _, pose, prior = prior_of_spider()
    rng = np.random.default_rng(1)
    pose = pose + rng.normal(0, 0.3, len(pose))
    active = np.arange(len(pose))
    matrix, vector = np.zeros((len(pose),) * 2), np.zeros(len(pose))
    loops.add_prior(pose, prior, active, matrix, vector)
    whole = matrix + np.tril(matrix, -1).T
    step = 1e-5
    for k in range(3, len(pose), 7):
        up, down = pose.copy(), pose.copy()
        up[k] += step
        down[k] -= step
        change = loops.prior_cost(up, prior, active) - loops.prior_cost(down, prior, active)
        np.testing.assert_allclose(change / (2 * step), vector[k], rtol=1e-4, atol=1e-4)
        more = np.zeros(len(pose))
        matrix_up = np.zeros_like(matrix)
        loops.add_prior(up, prior, active, matrix_up, more)
        np.testing.assert_allclose((more - vector) / step, whole[k], rtol=1e-3, atol=1e-3)


def test_a_leg_that_is_shorter_as_a_whole_costs_less_than_one_link_alone():
    animal, pose, prior = prior_of_spider()
    _, lengths = parameter_kinds(animal)
    active = np.arange(len(pose))
    all_links, one_link = pose.copy(), pose.copy()
    all_links[lengths[:5]] -= 0.2
    one_link[lengths[0]] -= 0.2
    costs = [loops.prior_cost(p, prior, active) for p in (pose, all_links, one_link)]
    assert costs[1] - costs[0] < 0.5 * (costs[2] - costs[0])


def test_about_is_the_product_of_two_gaussians():
    _, pose, prior = prior_of_spider()
    sd = np.full(len(pose), np.inf)
    sd[5] = 1 / np.sqrt(prior.precision[5])
    both = about(prior, pose + 1.0, sd)
    assert both.precision[5] == 2 * prior.precision[5]
    np.testing.assert_allclose(both.middle[5], (prior.middle[5] + pose[5] + 1.0) / 2)
    np.testing.assert_array_equal(np.delete(both.precision, 5), np.delete(prior.precision, 5))


def test_the_fit_finds_a_painted_pose_to_a_hundredth_of_a_pixel():
    animal, pose, prior = prior_of_spider()
    layout = make_layout(animal, px_per_unit=2.0)
    angles, lengths = parameter_kinds(animal)
    rng = np.random.default_rng(2)
    pose[angles] += rng.normal(0, 0.08, len(angles))
    canvas = make_canvas(180, 180, layout)
    paint(layout, pose, 2.0, np.zeros(2), *canvas)
    image_evidence = loops.ImageEvidence(canvas[0].copy(), np.full((180, 180), 70.0), np.zeros(2))
    first = pose.copy()
    first[:2] += (1.2, -0.8)
    first[angles] += rng.normal(0, 0.03, len(angles))
    free = prior._replace(precision=0.01 * prior.precision)
    active, shown = np.arange(len(pose)), np.ones(len(animal.legs) + 1, bool)
    fitted, _ = loops.fit_pose(
        layout, first, image_evidence, free, active, shown, 2.0, 0.45, 40, 1e-6, *canvas
    )
    np.testing.assert_allclose(fitted[:2], pose[:2], atol=0.01)
    np.testing.assert_allclose(fitted[2], pose[2], atol=1e-3)
    # only what is listed moves
    fixed, _ = loops.fit_pose(
        layout, first, image_evidence, free, angles, shown, 2.0, 0.45, 5, 1e-6, *canvas
    )
    np.testing.assert_array_equal(fixed[lengths], first[lengths])
    np.testing.assert_array_equal(fixed[:3], first[:3])


def test_the_cost_of_a_leg_fitted_alone_is_that_of_the_whole_picture():
    # what does not move is painted once: the cost is as if all were painted again in every step
    animal, pose, prior = prior_of_spider()
    layout = make_layout(animal, px_per_unit=2.0)
    canvas = make_canvas(180, 180, layout)
    paint(layout, pose, 2.0, np.zeros(2), *canvas)
    image_evidence = loops.ImageEvidence(canvas[0].copy(), np.full((180, 180), 70.0), np.zeros(2))
    first, second = (
        np.arange(layout.first[i], layout.first[i] + 2 * layout.n_links[i]) for i in (0, 1)
    )
    # onto its neighbour, and back
    away = pose.copy()
    away[first[0]] -= 0.25
    away[second] += 0.02
    shown = np.ones(len(animal.legs) + 1, bool)
    fitted, cost = loops.fit_pose(
        layout, away, image_evidence, prior, first, shown, 2.0, 0.45, 12, 1e-6, *canvas
    )
    assert np.abs(fitted[first] - away[first]).max() > 0.05, "the leg did not move"
    np.testing.assert_array_equal(np.delete(fitted, first), np.delete(away, first))
    fresh = make_canvas(180, 180, layout)
    paint(layout, fitted, 2.0, np.zeros(2), *fresh)
    whole = picture_cost(fresh[0], fresh[1], image_evidence.seen, image_evidence.weight, 0.45)
    np.testing.assert_allclose(cost, whole + loops.prior_cost(fitted, prior, first), rtol=1e-9)


def test_what_moves():
    layout = make_layout(load_species("dolomedes"), px_per_unit=2.0)
    of_leg = np.arange(9) == 2
    number = int(layout.first[2]) + 1
    np.testing.assert_array_equal(loops.what_moves(layout, np.array([number])), of_leg)
    assert loops.what_moves(layout, np.array([2, number])).all(), "legs hang on the body"
