"""Tracking points through a whole recording at once: from clicks to Tracks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import (
    Placement,
    Views,
)
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.scan import scan_video
from pawnb.core.paws.offline.landmarks.backward_tracking import frames_back, track_backwards
from pawnb.core.paws.offline.landmarks.template_tracking import TemplateTracker
from pawnb.core.paws.offline.landmarks.tracks import check_landmarks, choose_landmarks, join_views
from pawnb.core.paws.offline.scene.treadmill import Scene, move_anchors, read_scene
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.treadmill.annotated import Annotated, read_request_and_annotations
from pawnb.core.paws.offline.treadmill.annotations import (
    annotated_points,
    annotated_positions,
    placed_points,
)
from pawnb.core.paws.offline.treadmill.output import as_tracks, empty_result
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.core.paws.offline.treadmill.pipeline import run_pipeline
from pawnb.core.paws.offline.treadmill.recording import Recording, ReferenceAnnotations
from pawnb.core.paws.request import TrackingRequest
from pawnb.errors import InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.schema import Tracks


def track_treadmill(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: OfflineSettings,
    looked: pd.DataFrame | None = None,
    store: DetectionCache | None = None,
) -> Tracks:
    """Track points by deciding over the whole recording.

    One pass over the video keeps only detections: the ends of parts that have the colour
    of the clicked paws. Detections of two views that meet make places in space; places
    that follow each other without doubt make tracklets; which tracklets belong to which
    point is decided for all points and all frames at once, with gaps where a point is
    occluded; then every view's detections are taken in again and the tracks are smoothed.
    Points that are no paws (:func:`choose_landmarks`) are followed by their own picture.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px); one frame or more, anywhere in the
        recording: points are tracked before their first click as they are after it.
    task : TrackingRequest
        What is to be tracked: all of its frames. Without a rig there must be one view. With
        tracks to go on from, positions in the first frame, and positions placed by hand in it
        or later, are certain.
    settings : OfflineSettings
        The settings.
    looked : DataFrame, optional
        Earlier clicks, columns as ``start``, that say what paws look like, where on a paw
        its point is and how large the animal is: where tracks are gone on from, those that
        they were begun with. Detections are then the same as theirs.
    store : DetectionCache, optional
        Where detections are kept: frames found there are not decoded again.

    Returns
    -------
    xarray.Dataset
        Tracks; without any frame where the run was stopped before each point was placed.
        ``position`` is smoothed and ``image_position`` is its projection into every view, also
        those that do not track the point; at clicks it is the click.
        ``image_origin`` is ``measured`` where a detection of that view was used,
        ``reprojected`` where only others saw the point, ``predicted`` where none did.
        ``origin`` is ``measured`` with two views or more (one without a rig), ``resolved``
        with one, else ``predicted``. ``image_confidence`` says how much the detection looks
        like the end of a paw, 0 to 1, ``image_residual`` how far it is from the projection,
        px, NaN where there was none, and ``image_offset`` in which direction; ``sd`` is the
        standard deviation of ``position``, and
        ``displacement_from_first_pass`` how far it is from where the point was before its stride
        was known (NaN where no stride is learnt). ``image_separation`` says how far the detection
        taken is ahead of the best other one in that view and frame, as the logarithm of the odds:
        near 0 nothing tells them apart, below 0 the other fits better by itself, 30 where there is
        no other. ``passes_apart`` says how far what was seen before a frame and what is seen after
        it expect the point apart (a filter forwards and one backwards), in standard deviations of
        that distance.

    Raises
    ------
    InputError
        If a click does not fit the views, points or frames, or a point has no click, or
        there are several views and no rig, or a landmark was clicked in one of several views.
    CalibrationError
        If the rig lacks a view.
    """
    asked = read_request_and_annotations(views, start, task, looked=looked)
    layout = asked.layout
    marks = choose_landmarks(layout.points, layout.kinds, settings.landmarks)
    scene = follower = None
    if not marks.all():
        scene = scene_of_paws(views, asked.of(~marks), settings)
        if not asked.is_looked and (words := _ambiguous(scene, views.names)) is not None:
            warn_of_input(words, InputWarning, stacklevel=2)
    if marks.any():
        marked = asked.of(marks)
        check_landmarks(marked.layout, marked.anchors)
        follower = TemplateTracker(marked.layout, marked.anchors)
    span = (asked.begin, task.frames[1])
    seen = scan_and_follow(
        views, span, scene, follower=follower, anchors=asked.anchors, store=store, task=task
    )
    n = max(asked.begin + len(seen) - task.frames[0], 0)
    result = empty_result(n, layout)
    if n and scene is not None:
        paws = solve(seen, scene, asked.of(~marks), task=task, settings=settings)
        paws = paws.within(TREADMILL.tracker_beyond * scene.body_scale)
        result = result.with_points(~marks, paws)
    if n and follower is not None:
        followed = join_landmarks(follower, asked.of(marks), n, task=task, settings=settings)
        result = result.with_points(marks, followed)
    return as_tracks(result, layout, task, placed=asked.inside(n))


def scene_of_paws(
    views: Views, asked: Annotated, settings: OfflineSettings, *, least_paw_width: float = 0.0
) -> Scene:
    """Return what the clicks on paws say; ``least_paw_width`` as for :func:`.read_scene`.

    Parameters
    ----------
    views : Views
        The opened views.
    asked : Annotated
        What a person gave.
    settings : OfflineSettings
        The settings.
    least_paw_width : float
        Least thickness of a paw; see :func:`.read_scene`.

    Returns
    -------
    Scene
        Views and animal.
    """
    layout, clicks, anchors = asked.layout, asked.clicks, asked.anchors
    scene = read_scene(
        views, layout, clicks, anchors=clicks if asked.is_looked else anchors, settings=settings,
        least_paw_width=least_paw_width,
    )  # fmt: skip
    return move_anchors(scene, layout, anchors) if asked.is_looked else scene


def warn_of_ambiguous_colour(
    views: Views, start: pd.DataFrame, task: TrackingRequest, *, settings: OfflineSettings
) -> str | None:
    """Return what a person should know of the clicked paws before they are tracked.

    Parameters
    ----------
    views, start, task, settings
        As for :func:`track_treadmill`; only the clicked frames are looked at.

    Returns
    -------
    str or None
        A sentence; None where there is nothing to say.

    Raises
    ------
    InputError
        If a click does not fit.
    """
    asked = read_request_and_annotations(views, start, task)
    paws = asked.of(~choose_landmarks(asked.layout.points, asked.layout.kinds, settings.landmarks))
    if not paws.layout.points:
        return None
    scene = read_scene(views, paws.layout, paws.clicks, anchors=paws.anchors, settings=settings)
    return _ambiguous(scene, views.names)


def _ambiguous(scene: Scene, names: Sequence[str]) -> str | None:
    """Return a sentence where paws look like what is around them."""
    alike = {
        name: detector.appearance.mistaken
        for name, detector in zip(names, scene.detectors, strict=True)
        if detector.appearance.mistaken > TREADMILL.tracker_mistaken
    }
    if not alike:
        return None
    return (
        f"in {', '.join(alike)} the clicked paws hardly differ from what is around the animal: "
        f"{max(alike.values()):.0%} of it has their colour (usually under 3 %), and the tracks "
        "will be poor. Look whether every click is on a paw; else another light, a belt of "
        "another colour or painted paws help."
    )


def scan_and_follow(
    views: Views,
    frames: tuple[int, int],
    scene: Scene | None,
    *,
    follower: TemplateTracker | None,
    anchors: Mapping[int, Sequence[Placement]],
    store: DetectionCache | None,
    task: TrackingRequest,
) -> list[list[ColourDetections]]:
    """Go through the video for paws and landmarks; return the paws' detections.

    There are none if it was stopped before every point was reached: nothing can be decided.

    Parameters
    ----------
    views : Views
        The opened views.
    frames : tuple of int
        First frame and one past the last.
    scene : Scene or None
        Paws; None for landmarks only.
    follower : TemplateTracker or None
        Landmarks; None for paws only.
    anchors : mapping
        Frame to what is certain there.
    store : DetectionCache or None
        Where detections are kept.
    task : TrackingRequest
        Whom progress is reported to.

    Returns
    -------
    list of list of ColourDetections
        For each frame, the detections of each view.
    """
    found = _scan_forwards(views, frames, scene, follower, store, task)
    inside = {t: here for t, here in anchors.items() if t < frames[0] + len(found)}
    if placed_points(inside) != placed_points(anchors):
        return []
    if follower is not None and not track_backwards(
        views, follower, frames[0], progress=task.progress, stop=task.stop
    ):
        return []
    return found


def _scan_forwards(
    views: Views,
    frames: tuple[int, int],
    scene: Scene | None,
    follower: TemplateTracker | None,
    store: DetectionCache | None,
    task: TrackingRequest,
) -> list[list[ColourDetections]]:
    """Go through the video once, forwards; return the paws' detections of every frame."""
    progress, total = task.progress, frames[1] - frames[0]
    if follower is not None:
        total += frames_back(follower.placed, frames[0])
    report = None if progress is None else lambda done: progress(done, total)
    watch = None if follower is None else follower.step
    if scene is not None:
        return scan_video(
            views, frames, detectors=scene.detectors, rois=scene.rois, home=scene.home,
            store=store, watch=watch, progress=report, stop=task.stop,
        )  # fmt: skip
    found: list[list[ColourDetections]] = []
    for i, pictures in views.frames(*frames, partly=True):
        if task.stop is not None and task.stop():
            break
        if watch is not None:
            watch(i, pictures)
        found.append([])
        if report is not None:
            report(len(found))
    return found


