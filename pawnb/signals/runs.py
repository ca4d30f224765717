"""Gaps: runs of samples that are there, and short gaps filled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import PchipInterpolator

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray
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

    def fill(column: FloatArray) -> FloatArray:
        there = np.isfinite(column)
        out = column.copy()
        short = _short_gaps(there, max_gap)
        known = np.flatnonzero(there)
        if len(short):
            curve = PchipInterpolator(known, column[known])
            for start, stop in short:
                out[start:stop] = curve(np.arange(start, stop))
        return out

    return each_column(x, fill)


def fill_gaps_of_points(positions: FloatArray, *, max_gap: int) -> FloatArray:
    """Interpolate short gaps of points in a plane or in space, whichever way its axes lie.

    The monotone curve of :func:`fill_gaps` is another one along other axes. Here it runs along
    the straight line over the gap, so that a picture that is turned has the same points.

    Parameters
    ----------
    positions : ndarray, shape (n, d) or (n, d, k)
        Positions; NaN where missing. A point of which one coordinate is missing is missing.
    max_gap : int
        Longest gap, in samples, that is filled.

    Returns
    -------
    ndarray of the same shape
        A copy with the gaps filled; longer ones, and missing ends, stay as they are.

    Raises
    ------
    InputError
        If ``max_gap`` is negative.
    """
    out = np.array(positions, dtype=float, order="C")
    for point in np.moveaxis(out.reshape(*out.shape[:2], -1), 2, 0):
        there = np.isfinite(point).all(axis=1)
        known = np.flatnonzero(there)
        for start, stop in _short_gaps(there, max_gap):
            after = int(np.searchsorted(known, stop))
            about = known[max(after - 2, 0) : after + 2]  # all that the curve over it depends on
            way = point[stop] - point[start - 1]
            length = float(np.linalg.norm(way))
            unit = way / length if length > 0.0 else way
            curve = PchipInterpolator(about, (point[about] - point[start - 1]) @ unit)
            point[start:stop] = point[start - 1] + np.outer(curve(np.arange(start, stop)), unit)
    return out


def _short_gaps(there: BoolArray, max_gap: int) -> IntArray:
    """Return the first sample and one past the last of gaps that are to be filled."""
    if max_gap < 0:
        raise InputError(f"max_gap is {max_gap}; expected 0 or more samples.")
    gaps = find_runs(~there)
    inner = (gaps[:, 0] > 0) & (gaps[:, 1] < len(there))
    return gaps[inner & (gaps[:, 1] - gaps[:, 0] <= max_gap)]


def as_signal(x: AnyArray) -> FloatArray:
    """Return signals as floats; what is masked is missing.

    Parameters
    ----------
    x : array_like, shape (n, ...)
        Signals.

    Returns
    -------
    ndarray, shape (n, ...)
        The same numbers, NaN where missing.

    Raises
    ------
    InputError
        If there is no sample, or one is no number.
    """
    given = x if isinstance(x, np.ma.MaskedArray) else np.asarray(x)
    if given.dtype.kind in "cmM":
        raise InputError(f"signals: expected numbers; found {given.dtype}.")
    try:
        values: FloatArray = np.ma.filled(given.astype(float), np.nan)
    except (TypeError, ValueError) as error:
        raise InputError(f"signals: expected numbers ({error}).") from None
    if values.size == 0 or values.ndim == 0:
        raise InputError(f"signals: shape {values.shape}; expected samples along the first axis.")
    return values


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
    x = as_signal(x)
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
