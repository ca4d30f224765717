"""Work on several things at once."""

from __future__ import annotations

import contextvars
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")

THREADS = 2


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
