"""Where the trials of a batch are tracked: processes of this machine, or those of a scheduler."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from typing import IO, Any, NamedTuple, Protocol

_KILLED_STATUS = -9
_KILLED = (
    "it was killed, as the system does where memory runs out; let fewer trials run at once, or "
    "run this again"
)


class TrialOutcome(NamedTuple):
    """What became of a trial: status, one sentence and verdict as in a :class:`BatchReport`."""

    status: str
    said: str
    verdict: str = ""


class Places(Protocol):
    """Somewhere trials can be tracked, several at once; each is known by its number."""

    def has_room(self) -> bool:
        """Say whether another trial may begin."""

    def begin(self, number: int, order: Mapping[str, Any]) -> None:
        """Begin a trial; ``order`` is what :mod:`pawnb.workflow.batch.worker` takes."""

    def ended(self) -> dict[int, TrialOutcome]:
        """Return the answers of trials that have ended since this was last asked."""

    def wait(self, at_most_s: float) -> None:
        """Wait until a trial may have ended, no longer than so many seconds."""

    def stop(self) -> None:
        """Ask every trial under way to keep what is done and end; may be called again."""

    def close(self) -> None:
        """Let go of what was opened."""


class WorkerProcess:
    """One trial in a process of its own.

    Parameters
    ----------
    order : mapping
        What :mod:`pawnb.workflow.batch.worker` takes.
    """

    def __init__(self, order: Mapping[str, Any]) -> None:
        self._stopping = False
        # closed when the process has ended
        self._errors: IO[str] = tempfile.TemporaryFile("w+")  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-m", "pawnb.workflow.batch.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            # an interrupt from the terminal is for the process that asks these to stop; the first
            # says so to POSIX, the second to Windows
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.write(json.dumps(order) + "\n")
                self._process.stdin.flush()

    def ask_to_stop(self) -> None:
        """Close its standard input: it keeps what is done and ends."""
        self._stopping = True
        self._close_input()

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def wait(self, at_most_s: float) -> None:
        """Wait until it has ended, no longer than so many seconds."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(at_most_s)

    def answer(self) -> TrialOutcome | None:
        """Return what it said once it has ended, else None; afterwards it is closed."""
        if self._process.poll() is None:
            return None
        said, errors = _read_out(self._process.stdout), _read_out(self._errors, rewind=True)
        self._close_input()
        try:
            answer = TrialOutcome(**json.loads(said[-1]))
        except (IndexError, json.JSONDecodeError):
            code = self._process.returncode
            last = errors[-1] if errors else "nothing was said"
            last = _KILLED if code == _KILLED_STATUS else last
            answer = TrialOutcome("failed", f"its process ended with status {code}: {last}")
        if self._stopping and answer.status == "failed":
            return TrialOutcome("stopped", "interrupted before anything was done")
        return answer

    def _close_input(self) -> None:
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()


class Processes:
    """Processes of this machine.

    Parameters
    ----------
    workers : int
        How many at once.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._running: dict[int, WorkerProcess] = {}

    def has_room(self) -> bool:
        """Say whether another trial may begin."""
        return len(self._running) < self._workers

    def begin(self, number: int, order: Mapping[str, Any]) -> None:
        """Begin a trial in a process of its own."""
        self._running[number] = WorkerProcess(order)

    def ended(self) -> dict[int, TrialOutcome]:
        """Return the answers of trials that have ended since this was last asked."""
        answers = {number: process.answer() for number, process in self._running.items()}
        ended = {number: answer for number, answer in answers.items() if answer is not None}
        for number in ended:
            del self._running[number]
        return ended

    def wait(self, at_most_s: float) -> None:
        """Wait for the trial that began first, no longer than so many seconds."""
        for process in self._running.values():
            process.wait(at_most_s)
            return

    def stop(self) -> None:
        """Ask every trial under way to keep what is done and end."""
        for process in self._running.values():
            process.ask_to_stop()

    def close(self) -> None:
        """Ask what still runs to keep what is done and end."""
        self.stop()


def _read_out(stream: IO[str] | None, *, rewind: bool = False) -> list[str]:
    """Return the lines of a stream, and close it."""
    if stream is None:
        return []
    with stream:
        if rewind:
            stream.seek(0)
        return stream.read().strip().splitlines()
