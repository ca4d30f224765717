"""Tracking points through a recording of any kind: from clicks to Tracks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd

from pawnb.core.parallel import calls_on_one_thread
from pawnb.core.paws.layout import Views
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.landmarks.tracks import choose_landmarks
from pawnb.core.paws.offline.learnt_run import goes_on, track_learnt
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.quality.assessment import Quality, assess, share_on_one_place
from pawnb.core.paws.offline.quality.likeness import add_likeness
from pawnb.core.paws.offline.reuse.kept_evidence import KeptStacks
from pawnb.core.paws.offline.reuse.retracking import Again
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.hidden import with_hidden_sd
from pawnb.core.paws.offline.treadmill.learnt_appearance import (
    is_seen_from_below,
    strides_may_tell,
    track_by_strides,
)
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill, warn_of_ambiguous_colour
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.pixels.grey import has_colour
from pawnb.schema import Tracks

BY_COLOUR, STRIDES, BY_LEARNT = "colour", "strides", "learnt"
"""What tracks may be found by; kept in their attribute ``evidence``."""


@calls_on_one_thread()
def track_offline(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None = None,
    store: DetectionCache | None = None,
    stacks: KeptStacks | None = None,
    again: Again | None = None,
) -> Tracks:
    """Track points by the first way that serves, of three.

    Paws of a colour of their own are tracked by :func:`.tracker.track_treadmill`,
    which knows strides and stance. Where colour does not tell them, as in grey pictures, or its
    tracks are not good by absolute measures (:func:`.quality.assess`), calibrated views of paws
    are tracked in the same way by a look that is learnt
    (:func:`.learnt_appearance.track_by_strides`), and these tracks are kept if clearly more labels
    are expected to be right and two names lie on one place in hardly a frame, or in fewer than by
    colour. Where neither applies,
    or tracks failed (on the real clips on which colour does not tell paws 7 to 37 % of labels are
    expected to be right, on rendered scenes 83 % and more), points are tracked by
    :func:`.learnt_run.track_learnt`; as well where clicks were added since its last run. Where one
    point failed but not all did, what is learnt takes over only if it is clearly surer.

    Parameters
    ----------
    views, start, task, settings, looked, store
        As for :func:`.tracker.track_treadmill`; ``settings.evidence`` may choose one
        of the three.
    stacks : KeptStacks, optional
        Evidence of earlier runs on the same recording, for what is learnt in it.
    again : Again, optional
        What is to be tracked again, for what is learnt in the recording; colour decides over all.

    Returns
    -------
    xarray.Dataset
        Tracks; the attribute ``evidence`` is ``"colour"``, ``"strides"`` or ``"learnt"``.

    Raises
    ------
    InputError
        If a click does not fit, or a point has none.
    """
    given: dict[str, Any] = {"settings": settings, "looked": looked, "store": store}
    n = task.frames[1] - task.frames[0]
    enough = RUN.colour_enough if n >= RUN.colour_long else RUN.colour_poor
    best: tuple[Quality, Tracks, float] | None = None
    ways = _ways(views, start, task, settings=settings, looked=looked)
    if stacks is not None and looked is None and goes_on(views, start, task, stacks=stacks):
        ways = []  # found to fail by the run that is gone on from
    for kind in ways:
        find: Callable[..., Tracks] = track_treadmill if kind == BY_COLOUR else track_by_strides
        tracks = find(views, start, task, **given)
        tracks.attrs["evidence"] = kind
        complete = tracks.sizes["time"] >= n
        if settings.evidence == kind or not complete:
            return with_hidden_sd(tracks, task.frames)
        quality = assess(add_likeness(views, tracks, start), clicks=start)
        shared = share_on_one_place(tracks, start)
        if best is None or (
            (shared <= RUN.shared_much or shared < best[2])
            and _is_better(quality, best[0], shared=best[2])
        ):
            best = quality, tracks, shared
        if best[0].expected_right >= enough:
            break
    kept = best if best is not None and best[0].verdict != "failed" else None
    if kept is None or kept[0].has_failed_point:
        tracks = track_learnt(views, start, task, looked=looked, stacks=stacks, again=again)
        tracks.attrs["evidence"] = BY_LEARNT
        complete = tracks.sizes["time"] >= n
        if kept is None or (complete and _is_surer(assess(tracks, clicks=start), kept[0])):
            return tracks
    # which way is the better was measured with what the smoothing alone states
    return with_hidden_sd(kept[1], task.frames)


def _is_surer(quality: Quality, than: Quality) -> bool:
    """Tell whether clearly more labels are expected to be right."""
    return quality.expected_right > than.expected_right + RUN.colour_surer


def _is_better(quality: Quality, than: Quality, *, shared: float) -> bool:
    """Tell whether tracks by strides take the place of those by colour.

    Those by colour are known to be wrong where two names ``shared`` a place in part of them.
    """
    surer = _is_surer(quality, than)
    return surer and (quality.verdict == "good" or than.verdict == "failed" or shared > 0.0)


def _ways(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None,
) -> list[str]:
    """Return by what tracks are sought, one after the other until one serves."""
    if settings.evidence in (BY_COLOUR, STRIDES):
        return [settings.evidence]
    if settings.evidence == BY_LEARNT:
        return []
    by_strides = strides_may_tell(views, start, task, settings=settings)
    # from the side brightness alone is worse than a look that is learnt; from below neither
    # is throughout the better one (docs/tracker_choices.md), and brightness stays where it is good
    by_colour = (
        not by_strides
        or _has_colour(views, int(start["frame"].iloc[0]))
        or is_seen_from_below(views, start, task)
    )
    ways = []
    if by_colour and _colour_may_tell(views, start, task, settings, looked):
        ways.append(BY_COLOUR)
    return [*ways, STRIDES] if by_strides else ways


def _has_colour(views: Views, frame: int) -> bool:
    """Tell whether any view is in colour."""
    pictures = views.frame(frame)
    sizes = {name: views.readers[name] for name in views.names}
    return any(
        has_colour(pictures[name].crop(0, 0, reader.width, reader.height))
        for name, reader in sizes.items()
    )


def _colour_may_tell(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    settings: OfflineSettings,
    looked: pd.DataFrame | None,
) -> bool:
    """Tell whether colour is worth trying: no predictions, and paws unlike what is about them."""
    if task.predictions or (task.rig is None and len(views.names) > 1):
        return False
    points = list(dict.fromkeys(start["point"]))
    kinds = [Maghsoudi2019Settings().kind(point) for point in points]
    if choose_landmarks(tuple(points), tuple(kinds), settings.landmarks).all():
        return False
    return (
        looked is not None
        or warn_of_ambiguous_colour(views, start, task, settings=settings) is None
    )
