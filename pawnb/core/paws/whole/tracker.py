"""Tracking points through a whole recording at once: from clicks to Tracks."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from pawnb.core.paws.layout import (
    Layout,
    Placement,
    Views,
    make_layout,
    only_points,
    read_start,
)
from pawnb.core.paws.settings import PaperSettings
from pawnb.core.paws.task import Task
from pawnb.core.paws.whole.decide import Told, decide
from pawnb.core.paws.whole.extract import extract
from pawnb.core.paws.whole.geometry import Geometry
from pawnb.core.paws.whole.landmark_tracks import check_landmarks, choose_landmarks, join_views
from pawnb.core.paws.whole.landmarks import Follower
from pawnb.core.paws.whole.landmarks_before import frames_back, look_back
from pawnb.core.paws.whole.placed import (
    certain_points,
    certain_positions,
    placed_points,
    read_placements,
)
from pawnb.core.paws.whole.refine import Refined
from pawnb.core.paws.whole.scene import Scene, move_anchors, read_scene
from pawnb.core.paws.whole.settings import WholeSettings
from pawnb.core.paws.whole.store import CandidateStore
from pawnb.errors import InputError, InputWarning
from pawnb.schema import ORIGIN_CODE, START_COLUMNS, Tracks, check_columns, make_tracks

_MISTAKEN = 0.1
"""Share of what is about the animal that passes for paws from which on a person is told: 0.2 to 3 %
in rendered scenes that are tracked, 23 % in one of a belt as brown as the paws, which is lost."""


def track_whole(
    views: Views,
    start: pd.DataFrame,
    task: Task,
    *,
    settings: WholeSettings,
    looked: pd.DataFrame | None = None,
    store: CandidateStore | None = None,
) -> Tracks:
    """Track points by deciding over the whole recording.

    One pass over the video keeps only candidates: the ends of parts that have the colour
    of the clicked paws. Candidates of two views that meet make places in space; places
    that follow each other without doubt make pieces of path; which pieces belong to which
    point is decided for all points and all frames at once, with gaps where a point is
    hidden; then every view's candidates are taken in again and the tracks are smoothed.
    Points that are no paws (:func:`choose_landmarks`) are followed by their own picture.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px); one frame or more, anywhere in the
        recording: points are tracked before their first click as they are after it.
    task : Task
        What is to be tracked: all of its frames. Without a rig there must be one view. With
        tracks to go on from, positions in the first frame, and positions placed by hand in it
        or later, are certain.
    settings : WholeSettings
        The settings.
    looked : DataFrame, optional
        Earlier clicks, columns as ``start``, that say what paws look like, where on a paw
        its point is and how large the animal is: where tracks are gone on from, those that
        they were begun with. Candidates are then the same as theirs.
    store : CandidateStore, optional
        Where candidates are kept: frames found there are not decoded again.

    Returns
    -------
    xarray.Dataset
        Tracks; without any frame where the run was stopped before each point was placed.
        ``position`` is smoothed and ``image_position`` is its projection into every view, also
        those that do not track the point; at clicks it is the click.
        ``image_origin`` is ``measured`` where a candidate of that view was used,
        ``reprojected`` where only others saw the point, ``predicted`` where none did.
        ``origin`` is ``measured`` with two views or more (one without a rig), ``resolved``
        with one, else ``predicted``. ``image_confidence`` says how much the candidate looks
        like the end of a paw, 0 to 1, ``image_residual`` how far it is from the projection,
        px, NaN where there was none; ``sd`` is the standard deviation of ``position``, and
        ``revision`` how far it is from where the point was before its stride was known (NaN
        where no stride is learnt).

    Raises
    ------
    InputError
        If a click does not fit the views, points or frames, or a point has no click, or
        there are several views and no rig, or a landmark was clicked in one of several views.
    CalibrationError
        If the rig lacks a view.
    """
    check_columns(start, START_COLUMNS, where="the start points")
    task.check_frames(views.n_frames)
    frames, tracks, rig = task.frames, task.tracks, task.rig
    if rig is None and len(views.names) > 1:
        raise InputError(
            f"{len(views.names)} views and no calibration; this method joins views in space: "
            "calibrate them, or keep one view."
        )
    layout = make_layout(views, start, task, settings=PaperSettings())
    clicks, anchors = read_placements(start, layout, frames, tracks=tracks)
    first = begin = frames[0]
    if looked is not None and len(looked):
        clicks = read_start(looked, layout, (0, frames[1]))
        begin = min(first, *clicks)
    marks = choose_landmarks(layout.points, layout.kinds, settings.landmarks)
    scene = follower = None
    if not marks.all():
        scene = _paws_scene(views, layout.only(~marks), settings,
                            *(only_points(one, ~marks) for one in (clicks, anchors)),
                            is_looked=looked is not None and len(looked) > 0)  # fmt: skip
    if marks.any():
        marked = only_points(anchors, marks)
        check_landmarks(layout.only(marks), marked)
        follower = Follower(layout.only(marks), marked)
    seen = _look_through(views, (begin, frames[1]), scene, follower, anchors, store, task)
    found = seen[first - begin :]
    rows = np.arange(frames[0], first + len(found))
    kept = np.empty(0, int)
    if tracks is not None:
        known = tracks["frame"].to_numpy()
        kept = known[(known < frames[0]) | (known >= first + len(found))]
        rows = np.sort(np.concatenate([kept, rows]))
    new = make_tracks(
        rows, layout.points, fps=task.fps, views=layout.views,
        space=("x", "y") if rig is None else ("x", "y", "z"), individual=task.individual,
        unit="px" if rig is None else task.unit,
    )  # fmt: skip
    new["sd"] = new["position"].copy()
    new["image_residual"] = xr.full_like(new["image_confidence"], np.nan).assign_attrs(units="px")
    new["revision"] = new["residual"].copy().assign_attrs(units=new["position"].attrs["units"])
    if found:
        row = int(np.searchsorted(rows, first))
        inside = {t - first: here for t, here in anchors.items() if t - first < len(found)}
        result = _empty_result(len(found), layout)
        if scene is not None:
            own = only_points(inside, ~marks)
            told = None
            if looked is not None and len(looked):
                told = _told(seen, layout.only(~marks), only_points(clicks, ~marks), begin)
            paws = _solve(
                found, scene, layout.only(~marks), own, first, task.fps, settings, told=told
            )
            result.take(~marks, paws)
        if follower is not None:
            uv, likeness = (
                np.swapaxes(np.array(values[first - begin :][: len(found)]), 1, 2)
                for values in (follower.uv, follower.likeness)
            )
            result.take(marks, join_views(
                uv, likeness, layout=layout.only(marks), fps=task.fps,
                by_hand=certain_points(only_points(inside, marks), likeness.shape),
                longest_gap_s=settings.longest_gap_s,
            ))  # fmt: skip
        _write(new, row, result, inside, layout)
    if tracks is not None:
        new = _keep_rows(tracks, new, kept)
    return new


def _paws_scene(
    views: Views,
    layout: Layout,
    settings: WholeSettings,
    clicks: Mapping[int, Sequence[Placement]],
    anchors: Mapping[int, Sequence[Placement]],
    *,
    is_looked: bool,
) -> Scene:
    """Return what the clicks on paws say; ``is_looked``: those of an earlier run."""
    if not is_looked:
        scene = read_scene(views, layout, clicks, anchors=anchors, settings=settings)
        _tell_mistaken(scene, views.names)
        return scene
    scene = read_scene(views, layout, clicks, anchors=clicks, settings=settings)
    return move_anchors(scene, layout, anchors)


def _tell_mistaken(scene: Scene, names: Sequence[str]) -> None:
    """Warn where paws look like what is around them."""
    alike = {
        name: look.appearance.mistaken
        for name, look in zip(names, scene.looks, strict=True)
        if look.appearance.mistaken > _MISTAKEN
    }
    if alike:
        warnings.warn(
            f"in {', '.join(alike)} the clicked paws hardly differ from what is around the animal: "
            f"{max(alike.values()):.0%} of it has their colour (usually under 3 %), and the tracks "
            "will be poor. Look whether every click is on a paw; else another light, a belt of "
            "another colour or painted paws help.",
            InputWarning,
            stacklevel=2,
        )


def _look_through(
    views: Views,
    frames: tuple[int, int],
    scene: Scene | None,
    follower: Follower | None,
    anchors: Mapping[int, Sequence[Placement]],
    store: CandidateStore | None,
    task: Task,
) -> list[list[np.ndarray]]:
    """Go through the video for paws and landmarks; return the paws' candidates.

    There are none if it was stopped before every point was reached: nothing can be decided.
    """
    found = _look_ahead(views, frames, scene, follower, store, task)
    inside = {t: here for t, here in anchors.items() if t < frames[0] + len(found)}
    if placed_points(inside) != placed_points(anchors):
        return []
    if follower is not None and not look_back(
        views, follower, frames[0], progress=task.progress, stop=task.stop
    ):
        return []
    return found


def _look_ahead(
    views: Views,
    frames: tuple[int, int],
    scene: Scene | None,
    follower: Follower | None,
    store: CandidateStore | None,
    task: Task,
) -> list[list[np.ndarray]]:
    """Go through the video once, forwards; return the paws' candidates of every frame."""
    progress, total = task.progress, frames[1] - frames[0]
    if follower is not None:
        total += frames_back(follower.placed, frames[0])
    report = None if progress is None else lambda done: progress(done, total)
    watch = None if follower is None else follower.step
    if scene is not None:
        return extract(
            views, frames, looks=scene.looks, regions=scene.regions, home=scene.home,
            store=store, watch=watch, progress=report, stop=task.stop,
        )  # fmt: skip
    found: list[list[np.ndarray]] = []
    for i, pictures in views.frames(*frames, partly=True):
        if task.stop is not None and task.stop():
            break
        if watch is not None:
            watch(i, pictures)
        found.append([])
        if report is not None:
            report(len(found))
    return found


