"""What every run of a tracker has about it: parameters, progress, open views, and its record."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.tracker import AnyTracker
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.trial import Trial
from pawnb.workflow.interrupt import interruptible
from pawnb.workflow.progress import Progress, tracking_progress
from pawnb.workflow.provenance.notes import noted_warnings
from pawnb.workflow.provenance.record import (
    build_step,
    film_sizes,
    name_on_record,
    trial_checksums,
    trial_fingerprint,
)
from pawnb.workflow.tracking.methods import (
    recorded_parameters,
    settings_in_force,
    stage_parameters,
)
from pawnb.workflow.tracking.options import TrackOptions


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
            warn_of_input(note, InputWarning, stacklevel=4)

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


@contextlib.contextmanager
def first_run(
    trial: Trial, tracker: AnyTracker, asked: TrackOptions, *, then: str = ""
) -> Iterator[tuple[OpenedRun, Callable[[], bool], list[str]]]:
    """Open what :func:`pawnb.track` works on, for a run that can be interrupted.

    Parameters
    ----------
    trial : Trial
        The trial.
    tracker : Tracker
        What tracks it.
    asked : TrackOptions
        What is asked for.
    then : str
        What is done after all frames are counted.

    Yields
    ------
    run : OpenedRun
        The open views, and where to tell how far the run is.
    stop : callable
        Says whether a person wants it to end.
    notes : list of str
        What is warned of meanwhile; it grows.
    """
    with contextlib.ExitStack() as stack:
        notes = stack.enter_context(noted_warnings())
        own = stage_parameters(trial, method=asked.method, settings=asked.settings)
        stop = stack.enter_context(interruptible()) if asked.stop is None else asked.stop
        run = opened_run(
            trial, tracker, parameters=own, progress=asked.progress, label="tracking", then=then
        )
        yield stack.enter_context(run), stop, notes


def record_of_run(
    trial: Trial,
    tracker: AnyTracker,
    asked: TrackOptions,
    *,
    frames: tuple[int, int],
    start: list[dict[Any, Any]],
    **more: Any,
) -> dict[str, Any]:
    """Return the record of a run: all that its tracks depend on.

    Parameters
    ----------
    trial : Trial
        The trial.
    tracker : Tracker
        What tracks it.
    asked : TrackOptions
        What is asked for.
    frames : tuple of int
        Half-open range of frames.
    start : list of dict
        Rows of the start, which stand in the record themselves.
    **more
        What else there is.

    Returns
    -------
    dict
        See :func:`pawnb.workflow.provenance.record.build_step`.
    """
    return build_step(
        "track",
        command=asked.command,
        # a start that was handed over is no file
        inputs=trial_checksums(trial, start=asked.start is None),
        settings=settings_in_force(trial, method=asked.method, settings=asked.settings),
        method=asked.method,
        **recorded_parameters(tracker),
        frames=list(frames),
        trial=trial_fingerprint(trial),
        film_bytes=film_sizes(trial),
        films={view.name: name_on_record(view.video) for view in trial.views},
        start=start,
        **more,
    )
