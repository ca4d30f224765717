"""How legs are coupled: Hughes' two rules and the two models of coordination, on measured phases.

Pullar 2009, section 4.2.4 and Fig. 5.1 (after Hughes 1952 and Shultz 1987).
"""

from __future__ import annotations

import functools

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.circular.mean import circular_sd, mean_vector
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

CONTRALATERAL, IPSILATERAL, DIAGONAL, OTHER_COUPLING = (
    "contralateral",
    "ipsilateral",
    "diagonal",
    "other",
)

ALTERNATION_COLUMNS = ("animal", "leg", "reference", "n_strides", "mean", "r", "from_half")
SUPPORT_RULE_COLUMNS = ("animal", "leg", "behind", "n_protractions", "n_obeyed", "share")
COUPLING_COLUMNS = ("animal", "kind", "n_pairs", "n_strides", "circular_sd", "r")


@functools.cache
def kind_of_pair(leg: str, reference: str) -> str:
    """Say how two legs lie to each other.

    Parameters
    ----------
    leg, reference : str
        Names of the legs.

    Returns
    -------
    str
        ``contralateral``: the same place on the other side. ``ipsilateral``: neighbours on
        one side. ``diagonal``: neighbours across the body. Else ``other``.
    """
    a, b = find_leg_place(leg), find_leg_place(reference)
    if a is None or b is None:
        return OTHER_COUPLING
    # a mouse's hind leg has rank 3 as an insect's has, and no leg between it and the front
    apart = abs(a.rank - b.rank)
    step = 2 if leg[0] in "FH" and reference[0] in "FH" else 1
    if a.side != b.side and apart == 0:
        return CONTRALATERAL
    if apart == step:
        return IPSILATERAL if a.side == b.side else DIAGONAL
    return OTHER_COUPLING


@checked_arguments
def alternation_rule(phases: pd.DataFrame) -> pd.DataFrame:
    """Test Hughes' first rule: each leg alternates with its partner on the other side.

    Parameters
    ----------
    phases : pandas.DataFrame
        animal, leg, reference, phase.

    Returns
    -------
    pandas.DataFrame
        For each animal and contralateral pair the mean phase, its mean vector's length r, and
        ``from_half``, mean phase minus a half, cycles in [-0.5, 0.5). Whether they differ from 0
        is a question about animals: hand one value an animal to a test.
    """
    check_columns(
        phases, ("animal", "leg", "reference", "phase"), where="phases", numbers=("phase",)
    )
    rows = []
    for (animal, leg, reference), own in phases.groupby(["animal", "leg", "reference"], sort=False):
        if kind_of_pair(str(leg), str(reference)) != CONTRALATERAL:
            continue
        mean, r, n = mean_vector(own["phase"].to_numpy(dtype=float))
        rows.append([animal, leg, reference, n, mean, r, mean % 1.0 - 0.5])
    return pd.DataFrame(rows, columns=list(ALTERNATION_COLUMNS))


@checked_arguments
def support_rule(events: pd.DataFrame, *, strides: pd.DataFrame | None = None) -> pd.DataFrame:
    """Test Hughes' second rule: no leg is protracted until the leg behind supports the body.

    Parameters
    ----------
    events : pandas.DataFrame
        AEP and PEP (or TD and LO, of a trial without AEP) of one or more animals.
    strides : pandas.DataFrame, optional
        Their strides: the state of the leg behind is known only within its strides then, and
        not across gaps and pauses. Without them it is between its first and last event.

    Returns
    -------
    pandas.DataFrame
        For each animal and pair of neighbours on one side: how many protractions of the leg
        began (PEP, LO) while the state of the leg behind is known, and how many of them while
        that leg was in stance (between its AEP and PEP). ``share`` is obeyed / all. A leg that
        ignores the one behind would begin a share equal to that one's duty factor.
    """
    check_columns(events, ("animal", "trial", "leg", "event", "time_s"), where="events")
    rows = []
    for animal, own in events.groupby("animal", sort=True):
        legs = sort_legs(own["leg"])
        for leg in legs:
            for behind in legs:
                if kind_of_pair(leg, behind) != IPSILATERAL or not _is_behind(behind, leg):
                    continue
                n, obeyed = 0, 0
                for name, trial in own.groupby("trial", sort=False):
                    known = None if strides is None else _spans(strides, animal, name, behind)
                    state = _state_at_protraction(trial, (leg, behind), known=known)
                    n, obeyed = n + len(state), obeyed + int(state.sum())
                rows.append([animal, leg, behind, n, obeyed, obeyed / n if n else np.nan])
    return pd.DataFrame(rows, columns=list(SUPPORT_RULE_COLUMNS))


