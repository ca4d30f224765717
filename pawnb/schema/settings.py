"""Settings: frozen dataclasses made from plain values, with errors that say what was expected."""

from __future__ import annotations

import dataclasses
import json
import math
import numbers
import os
import reprlib
import types
import typing
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pawnb.errors import InputError, did_you_mean

SettingsT = TypeVar("SettingsT")

_MOST = 1e300
"""Numbers beyond it, and infinite ones, are none that anybody means."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 100
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = 8


def build_settings(
    cls: type[SettingsT], values: Mapping[str, Any], *, where: str, typed: bool = False
) -> SettingsT:
    """Make a frozen settings dataclass from plain values; refuse what it does not know.

    Parameters
    ----------
    cls : type
        A dataclass whose fields all have defaults.
    values : mapping
        Field names to values; text (as from ``--set``) is read as JSON where it can be.
    where : str
        Where the values come from, for the message.
    typed : bool
        Whether the values have their types already (TOML): text then stands for text only.

    Returns
    -------
    cls
        The settings.

    Raises
    ------
    InputError
        For an unknown name (a near one is suggested) or a value of the wrong type.
    """
    if not isinstance(values, Mapping):
        raise InputError(
            f"{where}: settings are {shown(values)}; expected names and values, as {{name: value}}."
        )
    fields = {f.name for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    hints = _hints(cls)
    clean: dict[str, Any] = {}
    for name, value in values.items():
        if name not in fields:
            raise InputError(
                f"{where}: unknown name {name!r}{did_you_mean(name, fields)}; "
                f"known are {', '.join(sorted(fields))}."
            )
        clean[name] = _convert(value, hints[name], f"{where}: {name}", typed=typed)
    return cls(**clean)


def check_fields(item: Any, *, where: str) -> None:
    """Check the types of a frozen dataclass's fields, for its ``__post_init__``.

    What is of the type in other words is changed to it: a list to a tuple, a path to text, a
    whole number to float.

    Parameters
    ----------
    item : dataclass
        What was made.
    where : str
        What it is, for the message.

    Raises
    ------
    InputError
        For the first field whose value is of another type, or is no finite number.
    """
    hints = _hints(type(item))
    for field in dataclasses.fields(item):
        value = getattr(item, field.name)
        what = f"{where} {field.name}"
        object.__setattr__(item, field.name, _convert(value, hints[field.name], what, typed=True))


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


_HINTS: dict[type, dict[str, Any]] = {}
"""Types of the fields of each dataclass that was asked for: to work them out takes a while."""


def _hints(cls: type) -> dict[str, Any]:
    """Return the types of a dataclass's fields."""
    if cls not in _HINTS:
        _HINTS[cls] = typing.get_type_hints(cls)
    return _HINTS[cls]


def _options(hint: Any) -> tuple[Any, ...]:
    """Return the members of a union, or the single type."""
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        return typing.get_args(hint)
    return (hint,)


def _convert(value: Any, hint: Any, what: str, *, typed: bool) -> Any:
    """Convert one plain value to the annotated type, or say what was expected."""
    options = _options(hint)
    if (
        not typed
        and isinstance(value, str)
        and str not in options
        and not any(typing.get_origin(option) is typing.Literal for option in options)
    ):
        try:
            value = json.loads(value.lower() if value in {"True", "False", "None"} else value)
        except (ValueError, RecursionError):
            raise InputError(f"{what} is {shown(value)}; expected {_describe(hint)}.") from None
    if value is None and type(None) in options:
        return None
    for option in options:
        origin, args = typing.get_origin(option), typing.get_args(option)
        if origin is typing.Literal and value in args:
            return value
        if origin is tuple and isinstance(value, list | tuple):
            inner = args[:1] * len(value) if len(args) == 2 and args[1] is ... else args
            if len(inner) == len(value):
                return tuple(
                    _convert(v, t, what, typed=typed) for v, t in zip(value, inner, strict=True)
                )
        fitting = _fit(value, option if origin is None else origin)
        if fitting is not None:
            return fitting
    raise InputError(f"{what} is {shown(value)}; expected {_describe(hint)}.")


def _fit(value: Any, kind: Any) -> Any:
    """Return a value as one of a plain type, or None where it is of another."""
    if kind in (float, int):
        is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
        if is_number and abs(value) < _MOST and (kind is float or value == value // 1):
            return kind(value)
        return None
    if kind is str and isinstance(value, os.PathLike):
        return Path(value).as_posix()  # no backslashes of Windows: what is written is read anywhere
    if kind is Path and isinstance(value, str | os.PathLike):
        return Path(value)
    return value if kind is Any or (kind is not tuple and _is_a(value, kind)) else None


def _is_a(value: Any, kind: Any) -> bool:
    """Tell whether a value is of a class; what is annotated otherwise is none."""
    return isinstance(kind, type) and isinstance(value, kind)


def each_of(
    items: Any, *, what: str, kinds: tuple[type, ...] = (str, os.PathLike), one: bool = True
) -> list[Any]:
    """Return one item or several as a list; a text is one item, not its letters.

    Parameters
    ----------
    items : object or iterable
        What was given.
    what : str
        What the items are, for the message ("inputs").
    kinds : tuple of type
        What an item may be.
    one : bool
        Whether a single item will do, without a list around it.

    Returns
    -------
    list
        The items, at least one.

    Raises
    ------
    InputError
        If there is none, or one is of another kind.
    """
    is_one = isinstance(items, kinds)
    if is_one and one:
        return [items]
    if is_one or not isinstance(items, Iterable) or isinstance(items, str | bytes | Mapping):
        raise InputError(f"{what} is {shown(items)}; expected a list of them.")
    found = list(items)
    if not found:
        raise InputError(f"no {what}; name at least one.")
    for item in found:
        if not isinstance(item, kinds):
            raise InputError(
                f"{what} holds {shown(item)}; expected {' or '.join(k.__name__ for k in kinds)}."
            )
    return found


def shown(value: Any) -> str:
    """Return a value as a message shows it: as Python writes it, but not at great length."""
    return _SHORT.repr(value)


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
        Path: "a folder",
    }
    return words.get(hint, getattr(origin or hint, "__name__", str(hint)))
