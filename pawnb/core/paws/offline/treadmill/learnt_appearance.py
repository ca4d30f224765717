"""Paws tracked by strides and stance, their appearance learnt twice: the second from the first.

Which detections belong to which paw is decided as where colour tells them
(:mod:`.offline.treadmill`): detections of calibrated views meet in space, tracklets are
chosen for all paws and frames at once, and gaps are bridged by what strides and stance tell. Only
where paws may be is found otherwise: by :mod:`.detection.paw_appearance`.
"""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np
import pandas as pd

from pawnb.core.parameters import changed_in_force, values_in_force
from pawnb.core.paws.layout import Views
from pawnb.core.paws.offline.annotations import annotations_of_view
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections, InFrames
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.detection.paw_appearance import (
    clicked_training_frames,
    tracked_training_frames,
    with_paw_looks,
)
from pawnb.core.paws.offline.detection.predictions import judge_predictions
from pawnb.core.paws.offline.landmarks.template_tracking import TemplateTracker
from pawnb.core.paws.offline.landmarks.tracks import check_landmarks, choose_landmarks
from pawnb.core.paws.offline.parameters import APPEARANCE, AppearanceParameters
from pawnb.core.paws.offline.scene.treadmill import Scene, leading_view, move_anchors
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.annotated import Annotated, read_request_and_annotations
from pawnb.core.paws.offline.treadmill.output import as_tracks, empty_result
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.core.paws.offline.treadmill.tracker import (
    join_landmarks,
    scan_and_follow,
    scene_of_paws,
    solve,
)
from pawnb.core.paws.request import TrackingRequest
from pawnb.schema import Tracks


def strides_may_tell(
    views: Views, start: pd.DataFrame, task: TrackingRequest, *, settings: OfflineSettings
) -> bool:
    """Tell whether paws can be tracked so: front and hind ones, in calibrated views.

    Parameters
    ----------
    views, start, task, settings
        As for :func:`track_by_strides`.

    Returns
    -------
    bool
        Whether they can.

    Raises
    ------
    InputError
        If a click does not fit.
    """
    if task.rig is None or len(views.names) < 2:
        return False
    asked = read_request_and_annotations(views, start, task)
    marks = choose_landmarks(asked.layout.points, asked.layout.kinds, settings.landmarks)
    paws = asked.of(~marks)
    kinds = set(paws.layout.kinds)
    return kinds == {"front", "hind"}


def is_seen_from_below(views: Views, start: pd.DataFrame, task: TrackingRequest) -> bool:
    """Tell whether a calibrated view from below leads: it shows all paws.

    Parameters
    ----------
    views, start, task
        As for :func:`track_by_strides`.

    Returns
    -------
    bool
        Whether there is one.

    Raises
    ------
    InputError
        If a click does not fit.
    """
    asked = read_request_and_annotations(views, start, task)
    return leading_view(asked.layout, asked.anchors) is not None


def track_by_strides(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None = None,
    store: DetectionCache | None = None,
    parameters: AppearanceParameters | None = None,
) -> Tracks:
    """Track paws whose look is learnt from the clicks, then from the tracks that this gives.

    Where tracks are gone on from, it is what they were found by: learnt from the clicks of that
    run, which a session that has done so does not do again. Corrections are certain as ever.

    Parameters
    ----------
    views, start, task, settings, looked, store
        As for :func:`.tracker.track_treadmill`; predictions of the task are places where
        paws may be, whichever they are.
    parameters : AppearanceParameters, optional
        Of the classifier.

    Returns
    -------
    xarray.Dataset
        Tracks as those of :func:`.tracker.track_treadmill`; none where it was stopped.

    Raises
    ------
    InputError
        If a click does not fit, or a point has none.
    CalibrationError
        If the rig lacks a view.
    """
    parameters = parameters or values_in_force(APPEARANCE)
    asked = read_request_and_annotations(views, start, task, looked=looked)
    layout, span = asked.layout, (asked.begin, task.frames[1])
    marks = choose_landmarks(layout.points, layout.kinds, settings.landmarks)
    paws, follower = asked.of(~marks), None
    if marks.any():
        marked = asked.of(marks)
        check_landmarks(marked.layout, marked.anchors)
        follower = TemplateTracker(marked.layout, marked.anchors)
    store = store or DetectionCache()
    learnt_from = _learnt_from(paws, task, settings, parameters)
    scene = store.recall(learnt_from)
    if scene is None:
        scene = _learn_scene(views, _as_begun(paws), task, settings, parameters)
    seen: list[list[ColourDetections]] = []
    if scene is not None:
        seen = scan_and_follow(
            views, span, scene, follower=follower, anchors=asked.anchors, store=store,
            task=_part(task, TREADMILL.learnt_appearance_rounds - 1),
        )  # fmt: skip
    if scene is None or len(seen) < span[1] - span[0]:
        # stopped: a part does not decide over the whole
        return as_tracks(empty_result(0, layout), layout, task, placed={})
    store.remember(learnt_from, scene)
    if asked.is_looked:
        scene = move_anchors(scene, paws.layout, paws.anchors)
    seen = _with_predictions(seen, scene, paws, task)
    refined = solve(seen, scene, paws, task=task, settings=settings)
    refined = refined.within(TREADMILL.tracker_beyond * scene.body_scale)
    n = task.frames[1] - task.frames[0]
    result = empty_result(n, layout).with_points(~marks, refined)
    if follower is not None:
        followed = join_landmarks(follower, asked.of(marks), n, task=task, settings=settings)
        result = result.with_points(marks, followed)
    return as_tracks(result, layout, task, placed=asked.inside(n))


