"""What a trial has, what is missing, and what looks wrong, before any work is done."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from pawnb.core.lens import load_lenses
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    LOOK_AT_CLICKS,
    doubted_clicks_in_words,
    doubted_clicks_of,
)
from pawnb.core.pixels.grey import has_colour
from pawnb.core.rig import load_rig
from pawnb.core.suspects.moved_views import moved_views_of
from pawnb.core.video import Frame, ViewReader, ViewSet, open_views
from pawnb.core.video.doubts.cuts import WatchedViews, tell_cuts
from pawnb.core.video.doubts.interlaced import HOW_TO_MEND, looks_interlaced
from pawnb.core.video.doubts.one_film import tell_same_films
from pawnb.core.video.doubts.repeated import freezes_of_views, tell_freezes, tell_repeats
from pawnb.errors import InputError, InputWarning, PawnbError
from pawnb.gait.analysis.leg_names import choose_legs
from pawnb.gait.legs import sort_legs
from pawnb.input_warnings import hearing_input_warnings
from pawnb.io.cameras import read_cameras
from pawnb.io.native import read_tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, View, load_trial
from pawnb.workflow.checking.check_report import CheckReport
from pawnb.workflow.conversion.file_pixels import picture_sizes
from pawnb.workflow.conversion.film_of_tracks import doubt_film_of_tracks
from pawnb.workflow.conversion.foreign_tracks import read_belt, read_foreign_tracks
from pawnb.workflow.gait.event_sources import read_trial_events
from pawnb.workflow.gait.inputs import check_settings
from pawnb.workflow.kinds import kind_of
from pawnb.workflow.provenance.manifest import RUN_KINDS, find_fault, known_files
from pawnb.workflow.provenance.mended_trial import as_described_now
from pawnb.workflow.provenance.results import provenance_steps, results_folder
from pawnb.workflow.tracking.methods import stage_parameters, tracker_settings
from pawnb.workflow.tracking.unsynchronised import doubt_synchronisation

_MOST_LOOKED_FOR_CUTS = 2000
"""Resource: frames in which a check looks for cuts; tracking looks in all."""


@checked_arguments
def check_trial(trial: Trial | str | Path) -> CheckReport:
    """Look at everything a trial names.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.

    Returns
    -------
    CheckReport
        Findings; work can start where ``faults`` is empty.

    Raises
    ------
    InputError
        If ``trial.toml`` itself cannot be read.

    Examples
    --------
    >>> report = pawnb.check_trial(trial)
    >>> report.faults
    []
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    report = CheckReport(trial.name)
    report.found.append(
        f"kind {trial.kind}, animal {trial.animal.id}, {trial.fps:g} frames per second"
    )
    _check_belt(trial, report)
    _check_gait_settings(trial, report)
    _check_camera_sizes(trial, report)
    sizes: dict[str, list[int]] = {}
    if trial.is_tracked_elsewhere:
        _check_tracks_file(trial, report)
    else:
        sizes = _check_views(trial, report)
    _check_results(trial, report, sizes)
    return report


