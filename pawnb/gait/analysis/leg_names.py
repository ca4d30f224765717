"""Which points are feet: legs guessed from the names that other programs' users gave."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from pawnb.errors import InputError
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.schema import Tracks
from pawnb.trial import Trial

_SIDE_WORDS = {"l": "L", "left": "L", "r": "R", "right": "R"}
_RANK_WORDS = {
    "f": "F", "fore": "F", "front": "F", "anterior": "F", "pro": "F",
    "m": "M", "mid": "M", "middle": "M", "meso": "M",
    "h": "H", "hind": "H", "rear": "H", "back": "H", "posterior": "H", "meta": "H",
}  # fmt: skip
_LIMBS = ("paw", "leg", "limb", "foot", "feet", "hand")
_DISTAL = (
    ("tip", "claw", "toe", "toes", "tao", "finger"),
    ("paw", "foot", "feet", "hand", "tarsus", "ta"),
    ("mtp", "metatarsus", "ankle", "wrist"),
)
"""Words for parts of a leg, the outermost first; other parts are no feet when one of these is."""

_FOUR_LEGS = frozenset({"FR", "HR", "FL", "HL"})
_FRONT = ("snout", "nose", "head", "neck")
_REAR = ("butt", "tailbase", "tail", "abdomen", "hip", "pelvis")
_NOT_REAR = ("tip", "end", "mid", "middle", "center", "centre", "distal")

_WORDS_OF_NAME = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_GLUED = re.compile(
    rf"(?P<rank>{'|'.join(sorted(_RANK_WORDS, key=len, reverse=True))})"
    rf"(?P<limb>{'|'.join(_LIMBS)})s?(?P<side>[lr])?"
)
_PAIR = re.compile(r"(?P<a>[lrfmh])(?P<b>[lrfmh])")
_CHAIN = re.compile(r"(?P<leg>[LR]\d)(?P<part>[A-F])")


def guess_legs(points: Iterable[str]) -> dict[str, str]:
    """Guess which points are the feet, from their names.

    Understood are the names that pawnb itself uses (FR, L1, LF, ...), names in words
    (``Front Paw R``, ``hindpaw_left``, ``forelegL4``, ``LF_Claw``), and Anipose's fly legs
    (``L1A`` to ``L1E``). Where several points belong to one leg the outermost is its foot.

    Parameters
    ----------
    points : iterable of str
        Names of the points.

    Returns
    -------
    dict
        Leg to point. Legs are called FR, HR, FL, HL where there are fore and hind ones, LF,
        LM, LH, RF, RM, RH where there are middle ones too, L1, R1, ... where they are
        numbered. Empty where no name says side and place. A leg that has pawnb's own name keeps
        it; words fill in those of the same kind that are left.
    """
    points = list(points)
    own = {point: point for point in points if find_leg_place(point) is not None}
    guessed = _guess_from_words(point for point in points if point not in own)
    if not own or not own.keys() <= _FOUR_LEGS:
        return own or guessed
    return {leg: point for leg, point in guessed.items() if leg in _FOUR_LEGS} | own


def _guess_from_words(points: Iterable[str]) -> dict[str, str]:
    """Guess legs of names that say side and place in words."""
    best: dict[tuple[str, str], tuple[int, str]] = {}
    for point in points:
        read = _read(point)
        if read is None:
            continue
        place, depth = read
        if place not in best or depth < best[place][0]:
            best[place] = depth, point
    six = any(rank == "M" for _, rank in best)
    return {
        _leg_name(side, rank, six=six): point for (side, rank), (_, point) in sorted(best.items())
    }


def choose_legs(
    tracks: Tracks,
    *,
    trial: Trial | None = None,
    legs: Sequence[str] | Mapping[str, str] | None = None,
    where: str = "these tracks",
) -> dict[str, str]:
    """Choose which points of tracks are the feet.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    trial : Trial, optional
        Its ``[tracks] legs`` are used where none are named.
    legs : sequence of str or mapping, optional
        Points that are feet, or names of legs to names of points; default the trial's, else
        guessed (:func:`guess_legs`).
    where : str
        How the message names the tracks.

    Returns
    -------
    dict
        Names of legs to names of points, in anatomical order.

    Raises
    ------
    InputError
        If no leg is named and none can be guessed.
    """
    points = [str(p) for p in tracks["keypoint"].to_numpy()]
    if isinstance(legs, str):
        raise InputError(f"legs is {legs!r}; expected a list such as ['FR', 'HR'].")
    if not points:
        raise InputError(f"{where}: no point at all; expected tracks of at least one foot.")
    if isinstance(legs, Mapping):
        named = dict(legs)
    elif legs is not None:
        named = {leg: leg for leg in legs}
        if len(named) < len(list(legs)):
            raise InputError(f"legs is {list(legs)}, with one of them twice; name each once.")
    elif trial is not None and trial.tracks_legs:
        found = dict(trial.tracks_legs)
        # readers may have given the points the names of the legs already
        named = {leg: leg if leg in points else point for leg, point in found.items()}
    else:
        named = guess_legs(points)
    if not named:
        raise InputError(
            f"{where}: none of the points {', '.join(points)} is named like a leg (FR, HR, FL, "
            f"HL; L1, R1, ...; LF, RH, ...); say which are, with legs={{'HR': {points[-1]!r}}} or "
            f"on the command line --legs HR={points[-1]!r}."
        )
    feet = list(named.values())
    twice = next((foot for i, foot in enumerate(feet) if foot in feet[:i]), None)
    if twice is not None:
        raise InputError(f"{where}: two legs are the one point {twice!r}; name another.")
    return {leg: named[leg] for leg in sort_legs(named)}


def _leg_name(side: str, rank: str, *, six: bool) -> str:
    """Return pawnb's name of a leg."""
    return f"{side}{rank}" if six or rank.isdigit() else f"{rank}{side}"


