"""Smoothing splines, the alternative to the Butterworth filter, with their derivatives."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import make_smoothing_spline
from scipy.linalg import solveh_banded

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.signals.butterworth import check_cutoff, check_rate, end_bends, filter_reach
from pawnb.signals.gcv import effective_parameters, find_lowest, gcv_score
from pawnb.signals.runs import each_column, each_run, fill_gaps, find_runs

LEAST_SAMPLES = 5
"""Shortest run through which a smoothing spline can be laid."""


def smooth_spline(
    x: FloatArray,
    *,
    fs_hz: float,
    cutoff_hz: float | None = None,
    derivative: int = 0,
    max_gap: int = 0,
) -> FloatArray:
    """Smooth with a cubic smoothing spline, or take its first or second derivative.

    The spline f minimises ``sum (x_i - f(i))^2 + lambda * integral of f''^2``. Far from the
    ends such a spline passes ``1 / (1 + (2 pi f)^4 lambda)`` of the amplitude at the
    frequency f (in cycles per sample), the very response of the fourth-order zero-lag
    Butterworth filter, so both can be given the same cut-off:
    ``lambda = (sqrt(2) - 1) / (2 pi cutoff_hz / fs_hz)^4``. They differ in how derivatives are
    taken: those of the spline are exact. At its own ends a smoothing spline has no curvature;
    so each run is continued first, as for the filter
    (:func:`~pawnb.signals.butterworth.extend_run`). The fit is scipy's
    ``make_smoothing_spline``, run by run.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.
    cutoff_hz : float, optional
        Frequency at which half the power is left, in Hz. Default: chosen for each signal by
        generalised cross-validation; see :func:`spline_cutoff`.
    derivative : {0, 1, 2}
        0 for the smoothed signal, 1 for its derivative per second, 2 per second squared.
    max_gap : int
        Gaps up to this many samples are interpolated first; see :func:`fill_gaps`.

    Returns
    -------
    ndarray, shape (n, ...)
        The spline or its derivative at the samples; NaN in gaps that were not filled and in
        runs of fewer than five samples, which are too short for a spline.

    Raises
    ------
    InputError
        If the cut-off is not between 0 and half the sampling rate, the derivative is not 0,
        1 or 2, or no cut-off is given and a signal has too few samples to choose one.
    """
    if derivative not in (0, 1, 2):
        raise InputError(f"derivative is {derivative}; expected 0, 1 or 2.")
    check_rate(fs_hz)
    if cutoff_hz is not None:
        check_cutoff(cutoff_hz, fs_hz=fs_hz)

    def smooth(column: FloatArray) -> FloatArray:
        if not np.isfinite(column).any():
            return column
        cutoff = spline_cutoff(column, fs_hz=fs_hz) if cutoff_hz is None else cutoff_hz
        weight = _weight(cutoff / fs_hz)

        def fit(run: FloatArray) -> FloatArray:
            if len(run) < LEAST_SAMPLES:
                return np.full(len(run), np.nan)
            at = np.arange(len(run), dtype=float)
            first, last = end_bends(run, cutoff_hz=cutoff, fs_hz=fs_hz)
            bent = Polynomial([0.0, 0.0, float(first), float(last - first) / (3 * (len(run) - 1))])
            curve = make_smoothing_spline(at, run - bent(at), lam=weight)
            return (
                curve.derivative(derivative)(at) + bent.deriv(derivative)(at)
            ) * fs_hz**derivative

        return each_run(column, fit)

    return each_column(fill_gaps(x, max_gap=max_gap), smooth)


def spline_cutoff(x: FloatArray, *, fs_hz: float) -> float:
    """Choose the cut-off of a smoothing spline by generalised cross-validation.

    The score is that of :func:`gcv_score` (Craven & Wahba 1979; Woltring 1986), searched
    from a hundredth of half the sampling rate up to nine tenths of it. (Left to itself,
    ``make_smoothing_spline`` searches lambda on a linear scale up to the number of samples,
    which misses the minimum for smooth signals.)

    Parameters
    ----------
    x : ndarray, shape (n,)
        A signal; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    float
        The cut-off, in Hz.

    Raises
    ------
    InputError
        If the sampling rate is not above 0 or no run has five samples.
    """
    check_rate(fs_hz)
    x = np.asarray(x, dtype=float)
    spans = find_runs(np.isfinite(x))
    runs = [x[start:stop] for start, stop in spans if stop - start >= LEAST_SAMPLES]
    if not runs:
        raise InputError(
            f"smoothing spline: no {LEAST_SAMPLES} samples in a row; expected at least one "
            "such run: fill the gaps (max_gap) or leave this signal out."
        )

    def score(cutoff_hz: float) -> float:
        share = cutoff_hz / fs_hz
        squares = sum(float(np.sum((run - _fit(run, share)) ** 2)) for run in runs)
        spent = sum(_spent(len(run), share) for run in runs)
        return gcv_score(squares, spent=spent, n=sum(len(run) for run in runs))

    return find_lowest(score, fs_hz / 200.0, 0.45 * fs_hz)


def _weight(share: float) -> float:
    """Return lambda for a cut-off given as a share of the sampling rate."""
    return (math.sqrt(2.0) - 1.0) / (2.0 * math.pi * share) ** 4


def _fit(run: FloatArray, share: float) -> FloatArray:
    """Return the spline of one run, or of several side by side, at the samples.

    It is that of ``make_smoothing_spline``, in the form of Reinsch 1967 (Numer. Math. 10:
    177-183), which needs no basis: the search for a cut-off asks for it a hundred times.
    """
    weight = _weight(share)
    bands = np.empty((3, len(run) - 2))
    for band, own in enumerate((2 / 3 + 6 * weight, 1 / 6 - 4 * weight, weight)):
        bands[band] = own
    bend = solveh_banded(bands, np.diff(run, 2, axis=0), lower=True)
    beyond = [(2, 2), *[(0, 0)] * (run.ndim - 1)]
    return run - weight * np.diff(np.pad(bend, beyond), 2, axis=0)


@lru_cache(maxsize=4096)
def _spent(n: int, share: float) -> float:
    """Return the parameters spent on a run; the same for every signal of that length."""
    reach = filter_reach(share, fs_hz=1.0)
    return effective_parameters(lambda pulses: _fit(pulses, share), n, reach=reach)
