"""From the tracked feet of one animal to events: the steps of the analysis in order.

A recording is put on a regular grid of samples; the feet of each space (calibrated
space, or one view's picture) get their body frame; each foot gives extremes and contacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.cycles.leg_signals import HEIGHT, LATERAL, LEG_ANGLE, POSITION, LegSignals
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.events.extremes import Extreme, Rejected, find_extremes
from pawnb.gait.events.foot_speed import FootSpeed, sharpen_speed
from pawnb.gait.events.ground_contact import Contact, find_contacts, measure_height
from pawnb.gait.locomotion.body import BodyPoints, FoundBody, find_body
from pawnb.gait.locomotion.direction import find_up
from pawnb.gait.locomotion.displacement import displacement_along, measure_motion
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.grid import Grid
from pawnb.gait.locomotion.jitter import say_jitter
from pawnb.gait.locomotion.sides import place_across
from pawnb.gait.locomotion.substrate import find_belt_speed, speed_over_substrate
from pawnb.gait.locomotion.time_scales import Scales, least_excursions, say_held_still
from pawnb.gait.strides.stride_table import Motion
from pawnb.kinematics import along
from pawnb.schema import DROPPED_COLUMNS, EVENTS_COLUMNS
from pawnb.signals import (
    butterworth_lowpass,
    differentiate,
    fill_gaps,
    fill_gaps_of_points,
    find_jumps,
    find_runs,
)
from pawnb.trial import Trial

EVENT_TABLE_COLUMNS = (*EVENTS_COLUMNS, "position")


@dataclass(frozen=True, kw_only=True, eq=False)
class SpaceResult:
    """Events of the feet seen in one space.

    Parameters
    ----------
    events, dropped, gaps : list of dict
        Rows of the tables (gaps: leg, start_s, end_s, what).
    motion : Motion
        Distance run by the body and by every foot.
    notes : list of str
        What a reader should know.
    signals : list of LegSignals
        Leg angle (of jointed animals), position along forward in the body frame, and height
        (in 3D), smoothed.
    """

    events: list[dict[str, Any]]
    dropped: list[dict[str, Any]]
    gaps: list[dict[str, Any]]
    motion: Motion
    notes: list[str]
    signals: list[LegSignals]


def analyse_space(
    feet: FootPaths,
    grid: Grid,
    *,
    trial: Trial | None,
    belt: FloatArray | None,
    body: BodyPoints | None,
    others: FootPaths | None,
    forward: FloatArray | None,
    settings: EventSettings,
    who: Mapping[str, str],
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
    body : BodyPoints or None
        Points of the body, where they are named or can be guessed.
    others : FootPaths or None
        Tracked points that are no feet.
    forward : ndarray, shape (d,), or None
        Direction stated by the caller.
    settings : EventSettings
        Settings.
    who : mapping
        ``animal`` and ``trial``.

    Returns
    -------
    SpaceResult
        Everything found, leg by leg.
    """
    fs = grid.fs_hz
    feet, jumps = _without_jumps(feet, settings.jump_factor)
    up = find_up(trial, feet)
    found_body = find_body(
        feet, fs, trial=trial, belt=belt, body=body, others=others, forward=forward,
        settings=settings,
    )  # fmt: skip
    frame, scales, treadmill = found_body.frame, found_body.scales, found_body.treadmill
    smooth = _smoother(scales, fs)
    raw = frame.fore_aft(feet.positions)
    position, displacement = smooth(raw), displacement_along(smooth(feet.positions), frame.forward)
    turning, how = position, f"fore-aft position ({frame.method})"
    if feet.angle_deg is not None:
        turning, how = smooth(feet.angle_deg), "leg angle"
    extremes, rejected = _extremes_of_feet(turning, fs, settings, scales, found_body.standing)
    velocity = differentiate(displacement, dt=1.0 / fs)
    belt_here, said = find_belt_speed(feet, velocity, extremes, stated=belt, treadmill=treadmill)
    said = [*say_held_still(feet, turning, settings), *say_jitter(feet, raw, extremes), *said]
    motion = measure_motion(
        feet, frame, displacement=displacement, fore_aft=position, belt=belt_here, grid=grid
    )
    height = _height(feet, up, smooth) if settings.use_height else None
    across, sides = _across(found_body, feet, up, smooth)
    found = {
        LEG_ANGLE: None if feet.angle_deg is None else turning,
        POSITION: position, HEIGHT: height, LATERAL: across,
    }  # fmt: skip
    result = SpaceResult(
        events=[], dropped=[], gaps=[], motion=motion, notes=found_body.notes + said + sides,
        signals=_leg_signals(found, feet, grid, who),
    )  # fmt: skip
    is_guessed = treadmill and belt_here is not belt
    for k, leg in enumerate(feet.legs):
        bridged, where = ~np.isfinite(raw[:, k]), extremes[k]
        if feet.angle_deg is not None:
            where = _with_positions(where, position[:, k])
        _add_extremes(result, leg, where, bridged, grid, how)
        _add_left_out(result, leg, rejected[k], jumps[:, k], grid)
        _add_gaps(result, leg, position[:, k], grid, scales.max_gap_s)
        _add_pauses(result, leg, found_body.standing, grid)
        if belt_here is None:
            continue
        speed = speed_over_substrate(velocity[:, k], belt_here, where, follow=is_guessed)
        own = sharpen_speed(
            speed, velocity=velocity[:, k], displacement=displacement[:, k],
            height=None if height is None else height[:, k], fs_hz=fs, stride_hz=scales.stride_hz,
        )  # fmt: skip
        contacts = _find_contacts(own, where, settings, _filter_rise(scales, fs))
        _add_contacts(result, leg, *contacts, grid)
    return result