def _is_behind(behind: str, leg: str) -> bool:
    """Say whether one leg lies behind another."""
    a, b = find_leg_place(behind), find_leg_place(leg)
    return a is not None and b is not None and a.rank > b.rank


def _spans(strides: pd.DataFrame, animal: object, trial: object, leg: str) -> FloatArray:
    """Return start and end of the strides of one leg in one trial, shape (n, 2), in order."""
    # names that are numbers come back from a csv as such
    names = strides[["leg", "animal", "trial"]].astype(str)
    own = strides[(names == [leg, str(animal), str(trial)]).all(axis=1)].sort_values("start_s")
    start = own["start_s"].to_numpy(dtype=float)
    return np.column_stack((start, start + own["period_s"].to_numpy(dtype=float)))


def _state_at_protraction(
    events: pd.DataFrame, pair: tuple[str, str], *, known: FloatArray | None
) -> BoolArray:
    """Say of each protraction of a leg whether the one behind is in stance, where known."""
    leg, behind = pair
    # trials of one study may be scored in different ways
    begin, end = ("AEP", "PEP") if (events["event"] == "AEP").any() else ("TD", "LO")
    lifts = events.loc[(events["leg"] == leg) & (events["event"] == end), "time_s"]
    lifted = lifts.to_numpy(dtype=float)
    other = events[(events["leg"] == behind) & events["event"].isin((begin, end))]
    other = other.sort_values("time_s", kind="stable")
    times = other["time_s"].to_numpy(dtype=float)
    at = np.searchsorted(times, lifted, side="right")
    told = (at > 0) & (at < len(times))
    if known is not None:
        stride = np.searchsorted(known[:, 0], lifted, side="right") - 1
        told &= stride >= 0
        told[told] = lifted[told] < known[stride[told], 1]
    return (other["event"] == begin).to_numpy()[at[told] - 1]


@checked_arguments
def coupling_strength(phases: pd.DataFrame) -> pd.DataFrame:
    """Compare how tightly legs are coupled along, across and diagonally.

    The metachronal (ipsilateral) model of coordination expects the smallest spread between
    neighbours of one side, the alternating tetrapod (diagonal) model between neighbours across
    the body (Fig. 5.1; Shultz 1987; Pullar 2009 reads its own circular SDs so).

    Parameters
    ----------
    phases : pandas.DataFrame
        animal, leg, reference, phase.

    Returns
    -------
    pandas.DataFrame
        For each animal and kind of pair: r of the phases about each pair's own mean, pooled
        over pairs, and the circular SD from it, cycles.
    """
    check_columns(
        phases, ("animal", "leg", "reference", "phase"), where="phases", numbers=("phase",)
    )
    named = phases.assign(
        kind=[kind_of_pair(a, b) for a, b in zip(phases["leg"], phases["reference"], strict=True)]
    )
    rows = []
    for (animal, kind), own in named.groupby(["animal", "kind"], sort=True):
        if kind == OTHER_COUPLING:
            continue
        vectors = [
            mean_vector(part["phase"].to_numpy(dtype=float))
            for _, part in own.groupby(["leg", "reference"])
        ]
        n = sum(v.n for v in vectors)
        r = sum(v.n * v.r for v in vectors) / n
        rows.append([animal, kind, len(vectors), n, circular_sd(r), r])
    return pd.DataFrame(rows, columns=list(COUPLING_COLUMNS))