def _empty_result(n: int, layout: Layout) -> Refined:
    """Return tracks of all points in which nothing is known yet."""
    n_views, n_points = layout.tracked.shape
    d = 2 if layout.rig is None else 3
    x = np.full((n, n_points, d), np.nan)
    measured = np.full((n, n_points, n_views, 2), np.nan)
    return Refined(
        x, x.copy(), measured, np.zeros((n, n_points, n_views)), np.full((n, n_points), np.nan)
    )


def _solve(
    found: list[list[np.ndarray]],
    scene: Scene,
    layout: Layout,
    inside: Mapping[int, Sequence[Placement]],
    first: int,
    fps: float,
    settings: WholeSettings,
    *,
    told: Told | None,
) -> Refined:
    """Track the paws through the candidates; ``inside``: what is placed, by row."""
    n = len(found)
    fixed = {t - first: here for t, here in scene.anchors.items() if t - first < n}
    certain = certain_positions(inside, n, layout)
    return decide(
        found, fixed, certain, scene=scene, layout=layout, fps=fps, settings=settings, told=told
    )


def _told(
    seen: list[list[np.ndarray]],
    layout: Layout,
    clicks: Mapping[int, Sequence[Placement]],
    begin: int,
) -> Told:
    """Return the clicks of an earlier run with what was seen there, from frame ``begin`` on.

    They alone say where on a paw its point is, as they did then: a correction puts the paw in
    place in its frame, and a hand that was a pixel off there moves the track nowhere else.
    """
    here = {t - begin: clicks[t] for t in sorted(clicks) if t - begin < len(seen)}
    placed = certain_positions(here, len(seen), layout)
    return Told(placed[list(here)], {t: seen[t] for t in here})


