"""From the tracked feet of one animal to events: the steps of the analysis in order.

A recording is put on a regular grid of samples; the feet of each space (calibrated
space, or one view's picture) get their body frame; each foot gives extremes and contacts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.events import (
    Contact,
    EventSettings,
    Extreme,
    Rejected,
    find_contacts,
    find_extremes,
    measure_height,
    stance_velocity,
)
from pawnb.gait.grid import Grid
from pawnb.gait.strides import Motion
from pawnb.kinematics import (
    BodyFrame,
    FootPaths,
    along,
    body_frame_from_points,
    body_frame_of_feet,
    image_facing,
    is_travelling,
    smooth_path,
    stride_frequency,
    swing_direction,
    travel_direction,
)
from pawnb.schema import DROPPED_COLUMNS, EVENTS_COLUMNS
from pawnb.signals import (
    butterworth_lowpass,
    differentiate,
    fill_gaps,
    find_jumps,
    find_runs,
    find_turns,
)
from pawnb.trial import Trial

EVENT_TABLE_COLUMNS = (*EVENTS_COLUMNS, "position")
_UNFILTERED_ABOVE = 0.35
_SLIP_ALLOWED = 0.15


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Cut-offs and times in use: as asked for, or set from the stride frequency.

    Parameters
    ----------
    cutoff_hz : float or None
        Low-pass for the feet; None for no filter.
    body_cutoff_hz : float
        Low-pass for the mean of the feet.
    max_gap_s, min_stance_s, min_swing_s : float
        Longest bridged gap, shortest stance and swing.
    """

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
    if cutoff is None and 10.0 * stride <= _UNFILTERED_ABOVE * fs_hz:
        cutoff = 10.0 * stride
    return Scales(
        cutoff_hz=cutoff,
        body_cutoff_hz=asked(settings.body_cutoff_hz, stride / 3.0),
        max_gap_s=asked(settings.max_gap_s, 0.1 / stride),
        min_stance_s=asked(settings.min_stance_s, 0.06 / stride),
        min_swing_s=asked(settings.min_swing_s, 0.06 / stride),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class SpaceResult:
    """Events of the feet seen in one space.

    Parameters
    ----------
    events, dropped, gaps : list of dict
        Rows of the tables (gaps: leg, start_s, end_s).
    motion : Motion
        Distance run by the body and by every foot.
    notes : list of str
        What a reader should know.
    """

    events: list[dict[str, Any]]
    dropped: list[dict[str, Any]]
    gaps: list[dict[str, Any]]
    motion: Motion
    notes: list[str]


def analyse_space(
    feet: FootPaths,
    grid: Grid,
    *,
    trial: Trial | None,
    belt: np.ndarray | None,
    body: np.ndarray | None,
    forward: np.ndarray | None,
    settings: EventSettings,
) -> SpaceResult:
    """Find the events of the feet that are seen in one space.

    Parameters
    ----------
    feet : FootPaths
        Positions on the grid.
    grid : Grid
        The samples.
    trial : Trial or None
        Description of the trial.
    belt : ndarray, shape (n,), or None
        Belt speed in the trial's unit per second; None where unknown.
    body : ndarray, shape (n, d, m), or None
        Points of the body, rear to front, where the trial names them.
    forward : ndarray, shape (d,), or None
        Direction stated by the caller.
    settings : EventSettings
        Settings.

    Returns
    -------
    SpaceResult
        Everything found, leg by leg.
    """
    notes: list[str] = []
    fs = grid.fs_hz
    feet, jumps = _without_jumps(feet, settings.jump_factor)
    up = _up(trial, feet)
    # first guess from the spectrum; it only has to find the path of the body
    frequency = stride_frequency(feet.positions, fs_hz=fs)
    guess = choose_scales(settings, frequency, fs)
    path = smooth_path(feet.positions, cutoff_hz=guess.body_cutoff_hz, fs_hz=fs)
    treadmill = settings.substrate == "treadmill"
    if settings.substrate == "auto":
        treadmill = belt is not None or not is_travelling(feet.positions, path)
    direction = _direction(feet, path, trial, forward, treadmill, fs, notes)
    frame = body_frame_of_feet(path, direction, treadmill=treadmill)
    frequency = _stepping_frequency(frame.fore_aft(feet.positions), settings, fs, frequency)
    scales = choose_scales(settings, frequency, fs)
    notes.append(_say_scales(feet, scales, frequency))
    if body is not None:
        frame = body_frame_from_points(body, cutoff_hz=scales.cutoff_hz, fs_hz=fs, up=up)
    else:
        path = smooth_path(feet.positions, cutoff_hz=scales.body_cutoff_hz, fs_hz=fs)
        frame = body_frame_of_feet(path, direction, treadmill=treadmill)
    max_gap = round(scales.max_gap_s * fs)
    raw = frame.fore_aft(feet.positions)
    position = _smooth(raw, scales.cutoff_hz, fs, max_gap)
    lab = _smooth(along(feet.positions, frame.forward), scales.cutoff_hz, fs, max_gap)
    extremes, rejected = _extremes_of_feet(position, fs, settings, scales)
    velocity = differentiate(lab, dt=1.0 / fs)
    belt_here = _belt(feet, velocity, extremes, belt, treadmill, notes)
    motion = _motion(feet, frame, lab, belt_here, grid)
    height = None
    if up is not None and settings.use_height:
        level = np.tile(up, (len(raw), 1))
        height = _smooth(along(feet.positions, level), scales.cutoff_hz, fs, max_gap)
    result = SpaceResult(events=[], dropped=[], gaps=[], motion=motion, notes=notes)
    for k, leg in enumerate(feet.legs):
        bridged = ~np.isfinite(raw[:, k])
        how = f"fore-aft position ({frame.method})"
        _add_extremes(result, leg, extremes[k], bridged, grid, how)
        _add_rejected(result, leg, rejected[k], grid)
        _add_jumps(result, leg, jumps[:, k], grid)
        _add_gaps(result, leg, position[:, k], grid, scales.max_gap_s)
        if belt_here is not None:
            foot_height = None if height is None else height[:, k]
            slip = _own_slip(velocity[:, k] + belt_here, extremes[k], belt_here)
            speed = velocity[:, k] + belt_here - slip
            found = _find_contacts(speed, foot_height, extremes[k], settings, _rise(scales, fs))
            _add_contacts(result, leg, *found, grid)
    return result


def _without_jumps(feet: FootPaths, factor: float | None) -> tuple[FootPaths, np.ndarray]:
    """Make positions missing that jump away and back; return also where they did."""
    jumps = np.zeros((len(feet.positions), len(feet.legs)), dtype=bool)
    if factor is None:
        return feet, jumps
    for k in range(len(feet.legs)):
        jumps[:, k] = find_jumps(feet.positions[:, :, k], factor=factor)
    kept = np.where(jumps[:, None, :], np.nan, feet.positions)
    return replace(feet, positions=kept), jumps


def _say_scales(feet: FootPaths, scales: Scales, frequency: float) -> str:
    """Put the scales of time in one sentence."""
    who = f"{', '.join(feet.legs)} ({feet.source})"
    if not math.isfinite(frequency):
        return f"{who}: no stride frequency found; times are set as for 1 Hz."
    low_pass = "unfiltered" if scales.cutoff_hz is None else f"low-pass {scales.cutoff_hz:.3g} Hz"
    return (
        f"{who}: about {frequency:.3g} strides a second; {low_pass}, gaps bridged up to "
        f"{scales.max_gap_s:.3g} s, stance at least {scales.min_stance_s:.3g} s, swing at "
        f"least {scales.min_swing_s:.3g} s."
    )


def _up(trial: Trial | None, feet: FootPaths) -> np.ndarray | None:
    """Return the unit vector upwards in calibrated space, None in a picture."""
    if feet.positions.shape[1] != 3:
        return None
    if trial is not None and trial.calibration is not None:
        return np.array(trial.calibration.up)
    return np.array([0.0, 0.0, 1.0])


def _direction(
    feet: FootPaths,
    path: np.ndarray,
    trial: Trial | None,
    forward: np.ndarray | None,
    treadmill: bool,
    fs: float,
    notes: list[str],
) -> np.ndarray:
    """Choose the direction towards the front, and say where it comes from."""
    n_dims = feet.positions.shape[1]
    who = f"{', '.join(feet.legs)} ({feet.source})"
    if forward is not None:
        if forward.shape != (n_dims,) or not np.linalg.norm(forward) > 0:
            raise InputError(
                f"forward is {forward.tolist()}; expected {n_dims} numbers that are not all zero."
            )
        return forward
    if not treadmill:
        direction, straight = travel_direction(path, up=_up(trial, feet))
        if straight < 0.9:
            notes.append(
                f"{who}: the path is not straight ({straight:.0%} of its length is progress); "
                "name points of the body in [animal] body for a heading that turns."
            )
        return direction
    from_feet = swing_direction(feet.positions, fs_hz=fs)
    facing = image_facing(trial, feet.source) if n_dims == 2 else None
    if n_dims == 3:
        calibration = trial.calibration if trial is not None else None
        stated = np.array(calibration.forward if calibration else (1.0, 0.0, 0.0))
    elif facing is not None:
        stated = np.array([float(facing), 0.0])
    else:
        notes.append(
            f"{who}: the animal faces {_say_direction(from_feet)}, told from the swing of its feet."
        )
        return from_feet
    if stated @ from_feet < -0.5:
        notes.append(
            f"{who}: the feet swing fastest backwards; is forward = {stated.tolist()} "
            "(or facing) the wrong way round?"
        )
    return stated


def _say_direction(direction: np.ndarray) -> str:
    """Name a direction in a picture."""
    if abs(direction[0]) >= abs(direction[1]):
        return "right" if direction[0] > 0 else "left"
    return "down" if direction[1] > 0 else "up"


def _smooth(x: np.ndarray, cutoff_hz: float | None, fs: float, max_gap: int) -> np.ndarray:
    """Bridge short gaps and, where there is a cut-off, low-pass."""
    if cutoff_hz is None:
        return fill_gaps(x, max_gap=max_gap)
    return butterworth_lowpass(x, cutoff_hz=cutoff_hz, fs_hz=fs, max_gap=max_gap)


def _least_excursion(position: np.ndarray, settings: EventSettings) -> float:
    """Return the least excursion between AEP and PEP of one foot; 0 if it was never seen."""
    if settings.min_excursion is not None or not np.isfinite(position).any():
        return settings.min_excursion or 0.0
    low, high = np.nanpercentile(position, [5, 95])
    return settings.min_excursion_fraction * float(high - low)


def _stepping_frequency(
    position: np.ndarray, settings: EventSettings, fs: float, guess: float
) -> float:
    """Count steps: the inverse of the median time between a foot's turns to the rear."""
    periods: list[float] = []
    for column in position.T:
        least = _least_excursion(column, settings)
        if least > 0.0:
            turns = find_turns(fill_gaps(column, max_gap=len(column)), min_excursion=least)
            periods += np.diff(turns[turns[:, 1] > 0, 0]).tolist()
    return fs / float(np.median(periods)) if periods else guess


def _extremes_of_feet(
    position: np.ndarray, fs: float, settings: EventSettings, scales: Scales
) -> tuple[list[list[Extreme]], list[list[Rejected]]]:
    """Find the extremes of every foot, each with its own least excursion."""
    extremes, rejected = [], []
    for column in position.T:
        least = _least_excursion(column, settings)
        if not least:
            found: tuple[list[Extreme], list[Rejected]] = ([], [])  # never seen, or never moved
        else:
            found = find_extremes(
                column,
                min_excursion=least,
                min_stance=scales.min_stance_s * fs,
                min_swing=scales.min_swing_s * fs,
            )
        extremes.append(found[0])
        rejected.append(found[1])
    return extremes, rejected


def _belt(
    feet: FootPaths,
    velocity: np.ndarray,
    extremes: list[list[Extreme]],
    belt: np.ndarray | None,
    treadmill: bool,
    notes: list[str],
) -> np.ndarray | None:
    """Return the speed of the substrate backwards, in the unit of the positions per second."""
    n = len(velocity)
    if not treadmill:
        return np.zeros(n)
    who = f"{', '.join(feet.legs)} ({feet.source})"
    stance = [stance_velocity(v, e) for v, e in zip(velocity.T, extremes, strict=True)]
    known = [s for s in stance if math.isfinite(s)]
    own = -float(np.median(known)) if known else math.nan
    if belt is not None:
        usual = float(np.median(belt))
        if not math.isfinite(own) or abs(own - usual) <= _SLIP_ALLOWED * abs(usual):
            return belt
        if feet.unit != "px":
            notes.append(
                f"{who}: feet in stance go backwards at {own:.4g} {feet.unit}/s where the belt "
                f"is said to run at {usual:.4g}; check belt_speed and its unit. Contact is told "
                "from the feet's own stance; speed and stride length use the stated belt speed."
            )
            return belt
    if not (math.isfinite(own) and own > 0):
        return None
    notes.append(
        f"{who}: belt speed {own:.4g} {feet.unit}/s, taken from the feet in stance because none "
        f"is known in {feet.unit}/s."
    )
    return np.full(n, own)


def _own_slip(speed: np.ndarray, extremes: list[Extreme], belt: np.ndarray) -> float:
    """Return the foot's speed in stance relative to the belt where that is too much to be slip."""
    slip = stance_velocity(speed, extremes)
    return slip if abs(slip) > _SLIP_ALLOWED * abs(float(np.median(belt))) > 0 else 0.0


def _motion(
    feet: FootPaths, frame: BodyFrame, lab: np.ndarray, belt: np.ndarray | None, grid: Grid
) -> Motion:
    """Sum up how far body and feet have come relative to the ground or belt."""
    steps = np.einsum("nd,nd->n", np.diff(frame.path, axis=0), frame.forward[:-1])
    if belt is None:
        unknown = np.full(len(lab), np.nan)
        return Motion(time_s=grid.time_s, body=unknown)
    rolled = np.concatenate(([0.0], np.cumsum((belt[1:] + belt[:-1]) / 2.0) / grid.fs_hz))
    known = np.isfinite(frame.path).all(axis=1)
    body = np.concatenate(([0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0)))) + rolled
    return Motion(
        time_s=grid.time_s,
        body=np.where(known, body, np.nan),
        feet={leg: lab[:, k] + rolled for k, leg in enumerate(feet.legs)},
    )