def _as_begun(asked: Annotated) -> Annotated:
    """Return what a person gave an earlier run; where there was none, what was given now."""
    if not asked.is_looked:
        return asked
    return dataclasses.replace(asked, anchors=asked.clicks, is_looked=False)


def _learn_scene(
    views: Views,
    asked: Annotated,
    task: TrackingRequest,
    settings: OfflineSettings,
    parameters: AppearanceParameters,
) -> Scene | None:
    """Return a scene with looks that are learnt round by round; None where it was stopped."""
    base = scene_of_paws(views, asked, settings, least_paw_width=LEARNT.least_thickness)
    placed = {**asked.anchors, **asked.clicks}
    inside = {t: here for t, here in placed.items() if t < task.frames[1]}
    training_frames = told = clicked_training_frames(base, asked.layout, inside)
    span = (asked.begin, task.frames[1])
    for round_ in range(TREADMILL.learnt_appearance_rounds - 1):
        scene = with_paw_looks(
            views, asked.layout, base, training_frames=training_frames, parameters=parameters
        )
        seen = scan_and_follow(
            views, span, scene, follower=None, anchors=asked.anchors, store=None,
            task=_part(task, round_),
        )  # fmt: skip
        if len(seen) < span[1] - span[0]:
            return None
        seen = _with_predictions(seen, scene, asked, task)
        refined = solve(seen, scene, asked, task=task, settings=settings)
        tracked = tracked_training_frames(
            refined, scene, asked.layout.tracked, first=task.frames[0]
        )
        training_frames = told | {
            t: training_frame for t, training_frame in tracked.items() if t not in told
        }
    return with_paw_looks(
        views, asked.layout, base, training_frames=training_frames, parameters=parameters
    )


def _learnt_from(
    asked: Annotated,
    task: TrackingRequest,
    settings: OfflineSettings,
    parameters: AppearanceParameters,
) -> str:
    """Return a checksum of all that looks are learnt from, beside the video."""
    points = asked.layout.points
    clicks = sorted(
        (t, one.view, one.point, *map(float, one.uv))
        for t, here in asked.clicks.items()
        for one in here
    )
    rig = None if task.rig is None else task.rig.coefs.tobytes()
    said = [clicks, points, asked.layout.views, asked.begin, task.frames, task.fps, rig]
    how = [dataclasses.replace(settings, evidence="auto"), parameters, changed_in_force()]
    digest = hashlib.sha256(repr([said, how]).encode())
    for name, predicted in sorted(task.predictions.items()):
        digest.update(name.encode())
        for values in predicted.of(points):
            digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()


def _part(task: TrackingRequest, round_: int) -> TrackingRequest:
    """Return the task with a report of progress that counts the rounds as one."""
    report = task.progress
    if report is None:
        return task

    def part(done: int, total: int) -> None:
        report((round_ * total + done) // TREADMILL.learnt_appearance_rounds, total)

    return dataclasses.replace(task, progress=part)


def _with_predictions(
    seen: InFrames, scene: Scene, paws: Annotated, task: TrackingRequest
) -> list[list[ColourDetections]]:
    """Return detections with places that another program predicts where none was seen."""
    found = [list(here) for here in seen]
    layout, first = paws.layout, task.frames[0]
    for v, name in enumerate(layout.views):
        if name not in task.predictions:
            continue
        uv, likelihood = task.predictions[name].of(layout.points)
        own = annotations_of_view(paws.anchors, v, first)
        right = judge_predictions(uv, likelihood, own, size=layout.sizes[v]).right
        for row in range(len(uv)):
            here = found[first - paws.begin + row]
            likely = TREADMILL.learnt_appearance_predicted * right[row]
            new = _as_detections(uv[row][likely > 0], likely[likely > 0], scene, v)
            here[v] = _joined(here[v], new, scene, v)
    return found


def _as_detections(uv: np.ndarray, likely: np.ndarray, scene: Scene, view: int) -> ColourDetections:
    """Return places as detections."""
    detector = scene.detectors[view]
    ahead = np.broadcast_to(
        np.asarray(detector.limb_direction) * detector.reach * detector.shrink, uv.shape
    )
    return ColourDetections.of(
        uv, direction=ahead, coverage=np.zeros(len(uv)), score=0.5 + 2.0 * likely, tip=uv
    )


def _joined(
    own: ColourDetections, new: ColourDetections, scene: Scene, view: int
) -> ColourDetections:
    """Return detections with those of ``new`` that are not within a paw width of one."""
    if not len(new):
        return own
    away = np.linalg.norm(new.uv[:, None] - own.uv, axis=-1)
    free = new.take((away > scene.paw_width_px[view]).all(axis=1))
    every = ColourDetections.joined([own, free])
    score = endpoint_score(every, scene.detectors[view].limb_direction)
    return every.take(np.argsort(-score, kind="stable"))
