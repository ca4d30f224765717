"""Names of points in other words, put into those that legs are guessed from.

Read are German, French and Spanish, near and off sides of horses, words that are written together,
and letters of sides and places, which mean something only where those of all four legs are there.
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
    said = {
        point: [new for word in own for new in _translate(word)] for point, own in words.items()
    }
    said = _horse_sides(_letters(said))
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