def _height(
    feet: FootPaths, up: FloatArray | None, smooth: Callable[[FloatArray], FloatArray]
) -> FloatArray | None:
    """Return how high feet are, where it is known which way is up."""
    if up is None:
        return None
    return smooth(along(feet.positions, np.tile(up, (len(feet.positions), 1))))


def _across(
    body: FoundBody,
    feet: FootPaths,
    up: FloatArray | None,
    smooth: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray | None, list[str]]:
    """Return how far feet are to the right, where right and left are known, and what is said."""
    if up is None and not body.from_points:
        return None, []
    across, notes = place_across(feet, body.frame, up=up)
    return smooth(across), notes


def _leg_signals(
    found: Mapping[str, FloatArray | None], feet: FootPaths, grid: Grid, who: Mapping[str, str]
) -> list[LegSignals]:
    """Return what was measured of all legs over time, as signals of their names and units."""
    return [
        LegSignals(
            **who, legs=feet.legs, time_s=grid.time_s, samples=samples, signal=name,
            unit="deg" if name == LEG_ANGLE else feet.unit,
        )
        for name, samples in found.items()
        if samples is not None
    ]  # fmt: skip


def _without_jumps(feet: FootPaths, factor: float | None) -> tuple[FootPaths, BoolArray]:
    """Make positions missing that jump away and back; return also where they did."""
    jumps = np.zeros((len(feet.positions), len(feet.legs)), dtype=bool)
    if factor is None:
        return feet, jumps
    for k in range(len(feet.legs)):
        jumps[:, k] = find_jumps(feet.positions[:, :, k], factor=factor)
    kept = np.where(jumps[:, None, :], np.nan, feet.positions)
    angle = None if feet.angle_deg is None else np.where(jumps, np.nan, feet.angle_deg)
    return replace(feet, positions=kept, angle_deg=angle), jumps


def _smoother(scales: Scales, fs: float) -> Callable[[FloatArray], FloatArray]:
    """Return what smooths a signal of the feet at these scales of time."""
    max_gap = round(scales.max_gap_s * fs)
    return partial(_smooth, cutoff_hz=scales.cutoff_hz, fs=fs, max_gap=max_gap)


def _smooth(x: FloatArray, cutoff_hz: float | None, fs: float, max_gap: int) -> FloatArray:
    """Bridge short gaps and, where there is a cut-off, low-pass."""
    fill = fill_gaps_of_points if x.ndim == 3 else fill_gaps
    filled = fill(x, max_gap=max_gap)
    return (
        filled if cutoff_hz is None else butterworth_lowpass(filled, cutoff_hz=cutoff_hz, fs_hz=fs)
    )


