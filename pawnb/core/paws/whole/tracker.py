"""Tracking points through a whole recording at once: from clicks to Tracks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.core.paws.layout import (
    Layout,
    Placement,
    Views,
    check_every_point_started,
    make_layout,
    read_start,
)
from pawnb.core.paws.settings import PaperSettings
from pawnb.core.paws.whole.candidates import worth
from pawnb.core.paws.whole.extract import extract
from pawnb.core.paws.whole.flow import Flow, FlowCosts
from pawnb.core.paws.whole.habit import follow_body, habit_cost, learn_habits
from pawnb.core.paws.whole.hypotheses import Pairing, Places
from pawnb.core.paws.whole.refine import Refined, Refinement, learn_offsets, refine
from pawnb.core.paws.whole.scene import Scene, move_anchors, read_scene
from pawnb.core.paws.whole.settings import WholeSettings
from pawnb.core.paws.whole.store import CandidateStore
from pawnb.core.paws.whole.tracklets import Linking, Tracklet, build_tracklets, find_drift
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, START_COLUMNS, Tracks, check_columns, make_tracks

_LOOKS = 2
"""Times that paths are chosen again with the habits learnt from the last choice."""
_HABIT = 0.5
_BODY_S = 0.4


def track_whole(
    views: Views,
    start: pd.DataFrame,
    *,
    rig: Rig | None,
    settings: WholeSettings,
    points_by_view: Mapping[str, Sequence[str]],
    facing: Mapping[str, int] | None = None,
    frames: tuple[int, int],
    fps: float,
    individual: str = "animal",
    unit: str = "px",
    tracks: Tracks | None = None,
    looked: pd.DataFrame | None = None,
    store: CandidateStore | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tracks:
    """Track points by deciding over the whole recording.

    One pass over the video keeps only candidates: the ends of parts that have the colour
    of the clicked paws. Candidates of two views that meet make places in space; places
    that follow each other without doubt make pieces of path; which pieces belong to which
    point is decided for all points and all frames at once, with gaps where a point is
    hidden; then every view's candidates are taken in again and the tracks are smoothed.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px); one frame or more.
    rig : Rig, optional
        The calibrated views. Without it there must be one view.
    settings : WholeSettings
        The settings.
    points_by_view : mapping
        Points that each view tracks; none listed means every point.
    facing : mapping, optional
        +1 or -1 where the animal faces right or left in a view.
    frames : tuple of int
        First frame and one past the last. Tracking begins with the first start frame;
        frames before it stay missing.
    fps : float
        Frames per second.
    individual : str
        The animal's id.
    unit : str
        Unit of the rig's space.
    tracks : Tracks, optional
        Tracks to go on from: rows before ``frames[0]`` are kept; positions in
        ``frames[0]``, and positions placed by hand in it or later, are certain.
    looked : DataFrame, optional
        Earlier clicks, columns as ``start``, that say what paws look like and how large
        the animal is: where tracks are gone on from, those that they were begun with.
        Candidates are then the same as theirs, from the first of these frames on.
    store : CandidateStore, optional
        Where candidates are kept: frames found there are not decoded again.
    progress : callable, optional
        ``progress(done, total)`` after each frame.
    stop : callable, optional
        Asked before each frame; when it answers True, the frames done so far are tracked.

    Returns
    -------
    xarray.Dataset
        Tracks. ``position`` is smoothed and ``image_position`` is its projection into
        every view, also those that do not track the point; at clicks it is the click.
        ``image_origin`` is ``measured`` where a candidate of that view was used,
        ``reprojected`` where only others saw the point, ``predicted`` where none did.
        ``origin`` is ``measured`` with two views or more (one without a rig), ``resolved``
        with one, else ``predicted``. ``image_confidence`` says how much the candidate looks
        like the end of a paw, 0 to 1; ``sd`` is the standard deviation of ``position``.

    Raises
    ------
    InputError
        If a click does not fit the views, points or frames, or a point has no click, or
        there are several views and no rig.
    CalibrationError
        If the rig lacks a view.
    """
    check_columns(start, START_COLUMNS, where="the start points")
    if not 0 <= frames[0] < frames[1] <= views.n_frames:
        raise InputError(
            f"frames {frames[0]} to {frames[1] - 1} are to be tracked, but the views have "
            f"frames 0 to {views.n_frames - 1}; choose a range within."
        )
    if rig is None and len(views.names) > 1:
        raise InputError(
            f"{len(views.names)} views and no calibration; this method joins views in space: "
            "calibrate them, or keep one view."
        )
    layout = make_layout(
        views, start, rig=rig, settings=PaperSettings(), points_by_view=points_by_view,
        facing=facing,
    )  # fmt: skip
    clicks, anchors = _placements(start, layout, frames, tracks)
    first = min(anchors)
    begin = first
    if looked is not None and len(looked):
        clicks = read_start(looked, layout, (0, frames[1]))
        begin = min(first, *clicks)
        scene = read_scene(views, layout, clicks, anchors=clicks, settings=settings)
        scene = move_anchors(scene, layout, anchors)
    else:
        scene = read_scene(views, layout, clicks, anchors=anchors, settings=settings)
    total = frames[1] - begin
    found = extract(
        views, (begin, frames[1]), looks=scene.looks, regions=scene.regions, store=store,
        progress=None if progress is None else lambda done: progress(done, total), stop=stop,
    )[first - begin :]  # fmt: skip
    rows = np.arange(frames[0], first + len(found))
    kept = np.empty(0, int)
    if tracks is not None:
        known = tracks["frame"].to_numpy()
        kept = known[(known < frames[0]) | (known >= first + len(found))]
        rows = np.sort(np.concatenate([kept, rows]))
    new = make_tracks(
        rows, layout.points, fps=fps, views=layout.views,
        space=("x", "y") if rig is None else ("x", "y", "z"), individual=individual,
        unit="px" if rig is None else unit,
    )  # fmt: skip
    new["sd"] = new["position"].copy()
    if found:
        row = int(np.searchsorted(rows, first))
        _solve(new, row, found, scene, layout, anchors, first, fps, settings)
    if tracks is not None:
        new = _keep_rows(tracks, new, kept)
    return new


def _placements(
    start: pd.DataFrame, layout: Layout, frames: tuple[int, int], tracks: Tracks | None
) -> tuple[dict[int, list[Placement]], dict[int, list[Placement]]]:
    """Return what was placed by hand, and what tracks must pass through, by frame."""
    if tracks is None:
        check_every_point_started(start, layout)
        placements = read_start(start, layout, frames)
        return placements, placements
    by_hand: dict[int, list[Placement]] = {}
    anchors: dict[int, list[Placement]] = {}
    known = tracks["frame"].to_numpy()
    image = tracks["image_position"].isel(individual=0)
    uv = image.transpose("time", "view", "keypoint", "image_space").to_numpy()
    image = tracks["image_origin"].isel(individual=0)
    origin = image.transpose("time", "view", "keypoint").to_numpy()
    view_names = tracks["view"].to_numpy().tolist()
    point_names = tracks["keypoint"].to_numpy().tolist()
    edited = origin == ORIGIN_CODE["edited"]
    here = known == frames[0]
    wanted = np.isfinite(uv[..., 0]) & (edited | here[:, None, None])
    for i, v, p in np.argwhere(wanted):
        if view_names[v] not in layout.views or point_names[p] not in layout.points:
            continue
        view, point = layout.views.index(view_names[v]), layout.points.index(point_names[p])
        if not layout.tracked[view, point]:
            continue
        sure = bool(edited[i, v, p])
        place = Placement(view, point, uv[i, v, p], "edited" if sure else "measured")
        t = int(known[i])
        if sure:
            by_hand.setdefault(t, []).append(place)
        if frames[0] <= t < frames[1]:
            anchors.setdefault(t, []).append(place)
    for t, extra in read_start(start, layout, frames).items():
        have = {(p.view, p.point) for p in anchors.get(t, [])}
        anchors.setdefault(t, []).extend(p for p in extra if (p.view, p.point) not in have)
    return by_hand or anchors, anchors


def _solve(
    new: Tracks,
    begin: int,
    found: list[list[np.ndarray]],
    scene: Scene,
    layout: Layout,
    anchors: Mapping[int, Sequence[Placement]],
    first: int,
    fps: float,
    settings: WholeSettings,
) -> None:
    """Track the points through the candidates and write them from row ``begin`` on."""
    n, n_points, n_views = len(found), len(layout.points), len(layout.views)
    inside = {t - first: here for t, here in anchors.items() if t - first < n}
    fixed = {t - first: here for t, here in scene.anchors.items() if t - first < n}
    chosen = choose_paths(found, fixed, scene, fps=fps, settings=settings, kinds=layout.kinds)
    certain = np.full((n, n_points, n_views, 2), np.nan)
    for t, here in inside.items():
        for place in here:
            certain[t, place.point, place.view] = place.uv
    clicked = sorted(inside)
    offsets = learn_offsets(
        certain[clicked],
        {t: found[t] for t in clicked},
        thickness_px=scene.thickness_px,
        facing=layout.facing,
        distal=scene.distal,
        kinds=layout.kinds,
    )
    acceleration = settings.acceleration * scene.span / fps**2
    what = Refinement(
        scene.geometry, scene.thickness_px, scene.thickness, layout.facing, scene.distal, offsets,
        acceleration, layout.tracked.T,
    )  # fmt: skip
    result = refine(chosen, found, certain=certain, what=what)
    started = np.array([min(t for t, h in fixed.items() if p in h) for p in range(n_points)])
    result.x[np.arange(n)[:, None] < started] = np.nan
    _write(new, begin, result, inside, scene)


def choose_paths(
    found: Sequence[Sequence[np.ndarray]],
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    scene: Scene,
    *,
    fps: float,
    settings: WholeSettings,
    kinds: Sequence[str],
) -> np.ndarray:
    """Choose the places of every point: positions (n, P, d), NaN where hidden.

    Parameters
    ----------
    found : sequence
        Candidates of every frame and view.
    fixed : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    fps : float
        Frames per second.
    settings : WholeSettings
        The settings.
    kinds : sequence of str
        Kind of each point: "front", "hind" or "other".

    Returns
    -------
    ndarray
        The chosen places.
    """
    n_points = len(kinds)
    places = _find_places(found, scene, settings)
    d = scene.geometry.n_coordinates
    for t, here in fixed.items():
        away = places[t].distance(np.stack(list(here.values())))
        free = away > 1.2 * scene.thickness
        if t == min(fixed):
            free[:] = False
        places[t] = places[t].take(free)
    acceleration = settings.acceleration * scene.span / fps**2
    noise = settings.noise * scene.thickness
    speed = 12.0 * scene.span / fps
    drift = find_drift(places, within=0.3 * scene.thickness, longest=2.0 * speed)
    linking = Linking(acceleration, noise, 0.4 * speed, drift, 1.6)
    pieces = [
        piece for piece in build_tracklets(places, linking)
        if piece.cost.mean() < (0.9 if len(piece.picks) > 1 else 0.5)
    ]  # fmt: skip
    costs = FlowCosts(
        acceleration, noise, 0.4 * speed, drift, settings.hide_cost, settings.stay_cost,
        max(4, round(settings.longest_gap_s * fps)), settings.links,
    )  # fmt: skip
    start = min(fixed)
    pieces = [piece for piece in pieces if piece.first > start]
    problem = Flow(pieces, fixed, len(found), costs)
    prior = _start_prior(pieces, fixed, scene, kinds)
    x = _positions_of(problem.assign(prior), pieces, fixed, (len(found), n_points, d))
    axes = [scene.forward] if d == 2 else [scene.forward, np.cross(scene.up, scene.forward)]
    groups = [kinds, [str(p) for p in range(n_points)]][: len(axes)]
    for _ in range(_LOOKS):
        body = follow_body(x[start:], max(3, round(_BODY_S * fps)))
        body = np.concatenate([np.repeat(body[:1], start, axis=0), body])
        habits = learn_habits(x, body, axes=axes, groups=groups, span=scene.span)
        prior = _HABIT * habit_cost(pieces, body, axes=axes, habits=habits, span=scene.span)
        x = _positions_of(problem.assign(prior), pieces, fixed, (len(found), n_points, d))
    return x


def _positions_of(
    chains: Sequence[Sequence[int]],
    pieces: Sequence[Tracklet],
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    shape: tuple[int, int, int],
) -> np.ndarray:
    """Return where chains of pieces lead, (n, P, d), NaN where hidden."""
    x = np.full(shape, np.nan)
    for p, chain in enumerate(chains):
        for i in chain:
            x[pieces[i].first : pieces[i].last + 1, p] = pieces[i].at
    for t, here in fixed.items():
        for p, at in here.items():
            x[t, p] = at
    return x


def _find_places(
    found: Sequence[Sequence[np.ndarray]], scene: Scene, settings: WholeSettings
) -> list[Places]:
    """Return the places of every frame."""
    coefs = scene.geometry.coefs
    if coefs is None or scene.volume is None:
        return [_flat_places(rows[0], scene.distal[0]) for rows in found]
    pairing = Pairing(
        coefs, scene.volume, tolerance_px=0.8 * scene.thickness_px, distal=scene.distal,
        apart=scene.thickness, most=settings.places,
    )  # fmt: skip
    return pairing.places(found)


def _flat_places(rows: np.ndarray, distal: tuple[float, float]) -> Places:
    """Return the candidates of a single view as places."""
    return Places(rows[:, :2].astype(float), 1.5 * (1.0 - worth(rows, distal)))


def _start_prior(
    pieces: Sequence[Tracklet],
    fixed: Mapping[int, Mapping[int, np.ndarray]],
    scene: Scene,
    kinds: Sequence[str],
) -> np.ndarray:
    """Return the cost (P, pieces) of being far from where a point of its kind was clicked."""
    n_points = len(kinds)
    cost = np.zeros((n_points, len(pieces)))
    clicked = [np.stack([h[p] for h in fixed.values() if p in h]) for p in range(n_points)]
    alike = [
        np.concatenate([clicked[o] for o in range(n_points) if kinds[o] == kinds[p]]).mean(axis=0)
        for p in range(n_points)
    ]
    across = None if scene.volume is None else scene.volume.across
    for i, piece in enumerate(pieces):
        for p in range(n_points):
            if kinds[p] != "other":
                ahead = np.abs((piece.at - alike[p]) @ scene.forward) / scene.span
                far = np.maximum(ahead - 0.33, 0.0) / 0.1
                cost[p, i] += 0.5 * np.minimum(far**2, 6.0).sum()
            if across is not None:
                step = (piece.at - clicked[p].mean(axis=0)) @ across
                cost[p, i] += 0.5 * np.minimum((step / (0.1 * scene.span)) ** 2, 6.0).sum()
    return cost


def _write(
    new: Tracks,
    begin: int,
    result: Refined,
    anchors: Mapping[int, Sequence[Placement]],
    scene: Scene,
) -> None:
    """Write refined tracks into Tracks."""
    n, _, d = result.x.shape
    rows = slice(begin, begin + n)
    uv = scene.geometry.project(result.x)
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
    square = np.where(seen, ((result.measured - uv) ** 2).sum(axis=-1), 0.0).sum(axis=-1)
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
    new["origin"][rows, ..., 0] = origin
    new["confidence"][rows, ..., 0] = np.where(known, confidence, 0.0)
    new["residual"][rows, ..., 0] = residual
    new["image_position"][rows, ..., 0] = uv.transpose(0, 2, 3, 1)
    new["image_origin"][rows, ..., 0] = image_origin.transpose(0, 2, 1)
    new["image_confidence"][rows, ..., 0] = quality.transpose(0, 2, 1)


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
