"""Gaits as distances to ideal patterns, never as a bare label; Hildebrand's two numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import mean_vector
from pawnb.gait.legs import LegPlace, find_leg_place
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

PATTERN_COLUMNS = (
    "animal", "pattern", "n_pairs", "distance", "free_lag", "nearest",
)  # fmt: skip

# the phase of each leg as (side, place in the row), cycles; after Hildebrand 1965, 1989 for four
# legs, Wilson 1966 for six, and Pullar 2009, section 5.4, for eight
_FOUR = {
    "trot": {"L1": 0.5, "R1": 0.0, "L2": 0.0, "R2": 0.5},
    "pace": {"L1": 0.5, "R1": 0.0, "L2": 0.5, "R2": 0.0},
    "bound": {"L1": 0.0, "R1": 0.0, "L2": 0.5, "R2": 0.5},
    "lateral-sequence walk": {"L1": 0.5, "R1": 0.0, "L2": 0.25, "R2": 0.75},
    "diagonal-sequence walk": {"L1": 0.5, "R1": 0.0, "L2": 0.75, "R2": 0.25},
    "pronk": {"L1": 0.0, "R1": 0.0, "L2": 0.0, "R2": 0.0},
}
_SIX = {
    "alternating tripod": {"L1": 0.0, "R1": 0.5, "L2": 0.5, "R2": 0.0, "L3": 0.0, "R3": 0.5},
}
_EIGHT = {
    "alternating tetrapod": {
        "L1": 0.0, "R1": 0.5, "L2": 0.5, "R2": 0.0, "L3": 0.0, "R3": 0.5, "L4": 0.5, "R4": 0.0,
    },
}  # fmt: skip
IDEAL_PATTERNS: dict[int, dict[str, dict[str, float]]] = {4: _FOUR, 6: _SIX, 8: _EIGHT}
"""Ideal patterns by the number of legs: phase of every leg in cycles, from the front."""

METACHRONAL = "metachronal wave"
"""Six and more legs: each leg follows the one behind it by the same lag, which is fitted, and
the two sides alternate."""


@checked_arguments
def pattern_distances(
    phases: pd.DataFrame, *, patterns: Mapping[str, Mapping[str, float]] | None = None
) -> pd.DataFrame:
    """Say how far each animal's mean phases are from ideal patterns.

    Parameters
    ----------
    phases : pandas.DataFrame
        Phase lags with animal, leg, reference, phase (cycles).
    patterns : mapping, optional
        Name to the phase of each leg (``L1`` is the left front leg, whatever it is called);
        default :data:`IDEAL_PATTERNS` for the number of legs, and the metachronal wave for six
        legs and more.

    Returns
    -------
    pandas.DataFrame
        One row for animal and pattern, nearest first: ``distance`` is the root mean square
        over the pairs of the difference between mean and ideal phase, cycles (0: the same,
        0.29 on average for phases at random, 0.5: opposite). ``free_lag`` is the fitted lag of
        the metachronal wave, NaN for others. ``nearest`` marks the smallest distance (several
        patterns, where the pairs cannot tell them apart); look at the others before naming a
        gait after it.

    Raises
    ------
    InputError
        If a leg's name says no place, or a pattern names no leg of a pair.
    """
    rows = []
    for animal, own in phases.groupby("animal", sort=True):
        means = {
            (str(leg), str(reference)): mean_vector(part["phase"].to_numpy()).mean
            for (leg, reference), part in own.groupby(["leg", "reference"])
        }
        pairs = [(_place(a), _place(b)) for a, b in means]
        observed = np.array(list(means.values()))
        found = []
        for name, ideal in _patterns(pairs, patterns).items():
            expected = np.array([_expected(ideal, a, b, name) for a, b in pairs])
            found.append((name, _distance(observed - expected), np.nan))
        if patterns is None and max(p.rank for pair in pairs for p in pair) >= 3:
            found.append((METACHRONAL, *_fit_wave(observed, pairs)))
        found.sort(key=lambda one: one[1])
        for name, distance, lag in found:
            # patterns that these pairs cannot tell apart are equally near
            nearest = distance <= found[0][1] + 1e-9
            rows.append([animal, name, len(pairs), distance, lag, nearest])
    return pd.DataFrame(rows, columns=list(PATTERN_COLUMNS))


def _patterns(
    pairs: Sequence[tuple[LegPlace, LegPlace]],
    patterns: Mapping[str, Mapping[str, float]] | None,
) -> Mapping[str, Mapping[str, float]]:
    """Return the patterns for this number of legs."""
    if patterns is not None:
        return patterns
    n_legs = 2 * max(place.rank for pair in pairs for place in pair)
    return IDEAL_PATTERNS.get(n_legs, {})


def _expected(ideal: Mapping[str, float], leg: LegPlace, reference: LegPlace, name: str) -> float:
    """Return the ideal phase of a pair."""
    codes = [f"{place.side}{place.rank}" for place in (leg, reference)]
    for code in codes:
        if code not in ideal:
            raise InputError(
                f"pattern {name!r} says no phase for leg {code}; give one for every leg."
            )
    return ideal[codes[0]] - ideal[codes[1]]


def _distance(difference: FloatArray) -> float:
    """Return the root mean square of differences between phases, cycles."""
    wrapped = (difference + 0.5) % 1.0 - 0.5
    return float(np.sqrt(np.mean(wrapped**2)))


def _fit_wave(
    observed: FloatArray, pairs: Sequence[tuple[LegPlace, LegPlace]]
) -> tuple[float, float]:
    """Fit the lag of the metachronal wave: distance and lag of a leg after the one behind it."""
    steps = np.array([b.rank - a.rank for a, b in pairs], dtype=float)
    across = np.array([0.0 if a.side == b.side else 0.5 for a, b in pairs])
    lags = np.linspace(0.0, 1.0, 1000, endpoint=False)
    distance = [_distance(observed - (steps * lag + across)) for lag in lags]
    best = int(np.argmin(distance))
    return distance[best], float(lags[best])


def _place(leg: str) -> LegPlace:
    """Return a leg's place with 1, 2 for fore and hind where there are two pairs only."""
    place = find_leg_place(leg)
    if place is None:
        raise InputError(
            f"leg {leg!r} does not say its side and place; rename it like FR, LM or L3."
        )
    two_pairs = leg[0] in "FH"  # mouse: HR is the second pair, an insect's RH the third
    return LegPlace(place.side, 2) if two_pairs and place.rank == 3 else place


