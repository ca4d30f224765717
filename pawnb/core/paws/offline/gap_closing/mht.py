"""What a point did where no piece of path is certain: several stories told side by side.

Between two certain pieces a point may be hidden, half hidden, or seen by one view only, and
what looks like it may belong to another. Each story (hypothesis) carries a Kalman state;
in every frame and view it may take in a candidate or none, and it may be kicked: a paw that
lifts off changes its speed at once. Only the likeliest stories are kept, and the piece that
follows decides between them: multiple hypothesis tracking (Reid 1979, IEEE Trans. Automat.
Contr. 24: 843-854) with the end known.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import Moves
from pawnb.core.paws.offline.gap_closing.mht_parameters import Telling

_GAIN = np.array([[1 / 6], [0.5], [1.0]])
_JUMP = np.array([[1 / 3, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])
"""Covariance of a change of speed at any moment of the frame."""


def moves_of(
    telling: Telling,
    drift: np.ndarray,
    *,
    lift: np.ndarray | None = None,
    across: np.ndarray | None = None,
) -> Moves:
    """Return how stories go on from frame to frame.

    Parameters
    ----------
    telling : Telling
        How they are told.
    drift : ndarray, shape (d,)
        Speed of the ground.
    lift : ndarray, shape (d,), optional
        How much the speed of a point changes at lift-off; default not at all.
    across : ndarray, shape (d,), optional
        Unit vector to the side.
    """
    along = np.eye(len(drift))
    if across is not None:
        along -= (1.0 - telling.sideways**2) * np.outer(across, across)
    plain = telling.jerk**2 * np.kron(_GAIN @ _GAIN.T, along)
    kick = telling.kick**2 * np.kron(_JUMP, along)
    lower, lift = np.tril_indices(len(plain)), np.zeros_like(drift) if lift is None else lift
    return Moves(
        # how a paw lifts off is known better than how it is kicked
        plain[lower], (4.0 * plain + kick)[lower], (4.0 * plain + telling.lifting**2 * kick)[lower],
        drift, lift, (telling.hold * telling.noise) ** 2, (telling.slip * telling.noise) ** 2,
    )  # fmt: skip


def state_after(
    places: np.ndarray, drift: np.ndarray, *, telling: Telling, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return state (3, d) and covariance (3, 3) at the last of consecutive certain places.

    Parameters
    ----------
    places : ndarray, shape (n, d)
        The places.
    drift : ndarray, shape (d,)
        Speed before anything is known of it.
    telling : Telling
        How points move.
    speed : float
        Standard deviation of an unknown speed.
    """
    mean = np.stack([places[0], drift, np.zeros(places.shape[1])])
    P = np.diag([telling.noise**2, speed**2, (3.0 * telling.jerk) ** 2])
    _follow(mean, P, places, telling.jerk**2 * _GAIN @ _GAIN.T, telling.noise**2)
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
            P[i, 1], P[i, 2] = half[i, 1] + half[i, 2] + noise[i, 1], half[i, 2] + noise[i, 2]
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