def _write(
    new: Tracks,
    begin: int,
    result: Refined,
    anchors: Mapping[int, Sequence[Placement]],
    layout: Layout,
) -> None:
    """Write refined tracks into Tracks."""
    n, _, d = result.x.shape
    rows = slice(begin, begin + n)
    uv = Geometry(None if layout.rig is None else layout.rig.coefs).project(result.x)
    seen = np.isfinite(result.measured[..., 0])
    known = np.isfinite(result.x[..., 0])
    count = seen.sum(axis=-1)
    enough = 1 if d == 2 else 2
    origin = np.where(
        count >= enough,
        ORIGIN_CODE["measured"],
        np.where(count == 1, ORIGIN_CODE["resolved"], ORIGIN_CODE["predicted"]),
    )
    image_origin = np.where(
        seen,
        ORIGIN_CODE["measured"],
        np.where((count > 0)[..., None], ORIGIN_CODE["reprojected"], ORIGIN_CODE["predicted"]),
    )
    quality = np.where(seen, result.quality, 0.0)
    confidence = quality.sum(axis=-1) / np.maximum(count, 1)
    off = np.linalg.norm(result.measured - uv, axis=-1)  # NaN where a view saw nothing
    square = np.where(seen, off**2, 0.0).sum(axis=-1)
    residual = np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)
    for t, here in anchors.items():
        for place in here:
            if place.origin != "edited":
                continue
            uv[t, place.point, place.view] = place.uv
            image_origin[t, place.point, place.view] = ORIGIN_CODE["edited"]
            origin[t, place.point] = ORIGIN_CODE["edited"]
            confidence[t, place.point] = 1.0
    origin = np.where(known, origin, ORIGIN_CODE["missing"])
    image_origin = np.where(known[..., None], image_origin, ORIGIN_CODE["missing"])
    new["position"][rows, ..., 0] = np.swapaxes(result.x, 1, 2)
    new["sd"][rows, ..., 0] = np.where(known[:, None], np.swapaxes(result.sd, 1, 2), np.nan)
    new["revision"][rows, ..., 0] = np.where(known, result.revision, np.nan)
    new["origin"][rows, ..., 0] = origin
    new["confidence"][rows, ..., 0] = np.where(known, confidence, 0.0)
    new["residual"][rows, ..., 0] = residual
    new["image_position"][rows, ..., 0] = uv.transpose(0, 2, 3, 1)
    new["image_origin"][rows, ..., 0] = image_origin.transpose(0, 2, 1)
    new["image_confidence"][rows, ..., 0] = quality.transpose(0, 2, 1)
    new["image_residual"][rows, ..., 0] = off.transpose(0, 2, 1)


def _keep_rows(old: Tracks, new: Tracks, kept: np.ndarray) -> Tracks:
    """Copy the rows of ``old`` that were not tracked again, and its times and attributes."""
    frames = new["frame"].to_numpy()
    source = old.swap_dims(time="frame").sel(frame=kept)
    rows = np.isin(frames, kept)
    for name in new.data_vars:
        if name not in source:
            continue
        there = [dim for dim in ("view", "keypoint", "space") if dim in new[name].dims]
        part = source[name].reindex({dim: new[dim] for dim in there})
        whole = new[name].dtype.kind == "i" or "confidence" in str(name)
        new[name][rows] = part.fillna(0 if whole else np.nan).to_numpy()
    time = new["time"].to_numpy().copy()
    shared = np.isin(frames, old["frame"].to_numpy())
    time[shared] = old.swap_dims(time="frame").sel(frame=frames[shared])["time"].to_numpy()
    return new.assign_coords(time=time).assign_attrs(old.attrs)