def _check_results(trial: Trial, report: CheckReport, sizes: Mapping[str, list[int]]) -> None:
    """Say whether the trial is tracked already, and doubt tracks that cannot be used as they are.

    ``sizes`` are those of the pictures, as views show them now.
    """
    path = results_folder(trial) / "tracks.nc"
    name = f"{path.parent.name}/{path.name}"
    for run in RUN_KINDS:
        if known_files(path.parent).files_of(run) and (fault := find_fault(path.parent, run=run)):
            report.doubts.append(fault.rstrip("."))
    if not path.exists():
        return
    try:
        tracks = read_tracks(path)
    except PawnbError as error:
        report.doubts.append(
            f"{name} cannot be read, so the trial counts as not tracked: {str(error).rstrip('.')}; "
            "delete it and track again, or copy it anew from where it is whole"
        )
        return
    report.found.append(f"tracked already: {name}, {tracks.sizes['time']} frames")
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    if made and not made[-1].get("complete", True):
        report.doubts.append(f"{name} is of a run that was interrupted; track again to go on")
    if trial.is_tracked_elsewhere:
        return
    told: list[InputWarning] = []
    with hearing_input_warnings(told.append, shown=False):
        tracks = as_described_now(tracks, trial)
    report.doubts += [str(one).rstrip(".") for one in told]
    with suppress(PawnbError):  # a calibration that cannot be read is said where it is needed
        rig = load_rig(trial, sizes=picture_sizes(trial))
        report.doubts += [f"{name}: {one.sentence}" for one in moved_views_of(tracks, rig)]
    clicked = doubted_clicks_in_words(doubted_clicks_of(tracks))
    report.doubts += [f"{name}: {words}; {LOOK_AT_CLICKS}" for words in clicked]
    before = json.loads(tracks.attrs.get("pictures_px", "{}"))
    for name, size in sizes.items():
        was = before.get(name, size)
        if was != size and not any("crop" in str(one) for one in told):
            why = " (before it was heeded how the camera was held)" if was == size[::-1] else ""
            report.doubts.append(
                f"view {name} was clicked and tracked in pictures of {was[0]} x {was[1]} px{why}, "
                f"which are {size[0]} x {size[1]} px now: clicks and tracks lie in other pixels; "
                "click and track again"
            )


def _check_belt(trial: Trial, report: CheckReport) -> None:
    """Say the belt's speed, and doubt it where it is not positive."""
    unit = trial.calibration.unit if trial.calibration is not None else "unit"
    if isinstance(trial.belt_speed, str):
        try:
            table = read_belt(trial.path(trial.belt_speed))
        except InputError as error:
            report.faults.append(str(error))
            return
        speeds = table["speed"].to_numpy()
        report.found.append(
            f"belt speed from {trial.belt_speed}: {speeds.min():g} to {speeds.max():g} {unit}/s"
        )
    elif trial.belt_speed is not None:
        report.found.append(f"belt speed {trial.belt_speed:g} {unit}/s")
        if trial.belt_speed <= 0:
            report.doubts.append(
                f"belt speed is {trial.belt_speed:g}; a belt that carries the feet backwards "
                "has a speed above 0"
            )


def _check_gait_settings(trial: Trial, report: CheckReport) -> None:
    """Find what the gait analysis would refuse only after the trial was tracked."""
    try:
        check_settings(trial.gait, where="[gait]")
    except InputError as error:
        report.faults.append(str(error))


def _check_camera_sizes(trial: Trial, report: CheckReport) -> None:
    """Doubt cameras and lenses that were measured with pictures of another size."""
    calibration = trial.calibration
    file = calibration.cameras or calibration.lens if calibration is not None else None
    if calibration is None or file is None:
        return
    shown = picture_sizes(trial)
    with suppress(PawnbError):  # what cannot be read is said where it is needed
        made = (
            {name: lens.size for name, lens in load_lenses(trial.path(file)).items()}
            if calibration.cameras is None
            else {camera.name: camera.size for camera in read_cameras(trial.path(file))}
        )
        for name, size in made.items():
            if size is not None and name in shown and size != shown[name]:
                report.doubts.append(
                    f"{file}: camera {name!r} was calibrated with pictures of "
                    f"{size[0]} x {size[1]} px, and the video of that view has "
                    f"{shown[name][0]} x {shown[name][1]}; calibrate with pictures of the video's "
                    "size, or correct 'size' where only that is wrong"
                )


