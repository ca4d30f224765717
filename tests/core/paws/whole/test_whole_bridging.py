"""Stories without clutter against a textbook Kalman filter; with it, against what was put in."""

import itertools

import numpy as np
import pytest

from pawnb.core.paws.whole.bridging import Start, Stories, Telling, state_after
from pawnb.core.paws.whole.geometry import Geometry

# constant acceleration whose changes are white: Bar-Shalom, Li & Kirubarajan 2001, section 6.3
STEP = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
GAIN = np.array([1 / 6, 0.5, 1.0])
LINEAR = np.zeros((11, 3))
"""Three cameras so far away that projection is linear."""
LINEAR[:8] = np.array(
    [[4, 0, 0, 9, 0, 0, -4, 7], [0, 3, 1, -5, 1, 0, -4, 2], [2, -2, 0.5, 0, 0, 1, -3, 1]]
).T

# no story but the plain one with a good candidate
ONLY = {"kick_cost": 1e6, "bad_cost": 1e6, "clutter": 1e-30, "reach": 1e6}


def nothing(x, speed, recent):
    return np.zeros(len(x))


def told(geometry, state, covariance, *, start=None, **options):
    n_views = geometry.project(state[0]).shape[0]
    return Stories(
        state, covariance, geometry=geometry, thickness_px=np.linspace(8.0, 10.0, n_views),
        own=np.ones(n_views, bool), start=start,
        telling=Telling(**{"jerk": 0.3, "kick": 2.0, "noise": 0.4, "reach": 50.0, **options}),
    )  # fmt: skip


def conditioned(state, covariance, jerk, observed):
    """The last state by dense algebra: a Gaussian of all states, given all that was seen.

    ``observed`` holds for each frame its pairs (matrix on positions, value, variance).
    """
    d, n = state.shape[1], len(observed)
    F, Q = np.kron(STEP, np.eye(d)), jerk**2 * np.kron(np.outer(GAIN, GAIN), np.eye(d))
    mean, P = state.ravel(), np.kron(covariance, np.eye(d))
    powers = [np.linalg.matrix_power(F, k) for k in range(n + 1)]
    means = np.concatenate([powers[k] @ mean for k in range(1, n + 1)])
    joint = np.zeros((3 * d * n, 3 * d * n))
    for a in range(1, n + 1):
        for b in range(1, n + 1):
            block = powers[a] @ P @ powers[b].T
            for k in range(1, min(a, b) + 1):
                block += powers[a - k] @ Q @ powers[b - k].T
            joint[3 * d * (a - 1) : 3 * d * a, 3 * d * (b - 1) : 3 * d * b] = block
    rows, values, noise = [], [], []
    for t, here in enumerate(observed):
        for H, value, variance in here:
            row = np.zeros((len(H), 3 * d * n))
            row[:, 3 * d * t : 3 * d * t + d] = H
            rows.append(row)
            values.append(value)
            noise += [variance] * len(H)
    H = np.concatenate(rows)
    gain = joint @ H.T @ np.linalg.inv(H @ joint @ H.T + np.diag(noise))
    every = means + gain @ (np.concatenate(values) - H @ means)
    left = joint - gain @ H @ joint
    return every[-3 * d :], left[-3 * d :, -3 * d :]


@pytest.mark.parametrize("coefs", [None, LINEAR])
def test_one_candidate_a_frame_is_a_kalman_filter(coefs):
    rng = np.random.default_rng(3)
    geometry = Geometry(coefs)
    d = geometry.n_coordinates
    state, covariance = rng.normal(size=(3, d)), np.diag([0.2, 0.5, 0.1])
    stories = told(geometry, state, covariance, **ONLY)
    x, observed = state.copy(), []
    for t in range(7):
        x = STEP @ x + 0.3 * np.outer(GAIN, rng.normal(size=d))
        stories.advance()
        observed.append([])
        if t == 5:
            place = x[0] + 0.4 * rng.normal(size=d)
            stories.stand(place)
            observed[t].append((np.eye(d), place, 0.4**2))
        elif t != 3:  # unseen there
            for v, J in enumerate(geometry.jacobian(x[0])):
                sd = 0.15 * stories.thickness_px[v]
                away = geometry.project(x[0])[v] - J @ x[0]
                uv = geometry.project(x[0])[v] + sd * rng.normal(size=2)
                stories.see(v, uv[None], np.zeros(1))
                observed[t].append((J, uv - away, sd**2))
        stories.settle(nothing, certain=t == 5)
    mean, P = conditioned(state, covariance, 0.3, observed)
    assert len(stories.cost) == 1
    np.testing.assert_allclose(stories.mean[0], mean, atol=1e-8)
    np.testing.assert_allclose(stories.covariance[0], P, atol=1e-8)
    expected = np.full((7, len(stories.own)), 0)
    expected[[3, 5]] = -1
    np.testing.assert_array_equal(stories.best(), expected)


