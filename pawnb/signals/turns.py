"""Extremes of a signal, and jumps there and back."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.signals.runs import find_runs


def refine_extremum(x: FloatArray, index: int) -> tuple[float, float]:
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


def find_turns(x: FloatArray, *, min_excursion: float) -> IntArray:
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


def _turns_of_run(x: FloatArray, least: float) -> list[tuple[int, int]]:
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


def find_jumps(x: FloatArray, *, factor: float, longest: int = 3) -> BoolArray:
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
