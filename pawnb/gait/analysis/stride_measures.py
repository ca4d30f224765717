"""More measures of each stride: excursion, velocities in swing and stance, steps, body lengths.

Columns are added to the right of the stride table; see :data:`MEASURE_COLUMNS`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.gait.analysis.stride_drag import drag_fractions
from pawnb.gait.cycles.leg_signals import HEIGHT, LATERAL, LEG_ANGLE, LegSignals
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.legs import find_leg_place
from pawnb.gait.strides.stride_table import Motion
from pawnb.signals import differentiate

MEASURE_COLUMNS = (
    "speed_bl", "excursion", "excursion_deg", "swing_distance", "swing_velocity_deg_s",
    "stance_velocity_deg_s", "swing_peak_velocity_deg_s", "stance_peak_velocity_deg_s",
    "swing_peak_acceleration_deg_s2", "stance_peak_acceleration_deg_s2", "aep_lateral",
    "pep_lateral", "step_length", "step_width", "heading_deg", "heading_change_deg",
    "swing_height", "toe_clearance", "drag_fraction",
)  # fmt: skip
"""``speed_bl``: body lengths per second. ``excursion``: AEP minus PEP along forward in the
body's frame. ``excursion_deg``: leg angle at the next AEP minus at the PEP, the swing's (Pullar
2009, Fig. 4.8). ``swing_distance``: way of the foot over the ground in swing (Fig. 4.9 has the
tibia's; the body moves too). ``swing_velocity_deg_s``, ``stance_velocity_deg_s``: mean angular
velocity (Figs. 4.10, 4.11); ``..._peak_...``: the greatest in magnitude, with its sign.
``aep_lateral``, ``pep_lateral``: to the animal's right in the body's frame. ``step_length``,
``step_width``: from where the partner on the other side last landed to where this foot lands, along
and across the heading.
``heading_deg``: mean direction of the body, from the first axis of the positions towards the
second; ``heading_change_deg``: its turn over the stride. ``swing_height``: how high the foot is
lifted in swing, above its median height in the stance before; ``toe_clearance``: its least height
above that in the middle half of the swing, where a foot that drags is low. ``drag_fraction``: share
of the swing in which the foot moves on near the floor (:mod:`pawnb.gait.analysis.stride_drag`)."""


def measure_strides(
    strides: pd.DataFrame,
    *,
    motion: Mapping[str, Motion] | None = None,
    signals: Sequence[LegSignals] = (),
    body_length: float | None = None,
    settings: EventSettings | None = None,
) -> pd.DataFrame:
    """Add measures to the strides of one animal in one trial.

    Parameters
    ----------
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``, strides of one animal and trial.
    motion : mapping, optional
        Motion by the name of the leg.
    signals : sequence of LegSignals
        Leg angles and lateral positions of the legs, where known.
    body_length : float, optional
        Length of the body in the unit of the positions.
    settings : EventSettings, optional
        Settings of the analysis, which say when a foot is near the floor and moves.

    Returns
    -------
    pandas.DataFrame
        The strides with ``MEASURE_COLUMNS`` on the right; NaN where a measure cannot be told.
    """
    out = strides.reindex(columns=[*strides.columns, *MEASURE_COLUMNS])
    out[list(MEASURE_COLUMNS)] = out[list(MEASURE_COLUMNS)].astype(float)
    if strides.empty:
        return out
    if body_length is not None:
        out["speed_bl"] = out["speed"] / body_length
    out["excursion"] = out["aep_position"] - out["pep_position"]
    for leg, own in strides.groupby("leg", sort=False):
        name = str(leg)
        rows = own.index
        times = [own["start_s"], own["start_s"] + own["stance_s"], own["start_s"] + own["period_s"]]
        start, turn, end = (t.to_numpy(dtype=float) for t in times)
        moved = motion.get(name) if motion else None
        if moved is not None:
            out.loc[rows, "swing_distance"] = moved.foot_between(name, turn, end)
            heading, change = moved.heading_between(start, end)
            out.loc[rows, "heading_deg"], out.loc[rows, "heading_change_deg"] = heading, change
        for signal in signals:
            if name in signal.legs and signal.signal == LEG_ANGLE:
                found = _angular(signal, name, start, turn, end)
                out.loc[rows, list(found)] = pd.DataFrame(found, index=rows)
            if name in signal.legs and signal.signal == HEIGHT:
                found = _heights(signal, name, start, turn, end)
                out.loc[rows, list(found)] = pd.DataFrame(found, index=rows)
            if name in signal.legs and signal.signal == LATERAL:
                column = signal.samples[:, signal.legs.index(name)]
                out.loc[rows, "aep_lateral"] = np.interp(start, signal.time_s, column)
                out.loc[rows, "pep_lateral"] = np.interp(turn, signal.time_s, column)
    out["drag_fraction"] = drag_fractions(
        out, motion=motion, signals=signals, settings=settings or EventSettings()
    )
    return _with_steps(out, motion)


def _angular(
    signal: LegSignals, leg: str, start: FloatArray, turn: FloatArray, end: FloatArray
) -> dict[str, FloatArray]:
    """Return excursion, velocities and accelerations of one leg in swing and stance."""
    angle = signal.samples[:, signal.legs.index(leg)]
    speed = differentiate(angle, dt=signal.dt_s)
    change = differentiate(angle, dt=signal.dt_s, order=2)
    at = [np.interp(t, signal.time_s, angle) for t in (start, turn, end)]
    return {
        "excursion_deg": at[2] - at[1],
        "swing_velocity_deg_s": (at[2] - at[1]) / (end - turn),
        "stance_velocity_deg_s": (at[1] - at[0]) / (turn - start),
        "swing_peak_velocity_deg_s": _greatest(signal.time_s, speed, turn, end),
        "stance_peak_velocity_deg_s": _greatest(signal.time_s, speed, start, turn),
        "swing_peak_acceleration_deg_s2": _greatest(signal.time_s, change, turn, end),
        "stance_peak_acceleration_deg_s2": _greatest(signal.time_s, change, start, turn),
    }


def _heights(
    signal: LegSignals, leg: str, start: FloatArray, turn: FloatArray, end: FloatArray
) -> dict[str, FloatArray]:
    """Return how high a foot is lifted, and how low it is in the middle half of the swing."""
    height = signal.samples[:, signal.legs.index(leg)]
    lifted, clear = np.full(len(start), np.nan), np.full(len(start), np.nan)
    quarter = (end - turn) / 4.0
    times = (start, turn, end, turn + quarter, end - quarter)
    rows = np.searchsorted(signal.time_s, np.array(times)).T
    for i, (a, b, c, first, last) in enumerate(rows.tolist()):
        stance, swing, middle = height[a:b], height[b:c], height[first:last]
        if len(middle) and len(stance) and np.isfinite(swing).all() and np.isfinite(stance).all():
            ground = np.median(stance)
            lifted[i], clear[i] = swing.max() - ground, middle.min() - ground
    return {"swing_height": lifted, "toe_clearance": clear}


def _greatest(
    time_s: FloatArray, values: FloatArray, start: FloatArray, end: FloatArray
) -> FloatArray:
    """Return the value of greatest magnitude within each stretch; NaN where one is missing."""
    first = np.searchsorted(time_s, start, side="left")
    last = np.searchsorted(time_s, end, side="right")
    out = np.full(len(start), np.nan)
    for i, (a, b) in enumerate(zip(first, last, strict=True)):
        part = values[a:b]
        if len(part) and np.isfinite(part).all():
            out[i] = part[np.argmax(np.abs(part))]
    return out


def _with_steps(strides: pd.DataFrame, motion: Mapping[str, Motion] | None) -> pd.DataFrame:
    """Add step length and width: from the partner's last landing to this foot's."""
    if not motion:
        return strides
    by_place = {find_leg_place(str(leg)): str(leg) for leg in strides["leg"].unique()}
    for place, leg in by_place.items():
        if place is None:
            continue
        partner = by_place.get(place._replace(side="R" if place.side == "L" else "L"))
        moved = motion.get(leg)
        if partner is None or moved is None or motion.get(partner) is not moved:
            continue
        own, other = (strides[strides["leg"] == name] for name in (leg, partner))
        other = other.sort_values("start_s")
        landed = other["start_s"].to_numpy(dtype=float)
        start = own["start_s"].to_numpy(dtype=float)
        before = np.searchsorted(landed, start, side="left") - 1
        known = before >= 0
        # a partner that did not land within this stride's length has another rhythm
        known[known] &= (start - landed[before])[known] < own["period_s"].to_numpy()[known]
        here, there = start[known], landed[before[known]]
        rows = own.index[known]
        ahead = moved.place_of(leg, here) - moved.place_of(partner, there)
        strides.loc[rows, "step_length"] = ahead
        across = own["aep_lateral"].to_numpy(dtype=float)[known]
        other_across = other["aep_lateral"].to_numpy(dtype=float)[before[known]]
        strides.loc[rows, "step_width"] = np.abs(across - other_across)
    return strides
