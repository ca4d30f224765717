"""Hypotheses without clutter against a textbook Kalman filter; with it, against what was put in."""

import itertools

import numpy as np
import pytest

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.offline.gap_closing import hypothesis_kernels, mht_kernels, update_kernels
from pawnb.core.paws.offline.gap_closing.mht import process_noise_of, state_after
from pawnb.core.paws.offline.gap_closing.mht_parameters import mht_parameters as of_stage
from pawnb.core.paws.offline.gap_closing.usual_region import UsualRegion
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.plausibility_kernels import KinematicPrior

# constant acceleration whose changes are white: Bar-Shalom, Li & Kirubarajan 2001, section 6.3
STEP = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
GAIN = np.array([1 / 6, 0.5, 1.0])
LINEAR = np.zeros((11, 3))
"""Three cameras so far away that projection is linear."""
LINEAR[:8] = np.array(
    [[4, 0, 0, 9, 0, 0, -4, 7], [0, 3, 1, -5, 1, 0, -4, 2], [2, -2, 0.5, 0, 0, 1, -3, 1]]
).T

# no hypothesis but the plain one with a good detection
ONLY = {"impulse_cost": 1e6, "bad_cost": 1e6, "clutter": 1e-30, "reach": 1e6}


USUAL = {"jerk": 0.3, "impulse": 2.0, "noise": 0.4, "reach": 50.0, "rising": 0, "swinging": 0}


def mht_parameters(**options):
    return of_stage(**USUAL)._replace(**options)


def target(
    geometry, parameters, *, substrate_velocity=None, liftoff_velocity=None, **kinematic_prior
):
    """Return how hypotheses are told of a point about which there is no doubt but the given one."""
    d = geometry.n_coordinates
    substrate_velocity, liftoff_velocity = (
        np.zeros(d) if one is None else np.array(one)
        for one in (substrate_velocity, liftoff_velocity)
    )
    n_views = geometry.table.shape[1]
    axes = np.eye(d)
    nothing = {
        "forward": axes[0],
        "up": axes[-1],
        "fastest_back": -np.inf,
        "back_sd": 1.0,
        "lowest": -np.inf,
        "paw_width": 1.0,
        "height": np.nan,
        "substrate_velocity": substrate_velocity,
        "tolerance": 1.0,
        "way": 1,
        "above": STRIDE.lifted_above,
        "within": STRIDE.lifted_within,
        "ride": STRIDE.ride,
        "below": STRIDE.sunk,
        "strangest": STRIDE.strangest,
    }
    return mht_kernels.TargetModel(
        update_kernels.Cameras(
            geometry.rows,
            np.linspace(8.0, 10.0, n_views),
            np.ones(n_views, bool),
        ),
        process_noise_of(parameters, substrate_velocity, liftoff_velocity=liftoff_velocity),
        KinematicPrior(**{**nothing, **kinematic_prior}),
        parameters,
    )


class Steps:
    """Hypotheses told step by step."""

    def __init__(
        self,
        geometry,
        state,
        covariance,
        *,
        place=None,
        substrate_velocity=None,
        liftoff_velocity=None,
        **options,
    ):
        self.parameters = mht_parameters(**options)
        self.target = target(
            geometry,
            self.parameters,
            substrate_velocity=substrate_velocity,
            liftoff_velocity=liftoff_velocity,
        )
        d, n_views = state.shape[1], len(self.target.cameras.tracked_in_view)
        room = max(2 * self.parameters.most, self.parameters.most_within)
        self.now, self.then = (hypothesis_kernels.allocate(room, d, n_views) for _ in range(2))
        place = np.full(d, np.nan) if place is None else np.array(place)
        self.home = state[0]
        self.n = hypothesis_kernels.initialise(
            self.now, state, covariance, place, self.target.process_noise
        )

    def advance(self):
        parameters, process_noise = self.parameters, self.target.process_noise
        self.n = hypothesis_kernels.predict(
            self.now, self.n, self.then, process_noise, parameters.impulse_cost, 0.0
        )
        self.now, self.then = self.then, self.now

    def see(self, view, at, cost, *, rising=None):
        pairs = update_kernels.allocate_pairs(len(self.now.cost) * len(at))
        negative_log_odds = np.stack([cost, cost if rising is None else rising])
        self.now, self.then, self.n = update_kernels.associate(
            self.now,
            self.n,
            self.then,
            view,
            self.target.cameras,
            at,
            negative_log_odds,
            self.parameters,
            pairs,
        )

    def stand(self, place):
        hypothesis_kernels.update_with_position(self.now, self.n, place, self.parameters.noise**2)

    def expect(self, at, axes, variance, *, most):
        hypothesis_kernels.update_with_expectation(self.now, self.n, at, axes, variance, most)

    def settle(self, *, certain=False):
        mht_kernels.add_motion_cost(self.now, self.n, self.home, self.target, certain, False)
        self.n = mht_kernels.prune_and_merge(self.now, self.n, self.then, self.parameters)
        self.now, self.then = self.then, self.now

    @property
    def mean(self):
        return self.now.mean[:, : self.n].T.copy()

    @property
    def cost(self):
        return self.now.cost[: self.n].copy()

    @property
    def covariance(self):
        size = len(self.now.mean)
        full = np.empty((self.n, size, size))
        for j, i in np.ndindex(size, size):
            full[:, j, i] = self.now.covariance[hypothesis_kernels.cell(j, i), : self.n]
        return full