def test_the_state_after_certain_places_is_that_of_a_kalman_filter():
    rng = np.random.default_rng(4)
    places = np.cumsum(rng.normal(size=(6, 2)), axis=0)
    telling = Telling(jerk=0.3, kick=2.0, noise=0.4, reach=50.0)
    drift = np.array([-0.5, 0.2])
    mean, P = state_after(places, drift, telling=telling, speed=1.5)
    first = np.stack([places[0], drift, np.zeros(2)])
    before = np.diag([0.4**2, 1.5**2, 0.9**2])
    seen = [[(np.eye(2), place, 0.4**2)] for place in places[1:]]
    expected, spread = conditioned(first, before, 0.3, seen)
    np.testing.assert_allclose(mean.ravel(), expected, atol=1e-9)
    np.testing.assert_allclose(np.kron(P, np.eye(2)), spread, atol=1e-9)


def lift_off(**options):
    """Tell of a paw that stands and then swings at once, beside a thing that goes on standing."""
    state = np.zeros((3, 2))
    stories = told(Geometry(None), state, np.diag([0.04, 0.01, 1e-4]), jerk=0.05, **options)
    for t in range(8):
        paw = np.array([max(0.0, 4.0 * (t - 2)), 0.0])
        stories.advance()
        stories.see(0, np.array([[-1.0, 6.0], paw]), np.array([2.0, 0.0]))
        stories.settle(nothing)
    return stories.best()[:, 0]


def test_a_paw_that_lifts_off_is_followed_by_a_kick():
    np.testing.assert_array_equal(lift_off(), np.ones(8))
    # without kicks nothing can go so fast
    assert lift_off(kick_cost=1e6)[-1] != 1


def test_what_a_point_is_doubted_for_is_not_believed():
    def doubt(x, speed, recent):
        return np.where(x[:, 1] > 0, 20.0, 0.0)

    for sign in (1.0, -1.0):
        stories = told(Geometry(None), np.zeros((3, 2)), np.diag([0.04, 1.0, 0.1]))
        for t in range(5):
            stories.advance()
            fork = np.array([[0.0, 1.0 + t], [0.0, -1.0 - t]]) * sign
            stories.see(0, fork, np.zeros(2))
            stories.settle(doubt)
        np.testing.assert_array_equal(stories.best()[1:, 0], 1 if sign > 0 else 0)


def test_stories_that_tell_the_same_are_told_once():
    stories = told(Geometry(None), np.zeros((3, 2)), np.diag([4.0, 4.0, 1.0]), most=5)
    rng = np.random.default_rng(2)
    for _ in range(6):
        stories.advance()
        stories.see(0, 4.0 * rng.normal(size=(6, 2)), np.zeros(6))
        stories.settle(nothing)
        assert 1 < len(stories.cost) <= 5
        assert (np.diff(stories.cost) >= 0).all()
        # positions and speeds of any two differ by more than half a standard deviation of
        # the surer one and half of the noise
        spread = np.sqrt(stories.covariance.diagonal(axis1=1, axis2=2)[:, :4])
        for a, b in itertools.combinations(range(len(stories.cost)), 2):
            apart = np.abs(stories.mean[a, :4] - stories.mean[b, :4])
            assert (apart > 0.2 + 0.5 * np.minimum(spread[a], spread[b])).any()
    # covariances stay what they are: symmetric, positive
    assert np.linalg.eigvalsh(stories.covariance).min() > 0


