"""What tracking writes, and how what was written is read again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.core.pose.as_tracks import animal_of, is_pose, poses_of
from pawnb.core.pose.pose_suspects import find_pose_suspects
from pawnb.core.pose.pose_table import pose_names, pose_table
from pawnb.core.rig import Rig
from pawnb.core.suspects.frames import find_suspects
from pawnb.errors import InputError, InputWarning
from pawnb.files import write_whole
from pawnb.gait.analysis.notes import Note
from pawnb.input_warnings import warn_of_input
from pawnb.io import native
from pawnb.io.pose import write_pose
from pawnb.io.tables import write_table
from pawnb.schema import Tracks
from pawnb.trial import Trial, trial_document, trial_from_document
from pawnb.workflow.conversion.foreign_tracks import read_belt
from pawnb.workflow.provenance.manifest import MANIFEST, find_fault, known_files, writing_results
from pawnb.workflow.provenance.notes import notes_table
from pawnb.workflow.reviewing.quality import QUALITY_FILE, assess_quality, quality_text

RESULTS_FOLDER = "results"
_OF_ANALYSIS = ("events.csv", "strides.csv", "dropped.csv")
"""Tables that every analysis writes side by side, and nobody who scores events by hand does."""

_MOST_NAMED = 4

RESULT_FILES = (
    "tracks.nc", "tracks.csv", "suspects.csv", "notes.csv", QUALITY_FILE, MANIFEST,
)  # fmt: skip
"""What tracking always writes, beside :attr:`Tracker.more_files` (:mod:`.provenance.manifest`)."""


FAILURE_FILE = "not_tracked.txt"
"""Why tracking failed, in the folder of results; it is there until a run ends well."""

_KEPT_OF_VIEWS = ("name", "facing", "mirror", "crop", "offset")
"""What tracks carry of the views they were made of."""


def describe_trial(
    tracks: Tracks, trial: Trial, *, sizes: Mapping[str, tuple[int, int]] | None = None
) -> Tracks:
    """Return Tracks that carry what gait needs to know of their trial.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of this trial; not modified.
    trial : Trial
        The trial.
    sizes : mapping, optional
        Width and height of each view's picture, px.

    Returns
    -------
    xarray.Dataset
        Tracks with the attribute ``trial`` (name, animal, calibration and views as a JSON
        text), where the sizes are given the attribute ``pictures_px`` (JSON as well) and, where
        the belt's speed is known, the variable ``belt_speed`` (time) in unit/s, so that a
        ``tracks.nc`` can be analysed without its trial.

    Raises
    ------
    InputError
        If the file of the belt's speed cannot be read, or lacks some of the frames.
    """
    document = trial_document(trial)
    kept: dict[str, Any] = {name: document[name] for name in ("trial", "animal")}
    if trial.gait:
        kept["gait"] = document["gait"]
    # an offset of 0 is written, too: tracks without any were made before crop and offset were kept
    kept["views"] = [
        {"offset": 0, **{name: view[name] for name in _KEPT_OF_VIEWS if name in view}}
        for view in document.get("views", [])
    ]
    if "calibration" in document:
        # files may be named by absolute paths, and are not there where these Tracks go
        kept["calibration"] = {
            name: value
            for name, value in document["calibration"].items()
            if name not in ("dlt", "anipose", "opencv", "lens")
        }
    tracks = tracks.assign_attrs(trial=json.dumps(kept, sort_keys=True))
    if sizes is not None:
        tracks.attrs["pictures_px"] = json.dumps({name: list(size) for name, size in sizes.items()})
    if trial.belt_speed is None:
        return tracks
    if isinstance(trial.belt_speed, str):
        table = read_belt(trial.path(trial.belt_speed))
        frames = tracks["frame"].to_numpy()
        known = table["frame"].to_numpy(dtype=float)
        if known.min() > frames.min() or known.max() < frames.max():
            raise InputError(
                f"{trial.belt_speed}: belt speed of frames {known.min():g} to {known.max():g}; "
                f"expected all from {frames.min()} to {frames.max()}."
            )
        speed = np.interp(frames, known, table["speed"].to_numpy(dtype=float))
    else:
        speed = np.full(tracks.sizes["time"], trial.belt_speed)
    unit = tracks.attrs["units"]
    return tracks.assign(belt_speed=("time", speed, {"units": f"{unit}/s"}))


def described_trial(tracks: Tracks, *, where: str, folder: Path) -> Trial | None:
    """Return the trial that Tracks carry, or None where they carry none.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks, as :func:`describe_trial` leaves them.
    where : str
        How messages name them.
    folder : Path
        Where they lie.

    Returns
    -------
    Trial or None
        Of kind ``tracks``: it names no file that must be there.
    """
    if "trial" not in tracks.attrs:
        return None
    document = json.loads(tracks.attrs["trial"])
    document["trial"]["kind"] = "tracks"
    document["tracks"] = {"file": "tracks.nc"}
    for view in document.get("views", []):
        view["video"] = ""
    return trial_from_document(document, where=where, folder=folder)


def results_folder(trial: Trial, out: str | Path | None = None) -> Path:
    """Return the folder for results: ``out``, or ``results`` beside the trial."""
    return Path(out) if out is not None else trial.folder / RESULTS_FOLDER


def write_track_results(
    tracks: Tracks, out: str | Path, *, rig: Rig | None = None, warn: bool = False
) -> Path:
    """Write ``tracks.nc``, its tables, ``suspects.csv``, ``quality.json`` and ``notes.csv``.

    ``provenance.json`` is written last.
    ``pose.csv`` of a jointed animal has no row for a frame in which it was not found.

    Parameters
    ----------
    tracks : xarray.Dataset
        What was tracked, with its provenance.
    out : str or Path
        The folder; it is made where it is absent.
    rig : Rig, optional
        The calibrated views: suspects are then told view by view.
    warn : bool
        Whether to warn of gait in the folder that is of the tracks of before.

    Returns
    -------
    Path
        The folder.
    """
    out = make_folder(out)
    with writing_results(out, run="track", steps=provenance_steps(tracks)) as staging:
        native.write_tracks(tracks, staging / "tracks.nc")
        write_table(native.tracks_table(tracks), staging / "tracks.csv")
        if tracks.sizes["space"] == 3:
            write_table(native.points3d_table(tracks), staging / "points3d.csv")
        if is_pose(tracks):
            animal, poses = animal_of(tracks), poses_of(tracks)
            table = pose_table(animal, poses.take(np.all(np.isfinite(poses.poses.xy), axis=1)))
            write_pose(table, staging / "pose.csv", names=pose_names(animal))
            write_table(find_pose_suspects(tracks), staging / "suspects.csv")
        elif "image_position" in tracks:
            write_table(find_suspects(tracks, rig=rig), staging / "suspects.csv")
        if "image_position" in tracks:
            write_whole(staging / QUALITY_FILE, quality_text(assess_quality(tracks)).encode())
        write_table(notes_table(tracking_notes(tracks)), staging / "notes.csv")
    (out / FAILURE_FILE).unlink(missing_ok=True)
    old_gait = find_fault(out, run="gait") if known_files(out).files_of("gait") else None
    if warn and old_gait is not None:
        warn_of_input(old_gait, InputWarning, stacklevel=3)
    return out


def note_failure(folder: str | Path, why: str) -> None:
    """Write down that a trial could not be tracked, until it is; a folder of results is made."""
    write_whole(make_folder(folder) / FAILURE_FILE, f"{' '.join(why.split())}\n".encode())


def failure_of(folder: str | Path) -> str:
    """Return why a trial could not be tracked when that was tried last; empty where it was."""
    path = Path(folder) / FAILURE_FILE
    try:
        return path.read_text(encoding="utf-8").strip() if path.is_file() else ""
    except (OSError, UnicodeDecodeError):
        return f"{path} cannot be read"


def read_result_tracks(path: str | Path) -> Tracks:
    """Read the tracks of a folder of results, and look whether that is whole.

    Parameters
    ----------
    path : str or Path
        The folder, or its ``tracks.nc``; or a trial, for what lies in its own folder of results.

    Returns
    -------
    xarray.Dataset
        The tracks.

    Raises
    ------
    InputError
        If there are none, or they cannot be read.

    Warns
    -----
    InputWarning
        If files of the folder are not as the run that is on record left them.
    """
    path = Path(path)
    if path.is_dir() and not (path / "tracks.nc").exists() and (path / "trial.toml").exists():
        path /= RESULTS_FOLDER
    path = path / "tracks.nc" if path.is_dir() else path
    tracks = native.read_tracks(path)
    tell_fault(tracks, path)
    return tracks


def tell_fault(tracks: Tracks, path: Path) -> None:
    """Warn where tracks of pawnb lie in a folder that is not whole.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    path : Path
        The file they were read from. Copies by other names say nothing of a folder.

    Warns
    -----
    InputWarning
        As for :func:`read_result_tracks`.
    """
    # tracks of another program have no such folder
    if path.name != "tracks.nc" or not provenance_steps(tracks):
        return
    fault = find_fault(path.parent, run="track")
    if fault is not None:
        warn_of_input(fault, InputWarning, stacklevel=3)


def tell_fault_of_events(path: Path) -> None:
    """Warn where an ``events.csv`` of pawnb's own lies in a folder that is not whole.

    Parameters
    ----------
    path : Path
        A table of events. Tables scored by hand lie where no run has written any.

    Warns
    -----
    InputWarning
        If files of the folder are not as the run that is on record left them.
    """
    if path.name in known_files(path.parent).files_of("gait"):
        fault = find_fault(path.parent, run="gait")
        if fault is not None:
            warn_of_input(fault, InputWarning, stacklevel=3)


def need_sources(folder: Path) -> None:
    """Refuse a folder of nothing but gait results: their events tell no filter and no drops.

    Parameters
    ----------
    folder : Path
        A folder that was given to the gait analysis.

    Raises
    ------
    InputError
        If an analysis wrote what is in it and no tracks are there; what it was made from is named.
    """
    if any((folder / name).exists() for name in ("trial.toml", "tracks.nc")):
        return
    steps = known_files(folder).steps_of("gait")
    if not steps and not all((folder / name).exists() for name in _OF_ANALYSIS):
        return
    command = next((step["command"] for step in steps if step.get("command")), "")
    asked = f" ({command})" if command else ""
    raise InputError(
        f"{folder} holds the results of an analysis{asked} and not what that was made from; name "
        f"{_sources_of(steps, folder)} instead, or {folder / 'events.csv'} for its events alone."
    )


def _sources_of(steps: list[dict[str, Any]], folder: Path) -> str:
    """Name what an analysis was made from, as far as the record says it."""
    given = [_lies_at(str(n), folder) for step in steps for n in step.get("given") or ()]
    if not given:
        return "the trial, the study or the tracks"
    more = f" and {len(given) - _MOST_NAMED} more" if len(given) > _MOST_NAMED else ""
    return ", ".join(given[:_MOST_NAMED]) + more


def _lies_at(label: str, folder: Path) -> str:
    """Return a path to an input of the record, from where the user is; else what that calls it."""
    parts = Path(label).parts
    tails = [Path(*parts[k:]) for k in range(len(parts))]
    for place in folder.resolve().parents:
        there = next((path for tail in tails if (path := place / tail).exists()), None)
        if there is not None:
            here = Path.cwd()
            return str(there.relative_to(here) if there.is_relative_to(here) else there)
    return label


def provenance_steps(tracks: Tracks) -> list[dict[str, Any]]:
    """Return the steps that made these Tracks, oldest first; none where they do not say."""
    try:
        steps = json.loads(tracks.attrs.get("provenance", "{}")).get("steps", [])
        named = all(isinstance(step["step"], str) for step in steps)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        named = False
    if not named:
        raise InputError(
            "the attribute 'provenance' of these tracks is not a record of steps; mend it, or take "
            "it away."
        )
    return list(steps)


def tracking_notes(tracks: Tracks) -> list[Note]:
    """Return what was warned of while these Tracks were made.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with their provenance.

    Returns
    -------
    list of Note
        Each names the step, and the trial where Tracks carry one.
    """
    trial = json.loads(tracks.attrs["trial"])["trial"]["name"] if "trial" in tracks.attrs else ""
    return [
        Note(note, where=f"{step['step']} {trial}".strip())
        for step in provenance_steps(tracks)
        for note in step.get("notes", ())
    ]


def make_folder(path: str | Path) -> Path:
    """Make a folder for results, or say why it cannot be."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: cannot make this folder ({error.strerror}); choose another with --out."
        ) from None
    return path
