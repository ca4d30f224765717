"""Phase lags between legs, and their summary over strides and over animals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.gait.analysis.phase_patterns import name_pattern, say_pattern
from pawnb.gait.circular.mean import circular_sd, mean_interval, mean_vector
from pawnb.gait.circular.rayleigh import rayleigh_p
from pawnb.gait.inference.animal_phases import phase_of_animals
from pawnb.gait.inference.checks import as_numbers
from pawnb.gait.inference.circular_length import length_interval
from pawnb.schema import (
    DROPPED_COLUMNS,
    PHASE_SUMMARY_COLUMNS,
    PHASES_COLUMNS,
    check_columns,
)
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def phase_lags(times: FloatArray, reference: FloatArray) -> tuple[IntArray, FloatArray]:
    """Compute phase lags of events relative to the strides of a reference (Eq. 3.21).

    ``phase = (t - t') / P'`` for every event at t within the reference's stride from t'
    to t' + P'. A stride may hold no event, or more than one.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of one kind of event of the leg, rising.
    reference : ndarray, shape (m, 2)
        Start and end of each stride of the reference leg, in the same unit; strides do not
        overlap.

    Returns
    -------
    stride : ndarray of int, shape (k,)
        Which stride of the reference each phase belongs to, from 0.
    phase : ndarray, shape (k,)
        Phases in cycles, in [0, 1).

    Raises
    ------
    InputError
        If a time is not a finite number.
    """
    times = as_numbers(times, "times of events")
    start, end = as_numbers(reference, "strides of the reference").reshape(-1, 2).T
    for what, given in (("times of events", times), ("strides of the reference", (start, end))):
        if not np.isfinite(given).all():
            raise InputError(f"{what}: some are not finite; leave out what was not measured.")
    order = np.argsort(start, kind="stable")
    place = np.searchsorted(start[order], times, side="right") - 1
    which = order[np.maximum(place, 0)] if len(order) else np.zeros(len(times), dtype=int)
    inside = place >= 0
    inside[inside] = times[inside] < end[which[inside]]
    which, times = which[inside], times[inside]
    phase = (times - start[which]) / (end[which] - start[which])
    return which, np.where(phase < 1.0, phase, 0.0)


@checked_arguments
def build_phases(
    events: pd.DataFrame,
    strides: pd.DataFrame,
    pairs: Sequence[tuple[str, str]],
    *,
    start_event: str,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Build the phase table of one animal in one trial.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial.
    strides : pandas.DataFrame
        Their strides; those that were dropped give no phase.
    pairs : sequence of (leg, reference)
        Pairs to compare.
    start_event : {"AEP", "TD"}
        Event that begins a stride and whose phase is measured.

    Returns
    -------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``; ``stride`` is the reference's.
    dropped : pandas.DataFrame
        ``DROPPED_COLUMNS``: strides of the reference in which the leg has no event.
    """
    parts: list[pd.DataFrame] = []
    dropped: list[dict[str, Any]] = []
    for leg, reference in pairs:
        own = events[(events["leg"] == leg) & (events["event"] == start_event)]
        times = np.sort(own["time_s"].to_numpy(dtype=float))
        base = strides[strides["leg"] == reference].reset_index(drop=True)
        start = base["start_s"].to_numpy(dtype=float)
        spans = np.column_stack((start, start + base["period_s"].to_numpy(dtype=float)))
        which, values = phase_lags(times, spans)
        part = base.loc[which, ["animal", "trial", "stride"]]
        parts.append(part.assign(leg=leg, reference=reference, phase=values))
        for i in np.setdiff1d(np.arange(len(base)), which):
            stride = base.loc[i]
            who = {"animal": stride["animal"], "trial": stride["trial"], "leg": leg}
            why = f"no {start_event} of {leg} within stride {stride['stride']} of {reference}"
            span = {"start_s": spans[i, 0], "end_s": spans[i, 1]}
            dropped.append({**who, **span, "what": f"phase to {reference}", "why": why})
    parts = [part for part in parts if len(part)]
    names = list(PHASES_COLUMNS)
    phases = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=names)
    phases = phases[names].astype({"phase": float})
    return phases, pd.DataFrame(dropped, columns=list(DROPPED_COLUMNS))


