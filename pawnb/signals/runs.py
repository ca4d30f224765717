"""Gaps: runs of samples that are there, and short gaps filled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import PchipInterpolator

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError


def find_runs(valid: BoolArray) -> IntArray:
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


def fill_gaps(x: FloatArray, *, max_gap: int) -> FloatArray:
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

    def fill(column: FloatArray) -> FloatArray:
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

    return each_column(x, fill)


def each_column(x: FloatArray, apply: Callable[[np.ndarray], np.ndarray]) -> FloatArray:
    """Apply a function to every signal of an array whose first axis is time.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals.
    apply : callable
        Takes and returns an ndarray of shape (n,).

    Returns
    -------
    ndarray, shape (n, ...)
        What the function returned for each signal.
    """
    x = np.asarray(x, dtype=float)
    flat = x.reshape(len(x), -1)
    out = np.empty_like(flat)
    for k in range(flat.shape[1]):
        out[:, k] = apply(flat[:, k])
    return out.reshape(x.shape)


def each_run(x: FloatArray, apply: Callable[[np.ndarray], np.ndarray]) -> FloatArray:
    """Apply a function to every run of every signal.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    apply : callable
        Takes one run without gaps and returns as many values.

    Returns
    -------
    ndarray, shape (n, ...)
        What the function returned for each run; NaN in the gaps.
    """

    def runs(column: FloatArray) -> FloatArray:
        out = np.full(len(column), np.nan)
        for start, stop in find_runs(np.isfinite(column)):
            out[start:stop] = apply(column[start:stop])
        return out

    return each_column(x, runs)
