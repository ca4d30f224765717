"""Strides from events: stance, swing, duty factor, length and speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.legs import sort_legs
from pawnb.schema import DROPPED_COLUMNS, STRIDES_COLUMNS, check_columns
from pawnb.schema.arguments import checked_arguments

EXTRA_COLUMNS = (
    "step_displacement",
    "method",
    "aep_position",
    "pep_position",
    "contact_s",
    "contact_duty_factor",
)
"""Columns of the stride table beyond those of the contract.

``step_displacement``: how far the foot moved over ground or belt. ``method``: the events
that bound stance and stride, AEP/PEP or TD/LO. ``aep_position``, ``pep_position``: in the
body frame along forward, from the mean of the named body points, or else from the mean place of the
feet in the recording. ``contact_s``, ``contact_duty_factor``: from touch-down to
lift-off where the stride is counted from AEP and contact is known.
"""

TRIAL_KEYS = ["animal", "trial"]
"""Columns that name one recording in every table of gait."""
PARTNER = {"AEP": "PEP", "TD": "LO"}
"""The event that ends the stance which each event begins."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """How far body and feet have come relative to the ground or belt.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Times of the samples.
    body : ndarray, shape (n,)
        Distance run by the body along forward, from an arbitrary zero.
    feet : mapping
        The same of each foot, by the name of its leg, from zeros of their own.
    places : mapping
        Where each foot is along the body's way, all from the zero of the body.
    heading_deg : ndarray, shape (n,), optional
        Direction of the body, not wrapped, from the first axis of the positions towards the
        second.
    """

    time_s: FloatArray
    body: FloatArray
    feet: Mapping[str, FloatArray] = field(default_factory=dict)
    places: Mapping[str, FloatArray] = field(default_factory=dict)
    heading_deg: FloatArray | None = None

    def body_between(self, start_s: FloatArray, end_s: FloatArray) -> FloatArray:
        """Return the distances run by the body between pairs of times; NaN where not known."""
        return self._between(self.body, start_s, end_s)

    def foot_between(self, leg: str, start_s: FloatArray, end_s: FloatArray) -> FloatArray:
        """Return the distances a foot moved between pairs of times; NaN where not known.

        Parameters
        ----------
        leg : str
            The leg.
        start_s, end_s : ndarray, shape (n,)
            Pairs of times, s.

        Returns
        -------
        ndarray, shape (n,)
            Distances, in the unit of the positions.
        """
        if leg not in self.feet:
            return np.full(len(start_s), np.nan)
        return self._between(self.feet[leg], start_s, end_s)

    def place_of(self, leg: str, time_s: FloatArray) -> FloatArray:
        """Return how far along the body's way a foot is at some times; NaN where not known."""
        if leg not in self.places:
            return np.full(len(time_s), np.nan)
        return np.interp(time_s, self.time_s, self.places[leg])

    def heading_between(
        self, start_s: FloatArray, end_s: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean heading in [-180, 180) and its change between pairs of times, degrees."""
        if self.heading_deg is None:
            unknown = np.full(len(start_s), np.nan)
            return unknown, unknown
        ends = [np.interp(t, self.time_s, self.heading_deg) for t in (start_s, end_s)]
        middle = (ends[0] + ends[1]) / 2.0
        return (middle + 180.0) % 360.0 - 180.0, ends[1] - ends[0]

    def _between(self, distance: FloatArray, start_s: FloatArray, end_s: FloatArray) -> FloatArray:
        ends = np.interp(end_s, self.time_s, distance)
        return ends - np.interp(start_s, self.time_s, distance)


@checked_arguments
def choose_stride_event(events: pd.DataFrame, wanted: str) -> str:
    """Choose the event from which strides are counted.

    Parameters
    ----------
    events : pandas.DataFrame
        Events, with a column ``event``.
    wanted : {"auto", "AEP", "TD"}
        Setting ``stride_events``.

    Returns
    -------
    str
        ``"AEP"`` or ``"TD"``; on ``auto`` AEP where there is any.
    """
    if wanted != "auto":
        return wanted
    return "AEP" if (events["event"] == "AEP").any() else "TD"


@checked_arguments
def build_strides(
    events: pd.DataFrame,
    *,
    start_event: str,
    motion: Mapping[str, Motion] | None = None,
    gaps: pd.DataFrame | None = None,
    max_stride_s: float | None = None,
    excluded: pd.DataFrame | None = None,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Build the strides of one animal in one trial.

    A stride runs from one AEP (TD) to the next of the same leg and needs exactly one
    PEP (LO) between them. Whatever is not a stride is in the second table with its reason.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial, columns ``EVENTS_COLUMNS`` and optionally
        ``position`` (along forward in the body frame).
    start_event : {"AEP", "TD"}
        Event that begins a stride.
    motion : mapping, optional
        Motion by the name of the leg; without it lengths and speeds are NaN.
    gaps : pandas.DataFrame, optional
        Stretches that no stride may hold: leg, start_s, end_s, and optionally ``what`` (what
        the reason says of them; default "not tracked").
    max_stride_s : float, optional
        Longer strides are dropped as pauses.
    excluded : pandas.DataFrame, optional
        Strides that shall not count: leg, time_s (any time within the stride) and why.

    Returns
    -------
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS`` and ``EXTRA_COLUMNS``; strides of a leg are counted from 1.
    dropped : pandas.DataFrame
        ``DROPPED_COLUMNS``.
    """
    check_columns(events, ("animal", "trial", "leg", "event", "time_s"), where="events")
    parts: list[pd.DataFrame] = []
    dropped: list[dict[str, Any]] = []
    for leg in sort_legs(events["leg"]):
        own = events[events["leg"] == leg].sort_values("time_s", kind="stable")
        who = {"animal": own["animal"].iloc[0], "trial": own["trial"].iloc[0], "leg": leg}
        spans = _spans(own, start_event)
        fault = _faults(spans, _gaps_of(gaps, leg), start_event, max_stride_s)
        if excluded is not None:
            for no in excluded[excluded["leg"] == leg].itertuples():
                fault[(spans.start_s < no.time_s) & (no.time_s < spans.end_s)] = no.why
        for i in np.flatnonzero(fault != ""):
            span = {"start_s": spans.start_s[i], "end_s": spans.end_s[i]}
            dropped.append({**who, **span, "what": "stride", "why": str(fault[i])})
        good = spans.take(fault == "")
        columns = _times(good)
        if "position" in own and start_event == "AEP":
            columns |= {"aep_position": good.first_position, "pep_position": good.turn_position}
        columns |= _distances(leg, good, motion.get(leg) if motion else None)
        if start_event == "AEP":
            columns |= _contact(own, good)
        method = f"{start_event}/{PARTNER[start_event]}"
        number = np.arange(1, len(good.start_s) + 1)
        row = {**who, "stride": number, **columns, "method": method}
        parts.append(pd.DataFrame(row, index=number))
    names = [*STRIDES_COLUMNS, *EXTRA_COLUMNS]
    parts = [part.reindex(columns=names) for part in parts if len(part)]
    strides = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=names)
    numbers = [c for c in names if c not in ("animal", "trial", "leg", "method")]
    strides[numbers] = strides[numbers].astype(float)
    strides["stride"] = strides["stride"].astype(int)
    return strides, pd.DataFrame(dropped, columns=list(DROPPED_COLUMNS))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Spans:
    """Stretches from one starting event of a leg to the next: n of each.

    ``turns`` counts the partner's events within; ``turn_s`` and ``turn_position`` are of the
    first of them (NaN where there is none).
    """

    start_s: np.ndarray
    end_s: np.ndarray
    turns: np.ndarray
    turn_s: FloatArray
    first_position: FloatArray
    turn_position: FloatArray

    def take(self, which: BoolArray) -> _Spans:
        """Return some of the stretches."""
        return _Spans(**{name: values[which] for name, values in vars(self).items()})


