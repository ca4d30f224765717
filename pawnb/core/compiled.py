"""Loops over numbers, compiled: numba, the compiled code kept on disk for the next run."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

_F = TypeVar("_F", bound=Callable)
_LOOSE = {"contract", "arcp", "nsz", "reassoc"}
"""Sums in another order, one division for several: the last digits differ. NaN stays NaN."""
_UNREADABLE = (AttributeError, ImportError, EOFError)
"""What reading kept code raises where it names types that were renamed or moved since."""


class Compiled:
    """A function compiled for Python, and once more without what only Python needs, for loops.

    Unpacking Python's arguments, tuples of arrays above all, is up to half of a small
    function's code; what only compiled functions call is compiled without it, and is kept as a
    part of them.

    Parameters
    ----------
    function : callable
        What to compile.
    how : dict
        Options of ``numba.njit``.
    """

    every: list[Compiled] = []  # noqa: RUF012
    """All there are, in the order in which they were made."""
    before_first_call: Callable[[Compiled], None] | None = None
    """Asked before any of them is called from Python for the first time."""

    def __init__(self, function: Callable, how: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self.name = f"{function.__module__}:{function.__qualname__}"
        """Module and name, from which it can be imported."""
        self.sources: set[str] = {function.__code__.co_filename}
        """Files of the function and of all that it may call."""
        for other in function.__globals__.values():
            if isinstance(other, Compiled):
                self.sources |= other.sources
        njit: Any = numba.njit
        options = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, **how}
        try:
            self._called = njit(cache=True, **options)(function)
            self.is_kept = True
            self._check_all_sources()
        except RuntimeError:  # numba: "cannot cache function: no locator available"
            self._called = njit(**options)(function)
            self.is_kept = False
        self._inside = njit(no_cpython_wrapper=True, **options)(function)
        self.is_called = False
        Compiled.every.append(self)

    def _check_all_sources(self) -> None:
        """Let code that is kept be old where a file has changed from which it was compiled.

        Numba looks at the function's own file only: what it calls may be in others.
        """
        with contextlib.suppress(AttributeError, OSError):  # another numba; not in a folder
            self._pass_over_unreadable_code()
            index = self._called._cache._cache_file
            about = [(path.name, path.stat()) for path in map(Path, sorted(self.sources))]
            stamps = [(name, stat.st_mtime, stat.st_size) for name, stat in about]
            index._source_stamp = (index._source_stamp, *stamps)

    def _pass_over_unreadable_code(self) -> None:
        """Let code that is kept count as none where it cannot be read.

        Numba reads the list of it first, types of arguments among it, and only then looks whether
        it is of these files: after an update that renames a type the first call would fail.
        """
        index = self._called._cache._cache_file
        read = index._load_index

        def read_if_readable() -> dict:
            with contextlib.suppress(*_UNREADABLE):
                return dict(read())
            return {}

        index._load_index = read_if_readable

    def __call__(self, *arguments: Any) -> Any:  # noqa: D102 - as the function
        if not self.is_called:
            if Compiled.before_first_call is not None:
                Compiled.before_first_call(self)
            self.is_called = True
        return self._called(*arguments)

    @property
    def _numba_type_(self) -> Any:
        """What numba takes it for where a compiled function calls it."""
        return self._inside._numba_type_

    @property
    def signatures(self) -> list[tuple]:
        """Numba's types of the arguments for which there is compiled code that Python calls."""
        return list(self._called.signatures)

    def has_code(self) -> bool:
        """Return whether any code is kept, be it of an earlier version."""
        folder = Path(self._called.stats.cache_path or "")
        return any(folder.glob(f"*.{self.name.partition(':')[2]}-*.nbi"))

    def compile_for(self, arguments: tuple) -> None:
        """Compile for arguments of such types, or read the code that is kept."""
        self._called.compile(arguments)


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
    return cast("_F", Compiled(function, {}))


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
    return cast("_F", Compiled(function, {"fastmath": _LOOSE}))


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
    return cast("_F", Compiled(function, {"fastmath": _LOOSE, "forceinline": True}))


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
