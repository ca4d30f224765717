"""Work on several things at once."""

from __future__ import annotations

import contextvars
import os
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

THREADS = 2
_PARTS_A_THREAD = 4
"""Parts for each thread, so that none waits long for the last."""


class Threads(ThreadPoolExecutor):
    """Threads that work with the parameters that are in force where work is handed to them."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand over a call.

        Parameters
        ----------
        fn : callable
            What to call.
        *args, **kwargs
            What to call it with.

        Returns
        -------
        concurrent.futures.Future
            Its result, when it is there.
        """
        return super().submit(contextvars.copy_context().run, fn, *args, **kwargs)


def on_threads(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
    """Return what becomes of each item, in their order: each by itself, on any thread.

    Parameters
    ----------
    work : callable
        What to do with one item; compiled loops let other threads run.
    items : iterable
        The items.
    """
    items = list(items)
    if len(items) < 2:
        return [work(item) for item in items]
    with Threads(THREADS, thread_name_prefix="pawnb-decide") as pool:
        return list(pool.map(work, items))


def in_parts(work: Callable[..., _Result], *items: Iterable[Any]) -> list[_Result]:
    """Return what becomes of each of many small items, in their order, on all processors.

    They are handed to threads in parts: handing over one picture takes about a fifth of the time
    in which a place is found in it.

    Parameters
    ----------
    work : callable
        What to do with one item; numpy and OpenCV let other threads run.
    *items : iterable
        Its arguments, as for :func:`map`, of one length.

    Returns
    -------
    list
        The results.
    """
    rows = list(zip(*items, strict=True))
    workers = os.cpu_count() or 1
    size = max(1, -(-len(rows) // (_PARTS_A_THREAD * workers)))
    parts = [rows[begin : begin + size] for begin in range(0, len(rows), size)]
    with Threads(workers) as pool:
        found = pool.map(lambda part: [work(*row) for row in part], parts)
        return [one for own in found for one in own]