def _extremes_of_feet(
    position: FloatArray, fs: float, settings: EventSettings, scales: Scales, standing: BoolArray
) -> tuple[list[list[Extreme]], list[list[Rejected]]]:
    """Find the extremes of every foot where the animal goes, each with its own least excursion."""
    extremes, rejected = [], []
    going = np.where(standing[:, None], np.nan, position)
    for column, least in zip(going.T, least_excursions(going, settings), strict=True):
        found: tuple[list[Extreme], list[Rejected]]
        if not least:  # never seen, or held still
            found = [], []
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


def _with_positions(extremes: list[Extreme], position: FloatArray) -> list[Extreme]:
    """Return extremes with the foot's position along forward at their moments."""
    samples = np.arange(len(position))
    return [
        extreme._replace(position=float(np.interp(extreme.sample, samples, position)))
        for extreme in extremes
    ]


def _add_extremes(
    result: SpaceResult,
    leg: str,
    extremes: list[Extreme],
    bridged: BoolArray,
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


def _add_left_out(
    result: SpaceResult, leg: str, rejected: list[Rejected], jumps: BoolArray, grid: Grid
) -> None:
    """Write down the pairs of extremes that were too close, and positions that jump."""
    for start, end, why in rejected:
        span = {"start_s": grid.time_at(start), "end_s": grid.time_at(end)}
        result.dropped.append({"leg": leg, **span, "what": "AEP and PEP", "why": why})

    for start, stop in find_runs(jumps):
        span = {"start_s": grid.time_at(start), "end_s": grid.time_at(stop - 1)}
        why = "jumps away and back (jump_factor)"
        result.dropped.append({"leg": leg, **span, "what": "position", "why": why})


def _add_gaps(
    result: SpaceResult, leg: str, position: FloatArray, grid: Grid, max_gap_s: float
) -> None:
    """Write down the stretches in which a foot was not tracked."""
    for start, stop in find_runs(~np.isfinite(position)):
        span = {
            "start_s": grid.time_at(max(start - 1, 0)),
            "end_s": grid.time_at(min(stop, len(position) - 1)),
        }
        n = int(stop - start)
        why = f"not tracked for {n} frame{'s' * (n != 1)}"
        if start == 0 or stop == len(position):
            why += f" at the {'start' if start == 0 else 'end'}"
        else:
            why += f"; gaps are bridged up to {max_gap_s:.3g} s"
        result.gaps.append({"leg": leg, **span, "what": "not tracked"})
        result.dropped.append({"leg": leg, **span, "what": "track", "why": why})


def _add_pauses(result: SpaceResult, leg: str, standing: BoolArray, grid: Grid) -> None:
    """Write down where the animal stands: no stride may reach into it."""
    for start, stop in find_runs(standing):
        span = {"start_s": grid.time_at(start), "end_s": grid.time_at(stop - 1)}
        result.gaps.append({"leg": leg, **span, "what": "the animal stands or turns slowly"})
        why = "the animal stands or turns slowly (bouts)"
        result.dropped.append({"leg": leg, **span, "what": "pause", "why": why})


def _filter_rise(scales: Scales, fs: float) -> float:
    """Return how many samples the filter spreads a step of the speed over.

    The inverse of the steepest slope of its step response, which is 2.77 times its cut-off.
    """
    return 0.36 * fs / scales.cutoff_hz if scales.cutoff_hz is not None else 0.0


def _find_contacts(
    foot: FootSpeed, extremes: list[Extreme], settings: EventSettings, filter_rise: float
) -> tuple[list[Contact], str]:
    """Find TD and LO of a leg, and say by what."""
    known, finer = None, foot.finer
    extremes = [extreme._replace(sample=extreme.sample * finer) for extreme in extremes]
    if foot.height is not None:
        known = measure_height(foot.height, extremes, fraction=settings.contact_height_fraction)
    contacts = find_contacts(
        foot.speed,
        extremes,
        fraction=settings.contact_speed_fraction,
        rise=max(foot.spread, finer * filter_rise),
        height=known,
    )
    found = [contact._replace(sample=contact.sample / finer) for contact in contacts]
    return found, "foot speed" if known is None else "foot speed and height"


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
