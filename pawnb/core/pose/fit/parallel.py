"""Work on several frames, or several legs, at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import wait
from typing import TypeVar

import numpy as np

from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.steps import Steps

THREADS = 2
"""The compiled loops let other threads run, numpy's own part is small: both cores are busy."""
_TELL_S = 0.3
"""Time, s, after which it is reported how far the other thread is."""

_T = TypeVar("_T")
_S = TypeVar("_S")


def threaded(work: Callable[[_S], _T], items: Sequence[_S]) -> list[_T]:
    """Return what ``work``, which changes nothing, makes of each item, in their order."""
    if len(items) < 2:
        return [work(item) for item in items]
    with Threads(THREADS, thread_name_prefix="pawnb-fit") as pool:
        return list(pool.map(work, items))


def side_by_side(one: Callable[[], _T], other: Callable[[], _T], steps: Steps) -> tuple[_T, _T]:
    """Return what two pieces of work return that are done at the same time.

    Where one of them fails, or telling how far they are, the other is asked to stop.

    Parameters
    ----------
    one, other : callable
        Pieces of work without arguments.
    steps : Steps
        Told while the two run; halted where one of them fails.

    Returns
    -------
    tuple
        What the two returned.
    """

    def watched(work: Callable[[], _T]) -> _T:
        try:
            return work()
        except BaseException:
            steps.halt()
            raise

    def here() -> _T:
        result = other()
        while wait([job], _TELL_S).not_done:
            steps.tell()
        return result

    with Threads(1, thread_name_prefix="pawnb-way") as pool:
        job = pool.submit(watched, one)
        result = watched(here)
        return job.result(), result


def on_threads(
    fitter: FrameFitter, items: Sequence[int] | np.ndarray, work: Callable[[FrameFitter, int], _T]
) -> list[_T]:
    """Return what ``work`` makes of each item.

    Parameters
    ----------
    fitter : FrameFitter
        Each thread gets its twin.
    items : sequence of int
        Frames or legs.
    work : callable
        Called with a fitter and an item; in any order.

    Returns
    -------
    list
        In the order of ``items``.
    """
    numbers = [int(item) for item in items]
    # every other one: what is hard to fit lies together, and both shall have their share
    parts = [numbers[first::THREADS] for first in range(THREADS)]
    twins = [fitter.twin() for _ in parts]
    out: dict[int, _T] = {}
    pairs = list(zip(twins, parts, strict=True))
    done = threaded(lambda pair: [work(pair[0], one) for one in pair[1]], pairs)
    for part, results in zip(parts, done, strict=True):
        out.update(zip(part, results, strict=True))
    return [out[number] for number in numbers]
