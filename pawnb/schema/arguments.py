"""Arguments of public functions: one of another type than the signature says is refused.

What a function is given in the place of a table, a path or a number comes from a notebook, where
``None`` is what the cell before has not made. Without this it ends deep inside, or gives NaN.
"""

from __future__ import annotations

import builtins
import functools
import inspect
import math
import numbers
import os
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from pawnb.errors import InputError
from pawnb.schema.columns import check_finite
from pawnb.schema.settings import shown

ParametersT = ParamSpec("ParametersT")
ResultT = TypeVar("ResultT")

_WORDS: dict[Any, str] = {
    pd.DataFrame: "a table (pandas.DataFrame)",
    xr.Dataset: "Tracks (an xarray.Dataset)",
    np.ndarray: "numbers, as an array",
    float: "a number",
    int: "a whole number",
    bool: "True or False",
    str: "text",
    Path: "a path",
    os.PathLike: "a path",
}
_LISTS = (Sequence, Iterable, Collection, list, tuple)


def checked_arguments(function: Callable[ParametersT, ResultT]) -> Callable[ParametersT, ResultT]:
    """Make a function refuse an argument of another type than its annotation, in one sentence.

    Numbers must be finite, also in a table's columns that hold numbers; texts are no lists of
    names, and what is no table is said to be none. What an array holds, the range of a number and
    which word is known are the function's own affair. A value that is the parameter's default is
    taken as it is, and so is what the annotation does not tell.

    Parameters
    ----------
    function : callable
        A public function with annotations.

    Returns
    -------
    callable
        The same function, checked.

    Examples
    --------
    >>> from pawnb.schema.arguments import checked_arguments
    >>> @checked_arguments
    ... def halve(x: float) -> float:
    ...     return x / 2
    >>> halve(None)
    Traceback (most recent call last):
    ...
    pawnb.errors.InputError: x is None; expected a number.
    """
    signature = inspect.signature(function)
    hints: dict[str, Any] = {}

    @functools.wraps(function)
    def checked(*args: ParametersT.args, **kwargs: ParametersT.kwargs) -> ResultT:
        if not hints:
            hints.update(_hints_of(function))
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError:  # Python's own sentence names the argument
            return function(*args, **kwargs)
        for name, value in given.items():
            parameter = signature.parameters[name]
            is_whole = parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
            if is_whole and name in hints and value is not parameter.default:
                _check(name, value, hints[name])
                if isinstance(value, pd.DataFrame):
                    check_finite(value, where=name)
        return function(*args, **kwargs)

    return checked


class _Names(dict[str, Any]):
    """Names of a module; what is imported there for type checkers only is of any type."""

    def __missing__(self, name: str) -> Any:
        if name.startswith("__"):  # asked for by what looks at frames
            raise KeyError(name)
        return _Unknown


class _Unknown:
    """A type whose name is there for type checkers only, with or without its parts."""

    def __class_getitem__(cls, parts: object) -> Any:
        """Return it whatever its parts are."""
        return cls


def _hints_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of parameters."""
    names = _Names(vars(builtins) | getattr(function, "__globals__", {}))
    return typing.get_type_hints(function, localns=names)


def _check(name: str, value: Any, hint: Any) -> None:
    """Refuse a value that no member of its annotation allows."""
    options = _options(hint)
    if any(_allows(option, value) for option in options):
        for option in options:
            if _origin(option) in _LISTS:
                _check_items(name, value, option)
        return
    if isinstance(value, pd.DataFrame | xr.Dataset):
        value = type(value)  # a table of a hundred lines says no more
        raise InputError(f"{name} is of type {value.__name__}; expected {_describe(options)}.")
    raise InputError(f"{name} is {shown(value)}; expected {_describe(options)}.")


def _check_items(name: str, value: Any, option: Any) -> None:
    """Refuse an item of another type in a list; what can be read once only is not looked at."""
    inner = typing.get_args(option)[:1]
    if not isinstance(value, list | tuple) or not inner:
        return
    if typing.get_origin(option) is tuple and typing.get_args(option)[1:2] != (...,):
        return
    for item in value:
        is_name = str in inner and _is_number(item, whole=True)  # animals 1, 2, 3
        if not is_name and not any(_allows(kind, item) for kind in _options(inner[0])):
            found = type(item).__name__ if isinstance(item, pd.DataFrame) else shown(item)
            raise InputError(f"{name} holds {found}; expected a list{_of_items(inner)}.")


def _options(hint: Any) -> tuple[Any, ...]:
    """Return the members of a union, or the single type."""
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        return tuple(inner for one in typing.get_args(hint) for inner in _options(one))
    return (hint,)


def _origin(option: Any) -> Any:
    """Return the plain class of an annotation."""
    return typing.get_origin(option) or option


def _allows(option: Any, value: Any) -> bool:
    """Say whether one member of an annotation allows a value; of what is not known, yes."""
    kind = _origin(option)
    if kind is None or kind is type(None):
        return value is None
    if kind is typing.Literal:
        return isinstance(value, str)  # which of them, the function says itself
    if kind in (float, int):
        return _is_number(value, whole=kind is int)
    if kind is bool:
        return isinstance(value, bool | np.bool_) or (
            _is_number(value, whole=True) and value in (0, 1)
        )
    if kind in _LISTS:
        return isinstance(value, Iterable) and not isinstance(
            value, str | bytes | Mapping | pd.DataFrame | xr.Dataset
        )
    if kind is np.ndarray:
        return value is not None and not isinstance(
            value, str | bytes | Mapping | xr.Dataset | numbers.Number
        )
    if (
        kind in (Any, _Unknown)
        or not isinstance(kind, type)
        or getattr(kind, "_is_protocol", False)
    ):
        return True
    return isinstance(value, kind)


def _is_number(value: Any, *, whole: bool) -> bool:
    """Say whether a value is a number, a whole one where that is asked; NaN and inf are numbers."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return False
    return not whole or (math.isfinite(value) and value == value // 1)


def _of_items(inner: Sequence[Any]) -> str:
    """Say in words what the items of a list are."""
    if not inner:
        return ""
    return " of names" if inner[0] is str else f", each item {_describe(_options(inner[0]))}"


def _describe(options: Sequence[Any]) -> str:
    """Say in words what an annotation allows."""
    words = []
    for option in options:
        kind = _origin(option)
        if kind is type(None) or (
            kind is str and {Path, os.PathLike} & {_origin(o) for o in options}
        ):
            continue
        if kind is typing.Literal:
            words.append("one of " + ", ".join(repr(arg) for arg in typing.get_args(option)))
        elif kind in _LISTS:
            words.append(f"a list{_of_items(typing.get_args(option)[:1])}")
        elif kind is Mapping or kind is dict:
            words.append("names and values, as {name: value}")
        else:
            words.append(_WORDS.get(kind, getattr(kind, "__name__", str(kind))))
    return " or ".join(dict.fromkeys(words))