def anywhere(frames):
    """No limits, and no other point."""
    beyond = np.full((frames, 1), np.inf)
    nobody = np.empty((frames, 0, 2))
    return UsualRegion(np.array([[1.0, 0.0]]), -beyond, beyond, 1.0, nobody, 0.0, 0.0)


def close(at, cost, *, state, covariance, place=None, expected=(), lifting=None, **setting):
    """Tell what detections (frames, c, 2) of one picture, NaN where there is none, say of a point.

    Returns which were taken, and where it stands.
    """
    parameters = mht_parameters(**setting.pop("options", {}))
    covered = np.full(len(at), setting.pop("covered", False))
    there = np.isfinite(at[..., 0])
    negative_log_odds = np.repeat(np.broadcast_to(cost, there.shape)[None, :, None], 2, axis=0)
    nowhere = np.full((0, len(at), 2), np.nan)
    taken, stood, _ = mht_kernels.run_mht(
        np.asarray(state, float),
        covariance,
        np.full(2, np.nan) if place is None else place,
        mht_kernels.GapEvidence(
            there.sum(axis=1)[:, None],
            np.nan_to_num(at)[:, None],
            negative_log_odds,
            covered,
            np.empty((0, 2)),
            np.zeros(len(at)) if lifting is None else lifting,
        ),
        mht_kernels.ExpectedPositions(nowhere, nowhere, np.empty((0, 2, 2)), np.empty(0)),
        anywhere(len(at)),
        target(Projection(None), parameters, **setting),
    )
    return taken[:, 0], stood


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


@pytest.mark.usefixtures("steps_of_loops")
@pytest.mark.parametrize("coefs", [None, LINEAR])
def test_one_candidate_a_frame_is_a_kalman_filter(coefs):
    rng = np.random.default_rng(3)
    geometry = Projection(coefs)
    d = geometry.n_coordinates
    state, covariance = rng.normal(size=(3, d)), np.diag([0.2, 0.5, 0.1])
    hypotheses = Steps(geometry, state, covariance, **ONLY)
    x, observed = state.copy(), []
    for t in range(7):
        x = STEP @ x + 0.3 * np.outer(GAIN, rng.normal(size=d))
        hypotheses.advance()
        observed.append([])
        if t == 5:
            place = x[0] + 0.4 * rng.normal(size=d)
            hypotheses.stand(place)
            observed[t].append((np.eye(d), place, 0.4**2))
        elif t != 3:  # unseen there
            for v, J in enumerate(geometry.jacobian(x[0])):
                sd = 0.15 * hypotheses.target.cameras.paw_width[v]
                away = geometry.project(x[0])[v] - J @ x[0]
                uv = geometry.project(x[0])[v] + sd * rng.normal(size=2)
                hypotheses.see(v, uv[None], np.zeros(1))
                observed[t].append((J, uv - away, sd**2))
        hypotheses.settle(certain=t == 5)
        np.testing.assert_array_equal(hypotheses.now.taken[:, 0], -1 if t in (3, 5) else 0)
    mean, P = conditioned(state, covariance, 0.3, observed)
    assert len(hypotheses.cost) == 1
    np.testing.assert_allclose(hypotheses.mean[0], mean, atol=1e-8)
    np.testing.assert_allclose(hypotheses.covariance[0], P, atol=1e-8)


