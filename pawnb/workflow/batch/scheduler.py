"""Trials of a batch on the workers of a Dask scheduler (https://distributed.dask.org).

``distributed`` is not needed for anything else; ``pip install "pawnb[scheduler]"`` brings it. Each
trial is one task, and the worker that takes it tracks it in a process of its own
(:class:`pawnb.workflow.batch.places.WorkerProcess`), as on one machine. Trials and results are
read and written where they lie: every worker must reach them under the same paths.
"""

from __future__ import annotations

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
_SCHEDULER_POLL_S = 0.5
"""How often a worker looks whether its process is to stop."""
_COUNT_S = 1.0
"""How often workers are counted: to ask takes longer than to hand out a trial."""
_TRIALS_AHEAD = 64
"""So many trials wait for a worker at most, for each to find the next one at once. They are handed
out and answered for many together: a message costs the scheduler more than what it says. Measured:
10,000 trials, processor time a trial, :doc:`/accuracy`."""

_GONE = "the scheduler no longer answers; run this again to go on"


class Scheduler:
    """The workers of a Dask scheduler: as many trials at once as they have threads, some waiting.

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
        self._orders: dict[int, Mapping[str, Any]] = {}
        self._running: dict[int, Any] = {}
        self._refused: dict[int, TrialOutcome] = {}
        self._stopping = False
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
        wait = len(self._running) + len(self._orders) - self._threads
        # half of them are used up before more are handed out, then all at once
        return wait < (_TRIALS_AHEAD if self._orders else _TRIALS_AHEAD // 2)

    def begin(self, number: int, order: Mapping[str, Any]) -> None:
        """Order a trial of a worker; its paths become absolute."""
        places = {name: str(Path(order[name]).absolute()) for name in ("trial", "out")}
        self._orders[number] = {**order, **places}

    def _hand_out(self) -> None:
        """Hand out what has been ordered, all in one message."""
        orders, self._orders = self._orders, {}
        if self._is_gone():
            self._refused.update(
                dict.fromkeys(orders, TrialOutcome("failed", f"not begun: {_GONE}"))
            )
        elif orders:
            futures = self._client.map(
                track_on_worker,
                list(orders.values()),
                stop_name=self._stop_name,
                pure=False,
                retries=0,
            )
            self._running.update(zip(orders, futures, strict=True))

    def wait(self, at_most_s: float) -> None:
        """Hand out what has been ordered, and wait a while, in which several trials may end."""
        self._hand_out()
        if not self._refused:
            time.sleep(at_most_s)

    def ended(self) -> dict[int, TrialOutcome]:
        """Return the answers of trials that have ended since this was last asked."""
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
        self._refused.update(dict.fromkeys(self._orders, TrialOutcome("stopped", "not begun")))
        self._orders.clear()
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
            process.wait(_SCHEDULER_POLL_S)
            if stop.is_set():
                process.ask_to_stop()
    except BaseException:
        process.kill()
        raise
    return answer.status, answer.said, answer.verdict
