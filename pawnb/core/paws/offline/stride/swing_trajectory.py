"""The arc on which paws swing, and how it is fitted to swings that are seen in part.

Forward a paw goes with least jerk from where it stood to where it lands (Flash and Hogan 1985,
J. Neurosci. 5: 1688-1703), from rest on the ground to a speed with which it meets it. Upwards
it goes as ``s**a (1 - s)**b`` with the share ``s`` of the swing. Paws of a kind share a and b;
when a swing begins and ends, its height and its last speed are its own. The beginning of a
front paw's swing is mostly occluded by the hind paw that lands there: what is seen later, and how
other swings went, tell it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.stride import trajectory_kernels as loops
from pawnb.core.paws.offline.stride.parameters import STRIDE


@dataclass(frozen=True)
class Part:
    """What is seen of S swings, in T frames about each.

    Parameters
    ----------
    frames : ndarray, shape (S, T)
        The frames.
    way : ndarray, shape (S, T)
        Share of the way forward.
    up : ndarray, shape (S, T)
        Height above the line from begin to end, paw widths.
    weight : ndarray, shape (S, T)
        How much each frame counts, 0 where nothing is seen.
    step : ndarray, shape (S,)
        Length of the way, paw widths.
    """

    frames: np.ndarray
    way: FloatArray
    up: FloatArray
    weight: FloatArray
    step: FloatArray


@dataclass(frozen=True)
class Guess:
    """What is known of S swings before they are fitted.

    Parameters
    ----------
    times, sd : ndarray, shape (S, 2)
        Frames of lift-off and landing, and their standard deviations.
    """

    times: FloatArray
    sd: FloatArray


@dataclass(frozen=True)
class SwingTrajectory:
    """The arc of a kind of paw.

    Parameters
    ----------
    shape, covariance : ndarray, shape (2,) and (2, 2)
        The exponents a and b.
    height : float
        Median height of its swings, paw widths.
    """

    shape: FloatArray
    covariance: FloatArray
    height: float


def trajectory_at(
    values: FloatArray, shape: FloatArray, frames: AnyArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far forward and up swings are in some frames.

    Parameters
    ----------
    values : ndarray, shape (..., 4)
        Lift-off and landing, frames; height, paw widths; speed at landing.
    shape : ndarray, shape (2,)
        The exponents.
    frames : ndarray, shape (..., T)
        The frames.

    Returns
    -------
    way, up : ndarray, shape (..., T)
        Share of the way, and paw widths.
    """
    way, up = loops.trajectory(*_flat(values, shape, frames), STRIDE.swing_shortest)
    return way.reshape(frames.shape), up.reshape(frames.shape)


def changes(
    values: FloatArray, shape: FloatArray, frames: AnyArray
) -> tuple[FloatArray, FloatArray]:
    """Return how the arc changes with the values, (4, 2, ..., T), and the shape, (2, 2, ..., T).

    Parameters
    ----------
    values : ndarray, shape (4, ...)
        What each swing has of its own.
    shape : ndarray, shape (2,)
        Exponents, shared by all.
    frames : ndarray, shape (..., T)
        Frames of each swing.

    Returns
    -------
    by_values : ndarray, shape (4, 2, ..., T)
        Derivatives by the values.
    by_shape : ndarray, shape (2, 2, ..., T)
        Derivatives by the exponents.
    """
    found = loops.changes(*_flat(values, shape, frames), STRIDE.swing_shortest).reshape(
        6, 2, *frames.shape
    )
    return found[:4], found[4:]


