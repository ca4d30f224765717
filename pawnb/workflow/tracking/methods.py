"""The methods of the trackers: their names, settings, and how each paw tracker is run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import pandas as pd

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.tracker import track_maghsoudi2019
from pawnb.core.paws.offline.again import Again
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.kept import KeptStacks
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.tracker import track_offline
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.pullar2009.tracker import track_pullar2009
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video import ViewReader, ViewSet
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import SettingsT, Tracks, build_settings
from pawnb.trial import Trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking.published_names import refuse_published_names, with_present_names

METHODS = ("pawnb", "paper", "slic-3d", "slic-2d")
"""Methods of the paw tracker; the first is the default."""

POSE_METHODS = ("pawnb", "paper")
"""Methods of the pose tracker; the first is the default."""

TrackerSettings = OfflineSettings | Maghsoudi2019Settings
PoseTrackerSettings = PoseSettings | Pullar2009Settings

_SPACE = "space"
"""Where settings of joints in space stand among those of a pose tracker."""

_OF_TRACKS = "settings of these tracks"
_SETTINGS: dict[str, type[TrackerSettings]] = {
    method: OfflineSettings if method == "pawnb" else Maghsoudi2019Settings for method in METHODS
}
_POSE_TRACKERS: dict[str, Callable[..., PoseTrack]] = {
    "pawnb": track_pose,
    "paper": track_pullar2009,
}
_POSE_SETTINGS: dict[str, type[PoseTrackerSettings]] = {
    "pawnb": PoseSettings,
    "paper": Pullar2009Settings,
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
    OfflineSettings or Maghsoudi2019Settings
        The settings.

    Raises
    ------
    InputError
        For an unknown method, an unknown setting, or a value of the wrong type.
    """
    return _settings_in_force(_SETTINGS, trial, method, settings)


def pose_tracker_settings(
    trial: Trial, *, method: str = POSE_METHODS[0], settings: Mapping[str, Any] | None = None
) -> PoseTrackerSettings:
    """Return the settings in force for a jointed animal; else as :func:`tracker_settings`.

    Parameters
    ----------
    trial : Trial
        The trial. Its ``[tracking]`` may hold settings of several methods.
    method : str
        One of :data:`POSE_METHODS`.
    settings : mapping, optional
        Settings of this method that go first.

    Returns
    -------
    PoseSettings or Pullar2009Settings
        The settings.

    Raises
    ------
    InputError
        As :func:`tracker_settings`.
    """
    own, _ = _apart(settings or {})
    tracking, _ = _apart(trial.tracking)
    bare = dataclasses.replace(trial, tracking=tracking)
    return _settings_in_force(_POSE_SETTINGS, bare, method, own)


def space_settings(trial: Trial, *, settings: Mapping[str, Any] | None = None) -> SpaceSettings:
    """Return the settings in force for joints in space, of a trial with a second view.

    Parameters
    ----------
    trial : Trial
        The trial; ``[tracking.space]`` holds such settings.
    settings : mapping, optional
        Settings that go first: ``space.NAME``, or a mapping named ``space``.

    Returns
    -------
    SpaceSettings
        The settings.

    Raises
    ------
    InputError
        For an unknown setting, a value of the wrong type, or a trial with one view.
    """
    _, given = _apart(settings or {})
    if given and len(trial.views) < 2:
        name = next(iter(given))
        raise InputError(
            f"setting 'space.{name}' is about a second view, but trial {trial.name!r} has one."
        )
    where = "trial.toml: [tracking.space]"
    written = build_settings(SpaceSettings, _apart(trial.tracking)[1], where=where)
    return build_settings(
        SpaceSettings, {**dataclasses.asdict(written), **given}, where="settings of space"
    )


