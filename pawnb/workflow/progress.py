"""Progress: told to a caller, or shown as a bar on a terminal and in a notebook."""

from __future__ import annotations

import contextlib
import inspect
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pawnb.core.first_run import compiling_side_by_side

Progress = Callable[[int, int], None]
"""Called with what is done and what there is in all; while tracking also with ``doing``, what is
done now in words, if it takes that."""
COMPILING = "compiling (first run only)"


@contextmanager
def progress_bar(label: str, *, unit: str = "frame", then: str = "") -> Iterator[Progress | None]:
    """Show a bar with rate and time left while the block runs.

    Parameters
    ----------
    label : str
        Words before the bar.
    unit : str
        What is counted.
    then : str
        What is done after all of them, said as soon as they are counted.

    Yields
    ------
    callable or None
        ``progress(done, total)``; None where nobody would see a bar.
    """
    with _bar(label, unit, then) as bar:
        yield bar


@contextmanager
def given_or_bar(progress: Progress | None, label: str) -> Iterator[Progress | None]:
    """Tell a caller how far something is or, where none asks, show a bar.

    Parameters
    ----------
    progress : callable, optional
        The caller's ``progress(done, total)``.
    label : str
        Words before the bar.

    Yields
    ------
    callable or None
        ``progress(done, total)``; None where nobody would see a bar.
    """
    if progress is not None:
        yield progress
        return
    with progress_bar(label) as bar:
        yield bar


@contextmanager
def tracking_progress(
    progress: Progress | None, label: str, *, kind: str | None, then: str = ""
) -> Iterator[Progress | None]:
    """Tell a caller, or show, how far tracking is; what is compiled is compiled side by side.

    Parameters
    ----------
    progress : callable, optional
        ``progress(done, total)``. One that takes ``doing`` is told in words, too, what is done.
    label : str
        Those words, where nothing else is said.
    kind : str or None
        Which functions will be needed, see :mod:`pawnb.core.first_run`; None where no list says.
    then : str
        What is done after all frames are counted.

    Yields
    ------
    callable or None
        To be called with what is done, and what there is in all.
    """
    with contextlib.ExitStack() as stack:
        report: _Bar | _Told | None
        if progress is None:
            report = stack.enter_context(_bar(label, "frame", then))
        else:
            report = _Told(progress, label, then)
        tell = None if report is None else report.tell_compiling
        stack.enter_context(compiling_side_by_side(kind, tell))
        yield report


@contextmanager
def _bar(label: str, unit: str, then: str) -> Iterator[_Bar | None]:
    if not _is_seen():
        yield None
        return
    bar = _Bar(label, unit, then)
    try:
        yield bar
    finally:
        bar.close()


class _Bar:
    """A bar that is there from the first word on."""

    def __init__(self, label: str, unit: str, then: str) -> None:
        self._label, self._unit, self._then = label, unit, then
        self._bar: Any = None
        self._is_compiling = False

    def __call__(self, done: int, total: int) -> None:
        bar = self._shown()
        if bar.total != total:
            bar.reset(total=total)
            # what an earlier run has done tells nothing of the rate of this one
            bar.initial = bar.n = done - 1
        bar.update(done - bar.n)
        if self._then and done == total:
            self._say()

    def tell_compiling(self, begins: bool) -> None:
        """Say that it is compiled now, or no more."""
        self._is_compiling = begins
        self._shown()
        self._say()

    def close(self) -> None:
        """Leave the bar as it is at the end."""
        if self._bar is not None:
            self._bar.bar_format = None
            self._bar.set_description_str(self._label)
            self._bar.close()

    def _shown(self) -> Any:
        if self._bar is None:
            self._bar = _make_bar(self._label, self._unit)
        return self._bar

    def _say(self) -> None:
        """Show words in place of a percentage of frames, which would say nothing of the wait."""
        bar = self._bar
        is_counted = self._then and bar.n == bar.total
        words = [self._then] * bool(is_counted) + [COMPILING] * self._is_compiling
        counted = f", {{n_fmt}} of {{total_fmt}} {self._unit}s" if bar.n else ""
        bar.bar_format = f"{{desc}}{counted}" if words else None
        bar.set_description_str(", ".join([self._label, *words]))


class _Told:
    """A caller's progress, with words if it takes them."""

    def __init__(self, progress: Progress, label: str, then: str) -> None:
        self._progress: Any = progress
        self._label, self._then = label, then
        self._takes_words = _takes(progress, "doing")
        self._at, self._is_compiling = (0, 1), False

    def __call__(self, done: int, total: int) -> None:
        self._at = done, total
        if self._takes_words:
            self._progress(done, total, doing=self._words())
        else:
            self._progress(done, total)

    def tell_compiling(self, begins: bool) -> None:
        """Say that it is compiled now, or no more."""
        self._is_compiling = begins
        if self._takes_words:
            self._progress(*self._at, doing=self._words())

    def _words(self) -> str:
        is_counted = self._then and self._at[0] == self._at[1]
        return COMPILING if self._is_compiling else self._then if is_counted else self._label


def _takes(function: Callable, name: str) -> bool:
    """Return whether a function can be called with an argument of this name."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # one of those that cannot tell
        return False
    return any(
        (own.name == name and own.kind != own.POSITIONAL_ONLY) or own.kind == own.VAR_KEYWORD
        for own in parameters
    )


def _is_seen() -> bool:
    """Return whether somebody sees a bar."""
    return _in_notebook() or sys.stderr.isatty()


def _make_bar(label: str, unit: str) -> Any:
    """Return a tqdm bar that suits where we run."""
    if _in_notebook():
        from tqdm.notebook import tqdm as notebook_bar

        return notebook_bar(desc=label, unit=unit, total=1)
    from tqdm import tqdm

    width = None if _terminal_width() else 80  # else tqdm shows nothing at all
    return tqdm(desc=label, unit=unit, total=1, file=sys.stderr, ncols=width)


def _terminal_width() -> int:
    """Return the columns of the terminal; some, of scripts and containers, say they have none."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns
    except OSError:
        return 0


def _in_notebook() -> bool:
    """Return whether a kernel runs this; that its package was imported does not say so."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")
