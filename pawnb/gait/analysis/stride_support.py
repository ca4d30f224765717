"""Feet on the ground and static stability, stride by stride.

Columns are added to the right of the stride table; see :data:`SUPPORT_MEASURES`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.cycles.leg_signals import LATERAL, POSITION, LegSignals
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.gait.support import static_stability, wave_gait_margin, whole_stretches

SUPPORT_MEASURES = (
    "feet_down", "wave_gait_margin", "support_area", "stability_margin", "longitudinal_margin",
    "stable_share",
)  # fmt: skip
"""``feet_down``: mean number of feet on the ground over the stride. ``wave_gait_margin``:
longitudinal stability margin of a wave gait with this duty factor, in stride lengths (Pullar 2009,
appendix A), for four legs and more. Where the feet are known in a plane: ``support_area``, mean
area of the polygon of the feet that are down; ``stability_margin`` and ``longitudinal_margin``,
the least over the stride, distance of the body's centre to the edge of the polygon, in any
direction and along the heading (negative: outside); ``stable_share``, share of the stride in which
the centre is inside. The centre is the middle between the mean places of the feet of the first and
of the last pair of legs, which is where the body lies within its steps."""

_PHASES = (np.arange(20) + 0.5) / 20.0


def measure_support(
    strides: pd.DataFrame, events: pd.DataFrame, *, signals: Sequence[LegSignals] = ()
) -> pd.DataFrame:
    """Add feet on the ground and static stability to the strides of one animal in one trial.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of one animal and trial.
    events : pandas.DataFrame
        Their events: TD and LO where there are any, else AEP and PEP.
    signals : sequence of LegSignals
        Positions of the legs along and across the heading, where known.

    Returns
    -------
    pandas.DataFrame
        The strides with ``SUPPORT_MEASURES`` on the right, from 20 moments of each stride. NaN
        in strides in which the state of a leg is not known throughout.
    """
    out = strides.reindex(columns=[*strides.columns, *SUPPORT_MEASURES])
    out[list(SUPPORT_MEASURES)] = out[list(SUPPORT_MEASURES)].astype(float)
    if strides.empty:
        return out
    legs = sort_legs(events["leg"])
    if len(legs) >= 4:
        duty = strides["duty_factor"].to_numpy(dtype=float)
        out["wave_gait_margin"] = wave_gait_margin(duty, n_legs=len(legs))
    start, period = (strides[name].to_numpy(dtype=float) for name in ("start_s", "period_s"))
    times = start[:, None] + period[:, None] * _PHASES
    whole = _within(start, start + period, whole_stretches(events, strides))
    if not whole.any():
        return out
    down = _states(events, legs, times[whole])
    rows = out.index[whole]
    out.loc[rows, "feet_down"] = down.sum(axis=2).mean(axis=1)
    feet = _places(legs, signals, times[whole])
    if feet is not None:
        for name, values in _stability(feet, down, legs).items():
            out.loc[rows, name] = values
    return out


def _within(start: FloatArray, end: FloatArray, stretches: pd.DataFrame) -> BoolArray:
    """Say of each stride whether it lies in one of the stretches."""
    first, last = (stretches[name].to_numpy(dtype=float) for name in ("start_s", "end_s"))
    at = np.searchsorted(first, start + 1e-6, side="right") - 1
    inside = at >= 0
    inside[inside] = end[inside] <= last[at[inside]] + 1e-6
    return inside


def _states(events: pd.DataFrame, legs: Sequence[str], times: FloatArray) -> BoolArray:
    """Return which feet are down, shape (n, m, k)."""
    contact = events["event"].isin(("TD", "LO")).any()
    begin, end = ("TD", "LO") if contact else ("AEP", "PEP")
    down = np.zeros((*times.shape, len(legs)), dtype=bool)
    for k, leg in enumerate(legs):
        own = events[(events["leg"] == leg) & events["event"].isin((begin, end))]
        own = own.sort_values("time_s", kind="stable")
        begins = (own["event"] == begin).to_numpy()
        if len(begins):
            at = np.searchsorted(own["time_s"].to_numpy(dtype=float), times, side="right") - 1
            down[..., k] = np.where(at >= 0, begins[np.maximum(at, 0)], ~begins[0])
    return down


def _places(
    legs: Sequence[str], signals: Sequence[LegSignals], times: FloatArray
) -> FloatArray | None:
    """Return places of the feet along and across the heading, shape (n, m, k, 2)."""
    feet = np.full((*times.shape, len(legs), 2), np.nan)
    for axis, kind in enumerate((POSITION, LATERAL)):
        for signal in (one for one in signals if one.signal == kind):
            for k, leg in enumerate(legs):
                if leg in signal.legs:
                    column = signal.samples[:, signal.legs.index(leg)]
                    feet[..., k, axis] = np.interp(times, signal.time_s, column)
    known = np.isfinite(feet).any(axis=(0, 1))
    return feet if known.all() and len(legs) >= 4 else None


def _stability(feet: FloatArray, down: BoolArray, legs: Sequence[str]) -> dict[str, FloatArray]:
    """Return the measures of the support polygon, stride by stride."""
    n, m, k, _ = feet.shape
    ranks = np.array([place.rank if (place := find_leg_place(leg)) else 0 for leg in legs])
    mean = np.nanmean(feet, axis=(0, 1))
    ends = [mean[ranks == rank].mean(axis=0) for rank in (ranks.min(), ranks.max())]
    centre = np.broadcast_to((ends[0] + ends[1]) / 2.0, (n * m, 2))
    forward = np.broadcast_to([1.0, 0.0], (n * m, 2))
    found = static_stability(
        feet.reshape(-1, k, 2), down.reshape(-1, k), centre, forward=np.array(forward)
    )
    margin, along = found.margin.reshape(n, m), found.longitudinal_margin.reshape(n, m)
    # with fewer than three feet down, and beside the polygon, there is no margin
    least = [
        np.where(np.isfinite(one).any(axis=1), np.nanmin(np.where(np.isfinite(one), one, np.inf),
                                                         axis=1), np.nan)
        for one in (margin, along)
    ]  # fmt: skip
    return {
        "support_area": found.area.reshape(n, m).mean(axis=1),
        "stability_margin": least[0],
        "longitudinal_margin": least[1],
        "stable_share": (margin > 0.0).mean(axis=1),
    }
