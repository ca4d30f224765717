"""The methods of the paw tracker: their names, settings, and how each is run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import pandas as pd

from pawnb.core.paws import PaperSettings, Task, track_paws
from pawnb.core.paws.whole import WholeSettings, track_whole
from pawnb.core.paws.whole.store import CandidateStore
from pawnb.core.video import ViewSet
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import Tracks, build_settings
from pawnb.trial import Trial
from pawnb.workflow.results import provenance_steps

METHODS = ("pawnb", "paper", "slic-3d", "slic-2d")
"""Methods of the paw tracker; the first is the default."""

TrackerSettings = WholeSettings | PaperSettings
_SETTINGS: dict[str, type[TrackerSettings]] = {
    method: WholeSettings if method == "pawnb" else PaperSettings for method in METHODS
}


def tracker_settings(
    trial: Trial, *, method: str = METHODS[0], settings: Mapping[str, Any] | None = None
) -> TrackerSettings:
    """Return the settings in force: the trial's ``[tracking]``, overridden by ``settings``.

    Parameters
    ----------
    trial : Trial
        The trial. Its ``[tracking]`` may hold settings of several methods.
    method : str
        A method of the tracker.
    settings : mapping, optional
        Settings of this method that go first; text is read as JSON where it can be.

    Returns
    -------
    WholeSettings or PaperSettings
        The settings.

    Raises
    ------
    InputError
        For an unknown method, an unknown setting, or a value of the wrong type.
    """
    if method not in METHODS:
        raise InputError(
            f"unknown method {method!r}{did_you_mean(method, METHODS)}; "
            f"expected {', '.join(METHODS)}."
        )
    kind = _SETTINGS[method]
    own = setting_names(method)
    others = set().union(*(setting_names(other) for other in METHODS)) - own
    given = {name: value for name, value in trial.tracking.items() if name not in others}
    build_settings(kind, given, where="trial.toml: [tracking]")
    for name in sorted(set(settings or {}) & others):
        owners = [other for other in METHODS if name in setting_names(other)]
        raise InputError(
            f"setting {name!r} belongs to method {owners[0]!r}, not to {method!r}; leave it out, "
            f"or choose that method."
        )
    return build_settings(
        kind, {**given, **(settings or {})}, where=f"settings of method {method!r}"
    )


def method_of_tracks(trial: Trial, tracks: Tracks) -> tuple[str, TrackerSettings]:
    """Return the method that made tracks and its settings, or those in force by default.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Tracks; where another program made them, they are gone on with by the default.

    Returns
    -------
    method : str
        One of :data:`METHODS`.
    settings : WholeSettings or PaperSettings
        Its settings.
    """
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    if not made:
        return METHODS[0], tracker_settings(trial)
    method = made[-1]["method"]
    where = "settings of these tracks"
    return method, build_settings(_SETTINGS[method], made[-1]["settings"], where=where)


def setting_names(method: str) -> set[str]:
    """Return the names of a method's settings."""
    return {field.name for field in dataclasses.fields(_SETTINGS[method])}


def run_tracker(
    method: str,
    views: ViewSet,
    clicks: pd.DataFrame,
    *,
    task: Task,
    settings: TrackerSettings,
    learn_at: Mapping[str, int] | None = None,
    looked: pd.DataFrame | None = None,
    store: CandidateStore | None = None,
) -> Tracks:
    """Track with one of the methods.

    Parameters
    ----------
    method : str
        One of :data:`METHODS`.
    views : ViewSet
        The open views.
    clicks : pandas.DataFrame
        Start clicks.
    task : Task
        What is to be tracked.
    settings : WholeSettings or PaperSettings
        Settings of that method.
    learn_at : mapping, optional
        See :func:`pawnb.core.paws.track_paws`; method ``pawnb`` has no use for it, as it
        learns from every position placed by hand.
    looked, store
        See :func:`pawnb.core.paws.whole.track_whole`; the other methods have no use for them.

    Returns
    -------
    xarray.Dataset
        Tracks.
    """
    if isinstance(settings, WholeSettings):
        return track_whole(views, clicks, task, settings=settings, looked=looked, store=store)
    return track_paws(views, clicks, task, settings=settings, method=method, learn_at=learn_at)
