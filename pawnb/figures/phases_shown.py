"""What figures of phases have in common: which pairs, and whose mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.figures.panels import say_phase
from pawnb.gait.analysis.phase_patterns import NEAR
from pawnb.gait.circular import mean_vector
from pawnb.gait.phases import summarise_phases
from pawnb.schema import PHASES_COLUMNS, check_columns

ANTI_PHASE_ZONE = (0.5 - NEAR, 0.5 + NEAR)
"""Cycles between which a mean phase is anti-phase."""


def choose_pairs(
    phases: pd.DataFrame, pairs: Sequence[tuple[str, str]] | None, *, where: str
) -> list[tuple[tuple[str, str], pd.DataFrame]]:
    """Return the phases of the pairs to show.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    pairs : sequence of (leg, reference) or None
        Pairs, in this order; None for all.
    where : str
        Name of the figure, for messages.

    Returns
    -------
    list of (pair, DataFrame)
        Each pair with its rows.

    Raises
    ------
    InputError
        If a column is missing, there is no phase, a phase is outside [0, 1), or a pair is not
        there.
    """
    check_columns(phases, PHASES_COLUMNS, where="phases", numbers=("phase",))
    if len(phases) == 0:
        raise InputError(
            f"{where}: no phases; expected those of two legs that make strides at the same time. "
            "What is missing stands in the tables 'dropped' and 'notes' of the analysis; correct "
            "the tracks or events, or take a longer recording."
        )
    if not phases["phase"].between(0.0, 1.0, inclusive="left").all():
        raise InputError(f"{where}: a phase is not in [0, 1); give phases in cycles.")
    groups = {
        (str(leg), str(reference)): own
        for (leg, reference), own in phases.groupby(["leg", "reference"], sort=False)
    }
    wanted = list(groups) if pairs is None else [(str(a), str(b)) for a, b in pairs]
    for pair in wanted:
        if pair not in groups:
            known = ", ".join(f"{a} to {b}" for a, b in groups)
            raise InputError(f"{where}: no phase of {pair[0]} to {pair[1]}; there are {known}.")
    return [(pair, groups[pair]) for pair in wanted]


def say_interval(low: float, high: float) -> str:
    """Return an interval of phases in brackets; empty where there is none.

    Parameters
    ----------
    low, high : float
        Ends in cycles; 0 and 1 for the whole cycle.

    Returns
    -------
    str
        As ``"[0.95, 0.05]"``.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return ""
    return f"[{say_phase(low)}, {'1.00' if high - low == 1.0 else say_phase(high)}]"


def interval_length(low: float, high: float) -> float:
    """Return the length of an interval of phases that may wrap, in cycles.

    Parameters
    ----------
    low, high : float
        Ends in cycles; 0 and 1 for the whole cycle.

    Returns
    -------
    float
        0 to 1.
    """
    return 1.0 if high - low == 1.0 else (high - low) % 1.0


def mean_of_pair(own: pd.DataFrame, summary: pd.DataFrame | None) -> dict[str, Any]:
    """Return mean and interval of one pair: over animals where there are several.

    Parameters
    ----------
    own : pandas.DataFrame
        Phases of one pair.
    summary : pandas.DataFrame or None
        ``phase_summary`` that holds the pair; None to make it.

    Returns
    -------
    dict
        ``n_animals``, ``basis`` (animals or strides), ``mean``, ``r``, ``ci_low``, ``ci_high``
        (NaN for one animal) and ``pattern`` (None for one animal).

    Raises
    ------
    InputError
        If ``summary`` does not hold the pair once.
    """
    n_animals = int(own["animal"].nunique())
    if n_animals == 1:
        mean, r, _ = mean_vector(own["phase"].to_numpy(dtype=float))
        return {"n_animals": 1, "basis": "strides", "mean": mean, "r": r, "ci_low": np.nan,
                "ci_high": np.nan, "pattern": None}  # fmt: skip
    if summary is None:
        summary = summarise_phases(own)
    pair = own["leg"].iloc[0], own["reference"].iloc[0]
    rows = summary[(summary["leg"] == pair[0]) & (summary["reference"] == pair[1])]
    if len(rows) != 1:
        raise InputError(
            f"the phase summary has {len(rows)} rows of {pair[0]} to {pair[1]}; expected one."
        )
    names = ("mean", "r", "ci_low", "ci_high", "pattern")
    return {
        "n_animals": n_animals, "basis": "animals", **{name: rows[name].iloc[0] for name in names}
    }  # fmt: skip
