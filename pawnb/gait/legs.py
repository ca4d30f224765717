"""Names of legs: side and place in the row, anatomical order, pairs to compare."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

_RANK_LETTERS = {"F": 1, "M": 2, "H": 3}
_MANY_LEGS = 4
"""From so many pairs of legs on, each leg is compared with all on its side."""
_FORMS = (
    re.compile(r"(?P<rank>[FMH])(?P<side>[LR])"),  # mouse: FR, HR, FL, HL
    re.compile(r"(?P<side>[LR])(?P<rank>\d+)"),  # spider: L1..L4, R1..R4
    re.compile(r"(?P<side>[LR])(?P<rank>[FMH])"),  # insect: LF, LM, LH, RF, RM, RH
)


class LegPlace(NamedTuple):
    """Where a leg sits.

    Attributes
    ----------
    side : str
        ``"L"`` or ``"R"``.
    rank : int
        Place in the row, counted from the front.
    """

    side: str
    rank: int


@functools.cache
def find_leg_place(name: str) -> LegPlace | None:
    """Read side and place from a leg's name.

    Parameters
    ----------
    name : str
        FR, HR, FL, HL; L1.., R1..; or LF, LM, LH, RF, RM, RH.

    Returns
    -------
    LegPlace or None
        None where the name says neither.
    """
    for form in _FORMS:
        found = form.fullmatch(name)
        if found:
            rank = found["rank"]
            return LegPlace(found["side"], _RANK_LETTERS.get(rank) or int(rank))
    return None


def sort_legs(legs: Iterable[str]) -> list[str]:
    """Sort legs in anatomical order.

    Parameters
    ----------
    legs : iterable of str
        Names, each counted once.

    Returns
    -------
    list of str
        Mouse: FR, HR, FL, HL. Others: the left legs from the front, then the right
        ones. Names that say no place follow in alphabetical order.
    """

    def key(name: str) -> tuple[int, bool, int, str]:
        place = find_leg_place(name)
        if place is None:
            return 1, False, 0, name
        right_first = name[0] in _RANK_LETTERS
        return 0, (place.side == "L") == right_first, place.rank, name

    return sorted(set(legs), key=key)


def default_pairs(legs: Sequence[str]) -> list[tuple[str, str]]:
    """List the pairs of legs whose phase is measured when none are named.

    Parameters
    ----------
    legs : sequence of str
        Names of the legs.

    Returns
    -------
    list of (leg, reference)
        Left relative to right of each pair of legs, from the front; then on each side
        every leg relative to the next behind it; then every leg relative to the next
        behind it on the other side (the diagonals). Of an animal with four or more pairs
        of legs: left relative to right, then on each side every leg relative to every
        one behind it, as in Pullar 2009, §4.2.4 (eight legs: 16 pairs). Legs without a
        partner, and names that say no place, form no pair.
    """
    places = {}
    for name in sort_legs(legs):
        place = find_leg_place(name)
        if place is not None:
            places[place] = name
    sides = sorted({p.side for p in places}, reverse=True)  # right side first, as FR, HR, FL, HL
    ranks = sorted({p.rank for p in places})
    wanted = [(LegPlace("L", k), LegPlace("R", k)) for k in ranks]
    if len(ranks) >= _MANY_LEGS:
        apart = range(1, len(ranks))
        behind = [(a, b) for k in apart for a, b in zip(ranks, ranks[k:], strict=False)]
        wanted += [(LegPlace(s, a), LegPlace(s, b)) for a, b in behind for s in sides]
        return [(places[a], places[b]) for a, b in wanted if a in places and b in places]
    steps = list(pairwise(ranks))
    wanted += [(LegPlace(s, a), LegPlace(s, b)) for s in sides for a, b in steps]
    other = {"L": "R", "R": "L"}
    wanted += [(LegPlace(s, a), LegPlace(other[s], b)) for s in sides for a, b in steps]
    return [(places[a], places[b]) for a, b in wanted if a in places and b in places]
