"""Which tracker a trial asks for, and its settings in force."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from pawnb.core.parameters import constants_of, parameters_of, read_parameters
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.tracker import DEFAULT, AnyTracker, find_tracker, tracked_kinds, trackers
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.pullar2009.settings import Pullar2009Settings
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.errors import InputError
from pawnb.schema import Tracks, build_settings
from pawnb.trial import Trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking.published_names import refuse_published_names, with_present_names

PAW_METHODS = tuple(trackers("paws"))
"""Methods of the paw tracker; the first is the default."""

POSE_METHODS = tuple(trackers("pose"))
"""Methods of the pose tracker; the first is the default."""

TrackerSettings = OfflineSettings | Maghsoudi2019Settings | PoseSettings | Pullar2009Settings

_SPACE = "space"
"""Where settings of joints in space stand among those of a pose tracker."""

_OF_TRACKS = "settings of these tracks"

NO_RECORDING = "; tracking needs kind 'paws' or 'pose'."
"""What is said of a trial that another program has tracked."""


def trial_tracker(trial: Trial, method: str = DEFAULT) -> AnyTracker:
    """Return the tracker for a trial, by the name of its method.

    Parameters
    ----------
    trial : Trial
        The trial.
    method : str
        A method for its kind.

    Returns
    -------
    Tracker
        The tracker.

    Raises
    ------
    InputError
        If nothing tracks trials of this kind, or no method has this name.
    """
    trial.must_be(*tracked_kinds(), or_else=NO_RECORDING)
    return find_tracker(trial.kind, method)


def tracker_settings(
    trial: Trial, *, method: str = DEFAULT, settings: Mapping[str, Any] | None = None
) -> TrackerSettings:
    """Return the settings in force: the trial's ``[tracking]``, overridden by ``settings``.

    Parameters
    ----------
    trial : Trial
        The trial. Its ``[tracking]`` may hold settings of several methods.
    method : str
        A method for its kind.
    settings : mapping, optional
        Settings of this method that go first; text is read as JSON where it can be. Those of
        joints in space (:func:`space_settings`) are left out.

    Returns
    -------
    OfflineSettings, Maghsoudi2019Settings, PoseSettings or Pullar2009Settings
        The settings.

    Raises
    ------
    InputError
        For an unknown method, an unknown setting, or a value of the wrong type.
    """
    tracker = trial_tracker(trial, method)
    own, written = _of_tracker(tracker, settings or {}), _of_tracker(tracker, trial.tracking)
    refuse_published_names([*written, *own], kind=tracker.kind)
    names = {one: setting_names(one, kind=tracker.kind) for one in trackers(tracker.kind)}
    others = set().union(*names.values()) - names[method]
    given = {name: value for name, value in written.items() if name not in others}
    build_settings(tracker.settings, given, where="trial.toml: [tracking]")
    for name in sorted(set(own) & others):
        owner = next(one for one in names if name in names[one])
        raise InputError(
            f"setting {name!r} belongs to method {owner!r}, not to {method!r}; leave it out, "
            f"or choose that method."
        )
    where = f"settings of method {method!r}"
    chosen: TrackerSettings = build_settings(tracker.settings, {**given, **own}, where=where)
    return chosen


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


def stage_parameters(
    trial: Trial, *, method: str = DEFAULT, settings: Mapping[str, Any] | None = None
) -> dict[str, dict[str, Any]]:
    """Return the parameters of stages that are set: the trial's, overridden by ``settings``.

    Parameters
    ----------
    trial : Trial
        The trial; ``[tracking.STAGE]`` holds such parameters.
    method : str
        A method for its kind.
    settings : mapping, optional
        Those that go first: ``STAGE.NAME``, or a mapping named as the stage.

    Returns
    -------
    dict
        Stage to names and values; see :func:`pawnb.core.parameters.parameters_set`.

    Raises
    ------
    InputError
        For an unknown stage or name, or a value of the wrong type.
    """
    tracker = trial_tracker(trial, method)
    known = {stage for one in trackers(tracker.kind).values() for stage in one.stages}
    written = {
        name: value
        for name, value in _grouped(tracker, trial.tracking).items()
        # those of another method wait for it
        if name.partition(".")[0] in tracker.stages or name.partition(".")[0] not in known
    }
    own = _grouped(tracker, settings or {})
    found = read_parameters(written, tracker.stages, where="trial.toml: [tracking]")
    where = f"settings of method {method!r}"
    for stage, values in read_parameters(own, tracker.stages, where=where).items():
        found[stage] = found.get(stage, {}) | values
    return found


def _grouped(tracker: AnyTracker, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that are of a stage, as ``stage.name``, without those of space."""
    rest = _apart(settings)[0] if tracker.is_of_first_view else settings
    found = {name: value for name, value in rest.items() if "." in name}
    for stage, own in rest.items():
        if isinstance(own, Mapping):
            found |= {f"{stage}.{name}": value for name, value in own.items()}
    return found


