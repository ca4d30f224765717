"""Extreme positions of each foot, and how fast it goes between them.

Kernels on arrays of one foot. Samples are equally spaced; times are fractional
samples, which the caller turns into frames and seconds. Touch-down and lift-off are in
:mod:`pawnb.gait.events.ground_contact`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.signals import find_turns, refine_extremum


class Extreme(NamedTuple):
    """An extreme position of a foot.

    Attributes
    ----------
    sample : float
        When, in fractional samples.
    kind : int
        +1 anterior (AEP), -1 posterior (PEP).
    position : float
        Where, along forward.
    """

    sample: float
    kind: int
    position: float


class Rejected(NamedTuple):
    """A pair of extremes that was taken out again.

    Attributes
    ----------
    start, end : float
        Fractional samples of the two.
    why : str
        The reason, in words.
    """

    start: float
    end: float
    why: str


def find_extremes(
    position: FloatArray, *, min_excursion: float, min_stance: float, min_swing: float
) -> tuple[list[Extreme], list[Rejected]]:
    """Find AEP and PEP in the fore-aft position of a foot.

    Turns of at least ``min_excursion`` on both sides are placed between samples by a
    parabola. Where a stance (AEP to PEP) or swing (PEP to AEP) is too short, the pair
    with the smallest excursion is taken out first; of its neighbours the further ones
    stay. Events alternate within every stretch without gap.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Position along forward; NaN where missing.
    min_excursion : float
        Least excursion, in the unit of ``position``.
    min_stance, min_swing : float
        Shortest stance and swing, in samples.

    Returns
    -------
    extremes : list of Extreme
        In order of time.
    rejected : list of Rejected
        What was too short.
    """
    extremes: list[Extreme] = []
    rejected: list[Rejected] = []
    turns = find_turns(position, min_excursion=min_excursion)
    missing = np.cumsum(~np.isfinite(position))
    for run in np.unique(missing[turns[:, 0]]):
        found = []
        for index, kind in turns[missing[turns[:, 0]] == run]:
            sample, value = refine_extremum(position, int(index))
            found.append(Extreme(sample, int(kind), value))
        kept, out = _remove_short(found, min_stance, min_swing)
        extremes += kept
        rejected += out
    return extremes, rejected


def _remove_short(
    found: list[Extreme], min_stance: float, min_swing: float
) -> tuple[list[Extreme], list[Rejected]]:
    """Take out pairs that follow each other too fast, smallest excursion first."""
    kept = list(found)
    out: list[Rejected] = []
    while True:
        short = [
            (abs(b.position - a.position), i)
            for i, (a, b) in enumerate(pairwise(kept))
            if b.sample - a.sample < (min_stance if a.kind > 0 else min_swing)
        ]
        if not short:
            return kept, out
        _, i = min(short)
        a, b = kept[i], kept[i + 1]
        what, least = ("stance", min_stance) if a.kind > 0 else ("swing", min_swing)
        lasted = b.sample - a.sample
        why = f"{what} of {lasted:.1f} frames is shorter than {least:.1f}"
        out.append(Rejected(a.sample, b.sample, why))
        before = kept[i - 1] if i > 0 else None
        after = kept[i + 2] if i + 2 < len(kept) else None
        if before is not None and b.kind * b.position > b.kind * before.position:
            kept[i - 1] = b
        if after is not None and a.kind * a.position > a.kind * after.position:
            kept[i + 2] = a
        del kept[i : i + 2]


def stance_velocity(velocity: FloatArray, extremes: Sequence[Extreme]) -> float:
    """Measure how fast a foot moves in the middle of its stances.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Velocity along forward.
    extremes : sequence of Extreme
        AEP and PEP in order.

    Returns
    -------
    float
        Median velocity over the middle half of every stance; NaN without a stance.
    """
    parts = [part for _, part in _mid_stances(velocity, extremes)]
    return float(np.median(np.concatenate(parts))) if parts else math.nan


def stance_velocity_over_time(velocity: FloatArray, extremes: Sequence[Extreme]) -> FloatArray:
    """Measure how fast a foot moves in stance, from stance to stance.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Velocity along forward.
    extremes : sequence of Extreme
        AEP and PEP in order.

    Returns
    -------
    ndarray, shape (n,)
        Median velocity over the middle half of each stance, straight lines between; NaN
        without a stance.
    """
    found = [(middle, float(np.median(part))) for middle, part in _mid_stances(velocity, extremes)]
    if not found:
        return np.full(len(velocity), np.nan)
    middles, medians = np.array(found).T
    return np.asarray(np.interp(np.arange(len(velocity)), middles, medians))


def _mid_stances(
    velocity: FloatArray, extremes: Sequence[Extreme]
) -> Iterator[tuple[float, FloatArray]]:
    """Yield the middle of each stance and the known velocities in its middle half."""
    for a, b in pairwise(extremes):
        if a.kind > 0 and b.kind < 0:
            quarter = (b.sample - a.sample) / 4.0
            first, last = math.ceil(a.sample + quarter), math.floor(b.sample - quarter)
            part = velocity[first : last + 1]
            part = part[np.isfinite(part)]
            if len(part):
                yield (a.sample + b.sample) / 2.0, part
