"""Work on several frames, or several legs, at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

from pawnb.core.pose.fit.fitter import FrameFitter

THREADS = 2
"""The compiled loops let other threads run, numpy's own part is small: both cores are busy."""

_T = TypeVar("_T")


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
    with ThreadPoolExecutor(THREADS, thread_name_prefix="pawnb-fit") as pool:
        done = pool.map(lambda own, part: [work(own, one) for one in part], twins, parts)
        for part, results in zip(parts, done, strict=True):
            out.update(zip(part, results, strict=True))
    return [out[number] for number in numbers]
