"""Names of points in other words, put into those that legs are guessed from.

Read are German, French and Spanish, near and off sides of horses, words that are written together,
the signs of Chinese and Japanese, and letters of sides and places and Roman numbers, which mean
something only where those of other legs are there.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

_TRANSLATED = {
    "links": "left", "linke": "left", "linker": "left", "linkes": "left", "linken": "left",
    "rechts": "right", "rechte": "right", "rechter": "right", "rechtes": "right",
    "rechten": "right", "vorn": "front", "vorne": "front", "vordere": "front", "hinten": "hind",
    "hintere": "hind", "pfote": "paw", "pfoten": "paw", "bein": "leg", "fuss": "foot",
    "huf": "hoof", "zehe": "toe", "zehen": "toe", "kralle": "claw", "handgelenk": "wrist",
    "sprunggelenk": "ankle",
    "gauche": "left", "droit": "right", "droite": "right", "avant": "front", "arriere": "hind",
    "anterieur": "front", "anterieure": "front", "posterieur": "hind", "posterieure": "hind",
    "patte": "paw", "pied": "foot", "sabot": "hoof", "membre": "limb", "jambe": "leg",
    "doigt": "toe", "griffe": "claw", "poignet": "wrist", "cheville": "ankle",
    "izquierda": "left", "izquierdo": "left", "derecha": "right", "derecho": "right",
    "delantera": "front", "delantero": "front", "trasera": "hind", "trasero": "hind",
    "pata": "paw", "pie": "foot", "mano": "hand", "pierna": "leg", "miembro": "limb",
    "extremidad": "limb", "pezuna": "hoof", "casco": "hoof", "dedo": "toe", "garra": "claw",
    "muneca": "wrist", "tobillo": "ankle",
}  # fmt: skip
"""Words that mean one thing. Not read: ``der``, right in Spanish and "of the" in German; hands and
feet, or wrists and ankles, which say fore and hind of a quadruped only, and not of a person."""

_LETTERS = (
    (("vl", "vr", "hl", "hr"), "German: vorne, hinten; links, rechts"),
    (("avg", "avd", "arg", "ard"), "French: avant, arrière; gauche, droite"),
    (("ag", "ad", "pg", "pd"), "French: antérieur, postérieur; gauche, droit"),
    (("di", "dd", "ti", "td"), "Spanish: delantera, trasera; izquierda, derecha"),
)
"""Letters of the front left, front right, hind left and hind right leg."""
_LETTERS_IN_ENGLISH = ("fl", "fr", "hl", "hr")

_LIMB_LETTERS = {
    "fl": ("fore", "limb"), "hl": ("hind", "limb"), "bl": ("back", "limb"), "rl": ("rear", "limb"),
}  # fmt: skip

_SIGNS = str.maketrans(
    {"左": " left ", "右": " right ", "前": " front ", "中": " mid ", "后": " hind ",
     "後": " hind ", "足": " foot ", "爪": " claw ", "脚": " foot ", "蹄": " hoof ",
     "腿": " leg ", "肢": " limb ", "趾": " toe ", "尖": " tip ", "腕": " wrist ",
     "踝": " ankle ", "耳": " ear ", "眼": " eye ", "尾": " tail "}
)  # fmt: skip
_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4"}
_ROMAN_LEG = re.compile(r"(?P<side>[lr])(?P<number>i{1,3}|iv)")

_WORDS_OF_NAME = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_GERMAN = re.compile(
    r"(?P<rank>vorder|mittel|hinter)(?P<limb>pfote|bein|fuss|huf|lauf|tatze|zehe|kralle)n?"
)
_GERMAN_RANKS = {"vorder": "front", "mittel": "mid", "hinter": "hind"}
_RANKS = "fore|front|mid|middle|hind|rear|back"
_ENDS = "(paw|leg|limb|foot|hand|hoof|toe|claw|tip)?"
_TOGETHER = re.compile(rf"({_RANKS}){_ENDS}(left|right){_ENDS}|(left|right)({_RANKS}){_ENDS}")
_HORSE_SIDE = re.compile(
    rf"(?P<side>near|off)(?:side)?(?P<rank>{_RANKS})?(?P<limb>paw|leg|limb|foot|feet|hoof)?"
)


def in_english(points: Iterable[str]) -> dict[str, str]:
    """Return names of points in the words that legs are guessed from.

    Parameters
    ----------
    points : iterable of str
        Names as they are.

    Returns
    -------
    dict
        Each name to the one in English words; to itself where nothing was to be said otherwise,
        and everywhere where two names would be one.
    """
    points = list(points)
    words = {point: split_name(point) for point in points}
    plain = {point: split_name(point.translate(_SIGNS)) for point in points}
    said = {
        point: [new for word in own for new in _translate(word)] for point, own in plain.items()
    }
    said = _roman_numbers(_horse_sides(_limb_letters(_letters(said))))
    new = {
        point: point if said[point] == words[point] else " ".join(said[point]) for point in points
    }
    return new if len(set(new.values())) == len(points) else {point: point for point in points}


def split_name(point: str) -> list[str]:
    """Return the words of a name, in small letters without accents.

    Parameters
    ----------
    point : str
        A name, such as ``Front Paw R`` or ``hindPawL``.

    Returns
    -------
    list of str
        Such as front, paw, r.
    """
    apart = unicodedata.normalize("NFKD", point.replace("ß", "ss"))
    plain = "".join(letter for letter in apart if not unicodedata.combining(letter))
    return [word.lower() for word in _WORDS_OF_NAME.findall(plain)]


def _translate(word: str) -> list[str]:
    """Return the English words of one word."""
    if word in _TRANSLATED:
        return [_TRANSLATED[word]]
    german, together = _GERMAN.fullmatch(word), _TOGETHER.fullmatch(word)
    if german:
        return [_GERMAN_RANKS[german["rank"]], _TRANSLATED.get(german["limb"], "leg")]
    return [part for part in together.groups() if part] if together else [word]


def _letters(said: dict[str, list[str]]) -> dict[str, list[str]]:
    """Read letters of sides and places where those of all four legs are there."""
    words = {word for own in said.values() for word in own}
    for letters, _language in _LETTERS:
        if words >= set(letters) and not words & ({"fl", "fr"} - set(letters)):
            meant = dict(zip(letters, _LETTERS_IN_ENGLISH, strict=True))
            return {point: [meant.get(word, word) for word in own] for point, own in said.items()}
    return said


def _limb_letters(said: dict[str, list[str]]) -> dict[str, list[str]]:
    """Read FL and HL as fore- and hindlimb where the right has them, too: L_FL, R_FL; LFL, RFL."""
    words = {word for own in said.values() for word in own}
    if words & {"fr", "hr", "br", "rr"}:
        return said
    meant: dict[str, list[str]] = {}
    for letters, limb in _LIMB_LETTERS.items():
        beside = {word for own in said.values() if letters in own for word in own}
        if beside & {"l", "left"} and beside & {"r", "right"}:
            meant[letters] = [*limb]
        if {f"l{letters}", f"r{letters}"} <= words:
            meant |= {f"{side}{letters}": [side, *limb] for side in "lr"}
    return {
        point: [new for word in own for new in meant.get(word, [word])]
        for point, own in said.items()
    }


def _roman_numbers(said: dict[str, list[str]]) -> dict[str, list[str]]:
    """Read I, II, III and IV as numbers of legs where the first three of them are there."""
    words = {word for own in said.values() for word in own}
    if words >= {"i", "ii", "iii"}:
        return {point: [_ROMAN.get(word, word) for word in own] for point, own in said.items()}
    if not words >= {"li", "lii", "liii"} and not words >= {"ri", "rii", "riii"}:
        return said

    def read(word: str) -> list[str]:
        match = _ROMAN_LEG.fullmatch(word)
        return ["leg", _ROMAN[match["number"]], match["side"]] if match else [word]

    return {point: [new for word in own for new in read(word)] for point, own in said.items()}


def _horse_sides(said: dict[str, list[str]]) -> dict[str, list[str]]:
    """Read near and off as left and right where both are there: near and far are of a camera."""
    found = [_HORSE_SIDE.fullmatch(word) for own in said.values() for word in own]
    if {match["side"] for match in found if match} != {"near", "off"}:
        return said

    def read(word: str) -> Sequence[str]:
        match = _HORSE_SIDE.fullmatch(word)
        if match is None:
            return [word]
        side = "left" if match["side"] == "near" else "right"
        return [side, *(part for part in (match["rank"], match["limb"]) if part)]

    return {
        point: [new for word in own if word != "side" for new in read(word)]
        for point, own in said.items()
    }
