"""How far a tracker is, and whether it shall stop."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Steps:
    """Counts what is done, tells it, and says whether to stop.

    Any thread may count; what is done is reported by the one that made this, as progress bars
    expect.

    Parameters
    ----------
    total : int
        Steps in all.
    progress : callable, optional
        Called with steps done and steps in all.
    stop : callable, optional
        Work ends early when this returns True.
    """

    def __init__(
        self,
        total: int,
        progress: Callable[[int, int], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> None:
        self.total, self.done = total, 0
        self._progress, self._stop = progress, stop
        self._lock = threading.Lock()
        self._teller = threading.get_ident()
        self._halted = False

    def expect(self, more: int) -> None:
        """Expect so many steps more."""
        self.total += more

    def one(self) -> None:
        """Count a step."""
        with self._lock:
            self.done += 1
        self.tell()

    def tell(self) -> None:
        """Say how far it is, if this thread is the one to say so."""
        if self._progress is not None and threading.get_ident() == self._teller:
            self._progress(min(self.done, self.total), self.total)

    def end(self) -> None:
        """Say that all is done, also where the animal was not there in every frame."""
        if self._progress is not None and not self.stopped():
            self._progress(self.total, self.total)

    def halt(self) -> None:
        """Stop all work: something went wrong."""
        self._halted = True

    def stopped(self) -> bool:
        """Return whether work ends early."""
        return self._halted or (self._stop is not None and self._stop())
