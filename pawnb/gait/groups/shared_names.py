"""Legs that all animals have: a mean over legs compares animals only where it is of the same ones.

A fore leg has another duty factor than a hind leg. An animal without one of them differs from the
others by what its legs differ, and not by what it does.
"""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

_ANIMALS_NAMED = 3


def keep_shared(
    known: pd.DataFrame, over: str, *, group: str | None = None, paired: bool = False
) -> tuple[pd.DataFrame, str]:
    """Keep the rows of those names, such as legs, that every animal has.

    Parameters
    ----------
    known : pandas.DataFrame
        Rows that have a value: ``animal``, the column ``over``, and the group.
    over : str
        Column of the names to average over.
    group : str, optional
        Column of the group; an animal in two of them must have a name in both.
    paired : bool
        Whether groups are conditions of the same animals: those in one only do not count.

    Returns
    -------
    kept : pandas.DataFrame
        Rows of the names that all animals have, and of animals that do not count; all rows where
        there is no such name.
    note : str
        What is left out and which animals lack it; empty where all have the same names.
    """
    named = known[["animal", over, *([] if group is None else [group])]].astype(str)
    if paired and group is not None:
        both = named.groupby("animal")[group].transform("nunique") > 1
        named = named[both] if both.any() else named
    names = list(dict.fromkeys(named[over]))
    lacks: dict[str, dict[str, None]] = {}
    for _, own in named.groupby([name for name in named if name != over], sort=False):
        animal, there = str(own["animal"].iloc[0]), set(own[over])
        for name in names:
            if name not in there:
                lacks.setdefault(name, {})[animal] = None
    if not lacks:
        return known, ""
    told = "; ".join(f"{name} is not known of {_listed(list(own))}" for name, own in lacks.items())
    shared = [name for name in names if name not in lacks]
    if not shared:
        return known, f"animals have means of different {over}s: {told}"
    alone = ~known["animal"].astype(str).isin(set(named["animal"]))
    kept = known[known[over].astype(str).isin(shared) | alone]
    return kept, f"mean of {', '.join(shared)} only: {told}"


def _listed(animals: Sequence[str]) -> str:
    """Name animals, of many the first."""
    more = len(animals) - _ANIMALS_NAMED
    first = ", ".join(animals[:_ANIMALS_NAMED])
    return first if more <= 0 else f"{first} and {more} more"
