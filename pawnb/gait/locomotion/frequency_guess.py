"""How often the feet of an animal step, guessed before anything else is known of it."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.kinematics import body_frame_from_points, mean_path, stride_frequency
from pawnb.signals import dominant_frequency

_SHARED_SLOWER = 2.5
"""What feet share is travel, no steps, where they move against each other this many times as often:
more than twice, for the feet of two pairs may part twice in a stride."""

_STEPS_APART = 0.7
"""Speed of feet against each other, as a share of the speed that they share, from which it is
steps: 1 to 4 where feet step in turn; in a bound, or hopping, they part by less than half."""

_STEPS_SAMPLED = 10.0
"""Samples in a step that no jitter of labels has: that is fastest in neighbouring samples."""

_TURNS_BACK = -0.25
"""Correlation of a foot's movement with that of the sample before, below which it is jitter, where
a step has fewer samples: -0.5 in white jitter. Measured: a mouse in an open field 0.07 at
60 and 30 frames a second, 0.02 at 20; a fly on a ball 0.1 at 50, a rat on a belt 0.8 at 31."""


def guess_frequency(feet: FootPaths, *, body: FloatArray | None, fs_hz: float) -> float:
    """Guess how often the feet step, in the body's frame where there is one.

    An animal that goes, stops and turns on the ground does so more slowly than it steps, and its
    feet share all of that: what they do against each other tells the steps from it. Of feet that
    step together only labels' jitter is left.

    Parameters
    ----------
    feet : FootPaths
        The feet of one space.
    body : ndarray, shape (n, d, m), or None
        Points along the body, rear to front, where there are any.
    fs_hz : float
        Samples per second.

    Returns
    -------
    float
        Stride frequency in Hz; NaN where nothing can be told.
    """
    if body is None:
        whole = stride_frequency(feet.positions, fs_hz=fs_hz)
        if len(feet.legs) < 2:
            return whole
        path = mean_path(feet.positions)
        apart = feet.positions - path[:, :, None]
        own = stride_frequency(apart, fs_hz=fs_hz)
        in_turn = _speed(apart) > _STEPS_APART * _speed(path[:, :, None])
        if not (in_turn and own > _SHARED_SLOWER * whole):
            return whole
        return own if own < fs_hz / _STEPS_SAMPLED or _goes_on(apart) > _TURNS_BACK else whole
    frame = body_frame_from_points(body, cutoff_hz=None, fs_hz=fs_hz)
    return dominant_frequency(frame.fore_aft(feet.positions), fs_hz=fs_hz)


def _goes_on(positions: FloatArray) -> float:
    """Return how movements (n, d, k) from sample to sample correlate with those before."""
    step = np.diff(positions, axis=0)
    step = step - np.nanmean(step, axis=0)
    return float(np.nanmean(step[1:] * step[:-1]) / np.nanmean(step**2))


def _speed(positions: FloatArray) -> float:
    """Return the root mean square of velocities (n, d, k) about their means, per sample."""
    step = np.diff(positions, axis=0)
    return float(np.sqrt(np.nanmean((step - np.nanmean(step, axis=0)) ** 2)))
