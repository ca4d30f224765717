"""Work on several things at once."""

from __future__ import annotations

import contextlib
import contextvars
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

import cv2
from threadpoolctl import ThreadpoolController

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


class _OneThread:
    """How many blocks ask for calls on one thread, and what gives the threads back."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asked = 0
        self._given_back = contextlib.ExitStack()

    def enter(self) -> None:
        """Take the threads, if this block is the first."""
        with self._lock:
            if not self._asked:
                limits = ThreadpoolController().limit(limits=1, user_api="blas")
                self._given_back.enter_context(limits)
                self._given_back.callback(cv2.setNumThreads, cv2.getNumThreads())
                cv2.setNumThreads(1)
            self._asked += 1

    def leave(self) -> None:
        """Give the threads back, if this block is the last."""
        with self._lock:
            self._asked -= 1
            if not self._asked:
                self._given_back.close()


_one_thread = _OneThread()


@contextlib.contextmanager
def calls_on_one_thread() -> Iterator[None]:
    """Let products of matrices and OpenCV run on the thread that asks, while the block runs.

    Where several threads call at once, threads of the linear algebra and of OpenCV wait by
    counting: on a busy machine learnt tracking took five times as much processor time by those of
    the one, and a twentieth more by those of the other. Results are the same, bit for bit. Blocks
    may overlap, on any threads: the last to end gives the threads back.
    """
    _one_thread.enter()
    try:
        yield
    finally:
        _one_thread.leave()


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
