"""Trials from and to the content of a ``trial.toml``: sections of plain values, checked."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import build_settings
from pawnb.trial.description import Animal, Calibration, Kind, Trial, View


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
_SECTIONS = (*_SECTION_FIELDS, "animal", "views", "calibration", "tracking")


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
    for name in document:
        if name not in _SECTIONS:
            raise InputError(
                f"{where}: unknown section [{name}]{did_you_mean(name, _SECTIONS)}; "
                f"expected {', '.join(_SECTIONS)}."
            )
    head = build_settings(_Head, _section(document, "trial", where), where=f"{where}: [trial]")
    fps = _checked_fps(head.fps, where)
    if head.frames is not None and not 0 <= head.frames[0] < head.frames[1]:
        raise InputError(
            f"{where}: [trial] frames is {list(head.frames)}; expected first and one past last, "
            "for instance [0, 1000]."
        )
    tracks = _section(document, "tracks", where)
    legs = tracks.pop("legs", {})
    if not isinstance(legs, dict) or not all(isinstance(name, str) for name in legs.values()):
        raise InputError(
            f'{where}: [tracks] legs is {legs!r}; expected {{ leg = "name in the file" }}.'
        )
    sections = {name: _section(document, name, where) for name in ("treadmill", "start")}
    files = build_settings(
        _Files, {**sections["treadmill"], **sections["start"], **tracks}, where=where
    )
    tracking = document.get("tracking", {})
    if not isinstance(tracking, dict):
        raise InputError(f"{where}: [tracking] is {tracking!r}; expected a section with settings.")
    trial = Trial(
        kind=head.kind,
        name=head.name or folder.resolve().name,
        fps=fps,
        frames=head.frames,
        animal=_animal(document.get("animal", {}), where),
        folder=folder,
        belt_speed=files.belt_speed,
        views=_views(document.get("views", []), where),
        calibration=_calibration(document, where),
        start_points=files.points,
        start_pose=files.pose,
        tracks_file=files.file,
        tracks_legs=legs,
        tracking=tracking,
    )
    if trial.kind == "tracks" and trial.tracks_file is None:
        raise InputError(f"{where}: kind is 'tracks' but [tracks] file is missing; name the file.")
    if trial.kind != "tracks" and not trial.views:
        raise InputError(
            f"{where}: no [[views]]; a trial of kind {trial.kind!r} needs at least one."
        )
    return trial


def _section(document: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    """Return a copy of one section after refusing fields that do not belong there."""
    section = document.get(name, {})
    if not isinstance(section, dict):
        raise InputError(f"{where}: [{name}] is {section!r}; expected a section with fields.")
    known = _SECTION_FIELDS[name]
    for field_name in section:
        if field_name not in known:
            raise InputError(
                f"{where}: [{name}] has an unknown field {field_name!r}"
                f"{did_you_mean(field_name, known)}; known are {', '.join(known)}."
            )
    return dict(section)


def _checked_fps(fps: float | None, where: str) -> float:
    """Return the frame rate, or say that it is missing."""
    if fps is None:
        raise InputError(
            f"{where}: [trial] fps is missing; give the frame rate of the recording in "
            "frames per second, for instance fps = 250.0."
        )
    if not (math.isfinite(fps) and fps > 0):
        raise InputError(f"{where}: [trial] fps is {fps}; expected a number above 0.")
    return fps


def _animal(section: Any, where: str) -> Animal:
    """Read [animal]; every field beyond the known ones is kept in ``extra``."""
    if not isinstance(section, dict):
        raise InputError(f"{where}: [animal] is {section!r}; expected a section with fields.")
    names = {f.name for f in dataclasses.fields(Animal)} - {"extra"}
    known = {k: v for k, v in section.items() if k in names}
    animal = build_settings(Animal, {"id": "animal", **known}, where=f"{where}: [animal]")
    if len(animal.across) not in (0, 2):
        raise InputError(
            f"{where}: [animal] across names {len(animal.across)} points; expected two, at the "
            'left and at the right, for instance across = ["ear_L", "ear_R"].'
        )
    return dataclasses.replace(animal, extra={k: v for k, v in section.items() if k not in known})


def _views(sections: Any, where: str) -> tuple[View, ...]:
    """Read every [[views]] and check names, crops and patterns."""
    views: list[View] = []
    if not (isinstance(sections, list) and all(isinstance(s, dict) for s in sections)):
        raise InputError(f"{where}: views is {sections!r}; write each view under [[views]].")
    for number, section in enumerate(sections, start=1):
        place = f"{where}: [[views]] number {number}"
        for needed in ("name", "video"):
            if needed not in section:
                raise InputError(f'{place}: {needed} is missing; add {needed} = "...".')
        view = build_settings(View, section, where=place)
        u0, v0, u1, v1 = view.crop or (0, 0, 1, 1)
        if not (0 <= u0 < u1 and 0 <= v0 < v1):
            raise InputError(
                f"{place}: crop is {[u0, v0, u1, v1]}; expected u0, v0, u1, v1 with u0 < u1 and "
                "v0 < v1, half open."
            )
        if view.facing not in (None, 1, -1):
            raise InputError(f"{place}: facing is {view.facing}; expected 1 (right) or -1 (left).")
        views.append(view)
    names = [view.name for view in views]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{where}: two views are called {name!r}; give each its own name.")
    return tuple(views)


def _calibration(document: dict[str, Any], where: str) -> Calibration | None:
    """Read [calibration], if there is one; directions become unit vectors."""
    if "calibration" not in document:
        return None
    place = f"{where}: [calibration]"
    section = document["calibration"]
    if not isinstance(section, dict):
        raise InputError(f"{place} is {section!r}; expected a section with fields.")
    calibration = build_settings(Calibration, section, where=place)
    if calibration.px_per_unit is not None and calibration.px_per_unit <= 0:
        raise InputError(f"{place} px_per_unit is {calibration.px_per_unit}; expected above 0.")
    if calibration.dlt is not None and calibration.px_per_unit is not None:
        raise InputError(f"{place} has both dlt and px_per_unit; keep the one that is meant.")
    return dataclasses.replace(
        calibration,
        forward=_unit_vector(calibration.forward, f"{place} forward"),
        up=_unit_vector(calibration.up, f"{place} up"),
    )


def _unit_vector(vector: tuple[float, float, float], what: str) -> tuple[float, float, float]:
    """Return the direction with length 1, or say that it has none."""
    length = math.hypot(*vector)
    if not (math.isfinite(length) and length > 0):
        raise InputError(f"{what} is {list(vector)}; expected a direction that is not zero.")
    x, y, z = vector
    return x / length, y / length, z / length


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
    if trial.tracks_file is not None:
        document["tracks"] = {"file": trial.tracks_file}
        if trial.tracks_legs:
            document["tracks"]["legs"] = dict(trial.tracks_legs)
    if trial.tracking:
        document["tracking"] = dict(trial.tracking)
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
