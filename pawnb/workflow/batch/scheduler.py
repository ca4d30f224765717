"""Trials of a batch on the workers of a Dask scheduler (https://distributed.dask.org).

``distributed`` is not needed for anything else; ``pip install "pawnb[scheduler]"`` brings it. Each
trial is one task, and the worker that takes it tracks it in a process of its own
(:class:`pawnb.workflow.batch.places.WorkerProcess`), as on one machine. Trials and results are
read and written where they lie: every worker must reach them under the same paths.
"""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Mapping, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.workflow.batch.places import TrialOutcome, WorkerProcess

_CONNECT_S = 10.0
"""So long a scheduler may be silent, at the beginning and in between, before it is gone."""
_LOOK_S = 0.5
"""How often a worker looks whether its process is to stop."""
_COUNT_S = 1.0
"""How often workers are counted: to ask takes longer than to hand out a trial."""

_GONE = "the scheduler no longer answers; run this again to go on"


class Scheduler:
    """The workers of a Dask scheduler: as many trials at once as they have threads.

    Parameters
    ----------
    address : str
        Such as ``tcp://cluster:8786``.

    Raises
    ------
    InputError
        If ``distributed`` is not installed, or no scheduler answers at that address.
    """

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise InputError(
                "a scheduler needs the package distributed, which is not installed; "
                'python -m pip install "pawnb[scheduler]" brings it, or use --workers instead.'
            ) from None
        try:
            self._client = distributed.Client(address, timeout=_CONNECT_S)
        except (OSError, ValueError) as error:
            raise InputError(
                f"no Dask scheduler answers at {address!r} ({error}); expected the address that "
                "`dask scheduler` prints, such as tcp://cluster:8786."
            ) from None
        self._stop_name = f"pawnb-stop-{uuid.uuid4().hex}"
        self._stop = distributed.Event(self._stop_name, client=self._client)
        self._running: dict[int, Any] = {}
        self._refused: dict[int, TrialOutcome] = {}
        self._stopping = False
        self._some_ended = threading.Event()
        self._threads, self._counted_at = 0, -_COUNT_S

    def _is_gone(self) -> bool:
        """Say whether the scheduler no longer answers, and is no longer waited for."""
        return self._client.status in ("closing", "closed")

    def has_room(self) -> bool:
        """Say whether another trial may begin: one waits even where no worker is there yet.

        Where the scheduler is gone trials "begin", and are answered for at once.
        """
        if self._is_gone():
            return True
        if time.monotonic() - self._counted_at >= _COUNT_S:
            try:
                self._threads = sum(self._client.nthreads().values())
            except OSError:  # it does not answer now; the client tries again, or gives up
                return False
            self._counted_at = time.monotonic()
        return len(self._running) < max(1, self._threads)

    def begin(self, number: int, order: Mapping[str, Any]) -> None:
        """Hand a trial to a worker; its paths become absolute."""
        if self._is_gone():
            self._refused[number] = TrialOutcome("failed", f"not begun: {_GONE}")
            return
        places = {name: str(Path(order[name]).resolve()) for name in ("trial", "out")}
        future = self._client.submit(
            track_on_worker, {**order, **places}, self._stop_name, pure=False, retries=0
        )
        future.add_done_callback(lambda _future: self._some_ended.set())
        self._running[number] = future

    def wait(self, at_most_s: float) -> None:
        """Wait until a trial has ended, no longer than so many seconds."""
        if not self._refused:
            self._some_ended.wait(at_most_s)

    def ended(self) -> dict[int, TrialOutcome]:
        """Return the answers of trials that have ended since this was last asked."""
        self._some_ended.clear()
        ended, self._refused = self._refused, {}
        status = {number: future.status for number, future in self._running.items()}
        finished = [number for number, said in status.items() if said == "finished"]
        ended.update(self._answers(finished))
        for number, said in status.items():
            if said in ("error", "cancelled", "lost"):
                ended[number] = self._without_answer(self._running[number], said)
        for number in ended.keys() & self._running.keys():
            del self._running[number]
        return ended

    def _answers(self, finished: Sequence[int]) -> dict[int, TrialOutcome]:
        """Return what workers said, all in one request, which takes as long as one alone."""
        if not finished:
            return {}
        try:
            said = self._client.gather([self._running[number] for number in finished])
        except (OSError, CancelledError):  # the scheduler died meanwhile; asked again they say so
            return {}
        return {number: TrialOutcome(*one) for number, one in zip(finished, said, strict=True)}

    def _without_answer(self, future: Any, status: str) -> TrialOutcome:
        """Return what became of a trial whose worker never said it."""
        if status == "cancelled" and self._stopping:
            return TrialOutcome("stopped", "not begun")
        if self._client.status != "running":  # then the client takes all back
            return TrialOutcome("failed", f"{_GONE}, and what its worker has kept is there")
        error = future.exception() if status == "error" else "its worker is gone"
        return TrialOutcome("failed", f"the scheduler's worker failed: {error}")

    def stop(self) -> None:
        """Ask every trial under way to keep what is done and end; take back those that wait."""
        if self._stopping:
            return
        self._stopping = True
        try:
            self._stop.set()
            taken = {key for keys in self._client.processing().values() for key in keys}
        except (OSError, AttributeError):  # the scheduler is gone, and with it its connection
            return
        for future in self._running.values():
            if future.key not in taken and future.status == "pending":
                future.cancel()

    def close(self) -> None:
        """Leave the scheduler; what still runs keeps what is done and ends."""
        if self._running:
            self.stop()
        self._client.close()


def track_on_worker(order: Mapping[str, Any], stop_name: str) -> tuple[str, str, str]:
    """Track a trial in a process of its own on the worker that runs this.

    Parameters
    ----------
    order : mapping
        What :mod:`pawnb.workflow.batch.worker` takes.
    stop_name : str
        Name of the scheduler's event that says to stop.

    Returns
    -------
    status, said, verdict : str
        See :class:`pawnb.workflow.batch.places.TrialOutcome`.
    """
    import distributed

    stop = distributed.Event(stop_name)
    if stop.is_set():
        return "stopped", "not begun", ""
    process = WorkerProcess(order)
    try:
        while (answer := process.answer()) is None:
            process.wait(_LOOK_S)
            if stop.is_set():
                process.ask_to_stop()
    except BaseException:
        process.kill()
        raise
    return answer.status, answer.said, answer.verdict
