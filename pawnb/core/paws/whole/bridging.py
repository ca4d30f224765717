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

from pawnb.core.paws.whole.stories_loops import Moves
from pawnb.core.paws.whole.telling import Telling

_STEP = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
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
    noise = telling.jerk**2 * _GAIN @ _GAIN.T
    mean = np.stack([places[0], drift, np.zeros(places.shape[1])])
    P = np.diag([telling.noise**2, speed**2, (3.0 * telling.jerk) ** 2])
    for place in places[1:]:
        mean, P = _STEP @ mean, _STEP @ P @ _STEP.T + noise
        gain = P[:, 0] / (P[0, 0] + telling.noise**2)
        mean = mean + gain[:, None] * (place - mean[0])
        P = P - np.outer(gain, P[0])
    return mean, P
