"""Position, velocity and acceleration from sampled positions."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.signals.butterworth import butterworth_lowpass
from pawnb.signals.derivatives import differentiate
from pawnb.signals.splines import smooth_spline


class SmoothedMotion(NamedTuple):
    """A smoothed signal with its first two derivatives.

    Attributes
    ----------
    position : ndarray, shape (n, ...)
        The smoothed signal.
    velocity : ndarray, shape (n, ...)
        Its derivative, per second.
    acceleration : ndarray, shape (n, ...)
        Its second derivative, per second squared.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def smooth_motion(
    x: FloatArray,
    *,
    fs_hz: float,
    cutoff_hz: float | None,
    method: Literal["butterworth", "spline"] = "butterworth",
    order: int = 4,
    max_gap: int = 0,
) -> SmoothedMotion:
    """Smooth positions and compute velocity and acceleration (paper 2009, §3.5).

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Positions or unwrapped angles (:func:`unwrap_angles`); NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.
    cutoff_hz : float or None
        Cut-off, in Hz. None, for the spline only: chosen by generalised cross-validation.
    method : {"butterworth", "spline"}
        The zero-lag filter with finite differences (Eq. 3.18-3.20), or a smoothing spline
        with its own derivatives.
    order : int
        Order of the Butterworth filter; the spline answers to frequencies as order 4.
    max_gap : int
        Gaps up to this many samples are interpolated first; see :func:`fill_gaps`.

    Returns
    -------
    SmoothedMotion
        Position, velocity and acceleration.

    Raises
    ------
    InputError
        If the method is not known, or the Butterworth filter is given no cut-off.
    """
    if method == "spline":
        return SmoothedMotion(
            *(
                smooth_spline(x, fs_hz=fs_hz, cutoff_hz=cutoff_hz, derivative=k, max_gap=max_gap)
                for k in range(3)
            )
        )
    if method != "butterworth":
        raise InputError(f"method is {method!r}; expected 'butterworth' or 'spline'.")
    if cutoff_hz is None:
        raise InputError(
            "cutoff_hz is missing; choose one, for instance by pawnb.gait.residuals."
            "compare_cutoffs, or use method='spline'."
        )
    position = butterworth_lowpass(
        x, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order, max_gap=max_gap
    )
    dt = 1.0 / fs_hz
    return SmoothedMotion(
        position, differentiate(position, dt=dt), differentiate(position, dt=dt, order=2)
    )
