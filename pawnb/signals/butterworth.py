"""Zero-lag Butterworth filter."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from pawnb.errors import InputError
from pawnb.signals.runs import each_run, fill_gaps


def two_pass_correction(order: int) -> float:
    """Compute the ratio between the cut-off of a two-pass filter and that of each pass.

    One pass of order m leaves ``1 / (1 + (f / f0)^(2m))`` of the power, two leave its square.
    That is one half where ``f / f0 = (sqrt(2) - 1)^(1 / (2m))``: 0.8022 for m = 2
    (Winter 2009; Robertson & Dowling 2003).

    Parameters
    ----------
    order : int
        Order of the whole filter, both passes together: 2, 4, 6, ...

    Returns
    -------
    float
        The ratio, below 1.

    Raises
    ------
    InputError
        If the order is odd or below 2: each pass has half of it.
    """
    if order < 2 or order % 2:
        raise InputError(
            f"order is {order}; expected an even number from 2 on, for each of the two passes "
            "has half of it (4: two passes of second order)."
        )
    return (math.sqrt(2.0) - 1.0) ** (1.0 / order)


TWO_PASS_CORRECTION = two_pass_correction(4)
"""Factor 0.8022 between the cut-off of one and of two passes, second order each."""


def highest_cutoff(fs_hz: float, *, order: int = 4) -> float:
    """Compute the frequency below which a cut-off must lie.

    Parameters
    ----------
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the whole filter.

    Returns
    -------
    float
        Half the sampling rate times :func:`two_pass_correction`, in Hz.

    Raises
    ------
    InputError
        If the sampling rate is not above 0 or the order is odd.
    """
    if not fs_hz > 0:
        raise InputError(f"fs_hz is {fs_hz}; expected a sampling rate above 0 Hz.")
    return two_pass_correction(order) * fs_hz / 2.0


def filter_reach(cutoff_hz: float, *, fs_hz: float) -> int:
    """Return over how many samples a run is continued beyond its ends.

    Parameters
    ----------
    cutoff_hz : float
        Cut-off frequency, in Hz.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    int
        Three periods of the cut-off, in samples, and at least nine.
    """
    return max(9, math.ceil(3.0 * fs_hz / cutoff_hz))


def butterworth_lowpass(
    x: np.ndarray, *, cutoff_hz: float, fs_hz: float, order: int = 4, max_gap: int = 0
) -> np.ndarray:
    """Low-pass with a zero-lag Butterworth filter, of fourth order (paper 2009, Eq. 3.18).

    A filter of half the order runs forwards and backwards, so nothing is delayed. Two passes
    lower the cut-off, so the design frequency is ``cutoff_hz / two_pass_correction(order)``
    (0.8022 for the fourth order), which leaves half the power at ``cutoff_hz``; the frequency
    warping of the digital filter moves that point up by 1 % at a twelfth of the
    sampling rate and by 7 % at a fifth.

    Runs between gaps are filtered one by one. At both ends of a run the signal is
    continued by point reflection (odd extension) over three periods of the cut-off, or
    as far as the run is long, so that a trend goes on and the ends are not pulled
    anywhere. Values within about half a period of the cut-off from an end still lean
    on that assumption, and derivatives there more so. A run of one sample stays as it is.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    cutoff_hz : float
        Cut-off frequency of the whole filter, in Hz.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the whole filter, both passes together: 2, 4, 6, ...
    max_gap : int
        Gaps up to this many samples are interpolated first; see :func:`fill_gaps`.

    Returns
    -------
    ndarray, shape (n, ...)
        Filtered signals; NaN in the gaps that were not filled.

    Raises
    ------
    InputError
        If the order is odd or below 2, or the cut-off is not above 0 and, corrected for two
        passes, below half the sampling rate.
    """
    highest = highest_cutoff(fs_hz, order=order)
    if not 0.0 < cutoff_hz < highest:
        raise InputError(
            f"cutoff_hz is {cutoff_hz:g}; expected above 0 and below {highest:g} Hz at a "
            f"sampling rate of {fs_hz:g} Hz."
        )
    return each_run(
        fill_gaps(x, max_gap=max_gap),
        lambda run: filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order),
    )


def filter_run(run: np.ndarray, *, cutoff_hz: float, fs_hz: float, order: int = 4) -> np.ndarray:
    """Filter one run, or several of the same length, as :func:`butterworth_lowpass` does.

    Parameters
    ----------
    run : ndarray, shape (n,) or (n, k)
        Values without gaps.
    cutoff_hz, fs_hz : float
        Cut-off of the whole filter and sampling rate, in Hz.
    order : int
        Order of the whole filter.

    Returns
    -------
    ndarray of the same shape
        Filtered values.
    """
    sections = _sections(cutoff_hz / fs_hz, order)
    reach = min(filter_reach(cutoff_hz, fs_hz=fs_hz), len(run) - 1)
    return sosfiltfilt(sections, run, axis=0, padtype="odd", padlen=reach)


@lru_cache(maxsize=1024)
def _sections(share: float, order: int) -> np.ndarray:
    """Return one pass of the filter; the cut-off is a share of the sampling rate."""
    return butter(order // 2, share / two_pass_correction(order), fs=1.0, output="sos")