def test_the_state_after_certain_places_is_that_of_a_kalman_filter():
    rng = np.random.default_rng(4)
    places = np.cumsum(rng.normal(size=(6, 2)), axis=0)
    substrate_velocity = np.array([-0.5, 0.2])
    mean, P = state_after(places, substrate_velocity, parameters=mht_parameters(), speed=1.5)
    first = np.stack([places[0], substrate_velocity, np.zeros(2)])
    before = np.diag([0.4**2, 1.5**2, 0.3**2])
    seen = [[(np.eye(2), place, 0.4**2)] for place in places[1:]]
    expected, spread = conditioned(first, before, 0.3, seen)
    np.testing.assert_allclose(mean.ravel(), expected, atol=1e-9)
    np.testing.assert_allclose(np.kron(P, np.eye(2)), spread, atol=1e-9)


def lift_off(**options):
    """Tell of a paw that stands and then swings at once, beside a thing that goes on standing."""
    paw = np.maximum(0.0, 4.0 * (np.arange(8.0) - 2))
    at = np.stack([np.tile([-1.0, 6.0], (8, 1)), np.column_stack([paw, 0 * paw])], axis=1)
    taken, _ = close(
        at, [2.0, 0.0], state=np.zeros((3, 2)), covariance=np.diag([0.04, 0.01, 1e-4]),
        options={"jerk": 0.05, **options},
    )  # fmt: skip
    return taken


def test_a_paw_that_lifts_off_is_followed_by_a_manoeuvre():
    np.testing.assert_array_equal(lift_off(), np.ones(8))
    # without manoeuvres nothing can go so fast
    assert lift_off(impulse_cost=1e6)[-1] != 1


def test_what_is_set_is_what_the_compiled_loops_read():
    still = np.zeros((6, 1, 2)) + 0.5

    def taken():
        return close(still, np.zeros(1), state=np.zeros((3, 2)), covariance=np.eye(3))[0]

    assert (taken() == 0).all()
    for name, value in (("mht_gate", 1e-6), ("mht_clutter", 1e9)):
        with parameters_set({"gap_closing": {name: value}}):
            assert (taken() == -1).all(), name


def test_what_a_point_is_doubted_for_is_not_believed():
    # no point goes above the picture's line v = 0: a quarter beyond is a standard deviation
    kinematic_prior = {"up": np.array([0.0, -1.0]), "lowest": 0.35, "paw_width": 0.5}
    up = np.column_stack([np.zeros(5), 1.0 + np.arange(5.0)])
    for sign in (1.0, -1.0):
        fork = np.stack([up, -up], axis=1) * sign
        taken, _ = close(
            fork, np.zeros(2), state=np.zeros((3, 2)), covariance=np.diag([0.04, 1.0, 0.1]),
            **kinematic_prior,
        )  # fmt: skip
        np.testing.assert_array_equal(taken[1:], 1 if sign > 0 else 0)


@pytest.mark.usefixtures("steps_of_loops")
def test_stories_that_tell_the_same_are_told_once():
    hypotheses = Steps(Projection(None), np.zeros((3, 2)), np.diag([4.0, 4.0, 1.0]), most=5)
    rng = np.random.default_rng(2)
    for _ in range(6):
        hypotheses.advance()
        hypotheses.see(0, 4.0 * rng.normal(size=(6, 2)), np.zeros(6))
        hypotheses.settle()
        assert 1 < len(hypotheses.cost) <= 5
        assert (np.diff(hypotheses.cost) >= 0).all()
        # positions and speeds of any two differ by more than half a standard deviation of
        # the surer one and half of the noise
        spread = np.sqrt(hypotheses.covariance.diagonal(axis1=1, axis2=2)[:, :4])
        for a, b in itertools.combinations(range(len(hypotheses.cost)), 2):
            apart = np.abs(hypotheses.mean[a, :4] - hypotheses.mean[b, :4])
            assert (apart > 0.2 + 0.5 * np.minimum(spread[a], spread[b])).any()
    # covariances stay what they are: positive
    assert np.linalg.eigvalsh(hypotheses.covariance).min() > 0