def _apart(settings: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Part settings of a tracker in the view from those of joints in space."""
    rest = {n: v for n, v in settings.items() if n != _SPACE and not n.startswith(f"{_SPACE}.")}
    given = settings.get(_SPACE, {})
    if not isinstance(given, Mapping):
        raise InputError(f"{_SPACE} is {given!r}; write its settings as space.NAME=VALUE.")
    dotted = {n.split(".", 1)[1]: v for n, v in settings.items() if n.startswith(f"{_SPACE}.")}
    return rest, {**given, **dotted}


def settings_in_force(
    trial: Trial, *, method: str, settings: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return every setting in force for a trial of any kind, as plain values.

    Parameters
    ----------
    trial : Trial
        The trial.
    method : str
        A method for its kind.
    settings : mapping, optional
        Settings that go first.

    Returns
    -------
    dict
        Names to values.

    Raises
    ------
    InputError
        As :func:`tracker_settings`.
    """
    if trial.kind != "pose":
        return dataclasses.asdict(tracker_settings(trial, method=method, settings=settings))
    chosen = dataclasses.asdict(pose_tracker_settings(trial, method=method, settings=settings))
    space = space_settings(trial, settings=settings)
    return chosen | ({_SPACE: dataclasses.asdict(space)} if len(trial.views) > 1 else {})


def _settings_in_force(
    kinds: Mapping[str, type[SettingsT]],
    trial: Trial,
    method: str,
    settings: Mapping[str, Any] | None,
) -> SettingsT:
    """Return the settings of a method, refusing what is unknown or of another method."""
    if method not in kinds:
        raise InputError(
            f"unknown method {method!r}{did_you_mean(method, kinds)}; expected {', '.join(kinds)}."
        )
    refuse_published_names([*trial.tracking, *(settings or {})], pose=trial.kind == "pose")
    names = {one: {field.name for field in _fields(kind)} for one, kind in kinds.items()}
    others = set().union(*names.values()) - names[method]
    given = {name: value for name, value in trial.tracking.items() if name not in others}
    build_settings(kinds[method], given, where="trial.toml: [tracking]")
    for name in sorted(set(settings or {}) & others):
        owner = next(one for one in kinds if name in names[one])
        raise InputError(
            f"setting {name!r} belongs to method {owner!r}, not to {method!r}; leave it out, "
            f"or choose that method."
        )
    return build_settings(
        kinds[method], {**given, **(settings or {})}, where=f"settings of method {method!r}"
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
    settings : OfflineSettings or Maghsoudi2019Settings
        Its settings.
    """
    made = _made_by(tracks)
    if made is None:
        return METHODS[0], tracker_settings(trial)
    kind = _SETTINGS[made["method"]]
    settings = with_present_names(made["settings"])
    return made["method"], build_settings(kind, settings, where=_OF_TRACKS)


def pose_method_of_tracks(trial: Trial, tracks: Tracks) -> tuple[str, PoseTrackerSettings]:
    """Return the method that made a jointed animal's tracks; else as :func:`method_of_tracks`.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    method : str
        One of :data:`POSE_METHODS`.
    settings : PoseSettings or Pullar2009Settings
        Its settings.
    """
    made = _made_by(tracks)
    if made is None:
        return POSE_METHODS[0], pose_tracker_settings(trial)
    own, _ = _apart(made["settings"])
    kind = _POSE_SETTINGS[made["method"]]
    return made["method"], build_settings(kind, own, where=_OF_TRACKS)


def space_settings_of_tracks(trial: Trial, tracks: Tracks) -> SpaceSettings:
    """Return the settings that joints in space were found with, or those in force by default."""
    made = _made_by(tracks)
    known = {} if made is None else _apart(made["settings"])[1]
    if not known:
        return space_settings(trial)
    return build_settings(SpaceSettings, known, where=_OF_TRACKS)


def _made_by(tracks: Tracks) -> dict[str, Any] | None:
    """Return the record of the run that made these tracks; None where another program did."""
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    return made[-1] if made else None


def run_pose_tracker(
    method: str,
    reader: ViewReader,
    start: Poses,
    *,
    animal: StickAnimal,
    background: Background,
    settings: PoseTrackerSettings,
    frames: tuple[int, int],
    look: Poses | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
    kept: KeptFrames | None = None,
) -> PoseTrack:
    """Track a jointed animal with one of the methods.

    Parameters
    ----------
    method : str
        One of :data:`POSE_METHODS`.
    reader : ViewReader
        The open view.
    start : Poses
        Poses to start from.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene.
    settings : PoseSettings or Pullar2009Settings
        Settings of that method.
    frames : tuple of int
        Half-open range of frames.
    look : Poses, optional
        One frame from which the animal's look is learnt; default the first to start from.
    progress, stop : callable, optional
        As for :func:`pawnb.track`.
    kept : KeptFrames, optional
        What an interrupted run has found, and what this one finds.

    Returns
    -------
    PoseTrack
        The poses.
    """
    return _POSE_TRACKERS[method](
        reader, start, animal=animal, background=background, settings=settings, frames=frames,
        look=look, progress=progress, stop=stop, kept=kept,
    )  # fmt: skip


def setting_names(method: str, *, pose: bool = False) -> set[str]:
    """Return the names of the settings of a method, of paws or of jointed animals."""
    kind = _POSE_SETTINGS[method] if pose else _SETTINGS[method]
    return {field.name for field in _fields(kind)}


def _fields(kind: type[Any]) -> tuple[dataclasses.Field[Any], ...]:
    """Return the fields of a settings class."""
    return dataclasses.fields(kind)


def run_tracker(
    method: str,
    views: ViewSet,
    clicks: pd.DataFrame,
    *,
    task: TrackingRequest,
    settings: TrackerSettings,
    learn_at: Mapping[str, int] | None = None,
    looked: pd.DataFrame | None = None,
    store: DetectionCache | None = None,
    stacks: KeptStacks | None = None,
    again: Again | None = None,
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
    task : TrackingRequest
        What is to be tracked.
    settings : OfflineSettings or Maghsoudi2019Settings
        Settings of that method.
    learn_at : mapping, optional
        See :func:`.tracker.track_maghsoudi2019`; method ``pawnb`` has no use for it, as it
        learns from every position placed by hand.
    looked, store, stacks, again
        See :func:`pawnb.core.paws.offline.tracker.track_learnt`; other methods do not use them.

    Returns
    -------
    xarray.Dataset
        Tracks.
    """
    if isinstance(settings, OfflineSettings):
        return track_offline(
            views, clicks, task, settings=settings, looked=looked, store=store, stacks=stacks,
            again=again,
        )  # fmt: skip
    return track_maghsoudi2019(
        views, clicks, task, settings=settings, method=method, learn_at=learn_at
    )