def solve(
    seen: list[list[ColourDetections]],
    scene: Scene,
    asked: Annotated,
    *,
    task: TrackingRequest,
    settings: OfflineSettings,
) -> SmoothedTracks:
    """Track the paws through the detections, ``seen`` from the frame ``asked.begin`` on.

    Parameters
    ----------
    seen : list of list of ColourDetections
        For each frame, the detections of each view.
    scene : Scene
        Views and animal.
    asked : Annotated
        What a person gave.
    task : TrackingRequest
        What is to be tracked.
    settings : OfflineSettings
        The settings.

    Returns
    -------
    SmoothedTracks
        The paws.
    """
    found = seen[asked.first - asked.begin :]
    n = len(found)
    anchors = {t - asked.first: here for t, here in scene.anchors.items() if t - asked.first < n}
    certain = annotated_positions(asked.inside(n), n, asked.layout)
    return run_pipeline(
        Recording(
            found, anchors, certain, _reference_annotations(seen, certain, asked), scene,
            asked.layout, task.fps, settings,
        )
    )  # fmt: skip


def _reference_annotations(
    seen: list[list[ColourDetections]], certain: FloatArray, asked: Annotated
) -> ReferenceAnnotations:
    """Return the clicks that say where on a paw its point is, with what was seen there.

    Those of an earlier run alone say it, as they did then: a correction puts the paw in place in
    its frame, and a hand that was a pixel off there moves the track nowhere else.
    """
    begin = asked.begin
    if not asked.is_looked:
        clicked = np.flatnonzero(np.isfinite(certain[..., 0]).any(axis=(1, 2))).tolist()
        skip = asked.first - begin
        return ReferenceAnnotations(certain[clicked], {t: seen[skip + t] for t in clicked})
    clicks = asked.clicks
    here = {t - begin: clicks[t] for t in sorted(clicks) if t - begin < len(seen)}
    placed = annotated_positions(here, len(seen), asked.layout)
    return ReferenceAnnotations(placed[list(here)], {t: seen[t] for t in here})


def join_landmarks(
    follower: TemplateTracker,
    asked: Annotated,
    n: int,
    *,
    task: TrackingRequest,
    settings: OfflineSettings,
) -> SmoothedTracks:
    """Return the landmarks' tracks in the n frames asked for, from what each view shows.

    Parameters
    ----------
    follower : TemplateTracker
        What has followed them.
    asked : Annotated
        What a person gave.
    n : int
        Frames.
    task : TrackingRequest
        What is to be tracked.
    settings : OfflineSettings
        The settings.

    Returns
    -------
    SmoothedTracks
        The landmarks.
    """
    skip = asked.first - asked.begin
    uv, likeness = (
        np.swapaxes(np.array(values[skip : skip + n]), 1, 2)
        for values in (follower.uv, follower.likeness)
    )
    return join_views(
        uv,
        likeness,
        layout=asked.layout,
        fps=task.fps,
        by_hand=annotated_points(asked.inside(n), likeness.shape),
        max_occlusion_s=settings.max_occlusion_s,
    )
