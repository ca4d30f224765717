"""The network that follows points and that a trial names under ``[tracking] point_tracker``."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable

import pandas as pd

from pawnb.core.paws.offline.detection.point_tracking.point_tracker import PointTracker
from pawnb.core.paws.offline.detection.point_tracking.tapir import Tapir, load_tapir
from pawnb.core.paws.offline.tracker import BY_LEARNT
from pawnb.errors import InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.provenance.record import file_checksum


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
    path = trial.path(trial.point_tracker)
    network = load_tapir(path)
    if tell:
        network.tell_slow()
    name = f"point tracker {file_checksum(path)}"  # with others no run goes on from this one
    return [dataclasses.replace(_of_session(network), name=name, stop=stop)]


def tell_unused(trial: Trial, tracks: Tracks, clicks: pd.DataFrame) -> None:
    """Warn where tracks were found without the network that a trial names.

    Parameters
    ----------
    trial : Trial
        The trial.
    tracks : xarray.Dataset
        Its tracks.
    clicks : pandas.DataFrame
        frame, view, point, u, v.
    """
    by = tracks.attrs.get("evidence")
    if trial.point_tracker is None or by is None:
        return
    what = "the point tracker that the trial names was not used, as "
    if by != BY_LEARNT:
        what += f"points were found by {by}; --set evidence=learnt uses it."
    elif clicks.groupby(["view", "point"])["frame"].nunique().max() < 2:
        what += "every point was clicked in one frame: click a second one, by which it is judged."
    else:
        return
    warn_of_input(what, InputWarning, stacklevel=3)


@functools.lru_cache(maxsize=1)
def _of_session(network: Tapir) -> PointTracker:
    """Return what keeps the paths that a network has found."""
    return PointTracker(network)
