"""The heading of an animal that turns, from how its feet stand where no point of its body is known.

Feet swing about places that turn with the body. Those places are found together with the turn
(generalised Procrustes analysis: Gower 1975, Psychometrika 40, 33-51), without knowing which leg is
which. Where its front is, is where it goes on the whole: an animal that walks backwards for some
steps keeps its front, and one that goes sideways has it on its side.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.kinematics import smooth_path
from pawnb.signals import fill_gaps_of_points

_ALIGNMENTS = 20
_LIKE_PLACES = 0.5
"""Share of the feet's distances from their middle that their places explain, at least (by hand).
Made walks along circles have 0.92 with six legs, 0.75 to 0.95 with four at a trot, 0.59 and more at
a gallop whose swings are longer than the body, 0.90 with two; a real mouse in a field has 0.82."""

_GOING = 0.35
"""It goes where it is faster than this share of its fast speed, as at the start of a bout."""

_ONE_WAY = 0.7
"""Share of the way that an animal goes to one side of its body, at least (by hand): 0.89 and more
in the same walks, 0.88 in a real mouse in an open field, 0 there and back without a turn."""


def heading_of_feet(
    positions: FloatArray,
    path: FloatArray,
    *,
    up: FloatArray | None,
    cutoff_hz: float,
    fs_hz: float,
) -> FloatArray | None:
    """Find where an animal on the ground faces, from how its feet stand to each other.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions of the feet; NaN where missing.
    path : ndarray, shape (n, d)
        Low-passed path of the body.
    up : ndarray, shape (3,), or None
        Direction upwards, in space; None in a picture.
    cutoff_hz : float
        Low-pass of the turn: what is faster is steps.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    ndarray, shape (n, d), or None
        Unit vectors towards the front; None where fewer than two feet are known (together in
        half of the samples), where they do not stand in an order of their own, or where the animal
        goes to no side of its body on the whole.
    """
    across, ahead = _plane(positions.shape[1], up)
    filled = np.moveaxis(fill_gaps_of_points(positions, max_gap=len(positions)), 1, -1)
    feet = _as_complex(filled, across, ahead)
    feet = feet[:, np.isfinite(feet).any(axis=0)]
    known = np.isfinite(feet).all(axis=1)
    if feet.shape[1] < 2 or known.sum() < len(feet) / 2:
        return None
    feet = feet[known]
    feet = feet - feet.mean(axis=1, keepdims=True)
    places, turn = feet[0], np.ones(len(feet), dtype=complex)
    for _ in range(_ALIGNMENTS):
        turn = feet @ np.conj(places)
        turn = turn / np.maximum(np.abs(turn), np.finfo(float).tiny)
        places = (feet * np.conj(turn)[:, None]).mean(axis=0)
    if np.sum(np.abs(places) ** 2) < _LIKE_PLACES * np.mean(np.sum(np.abs(feet) ** 2, axis=1)):
        return None
    rows = np.arange(len(known))
    bridged = [np.interp(rows, rows[known], part) for part in (turn.real, turn.imag)]
    parts = np.stack(bridged, axis=-1)
    turn = smooth_path(parts[:, :, None], cutoff_hz=cutoff_hz, fs_hz=fs_hz) @ np.array([1.0, 1.0j])
    turn = turn / np.abs(turn)
    gone = np.gradient(_as_complex(path, across, ahead)) * np.conj(turn)
    gone = gone[np.isfinite(gone)]
    gone = gone[np.abs(gone) >= _GOING * np.percentile(np.abs(gone), 95)]
    front = gone.sum()
    if not np.abs(front) > _ONE_WAY * np.abs(gone).sum():
        return None
    heading = turn * front / np.abs(front)
    return np.outer(heading.real, across) + np.outer(heading.imag, ahead)


def _plane(n_dims: int, up: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors at right angles, level where it is known which way is up."""
    if up is None:
        return np.eye(n_dims)[0], np.eye(n_dims)[1]
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = first - (first @ up) * up
    first = first / np.linalg.norm(first)
    return first, np.cross(up, first)


def _as_complex(points: FloatArray, first: FloatArray, second: FloatArray) -> np.ndarray:
    """Return points (..., d) as complex numbers in the plane of two directions."""
    return np.asarray(points @ first + 1j * (points @ second))
