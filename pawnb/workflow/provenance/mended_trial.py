"""Tracks of a trial whose ``trial.toml`` was mended after it was tracked.

A frame rate, a scale or a belt speed that was wrong does not change where points are in the
pictures, so the tracks are brought to what the trial says now. What does change it is said.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pawnb.errors import InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import Tracks
from pawnb.trial import Trial, View
from pawnb.workflow.provenance.record import (
    file_checksum,
    film_sizes,
    name_on_record,
)
from pawnb.workflow.provenance.results import describe_trial, provenance_steps, results_folder

_EVEN = 1e-3
"""How far times may lie off frame / fps, in frames, and still be made by it."""


def as_described_now(tracks: Tracks, trial: Trial) -> Tracks:
    """Bring tracks that pawnb made of a trial to its frame rate, scale and belt speed of now.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks as they were read; not modified.
    trial : Trial
        Their trial, as ``trial.toml`` describes it now.

    Returns
    -------
    xarray.Dataset
        The same where nothing was mended.

    Warns
    -----
    InputWarning
        What has changed, and where tracking again is needed.
    """
    if "trial" not in tracks.attrs:
        return tracks
    before = json.loads(tracks.attrs["trial"])
    said: list[str] = []
    now = _rescaled(_retimed(tracks, trial, said), before, trial, said)
    now = _on_belt(now, trial, said)
    again = changed_inputs(tracks, trial)
    sizes = json.loads(tracks.attrs["pictures_px"]) if "pictures_px" in tracks.attrs else None
    if said:
        now = describe_trial(now, trial, sizes=sizes)
        # the pictures stay those that were tracked
        document = json.loads(now.attrs["trial"]) | {"views": before.get("views", [])}
        now.attrs["trial"] = json.dumps(document, sort_keys=True)
    if again:
        said.append(f"{' and '.join(again)} changed: pawnb track again")
    said += [
        f"{name} was replaced by another film: clicks, tracks and corrections are of the one "
        "before; put it back, or click and track again"
        for name in _replaced_films(tracks, trial)
    ]
    said += tell_exchanged_views(_record(tracks), trial)
    said += _other_pictures(before, trial, sizes or {})
    if said:
        text = f"{trial.name}: since it was tracked, {'; '.join(said)}."
        warn_of_input(text, InputWarning, stacklevel=3)
    return now


def changed_inputs(tracks: Tracks, trial: Trial) -> list[str]:
    """Name the clicks and calibrations that are not those the tracks were made with.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks that pawnb made of the trial.
    trial : Trial
        The trial.

    Returns
    -------
    list of str
        Names of files; of these only what the record of tracking knows.
    """
    known = {Path(label).name: checksum for label, checksum in _inputs(tracks).items()}
    if not known:
        return []
    calibration = trial.calibration
    # clicks may have been given by hand, and are on record only where they were read
    clicks = (trial.start_file(), trial.start_pose_file())
    named: list[str | None] = [n for n in clicks if n and Path(n).name in known]
    if calibration is not None:
        named += [calibration.of_views, calibration.lens]
    paths = [trial.path(name) for name in named if name is not None]
    return [
        path.name
        for path in paths
        if path.is_file() and known.get(path.name) != file_checksum(path)
    ]


def _inputs(tracks: Tracks, what: str = "inputs") -> dict[str, Any]:
    """Return the checksums of what the tracks were made from, by the names in the trial.

    Or what else the record says of each, such as ``film_bytes``.
    """
    return _record(tracks).get(what) or {}


def _record(tracks: Tracks) -> dict[str, Any]:
    """Return the record of tracking that tracks carry; empty where they carry none."""
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    return made[-1] if made else {}


def tell_exchanged_views(record: Mapping[str, Any], trial: Trial) -> list[str]:
    """Say which views name the film that another view had when the trial was tracked.

    Parameters
    ----------
    record : mapping
        The record of tracking then; of a trial that was not tracked, empty.
    trial : Trial
        The trial as it is now.

    Returns
    -------
    list of str
        A sentence for each such view. Films that were moved, renamed or compressed again are not
        those of another view.
    """
    films, known = record.get("films") or {}, record.get("inputs") or {}
    said = []
    for view in trial.views:
        was, now = films.get(view.name), name_on_record(view.video)
        others = [other for other, film in films.items() if film == now]
        if was in (None, now) or not others or known.get(now) == known.get(was):
            continue
        film = trial.path(view.video)
        if film.exists() and file_checksum(film) == known.get(now):
            said.append(
                f"view {view.name} was given {now}, the film that {' and '.join(others)} had, in "
                f"place of {was}: clicks, tracks and corrections of {view.name} are of {was}; put "
                "it back, or click and track again"
            )
    return said


def _replaced_films(tracks: Tracks, trial: Trial) -> list[str]:
    """Name the films that are not those that were tracked.

    Films are large: those of the same size are read only where they changed after the tracks were
    written. Clocks of two drives may differ, and a study that was copied has lost its times.
    """
    written = results_folder(trial) / "tracks.nc"
    if not written.is_file():
        return []
    known, sizes = _inputs(tracks), _inputs(tracks, "film_bytes")
    now = film_sizes(trial)
    films = {name_on_record(view.video): trial.path(view.video) for view in trial.views}
    return [
        name
        for name, film in films.items()
        if name in known
        and film.exists()
        and (
            sizes.get(name, now.get(name)) != now.get(name)
            or (_changed_at(film) > _changed_at(written) and known[name] != file_checksum(film))
        )
    ]


def _changed_at(path: Path) -> float:
    """Return when a file was last written or, where copies keep that, came to be there."""
    state = path.stat()
    return max(state.st_mtime, state.st_ctime)


def _other_pictures(before: dict[str, Any], trial: Trial, sizes: dict[str, list[int]]) -> list[str]:
    """Say in which respects the pictures are not those that were tracked."""
    said = []
    frames = before.get("trial", {}).get("frames")
    if frames != (None if trial.frames is None else list(trial.frames)):
        said.append(
            f"frames was changed from {_word(frames)} to {_word(trial.frames)}: pawnb track again"
        )
    was = {view["name"]: view for view in before.get("views", [])}
    for view in trial.views:
        old = was.get(view.name)
        if old is None:
            continue
        if "offset" in old and old["offset"] != view.offset:
            said.append(
                f"offset of {view.name} was changed from {old['offset']} to {view.offset}: pawnb "
                "track again"
            )
        changed = [] if old.get("mirror", False) == view.mirror else ["mirror"]
        if _crop_changed(old, view, sizes.get(view.name)):
            changed.append(f"crop (from {_word(old.get('crop'))} to {_word(view.crop)})")
        if changed:
            said.append(
                f"{' and '.join(changed)} of {view.name} changed: clicks, tracks and corrections "
                "are in pixels of the picture before; put it back, or click and track again"
            )
    return said


def _crop_changed(old: dict[str, Any], view: View, size: list[int] | None) -> bool:
    """Tell whether another part of the picture is meant than that which was tracked."""
    crop = None if view.crop is None else list(view.crop)
    if "crop" in old or "offset" in old:
        return old.get("crop") != crop
    # tracks of before crops were kept know the size of their pictures only
    return crop is not None and size is not None and size != [crop[2] - crop[0], crop[3] - crop[1]]


def _word(numbers: Sequence[int] | None) -> str:
    """Return numbers, or that there were none."""
    return "none" if numbers is None else str(list(numbers))


def _retimed(tracks: Tracks, trial: Trial, said: list[str]) -> Tracks:
    """Bring the times of frames to the frame rate of the trial."""
    old, new = float(tracks.attrs["fps"]), trial.fps
    if math.isclose(old, new, rel_tol=1e-9):
        return tracks
    frame, time = tracks["frame"].to_numpy(), tracks["time"].to_numpy().astype(float)
    change = f"fps was changed from {old:g} to {new:g}"
    if np.abs((time - time[0]) * old - (frame - frame[0])).max() > _EVEN:
        said.append(f"{change}, and times are of the video's own stamps: pawnb track again")
        return tracks.assign_attrs(fps=new)
    said.append(f"{change} (times are counted anew)")
    times = tracks["time"] * (old / new)
    return tracks.assign_coords(time=times.assign_attrs(tracks["time"].attrs)).assign_attrs(fps=new)


def _rescaled(tracks: Tracks, before: dict[str, Any], trial: Trial, said: list[str]) -> Tracks:
    """Bring the positions of a single view to the scale of the trial."""
    old = before.get("calibration", {}).get("px_per_unit")
    calibration = trial.calibration
    new = None if calibration is None else calibration.px_per_unit
    unit = "px" if calibration is None or new is None else calibration.unit
    is_scaled = old is not None or tracks.attrs["units"] == "px"
    if not is_scaled or (old == new and tracks.attrs["units"] == unit):
        return tracks
    said.append(
        f"px_per_unit was changed from {_number(old)} to {_number(new)} (positions are in {unit})"
    )
    factor = (old or 1.0) / (new or 1.0)
    scaled = {
        name: (tracks[name] * factor).assign_attrs(tracks[name].attrs | {"units": unit})
        for name in ("position", "sd", "revision")
        if name in tracks
    }
    return tracks.assign(scaled).assign_attrs(units=unit)


def _on_belt(tracks: Tracks, trial: Trial, said: list[str]) -> Tracks:
    """Bring the speed of the belt to that of the trial."""
    named = trial.belt_speed
    if isinstance(named, str) and not trial.path(named).is_file():
        return tracks  # which carry what was in it
    old = tracks.get("belt_speed")
    bare = tracks.drop_vars("belt_speed", errors="ignore")
    new = describe_trial(bare, trial).get("belt_speed")
    if old is None and new is None:
        return tracks
    if old is not None and new is not None and np.allclose(old, new, equal_nan=True):
        return tracks
    said.append(f"belt_speed was changed from {_speed(old)} to {_speed(new)}")
    return bare if new is None else bare.assign(belt_speed=new)


def _speed(belt: xr.DataArray | None) -> str:
    """Return the speed of a belt, or its range, or that there was none."""
    if belt is None:
        return "none"
    low, high = float(belt.min()), float(belt.max())
    return f"{low:g}" if math.isclose(low, high) else f"{low:g} ... {high:g}"


def _number(value: float | None) -> str:
    """Return a number, or that there was none."""
    return "none" if value is None else f"{value:g}"
