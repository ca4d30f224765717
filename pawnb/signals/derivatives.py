"""Derivatives by finite differences, and angles without jumps of a turn."""

from __future__ import annotations

from typing import Literal

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.signals.runs import each_column, each_run


def differentiate(x: FloatArray, *, dt: float, order: Literal[1, 2] = 1) -> FloatArray:
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

    def first(run: FloatArray) -> FloatArray:
        if len(run) < 2:
            return np.full(len(run), np.nan)
        return np.gradient(run, dt, edge_order=2 if len(run) > 2 else 1)

    def second(run: FloatArray) -> FloatArray:
        if len(run) < 3:
            return np.full(len(run), np.nan)
        inner = (run[2:] - 2.0 * run[1:-1] + run[:-2]) / dt**2
        return np.concatenate((inner[:1], inner, inner[-1:]))

    return each_run(np.asarray(x, dtype=float), first if order == 1 else second)


def unwrap_angles(x: FloatArray, *, turn: float = 360.0, max_gap: int | None = None) -> FloatArray:
    """Take the jumps of a whole turn out of angles, so that they can be filtered.

    Every sample is moved by whole turns to within half a turn of the sample before it. After
    a gap the sample before the gap counts, which is right where the angle moved by less than
    half a turn in the gap; after a gap longer than ``max_gap`` nothing is known of the turns
    in between, and the angle starts anew as it was given.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Angles; NaN where missing.
    turn : float
        A whole turn in the unit of ``x``: 360 for degrees, 1 for cycles.
    max_gap : int, optional
        Longest gap, in samples, over which turns are counted; default any.

    Returns
    -------
    ndarray, shape (n, ...)
        The angles without jumps; NaN stays.

    Raises
    ------
    InputError
        If ``turn`` is not above 0 or ``max_gap`` is negative.
    """
    if not turn > 0 or (max_gap is not None and max_gap < 0):
        raise InputError(
            f"turn is {turn}, max_gap {max_gap}; expected a turn above 0 and a gap of 0 or more."
        )

    def unwrap(column: FloatArray) -> FloatArray:
        out = column.copy()
        known = np.flatnonzero(np.isfinite(column))
        longest = len(column) if max_gap is None else max_gap
        breaks = np.flatnonzero(np.diff(known) - 1 > longest) + 1
        for part in np.split(known, breaks):
            out[part] = np.unwrap(column[part], period=turn)
        return out

    return each_column(x, unwrap)
