"""Settings: frozen dataclasses made from plain values, with errors that say what was expected."""

from __future__ import annotations

import dataclasses
import json
import math
import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pawnb.errors import InputError, did_you_mean

SettingsT = TypeVar("SettingsT")


def build_settings(cls: type[SettingsT], values: Mapping[str, Any], *, where: str) -> SettingsT:
    """Make a frozen settings dataclass from plain values; refuse what it does not know.

    Parameters
    ----------
    cls : type
        A dataclass whose fields all have defaults.
    values : mapping
        Field names to values; text (as from ``--set``) is read as JSON where it can be.
    where : str
        Where the values come from, for the message.

    Returns
    -------
    cls
        The settings.

    Raises
    ------
    InputError
        For an unknown name (a near one is suggested) or a value of the wrong type.
    """
    fields = {f.name for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    hints = typing.get_type_hints(cls)
    clean: dict[str, Any] = {}
    for name, value in values.items():
        if name not in fields:
            raise InputError(
                f"{where}: unknown name {name!r}{did_you_mean(name, fields)}; "
                f"known are {', '.join(sorted(fields))}."
            )
        clean[name] = _convert(value, hints[name], f"{where}: {name}")
    return cls(**clean)


def check_ranges(
    settings: Any, *, above_0: Sequence[str] = (), least_0: Sequence[str] = ()
) -> None:
    """Refuse settings that are not above 0, or below it; None (work it out) is welcome.

    Parameters
    ----------
    settings : dataclass
        The settings.
    above_0, least_0 : sequence of str
        Names of those that must be above 0, and of those that may be 0 too.

    Raises
    ------
    InputError
        For the first number that is out of range, infinite or not a number.
    """
    for name in (*above_0, *least_0):
        value = getattr(settings, name)
        if value is None or (
            math.isfinite(value) and (value > 0 or (value == 0 and name in least_0))
        ):
            continue
        words = "a number, 0 or more" if name in least_0 else "a number above 0"
        raise InputError(f"setting {name!r} is {value}; expected {words}.")


def _options(hint: Any) -> tuple[Any, ...]:
    """Return the members of a union, or the single type."""
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        return typing.get_args(hint)
    return (hint,)


def _convert(value: Any, hint: Any, what: str) -> Any:
    """Convert one plain value to the annotated type, or say what was expected."""
    options = _options(hint)
    if (
        isinstance(value, str)
        and str not in options
        and not any(typing.get_origin(option) is typing.Literal for option in options)
    ):
        try:
            value = json.loads(value.lower() if value in {"True", "False", "None"} else value)
        except json.JSONDecodeError:
            raise InputError(f"{what} is {value!r}; expected {_describe(hint)}.") from None
    if value is None and type(None) in options:
        return None
    for option in options:
        origin, args = typing.get_origin(option), typing.get_args(option)
        if origin is typing.Literal and value in args:
            return value
        if origin is tuple and isinstance(value, list | tuple):
            inner = args[:1] * len(value) if len(args) == 2 and args[1] is ... else args
            if len(inner) == len(value):
                return tuple(_convert(v, t, what) for v, t in zip(value, inner, strict=True))
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if option is float and number:
            return float(value)
        if option is int and number and value == value // 1:
            return int(value)
        if option in (bool, str) and isinstance(value, option):
            return value
    raise InputError(f"{what} is {value!r}; expected {_describe(hint)}.")


def _describe(hint: Any) -> str:
    """Say in words what a type annotation allows."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if len(_options(hint)) > 1:
        return " or ".join(_describe(option) for option in args if option is not type(None))
    if origin is typing.Literal:
        return "one of " + ", ".join(repr(a) for a in args)
    if origin is tuple:
        if len(args) == 2 and args[1] is ...:
            return f"a list, each item {_describe(args[0])}"
        return f"a list of {len(args)}, each {_describe(args[0])}"
    words = {
        float: "a number",
        int: "a whole number",
        bool: "true or false",
        str: "text",
    }
    return words.get(hint, str(hint))