def _flat(
    values: FloatArray, shape: FloatArray, frames: np.ndarray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return values (S, 4), the shape and frames (S, T) of swings, whatever their arrangement."""
    return values.reshape(-1, 4), shape, np.asarray(frames, float).reshape(-1, frames.shape[-1])


def learn_trajectory(part: Part, guess: Guess) -> SwingTrajectory:
    """Learn the arc from swings of one kind.

    Parameters
    ----------
    part : Part
        What is seen of them.
    guess : Guess
        What is known of them.

    Returns
    -------
    SwingTrajectory
        The arc.
    """
    highest = np.where(part.weight > STRIDE.swing_seen, part.up, 0.0).max(axis=1, initial=0.0)
    told = highest[highest > STRIDE.least_high]
    height, shape = float(np.median(told)) if len(told) else 1.0, _shape()
    values, shape_sd = _first(guess, height), np.array(STRIDE.swing_shape_sd)
    for _ in range(STRIDE.swing_trajectory_rounds):
        values, _, (normal, target) = _fit(values, part, guess, shape, height)
        normal = normal + np.diag(1.0 / shape_sd**2)
        step = np.linalg.solve(normal, target + (shape - _shape()) / shape_sd**2)
        step = np.clip(step, -STRIDE.most_shape, STRIDE.most_shape)
        shape = np.clip(shape - step, STRIDE.least_shape, STRIDE.largest_shape)
        height = float(np.median(values[:, 2]))
    return SwingTrajectory(shape, np.linalg.inv(normal), height)


def fit_swings(
    trajectory: SwingTrajectory, part: Part, guess: Guess
) -> tuple[FloatArray, FloatArray]:
    """Fit swings to an arc.

    Parameters
    ----------
    trajectory : SwingTrajectory
        The arc.
    part : Part
        What is seen of S swings.
    guess : Guess
        What is known of them.

    Returns
    -------
    values : ndarray, shape (S, 4)
        See :func:`trajectory_at`.
    covariance : ndarray, shape (S, 4, 4)
        Theirs.
    """
    values = _first(guess, trajectory.height)
    for _ in range(STRIDE.swing_trajectory_fits):
        values, covariance, _ = _fit(values, part, guess, trajectory.shape, trajectory.height)
    return values, covariance


def _shape() -> FloatArray:
    """Return the exponents (2,) before any swing is seen."""
    return np.array(STRIDE.swing_shape)


def _first(guess: Guess, height: float) -> FloatArray:
    """Return values (S, 4) before anything is fitted."""
    return np.column_stack(
        [guess.times, np.tile([height, STRIDE.landing_speed], (len(guess.times), 1))]
    )


def _fit(
    values: FloatArray, part: Part, guess: Guess, shape: FloatArray, height: float
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Return values (S, 4) after some steps, their covariances, and the shape's equations.

    Gauss-Newton; places far from their arc count less and less.
    """
    expected = _first(guess, height)
    height_sd = STRIDE.swing_height_sd * height
    own_sd = np.tile([height_sd, STRIDE.landing_speed_sd], (len(values), 1))
    sd = np.column_stack([guess.sd, own_sd])
    most = np.array([STRIDE.most_frames, STRIDE.most_frames, 2.0 * height_sd, STRIDE.most_slope])
    errors = loops.SwingErrors(
        STRIDE.swing_shortest, STRIDE.swing_noise, STRIDE.swing_alike, STRIDE.swing_tail
    )
    frames, seen = part.frames.astype(float), np.stack([part.way, part.up])
    for step in range(STRIDE.swing_trajectory_steps + 1):
        normal, target = loops.equations(
            values,
            shape,
            frames,
            seen,
            part.step,
            part.weight,
            errors,
            6 if step == STRIDE.swing_trajectory_steps else 4,
        )
        normal[:, :4, :4] += (1.0 / sd**2)[:, :, None] * np.eye(4)
        if step == STRIDE.swing_trajectory_steps:
            break
        target += (values - expected) / sd**2
        change = np.linalg.solve(normal, target[..., None])[..., 0]
        values = values - np.clip(change, -most, most)
        values[:, 1] = np.maximum(values[:, 1], values[:, 0] + STRIDE.swing_shortest)
        values[:, 2] = np.clip(
            values[:, 2],
            STRIDE.swing_trajectory_lowest * height,
            STRIDE.swing_trajectory_highest * height,
        )
    covariance = np.linalg.inv(normal[:, :4, :4])
    cross = normal[:, 4:, :4]
    # what the values of the swings could do as well says nothing of the shape
    shared = np.einsum("sij,sjk,slk->il", cross, covariance, cross)
    return values, covariance, (normal[:, 4:, 4:].sum(axis=0) - shared, target[:, 4:].sum(axis=0))