def _spans(own: pd.DataFrame, start_event: str) -> _Spans:
    """Return the stretches between the starting events of one leg."""
    time = own["time_s"].to_numpy(dtype=float)
    position = (
        own["position"].to_numpy(dtype=float) if "position" in own else np.full(len(own), np.nan)
    )
    starts = (own["event"] == start_event).to_numpy()
    middles = (own["event"] == PARTNER[start_event]).to_numpy()
    start, middle = time[starts], time[middles]
    if len(start) < 2:
        none = np.empty(0)
        return _Spans(
            start_s=none, end_s=none, turns=none, turn_s=none, first_position=none,
            turn_position=none,
        )  # fmt: skip
    first = np.searchsorted(middle, start[:-1], side="left")
    turns = np.searchsorted(middle, start[1:], side="right") - first
    known = turns > 0
    at = np.minimum(first, max(len(middle) - 1, 0))

    def of_turn(values: FloatArray) -> FloatArray:
        return np.where(known, values[at], np.nan) if len(middle) else np.full(len(at), np.nan)

    return _Spans(
        start_s=start[:-1],
        end_s=start[1:],
        turns=turns,
        turn_s=of_turn(middle),
        first_position=position[starts][:-1],
        turn_position=of_turn(position[middles]),
    )


def _gaps_of(gaps: pd.DataFrame | None, leg: str) -> dict[str, FloatArray]:
    """Return start and end of the gaps of one leg, shape (k, 2), by what they are."""
    if gaps is None:
        return {}
    own = gaps[gaps["leg"] == leg]
    what = own["what"] if "what" in own else pd.Series("not tracked", index=own.index)
    return {
        str(name): part[["start_s", "end_s"]].to_numpy(dtype=float)
        for name, part in own.groupby(what)
    }


