"""Loops over numbers, compiled: numba, the compiled code kept on disk for the next run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, cast

import numba
from numba.core import event

_F = TypeVar("_F", bound=Callable)
_LOOSE = {"contract", "arcp", "nsz", "reassoc"}
"""Sums in another order, one division for several: the last digits differ. NaN stays NaN."""


def compiled(function: _F) -> _F:
    """Compile a function of arrays and numbers when it is first called.

    While it runs, other threads run too. The code is kept beside the module, or else in the
    user's cache folder; where neither can be written, it is compiled again in every session.

    Parameters
    ----------
    function : callable
        What to compile.

    Returns
    -------
    callable
        The same, fast.
    """
    return _compiled(function)


def compiled_loosely(function: _F) -> _F:
    """Compile as :func:`compiled`, with sums in whatever order is fastest.

    Parameters
    ----------
    function : callable
        What to compile; its last digits need not be the same on another machine.

    Returns
    -------
    callable
        The same, faster.
    """
    return _compiled(function, fastmath=_LOOSE)


def compiled_inside(function: _F) -> _F:
    """Compile as :func:`compiled_loosely`, into each compiled function that calls it.

    Parameters
    ----------
    function : callable
        What loops call for every pixel: passing it an animal takes longer than its work.

    Returns
    -------
    callable
        The same.
    """
    return _compiled(function, fastmath=_LOOSE, forceinline=True)


@contextmanager
def time_compiling() -> Iterator[Callable[[], float]]:
    """Measure how long functions are compiled, or their compiled code is read, in the block.

    Yields
    ------
    callable
        Seconds of that until now, on all threads: one at a time does it.
    """
    listener = event.TimingListener()  # type: ignore[no-untyped-call]

    def seconds() -> float:
        return float(listener.duration) if listener.done else 0.0

    with event.install_listener("numba:compiler_lock", listener):
        yield seconds


def _compiled(function: _F, **how: Any) -> _F:
    try:
        return cast("_F", numba.njit(cache=True, nogil=True, error_model="numpy", **how)(function))
    except RuntimeError:  # numba: "cannot cache function: no locator available"
        return cast("_F", numba.njit(nogil=True, error_model="numpy", **how)(function))