def _of_tracker(tracker: AnyTracker, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that are of a tracker itself, of no stage and not of space."""
    rest = _apart(settings)[0] if tracker.is_of_first_view else settings
    return {n: v for n, v in rest.items() if "." not in n and not isinstance(v, Mapping)}


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

    Parameters of stages are among them where they are set; :func:`recorded_parameters` has all.

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
    chosen = dataclasses.asdict(tracker_settings(trial, method=method, settings=settings))
    chosen |= by_dotted_name(stage_parameters(trial, method=method, settings=settings))
    if not trial_tracker(trial, method).is_of_first_view or len(trial.views) < 2:
        return chosen
    return chosen | {_SPACE: dataclasses.asdict(space_settings(trial, settings=settings))}


def by_dotted_name(stages: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return parameters of stages as settings have them: ``STAGE.NAME`` to values."""
    return {
        f"{stage}.{name}": value for stage, own in stages.items() for name, value in own.items()
    }


def recorded_parameters(tracker: AnyTracker) -> dict[str, Any]:
    """Return what a record of a run says of a tracker besides its settings.

    Parameters
    ----------
    tracker : Tracker
        The tracker.

    Returns
    -------
    dict
        ``parameters``: stage to the values in force; ``constants``: package to the other named
        numbers of its modules, which cannot be set.
    """
    constants = {package: constants_of(package) for package in tracker.packages}
    return {"parameters": parameters_of(tracker.stages), "constants": constants}


def method_of_tracks(trial: Trial, tracks: Tracks) -> tuple[AnyTracker, TrackerSettings]:
    """Return the tracker that made tracks and its settings, or those in force by default.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Tracks; where another program made them, they are gone on with by the default.

    Returns
    -------
    tracker : Tracker
        The tracker.
    settings : OfflineSettings, Maghsoudi2019Settings, PoseSettings or Pullar2009Settings
        Its settings.
    """
    made = _made_by(tracks)
    if made is None:
        return trial_tracker(trial), tracker_settings(trial)
    tracker = trial_tracker(trial, made["method"])
    settings = _of_tracker(tracker, with_present_names(made["settings"], kind=tracker.kind))
    return tracker, build_settings(tracker.settings, settings, where=_OF_TRACKS)


def stage_parameters_of_tracks(trial: Trial, tracks: Tracks) -> dict[str, dict[str, Any]]:
    """Return the parameters of stages that were set for tracks, or those of the trial.

    Parameters
    ----------
    trial : Trial
        The trial of the tracks.
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    dict
        Stage to names and values.
    """
    made = _made_by(tracks)
    if made is None:
        return stage_parameters(trial)
    tracker = trial_tracker(trial, made["method"])
    return read_parameters(_grouped(tracker, made["settings"]), tracker.stages, where=_OF_TRACKS)


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


def setting_names(method: str, *, kind: str = "paws") -> set[str]:
    """Return the names of the settings of a method, of paws or of jointed animals."""
    return {field.name for field in dataclasses.fields(find_tracker(kind, method).settings)}
