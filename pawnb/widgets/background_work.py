"""Work that needs no person, done off the thread that hears the browser, with its progress."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import ipywidgets as widgets

from pawnb.errors import InputError, PawnbError
from pawnb.widgets.workbench_parts import ROW
from pawnb.workflow.progress import Progress, progress_bar


@contextmanager
def said_in_status(canvas: Any, doing: str) -> Iterator[Progress | None]:
    """Say in a canvas how far something is that it waits for; before it is shown, by a bar.

    Parameters
    ----------
    canvas : FrameCanvas
        Its ``status`` is as it was when the block has ended; it has none before it is shown.
    doing : str
        What is being done.

    Yields
    ------
    callable or None
        ``progress(done, total)``; None where nobody would see a bar.
    """
    before, words = canvas.status, doing.capitalize()
    if not before:
        with progress_bar(doing) as bar:
            yield bar
        return

    def tell(done: int, total: int) -> None:
        canvas.status = f"{words}: {100 * done // total} %."

    tell(0, 1)
    try:
        yield tell
    finally:
        canvas.status = before


class BackgroundWork(widgets.HBox):  # type: ignore[misc]
    """A bar that shows how far something is, with a button to stop it; hidden while all is done.

    Parameters
    ----------
    stop : widget
        The button that stops it.
    around : callable
        Called before something begins and when it has ended.
    failed : callable
        ``failed(text)`` is told what is wrong.
    """

    def __init__(
        self, stop: Any, *, around: Callable[[], None], failed: Callable[[str], None]
    ) -> None:
        self._bar, self._doing = widgets.IntProgress(layout={"width": "20em"}), widgets.Label()
        self._around, self._failed = around, failed
        self._worker: threading.Thread | None = None
        super().__init__([self._bar, self._doing, stop], layout={**ROW, "display": "none"})

    def begin(self, doing: str, work: Callable[[], Callable[[], None]]) -> None:
        """Do something off this thread, and then what it gives.

        Parameters
        ----------
        doing : str
            What is being done.
        work : callable
            The work; gives what to do then.

        Raises
        ------
        InputError
            If something is being done already.
        """
        if self._worker is not None and self._worker.is_alive():
            raise InputError("something is being done already; wait, or press Stop.")
        self._around()
        self._doing.value, self._bar.value = f"{doing} ...", 0
        self.layout.display = None

        def run() -> None:
            then: Callable[[], None] | None = None
            try:
                then = work()
            except (PawnbError, OSError) as error:
                self._failed(str(error))
            except KeyboardInterrupt:
                self._failed("stopped before anything was tracked.")
            except Exception as error:  # noqa: BLE001, in this thread nobody else would hear of it
                traceback.print_exc()  # into the log, for whoever mends it
                self._failed(
                    f"{doing}: this is a fault of pawnb itself ({type(error).__name__}: {error}). "
                    "What was there before is kept; report it with the lines in the log "
                    "(View > Show Log Console)."
                )
            finally:
                self.layout.display = "none"
                self._around()
            if then is not None:
                then()

        self._worker = threading.Thread(target=run, name="pawnb-work", daemon=True)
        self._worker.start()

    def progress(self, done: int, total: int, doing: str = "") -> None:
        """Show how far the work is.

        Parameters
        ----------
        done, total : int
            Frames.
        doing : str
            What is being done to them.
        """
        self._bar.max, self._bar.value = max(1, total), done
        self._doing.value = f"{doing or 'tracking'}: {done} of {total} frames"

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait until it is done; at once on the thread that does it."""
        if self._worker is not None and self._worker is not threading.current_thread():
            self._worker.join(timeout_s)
