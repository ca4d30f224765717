"""Two pieces of work at once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import wait
from typing import TypeVar

from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.steps import Steps

_TELL_S = 0.3
"""Resource: time, s, after which it is reported how far the other thread is."""

_T = TypeVar("_T")


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
