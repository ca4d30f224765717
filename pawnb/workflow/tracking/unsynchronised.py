"""What is said of films of several views that are not synchronised."""

from __future__ import annotations

from itertools import combinations

from pawnb.core.calibration.synchronisation import find_unsynchronised, motion_of_views
from pawnb.core.video import ViewSet
from pawnb.trial import Trial


def doubt_synchronisation(trial: Trial, views: ViewSet, *, start: int, stop: int) -> list[str]:
    """Say which views move some frames before or after the others.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    start, stop : int
        Frames of the trial, half open.

    Returns
    -------
    list of str
        A sentence for each such view.
    """
    pairs = [
        (a, b)
        for a, b in combinations(views.names, 2)
        if trial.view(a).video != trial.view(b).video and _show_the_same(trial, a, b)
    ]
    if not pairs:
        return []
    said = []
    calibration = trial.calibration
    in_space = calibration is not None and calibration.of_views is not None
    wrong = ", and places in space will be wrong" if in_space else ""
    for one in find_unsynchronised(motion_of_views(views, start, stop), pairs=pairs):
        offset = trial.view(one.view).offset
        n = f"{abs(one.lag_frames)} frame{'s' if abs(one.lag_frames) > 1 else ''}"
        when = "later" if one.lag_frames > 0 else "earlier"
        said.append(
            f"what moves in view {one.view} moves {n} {when} "
            f"than in view {one.other} (correlation {one.correlation:.2f} once moved, "
            f"{one.correlation_now:.2f} as it is): the films seem not to be synchronised{wrong}; "
            f"compare a touch-down in both, and set offset = {offset + one.lag_frames} of view "
            f"{one.view} (now {offset}) if it fits"
        )
    return said


def may_be_unsynchronised(trial: Trial, views: ViewSet) -> bool:
    """Tell whether films need not have been started together, by what is known without a look.

    Cameras that are triggered together give films of one length, and no offset is stated. Looking
    takes as long as decoding 200 frames, so tracking does it only here, and ``pawnb check`` always.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.

    Returns
    -------
    bool
        Whether an offset is stated, or lengths differ.
    """
    lengths = {reader.n_frames for reader in views.readers.values()}
    return len(lengths) > 1 or any(view.offset for view in trial.views)


def _show_the_same(trial: Trial, a: str, b: str) -> bool:
    """Say whether two views show the same legs: those of the other side move at other times."""
    points = [set(trial.view(name).points or ()) for name in (a, b)]
    return not all(points) or bool(points[0] & points[1])