def _add_extremes(
    result: SpaceResult,
    leg: str,
    extremes: list[Extreme],
    bridged: np.ndarray,
    grid: Grid,
    how: str,
) -> None:
    """Add the AEP and PEP of a leg to the events."""
    for sample, kind, position in extremes:
        near = bridged[math.floor(sample) : math.ceil(sample) + 1].any()
        result.events.append(
            {
                "leg": leg,
                "event": "AEP" if kind > 0 else "PEP",
                "frame": grid.frame_at(sample),
                "time_s": grid.time_at(sample),
                "method": how + (", in a bridged gap" if near else ""),
                "position": position,
            }
        )


def _add_rejected(result: SpaceResult, leg: str, rejected: list[Rejected], grid: Grid) -> None:
    """Write down the pairs of extremes that were too close."""
    for start, end, why in rejected:
        span = {"start_s": grid.time_at(start), "end_s": grid.time_at(end)}
        result.dropped.append({"leg": leg, **span, "what": "AEP and PEP", "why": why})


def _add_jumps(result: SpaceResult, leg: str, jumps: np.ndarray, grid: Grid) -> None:
    """Write down positions that were left out because they jump."""
    for start, stop in find_runs(jumps):
        span = {"start_s": grid.time_at(start), "end_s": grid.time_at(stop - 1)}
        why = "jumps away and back (jump_factor)"
        result.dropped.append({"leg": leg, **span, "what": "position", "why": why})


