"""What every run of a tracker has about it: parameters set, progress shown, views open."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator, Mapping
from typing import Any

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.tracker import AnyTracker
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputWarning
from pawnb.trial import Trial
from pawnb.workflow.progress import Progress, tracking_progress


class OpenedRun:
    """Open views, and where to tell how far the run is.

    Parameters
    ----------
    views : ViewSet
        The open views.
    report : callable or None
        ``progress(done, total)``.
    bar : ExitStack
        Ends the bar when it is closed.
    """

    def __init__(self, views: ViewSet, report: Progress | None, bar: contextlib.ExitStack) -> None:
        self.views, self.report, self._bar = views, report, bar

    @property
    def sizes(self) -> dict[str, tuple[int, int]]:
        """Width and height of each view's picture, px."""
        return {name: (r.width, r.height) for name, r in self.views.readers.items()}

    def tell_notes(self) -> None:
        """Warn of what is odd about the recording; the line that is named is the user's."""
        for note in self.views.notes:
            warnings.warn(note, InputWarning, stacklevel=4)

    def end_progress(self) -> None:
        """End the bar: what follows takes no time."""
        self._bar.close()


@contextlib.contextmanager
def opened_run(
    trial: Trial,
    tracker: AnyTracker,
    *,
    parameters: Mapping[str, Mapping[str, Any]],
    progress: Progress | None,
    label: str,
    then: str = "",
) -> Iterator[OpenedRun]:
    """Set parameters of stages, show progress and open the views while the block runs.

    Parameters
    ----------
    trial : Trial
        The trial.
    tracker : Tracker
        What tracks it.
    parameters : mapping
        Stage to names and values, see :func:`pawnb.core.parameters.parameters_set`.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook.
    label, then : str
        What is done meanwhile, and after all frames are counted.

    Yields
    ------
    OpenedRun
        The open views, and where to tell how far the run is.
    """
    with contextlib.ExitStack() as stack:
        stack.enter_context(parameters_set(parameters))
        bar = stack.enter_context(contextlib.ExitStack())
        # what the other methods call is compiled in no time
        kind = tracker.kind if tracker.is_offline else None
        report = bar.enter_context(tracking_progress(progress, label, kind=kind, then=then))
        yield OpenedRun(stack.enter_context(open_views(trial)), report, bar)
