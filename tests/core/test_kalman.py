"""The filter against OpenCV's, the smoother against one big least-squares problem."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core import kalman
from pawnb.errors import InputError


def opencv_filter(d: int) -> cv2.KalmanFilter:
    """OpenCV's filter with the paper's matrices and its own default covariances."""
    peer = cv2.KalmanFilter(2 * d, d, 0, cv2.CV_64F)
    peer.transitionMatrix = np.block([[np.eye(d), np.eye(d)], [np.zeros((d, d)), np.eye(d)]])
    peer.measurementMatrix = np.hstack([np.eye(d), np.zeros((d, d))])
    return peer


def run(model, measured, velocity=None):
    state = kalman.start(model, measured[0], velocity)
    states = [state]
    for row in measured[1:]:
        state = kalman.update(model, kalman.predict(model, state), row)
        states.append(state)
    return states


def test_matrices_are_those_printed_in_the_paper():
    model = kalman.make_model(3)
    # section 2.3.2
    assert model.transition.tolist() == [
        [1, 0, 0, 1, 0, 0],
        [0, 1, 0, 0, 1, 0],
        [0, 0, 1, 0, 0, 1],
        [0, 0, 0, 1, 0, 0],
        [0, 0, 0, 0, 1, 0],
        [0, 0, 0, 0, 0, 1],
    ]
    assert model.observation.tolist() == [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 1, 0, 0, 0],
    ]


def test_default_covariances_are_opencv_s():
    peer, model = cv2.KalmanFilter(6, 3, 0, cv2.CV_64F), kalman.make_model(3)
    np.testing.assert_array_equal(model.process_noise, peer.processNoiseCov)
    np.testing.assert_array_equal(model.measurement_noise, peer.measurementNoiseCov)
    np.testing.assert_array_equal(model.initial_covariance, peer.errorCovPost)


@pytest.mark.parametrize("d", [2, 3])
def test_filter_agrees_with_opencv_also_over_missing_measurements(d):
    rng = np.random.default_rng(4)
    measured = np.cumsum(rng.normal(size=(40, d)), axis=0)
    measured[[7, 20, 21, 22]] = np.nan
    peer = opencv_filter(d)
    peer.statePost = np.concatenate([measured[0], np.zeros(d)])[:, None]
    expected = [peer.statePost[:, 0].copy()]
    for row in measured[1:]:
        peer.predict()
        if np.isfinite(row).all():
            peer.correct(row[:, None])
        else:  # OpenCV's own way to skip a measurement
            peer.statePost, peer.errorCovPost = peer.statePre, peer.errorCovPre
        expected.append(peer.statePost[:, 0].copy())
    states = run(kalman.make_model(d), measured)
    means = np.array([state.mean for state in states])
    np.testing.assert_allclose(means, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[-1].covariance, peer.errorCovPost, atol=1e-9)
    # the comparison is sharp: one per cent more noise in the model is seen
    other = run(kalman.make_model(d, process_var=1.01), measured)
    assert np.abs(np.array([state.mean for state in other]) - expected).max() > 1e-4


def test_many_points_at_once_are_each_as_if_alone():
    rng = np.random.default_rng(5)
    measured = rng.normal(size=(15, 2, 3, 2))
    measured[4, 0, 1] = np.nan
    model = kalman.make_model(2)
    together = run(model, measured)[-1]
    for i in range(2):
        for j in range(3):
            alone = run(model, measured[:, i, j])[-1]
            np.testing.assert_allclose(together.mean[i, j], alone.mean, atol=1e-12)


@given(
    st.lists(st.floats(-50, 50), min_size=6, max_size=6),
    st.integers(1, 30),
)
def test_a_point_that_keeps_its_velocity_is_predicted_exactly(numbers, n):
    position, velocity = np.array(numbers[:3]), np.array(numbers[3:])
    model = kalman.make_model(3)
    state = kalman.start(model, position, velocity)
    for k in range(1, n + 1):
        state = kalman.predict(model, state)
        np.testing.assert_allclose(state.position, position + k * velocity, atol=1e-6)
        state = kalman.update(model, state, position + k * velocity)
    np.testing.assert_allclose(state.velocity, velocity, atol=1e-6)


def test_points_without_a_state_stay_without():
    model = kalman.make_model(3)
    state = kalman.start(model, np.array([[1.0, 2.0, 3.0], [np.nan] * 3]))
    state = kalman.update(model, kalman.predict(model, state), np.full((2, 3), np.nan))
    np.testing.assert_allclose(state.position[0], [1, 2, 3])
    assert np.isnan(state.mean[1]).all()


def test_smoother_solves_the_whole_least_squares_problem():
    """Smoothed states are the most probable ones: the minimum of one quadratic form."""
    rng = np.random.default_rng(6)
    measured = np.cumsum(rng.normal(size=(12, 1)), axis=0)
    measured[5:8] = np.nan
    q, r, p0 = 0.3, 0.7, 2.0
    model = kalman.make_model(1, process_var=q, measurement_var=r, initial_var=p0)
    n, F = len(measured), model.transition
    rows, values = [], []

    def add(blocks, value, sd):
        row = np.zeros((len(value), 2 * n))
        for frame, matrix in blocks:
            row[:, 2 * frame : 2 * frame + 2] = matrix
        rows.append(row / sd)
        values.append(np.asarray(value) / sd)

    add([(0, np.eye(2))], [measured[0, 0], 0.0], np.sqrt(p0))
    for k in range(1, n):
        add([(k, np.eye(2)), (k - 1, -F)], [0.0, 0.0], np.sqrt(q))
        if np.isfinite(measured[k, 0]):
            add([(k, np.array([[1.0, 0.0]]))], measured[k], np.sqrt(r))
    A, b = np.vstack(rows), np.concatenate(values)
    expected = np.linalg.lstsq(A, b, rcond=None)[0].reshape(n, 2)
    smoothed = kalman.smooth(model, measured)
    np.testing.assert_allclose(smoothed.mean, expected, atol=1e-8)
    covariance = np.linalg.inv(A.T @ A)
    np.testing.assert_allclose(smoothed.covariance[6], covariance[12:14, 12:14], atol=1e-8)
    # and the filter alone does not
    assert np.abs(run(model, measured)[6].mean - expected[6]).max() > 0.05


def test_smoother_fills_gaps_and_begins_where_a_point_begins():
    t = np.arange(20.0)
    measured = np.stack([t, 2 * t], axis=-1)[:, None, :].repeat(2, axis=1)
    measured[:3, 1] = np.nan
    measured[10:13] = np.nan
    smoothed = kalman.smooth(kalman.make_model(2, initial_var=1.0), measured)
    assert np.isnan(smoothed.mean[:3, 1]).all()
    np.testing.assert_allclose(
        smoothed.position[10:13, :, 0], np.tile(t[10:13, None], 2), atol=0.05
    )


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"process_var": -1.0}, "process_var is -1.0; expected a number, 0 or more."),
        ({"measurement_var": 0.0}, "measurement_var is 0.0; expected a number, above 0."),
        ({"initial_var": float("nan")}, "initial_var is nan; expected a number, 0 or more."),
    ],
)
def test_impossible_variances_are_refused(values, message):
    with pytest.raises(InputError) as error:
        kalman.make_model(2, **values)
    assert str(error.value) == message
