"""Which points are feet: legs guessed from the names that other programs' users gave."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from pawnb.errors import InputError, did_you_mean
from pawnb.files import as_word
from pawnb.gait.analysis.leg_words import in_english, split_name
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.schema import Tracks
from pawnb.trial import Trial

_SIDE_WORDS = {"l": "L", "left": "L", "r": "R", "right": "R"}
_RANK_WORDS = {
    "f": "F", "fore": "F", "front": "F", "anterior": "F", "pro": "F",
    "m": "M", "mid": "M", "middle": "M", "meso": "M",
    "h": "H", "hind": "H", "rear": "H", "back": "H", "posterior": "H", "meta": "H",
    "hd": "H", "bk": "H", "prothoracic": "F", "mesothoracic": "M", "metathoracic": "H",
}  # fmt: skip
_LIMBS = ("paw", "leg", "limb", "foot", "feet", "hand", "hoof")
_DISTAL = (
    ("tip", "claw", "toe", "toes", "tao", "finger", "nail"),
    ("paw", "foot", "feet", "hand", "hoof", "tarsus", "ta"),
    ("mtp", "metatarsus", "ankle", "wrist"),
)
"""Words for parts of a leg, the outermost first; other parts are no feet when one of these is."""
_COUNTED_PARTS = frozenset({"leg", "limb", "claw", "tip", "tarsus", "ta"})
"""Words beside which a number counts legs from the front; beside a paw or toe it counts others."""
_NO_LEGS = frozenset({"ear", "eye", "tail", "wing", "antenna", "whisker", "palp"})
_REAR_PAIRS = (
    (("fl", "fr"), {"rl": ("L", "H"), "rr": ("R", "H")}),
    (("fl", "fr"), {"bl": ("L", "H"), "br": ("R", "H")}),
    (("lf", "rf"), {"lr": ("L", "H"), "rr": ("R", "H")}),
    (("lf", "rf"), {"lb": ("L", "H"), "rb": ("R", "H")}),
)
"""Letters of rear and back legs, which say so only beside those of front ones."""

_FOUR_LEGS = frozenset({"FR", "HR", "FL", "HL"})
_FRONT = ("snout", "nose", "head", "neck", "thorax")
_REAR = ("butt", "tailbase", "tail", "abdomen", "hip", "pelvis")
_NOT_REAR = ("tip", "end", "mid", "middle", "center", "centre", "distal")

_GLUED = re.compile(
    rf"(?P<rank>{'|'.join(sorted(_RANK_WORDS, key=len, reverse=True))})"
    rf"(?P<limb>{'|'.join(_LIMBS)})s?(?P<side>[lr])?"
)
_PAIR = re.compile(rf"([lr][fmh]|[fmh][lr])(?P<limb>(?:{'|'.join(_LIMBS)})s?)?")
_CHAIN = re.compile(r"(?P<leg>[LR]\d)(?P<part>[A-F])")


def guess_legs(points: Iterable[str]) -> dict[str, str]:
    """Guess which points are the feet, from their names.

    Understood are the names that pawnb itself uses (FR, L1, LF, ...), names in words
    (``Front Paw R``, ``hindpaw_left``, ``forelegL4``, ``LF_Claw``, ``claw_L1``), Anipose's fly
    legs (``L1A`` to ``L1E``), and R or B for rear or back legs beside F for front ones (FL, FR,
    RL, RR); German, French and Spanish words (``Vorderpfote links``), near and off sides of horses
    where both are there. Where several points belong to one leg the outermost is its foot.

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
    english = in_english(points)
    names = {name: point for point, name in english.items()}
    return {leg: names[name] for leg, name in _guess(list(names)).items()}


def _guess(points: Sequence[str]) -> dict[str, str]:
    """Guess legs of names in English words."""
    rears = _rear_pairs(points)
    own = {point: point for point in points if find_leg_place(point) is not None}
    guessed = _guess_from_words([point for point in points if point not in own], rears)
    if not own:
        return guessed
    four = {leg: point for leg, point in guessed.items() if leg in _FOUR_LEGS}
    if own.keys() <= _FOUR_LEGS:
        return four | own
    if own.keys() <= {leg[::-1] for leg in _FOUR_LEGS}:
        return {leg[::-1]: point for leg, point in four.items()} | own
    return own


def overlooked_points(points: Iterable[str], legs: Mapping[str, str]) -> list[str]:
    """Return points that are named like a part of a limb and belong to no leg that was guessed.

    Parameters
    ----------
    points : iterable of str
        Names of all points.
    legs : mapping
        Leg to point, as guessed.

    Returns
    -------
    list of str
        Such as ``left paw``, which does not say whether it is a front one.
    """
    english = in_english(points)
    rears = _rear_pairs(english.values())
    feet = set(legs.values())
    known = {(leg.side, leg.rank) for name in legs if (leg := find_leg_place(name)) is not None}
    found = []
    for point, name in english.items():
        words = split_name(name)
        if point in feet or set(words) & _NO_LEGS:
            continue
        read = _read(name, rears)
        if read is not None:
            (side, rank), _ = read
            place = find_leg_place(_leg_name(side, rank, six="M" in rank))
            if place is None or (place.side, place.rank) not in known:
                found.append(point)
        elif any(
            _GLUED.fullmatch(word)
            or _PAIR.fullmatch(word)
            or any(word in group for group in (_LIMBS, *_DISTAL[:2]))
            for word in words
        ):
            found.append(point)
    return found


