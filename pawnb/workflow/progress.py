"""Progress bars: on a terminal, in a notebook, and nowhere else."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = Callable[[int, int], None]
"""Called with what is done and what there is in all."""


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
    bar = _make_bar(label, unit)
    if bar is None:
        yield None
        return

    def update(done: int, total: int) -> None:
        if bar.total != total:
            bar.reset(total=total)
            # what an earlier run has done tells nothing of the rate of this one
            bar.initial = bar.n = done - 1
        bar.update(done - bar.n)
        if then and done == total:
            bar.set_description_str(f"{label}, {then}")

    try:
        yield update
    finally:
        if then:
            bar.set_description_str(label)
        bar.close()


def _make_bar(label: str, unit: str) -> Any:
    """Return a tqdm bar that suits where we run, or None."""
    if _in_notebook():
        from tqdm.notebook import tqdm as notebook_bar

        return notebook_bar(desc=label, unit=unit, total=1)
    if sys.stderr.isatty():
        from tqdm import tqdm

        width = None if _terminal_width() else 80  # else tqdm shows nothing at all
        return tqdm(desc=label, unit=unit, total=1, file=sys.stderr, ncols=width)
    return None


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