def _read(point: str) -> tuple[tuple[str, str], int] | None:
    """Return side and rank of a point's leg, and how far in it lies (0: outermost)."""
    chain = _CHAIN.fullmatch(point)
    if chain:
        leg = find_leg_place(chain["leg"])
        return ((leg.side, str(leg.rank)), ord("F") - ord(chain["part"])) if leg else None
    side = rank = ""
    words = [word.lower() for word in _WORDS_OF_NAME.findall(point)]
    limb = False
    for word in words:
        glued, pair = _GLUED.fullmatch(word), _PAIR.fullmatch(word)
        if glued:
            rank, side, limb = (
                _RANK_WORDS[glued["rank"]],
                side or _SIDE_WORDS.get(glued["side"], ""),
                True,
            )
        elif (
            pair and {pair["a"], pair["b"]} & set("lr") and not {pair["a"], pair["b"]} <= set("lr")
        ):
            for letter in word:
                side, rank = _SIDE_WORDS.get(letter, side), _RANK_WORDS.get(letter, rank)
            limb = True
        elif word in _SIDE_WORDS:
            side = side or _SIDE_WORDS[word]
        elif word in _RANK_WORDS:
            rank = rank or _RANK_WORDS[word]
        limb = limb or word.rstrip("s") in _LIMBS
    depth = next(
        (i for i, group in enumerate(_DISTAL) if any(word in group for word in words)), None
    )
    if not side or not rank or not (limb or depth is not None):
        return None
    return (side, rank), len(_DISTAL) if depth is None else depth


def guess_body(points: Iterable[str]) -> tuple[str, str] | None:
    """Guess which two points give the animal's heading, from their names.

    Parameters
    ----------
    points : iterable of str
        Names of the points.

    Returns
    -------
    tuple of str or None
        A point at the rear (base of the tail, butt, abdomen) and one in front (snout, nose,
        head, neck), the first of each list that is there; None where there are not both.
    """
    words = {point: [w.lower() for w in _WORDS_OF_NAME.findall(point)] for point in points}

    def first(wanted: tuple[str, ...], refused: tuple[str, ...] = ()) -> str | None:
        for word in wanted:
            for point, own in words.items():
                if word in own and not set(own) & set(refused):
                    return point
        return None

    rear, front = first(_REAR, _NOT_REAR), first(_FRONT)
    return None if rear is None or front is None else (rear, front)
