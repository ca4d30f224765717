"""Cut-offs and shortest times that follow the animal: set from its stride frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.signals import butterworth_lowpass, fill_gaps, fill_gaps_of_points, find_turns

_UNFILTERED_ABOVE = 0.35
"""No filter where its cut-off would be above this share of the sampling rate."""

_CUTOFF_STRIDES = 10.0
"""Low-pass of the feet, in stride frequencies."""

_FEWER = 0.9
"""Steps that a low-pass leaves by less than this share were jitter; periods are whole samples."""

_HELD = 0.1
"""Share of the movement of the feet on the whole below which a foot makes no steps."""


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Cut-offs and times in use: as asked for, or set from the stride frequency.

    Parameters
    ----------
    stride_hz : float
        Stride frequency that they are set from; 1 Hz where it is not known.
    cutoff_hz : float or None
        Low-pass for the feet; None for no filter.
    body_cutoff_hz : float
        Low-pass for the mean of the feet.
    max_gap_s, min_stance_s, min_swing_s : float
        Longest bridged gap, shortest stance and swing.
    """

    stride_hz: float
    cutoff_hz: float | None
    body_cutoff_hz: float
    max_gap_s: float
    min_stance_s: float
    min_swing_s: float


def choose_scales(settings: EventSettings, frequency_hz: float, fs_hz: float) -> Scales:
    """Set every scale of time that the settings leave to the animal.

    Parameters
    ----------
    settings : EventSettings
        What was asked for.
    frequency_hz : float
        Stride frequency; NaN where unknown, and then 1 Hz is assumed.
    fs_hz : float
        Sampling rate.

    Returns
    -------
    Scales
        The scales.
    """
    stride = frequency_hz if math.isfinite(frequency_hz) else 1.0

    def asked(value: float | None, default: float) -> float:
        return default if value is None else value

    cutoff = settings.cutoff_hz
    if cutoff is None and _CUTOFF_STRIDES * stride <= _UNFILTERED_ABOVE * fs_hz:
        cutoff = _CUTOFF_STRIDES * stride
    return Scales(
        stride_hz=stride,
        cutoff_hz=cutoff,
        body_cutoff_hz=asked(settings.body_cutoff_hz, stride / 3.0),
        max_gap_s=asked(settings.max_gap_s, 0.1 / stride),
        min_stance_s=asked(settings.min_stance_s, 0.06 / stride),
        min_swing_s=asked(settings.min_swing_s, 0.06 / stride),
    )


def say_scales(feet: FootPaths, scales: Scales, frequency: float) -> str:
    """Put the scales of time in one sentence.

    Parameters
    ----------
    feet : FootPaths
        The feet they are for.
    scales : Scales
        The scales in use.
    frequency : float
        Stride frequency they were set from, in Hz; NaN where unknown.

    Returns
    -------
    str
        A note.
    """
    who = feet.label
    if not math.isfinite(frequency):
        return f"{who}: no stride frequency found; times are set as for 1 Hz."
    low_pass = (
        "unfiltered, as too few frames make a stride for a low-pass of 10 times that"
        if scales.cutoff_hz is None
        else f"low-pass {scales.cutoff_hz:.3g} Hz"
    )
    return (
        f"{who}: about {frequency:.3g} strides a second; {low_pass}, gaps bridged up to "
        f"{scales.max_gap_s:.3g} s, stance at least {scales.min_stance_s:.3g} s, swing at "
        f"least {scales.min_swing_s:.3g} s."
    )


def least_excursion(position: FloatArray, settings: EventSettings) -> float:
    """Choose the least excursion between AEP and PEP of one foot.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Position along forward; NaN where missing.
    settings : EventSettings
        Settings.

    Returns
    -------
    float
        In the unit of ``position``; 0 for a foot that was never seen or never moved.
    """
    if settings.min_excursion is not None or not np.isfinite(position).any():
        return settings.min_excursion or 0.0
    return settings.min_excursion_fraction * _range_of(position)


def least_excursions(position: FloatArray, settings: EventSettings) -> FloatArray:
    """Choose the least excursion between AEP and PEP of each foot of an animal.

    Parameters
    ----------
    position : ndarray, shape (n, k)
        Positions along forward; NaN where missing.
    settings : EventSettings
        Settings.

    Returns
    -------
    ndarray, shape (k,)
        In the unit of ``position``; 0 for a foot that was never seen, that never moved, or that is
        held still where the others step: its turns are jitter. A least excursion that the settings
        state holds for all feet.
    """
    least = np.array([least_excursion(column, settings) for column in position.T])
    return np.where(held_still(position, settings), 0.0, least)


