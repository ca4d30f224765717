"""Words of the command line that are pairs: NAME=VALUE, LEG=POINT, NAME=EVENT."""

from __future__ import annotations

from collections.abc import Sequence

from pawnb.errors import InputError


def split_settings(words: Sequence[str]) -> dict[str, str]:
    """Split settings of a method.

    Parameters
    ----------
    words : sequence of str
        ``NAME=VALUE``.

    Returns
    -------
    dict
        Name to value.

    Raises
    ------
    InputError
        If a word is no such pair.
    """
    pairs = [_split(word, "--set", "NAME=VALUE", "--set median_px=3") for word in words]
    return {name.strip(): value.strip() for name, value in pairs}


def split_legs(words: Sequence[str] | None) -> list[str] | dict[str, str] | None:
    """Split names of legs, some with the names that the file has for them.

    Parameters
    ----------
    words : sequence of str, optional
        ``LEG`` or ``LEG=POINT``.

    Returns
    -------
    list of str, dict or None
        Leg to point where any word is a pair; else as they are.

    Raises
    ------
    InputError
        If a word lacks one of the two names, or a leg is there twice.
    """
    if words is None or not any("=" in word for word in words):
        return None if words is None else list(words)
    pairs = [
        _split(word, "--legs", "LEG=POINT", "HR=hindpaw_R") if "=" in word else (word, word)
        for word in words
    ]
    legs = [leg for leg, _ in pairs]
    twice = next((leg for i, leg in enumerate(legs) if leg in legs[:i]), None)
    if twice is not None:
        raise InputError(f"--legs: leg {twice!r} is there twice; give each leg one point.")
    return dict(pairs)


def split_event_names(words: Sequence[str] | None) -> dict[str, str] | None:
    """Split what a table of events calls them.

    Parameters
    ----------
    words : sequence of str, optional
        ``NAME=EVENT``.

    Returns
    -------
    dict or None
        Name in the table to event.

    Raises
    ------
    InputError
        If a word is no such pair.
    """
    if words is None:
        return None
    return dict(_split(word, "--event-names", "NAME=EVENT", "down=TD") for word in words)


def _split(word: str, option: str, form: str, example: str) -> tuple[str, str]:
    """Split one word at its first equals sign."""
    name, equals, value = word.partition("=")
    if not equals or not name or not value:
        raise InputError(f"{option} {word}: expected {form}, for instance {example}.")
    return name, value
