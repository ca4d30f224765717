"""Legs of which no stride was found, and what was found of them instead."""

from __future__ import annotations

from pawnb.gait.analysis.notes import Note
from pawnb.gait.analysis.tables import GaitTables, TrialBasis, of_trial
from pawnb.gait.cycles.leg_signals import LEG_ANGLE, POSITION
from pawnb.gait.legs import sort_legs
from pawnb.gait.locomotion.time_scales import held_still
from pawnb.gait.strides.stride_table import PARTNER, choose_stride_event


def say_no_strides(tables: GaitTables) -> list[Note]:
    """Say of each trial which legs have no stride, what was found of them and what is needed.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.

    Returns
    -------
    list of Note
        One sentence for each trial in which a leg has no stride; animals of one trial share it
        where it is the same.
    """
    said: dict[tuple[str, str], list[str]] = {}
    for basis in tables.bases:
        what = _on_legs_without_strides(tables, basis)
        if what:
            said.setdefault((basis.who["trial"], what), []).append(basis.who["animal"])
    trials = [basis.who["trial"] for basis in tables.bases]
    return [
        Note(f"{', '.join(who)}: {what}" if trials.count(trial) > 1 else what, where=trial)
        for (trial, what), who in said.items()
    ]


def _on_legs_without_strides(tables: GaitTables, basis: TrialBasis) -> str:
    """Say which legs of one animal and trial have no stride; empty where all have one."""
    events = of_trial(tables.events, basis.who)
    legs = sort_legs(events["leg"]) if basis.legs is None else list(basis.legs)
    with_strides = set(of_trial(tables.strides, basis.who)["leg"])
    without = [leg for leg in legs if leg not in with_strides]
    if legs and not without:
        return ""
    start = choose_stride_event(events, tables.settings.stride_events)
    counts = events.loc[events["event"] == start, "leg"].value_counts()
    left_out = of_trial(tables.dropped, basis.who)
    unseen = set(left_out.loc[left_out["what"] == "leg", "leg"])
    if unseen.issuperset(legs):
        return "left out, as no leg has a position in any frame."
    found = ", ".join(
        f"{counts.get(leg, 0)} of {leg}{' (no position in any frame)' * (leg in unseen)}"
        for leg in without
    )
    dropped = ((left_out["what"] == "stride") & left_out["leg"].isin(without)).sum()
    if dropped:
        found += f" ({dropped} from {start} to {start} dropped: see dropped.csv)"
    others = left_out[~left_out["what"].isin(["stride", "leg"]) & left_out["leg"].isin(without)]
    if len(others):
        why = others["why"].mode().iloc[0]
        found += f" ({len(others)} left out, most often as {why}: see dropped.csv)"
    which = f"no stride of {', '.join(without)}" if with_strides else "no stride"
    needed = "a longer recording is needed, or other settings of the event detection."
    still = _held_still(basis)
    held = [leg for leg in without if leg in still]
    if held:
        needed = f"for the others {needed}" if len(held) < len(without) else ""
        needed = (
            f"{', '.join(held)} {'is' if len(held) == 1 else 'are'} held still, and a longer "
            f"recording gives no more{'; ' if needed else '.'}{needed}"
        )
    return (
        f"{which}, for one runs from {start} to {start} of the same leg, with one "
        f"{PARTNER[start]} between; found {start}: {found}; {needed}"
    )


def _held_still(basis: TrialBasis) -> set[str]:
    """Return the legs that are held still where the others step."""
    turning = [one for one in basis.signals if one.signal == LEG_ANGLE]
    turning = turning or [one for one in basis.signals if one.signal == POSITION]
    return {
        leg
        for one in turning
        for leg, held in zip(one.legs, held_still(one.samples, basis.settings), strict=True)
        if held
    }
