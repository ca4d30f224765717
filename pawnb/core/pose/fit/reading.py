"""Frames for several ways through a recording at the same time, each decoded a few ahead."""

from __future__ import annotations

from collections.abc import Iterator

from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.video.views import Frame, ViewReader

_FRAMES_AHEAD = 4
"""Resource: frames that are decoded before they are asked for."""


class WaysReader:
    """Readers of one view for ways through it that are followed at the same time.

    A reader goes through the file; two that took turns in it would seek before every frame.

    Parameters
    ----------
    reader : ViewReader
        The view; more readers are opened as they are needed, and closed.
    steps : Steps
        Says whether to stop.
    """

    def __init__(self, reader: ViewReader, steps: Steps) -> None:
        self._free, self._steps = [reader], steps
        self._first = reader

    def read(self, numbers: range) -> Iterator[Frame]:
        """Yield frames, decoded in a thread of their own a few ahead.

        Parameters
        ----------
        numbers : range
            Their numbers.

        Yields
        ------
        Frame
            One after the other, until all are read or work ends early.
        """
        try:
            reader = self._free.pop()  # of two threads, one gets it
        except IndexError:
            reader = self._first.again()
        try:
            yield from _read_ahead(reader, numbers, self._steps)
        finally:
            if reader is self._first:
                self._free.append(reader)
            else:
                reader.close()


def _read_ahead(reader: ViewReader, numbers: range, steps: Steps) -> Iterator[Frame]:
    """Yield frames, decoded in a thread of their own a few ahead."""
    with Threads(1, thread_name_prefix="pawnb-pose") as pool:
        waiting = []
        for i in numbers:
            waiting.append(pool.submit(reader.frame, i))
            if len(waiting) > _FRAMES_AHEAD:
                yield waiting.pop(0).result()
            if steps.stopped():
                break
        for future in waiting:
            if steps.stopped():
                future.cancel()
            else:
                yield future.result()
