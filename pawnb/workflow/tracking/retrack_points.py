"""Points tracked again about a frame in which a person corrected them."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.core.paws.maghsoudi2019.settings import REFERENCE_WIDTH_PX
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.quality.likeness import keep_likeness
from pawnb.core.paws.offline.reuse.kept_evidence import GONE_ON_FROM
from pawnb.core.paws.offline.reuse.retracking import after_correction
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.tracker import BY_LEARNT
from pawnb.core.paws.retracked_span import TOLERANCE_PX, keep_untouched
from pawnb.core.paws.tracker import AnyTracker, Correction, KeptEvidence
from pawnb.core.video import ViewSet
from pawnb.core.video.doubts.frozen_labels import without_frozen
from pawnb.core.video.doubts.repeated import freezes_of_views
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, START_COLUMNS, Tracks, add_provenance
from pawnb.trial import Trial
from pawnb.workflow.calibration.real_units import in_real_units
from pawnb.workflow.provenance.manifest import run_alone
from pawnb.workflow.provenance.record import build_step, trial_checksums
from pawnb.workflow.provenance.results import describe_trial, provenance_steps, results_folder
from pawnb.workflow.tracking.kept_candidates import (
    describe_source,
    keep_store,
    reopen_store,
    session_stacks,
)
from pawnb.workflow.tracking.methods import (
    by_dotted_name,
    method_of_tracks,
    stage_parameters_of_tracks,
)
from pawnb.workflow.tracking.opened_run import opened_run
from pawnb.workflow.tracking.options import RetrackOptions
from pawnb.workflow.tracking.placed import clicks_by_hand, clicks_learnt_from, clicks_of_frame
from pawnb.workflow.tracking.point_tracker import point_trackers
from pawnb.workflow.tracking.predicted import predictions_for
from pawnb.workflow.tracking.trial_views import paw_task, shown_in_every_view, trial_rig


def retrack_points(trial: Trial, tracks: Tracks, frame: int, *, asked: RetrackOptions) -> Tracks:
    """Track the points of a trial of kind ``paws`` again, from a corrected frame on.

    Parameters
    ----------
    trial : Trial
        The trial of these tracks.
    tracks : xarray.Dataset
        Tracks with the corrections already applied.
    frame : int
        The corrected frame.
    asked : RetrackOptions
        What :func:`pawnb.retrack` was asked for.

    Returns
    -------
    xarray.Dataset
        Tracks of the same frames.

    Raises
    ------
    InputError
        If the frame is not among those of the tracks.
    """
    known = _known_frames(tracks, frame)
    tracker, settings = _method_that_found(trial, tracks)
    placed = corrected_points(tracks, frame)
    learnt = _frames_learnt_in(tracks) | (dict.fromkeys(placed, frame) if asked.learn else {})
    own = stage_parameters_of_tracks(trial, tracks)
    with contextlib.ExitStack() as stack:
        run = stack.enter_context(
            opened_run(
                trial, tracker, parameters=own, progress=asked.progress, label="tracking again",
                then="deciding" if tracker.is_offline else "",
            )
        )  # fmt: skip
        views = run.views
        rig = trial_rig(trial, views, method=tracker.name)
        looked = clicks_learnt_from(tracks) if tracker.is_offline else None
        joint = looked is not None
        clicks = clicks_by_hand(trial, tracks) if joint else clicks_of_frame(trial, tracks, frame)
        given: dict[str, Any] = {}
        if looked is not None and tracks.attrs.get("evidence") == BY_LEARNT:
            framed_by = _first_clicks(tracks, looked)
            given = _learnt_again(trial, tracks, frame, placed) | {"annotations": framed_by}
        elif looked is not None and not asked.learn:
            store = _kept_detections(trial, asked.out, stack)
            given = {"annotations": looked, "kept": KeptEvidence(store)}
        span = (int(known[0] if joint else frame), int(known[-1]) + 1)
        others = _evidence_of_others(trial, views, clicks, span, asked, tracker=tracker)
        task = paw_task(
            trial, rig, clicks, frames=span, tracks=None if joint else tracks,
            progress=run.report, stop=asked.stop, **others,
        )  # fmt: skip
        corrected = Correction(learnt, **given)
        new = tracker.retrack(views, clicks, task, settings=settings, corrected=corrected)
        freezes = freezes_of_views(trial, views, start=span[0], stop=span[1])
        tolerance = {name: _tolerance_px(reader.width) for name, reader in views.readers.items()}
    # an animal that was renamed in trial.toml is still that of these tracks
    new = in_real_units(without_frozen(new, freezes), trial, units="px").assign_coords(
        individual=tracks["individual"]
    )
    if joint and new.sizes["time"] < known[-1] + 1 - known[0]:
        return tracks  # stopped: a part of the recording does not decide over the whole
    new = new.isel(time=np.isin(new["frame"], known))
    new = keep_untouched(tracks, new, frame, tolerance_px=tolerance, joint=joint)
    if not tracker.is_offline:
        new = shown_in_every_view(new, rig, run.sizes)
    new = keep_likeness(tracks, new.assign_attrs(tracks.attrs))
    new = describe_trial(new.assign_coords(time=tracks["time"]), trial)
    return _with_step(
        new, trial, settings=dataclasses.asdict(settings) | by_dotted_name(own), frame=int(frame),
        points=placed, learn=asked.learn, start=clicks.to_dict(orient="records"),
    )  # fmt: skip


def _evidence_of_others(
    trial: Trial,
    views: ViewSet,
    clicks: pd.DataFrame,
    span: tuple[int, int],
    asked: RetrackOptions,
    *,
    tracker: AnyTracker,
) -> dict[str, Any]:
    """Return what other programs predict, and further kinds of evidence."""
    if not tracker.is_offline:
        return {}
    return {
        "predictions": predictions_for(trial, views, clicks, frames=span),
        "evidence": point_trackers(trial, asked.stop),
    }


def _kept_detections(
    trial: Trial, out: str | Path | None, stack: contextlib.ExitStack
) -> DetectionCache:
    """Return the detections that a run has kept; what is found now goes there, too."""
    folder = results_folder(trial, out)
    if folder.is_dir():  # a run there would write the same candidates
        stack.enter_context(run_alone(folder))
    store = reopen_store(trial, folder)
    stack.callback(keep_store, store)
    return store


def _with_step(new: Tracks, trial: Trial, **said: Any) -> Tracks:
    """Return tracks that say how they were tracked again."""
    inputs = trial_checksums(trial, start=False)
    return add_provenance(new, **build_step("retrack", command=None, inputs=inputs, **said))


def _known_frames(tracks: Tracks, frame: int) -> IntArray:
    """Return the tracked frames, of which a corrected one must be."""
    known = np.asarray(tracks["frame"].to_numpy())
    if frame not in known:
        raise InputError(
            f"frame {frame} is not among the tracked frames {known[0]} to {known[-1]}."
        )
    return known


def _method_that_found(trial: Trial, tracks: Tracks) -> tuple[AnyTracker, Any]:
    """Return the tracker and the settings that found tracks: they find them again."""
    tracker, settings = method_of_tracks(trial, tracks)
    if isinstance(settings, OfflineSettings) and "evidence" in tracks.attrs:
        settings = dataclasses.replace(settings, evidence=tracks.attrs["evidence"])
    return tracker, settings


def _tolerance_px(width: int) -> float:
    """Return how far a place may differ from the old one in a picture so wide."""
    return TOLERANCE_PX * width / REFERENCE_WIDTH_PX


def _first_clicks(tracks: Tracks, looked: pd.DataFrame) -> pd.DataFrame:
    """Return the clicks by which the body's frame was found: of the run first gone on from."""
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    earlier = made[-1].get(GONE_ON_FROM)
    return pd.DataFrame(earlier[0], columns=list(START_COLUMNS)) if earlier else looked


def _learnt_again(
    trial: Trial, tracks: Tracks, frame: int, placed: Sequence[str]
) -> dict[str, Any]:
    """Return what is kept for tracks by learnt evidence, and in which frames they are made anew."""
    stacks = session_stacks(describe_source(trial))
    given: dict[str, Any] = {"kept": KeptEvidence(stacks=stacks)}
    if placed:
        given["again"] = after_correction(tracks, int(frame), placed)
    return given


def corrected_points(tracks: Tracks, frame: int) -> list[str]:
    """Return the points that were put in place by hand in a frame, in any view."""
    here = tracks.isel(time=tracks["frame"].to_numpy() == frame)
    placed = (here["image_origin"] == ORIGIN_CODE["edited"]).any(("time", "view", "individual"))
    return [str(point) for point in here["keypoint"].to_numpy()[placed.to_numpy()]]


def _frames_learnt_in(tracks: Tracks) -> dict[str, int]:
    """Return the frame in which colours of points were last learnt anew."""
    steps = [step for step in provenance_steps(tracks) if step["step"] == "retrack"]
    return {point: step["frame"] for step in steps if step.get("learn") for point in step["points"]}
