"""What the frames before and after a frame tell of it: passes through smoothed tracks.

A track is smoothed from all frames at once (:mod:`.smoothing.smoother`). Told from
the frames before it alone, and from those after it alone, a position is predicted twice, from
measurements that have nothing in common: a Kalman filter forwards and one backwards. Where a
track goes over to another paw, or a wrong stance is taken for the point's, what came before
foretells another place than what comes after, in units of how well each foretells it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.smoothing import forward_backward_kernels as loops
from pawnb.core.paws.offline.smoothing.parameters import SMOOTHING

_OF_JERK = 20.0
"""Mathematics: a third difference (1, -3, 3, -1) weighs a place by the sum of its squares, 20."""


@dataclass(frozen=True)
class NormalEquations:
    """What tracks were smoothed from: n frames, P points, d coordinates.

    Parameters
    ----------
    information : ndarray, shape (n, P, d, d)
        Information of each measurement; 0 where there is none.
    target : ndarray, shape (n, P, d)
        That times the measurement.
    jerk2, jerk_mean : ndarray, shape (n, P, d)
        Variance of the change of acceleration along each axis, and its mean in coordinates.
    axes : ndarray, shape (d, d), optional
        The axes; without them those of the coordinates.
    covariance : ndarray, shape (n, P, d, d)
        Covariance of the smoothed positions.
    """

    information: FloatArray
    target: FloatArray
    jerk2: FloatArray
    jerk_mean: FloatArray
    axes: FloatArray | None
    covariance: FloatArray


def forward_backward_distance(equations: NormalEquations) -> FloatArray:
    """Tell every frame from the frames before it, and from those after it, and compare.

    Parameters
    ----------
    equations : NormalEquations
        What the tracks were smoothed from.

    Returns
    -------
    ndarray, shape (n, P)
        How far both are apart, in standard deviations of that distance: the root mean square
        over the axes, of which 1 is usual where measurements are as good as they are taken to
        be. NaN where fewer than three frames before or after tell anything.
    """
    n, n_points, d = equations.target.shape
    axes = np.eye(d) if equations.axes is None else equations.axes
    W = axes @ equations.information @ axes.T
    z, jerk_mean = equations.target @ axes.T, equations.jerk_mean @ axes.T
    informative = np.trace(W, axis1=-2, axis2=-1) > 0.0
    largest = W.max(initial=0.0) + _OF_JERK / equations.jerk2.min(initial=np.inf)
    W = W + SMOOTHING.forward_backward_distance_trace * largest * np.eye(d)
    forth = loops.predict(W, z, equations.jerk2, jerk_mean)
    # backwards, the change of acceleration at frame t is that at frame n - 2 - t, the other way
    turn = np.clip(n - 2 - np.arange(n), 0, None)
    back = loops.predict(W[::-1].copy(), z[::-1].copy(), equations.jerk2[turn], -jerk_mean[turn])
    count = np.cumsum(informative, axis=0)
    both = (count - informative >= SMOOTHING.informative_frames) & (
        count[-1:] - count >= SMOOTHING.informative_frames
    )
    one, two = (np.linalg.inv(known[both]) for known in (forth[0], back[0][::-1]))
    away = _times(one, forth[1][both]) - _times(two, back[1][::-1][both])
    apart = np.full((n, n_points), np.nan)
    apart[both] = np.sqrt((away * _times(np.linalg.inv(one + two), away)).sum(axis=-1) / d)
    return apart


def leave_one_out(x: AnyArray, equations: NormalEquations) -> tuple[AnyArray, AnyArray]:
    """Tell every frame from all others: smoothed tracks without what the frame itself measured.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Smoothed positions.
    equations : NormalEquations
        What they were smoothed from.

    Returns
    -------
    x, covariance : ndarray, shape (n, P, d) and (n, P, d, d)
        Positions and their covariance.
    """
    covariance = equations.covariance
    rest = np.eye(x.shape[-1]) - covariance @ equations.information
    aim = x - _times(covariance, equations.target)
    return np.linalg.solve(rest, aim[..., None])[..., 0], np.linalg.solve(rest, covariance)


def _times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the products of matrices (..., d, d) and vectors (..., d)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])
