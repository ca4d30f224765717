"""The arc of a swing, and swings made by other formulas that are fitted though occluded in part."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as rules
from hypothesis import strategies as st
from scipy.stats import beta

from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.swing_trajectory import (
    Guess,
    Part,
    SwingTrajectory,
    changes,
    fit_swings,
    learn_trajectory,
    trajectory_at,
)
from pawnb.core.paws.offline.stride.trajectory_kernels import forward as forward_at
from pawnb.core.paws.offline.stride.trajectory_kernels import peak
from pawnb.core.paws.offline.stride.trajectory_kernels import upward as upward_at

SHAPE, SHAPE_SD = np.array(STRIDE.swing_shape), np.array(STRIDE.swing_shape_sd)
SLOPE, SLOPE_SD = STRIDE.landing_speed, STRIDE.landing_speed_sd
SHARES = np.linspace(0.0, 1.0, 101)
EXPONENTS = st.floats(0.7, 4.0)


def forward(shares, slope):
    return np.array([forward_at(s, slope) for s in np.atleast_1d(shares)])


def upward(shares, shape):
    return np.array([upward_at(s, shape, peak(shape)) for s in np.atleast_1d(shares)])


def quintic(slope):
    """Coefficients, lowest first, of the polynomial from rest at 0 to ``slope`` at 1.

    Flash & Hogan 1985: of least jerk are those of fifth order, told by place, speed and
    acceleration at both ends; here the last acceleration is none.
    """
    power = np.arange(6)
    begin = [np.eye(6)[0], np.eye(6)[1], 2.0 * np.eye(6)[2]]
    end = [np.ones(6), power, power * (power - 1)]
    return np.linalg.solve(np.array(begin + end), [0.0, 0.0, 0.0, 1.0, slope, 0.0])


@pytest.mark.parametrize("slope", [0.0, 0.3, 0.9])
def test_forward_is_the_polynomial_of_least_jerk(slope):
    expected = np.polynomial.polynomial.polyval(SHARES, quintic(slope))
    np.testing.assert_allclose(forward(SHARES, slope), expected, atol=1e-12)
    assert not np.allclose(forward(SHARES, slope), SHARES)


def test_from_rest_to_rest_half_the_way_takes_half_the_time():
    assert forward(np.array(0.5), 0.0) == pytest.approx(0.5)
    # its largest speed is 1.875 of the mean one, in the middle (Flash & Hogan 1985)
    assert np.gradient(forward(SHARES, 0.0), SHARES).max() == pytest.approx(1.875, abs=1e-3)


@given(EXPONENTS, EXPONENTS)
def test_upward_is_a_beta_density_in_its_largest_value(a, b):
    of = beta(a + 1.0, b + 1.0)
    shape = np.array([a, b])
    expected = of.pdf(SHARES) / of.pdf(a / (a + b))
    np.testing.assert_allclose(upward(SHARES, shape), expected, atol=1e-5)
    assert upward(np.array(a / (a + b)), shape) == pytest.approx(1.0)


@pytest.mark.usefixtures("steps_of_loops")
def test_before_it_lifts_off_and_after_it_has_landed_a_paw_is_on_the_ground():
    way, up = trajectory_at(
        np.array([10.0, 30.0, 2.0, 0.3]), SHAPE, np.array([-5.0, 10, 20, 30, 99])
    )
    np.testing.assert_allclose(way[[0, 1, 3, 4]], [0.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(up[[0, 1, 3, 4]], 0.0, atol=1e-3)
    assert 0.3 < way[2] < 0.6
    assert 1.9 < up[2] < 2.0
    # a swing that takes no time is no reason to fail
    assert np.isfinite(
        trajectory_at(np.array([10.0, 10.0, 2.0, 0.3]), SHAPE, np.arange(20.0))
    ).all()


@pytest.mark.usefixtures("steps_of_loops")
def test_changes_of_the_arc_are_its_derivatives():
    values, frames = np.array([[10.0, 30.0, 2.0, 0.3], [40.0, 55.0, 1.0, 0.0]]), np.arange(12.0, 29)
    frames = np.stack([frames, frames[:14:-1].repeat(9)[:17] + 20.0])
    by_value, by_shape = changes(values, SHAPE, frames)
    _, up = trajectory_at(values, SHAPE, frames)
    # what is linear is told exactly
    np.testing.assert_allclose(by_value[2, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(by_value[2, 1], up / values[:, 2:3], atol=1e-9)
    np.testing.assert_allclose(by_shape[:, 0], 0.0, atol=1e-9)
    # of a swing that is later by a frame, each frame shows what the one before did
    sooner, later = (np.stack(trajectory_at(values, SHAPE, frames + h)) for h in (0.01, -0.01))
    np.testing.assert_allclose(by_value[0] + by_value[1], (later - sooner) / 0.02, atol=0.02)
    s = (frames - values[:, :1]) / (values[:, 1:2] - values[:, :1])
    expected = up * (np.log(s) - np.log(SHAPE[0] / SHAPE.sum()))
    np.testing.assert_allclose(by_shape[0, 1], expected, atol=0.02)


STEP = 12.0


def made(count, *, shape=SHAPE, seed=0, hidden=0.0, noise=0.15, height=2.0, sd=(1.5, 1.0)):
    """Return swings by other formulas, as seen, what is guessed of them, and the truth (S, 4).

    Forward by :func:`quintic`, upwards by a beta density; lift-off, landing, height and last
    speed scatter as the model says, and noise is alike in three neighbouring frames. Of each
    the share ``occluded`` is not seen.
    """
    rng = np.random.default_rng(seed)
    times = np.column_stack([rng.uniform(8.0, 12.0, count), rng.uniform(38.0, 44.0, count)])
    times += 100.0 * np.arange(count)[:, None]
    truth = np.column_stack([
        times + rng.normal(size=times.shape) * sd,
        height * (1.0 + STRIDE.swing_height_sd * rng.normal(size=count).clip(-2.0, 2.0)),
        SLOPE + SLOPE_SD * rng.normal(size=count),
    ])  # fmt: skip
    frames = 100.0 * np.arange(count)[:, None] + np.arange(52)
    s = ((frames - truth[:, :1]) / (truth[:, 1:2] - truth[:, :1])).clip(0.0, 1.0)
    way = np.stack([
        np.polynomial.polynomial.polyval(of, quintic(slope))
        for of, slope in zip(s, truth[:, 3], strict=True)
    ])  # fmt: skip
    a, b = shape
    up = truth[:, 2:3] * beta(a + 1, b + 1).pdf(s) / beta(a + 1, b + 1).pdf(a / (a + b))
    err = rng.normal(size=(3, count, 54))
    err = noise * np.stack([np.convolve(e, np.ones(3), "valid") for e in err.reshape(-1, 54)])
    err = err.reshape(3, count, 52) / np.sqrt(3.0)
    weight = np.where((s > 0.0) & (s < hidden), 0.0, 1.0)
    part = Part(
        frames, way + err[0] / STEP, up + err[1], weight,
        np.full(count, STEP),
    )  # fmt: skip
    return part, Guess(times, np.tile(sd, (count, 1))), truth


def known(shape=SHAPE, height=2.0):
    """Return an arc that is known."""
    return SwingTrajectory(np.asarray(shape), np.zeros((2, 2)), height)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [(1.0, 1.0), (1.2, 2.4), (2.2, 1.3)])
@pytest.mark.parametrize("hidden", [0.0, 0.45])
def test_the_arc_is_learnt_from_swings_whose_beginning_is_hidden(shape, hidden):
    part, guess, truth = made(16, shape=shape, hidden=hidden, seed=4)
    trajectory = learn_trajectory(part, guess)
    sd = np.sqrt(np.diag(trajectory.covariance))
    assert (np.abs(trajectory.shape - shape) < 3.0 * sd).all()
    assert (sd < 0.7 * SHAPE_SD).all()
    # a top that was never seen was perhaps higher
    within = (0.1 if hidden else 0.05) if shape[0] / sum(shape) > hidden else 0.2
    assert trajectory.height == pytest.approx(np.median(truth[:, 2]), rel=within)
    # less is known of the beginning of what was seen less
    if hidden:
        seen = learn_trajectory(replace(part, weight=np.ones_like(part.weight)), guess)
        assert sd[0] > np.sqrt(seen.covariance[0, 0])


@pytest.mark.parametrize("hidden", [0.0, 0.45])
def test_the_stated_sd_of_lift_off_and_landing_is_honest(hidden):
    part, guess, truth = made(200, hidden=hidden, seed=1)
    values, covariance = fit_swings(known(), part, guess)
    sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    error = (values - truth) / sd
    # of 200 the root mean square is told to 5 %
    np.testing.assert_allclose(np.sqrt(np.mean(error**2, axis=0)), 1.0, atol=0.25)
    np.testing.assert_allclose(error.mean(axis=0), 0.0, atol=0.3)
    # and it is much less than what was known before
    assert np.median(sd[:, 0]) < (0.6 if hidden else 0.4) * guess.sd[0, 0]
    assert np.median(sd[:, 1]) < 0.7 * guess.sd[0, 1]


def test_where_it_was_hidden_the_arc_is_near_the_truth():
    part, guess, _ = made(12, hidden=0.45, seed=2)
    truth = made(12, noise=0.0, seed=2)[0]
    trajectory = learn_trajectory(part, guess)
    is_hidden = part.weight == 0.0
    assert is_hidden.sum(axis=1).min() > 10

    def off(values, shape):
        way, up = trajectory_at(values, shape, part.frames)
        away = np.hypot(STEP * (way - truth.way), up - truth.up)[is_hidden]
        return np.sqrt(np.mean(away**2))

    # within about twice what is put on each place that is seen, in the two directions
    found = off(fit_swings(trajectory, part, guess)[0], trajectory.shape)
    assert found < 0.3
    expected = np.column_stack([guess.times, np.tile([2.0, SLOPE], (12, 1))])
    assert found < 0.5 * off(expected, SHAPE)


def test_another_family_of_bumps_is_followed_closely():
    """Paws do not know of beta curves: heights go as sin(pi s) and as sin(pi s)^2."""
    for power, near in ((1, 0.05), (2, 0.12)):
        part, guess, truth = made(16, seed=6, noise=0.0, sd=(0.5, 0.5))
        s = ((part.frames - truth[:, :1]) / (truth[:, 1:2] - truth[:, :1])).clip(0.0, 1.0)
        up = truth[:, 2:3] * np.sin(np.pi * s) ** power
        weight = np.where((s > 0.0) & (s < 0.45), 0.0, 1.0)
        part = replace(part, up=up, weight=weight)
        trajectory = learn_trajectory(part, guess)
        _, found = trajectory_at(
            fit_swings(trajectory, part, guess)[0], trajectory.shape, part.frames
        )
        assert np.sqrt(np.mean((found - up)[weight == 0.0] ** 2)) < near * 2.0
        # it is as high late as early
        assert trajectory.shape[0] == pytest.approx(trajectory.shape[1], abs=0.5)


def test_a_place_far_off_hardly_counts():
    part, guess, _ = made(8, seed=3)
    up = part.up.copy()
    up[:, 20:23] += 8.0
    (plain, _), (pulled, _) = (
        fit_swings(known(), of, guess) for of in (part, replace(part, up=up))
    )
    np.testing.assert_allclose(pulled[:, :2], plain[:, :2], atol=0.3)
    np.testing.assert_allclose(pulled[:, 2], plain[:, 2], atol=0.25)


def test_swings_of_which_nothing_is_seen_stay_as_guessed():
    part, guess, _ = made(5)
    part = replace(part, weight=np.zeros_like(part.weight))
    trajectory = learn_trajectory(part, guess)
    np.testing.assert_allclose(trajectory.shape, SHAPE)
    np.testing.assert_allclose(np.diag(trajectory.covariance), SHAPE_SD**2)
    values, covariance = fit_swings(trajectory, part, guess)
    np.testing.assert_allclose(values[:, :2], guess.times)
    np.testing.assert_allclose(np.diagonal(covariance, axis1=1, axis2=2)[:, :2], guess.sd**2)
    assert trajectory.height == 1.0


def test_no_swings_are_fitted_to_none():
    nothing = np.empty((0, 20))
    part = Part(nothing, nothing, nothing, nothing, np.empty(0))
    values, covariance = fit_swings(known(), part, Guess(np.empty((0, 2)), np.empty((0, 2))))
    assert values.shape == (0, 4)
    assert covariance.shape == (0, 4, 4)


def test_each_swing_is_fitted_by_itself():
    part, guess, _ = made(4, hidden=0.45, seed=5)
    values, covariance = fit_swings(known(), part, guess)
    one = Part(*(getattr(part, name)[2:3] for name in vars(part)))
    alone, spread = fit_swings(known(), one, Guess(guess.times[2:3], guess.sd[2:3]))
    np.testing.assert_allclose(alone[0], values[2], rtol=1e-9)
    np.testing.assert_allclose(spread[0], covariance[2], rtol=1e-9)


@rules(max_examples=5)
@given(st.integers(-500, 500), st.permutations(range(3)))
def test_when_it_is_and_in_which_order_does_not_matter(later, order):
    part, guess, _ = made(3, hidden=0.3, seed=7)
    moved = Part(*(getattr(part, name)[order] for name in vars(part)))
    moved = replace(moved, frames=moved.frames + later)
    again = Guess(guess.times[order] + later, guess.sd[order])
    trajectory, same = learn_trajectory(part, guess), learn_trajectory(moved, again)
    np.testing.assert_allclose(same.shape, trajectory.shape, rtol=1e-6)
    np.testing.assert_allclose(same.covariance, trajectory.covariance, rtol=1e-6)
    values, _ = fit_swings(trajectory, part, guess)
    found, _ = fit_swings(trajectory, moved, again)
    np.testing.assert_allclose(found, values[order] + [later, later, 0.0, 0.0], atol=1e-6)
