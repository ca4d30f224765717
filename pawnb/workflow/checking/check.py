"""What a trial has, what is missing, and what looks wrong, before any work is done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import warn_of_ambiguous_colour
from pawnb.core.rig import Rig
from pawnb.core.video import ViewReader, ViewSet, open_views
from pawnb.errors import InputError, PawnbError
from pawnb.gait.analysis.leg_names import choose_legs
from pawnb.gait.legs import sort_legs
from pawnb.io.native import read_tracks
from pawnb.io.start import check_start, read_start
from pawnb.trial import Trial, View, load_trial
from pawnb.workflow.checking.check_pose import check_pose_trial
from pawnb.workflow.checking.check_report import CheckReport
from pawnb.workflow.conversion.foreign_tracks import read_belt, read_foreign_tracks
from pawnb.workflow.gait.event_sources import read_trial_events
from pawnb.workflow.provenance.manifest import RUN_KINDS, find_fault, known_files
from pawnb.workflow.provenance.results import provenance_steps, results_folder
from pawnb.workflow.tracking.methods import stage_parameters, tracker_settings, trial_tracker
from pawnb.workflow.tracking.predicted import doubt_predictions, read_predictions
from pawnb.workflow.tracking.trial_views import frame_range, paw_task, points_by_view, trial_rig

MAX_CLICK_RESIDUAL_PX = 10.0


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
    if trial.kind == "tracks":
        _check_tracks_file(trial, report)
    else:
        _check_views(trial, report)
    _check_results(trial, report)
    return report


def _check_results(trial: Trial, report: CheckReport) -> None:
    """Say whether the trial is tracked already, and doubt tracks that cannot be read."""
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


def _check_views(trial: Trial, report: CheckReport) -> None:
    """Open the views, read their first and last frame, and check what depends on them."""
    try:
        tracker_settings(trial)
        stage_parameters(trial)
    except PawnbError as error:
        report.faults.append(str(error))
    try:
        views = open_views(trial)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    with views:
        for name in views.names:
            reader = views.readers[name]
            colour = "colour" if reader.is_colour else "grey"
            report.found.append(
                f"view {name}: {reader.n_frames} frames of {reader.width} x {reader.height} px"
                f"{_say_crop(trial.view(name), reader)}, {colour}"
            )
        report.doubts += views.notes
        for frame in (0, views.n_frames - 1):
            try:
                views.frame(frame)
            except PawnbError as error:
                report.faults.append(str(error))
        _CHECK_START[trial_tracker(trial).kind](trial, views, report)


def _say_crop(view: View, reader: ViewReader) -> str:
    """Say which part of the picture a crop keeps: four numbers may be meant in another way."""
    if view.crop is None:
        return ""
    u0, v0, u1, v1 = view.crop
    source = reader.source
    return (
        f" (crop: u {u0} to {u1 - 1} and v {v0} to {v1 - 1} of {source.width} x {source.height} px)"
    )


def _check_calibration(trial: Trial, views: ViewSet, report: CheckReport) -> None:
    """Check the calibration, and the start clicks against it."""
    try:
        rig = trial_rig(trial, views)
    except PawnbError as error:
        report.faults.append(str(error))
        rig = None
    else:
        if rig is not None:
            report.found.append(f"DLT of {len(rig.names)} views, unit {rig.unit}")
        else:
            alone = "each view is tracked by itself, and " if len(views.names) > 1 else ""
            report.doubts.append(f"no calibration: {alone}positions will be in px")
    file = trial.start_file()
    if file is None:
        report.faults.append(
            "no start points: click them with pawnb.widgets.ClickInitialiser, or name a csv "
            "under [start] points."
        )
        return
    sizes = {name: (r.width, r.height) for name, r in views.readers.items()}
    try:
        clicks = read_start(trial.path(file), trial)
        check_start(clicks, trial, sizes)
        frames = frame_range(trial, views, clicks)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    clicked = sorted(set(clicks["frame"]))
    report.found.append(
        f"start: {len(clicks)} clicks on {', '.join(dict.fromkeys(clicks['point']))} in "
        f"frame{'s' if len(clicked) > 1 else ''} {', '.join(map(str, clicked))}"
    )
    _check_predictions(trial, views, clicks, frames, report)
    if not report.faults and (rig is not None or len(views.names) == 1):
        _doubt_colours(trial, views, rig, clicks, report)
    if rig is None:
        return
    for (frame, point), group in clicks.groupby(["frame", "point"], sort=True):
        uv = np.full((len(rig.names), 2), np.nan)
        for row in group.itertuples():
            uv[rig.names.index(str(row.view))] = row.u, row.v
        residual = float(rig.triangulate(uv).residual_px)
        if residual > MAX_CLICK_RESIDUAL_PX:
            report.doubts.append(
                f"start clicks of {point} in frame {frame} disagree between the views by "
                f"{residual:.0f} px: one of them is on another point, or the calibration is off"
            )


def _check_predictions(
    trial: Trial,
    views: ViewSet,
    clicks: pd.DataFrame,
    frames: tuple[int, int],
    report: CheckReport,
) -> None:
    """Read other programs' predictions as tracking will, and doubt those far from the clicks."""
    tracked = points_by_view(trial, clicks)
    points = tuple(dict.fromkeys(point for own in tracked.values() for point in own))
    try:
        predictions = read_predictions(trial, views, points=points, frames=frames)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    for view, own in predictions.items():
        share = np.isfinite(own.uv[..., 0]).mean()
        report.found.append(
            f"predictions of view {view} in {own.file}: {', '.join(own.points)}, there in "
            f"{100 * share:.0f} % of frames"
        )
    said = doubt_predictions(predictions, clicks, views=views, first=frames[0])
    report.doubts += [words.rstrip(".") for words in said]


def _doubt_colours(
    trial: Trial, views: ViewSet, rig: Rig | None, clicks: pd.DataFrame, report: CheckReport
) -> None:
    """Doubt clicked paws that look like what is around them."""
    frames = int(clicks["frame"].min()), int(clicks["frame"].max()) + 1
    task = paw_task(trial, rig, clicks, frames=frames)
    settings = tracker_settings(trial)
    assert isinstance(settings, OfflineSettings)  # noqa: S101  those of the default method
    try:
        words = warn_of_ambiguous_colour(views, clicks, task, settings=settings)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    if words is not None:
        report.doubts.append(words.rstrip("."))


_CHECK_START: dict[str, Callable[[Trial, ViewSet, CheckReport], None]] = {
    "paws": _check_calibration,
    "pose": check_pose_trial,
}
"""What is checked of the start of a trial of each kind, and of what it needs."""