@pytest.mark.usefixtures("steps_of_loops")
def test_an_expected_place_is_taken_in_as_a_kalman_filter_does():
    rng = np.random.default_rng(6)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])  # forward and up, oblique in the picture
    state, covariance = rng.normal(size=(3, 2)), np.diag([0.5, 0.3, 0.1])
    at, variance = state[0] + [0.7, -0.4], np.array([0.9, 0.2])
    hypotheses = Steps(Projection(None), state, covariance, **ONLY)
    hypotheses.advance()
    before = (hypotheses.mean[0].copy(), hypotheses.covariance[0].copy(), hypotheses.cost[0])
    hypotheses.expect(at, turn, variance, most=100.0)
    H = np.concatenate([turn, np.zeros((2, 4))], axis=1)
    # information adds up: Bar-Shalom, Li & Kirubarajan 2001, section 7.2
    left = np.linalg.inv(np.linalg.inv(before[1]) + H.T @ np.diag(1 / variance) @ H)
    step = turn @ at - H @ before[0]
    mean = before[0] + left @ H.T @ np.diag(1 / variance) @ step
    np.testing.assert_allclose(hypotheses.mean[0], mean, atol=1e-10)
    np.testing.assert_allclose(hypotheses.covariance[0], left, atol=1e-10)
    # squared distances add up axis by axis: that of the second after the first was taken in
    square = step @ np.linalg.solve(H @ before[1] @ H.T + np.diag(variance), step)
    assert hypotheses.cost[0] - before[2] == pytest.approx(0.5 * square)


@pytest.mark.usefixtures("steps_of_loops")
def test_a_story_far_from_where_it_is_expected_goes_its_own_way():
    hypotheses = Steps(Projection(None), np.zeros((3, 2)), np.diag([0.04, 0.01, 1e-4]), **ONLY)
    hypotheses.advance()
    mean, cost = hypotheses.mean.copy(), hypotheses.cost.copy()
    hypotheses.expect(np.array([50.0, 0.0]), np.eye(2), np.ones(2), most=1.6)
    np.testing.assert_array_equal(hypotheses.mean, mean)
    np.testing.assert_allclose(hypotheses.cost - cost, 1.6)


def standing(place, *, dear=()):
    """Tell of a paw that stands on moving ground, lifts off after the fifth frame and is seen."""
    substrate = np.array([-1.0, 0.0])
    at = np.full((8, 2, 2), np.nan)
    for t in range(1, 9):
        # a poor looking wrist keeps above it; once it has lifted off, by 3 a frame, it shows
        at[t - 1, 0] = t * substrate + [0.0, -9.0]
        if t > 5:
            at[t - 1, 1] = t * substrate + [0.0, -3.0 * (t - 5.5)]
    return close(
        at, [4.0, 0.0], state=np.stack([np.zeros(2), substrate, np.zeros(2)]),
        covariance=np.diag([0.04, 0.01, 1e-4]), place=place, covered=True,
        lifting=np.where(np.isin(np.arange(1, 9), dear), 30.0, 0.0),
        substrate_velocity=substrate, liftoff_velocity=[0.0, -3.0], options={"jerk": 0.05},
    )  # fmt: skip


def test_a_paw_stands_under_its_wrist_until_it_lifts_off():
    taken, stood = standing(np.zeros(2))
    np.testing.assert_array_equal(stood, np.arange(1, 9) <= 5)
    np.testing.assert_array_equal(taken, [-1] * 5 + [1] * 3)
    assert not standing(None)[1].any()


@pytest.mark.parametrize(("dear", "last"), [((1, 2, 3), 5), ((6,), 4), ((5, 6, 7), 3)])
def test_a_paw_lifts_off_earlier_where_that_is_dear_when_it_does(dear, last):
    np.testing.assert_array_equal(standing(np.zeros(2), dear=dear)[1], np.arange(1, 9) <= last)


