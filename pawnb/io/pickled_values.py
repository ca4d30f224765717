"""Lists of names out of a pickle, without ever unpickling.

pandas and PyTables keep the names of columns in HDF5 as pickles. A pickle is a program: loading
one runs what its author wished. Here its opcodes are read one by one, and only those that make
lists, tuples, text, numbers, true, false and nothing are followed; any other, such as those that
name or call a function, is refused before anything is made of it.
"""

from __future__ import annotations

import pickletools
import struct
from collections.abc import Callable
from typing import Any

from pawnb.errors import InputError

_MARK = object()
_LITERALS = {
    "INT", "BININT", "BININT1", "BININT2", "LONG", "LONG1", "LONG4", "FLOAT", "BINFLOAT",
    "STRING", "BINSTRING", "SHORT_BINSTRING", "UNICODE", "BINUNICODE", "SHORT_BINUNICODE",
    "BINUNICODE8",
}  # fmt: skip
_CONSTANTS: dict[str, Callable[[], Any]] = {
    "NONE": lambda: None,
    "NEWTRUE": lambda: True,
    "NEWFALSE": lambda: False,
    "EMPTY_LIST": list,
    "EMPTY_TUPLE": tuple,
}
_PUTS, _GETS = {"PUT", "BINPUT", "LONG_BINPUT"}, {"GET", "BINGET", "LONG_BINGET"}
_FAULTS = (ValueError, IndexError, KeyError, TypeError, AttributeError, OverflowError, struct.error)


def read_pickled_values(data: bytes, *, where: str) -> Any:
    """Return the lists, tuples, text and numbers that a pickle holds.

    Parameters
    ----------
    data : bytes
        The pickle, of any protocol.
    where : str
        How messages name it: the file and the place in it.

    Returns
    -------
    object
        Lists and tuples of text, numbers, true, false and None.

    Raises
    ------
    InputError
        If it holds anything else, such as a call, or is damaged.
    """
    try:
        return _follow(data, where)
    except _FAULTS as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{where}: damaged ({' '.join(str(error).split())[:100]}); copy the file again from "
            "where it is whole, or use the csv that DeepLabCut writes beside it."
        ) from None


def _follow(data: bytes, where: str) -> Any:
    """Follow the opcodes of a pickle with a stack of plain values."""
    stack: list[Any] = []
    memo: dict[Any, Any] = {}
    for code, argument, _ in pickletools.genops(data):
        name = code.name
        if name == "STOP":
            (value,) = stack
            return value
        if name in _LITERALS:
            stack.append(argument)
        elif name in _CONSTANTS:
            stack.append(_CONSTANTS[name]())
        elif name in _PUTS or name == "MEMOIZE":
            memo[len(memo) if name == "MEMOIZE" else argument] = _last(stack, 1)[0]
        elif name in _GETS:
            stack.append(memo[argument])
        elif name in _BUILDERS:
            _BUILDERS[name](stack)
        elif name not in ("PROTO", "FRAME"):
            raise InputError(
                f"{where}: holds a pickled {name.lower()}, which could run a program when it is "
                "opened; only names and numbers are read from there. If you trust the file, use "
                "the csv of the same tracks."
            )
    raise ValueError("it ends too early")


def _append(stack: list[Any]) -> None:
    """Move the last value into the list below it."""
    (item,) = _last(stack, 1)
    stack.pop()
    _list_on(stack).append(item)


def _extend(stack: list[Any]) -> None:
    """Move the values above the last mark into the list below it."""
    items = _pop_to_mark(stack)
    _list_on(stack).extend(items)


def _make_tuple(stack: list[Any], n: int) -> None:
    """Put the last values into a tuple."""
    stack[-n:] = [tuple(_last(stack, n))]


def _last(stack: list[Any], n: int) -> list[Any]:
    """Return the last values of the stack, none of which may be a mark."""
    values = stack[-n:]
    if len(values) < n or any(value is _MARK for value in values):
        raise ValueError("values are missing")
    return values


def _pop_to_mark(stack: list[Any]) -> list[Any]:
    """Take the values above the last mark from the stack, and the mark."""
    values = []
    while (value := stack.pop()) is not _MARK:
        values.append(value)
    return values[::-1]


def _list_on(stack: list[Any]) -> list[Any]:
    """Return the list on top of the stack."""
    if not isinstance(stack[-1], list):
        raise TypeError("items are added to what is no list")
    return stack[-1]


_BUILDERS: dict[str, Callable[[list[Any]], None]] = {
    "MARK": lambda stack: stack.append(_MARK),
    "LIST": lambda stack: stack.append(_pop_to_mark(stack)),
    "TUPLE": lambda stack: stack.append(tuple(_pop_to_mark(stack))),
    "TUPLE1": lambda stack: _make_tuple(stack, 1),
    "TUPLE2": lambda stack: _make_tuple(stack, 2),
    "TUPLE3": lambda stack: _make_tuple(stack, 3),
    "APPEND": _append,
    "APPENDS": _extend,
}
"""What each opcode that makes a list or tuple does to the stack."""
