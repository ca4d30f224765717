"""What a point did where no tracklet is certain: several hypotheses followed side by side.

Between two certain tracklets a point may be occluded, half occluded, or seen by one view only, and
what looks like it may belong to another. Each hypothesis carries a Kalman state;
in every frame and view it may take in a detection or none, and it may get an impulse: a paw that
lifts off changes its speed at once. Only the likeliest hypotheses are kept, and the tracklet that
follows decides between them: multiple hypothesis tracking (Reid 1979, IEEE Trans. Automat.
Contr. 24: 843-854) with the end known.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import ProcessNoise
from pawnb.core.paws.offline.gap_closing.mht_parameters import MHTParameters

_GAIN = np.array([[1 / 6], [0.5], [1.0]])
"""Mathematics: how a change of acceleration in one frame changes place, speed and acceleration."""
_JUMP = np.array([[1 / 3, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])
"""Mathematics: covariance of a change of speed at any moment of the frame."""


def process_noise_of(
    parameters: MHTParameters,
    substrate_velocity: FloatArray,
    *,
    liftoff_velocity: FloatArray | None = None,
    across: FloatArray | None = None,
) -> ProcessNoise:
    """Return how hypotheses go on from frame to frame.

    Parameters
    ----------
    parameters : MHTParameters
        The parameters.
    substrate_velocity : ndarray, shape (d,)
        Speed of the ground.
    liftoff_velocity : ndarray, shape (d,), optional
        How much the speed of a point changes at lift-off; default not at all.
    across : ndarray, shape (d,), optional
        Unit vector to the side.

    Returns
    -------
    ProcessNoise
        What is added in each frame.
    """
    along = np.eye(len(substrate_velocity))
    if across is not None:
        along -= (1.0 - parameters.sideways**2) * np.outer(across, across)
    plain = parameters.jerk**2 * np.kron(_GAIN @ _GAIN.T, along)
    impulse = parameters.impulse**2 * np.kron(_JUMP, along)
    lower, liftoff_velocity = (
        np.tril_indices(len(plain)),
        np.zeros_like(substrate_velocity) if liftoff_velocity is None else liftoff_velocity,
    )
    return ProcessNoise(
        # how a paw lifts off is known better than how it manoeuvres
        plain[lower],
        (plain + impulse)[lower],
        (plain + parameters.lifting**2 * impulse)[lower],
        substrate_velocity,
        liftoff_velocity,
        (parameters.hold * parameters.noise) ** 2,
        (parameters.slip * parameters.noise) ** 2,
    )


def state_after(
    places: FloatArray, substrate_velocity: FloatArray, *, parameters: MHTParameters, speed: float
) -> tuple[FloatArray, FloatArray]:
    """Return state (3, d) and covariance (3, 3) at the last of consecutive certain places.

    Parameters
    ----------
    places : ndarray, shape (n, d)
        The places.
    substrate_velocity : ndarray, shape (d,)
        Speed before anything is known of it.
    parameters : MHTParameters
        How points move.
    speed : float
        Standard deviation of an unknown speed.

    Returns
    -------
    mean : ndarray, shape (3, d)
        Place, speed and acceleration, a frame.
    covariance : ndarray, shape (3, 3)
        Alike in every direction.
    """
    mean = np.stack([places[0], substrate_velocity, np.zeros(places.shape[1])])
    P = np.diag([parameters.noise**2, speed**2, parameters.jerk**2])
    _follow(mean, P, places, parameters.jerk**2 * _GAIN @ _GAIN.T, parameters.noise**2)
    return mean, P


@compiled
def _follow(
    mean: np.ndarray, P: np.ndarray, places: np.ndarray, noise: np.ndarray, variance: float
) -> None:
    """Let a state (3, d) and its covariance (3, 3) follow all places but the first."""
    half, gain = np.empty((3, 3)), np.empty(3)
    for t in range(1, len(places)):
        for i in range(3):
            half[0, i] = P[0, i] + P[1, i] + 0.5 * P[2, i]
            half[1, i], half[2, i] = P[1, i] + P[2, i], P[2, i]
        for i in range(3):
            P[i, 0] = half[i, 0] + half[i, 1] + 0.5 * half[i, 2] + noise[i, 0]
            P[i, 1], P[i, 2] = (
                half[i, 1] + half[i, 2] + noise[i, 1],
                half[i, 2] + noise[i, 2],
            )
        for i in range(3):
            gain[i], half[0, i] = P[i, 0] / (P[0, 0] + variance), P[0, i]
        for c in range(mean.shape[1]):
            mean[0, c] += mean[1, c] + 0.5 * mean[2, c]
            mean[1, c] += mean[2, c]
            away = places[t, c] - mean[0, c]
            for i in range(3):
                mean[i, c] += gain[i] * away
        for i in range(3):
            for j in range(3):
                P[i, j] -= gain[i] * half[0, j]