def held_still(position: FloatArray, settings: EventSettings) -> BoolArray:
    """Say which feet of an animal are held still where the others step.

    Parameters
    ----------
    position : ndarray, shape (n, k)
        Positions along forward; NaN where missing.
    settings : EventSettings
        Settings; where they state the least excursion, it tells what a step is.

    Returns
    -------
    ndarray of bool, shape (k,)
        True for feet that move by less than a tenth of what the feet do on the whole.
    """
    ranges = np.array([_range_of(column) for column in position.T])
    known = np.isfinite(ranges)
    if settings.min_excursion is not None or not known.any():
        return np.zeros(len(ranges), dtype=bool)
    return known & (ranges < _HELD * float(np.median(ranges[known])))


def say_held_still(feet: FootPaths, position: FloatArray, settings: EventSettings) -> list[str]:
    """Name the feet that are held still, of which no strides are made.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    position : ndarray, shape (n, k)
        Their positions along forward, or the angles of their legs.
    settings : EventSettings
        Settings.

    Returns
    -------
    list of str
        A note; none where all of them step.
    """
    held = held_still(position, settings)
    legs = [leg for leg, one in zip(feet.legs, held, strict=True) if one]
    if not legs:
        return []
    return [
        f"{', '.join(legs)} move{'s' * (len(legs) == 1)} by less than {_HELD:.0%} of what the feet "
        "do on the whole: held still, or another point than the foot was followed. No strides are "
        "made of that; min_excursion states what a step is."
    ]


def _range_of(position: FloatArray) -> float:
    """Return how far a foot moves, from the 5th to the 95th percentile; NaN if never seen."""
    if not np.isfinite(position).any():
        return math.nan
    low, high = np.nanpercentile(position, [5, 95])
    return float(high - low)


def without_jitter(positions: FloatArray, *, frequency_hz: float, fs_hz: float) -> FloatArray:
    """Return positions after the low-pass that a stride frequency asks for, gaps bridged.

    Parameters
    ----------
    positions : ndarray, shape (n, ...)
        Positions; NaN where missing.
    frequency_hz : float
        Stride frequency; where it is not known, gaps are bridged only.
    fs_hz : float
        Sampling rate.

    Returns
    -------
    ndarray
        Of the same shape.
    """
    fill = fill_gaps_of_points if positions.ndim == 3 else fill_gaps
    filled = fill(positions, max_gap=len(positions))
    if not 0.0 < frequency_hz < math.inf:
        return filled
    cutoff = min(_CUTOFF_STRIDES * frequency_hz, _UNFILTERED_ABOVE * fs_hz)
    return butterworth_lowpass(filled, cutoff_hz=cutoff, fs_hz=fs_hz)


def stepping_frequency(
    position: FloatArray, settings: EventSettings, *, fs_hz: float, guess: float
) -> float:
    """Count steps: the inverse of the median time between the AEP of a foot.

    The jitter of tracks makes turns of its own, and a low-pass set from their frequency would not
    take them away. So steps are counted again after the low-pass that their frequency asks for,
    until that takes none away. Where fewer are left after the low-pass that the guess asks for,
    and as many as the guess says, it is these.

    Parameters
    ----------
    position : ndarray, shape (n, k)
        Positions of the feet along forward, unfiltered.
    settings : EventSettings
        Settings.
    fs_hz : float
        Sampling rate.
    guess : float
        Stride frequency as the spectrum has it; returned where no foot turns twice.

    Returns
    -------
    float
        Stride frequency in Hz.
    """
    filled = fill_gaps(position, max_gap=len(position))

    def count_after(frequency: float) -> float:
        """Count steps after the low-pass that a stride frequency asks for."""
        smooth = without_jitter(filled, frequency_hz=frequency, fs_hz=fs_hz)
        return _turning_frequency(smooth, settings, fs_hz)

    frequency = _turning_frequency(filled, settings, fs_hz)
    if not math.isfinite(frequency):
        return guess
    while (slower := count_after(frequency)) < _FEWER * frequency:
        frequency = slower
    if 0.0 < guess < _FEWER * frequency:
        guessed = count_after(guess)
        if _FEWER <= guessed / guess <= 1.0 / _FEWER:
            return guessed
    return frequency


def _turning_frequency(position: FloatArray, settings: EventSettings, fs_hz: float) -> float:
    """Return the inverse of the median time between the AEP of a foot; NaN without any."""
    periods: list[float] = []
    columns = zip(position.T, least_excursions(position, settings), strict=True)
    for column, least in columns:
        if least > 0.0:
            turns = find_turns(column, min_excursion=least)
            periods += np.diff(turns[turns[:, 1] > 0, 0]).tolist()
    return fs_hz / float(np.median(periods)) if periods else math.nan
