"""How long a person has worked on a review: the papers' own measure of what a method costs.

A review takes the time between things a person does: keys, clicks, and the mouse over the widget.
Longer gaps are pauses and count nothing. The time is in ``minutes.jsonl`` beside ``edits.jsonl``,
whose lines are corrections only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import monotonic

from pawnb.errors import InputError
from pawnb.io.journal import Journal, LineFormat

PAUSE_S = 100.0
"""A longer gap between two things a person does is a pause and does not count. So CVAT counts
working time (issues #7884 and #7994), which loses long looks where only clicks are heard (#9333):
here the mouse over the widget is heard, too. CATMAID allows for 3 minutes."""
_KEPT_EVERY_S = 10.0
"""So much is lost at most where the program ends by force."""
_LEAST_S = 1.0
"""Less is not worth a file."""


@dataclass(frozen=True, kw_only=True)
class Worked:
    """A person has worked for so long, since the line before.

    Parameters
    ----------
    seconds : float
        Without pauses.
    """

    seconds: float


WORKED_LINES: LineFormat[Worked] = LineFormat({"worked": Worked})
"""The lines of ``minutes.jsonl``."""


class WorkingTime:
    """The time that a person has worked, over all sessions.

    Parameters
    ----------
    path : str or Path, optional
        ``minutes.jsonl``; None keeps nothing. A file that cannot be written stops nobody: the
        time of this session is only not kept.
    clock : callable, optional
        Seconds of any clock that only goes on.
    """

    def __init__(self, path: str | Path | None, *, clock: Callable[[], float] = monotonic) -> None:
        self._path, self._clock = None if path is None else Path(path), clock
        self._file: Journal[Worked] | None = None
        self._lock = Lock()
        self._open()
        self._before = self._written()
        self._here = self._kept = 0.0
        self._last: float | None = None

    @property
    def seconds(self) -> float:
        """Seconds over all sessions, this one included."""
        return self._before + self._here

    @property
    def minutes(self) -> float:
        """Minutes over all sessions, this one included."""
        return self.seconds / 60.0

    def hear(self) -> None:
        """Take notice that a person does something now."""
        with self._lock:
            now, last = self._clock(), self._last
            self._last = now
            if last is not None and now - last <= PAUSE_S:
                self._here += now - last
            if self._here - self._kept >= _KEPT_EVERY_S:
                self._write()

    def keep(self) -> None:
        """Write what is not in the file yet."""
        with self._lock:
            if self._here - self._kept >= _LEAST_S:
                self._write()

    def _open(self) -> None:
        """Read the file anew; one that is no such file is left alone."""
        try:
            self._file = (
                None if self._path is None else Journal(self._path, WORKED_LINES, made_in="review")
            )
        except InputError:
            self._file = None

    def _written(self) -> float:
        entries = [] if self._file is None else self._file.entries
        return sum(entry.seconds for entry in entries if isinstance(entry, Worked))

    def _write(self) -> None:
        """Add a line; where another window has written meanwhile, behind its lines."""
        entry = Worked(seconds=round(self._here - self._kept, 1))
        for _ in range(2):
            if self._file is None:
                return
            try:
                self._file.append(entry)
            except InputError:
                if not self._file.path.parent.is_dir():
                    return  # it was moved away, and is not made anew where it was
                self._open()
            else:
                self._kept += entry.seconds
                return
