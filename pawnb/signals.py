"""Filters, derivatives, gaps and extremes of sampled signals.

Every function works along the first axis, treats further axes as separate signals,
and respects gaps: a stretch of NaN parts a signal into runs that never mix. Nothing
here knows what the numbers mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.signal import butter, filtfilt

from pawnb.errors import InputError

TWO_PASS_CORRECTION = (math.sqrt(2.0) - 1.0) ** 0.25
"""Factor 0.8022 between the cut-off of one and of two passes, second order each."""


def find_runs(valid: np.ndarray) -> np.ndarray:
    """Find the unbroken runs of True.

    Parameters
    ----------
    valid : ndarray of bool, shape (n,)
        Which samples are there.

    Returns
    -------
    ndarray of int, shape (k, 2)
        First sample and one past the last of each run, in order.
    """
    edges = np.diff(np.concatenate(([0], np.asarray(valid, dtype=np.int8), [0])))
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)))


def fill_gaps(x: np.ndarray, *, max_gap: int) -> np.ndarray:
    """Interpolate short gaps; longer ones, and missing ends, stay NaN.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    max_gap : int
        Longest gap, in samples, that is filled.

    Returns
    -------
    ndarray, shape (n, ...)
        A copy with the gaps filled by monotone cubic interpolation (PCHIP) through
        all samples that are there. It does not overshoot: an extreme that lies inside
        a gap is cut off, not invented.

    Raises
    ------
    InputError
        If ``max_gap`` is negative.
    """
    if max_gap < 0:
        raise InputError(f"max_gap is {max_gap}; expected 0 or more samples.")

    def fill(column: np.ndarray) -> np.ndarray:
        there = np.isfinite(column)
        out = column.copy()
        if there.sum() < 2:
            return out
        known = np.flatnonzero(there)
        gaps = find_runs(~there)
        inner = (gaps[:, 0] > known[0]) & (gaps[:, 1] <= known[-1])
        short = gaps[inner & (gaps[:, 1] - gaps[:, 0] <= max_gap)]
        if len(short):
            curve = PchipInterpolator(known, column[known])
            for start, stop in short:
                out[start:stop] = curve(np.arange(start, stop))
        return out

    return _each_column(x, fill)


def butterworth_lowpass(
    x: np.ndarray, *, cutoff_hz: float, fs_hz: float, max_gap: int = 0
) -> np.ndarray:
    """Low-pass with a fourth-order, zero-lag Butterworth filter (paper 2009, Eq. 3.18).

    A second-order filter runs forwards and backwards. Two passes lower the cut-off,
    so the design frequency is ``cutoff_hz / 0.8022`` (Winter 2009; Research Methods
    in Biomechanics), which leaves half the power at ``cutoff_hz``; the frequency
    warping of the digital filter moves that point up by 1 % at a twelfth of the
    sampling rate and by 7 % at a fifth.

    Runs between gaps are filtered one by one. At both ends of a run the signal is
    continued by point reflection (odd extension) over three periods of the cut-off, or
    as far as the run is long, so that a trend goes on and the ends are not pulled
    anywhere. Values within about half a period of the cut-off from an end still lean
    on that assumption. A run of one sample stays as it is.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    cutoff_hz : float
        Cut-off frequency of the whole filter, in Hz.
    fs_hz : float
        Sampling rate, in Hz.
    max_gap : int
        Gaps up to this many samples are interpolated first; see :func:`fill_gaps`.

    Returns
    -------
    ndarray, shape (n, ...)
        Filtered signals; NaN in the gaps that were not filled.

    Raises
    ------
    InputError
        If the cut-off is not above 0 and, corrected for two passes, below half the
        sampling rate.
    """
    highest = TWO_PASS_CORRECTION * fs_hz / 2.0
    if not 0.0 < cutoff_hz < highest:
        raise InputError(
            f"cutoff_hz is {cutoff_hz:g}; expected above 0 and below {highest:g} Hz at a "
            f"sampling rate of {fs_hz:g} Hz."
        )
    b, a = butter(2, cutoff_hz / TWO_PASS_CORRECTION, fs=fs_hz)
    reach = max(9, math.ceil(3.0 * fs_hz / cutoff_hz))

    def smooth(run: np.ndarray) -> np.ndarray:
        return filtfilt(b, a, run, padtype="odd", padlen=min(reach, len(run) - 1))

    return _each_run(fill_gaps(x, max_gap=max_gap), smooth)


def differentiate(x: np.ndarray, *, dt: float, order: Literal[1, 2] = 1) -> np.ndarray:
    """Differentiate by finite differences (paper 2009, Eq. 3.19 and 3.20).

    Inside a run the differences are central. The first and last sample of a run have
    no neighbour on one side: the first derivative there is the one-sided difference of
    second order (exact for a parabola), the second derivative that of the neighbour.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    dt : float
        Time between samples, in seconds.
    order : {1, 2}
        First or second derivative.

    Returns
    -------
    ndarray, shape (n, ...)
        The derivative per second (per second squared); NaN in gaps and in runs too
        short for a difference (one sample, or two for the second derivative).

    Raises
    ------
    InputError
        If ``dt`` is not above 0 or ``order`` is neither 1 nor 2.
    """
    if not dt > 0:
        raise InputError(f"dt is {dt}; expected the time between samples, above 0 s.")
    if order not in (1, 2):
        raise InputError(f"order is {order}; expected 1 or 2.")

    def first(run: np.ndarray) -> np.ndarray:
        if len(run) < 2:
            return np.full(len(run), np.nan)
        return np.gradient(run, dt, edge_order=2 if len(run) > 2 else 1)

    def second(run: np.ndarray) -> np.ndarray:
        if len(run) < 3:
            return np.full(len(run), np.nan)
        inner = (run[2:] - 2.0 * run[1:-1] + run[:-2]) / dt**2
        return np.concatenate((inner[:1], inner, inner[-1:]))

    return _each_run(np.asarray(x, dtype=float), first if order == 1 else second)


def refine_extremum(x: np.ndarray, index: int) -> tuple[float, float]:
    """Place a sampled extreme between samples by a parabola through three of them.

    Parameters
    ----------
    x : ndarray, shape (n,)
        A signal.
    index : int
        The highest or lowest sample of its neighbourhood.

    Returns
    -------
    position, value : float
        Fractional sample number, within half a sample of ``index``, and height of the
        parabola's vertex. Without both neighbours, or on a plateau, the sample itself.
    """
    if not 0 < index < len(x) - 1:
        return float(index), float(x[index])
    before, here, after = (float(v) for v in x[index - 1 : index + 2])
    bend = before - 2.0 * here + after
    if not np.isfinite(bend) or bend == 0.0:
        return float(index), here
    shift = float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5))
    return index + shift, here + 0.5 * shift * (after - before) + 0.5 * shift**2 * bend


def find_turns(x: np.ndarray, *, min_excursion: float) -> np.ndarray:
    """Find the maxima and minima between which a signal moves far enough.

    A turn counts when the signal has come at least ``min_excursion`` to it and goes
    at least as far away from it, within one run; smaller wiggles are passed over
    (hysteresis). Between two turns of a run lies no higher maximum and no lower minimum.

    Parameters
    ----------
    x : ndarray, shape (n,)
        A signal; NaN where missing.
    min_excursion : float
        Least excursion, in the unit of ``x``.

    Returns
    -------
    ndarray of int, shape (k, 2)
        Sample and kind (+1 maximum, -1 minimum) of each turn, in order; kinds
        alternate within a run.

    Raises
    ------
    InputError
        If ``min_excursion`` is not above 0.
    """
    if not min_excursion > 0:
        raise InputError(f"min_excursion is {min_excursion}; expected above 0.")
    turns: list[tuple[int, int]] = []
    for start, stop in find_runs(np.isfinite(x)):
        turns += [(start + i, kind) for i, kind in _turns_of_run(x[start:stop], min_excursion)]
    return np.array(turns, dtype=int).reshape(-1, 2)


def _turns_of_run(x: np.ndarray, least: float) -> list[tuple[int, int]]:
    """Zigzag through one run; the first pivot is dropped unless it was reached by ``least``."""
    high = low = 0
    direction = 0
    pivots: list[tuple[int, int]] = []
    for i, value in enumerate(x):
        if value > x[high]:
            high = i
        if value < x[low]:
            low = i
        if direction >= 0 and x[high] - value >= least:
            if direction == 1 or x[high] - x[: high + 1].min() >= least:
                pivots.append((high, 1))
            direction, low = -1, i
            high = i
        elif direction <= 0 and value - x[low] >= least:
            if direction == -1 or x[: low + 1].max() - x[low] >= least:
                pivots.append((low, -1))
            direction, high = 1, i
            low = i
    return pivots


def find_jumps(x: np.ndarray, *, factor: float, longest: int = 3) -> np.ndarray:
    """Find samples that jump away and back, as where a tracker took a wrong thing for a moment.

    A stretch of up to ``longest`` samples is a jump if the steps into and out of it go
    opposite ways and both exceed ``factor`` times the 95th percentile of all steps.
    A signal that moves away and stays, or comes back slowly, is left alone.

    Parameters
    ----------
    x : ndarray, shape (n, d)
        Positions; NaN where missing.
    factor : float
        How much larger than usual steps must be.
    longest : int
        Longest stretch, in samples.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the sample belongs to a jump.

    Raises
    ------
    InputError
        If ``factor`` is not at least 1 or ``longest`` not at least 1.
    """
    if not factor >= 1 or longest < 1:
        raise InputError(f"factor is {factor}, longest {longest}; expected 1 or more of both.")
    out = np.zeros(len(x), dtype=bool)
    steps = np.diff(x, axis=0)
    size = np.linalg.norm(steps, axis=1)
    if not np.isfinite(size).any():
        return out
    large = size > factor * np.nanpercentile(size, 95)
    for i in np.flatnonzero(large):
        for length in range(1, longest + 1):
            back = i + length
            if back < len(steps) and large[back] and steps[i] @ steps[back] < 0:
                out[i + 1 : back + 1] = True
                break
    return out


def dominant_frequency(x: np.ndarray, *, fs_hz: float) -> float:
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


def _each_column(x: np.ndarray, apply: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Apply a function to every signal of an array whose first axis is time."""
    x = np.asarray(x, dtype=float)
    flat = x.reshape(len(x), -1)
    out = np.empty_like(flat)
    for k in range(flat.shape[1]):
        out[:, k] = apply(flat[:, k])
    return out.reshape(x.shape)


def _each_run(x: np.ndarray, apply: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Apply a function to every run of every signal; NaN elsewhere."""

    def runs(column: np.ndarray) -> np.ndarray:
        out = np.full(len(column), np.nan)
        for start, stop in find_runs(np.isfinite(column)):
            out[start:stop] = apply(column[start:stop])
        return out

    return _each_column(x, runs)
