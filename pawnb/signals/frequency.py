"""The frequency of a repeated movement."""

from __future__ import annotations

import math

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.signals.runs import as_signal


def dominant_frequency(x: FloatArray, *, fs_hz: float) -> float:
    """Estimate the frequency of a repeated movement from its velocity.

    The spectrum is that of the first differences: it is flat where positions drift,
    and the strides stand out of the wander. A stride is short pulses, rich in
    harmonics, so the frequency is that with the largest sum of the amplitude at
    itself, half that at its double and a third of that at its triple, over all signals.
    Gaps are bridged, for this purpose only.

    Parameters
    ----------
    x : ndarray, shape (n, k)
        Positions of k feet that step at one frequency; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    float
        Frequency in Hz, between two cycles in the recording and a quarter of the
        sampling rate; NaN where there is too little to tell.
    """
    x = as_signal(x)
    x = x.reshape(len(x), -1)
    n = len(x)
    n_fft = 8 * 2 ** math.ceil(math.log2(max(n, 2)))
    amplitude = np.zeros(n_fft // 2 + 1)
    for column in x.T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known) >= max(8, n // 4):
            velocity = np.diff(np.interp(np.arange(n), known, column[known]))
            velocity = (velocity - velocity.mean()) * np.hanning(n - 1)
            amplitude += np.abs(np.fft.rfft(velocity, n_fft))
    bins = np.arange(math.ceil(2.0 * n_fft / n), n_fft // 4 + 1)
    if len(bins) == 0 or amplitude[bins].max() == 0.0:
        return math.nan
    padded = np.concatenate((amplitude, np.zeros(n_fft)))
    together = padded[bins] + padded[2 * bins] / 2.0 + padded[3 * bins] / 3.0
    return float(bins[np.argmax(together)] * fs_hz / n_fft)
