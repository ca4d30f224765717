"""Constant-velocity Kalman filter and smoother on arrays, batched over points.

A state holds ``d`` coordinates and their ``d`` velocities, in that order; a
measurement holds the ``d`` coordinates. One frame is the unit of time, so a
velocity is in units per frame. The matrices are those printed in Haji Maghsoudi
et al. 2019, section 2.3.2, whose text swaps the counts: there are six states and
three measurements in 3D (and four and two in 2D).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray
from pawnb.errors import InputError


@dataclass(frozen=True)
class ConstantVelocity:
    """The model: how a state moves on, and what is measured of it.

    Parameters
    ----------
    transition : ndarray, shape (2 d, 2 d)
        The next state is ``transition @ state``.
    observation : ndarray, shape (d, 2 d)
        What is measured is ``observation @ state``.
    process_noise : ndarray, shape (2 d, 2 d)
        Covariance of what the model leaves out in one frame.
    measurement_noise : ndarray, shape (d, d)
        Covariance of one measurement.
    initial_covariance : ndarray, shape (2 d, 2 d)
        Covariance of a state that has just been started.
    """

    transition: FloatArray
    observation: FloatArray
    process_noise: FloatArray
    measurement_noise: FloatArray
    initial_covariance: FloatArray

    @property
    def n_coordinates(self) -> int:
        """Number of coordinates, d."""
        return self.observation.shape[0]


@dataclass(frozen=True)
class State:
    """Mean and covariance of one or many states; NaN where a point has no state.

    Parameters
    ----------
    mean : ndarray, shape (..., 2 d)
        Coordinates, then velocities per frame.
    covariance : ndarray, shape (..., 2 d, 2 d)
        Covariance of the mean.
    """

    mean: FloatArray
    covariance: FloatArray

    @property
    def position(self) -> FloatArray:
        """The coordinates, shape (..., d)."""
        return self.mean[..., : self.mean.shape[-1] // 2]

    @property
    def velocity(self) -> FloatArray:
        """The velocities per frame, shape (..., d)."""
        return self.mean[..., self.mean.shape[-1] // 2 :]


def make_model(
    n_coordinates: int,
    *,
    process_var: float = 1.0,
    measurement_var: float = 1.0,
    initial_var: float = 0.0,
) -> ConstantVelocity:
    """Make the model of a point that keeps its velocity.

    Parameters
    ----------
    n_coordinates : int
        2 in a picture, 3 in calibrated space.
    process_var : float
        Variance added to each coordinate and each velocity in one frame.
    measurement_var : float
        Variance of each measured coordinate.
    initial_var : float
        Variance of a state that has just been started.

    Returns
    -------
    ConstantVelocity
        The model. The defaults (1, 1, 0) are those of OpenCV's ``cv2.KalmanFilter``,
        which the paper uses; with an initial variance of 0 only the ratio of the two
        others matters, so the unit of length does not.

    Raises
    ------
    InputError
        If a variance is negative or not finite, or the measurement's is not above 0.
    """
    variances = {
        "process_var": process_var,
        "measurement_var": measurement_var,
        "initial_var": initial_var,
    }
    for name, value in variances.items():
        if not np.isfinite(value) or value < 0 or (name == "measurement_var" and value == 0):
            least = "above 0" if name == "measurement_var" else "0 or more"
            raise InputError(f"{name} is {value}; expected a number, {least}.")
    one, zero = np.eye(n_coordinates), np.zeros((n_coordinates, n_coordinates))
    return ConstantVelocity(
        transition=np.block([[one, one], [zero, one]]),
        observation=np.hstack([one, zero]),
        process_noise=process_var * np.eye(2 * n_coordinates),
        measurement_noise=measurement_var * one,
        initial_covariance=initial_var * np.eye(2 * n_coordinates),
    )


def start(
    model: ConstantVelocity, position: FloatArray, velocity: FloatArray | None = None
) -> State:
    """Start states at known positions.

    Parameters
    ----------
    model : ConstantVelocity
        The model.
    position : ndarray, shape (..., d)
        Where the points are; NaN where a point has no state yet.
    velocity : ndarray, shape (..., d), optional
        Their velocities per frame; default 0.

    Returns
    -------
    State
        States with the model's initial covariance.
    """
    position = np.asarray(position, dtype=float)
    velocity = np.zeros_like(position) if velocity is None else np.asarray(velocity, dtype=float)
    mean = np.concatenate([position, velocity], axis=-1)
    covariance = np.broadcast_to(model.initial_covariance, (*mean.shape, mean.shape[-1])).copy()
    return State(mean, covariance)


def predict(model: ConstantVelocity, state: State) -> State:
    """Return the states one frame on, before anything is measured there.

    Parameters
    ----------
    model : ConstantVelocity
        The model.
    state : State
        States of any batch shape.

    Returns
    -------
    State
        Predicted states.
    """
    F = model.transition
    return State(state.mean @ F.T, F @ state.covariance @ F.T + model.process_noise)


def update(model: ConstantVelocity, state: State, measured: AnyArray) -> State:
    """Return the states after a measurement; a missing measurement changes nothing.

    Parameters
    ----------
    model : ConstantVelocity
        The model.
    state : State
        Predicted states.
    measured : ndarray, shape (..., d)
        Measured coordinates; a row with a NaN is a missing measurement.

    Returns
    -------
    State
        Updated states.
    """
    measured = np.asarray(measured, dtype=float)
    H = model.observation
    PHt = state.covariance @ H.T
    gain = PHt @ np.linalg.inv(H @ PHt + model.measurement_noise)
    innovation = measured - state.mean @ H.T
    mean = state.mean + (gain @ innovation[..., None])[..., 0]
    covariance = state.covariance - gain @ np.swapaxes(PHt, -1, -2)
    seen = np.asarray(np.isfinite(measured).all(axis=-1))
    return State(
        np.where(seen[..., None], mean, state.mean),
        np.where(seen[..., None, None], covariance, state.covariance),
    )


def smooth(model: ConstantVelocity, measured: FloatArray) -> State:
    """Smooth whole tracks forwards and backwards (Rauch, Tung & Striebel 1965).

    Parameters
    ----------
    model : ConstantVelocity
        The model. With an initial variance of 0 the first measurement is taken as exact.
    measured : ndarray, shape (n_frames, ..., d)
        Measured coordinates, NaN where missing; gaps are filled.

    Returns
    -------
    State
        Smoothed states, batch shape (n_frames, ...); NaN before a point's first
        measurement.
    """
    measured = np.asarray(measured, dtype=float)
    state = start(model, measured[0])
    states, ahead = [state], [state]
    for row in measured[1:]:
        predicted = predict(model, state)
        fresh = start(model, row)
        new = np.isnan(predicted.mean).any(axis=-1) & np.isfinite(row).all(axis=-1)
        state = _choose(new, fresh, update(model, predicted, row))
        states.append(state)
        ahead.append(predicted)
    F = model.transition
    for k in range(len(states) - 2, -1, -1):
        P, later = states[k].covariance, states[k + 1]
        # a pseudo-inverse: the covariance ahead is singular where there is no process noise
        gain = P @ F.T @ np.linalg.pinv(ahead[k + 1].covariance, hermitian=True)
        step = (gain @ (later.mean - ahead[k + 1].mean)[..., None])[..., 0]
        change = gain @ (later.covariance - ahead[k + 1].covariance) @ np.swapaxes(gain, -1, -2)
        states[k] = State(states[k].mean + step, P + change)
    return State(np.stack([s.mean for s in states]), np.stack([s.covariance for s in states]))


def _choose(where: BoolArray, yes: State, no: State) -> State:
    """Take the states of ``yes`` where ``where`` holds and those of ``no`` elsewhere."""
    return State(
        np.where(where[..., None], yes.mean, no.mean),
        np.where(where[..., None, None], yes.covariance, no.covariance),
    )
