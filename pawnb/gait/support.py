"""Feet on the ground: how many, whether they support the body, and in which order they land."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import ConvexHull, QhullError

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import find_runs

_TRIAL = ["animal", "trial"]
SUPPORT_COLUMNS = ("animal", "trial", "start_s", "end_s", "n_down", "legs")

_NORMAL_SEQUENCES = {
    "Ca": ("FR", "FL", "HR", "HL"),
    "Cb": ("FL", "FR", "HL", "HR"),
    "Aa": ("FR", "HR", "FL", "HL"),
    "Ab": ("FL", "HR", "FR", "HL"),
    "Ra": ("FR", "FL", "HL", "HR"),
    "Rb": ("FL", "FR", "HR", "HL"),
}
"""Normal step sequences of four legs (cruciate, alternate, rotary): Cheng et al. 1997."""


@checked_arguments
def wave_gait_margin(duty_factor: FloatArray | float, *, n_legs: int) -> FloatArray | float:
    """Compute the longitudinal stability margin of a wave gait from its duty factor.

    ``S = n/4 * duty - 3/4`` in units of the stride length (Pullar 2009, appendix A, after Ting
    et al. 1994); below 0 the animal is statically unstable: under a duty factor of 0.375 with
    eight legs, 0.5 with six, 0.75 with four.

    Parameters
    ----------
    duty_factor : float or ndarray
        Duty factor, 0 to 1.
    n_legs : int
        Number of legs, 4 or more.

    Returns
    -------
    float or ndarray
        The margin.

    Raises
    ------
    InputError
        If the duty factor is not between 0 and 1 or there are fewer than 4 legs.
    """
    duty = np.asarray(duty_factor, dtype=float)
    if n_legs < 4:
        raise InputError(f"n_legs is {n_legs}; a wave gait needs four legs or more.")
    known = duty[np.isfinite(duty)]
    if ((known < 0) | (known > 1)).any():
        raise InputError("duty factors lie between 0 and 1; are these percent?")
    return n_legs / 4.0 * duty_factor - 0.75


class Stability(NamedTuple):
    """Static stability sample by sample.

    Attributes
    ----------
    n_down : ndarray of int, shape (n,)
        Feet on the ground.
    area : ndarray, shape (n,)
        Area of the support polygon; 0 with fewer than three feet down.
    margin : ndarray, shape (n,)
        Least distance of the centre to an edge of the polygon: positive inside (statically
        stable), negative outside; NaN with fewer than three feet down.
    longitudinal_margin : ndarray, shape (n,)
        The shorter of the ways forward and backward along the heading to the edge of the
        polygon (Ting et al. 1994); negative where the centre is outside, NaN where the line
        along the heading misses the polygon or fewer than three feet are down.
    """

    n_down: IntArray
    area: FloatArray
    margin: FloatArray
    longitudinal_margin: FloatArray


@checked_arguments
def static_stability(
    feet: FloatArray, down: BoolArray, centre: FloatArray, *, forward: FloatArray
) -> Stability:
    """Measure the support polygon and how far inside it the centre of the body lies.

    Parameters
    ----------
    feet : ndarray, shape (n, k, 2)
        Places of the feet in the plane of the ground.
    down : ndarray of bool, shape (n, k)
        Which of them are on the ground.
    centre : ndarray, shape (n, 2)
        Centre of the body (of mass, where it is known) in the same plane.
    forward : ndarray, shape (n, 2)
        Heading.

    Returns
    -------
    Stability
        In the unit of the feet; samples in which a foot that is down has no place count as if
        it were not.

    Raises
    ------
    InputError
        If the shapes do not belong together.
    """
    n = len(feet)
    if down.shape != feet.shape[:2] or centre.shape != (n, 2) or forward.shape != (n, 2):
        raise InputError(
            f"shapes do not fit: feet {feet.shape}, down {down.shape}, centre {centre.shape}, "
            f"forward {forward.shape}; expected (n, k, 2), (n, k), (n, 2), (n, 2)."
        )
    used = down & np.isfinite(feet).all(axis=2)
    area, margin, along = np.zeros(n), np.full(n, np.nan), np.full(n, np.nan)
    for i in np.flatnonzero(used.sum(axis=1) >= 3):
        try:
            hull = ConvexHull(feet[i, used[i]])
        except QhullError:  # the feet lie on one line
            continue
        area[i] = hull.volume  # of a polygon: its area
        normals, offsets = hull.equations[:, :2], hull.equations[:, 2]
        depth = -(normals @ centre[i] + offsets)
        margin[i] = depth.min()
        along[i] = _way_to_edge(depth, normals @ (forward[i] / np.linalg.norm(forward[i])))
    return Stability(used.sum(axis=1), area, margin, along)


def _way_to_edge(depth: FloatArray, slope: FloatArray) -> float:
    """Return the shorter way along the heading to the edge, from depths below each edge."""
    ahead, behind = slope > 1e-12, slope < -1e-12
    level = ~ahead & ~behind
    if (depth[level] < 0).any():
        return np.nan
    front = (depth[ahead] / slope[ahead]).min()
    rear = (depth[behind] / -slope[behind]).min()
    return float(min(front, rear)) if front + rear >= 0 else np.nan


@checked_arguments
def whole_stretches(events: pd.DataFrame, strides: pd.DataFrame) -> pd.DataFrame:
    """Find the stretches in which every leg is within a stride that counts.

    Before and after them a leg is not tracked, the animal stands, or a stride was dropped:
    which feet are on the ground is not known there.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one or more trials: they say which legs there are.
    strides : pandas.DataFrame
        Their strides.

    Returns
    -------
    pandas.DataFrame
        animal, trial, start_s, end_s, in order of time.
    """
    check_columns(events, ("animal", "trial", "leg"), where="events")
    check_columns(strides, ("animal", "trial", "start_s", "period_s"), where="strides")
    legs = events.groupby(_TRIAL, sort=False)["leg"].nunique()
    rows: list[list[object]] = []
    for key, own in strides.groupby(_TRIAL, sort=False):
        start = own["start_s"].to_numpy(dtype=float)
        end = start + own["period_s"].to_numpy(dtype=float)
        # of strides that follow each other the end comes before the start, to rounding
        time = np.concatenate((np.round(start, 9), np.round(end, 9)))
        step = np.repeat((1, -1), len(start))
        order = np.argsort(time, kind="stable")
        at, first = np.unique(time[order], return_index=True)
        level = np.add.reduceat(step[order], first).cumsum()
        for i, j in find_runs(level == legs.get(key, 0)):
            rows.append([*key, at[i], at[j]])
    return pd.DataFrame(rows, columns=[*_TRIAL, "start_s", "end_s"])


@checked_arguments
def support_table(events: pd.DataFrame, *, strides: pd.DataFrame | None = None) -> pd.DataFrame:
    """List which feet are on the ground, stretch by stretch.

    Parameters
    ----------
    events : pandas.DataFrame
        TD and LO (where there are any), else AEP and PEP, of one or more trials.
    strides : pandas.DataFrame, optional
        Their strides: only what lies in :func:`whole_stretches` is listed then. Without them
        everything is, from the time at which the state of every leg is known to the last at
        which it is; that is for events without gaps and pauses.

    Returns
    -------
    pandas.DataFrame
        animal, trial, start_s, end_s, n_down and legs (names with + between).
    """
    check_columns(events, ("animal", "trial", "leg", "event", "time_s"), where="events")
    if strides is not None:
        check_columns(strides, ("animal", "trial", "start_s", "period_s"), where="strides")
    allowed = None if strides is None else whole_stretches(events, strides)
    parts = []
    for (animal, trial), own in events.groupby(_TRIAL, sort=False):
        contact = own["event"].isin(("TD", "LO")).any()
        begin, end = ("TD", "LO") if contact else ("AEP", "PEP")
        own = own[own["event"].isin((begin, end))].sort_values("time_s", kind="stable")
        spans = own.groupby("leg")["time_s"].agg(["min", "max"])
        stretches = [(float(spans["min"].max()), float(spans["max"].min()))]
        if allowed is not None:
            here = (allowed["animal"] == animal) & (allowed["trial"] == trial)
            spans = allowed.loc[here, ["start_s", "end_s"]]
            stretches = list(spans.itertuples(index=False, name=None))
        part = _support_of(own, begin, stretches)
        part["animal"], part["trial"] = str(animal), str(trial)
        parts.append(part[list(SUPPORT_COLUMNS)])
    parts = [part for part in parts if len(part)]
    if not parts:
        return pd.DataFrame(columns=list(SUPPORT_COLUMNS))
    return pd.concat(parts, ignore_index=True)


def _support_of(
    events: pd.DataFrame, begin: str, stretches: Sequence[tuple[float, float]]
) -> pd.DataFrame:
    """List which feet of one trial are down between its events, within some stretches."""
    time = events["time_s"].to_numpy(dtype=float)
    cuts = [np.unique([a, *time[(time > a) & (time < b)], b]) for a, b in stretches if b > a]
    start = np.concatenate([cut[:-1] for cut in cuts] or [np.empty(0)])
    end = np.concatenate([cut[1:] for cut in cuts] or [np.empty(0)])
    legs = sort_legs(events["leg"])
    down = np.zeros((len(start), len(legs)), dtype=bool)
    for k, leg in enumerate(legs):
        own = (events["leg"] == leg).to_numpy()
        begins = (events["event"] == begin).to_numpy()[own]
        at = np.searchsorted(time[own], start, side="right") - 1
        # before its first event a foot was in the other state
        down[:, k] = np.where(at >= 0, begins[np.maximum(at, 0)], ~begins[0])
    patterns, which = np.unique(down, axis=0, return_inverse=True)
    names = np.array(
        ["+".join(leg for leg, on in zip(legs, row, strict=True) if on) for row in patterns],
        dtype=object,
    )
    counts = down.sum(axis=1)
    which = which.reshape(-1)
    return pd.DataFrame({"start_s": start, "end_s": end, "n_down": counts, "legs": names[which]})


@checked_arguments
def support_shares(support: pd.DataFrame) -> pd.DataFrame:
    """Return for each animal the share of time with 0, 1, 2, ... feet on the ground.

    Parameters
    ----------
    support : pandas.DataFrame
        As :func:`support_table` makes it.

    Returns
    -------
    pandas.DataFrame
        animal, n_down, share (of 1).
    """
    check_columns(support, ("animal", "n_down", "start_s", "end_s"), where="support")
    spans = support.assign(duration=support["end_s"] - support["start_s"])
    time = spans.groupby(["animal", "n_down"], sort=True)["duration"].sum()
    share = time / time.groupby("animal").transform("sum")
    return share.rename("share").reset_index()


class Regularity(NamedTuple):
    """Regularity of the order in which four feet land.

    Attributes
    ----------
    percent : float
        Regularity index: 400 * normal sequences / footfalls.
    n_footfalls, n_sequences : int
        Footfalls counted, and complete normal step sequences among them.
    shares : dict
        Share of each normal sequence (Ca, Cb, Aa, Ab, Ra, Rb) among them.
    """

    percent: float
    n_footfalls: int
    n_sequences: int
    shares: dict[str, float]


@checked_arguments
def regularity_index(events: pd.DataFrame, *, stretches: pd.DataFrame | None = None) -> Regularity:
    """Compute the regularity index of a four-legged animal in one trial.

    ``RI = 100 * 4 * NSSP / PP``: normal step sequence patterns times four, over paw
    placements (Cheng et al. 1997, Hamers et al. 2001). A sequence may begin with any foot.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one trial; TD where there are any, else AEP.
    stretches : pandas.DataFrame, optional
        start_s and end_s: only footfalls in these are counted, and no sequence goes on from one
        to the next. Default all as one.

    Returns
    -------
    Regularity
        Index, counts and shares. Up to three footfalls at the end that complete no sequence
        count as placements, as the definition has it.

    Raises
    ------
    InputError
        If the legs are not FR, HR, FL and HL, or fewer than four footfalls are known.
    """
    check_columns(events, ("leg", "event", "time_s"), where="events")
    kind = "TD" if (events["event"] == "TD").any() else "AEP"
    own = events[events["event"] == kind].sort_values("time_s", kind="stable")
    legs = {leg for leg in own["leg"] if find_leg_place(leg) is not None}
    if legs != {"FR", "HR", "FL", "HL"} or len(own) < 4:
        raise InputError(
            f"the regularity index needs footfalls of FR, HR, FL and HL; found {len(own)} of "
            f"{', '.join(sort_legs(set(own['leg']))) or 'no leg'}."
        )
    runs = [own["leg"].tolist()]
    if stretches is not None:
        time = own["time_s"]
        runs = [
            own.loc[(time >= a - 1e-9) & (time <= b + 1e-9), "leg"].tolist()
            for a, b in stretches[["start_s", "end_s"]].to_numpy(dtype=float)
        ]
    turned = {
        (*steps[i:], *steps[:i]): name
        for name, steps in _NORMAL_SEQUENCES.items()
        for i in range(4)
    }
    counts = dict.fromkeys(_NORMAL_SEQUENCES, 0)
    for order in runs:
        at = 0
        while at + 4 <= len(order):
            name = turned.get(tuple(order[at : at + 4]))
            if name is None:
                at += 1
            else:
                counts[name] += 1
                at += 4
    total = sum(counts.values())
    n = sum(len(order) for order in runs)
    if n < 4:
        raise InputError("the regularity index needs four footfalls in one stretch at least.")
    shares = {name: count / total if total else 0.0 for name, count in counts.items()}
    return Regularity(400.0 * total / n, n, total, shares)