@checked_arguments
def summarise_phases(phases: pd.DataFrame) -> pd.DataFrame:
    """Summarise phases by pair of legs, over animals and over strides.

    The first set of statistics counts animals
    (:func:`pawnb.gait.inference.animal_phases.phase_of_animals`): each animal's mean phase is one
    unit vector, whatever its number of strides, and the interval is made for few animals. With one
    animal only its mean is given; spread, interval, test and pattern say nothing about animals then
    and are blank (one animal's r is 1 and its SD 0, whatever it does), and the note says so. The
    set named ``..._strides`` counts every stride as if it were independent of the others, which
    strides of one animal are not: it describes, and its p is too small.

    ``pattern`` names the phase relation, see
    :func:`pawnb.gait.analysis.phase_patterns.name_pattern`; where the animals do not determine one,
    the note says how alike they would have to be.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.

    Returns
    -------
    pandas.DataFrame
        ``PHASE_SUMMARY_COLUMNS``, pairs in their order of appearance. Standard
        deviation: :func:`~pawnb.gait.circular.circular_sd`; p: exact,
        :func:`~pawnb.gait.circular.rayleigh_p`; interval of 95 %:
        :func:`~pawnb.gait.inference.animal_phases.interval_of_phases` for animals,
        :func:`~pawnb.gait.circular.mean_interval` for strides; of r, ``r_low`` and ``r_high``:
        :func:`~pawnb.gait.inference.circular_length.length_interval`. ``moore_r`` and ``moore_p``:
        Moore's second-order test of the animals' mean vectors.

    Raises
    ------
    InputError
        If a column is missing, a phase is not finite, or an animal has no name.
    """
    check_columns(
        phases, ("animal", "leg", "reference", "phase"), where="phases", numbers=("phase",)
    )
    rows = []
    for (leg, reference), group in phases.groupby(["leg", "reference"], sort=False):
        strides = group["phase"].to_numpy()
        found = phase_of_animals(strides, group["animal"].tolist())
        row: dict[str, Any] = {"leg": leg, "reference": reference, "n": len(group)}
        row["n_animals"] = group["animal"].nunique()
        row |= {
            "mean": found.mean, "ci_low": found.low, "ci_high": found.high, "r": found.r,
            "circular_sd": found.circular_sd, "rayleigh_z": found.rayleigh_z,
            "rayleigh_p": found.rayleigh_p, "r_low": found.r_low, "r_high": found.r_high,
            "moore_r": found.moore_r, "moore_p": found.moore_p, "pattern": None,
        }  # fmt: skip
        notes = [found.note]
        if found.n_animals > 1:
            row["pattern"] = name_pattern(found.mean, found.r, found.n_animals)
            notes.append(say_pattern(row["pattern"], found.r, found.n_animals))
        elif len(group) > 1:
            notes.append(f"its {len(group)} strides are described in the columns ..._strides")
        row["note"] = "; ".join(note for note in notes if note)
        row |= {f"{k}_strides": v for k, v in describe_phases(strides).items()}
        rows.append(row)
    return pd.DataFrame(rows, columns=list(PHASE_SUMMARY_COLUMNS))


@checked_arguments
def describe_phases(phases: FloatArray) -> dict[str, Any]:
    """Describe one sample of phases, taken to be independent.

    Parameters
    ----------
    phases : ndarray, shape (n,)
        Phases in cycles.

    Returns
    -------
    dict
        mean, ci_low, ci_high, r, circular_sd, rayleigh_z, rayleigh_p, pattern, r_low and
        r_high. All NaN (pattern None) for an empty sample, all but the mean for a sample of one.
    """
    names = (
        "mean", "ci_low", "ci_high", "r", "circular_sd", "rayleigh_z", "rayleigh_p", "r_low",
        "r_high",
    )  # fmt: skip
    blank: dict[str, Any] = {**dict.fromkeys(names, math.nan), "pattern": None}
    if len(phases) == 0:
        return blank
    mean, r, n = mean_vector(phases)
    if n == 1:
        return {**blank, "mean": mean}
    low, high = mean_interval(mean, r, n)
    r_low, r_high = length_interval(r, n)
    return {
        "mean": mean,
        "ci_low": low,
        "ci_high": high,
        "r": r,
        "circular_sd": circular_sd(r),
        "rayleigh_z": n * r**2,
        "rayleigh_p": rayleigh_p(n, r),
        "pattern": name_pattern(mean, r, n),
        "r_low": r_low,
        "r_high": r_high,
    }
