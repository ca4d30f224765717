"""The arc of a swing and how it is fitted, compiled; see :mod:`.stride.swing_trajectory`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled

_H, _H_SHAPE = 0.05, 0.02
"""Numerics: steps over which it is measured how an arc changes, by differences: frames, and
exponents."""


class SwingErrors(NamedTuple):
    """How places lie about their arc; see the same names with ``swing_`` of the stage.

    Parameters
    ----------
    shortest : float
        Frames for which a swing lasts at least.
    noise : float
        Standard deviation of a place about its arc, paw widths, forward and up.
    alike : float
        Neighbouring frames that err alike.
    tail : float
        Standard deviations beyond which places count less and less.
    """

    shortest: float
    noise: float
    alike: float
    tail: float


@compiled
def forward(s: float, slope: float) -> float:
    """Return the share of the way after a share ``s`` of a swing that ends with a speed.

    The polynomial of fifth degree whose jerk is least (Flash & Hogan 1985), which rests at both
    ends, and what changes its speed at the end alone.
    """
    cube = s * s * s
    return cube * (10.0 - 15.0 * s + 6.0 * s * s) + slope * _steeper(s)


@compiled
def _steeper(s: float) -> float:
    """Return how the share of the way changes with the speed at landing."""
    return s * s * s * (-4.0 + 7.0 * s - 3.0 * s * s)


@compiled
def peak(shape: np.ndarray) -> float:
    """Return the logarithm of the largest value of ``s**a (1 - s)**b``."""
    a, b = shape[0], shape[1]
    return a * np.log(a) + b * np.log(b) - (a + b) * np.log(a + b)


@compiled
def upward(s: float, shape: np.ndarray, top: float) -> float:
    """Return the height after a share ``s`` of a swing, in the largest, whose :func:`peak` is."""
    s = min(max(s, 1e-9), 1.0 - 1e-9)
    return np.exp(shape[0] * np.log(s) + shape[1] * np.log1p(-s) - top)


@compiled
def _share(lift: float, land: float, frame: float, shortest: float) -> float:
    """Return which share of a swing is over in a frame."""
    return min(max((frame - lift) / max(land - lift, shortest), 0.0), 1.0)


@compiled
def trajectory(
    values: np.ndarray, shape: np.ndarray, frames: np.ndarray, shortest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far forward and up (S, T) swings are in some frames.

    Parameters
    ----------
    values : ndarray, shape (S, 4)
        Lift-off and landing, frames; height, paw widths; speed at landing.
    shape : ndarray, shape (2,)
        The exponents.
    frames : ndarray, shape (S, T)
        The frames.
    shortest : float
        Frames for which a swing lasts at least.
    """
    way, up, top = np.empty(frames.shape), np.empty(frames.shape), peak(shape)
    for i in range(len(frames)):
        lift, land, height, slope = values[i, 0], values[i, 1], values[i, 2], values[i, 3]
        for t in range(frames.shape[1]):
            s = _share(lift, land, frames[i, t], shortest)
            way[i, t], up[i, t] = forward(s, slope), height * upward(s, shape, top)
    return way, up


@compiled
def _changes(
    values: np.ndarray, shapes: np.ndarray, tops: np.ndarray, frame: float, shortest: float,
    by: np.ndarray,
) -> tuple[float, float]:  # fmt: skip
    """Return where a swing is, forward and up, and in ``by`` (k, 2) how that changes.

    With the four values (4,), and where there is room with the two exponents. ``shapes`` (3, 2)
    are these, and a little more of the one and the other, and ``tops`` their peaks.
    """
    lift, land, height, slope = values[0], values[1], values[2], values[3]
    s = _share(lift, land, frame, shortest)
    way, high = forward(s, slope), upward(s, shapes[0], tops[0])
    for k in range(2):
        later_lift, later_land = lift + (_H if k == 0 else 0.0), land + (_H if k == 1 else 0.0)
        late = _share(later_lift, later_land, frame, shortest)
        by[k, 0] = (forward(late, slope) - way) / _H
        by[k, 1] = height * (upward(late, shapes[0], tops[0]) - high) / _H
    by[2, 0], by[2, 1], by[3, 0], by[3, 1] = 0.0, high, _steeper(s), 0.0
    for k in range(len(by) - 4):
        by[4 + k, 0] = 0.0
        by[4 + k, 1] = height * (upward(s, shapes[1 + k], tops[1 + k]) - high) / _H_SHAPE
    return way, height * high


@compiled
def _beside(shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return exponents, those a little larger, one after the other, and the peaks of all."""
    shapes, tops = np.empty((3, 2)), np.empty(3)
    for k in range(3):
        for i in range(2):
            shapes[k, i] = shape[i] + (_H_SHAPE if k == i + 1 else 0.0)
        tops[k] = peak(shapes[k])
    return shapes, tops


@compiled
def changes(
    values: np.ndarray, shape: np.ndarray, frames: np.ndarray, shortest: float
) -> np.ndarray:
    """Return how swings (:func:`trajectory`) change with values and shape, (6, 2, S, T)."""
    found, by = np.empty((6, 2, *frames.shape)), np.empty((6, 2))
    shapes, tops = _beside(shape)
    for i in range(len(frames)):
        for t in range(frames.shape[1]):
            _changes(values[i], shapes, tops, frames[i, t], shortest, by)
            for k in range(6):  # as a slice it takes seconds more to compile
                found[k, 0, i, t], found[k, 1, i, t] = by[k, 0], by[k, 1]
    return found


@compiled
def equations(
    values: np.ndarray,
    shape: np.ndarray,
    frames: np.ndarray,
    seen: np.ndarray,
    step: np.ndarray,
    weight: np.ndarray,
    errors: SwingErrors,
    unknowns: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the normal equations of swings that are seen in part.

    Parameters
    ----------
    values, shape, frames : ndarray
        See :func:`trajectory`.
    seen : ndarray, shape (2, S, T)
        Share of the way and height, paw widths, that are seen.
    step : ndarray, shape (S,)
        Length of the way, paw widths.
    weight : ndarray, shape (S, T)
        How much each frame counts.
    errors : SwingErrors
        How places lie about their arc.
    unknowns : int
        4, the values of each swing, or 6, the exponents too.

    Returns
    -------
    normal, target : ndarray, shape (S, k, k) and (S, k)
        Places far from their arc count less.
    """
    normal = np.zeros((len(frames), unknowns, unknowns))
    target, by = np.zeros((len(frames), unknowns)), np.empty((unknowns, 2))
    shapes, tops = _beside(shape)
    for i in range(len(frames)):
        for t in range(frames.shape[1]):
            if weight[i, t] == 0.0:
                continue
            here = _changes(values[i], shapes, tops, frames[i, t], errors.shortest, by)
            for axis in range(2):
                unit = step[i] if axis == 0 else 1.0
                off = unit * (here[axis] - seen[axis, i, t])
                share = unit * weight[i, t] / (errors.noise**2 * errors.alike)
                share /= 1.0 + (off / (errors.tail * errors.noise)) ** 2
                for k in range(unknowns):
                    target[i, k] += share * by[k, axis] * off
                    for m in range(unknowns):
                        normal[i, k, m] += share * unit * by[k, axis] * by[m, axis]
    return normal, target
