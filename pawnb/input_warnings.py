"""Warnings about what a user gave: how they are said, and how a run hears its own.

Python keeps what is done with warnings for the whole process, and libraries change that on every
thread: a run that listened there would miss some of its own while, beside it, a widget analyses.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from pawnb.errors import InputWarning

_PASSED_OVER = "pawnb.schema.arguments"
"""Layout: the module whose wrapper stands between a function and the line that calls it."""


@dataclass(frozen=True)
class _Listener:
    """Who hears the warnings of a block, and whether they are shown as well."""

    hear: Callable[[InputWarning], object]
    is_shown: bool


_listeners: ContextVar[tuple[_Listener, ...]] = ContextVar("listeners", default=())

# a run that is made again says again what is doubtful; filters of the user's own come first
warnings.simplefilter("always", InputWarning, append=True)


def warn_of_input(
    sentence: str, category: type[InputWarning] = InputWarning, *, stacklevel: int = 1
) -> None:
    """Warn of something that a user gave.

    Parameters
    ----------
    sentence : str
        What was found, what was expected and how to mend it.
    category : type
        The kind of warning.
    stacklevel : int
        As of :func:`warnings.warn`: 1 names the line that calls this, 2 the one that called it.

    Warns
    -----
    InputWarning
        Unless the block that this runs in keeps its warnings to itself.
    """
    for listener in reversed(_listeners.get()):
        listener.hear(category(sentence))
        if not listener.is_shown:
            return
    warnings.warn(sentence, category, stacklevel=_level_of_caller(stacklevel))


def _level_of_caller(stacklevel: int) -> int:
    """Return the level, for a warning of the function that asks, of a function above its caller."""
    frame, level = sys._getframe(2), 2
    while stacklevel > 1 and frame.f_back is not None:
        frame, level = frame.f_back, level + 1
        stacklevel -= frame.f_globals.get("__name__") != _PASSED_OVER
    return level


def hide_warnings_of(library: str | None = None, *, saying: str = "") -> None:
    """Show no more what a library warns of, of odd files for example, which pawnb tells itself.

    This is for good: filters are those of all threads, and one that is taken back where another
    thread set its own may hide, or show, what it was not meant for.

    Parameters
    ----------
    library : str, optional
        Name of the package whose modules warn; default any, for libraries that warn in the name of
        who calls them.
    saying : str
        How the warnings begin, as a regular expression; default all of them.
    """
    module = "" if library is None else rf"{re.escape(library)}(\.|$)"
    warnings.filterwarnings("ignore", saying, module=module)


@contextmanager
def hearing_input_warnings(
    hear: Callable[[InputWarning], object], *, shown: bool
) -> Iterator[None]:
    """Hear what is warned of in a block and its threads (:mod:`pawnb.core.parallel`).

    Parameters
    ----------
    hear : callable
        Is called with each :class:`~pawnb.errors.InputWarning`.
    shown : bool
        Whether it is shown as ever, and heard by blocks around this one, too.
    """
    token = _listeners.set((*_listeners.get(), _Listener(hear, shown)))
    try:
        yield
    finally:
        _listeners.reset(token)
