"""Feet that lie on one place for a long time: one of them was tracked twice."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.kinematics import stride_frequency

_ON_ONE_PLACE = 0.15
"""Of how far feet move about their mean, RMS. Set by hand: a network that finds one paw twice puts
both labels within a pixel or two of it, where paws move by 75 px (26 RMS)."""
_BESIDE_STRIDES = 0.5
"""Part of a stride on either side over which labels that jitter are passed over: labels of one
network on one paw, each with a jitter of 1 px where paws move by 75, were never near throughout."""
_TOGETHER_STRIDES = 1.0
"""Feet that pass each other, or stand side by side, part again within a stride."""
_STEPPING = 0.5
"""Of how far feet move, from which on a foot steps. Set by hand."""
_TOGETHER_S = 0.2
"""Where no stride can be told."""


def say_on_one_place(feet: FootPaths, *, fs_hz: float) -> list[str]:
    """Say which two feet lie on one place for longer than a stride.

    Parameters
    ----------
    feet : FootPaths
        The feet, in one space.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    list of str
        One sentence for each such two feet.
    """
    places = feet.positions
    together = np.isfinite(places).all(axis=(1, 2))
    if not together.any() or len(feet.legs) < 2:
        return []
    about = places[together] - places[together].mean(axis=2, keepdims=True)
    moved = float(np.median(np.sqrt(about.var(axis=0).sum(axis=0))))
    frequency = stride_frequency(places, fs_hz=fs_hz)
    least_s = (
        _TOGETHER_STRIDES / frequency if math.isfinite(frequency) and frequency > 0 else _TOGETHER_S
    )
    beside = max(1, round(_BESIDE_STRIDES * least_s * fs_hz))
    notes = []
    for a, b in combinations(range(len(feet.legs)), 2):
        apart = np.linalg.norm(places[:, :, a] - places[:, :, b], axis=1)
        near = _middle(apart, beside) < _ON_ONE_PLACE * moved
        first, end = _longest_run(near)
        longest, own = end - first, places[first:end, :, a]
        # an animal that stands, seen from the side, may have its feet beside each other
        steps = longest > 0 and math.sqrt(np.nanvar(own, axis=0).sum()) > _STEPPING * moved
        if steps and longest >= least_s * fs_hz:
            known = np.isfinite(apart)
            share = int((near & known).sum()) / int(known.sum())
            notes.append(
                f"{feet.legs[a]} and {feet.legs[b]} ({feet.source}) lie on one place in "
                f"{share:.0%} of the time, {longest / fs_hz:.3g} s without a break: was one foot "
                "tracked as both? Its steps count as those of both there; unless these feet do "
                "step together, correct these frames or give them a low confidence."
            )
    return notes


def _middle(values: FloatArray, beside: int) -> FloatArray:
    """Return the median of each value and those beside it; infinite where most are missing."""
    filled = np.pad(np.where(np.isfinite(values), values, np.inf), beside, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(filled, 2 * beside + 1), axis=1)


def _longest_run(mask: BoolArray) -> tuple[int, int]:
    """Return the first and one past the last of most values in a row that are true."""
    edges = np.diff(np.concatenate([[0], mask.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    if not len(starts):
        return 0, 0
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k])