def _check_tracks_file(trial: Trial, report: CheckReport) -> None:
    """Read the tracks made elsewhere as the gait analysis will, and say what they hold."""
    name = ", ".join(trial.track_files)
    absent = [trial.path(one) for one in trial.track_files if not trial.path(one).exists()]
    if absent:
        report.faults.append(f"{absent[0]}: no such tracks; check [tracks] file.")
        return
    try:
        events = read_trial_events(trial)
        if events is not None:
            scored = ", ".join(sort_legs(events["leg"].astype(str)))
            report.found.append(f"events in {name}: {len(events)}, of legs {scored}")
            return
        tracks = read_foreign_tracks(trial)
        report.found.append(
            f"tracks in {name}: {tracks.sizes['time']} frames, positions in {tracks.attrs['units']}"
        )
        legs = choose_legs(tracks, trial=trial, where=name)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    if not np.isfinite(tracks["position"]).any() and "image_position" not in tracks:
        report.faults.append(f"{name}: no point has a position in any frame.")
    told = ", ".join(leg if leg == point else f"{leg} is {point!r}" for leg, point in legs.items())
    report.found.append(f"legs: {told}")
    report.doubts += [doubt.rstrip(".") for doubt in doubt_film_of_tracks(trial, tracks)]


def _check_views(trial: Trial, report: CheckReport) -> dict[str, list[int]]:
    """Open the views, read their first and last frame, and check what depends on them.

    Returns the width and height of each view, as far as they can be opened.
    """
    sizes: dict[str, list[int]] = {}
    try:
        tracker_settings(trial)
        stage_parameters(trial)
    except PawnbError as error:
        report.faults.append(str(error))
    try:
        views = open_views(trial)
    except PawnbError as error:
        report.faults.append(str(error))
        return sizes
    with views:
        pictures: Mapping[str, Frame] = {}
        for frame in (views.n_frames - 1, 0):
            try:
                pictures = views.frame(frame)
            except PawnbError as error:
                report.faults.append(str(error))
        for name in views.names:
            reader = views.readers[name]
            sizes[name] = [reader.width, reader.height]
            report.found.append(
                f"view {name}: {reader.n_frames} frames of {reader.width} x {reader.height} px"
                f"{_say_crop(trial.view(name), reader)}, {_say_colour(reader, pictures.get(name))}"
            )
        report.doubts += [*views.notes, *tell_same_films(views)]
        if not report.faults:
            first, stop = trial.frames or (0, views.n_frames)
            stop = min(stop, views.n_frames)
            try:
                report.doubts += doubt_synchronisation(trial, views, start=first, stop=stop)
                report.doubts += _doubt_weave(trial, views, first, stop)
                report.doubts += tell_repeats(trial, views, start=first, stop=stop)
                looked = min(stop, first + _MOST_LOOKED_FOR_CUTS)
                watched = WatchedViews(views)
                for _ in watched.frames(first, looked):
                    pass
                report.doubts += tell_cuts(views, watched.find_cuts(trial))
                report.doubts += tell_freezes(
                    views, freezes_of_views(trial, views, start=first, stop=stop)
                )
            except PawnbError as error:
                report.faults.append(str(error))
        kind_of(trial).check_start(trial, views, report)
    return sizes


def _doubt_weave(trial: Trial, views: ViewSet, first: int, stop: int) -> list[str]:
    """Say which films look interlaced though they do not say it, once a film."""
    seen: dict[str, str] = {}
    for name, reader in views.readers.items():
        view = trial.view(name)
        if view.video in seen or any(HOW_TO_MEND in note for note in reader.source.notes):
            continue
        offset = view.offset
        if looks_interlaced(reader, start=first + offset, stop=stop + offset):
            seen[view.video] = (
                f"{reader.source.name} looks interlaced, though it does not say so: "
                f"{HOW_TO_MEND} (where things then go to and fro, with parity=bff)"
            )
    return list(seen.values())


def _say_colour(reader: ViewReader, first: Frame | None) -> str:
    """Say whether a view is in colour: grey recordings are often stored as colour video."""
    if not reader.is_colour:
        return "grey"
    return "colour" if first is None or has_colour(first.image()) else "grey, stored in colour"


def _say_crop(view: View, reader: ViewReader) -> str:
    """Say which part of the picture a crop keeps: four numbers may be meant in another way."""
    if view.crop is None:
        return ""
    u0, v0, u1, v1 = view.crop
    source = reader.source
    return (
        f" (crop: u {u0} to {u1 - 1} and v {v0} to {v1 - 1} of {source.width} x {source.height} px)"
    )
