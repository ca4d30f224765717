"""The network that follows points and that a trial names under ``[tracking] point_tracker``."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable

from pawnb.core.paws.offline.detection.point_tracking.point_tracker import PointTracker
from pawnb.core.paws.offline.detection.point_tracking.tapir import Tapir, load_tapir
from pawnb.trial import Trial


def point_trackers(
    trial: Trial, stop: Callable[[], bool] | None = None, *, tell: bool = False
) -> list[PointTracker]:
    """Return the network that a trial names as a kind of evidence; none where it names none.

    What it has found is kept in the session, with the pictures in which it was.

    Parameters
    ----------
    trial : Trial
        The trial.
    stop : callable, optional
        Asked before each piece of a recording.
    tell : bool
        Whether to warn where it will be slow.

    Returns
    -------
    list of PointTracker
        One or none.

    Raises
    ------
    InputError
        If the file is not there or does not fit, or a package is not installed.
    """
    if trial.point_tracker is None:
        return []
    network = load_tapir(trial.path(trial.point_tracker))
    if tell:
        network.tell_slow()
    return [dataclasses.replace(_of_session(network), stop=stop)]


@functools.lru_cache(maxsize=1)
def _of_session(network: Tapir) -> PointTracker:
    """Return what keeps the paths that a network has found."""
    return PointTracker(network)
