"""Work on several things at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

THREADS = 2


def on_threads(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
    """Return what becomes of each item, in their order: each by itself, on any thread.

    Parameters
    ----------
    work : callable
        What to do with one item; compiled loops let other threads run.
    items : iterable
        The items.
    """
    with ThreadPoolExecutor(THREADS, thread_name_prefix="pawnb-decide") as pool:
        return list(pool.map(work, items))