def _faults(
    spans: _Spans, gaps: dict[str, FloatArray], start_event: str, max_stride_s: float | None
) -> np.ndarray:
    """Say of each stretch why it is no stride; empty text where it is one."""
    why = np.full(len(spans.start_s), "", dtype=object)
    if max_stride_s is not None:
        long = spans.end_s - spans.start_s > max_stride_s
        why[long] = f"longer than {max_stride_s:g} s (max_stride_s)"
    partner = PARTNER[start_event]
    for i in np.flatnonzero(spans.turns != 1):
        found = f"{spans.turns[i]:.0f} {partner}" if spans.turns[i] else f"no {partner}"
        why[i] = f"{found} between two {start_event}; expected one"
    for what, stretches in gaps.items():
        longest = np.zeros(len(why))
        for start, end in stretches:
            across = (end > spans.start_s) & (start < spans.end_s)
            longest[across] = np.maximum(longest[across], end - start)
        for i in np.flatnonzero(longest):
            why[i] = f"{what} for {longest[i]:.3f} s in it"
    return why


def _times(spans: _Spans) -> dict[str, FloatArray]:
    """Return what the three events of each stride tell."""
    period, stance = spans.end_s - spans.start_s, spans.turn_s - spans.start_s
    return {
        "start_s": spans.start_s,
        "period_s": period,
        "frequency_hz": 1.0 / period,
        "stance_s": stance,
        "swing_s": spans.end_s - spans.turn_s,
        "duty_factor": stance / period,
    }


def _distances(leg: str, spans: _Spans, motion: Motion | None) -> dict[str, FloatArray]:
    """Return stride length, speed, and the foot's own displacement, where motion is known."""
    if motion is None:
        return {}
    length = motion.body_between(spans.start_s, spans.end_s)
    return {
        "stride_length": length,
        "speed": length / (spans.end_s - spans.start_s),
        "step_displacement": motion.foot_between(leg, spans.start_s, spans.end_s),
    }


def _contact(own: pd.DataFrame, spans: _Spans) -> dict[str, FloatArray]:
    """Return the contact that belongs to each stance from AEP to PEP.

    It is the touch-down nearest before the middle of the stance (but after the middle of
    the swing before) to the next lift-off, which must come before the next swing's middle.
    """
    down = own.loc[own["event"] == "TD", "time_s"].to_numpy(dtype=float)
    up = own.loc[own["event"] == "LO", "time_s"].to_numpy(dtype=float)
    middle = (spans.start_s + spans.turn_s) / 2.0
    landed = np.searchsorted(down, middle, side="right") - 1
    lifted = np.searchsorted(up, middle, side="right")
    known = (landed >= 0) & (lifted < len(up))
    contact = np.full(len(middle), np.nan)
    contact[known] = up[lifted[known]] - down[landed[known]]
    period = spans.end_s - spans.start_s
    contact[~((contact > 0.0) & (contact < period))] = np.nan
    return {"contact_s": contact, "contact_duty_factor": contact / period}
