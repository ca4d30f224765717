"""Strides from events: stance, swing, duty factor, length and speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from pawnb.gait.legs import sort_legs
from pawnb.schema import DROPPED_COLUMNS, STRIDES_COLUMNS

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
body frame along forward. ``contact_s``, ``contact_duty_factor``: from touch-down to
lift-off where the stride is counted from AEP and contact is known.
"""

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
        The same of each foot, by the name of its leg.
    """

    time_s: np.ndarray
    body: np.ndarray
    feet: Mapping[str, np.ndarray] = field(default_factory=dict)

    def body_between(self, start_s: float, end_s: float) -> float:
        """Return the distance run by the body between two times; NaN where not known."""
        return self._between(self.body, start_s, end_s)

    def foot_between(self, leg: str, start_s: float, end_s: float) -> float:
        """Return the distance a foot moved between two times; NaN where not known."""
        return self._between(self.feet[leg], start_s, end_s) if leg in self.feet else math.nan

    def _between(self, distance: np.ndarray, start_s: float, end_s: float) -> float:
        ends = np.interp([start_s, end_s], self.time_s, distance)
        return float(ends[1] - ends[0])


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


def build_strides(
    events: pd.DataFrame,
    *,
    start_event: str,
    motion: Mapping[str, Motion] | None = None,
    gaps: pd.DataFrame | None = None,
    max_stride_s: float | None = None,
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
        Stretches without track: leg, start_s, end_s. No stride may hold one.
    max_stride_s : float, optional
        Longer strides are dropped as pauses.

    Returns
    -------
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS`` and ``EXTRA_COLUMNS``; strides of a leg are counted from 1.
    dropped : pandas.DataFrame
        ``DROPPED_COLUMNS``.
    """
    rows: list[dict[str, Any]] = []
    dropped: list[dict[str, Any]] = []
    for leg in sort_legs(events["leg"]):
        own = events[events["leg"] == leg].sort_values("time_s", kind="stable")
        who = {"animal": own["animal"].iloc[0], "trial": own["trial"].iloc[0], "leg": leg}
        starts = own[own["event"] == start_event]
        middles = own[own["event"] == PARTNER[start_event]]
        number = 0
        for i in range(len(starts) - 1):
            first, last = starts.iloc[i], starts.iloc[i + 1]
            inside = middles[middles["time_s"].between(first["time_s"], last["time_s"])]
            why = _fault(first, last, inside, gaps, max_stride_s)
            if why is not None:
                span = {"start_s": first["time_s"], "end_s": last["time_s"]}
                dropped.append({**who, **span, "what": "stride", "why": why})
                continue
            number += 1
            times = _times(first, inside.iloc[0], last)
            moved = _distances(leg, times, motion.get(leg) if motion else None)
            contact = _contact(own, times) if start_event == "AEP" else {}
            method = {"method": f"{start_event}/{PARTNER[start_event]}"}
            rows.append({**who, "stride": number, **times, **moved, **method, **contact})
    strides = pd.DataFrame(rows, columns=[*STRIDES_COLUMNS, *EXTRA_COLUMNS])
    numbers = [c for c in strides.columns if c not in ("animal", "trial", "leg", "method")]
    strides[numbers] = strides[numbers].astype(float)
    strides["stride"] = strides["stride"].astype(int)
    return strides, pd.DataFrame(dropped, columns=list(DROPPED_COLUMNS))


def _fault(
    first: pd.Series,
    last: pd.Series,
    inside: pd.DataFrame,
    gaps: pd.DataFrame | None,
    max_stride_s: float | None,
) -> str | None:
    """Say why two successive events bound no stride, or None if they do."""
    start, end = float(first["time_s"]), float(last["time_s"])
    if gaps is not None:
        own = gaps[gaps["leg"] == first["leg"]]
        across = own[(own["end_s"] > start) & (own["start_s"] < end)]
        if len(across):
            longest = float((across["end_s"] - across["start_s"]).max())
            return f"not tracked for {longest:.3f} s in it"
    partner = PARTNER[str(first["event"])]
    if len(inside) != 1:
        found = f"no {partner}" if len(inside) == 0 else f"{len(inside)} {partner}"
        return f"{found} between two {first['event']}; expected one"
    if max_stride_s is not None and end - start > max_stride_s:
        return f"longer than {max_stride_s:g} s (max_stride_s)"
    return None


def _times(first: pd.Series, middle: pd.Series, last: pd.Series) -> dict[str, float]:
    """Return what the three events of a stride tell."""
    start, turn, end = (float(e["time_s"]) for e in (first, middle, last))
    period, stance = end - start, turn - start
    out = {
        "start_s": start,
        "period_s": period,
        "frequency_hz": 1.0 / period,
        "stance_s": stance,
        "swing_s": end - turn,
        "duty_factor": stance / period,
    }
    if "position" in first.index and first["event"] == "AEP":
        out["aep_position"] = float(first["position"])
        out["pep_position"] = float(middle["position"])
    return out


def _distances(leg: str, times: Mapping[str, float], motion: Motion | None) -> dict[str, float]:
    """Return stride length, speed, and the foot's own displacement, where motion is known."""
    if motion is None:
        return {}
    start, end = times["start_s"], times["start_s"] + times["period_s"]
    length = motion.body_between(start, end)
    return {
        "stride_length": length,
        "speed": length / times["period_s"],
        "step_displacement": motion.foot_between(leg, start, end),
    }


def _contact(own: pd.DataFrame, times: Mapping[str, float]) -> dict[str, float]:
    """Return the contact that belongs to a stance from AEP to PEP.

    It is the touch-down nearest before the middle of the stance (but after the middle of
    the swing before) to the next lift-off, which must come before the next swing's middle.
    """
    middle = times["start_s"] + times["stance_s"] / 2.0
    down = own.loc[(own["event"] == "TD") & (own["time_s"] <= middle), "time_s"]
    up = own.loc[(own["event"] == "LO") & (own["time_s"] > middle), "time_s"]
    if down.empty or up.empty:
        return {}
    contact = float(up.min() - down.max())
    if not 0.0 < contact < times["period_s"]:
        return {}
    return {"contact_s": contact, "contact_duty_factor": contact / times["period_s"]}
