"""Stopping a run with Ctrl-C, or with a notebook's stop button, without losing what is done."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Turn the first interrupt while the block runs into a wish to stop.

    Yields
    ------
    callable
        Answers True once a person has interrupted. A second interrupt raises
        KeyboardInterrupt. Outside the main thread, where Python hands out no signals,
        it always answers False.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    asked = threading.Event()

    def wish(_number: int, _frame: FrameType | None) -> None:
        if asked.is_set():
            raise KeyboardInterrupt
        asked.set()

    before = signal.signal(signal.SIGINT, wish)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)