_HILDEBRAND = ("duty_percent", "lag_percent", "told_by")


@checked_arguments
def hildebrand_table(strides: pd.DataFrame, phases: pd.DataFrame) -> pd.DataFrame:
    """Collect Hildebrand's two numbers, stride by stride and side by side.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of four-legged animals (FR, HR, FL, HL).
    phases : pandas.DataFrame
        Their phases, with fore relative to hind leg of a side.

    Returns
    -------
    pandas.DataFrame
        animal, trial, side, stride, ``duty_percent`` (the hind foot's time on the ground in
        percent of the stride) and ``lag_percent`` (the fore footfall after the hind one of the
        same side, in percent of the stride): Hildebrand 1965, Science 150: 701. The time on the
        ground is that from touch-down to lift-off; ``told_by`` is "contact" then. Where no contact
        is known it is "AEP to PEP": that is longer, by a quarter of a stride in fast runs, and
        tells no run from a walk.

    Raises
    ------
    InputError
        If no fore leg is measured relative to the hind leg of its side.
    """
    check_columns(strides, ("animal", "trial", "leg", "stride", "duty_factor"), where="strides")
    check_columns(
        phases,
        ("animal", "trial", "leg", "reference", "stride", "phase"),
        where="phases",
        numbers=("phase",),
    )
    parts = []
    for side in "LR":
        own = phases[(phases["leg"] == f"F{side}") & (phases["reference"] == f"H{side}")]
        hind = strides[strides["leg"] == f"H{side}"]
        keys = ["animal", "trial", "stride"]
        on_ground, told_by = _time_on_ground(hind)
        hind = hind.assign(on_ground=on_ground, told_by=told_by)
        both = own.merge(hind[[*keys, "on_ground", "told_by"]], on=keys)
        both = both.assign(
            side=side,
            duty_percent=100.0 * both["on_ground"],
            lag_percent=100.0 * both["phase"],
        )
        parts.append(both[["animal", "trial", "side", "stride", *_HILDEBRAND]])
    table = pd.concat(parts, ignore_index=True)
    if table.empty:
        raise InputError(
            "no phase of a fore leg relative to the hind leg of its side (FL to HL, FR to HR); "
            "Hildebrand's diagram is for four legs."
        )
    return table


def _time_on_ground(strides: pd.DataFrame) -> tuple[pd.Series, pd.Series]:
    """Return the share of each stride that the foot is on the ground, and what tells it."""
    own = strides["duty_factor"].astype(float)
    method = strides.get("method", pd.Series("", index=strides.index)).astype(str)
    by_place = method.str.startswith("AEP")
    contact = strides.get("contact_duty_factor", pd.Series(np.nan, index=strides.index))
    if not contact[by_place].notna().any():
        return own, by_place.map({True: "AEP to PEP", False: "contact"})
    return own.where(~by_place, contact), pd.Series("contact", index=strides.index)