@pytest.mark.usefixtures("steps_of_loops")
def test_what_stands_goes_exactly_with_the_ground():
    hypotheses = Steps(
        Projection(None),
        np.ones((3, 2)),
        np.eye(3),
        place=[3.0, 2.0],
        substrate_velocity=[-1.0, 0.25],
        liftoff_velocity=[0.0, -4.0],
    )
    for t in range(1, 4):
        hypotheses.advance()
        substrate = np.array([3.0 - t, 2.0 + 0.25 * t])
        np.testing.assert_allclose(hypotheses.mean[0], [*substrate, -1.0, 0.25, 0.0, 0.0])
        # its place is less sure from frame to frame, by 0.1 of 0.4, from 0.4 of it
        np.testing.assert_allclose(hypotheses.covariance[0].diagonal()[:2], 0.16**2 + t * 0.04**2)
        if t == 1:
            # half a frame after it lifted off, on average
            np.testing.assert_allclose(hypotheses.mean[1, :2], [*substrate[:1], substrate[1] - 2.0])
            np.testing.assert_allclose(hypotheses.mean[1, 2:4], [-1.0, -3.75])
        hypotheses.settle()
        assert hypotheses.now.standing[0]


@pytest.mark.usefixtures("steps_of_loops")
def test_a_paw_that_has_just_lifted_off_may_look_poor():
    price = []
    for since in range(4):
        hypotheses = Steps(Projection(None), np.zeros((3, 2)), np.eye(3), rising=2, **ONLY)
        hypotheses.now.since[0] = since
        hypotheses.see(0, np.zeros((1, 2)), np.array([3.0]), rising=np.array([1.0]))
        price.append(hypotheses.cost.min())
    np.testing.assert_allclose(np.subtract(price, price[0]), [0.0, -2.0, -2.0, 0.0], atol=1e-9)


@pytest.mark.usefixtures("steps_of_loops")
@pytest.mark.parametrize(
    ("taken", "was", "certain", "price"),
    [
        # what becoming occluded, staying so and coming out cost
        ([-1, -1, 3], False, False, 2.0),
        ([-1, -1, 3], True, False, 0.6),
        ([0, 4, -1], True, False, 1.0),
        ([0, 4, -1], False, False, 0.0),
        ([-1, 4, -1], False, False, 0.0),
        ([-1, -1, -1], False, True, 0.0),
    ],
)
def test_what_being_hidden_costs(taken, was, certain, price):
    hypotheses = Steps(Projection(LINEAR), np.zeros((3, 3)), np.eye(3))
    # the third view is of the other side
    hypotheses.target.cameras.tracked_in_view[2] = False
    hypotheses.now.taken[:, 0], hypotheses.now.occluded[0] = taken, was
    mht_kernels.add_motion_cost(
        hypotheses.now, 1, hypotheses.home, hypotheses.target, certain, False
    )
    assert hypotheses.cost[0] == pytest.approx(price)
    assert hypotheses.now.occluded[0] == (price in (2.0, 0.6))


@pytest.mark.usefixtures("steps_of_loops")
def test_a_point_is_seldom_seen_from_the_other_side():
    price = []
    for tracked_in_view in (True, False):
        hypotheses = Steps(
            Projection(None), np.zeros((3, 2)), np.eye(3), seen=0.7, seen_across=0.15
        )
        hypotheses.target.cameras.tracked_in_view[0] = tracked_in_view
        hypotheses.see(0, np.zeros((1, 2)), np.zeros(1))
        price.append(hypotheses.cost)
    (missed, taken), (missed_across, taken_across) = price
    # to be occluded from a view that tracks it is paid for at the end of the frame
    assert missed == 0.0
    assert missed_across == pytest.approx(-np.log(0.85))
    assert taken_across - taken == pytest.approx(np.log(0.7 / 0.15))


@pytest.mark.usefixtures("steps_of_loops")
def test_one_that_stands_is_another_story_than_one_that_is_where_it_would_be():
    hypotheses = Steps(Projection(None), np.zeros((3, 2)), np.eye(3))
    alone = Steps(Projection(None), np.zeros((3, 2)), np.eye(3))
    for parameters, standing in ((hypotheses, True), (alone, False)):
        for name in ("mean", "covariance"):
            rows = getattr(parameters.now, name)
            rows[:, 1] = rows[:, 0]
        parameters.now.standing[1] = standing
        parameters.now.cost[1] = 1.0
        parameters.n = mht_kernels.prune_and_merge(
            parameters.now, 2, parameters.then, parameters.parameters
        )
    assert (hypotheses.n, alone.n) == (2, 1)
