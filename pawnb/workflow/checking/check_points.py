"""What ``pawnb check`` says of points: calibration, start clicks, predictions, colours."""

from __future__ import annotations

import numpy as np
import pandas as pd

from pawnb.core.calibration.doubts import tell_mirrored
from pawnb.core.dlt import handedness
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import warn_of_ambiguous_colour
from pawnb.core.rig import Rig
from pawnb.core.video import ViewSet
from pawnb.core.video.doubts.exchanged_films import film_codes, tell_other_films
from pawnb.errors import PawnbError
from pawnb.io.lengths import MM_PER_UNIT
from pawnb.io.start import check_start, clicked_films, read_start
from pawnb.trial import Calibration, Trial
from pawnb.workflow.calibration.moved_cameras import tell_moved_clicks
from pawnb.workflow.checking.check_report import CheckReport
from pawnb.workflow.start.exchanged_clicks import (
    solve_clicks,
    tell_disagreeing_clicks,
    tell_exchanged_clicks,
    tell_one_place,
)
from pawnb.workflow.start.turned_axes import tell_turned_axes
from pawnb.workflow.tracking.methods import tracker_settings
from pawnb.workflow.tracking.point_tracker import point_trackers
from pawnb.workflow.tracking.predicted import doubt_predictions, predictions_for
from pawnb.workflow.tracking.trial_views import frame_range, paw_task, trial_rig

LEAST_APART_MM, MOST_APART_MM = 0.1, 1e4
"""Points on one animal lie so far apart (by hand: a mite, a whale)."""


def check_points_trial(trial: Trial, views: ViewSet, report: CheckReport) -> None:
    """Add to a report what concerns points: the calibration, and the start clicks against it.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``paws``.
    views : ViewSet
        Its open views.
    report : CheckReport
        The report.
    """
    try:
        rig = trial_rig(trial, views)
    except PawnbError as error:
        report.faults.append(str(error))
        rig = None
    else:
        if rig is not None:
            report.found.append(f"DLT of {len(rig.names)} views, unit {rig.unit}")
        elif trial.calibration is not None and trial.calibration.px_per_unit is not None:
            _say_scale(trial.calibration, views, report)
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
    report.doubts += tell_one_place(clicks)
    if films := clicked_films(trial.path(file)):
        report.doubts += tell_other_films(film_codes(views.readers), films)
    _check_predictions(trial, views, clicks, frames, report)
    if not report.faults and (rig is not None or len(views.names) == 1):
        _doubt_colours(trial, views, rig, clicks, report)
    if rig is not None:
        _check_against_rig(trial, rig, clicks, report)
    elif trial.calibration is not None and trial.calibration.px_per_unit is not None:
        own = clicks[clicks["frame"] == clicks["frame"].iloc[0]]
        places = own[["u", "v"]].to_numpy(float) / trial.calibration.px_per_unit
        _doubt_unit(trial.calibration.unit, places, report)


def _check_against_rig(trial: Trial, rig: Rig, clicks: pd.DataFrame, report: CheckReport) -> None:
    """Doubt clicks that disagree between views, and a rig that shows their points mirrored."""
    solved = solve_clicks(rig, clicks)
    report.doubts += tell_disagreeing_clicks(solved)
    report.doubts += tell_exchanged_clicks(rig, clicks)
    report.doubts += tell_moved_clicks(clicks, rig)
    places = [place.xyz for place in solved.values()]
    xyz = np.array([place for place in places if np.isfinite(place).all()]).reshape(-1, 3)
    if len(xyz) > 1:
        # a view that is turned over by mirror = true shows either, by what was calibrated
        turned = [trial.view(name).mirror for name in rig.names]
        signs = np.where(turned, 0, handedness(rig.coefs, xyz))
        report.doubts += tell_mirrored(rig.names, signs)
    _doubt_unit(rig.unit, xyz, report)
    report.doubts += tell_turned_axes(rig, clicks)


def _say_scale(calibration: Calibration, views: ViewSet, report: CheckReport) -> None:
    """Say how large the pictures are in real units: a scale the wrong way round is seen by it."""
    assert calibration.px_per_unit is not None  # noqa: S101  asked for with a scale only
    reader = views.readers[views.names[0]]
    sides = [side / calibration.px_per_unit for side in (reader.width, reader.height)]
    report.found.append(
        f"scale: {calibration.px_per_unit:g} px per {calibration.unit}, so that view "
        f"{views.names[0]} is {sides[0]:.3g} x {sides[1]:.3g} {calibration.unit} large"
    )


def _doubt_unit(unit: str, places: np.ndarray, report: CheckReport) -> None:
    """Doubt a unit in which clicked points (n, 2 or 3) lie closer or wider than on any animal."""
    if unit not in MM_PER_UNIT or len(places) < 2:
        return
    apart = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not LEAST_APART_MM <= apart * MM_PER_UNIT[unit] <= MOST_APART_MM:
        report.doubts.append(
            f"the clicked points lie {apart:.3g} {unit} apart: [calibration] unit is not that "
            "of the calibration (some programs count in metres), or its scale is wrong"
        )


def _check_predictions(
    trial: Trial,
    views: ViewSet,
    clicks: pd.DataFrame,
    frames: tuple[int, int],
    report: CheckReport,
) -> None:
    """Read what a trial names as evidence as tracking will; doubt predictions far from clicks."""
    try:
        point_trackers(trial)
        predictions = predictions_for(trial, views, clicks, frames=frames)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    if trial.point_tracker is not None:
        report.found.append(f"point tracker: {trial.point_tracker}")
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