def rival_points(points: Iterable[str], legs: Mapping[str, str]) -> list[str]:
    """Return points that are by their names as much the feet of legs as those that were guessed.

    Parameters
    ----------
    points : iterable of str
        Names of all points.
    legs : mapping
        Leg to point, as guessed.

    Returns
    -------
    list of str
        Such as ``paw_LF_bottom`` beside ``paw_LF_top``: one paw in two views of a picture.
    """
    english = in_english(points)
    rears = _rear_pairs(english.values())
    read = {point: _read(name, rears) for point, name in english.items()}
    taken = [read.get(point) for leg, point in legs.items() if leg != point]
    feet = set(legs.values())
    return [
        point
        for point, place in read.items()
        if place is not None and place in taken and point not in feet
    ]


def _rear_pairs(points: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Return what letters of rear and back legs mean beside those of the front ones."""
    words = {word for point in points for word in split_name(point)}
    if words & {"hl", "hr", "lh", "rh"}:
        return {}
    meant: dict[str, tuple[str, str]] = {}
    for fronts, rears in _REAR_PAIRS:
        if words & set(fronts):
            meant = rears | meant
    return meant


def _guess_from_words(
    points: Sequence[str], rears: Mapping[str, tuple[str, str]]
) -> dict[str, str]:
    """Guess legs of names that say side and place in words."""
    best = _outermost(points, rears)
    if not best:  # names of nothing but side and place, where they are those of all four legs
        bare = _outermost(points, rears, bare=True)
        best = bare if len(bare) == len(_FOUR_LEGS) else {}
    six = any(rank == "M" for _, rank in best)
    return {_leg_name(side, rank, six=six): point for (side, rank), point in sorted(best.items())}


def _outermost(
    points: Sequence[str], rears: Mapping[str, tuple[str, str]], *, bare: bool = False
) -> dict[tuple[str, str], str]:
    """Return the outermost point of each leg, by side and rank."""
    best: dict[tuple[str, str], tuple[int, str]] = {}
    for point in points:
        read = _read(point, rears, bare=bare)
        if read is None:
            continue
        place, depth = read
        if place not in best or depth < best[place][0]:
            best[place] = depth, point
    return {place: point for place, (_, point) in best.items()}


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
        Legs or points that are feet, or names of legs to names of points; default the trial's, else
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
        If no leg is named and none can be guessed, or a point that is named is not there.
    """
    points = [str(p) for p in tracks["keypoint"].to_numpy()]
    if isinstance(legs, str):
        raise InputError(f"legs is {legs!r}; expected a list such as ['FR', 'HR'].")
    if not points:
        raise InputError(f"{where}: no point at all; expected tracks of at least one foot.")
    told = dict(trial.tracks_legs if trial is not None else {})
    if isinstance(legs, Mapping):
        named = dict(legs)
    elif legs is not None:
        # a leg that the trial, or the names of the points, say which point it is
        known = guess_legs(points) | {point: point for point in points} | told
        named = {leg: known.get(leg, leg) for leg in legs}
        if len(named) < len(list(legs)):
            raise InputError(f"legs is {list(legs)}, with one of them twice; name each once.")
    elif told:
        named = told
    else:
        named = guess_legs(points)
    if not named:
        examples = _examples(points)
        typed = " ".join(f"{leg}={as_word(point)}" for leg, point in examples.items())
        raise InputError(
            f"{where}: none of the points {', '.join(points)} is named like a leg (FR, HR, FL, "
            f"HL; L1, R1, ...; LF, RH, ...); say which are, with legs={examples} or on the "
            f"command line --legs {typed}."
        )
    for leg, point in named.items():
        if point not in points:
            raise InputError(
                f"leg {leg!r}: the tracks have no point {point!r}{did_you_mean(point, points)}; "
                f"they have {', '.join(points)}."
            )
    feet = list(named.values())
    twice = next((foot for i, foot in enumerate(feet) if foot in feet[:i]), None)
    if twice is not None:
        raise InputError(f"{where}: two legs are the one point {twice!r}; name another.")
    return {leg: named[leg] for leg in sort_legs(named)}


def notes_on_legs(points: Iterable[str], named: Mapping[str, str]) -> list[str]:
    """Return notes on legs that nobody named: what was guessed, and what may be left out.

    Parameters
    ----------
    points : iterable of str
        Names of all points.
    named : mapping
        Leg to point, as guessed.

    Returns
    -------
    list of str
        The notes.
    """
    notes = []
    if any(leg != point for leg, point in named.items()):
        guess = ", ".join(f"{leg} is {point!r}" for leg, point in named.items())
        notes.append(
            f"legs were guessed from the names of points: {guess}; say others with legs (--legs)."
        )
    points = list(points)
    if rivals := rival_points(points, named):
        notes.append(
            f"{', '.join(rivals)}: by name as much feet of the same legs as the points that were "
            "taken, as where one picture holds two views; say which are meant with legs (--legs)."
        )
    if left_out := overlooked_points(points, named):
        notes.append(
            f"{', '.join(left_out)}: named like a part of a limb, and of no leg that is analysed "
            f"({', '.join(named)}); say which legs these are with legs (--legs)."
        )
    return notes


def _examples(points: Sequence[str]) -> dict[str, str]:
    """Return a leg and a point that may be its foot, and that of the other side if there is one."""
    no_feet = {*_NO_LEGS, *_FRONT, *_REAR}
    words = {point: split_name(name) for point, name in in_english(points).items()}
    likely = [*overlooked_points(points, {}), *reversed(points)]
    foot = next((point for point in likely if not no_feet & set(words[point])), points[-1])
    other = {"left": "right", "right": "left", "l": "r", "r": "l"}
    mirrored = [other.get(word, word) for word in words[foot]]
    feet = [foot, *(point for point in points if point != foot and words[point] == mirrored)][:2]
    found = {}
    for point in feet:
        ranks = [_read_word(word, {})[1] for word in words[point]]
        side = next((_SIDE_WORDS[word] for word in words[point] if word in _SIDE_WORDS), "R")
        found[("F" if "F" in ranks else "H") + side] = point
    return found


def _leg_name(side: str, rank: str, *, six: bool) -> str:
    """Return pawnb's name of a leg."""
    return f"{side}{rank}" if six or rank.isdigit() else f"{rank}{side}"


def _read(
    point: str, rears: Mapping[str, tuple[str, str]], *, bare: bool = False
) -> tuple[tuple[str, str], int] | None:
    """Return side and rank of a point's leg, and how far in it lies (0: outermost).

    Parameters
    ----------
    point : str
        Its name.
    rears : mapping
        Of :func:`_rear_pairs`.
    bare : bool
        Whether a name of nothing but side and rank is one of a leg, too.

    Returns
    -------
    tuple or None
        ``(side, rank), depth``; None where the name is not that of a leg.
    """
    chain = _CHAIN.fullmatch(point)
    if chain:
        leg = find_leg_place(chain["leg"])
        return ((leg.side, str(leg.rank)), ord("F") - ord(chain["part"])) if leg else None
    words = split_name(point)
    if set(words) & _NO_LEGS:
        return None
    side = next((_SIDE_WORDS[word] for word in words if word in _SIDE_WORDS), "")
    rank, limb = "", False
    for word in words:
        own_side, own_rank, is_limb = _read_word(word, rears)
        if own_rank and side and own_side not in ("", side):
            if word != "fr":  # "l_fr_paw": short for front
                return None
            own_side = ""
        side, rank, limb = side or own_side, rank or own_rank, limb or is_limb
    numbers = [word for word in words if word.isdigit()]
    if not rank and len(numbers) == 1 and set(words) & _COUNTED_PARTS:
        rank, limb = numbers[0], True
    parts = {*words, *(glued["limb"] for word in words if (glued := _GLUED.fullmatch(word)))}
    depth = next((i for i, group in enumerate(_DISTAL) if parts & {*group}), None)
    limb = limb or depth is not None or (bare and {*words} <= {*_SIDE_WORDS, *_RANK_WORDS})
    if not (side and rank and limb):
        return None
    return (side, rank), len(_DISTAL) if depth is None else depth


def _read_word(word: str, rears: Mapping[str, tuple[str, str]]) -> tuple[str, str, bool]:
    """Return the side and the rank that a word says (empty: none), and whether it is a limb's."""
    if word in rears:
        return *rears[word], True
    glued, pair = _GLUED.fullmatch(word), _PAIR.fullmatch(word)
    if glued:
        return _SIDE_WORDS.get(glued["side"], ""), _RANK_WORDS[glued["rank"]], True
    if pair:
        side = next(_SIDE_WORDS[letter] for letter in word[:2] if letter in "lr")
        return side, next(_RANK_WORDS[letter] for letter in word[:2] if letter in "fmh"), True
    return "", _RANK_WORDS.get(word, ""), word.rstrip("s") in _LIMBS


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
        head, neck, thorax), the first of each list that is there; None where there are not both.
    """
    words = {point: split_name(point) for point in points}

    def first(wanted: tuple[str, ...], refused: tuple[str, ...] = ()) -> str | None:
        for word in wanted:
            for point, own in words.items():
                if word in own and not set(own) & set(refused):
                    return point
        return None

    rear, front = first(_REAR, _NOT_REAR), first(_FRONT)
    return None if rear is None or front is None else (rear, front)