def test_an_expected_place_is_taken_in_as_a_kalman_filter_does():
    rng = np.random.default_rng(6)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])  # forward and up, oblique in the picture
    state, covariance = rng.normal(size=(3, 2)), np.diag([0.5, 0.3, 0.1])
    at, variance = state[0] + [0.7, -0.4], np.array([0.9, 0.2])
    stories = told(Geometry(None), state, covariance, **ONLY)
    stories.advance()
    before = (stories.mean[0].copy(), stories.covariance[0].copy(), stories.cost[0])
    stories.expect(at, turn, variance, most=100.0)
    H = np.concatenate([turn, np.zeros((2, 4))], axis=1)
    # information adds up: Bar-Shalom, Li & Kirubarajan 2001, section 7.2
    left = np.linalg.inv(np.linalg.inv(before[1]) + H.T @ np.diag(1 / variance) @ H)
    step = turn @ at - H @ before[0]
    mean = before[0] + left @ H.T @ np.diag(1 / variance) @ step
    np.testing.assert_allclose(stories.mean[0], mean, atol=1e-10)
    np.testing.assert_allclose(stories.covariance[0], left, atol=1e-10)
    # squared distances add up axis by axis: that of the second after the first was taken in
    square = step @ np.linalg.solve(H @ before[1] @ H.T + np.diag(variance), step)
    assert stories.cost[0] - before[2] == pytest.approx(0.5 * square)


def test_a_story_far_from_where_it_is_expected_goes_its_own_way():
    stories = told(Geometry(None), np.zeros((3, 2)), np.diag([0.04, 0.01, 1e-4]), **ONLY)
    stories.advance()
    mean, cost = stories.mean.copy(), stories.cost.copy()
    stories.expect(np.array([50.0, 0.0]), np.eye(2), np.ones(2), most=1.6)
    np.testing.assert_array_equal(stories.mean, mean)
    np.testing.assert_allclose(stories.cost - cost, 1.6)


def standing(start, *, dear=(), **options):
    """Tell of a paw that stands on moving ground, lifts off after the fifth frame and is seen."""
    ground = np.array([-1.0, 0.0])

    def rides(x, speed, recent):
        return 7.0 * recent * np.exp(-((np.linalg.norm(speed - ground, axis=1) / 0.5) ** 2))

    state = np.stack([np.zeros(2), ground, np.zeros(2)])
    stories = Stories(
        state, np.diag([0.04, 0.01, 1e-4]), geometry=Geometry(None), thickness_px=np.array([8.0]),
        own=np.ones(1, bool), start=start,
        telling=Telling(jerk=0.05, kick=2.0, noise=0.4, reach=50.0, **options),
    )  # fmt: skip
    for t in range(1, 9):
        stories.advance(lifting=30.0 if t in dear else 0.0)
        # a poor looking wrist keeps above it; once it has lifted off, by 3 a frame, it shows
        seen = [t * ground + [0.0, -9.0]]
        if t > 5:
            seen.append(t * ground + [0.0, -3.0 * (t - 5.5)])
        stories.see(0, np.array(seen), np.array([4.0, 0.0])[: len(seen)])
        stories.settle(rides, covered=np.ones(1, bool))
    return stories


def test_a_paw_stands_under_its_wrist_until_it_lifts_off():
    start = Start(np.zeros(2), np.array([-1.0, 0.0]), np.array([0.0, -3.0]))
    stories = standing(start)
    np.testing.assert_array_equal(stories.stood(), np.arange(1, 9) <= 5)
    np.testing.assert_array_equal(stories.best()[:, 0], [-1] * 5 + [1] * 3)
    assert not standing(None).stood().any()


@pytest.mark.parametrize(("dear", "last"), [((1, 2, 3), 5), ((6,), 4), ((5, 6, 7), 3)])
def test_a_paw_lifts_off_earlier_where_that_is_dear_when_it_does(dear, last):
    start = Start(np.zeros(2), np.array([-1.0, 0.0]), np.array([0.0, -3.0]))
    np.testing.assert_array_equal(standing(start, dear=dear).stood(), np.arange(1, 9) <= last)


def test_what_stands_goes_exactly_with_the_ground():
    start = Start(np.array([3.0, 2.0]), np.array([-1.0, 0.25]), np.array([0.0, -4.0]))
    stories = told(Geometry(None), np.ones((3, 2)), np.eye(3), start=start)
    for t in range(1, 4):
        stories.advance()
        ground = np.array([3.0 - t, 2.0 + 0.25 * t])
        np.testing.assert_allclose(stories.mean[0], [*ground, -1.0, 0.25, 0.0, 0.0])
        # its place is less sure from frame to frame, by 0.1 of 0.4, from 0.4 of it
        np.testing.assert_allclose(stories.covariance[0].diagonal()[:2], 0.16**2 + t * 0.04**2)
        if t == 1:
            # half a frame after it lifted off, on average
            np.testing.assert_allclose(stories.mean[1, :2], [*ground[:1], ground[1] - 2.0])
            np.testing.assert_allclose(stories.mean[1, 2:4], [-1.0, -3.75])
        stories.settle(nothing)
        assert stories.stood().all()
