"""Trials from and to the content of a ``trial.toml``: sections of plain values, checked."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import build_settings, shown
from pawnb.trial.description import Animal, Calibration, Trial, View
from pawnb.trial.detections import FIELDS as EVIDENCE_FIELDS
from pawnb.trial.detections import read_detections, read_detections_points, read_point_tracker
from pawnb.trial.kinds import Kind

PartT = TypeVar("PartT")


@dataclass(frozen=True)
class _Head:
    """Fields of [trial]."""

    kind: Kind = "paws"
    name: str | None = None
    fps: float | None = None
    frames: tuple[int, int] | None = None


@dataclass(frozen=True)
class _Files:
    """Fields of the sections [treadmill], [start] and [tracks]."""

    belt_speed: float | str | None = None
    points: str | None = None
    pose: str | None = None
    file: str | None = None


_SECTION_FIELDS = {
    "trial": ("kind", "name", "fps", "frames"),
    "treadmill": ("belt_speed",),
    "start": ("points", "pose"),
    "tracks": ("file", "legs"),
}
_SECTIONS = (*_SECTION_FIELDS, "animal", "views", "calibration", "tracking", "gait")


def trial_from_document(document: dict[str, Any], *, where: str, folder: Path) -> Trial:
    """Build a Trial from the parsed content of a ``trial.toml``.

    Parameters
    ----------
    document : dict
        Sections and their fields.
    where : str
        How messages name the file.
    folder : Path
        Folder that the paths in it are relative to.

    Returns
    -------
    Trial
        The checked description.

    Raises
    ------
    InputError
        As for :func:`load_trial`.
    """
    _check_sections(document, where)
    head = _build(_Head, _section(document, "trial", where), f"{where}: [trial]")
    if head.fps is None:
        raise InputError(
            f"{where}: [trial] fps is missing; give the frame rate of the recording in "
            "frames per second, for instance fps = 250.0."
        )
    tracks = _section(document, "tracks", where)
    legs = _legs(tracks, where)
    of_views = _files_of_views(tracks, where)
    sections = {name: _section(document, name, where) for name in ("treadmill", "start")}
    files = _build(_Files, {**sections["treadmill"], **sections["start"], **tracks}, where)
    tracking = _settings(document, "tracking", where)
    parts: dict[str, Any] = {
        "gait": _settings(document, "gait", where),
        "animal": _animal(document.get("animal", {}), where),
        "views": _views(document.get("views", []), where),
        "calibration": _calibration(document, where),
    }
    try:
        trial = Trial(
            kind=head.kind,
            name=head.name or folder.resolve().name,
            fps=head.fps,
            frames=head.frames,
            folder=folder,
            belt_speed=files.belt_speed,
            start_points=files.points,
            start_pose=files.pose,
            tracks_file=files.file,
            tracks_of_views=of_views,
            tracks_legs=legs,
            tracking={k: v for k, v in tracking.items() if k not in EVIDENCE_FIELDS},
            detections=read_detections(
                tracking.get("detections", {}), [view.name for view in parts["views"]]
            ),
            detections_points=read_detections_points(tracking.get("detections_points", {})),
            point_tracker=read_point_tracker(tracking.get("point_tracker")),
            **parts,
        )
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    _check_sources(trial, where)
    return trial


def _check_sections(document: dict[str, Any], where: str) -> None:
    """Refuse a section that no trial has."""
    for name in document:
        if name not in _SECTIONS:
            raise InputError(
                f"{where}: unknown section [{name}]{did_you_mean(name, _SECTIONS)}; "
                f"expected {', '.join(_SECTIONS)}."
            )


def _settings(document: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    """Return a section of free settings."""
    found = document.get(name, {})
    if not isinstance(found, dict):
        raise InputError(f"{where}: [{name}] is {shown(found)}; expected a section with settings.")
    return found


def _legs(tracks: dict[str, Any], where: str) -> dict[str, str]:
    """Take the names of legs out of ``[tracks]``."""
    legs = tracks.pop("legs", {})
    if not isinstance(legs, dict) or not all(isinstance(name, str) for name in legs.values()):
        raise InputError(
            f'{where}: [tracks] legs is {shown(legs)}; expected {{ leg = "name in the file" }}.'
        )
    return legs


def _check_sources(trial: Trial, where: str) -> None:
    """Refuse a trial that names nothing to be tracked, or no tracks."""
    if trial.is_tracked_elsewhere and not trial.track_files:
        raise InputError(f"{where}: kind is 'tracks' but [tracks] file is missing; name the file.")
    if not trial.is_tracked_elsewhere and not trial.views:
        raise InputError(
            f"{where}: no [[views]]; a trial of kind {trial.kind!r} needs at least one."
        )


def _files_of_views(tracks: dict[str, Any], where: str) -> dict[str, str]:
    """Take the files of [tracks] out where there is one a view."""
    if not isinstance(tracks.get("file"), dict):
        return {}
    files = tracks.pop("file")
    if not files or not all(isinstance(name, str) and name for name in files.values()):
        raise InputError(
            f'{where}: [tracks] file is {shown(files)}; expected {{ view = "its file" }}.'
        )
    return dict(files)


def _section(document: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    """Return a copy of one section after refusing fields that do not belong there."""
    section = document.get(name, {})
    if not isinstance(section, dict):
        raise InputError(f"{where}: [{name}] is {shown(section)}; expected a section with fields.")
    known = _SECTION_FIELDS[name]
    for field_name in section:
        if field_name not in known:
            raise InputError(
                f"{where}: [{name}] has an unknown field {field_name!r}"
                f"{did_you_mean(field_name, known)}; known are {', '.join(known)}."
            )
    return dict(section)


def _animal(section: Any, where: str) -> Animal:
    """Read [animal]; every field beyond the known ones is kept in ``extra``."""
    if not isinstance(section, dict):
        raise InputError(f"{where}: [animal] is {shown(section)}; expected a section with fields.")
    names = {f.name for f in dataclasses.fields(Animal)} - {"extra"}
    known = {k: v for k, v in section.items() if k in names}
    animal = _build(Animal, {"id": "animal", **known}, f"{where}: [animal]")
    return dataclasses.replace(animal, extra={k: v for k, v in section.items() if k not in known})


def _views(sections: Any, where: str) -> tuple[View, ...]:
    """Read every [[views]] and check names, crops and patterns."""
    views: list[View] = []
    if not (isinstance(sections, list) and all(isinstance(s, dict) for s in sections)):
        raise InputError(f"{where}: views is {shown(sections)}; write each view under [[views]].")
    for number, section in enumerate(sections, start=1):
        place = f"{where}: [[views]] number {number}"
        for needed in ("name", "video"):
            if needed not in section:
                raise InputError(f'{place}: {needed} is missing; add {needed} = "...".')
        views.append(_build(View, section, place))
    return tuple(views)


def _build(cls: type[PartT], values: dict[str, Any], place: str) -> PartT:
    """Make a part of a trial; whatever is wrong with it begins with its place."""
    try:
        return build_settings(cls, values, where="", typed=True)
    except InputError as error:
        raise InputError(f"{place}: {str(error).removeprefix(': ')}") from None


def _calibration(document: dict[str, Any], where: str) -> Calibration | None:
    """Read [calibration], if there is one; directions become unit vectors."""
    if "calibration" not in document:
        return None
    place = f"{where}: [calibration]"
    section = document["calibration"]
    if not isinstance(section, dict):
        raise InputError(f"{place} is {shown(section)}; expected a section with fields.")
    return _build(Calibration, section, place)


def trial_document(trial: Trial) -> dict[str, Any]:
    """Return the content of a ``trial.toml``: sections of plain values.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    dict
        What :func:`trial_from_document` reads.
    """
    head: dict[str, Any] = {"kind": trial.kind, "name": trial.name, "fps": trial.fps}
    if trial.frames is not None:
        head["frames"] = list(trial.frames)
    document: dict[str, Any] = {
        "trial": head,
        "animal": {**_changed(trial.animal, keep=("id",), skip=("extra",)), **trial.animal.extra},
    }
    if trial.belt_speed is not None:
        document["treadmill"] = {"belt_speed": trial.belt_speed}
    if trial.views:
        document["views"] = [_changed(view, keep=("name", "video")) for view in trial.views]
    if trial.calibration is not None:
        document["calibration"] = _changed(trial.calibration, keep=("unit",))
    start = {"points": trial.start_points, "pose": trial.start_pose}
    if any(start.values()):
        document["start"] = {k: v for k, v in start.items() if v}
    if trial.track_files:
        document["tracks"] = {"file": trial.tracks_file or dict(trial.tracks_of_views)}
        if trial.tracks_legs:
            document["tracks"]["legs"] = dict(trial.tracks_legs)
    evidence = {name: getattr(trial, name) for name in EVIDENCE_FIELDS}
    named = {k: own if isinstance(own, str) else dict(own) for k, own in evidence.items() if own}
    tracking = {**trial.tracking, **named}
    if tracking:
        document["tracking"] = tracking
    if trial.gait:
        document["gait"] = dict(trial.gait)
    return document


def _changed(item: Any, *, keep: tuple[str, ...], skip: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return the fields that differ from their defaults, as TOML can write them."""
    values = {}
    for f in dataclasses.fields(item):
        value = getattr(item, f.name)
        if f.name in skip or value is None or (f.name not in keep and value == f.default):
            continue
        values[f.name] = list(value) if isinstance(value, tuple) else value
    return values