def _add_gaps(
    result: SpaceResult, leg: str, position: np.ndarray, grid: Grid, max_gap_s: float
) -> None:
    """Write down the stretches in which a foot was not tracked."""
    for start, stop in find_runs(~np.isfinite(position)):
        span = {
            "start_s": grid.time_at(max(start - 1, 0)),
            "end_s": grid.time_at(min(stop, len(position) - 1)),
        }
        why = f"not tracked for {stop - start} frames; gaps are bridged up to {max_gap_s:.3g} s"
        if start == 0 or stop == len(position):
            why = f"not tracked for {stop - start} frames at the {'start' if start == 0 else 'end'}"
        result.gaps.append({"leg": leg, **span})
        result.dropped.append({"leg": leg, **span, "what": "track", "why": why})


def _rise(scales: Scales, fs: float) -> float:
    """Return how many samples filter and differences spread a step of the speed over.

    The inverse of the steepest slope of the step response: that of the filter is
    2.77 times its cut-off, that of central differences half a sample.
    """
    return max(2.0, 0.36 * fs / scales.cutoff_hz if scales.cutoff_hz is not None else 0.0)


def _find_contacts(
    speed: np.ndarray,
    height: np.ndarray | None,
    extremes: list[Extreme],
    settings: EventSettings,
    rise: float,
) -> tuple[list[Contact], str]:
    """Find TD and LO of a leg, and say by what."""
    known = None
    if height is not None:
        known = measure_height(height, extremes, fraction=settings.contact_height_fraction)
    contacts = find_contacts(
        speed, extremes, fraction=settings.contact_speed_fraction, rise=rise, height=known
    )
    return contacts, "foot speed" if known is None else "foot speed and height"


def _add_contacts(
    result: SpaceResult, leg: str, contacts: list[Contact], method: str, grid: Grid
) -> None:
    """Add the TD and LO of a leg to the events."""
    for sample, kind in contacts:
        result.events.append(
            {
                "leg": leg,
                "event": kind,
                "frame": grid.frame_at(sample),
                "time_s": grid.time_at(sample),
                "method": method,
                "position": math.nan,
            }
        )


def dropped_table(rows: list[dict[str, Any]], who: Mapping[str, str]) -> pd.DataFrame:
    """Make the table of what was dropped for one animal and trial.

    Parameters
    ----------
    rows : list of dict
        Leg, start_s, end_s, what, why.
    who : mapping
        Animal and trial.

    Returns
    -------
    pandas.DataFrame
        ``DROPPED_COLUMNS``.
    """
    return pd.DataFrame([{**who, **row} for row in rows], columns=list(DROPPED_COLUMNS))
