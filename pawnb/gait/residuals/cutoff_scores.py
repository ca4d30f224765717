"""How well a cut-off does on given runs: what is taken away, and two scores of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.signal import detrend

from pawnb.arrays import FloatArray
from pawnb.signals import find_runs
from pawnb.signals.butterworth import filter_reach, filter_run
from pawnb.signals.gcv import effective_parameters, find_lowest, gcv_score

LEAST_SAMPLES = 20
"""Shortest run from which a cut-off can be chosen."""

NO_CUTOFF = "no cut-off: "
"""How the reason begins where there is none."""
STRAIGHT_LINE = "the signal is a straight line"
"""Why there is nothing to filter."""
_ROUNDING_SHARE = 1e-12
"""Share of the largest value up to which differences from a straight line are rounding."""


class Choice(NamedTuple):
    """A cut-off that was chosen.

    Attributes
    ----------
    cutoff_hz : float
        The cut-off; NaN where there is none.
    noise_rms : float
        The noise estimated beside it; NaN where it is not.
    reason : str
        How it was found, or why not.
    """

    cutoff_hz: float
    noise_rms: float
    reason: str


def find_long_runs(x: FloatArray) -> list[FloatArray]:
    """Find the runs of all signals that are long enough to choose a cut-off from.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.

    Returns
    -------
    list of ndarray, shape (m, k)
        Runs of at least 20 samples, those of one length side by side.
    """
    flat = np.asarray(x, dtype=float).reshape(len(x), -1)
    by_length: dict[int, list[FloatArray]] = {}
    for column in flat.T:
        for start, stop in find_runs(np.isfinite(column)):
            if stop - start >= LEAST_SAMPLES:
                by_length.setdefault(stop - start, []).append(column[start:stop])
    return [np.column_stack(runs) for runs in by_length.values()]


def why_no_runs(x: FloatArray) -> str:
    """Say why signals have no run that is long enough.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.

    Returns
    -------
    str
        What was found.
    """
    if not np.isfinite(np.asarray(x, dtype=float)).any():
        return "no value in any frame (of tracks without calibration, image_position has them)"
    return f"no run of {LEAST_SAMPLES} samples without a gap"


def are_straight(runs: list[FloatArray]) -> bool:
    """Tell whether all runs are straight lines, or stand still: there is nothing to filter.

    Parameters
    ----------
    runs : list of ndarray, shape (m, k)
        From :func:`find_long_runs`.

    Returns
    -------
    bool
        Whether they are.
    """
    largest = max(float(np.abs(run).max()) for run in runs)
    off = max(float(np.abs(detrend(run, axis=0)).max()) for run in runs)
    return off <= _ROUNDING_SHARE * largest


def _square_sum(runs: list[FloatArray], cutoff_hz: float, *, fs_hz: float, order: int) -> float:
    """Return the sum of the squares of raw minus filtered over all runs."""
    return sum(
        float(np.sum((run - filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order)) ** 2))
        for run in runs
    )


def residual_rms(runs: list[FloatArray], cutoff_hz: float, *, fs_hz: float, order: int) -> float:
    """Compute what a filter takes away.

    Parameters
    ----------
    runs : list of ndarray, shape (m, k)
        From :func:`find_long_runs`.
    cutoff_hz, fs_hz : float
        Cut-off and sampling rate, in Hz.
    order : int
        Total order of the Butterworth filter.

    Returns
    -------
    float
        RMS of raw minus filtered over all runs.
    """
    squares = _square_sum(runs, cutoff_hz, fs_hz=fs_hz, order=order)
    return math.sqrt(squares / sum(run.size for run in runs))


def cross_validate(runs: list[FloatArray], *, fs_hz: float, order: int) -> Choice:
    """Choose the cut-off with the least generalised cross-validation score.

    Parameters
    ----------
    runs : list of ndarray, shape (m, k)
        From :func:`find_long_runs`.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Total order of the Butterworth filter.

    Returns
    -------
    Choice
        Where the score falls up to an end of the search, ``cutoff_hz`` is that end and the
        reason begins with "no cut-off"; the noise left there is still that of the best fit.
    """
    said = "least cross-validation score"
    cutoff, reason = _search(lambda c: _gcv(runs, c / fs_hz, order), said, fs_hz)
    return Choice(cutoff, _gcv_noise(runs, cutoff / fs_hz, order), reason)


def find_whitest(runs: list[FloatArray], *, fs_hz: float, order: int) -> Choice:
    """Choose the cut-off at which what is taken away is most like white noise (Challis 1999).

    Parameters
    ----------
    runs : list of ndarray, shape (m, k)
        From :func:`find_long_runs`.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Total order of the Butterworth filter.

    Returns
    -------
    Choice
        As of :func:`cross_validate`; the noise is NaN.
    """
    said = "what is taken away is most like white noise"
    cutoff, reason = _search(lambda c: _colour(runs, c, fs_hz, order), said, fs_hz)
    return Choice(cutoff, math.nan, reason)


def _search(score: Callable[[float], float], said: str, fs_hz: float) -> tuple[float, str]:
    """Find the cut-off with the lowest score; say where it is an end of the search."""
    low, high = fs_hz / 200.0, 0.45 * fs_hz
    cutoff = find_lowest(score, low, high)
    if low < cutoff < high:
        return cutoff, said
    end = "lowest" if cutoff <= low else "highest"
    return cutoff, f"{NO_CUTOFF}{said} only at the {end} cut-off tried, {cutoff:.3g} Hz"


@lru_cache(maxsize=8192)
def _spent(n: int, share: float, order: int) -> float:
    """Return the parameters that the filter spends on a run of n samples."""
    return effective_parameters(
        lambda pulses: filter_run(pulses, cutoff_hz=share, fs_hz=1.0, order=order),
        n,
        reach=filter_reach(share, fs_hz=1.0),
    )


def _all_spent(runs: list[FloatArray], share: float, order: int) -> float:
    """Return the parameters spent on all runs."""
    return sum(_spent(len(run), share, order) * run.shape[1] for run in runs)


def _gcv(runs: list[FloatArray], share: float, order: int) -> float:
    """Return the cross-validation score of all runs together."""
    squares = _square_sum(runs, share, fs_hz=1.0, order=order)
    n = sum(run.size for run in runs)
    return gcv_score(squares, spent=_all_spent(runs, share, order), n=n)


def _gcv_noise(runs: list[FloatArray], share: float, order: int) -> float:
    """Return the RMS of the noise: the residual with the parameters spent taken off n."""
    n = sum(run.size for run in runs)
    left = n - _all_spent(runs, share, order)
    return math.sqrt(_square_sum(runs, share, fs_hz=1.0, order=order) / left)


def _colour(runs: list[FloatArray], cutoff_hz: float, fs_hz: float, order: int) -> float:
    """Return how far the residuals are from white: mean sum of squared autocorrelations."""
    total, n = 0.0, 0
    for run in runs:
        left = run - filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order)
        power = np.abs(np.fft.rfft(left - left.mean(axis=0), 2 * len(left), axis=0)) ** 2
        products = np.fft.irfft(power, axis=0)[: len(left)]
        moved = products[0] > 0.0
        shares = products[1:, moved] / products[0, moved]
        total += len(left) * float(np.sum(shares**2))
        n += len(left) * int(moved.sum())
    return total / n if n else math.inf
