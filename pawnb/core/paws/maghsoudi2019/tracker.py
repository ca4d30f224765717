"""Tracking points through one or more views: from clicks to Tracks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.core.paws.layout import (
    Views,
    check_every_point_started,
    make_layout,
    read_start,
)
from pawnb.core.paws.maghsoudi2019.collisions import Collisions
from pawnb.core.paws.maghsoudi2019.frame_result import FrameResult
from pawnb.core.paws.maghsoudi2019.restart import RestartPlan, prepare_again
from pawnb.core.paws.maghsoudi2019.run import Run
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.template import DEFAULT_TEMPLATE, load_template
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.retracked_span import keep_rows
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS, Tracks, check_columns, make_tracks

PAPER_METHODS = ("slic-2d", "slic-3d", "paper")
"""The method of 2019 (``paper``) and the two lesser variants it is compared with."""


def track_maghsoudi2019(
    views: Views,
    start: pd.DataFrame,
    task: TrackingRequest,
    *,
    settings: Maghsoudi2019Settings,
    method: str = "paper",
    learn_at: Mapping[str, int] | None = None,
) -> Tracks:
    """Track points by superpixels and Kalman filters, and through collisions by a template.

    The method of Haji Maghsoudi et al. 2019 (Algorithms 1 to 4, Eq. 1 to 9): in each frame
    the Kalman prediction is projected into each view, a sub-image around it is divided
    into superpixels, and the one with the highest fused score is the point. Two views or
    more give its 3D position, which updates the filter. Without a rig, and for a point
    that one view alone has found, a 2D filter predicts in the picture. Collisions are the
    matter of :mod:`pawnb.core.paws.maghsoudi2019.collisions`. Outside of collisions a point
    is never given up: where it is hidden, the superpixel most like it is taken.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px); one frame or more. A second
        start frame gives new colours, and velocities where it is the next frame. A
        point that is not clicked in a view is hidden there; see ``settings.hidden``.
    task : TrackingRequest
        What is to be tracked. Without a rig each view is tracked by itself, and ``position``
        is x = u, y = v, in px, of the first view in which the point was clicked. Where
        nothing tells which way the animal faces, the seventh feature is left out. With
        tracks to go on from, every state is made anew from the rows before the first frame
        and from the positions in it. Points put in place by hand there are tracked on, each
        to the next frame in which it was put in place by hand, or to where it has met the
        old track; other points and all other rows stay as they are. Where none was put in
        place there, all are tracked to the end, and positions placed by hand in later
        frames hold. ``start`` need only have points that the tracks lack.
    settings : Maghsoudi2019Settings
        The settings.
    method : {"paper", "slic-3d", "slic-2d"}
        ``"slic-3d"`` does nothing about collisions (the paper's SLIC + 3D); ``"slic-2d"``
        predicts in each view by itself as well (SLIC + 2D), and the rig only gives the
        positions in space afterwards.
    learn_at : mapping, optional
        With tracks to go on from: point to the frame, in which it was put in place by hand, whose
        colour is its initial colour from then on. The paper keeps that of the start
        unless the user asks for a new one.

    Returns
    -------
    xarray.Dataset
        Tracks of the frames asked for; where it was stopped while going on from tracks,
        later rows stay as they were. ``origin`` is ``edited`` for a clicked position, ``measured``
        for a superpixel or a triangulated position, ``resolved`` for a superpixel that was
        found during a collision or taken to undo a jump, ``predicted`` where the filter or
        the template alone says it, else ``missing``. ``image_confidence`` is the fused score
        (Eq. 6) of the superpixel taken: 1 means that it was the best of its sub-image in
        every feature at once. It compares superpixels of one sub-image, so it falls when colour and
        place disagree, not when the paw is absent. ``confidence`` is its mean over the
        views used; predicted positions have 0, clicks 1. ``residual`` is the RMS
        reprojection error, px.

    Raises
    ------
    InputError
        If a click does not fit the views, points or frames, a point has no click, or there
        is no such method.
    CalibrationError
        If the rig lacks a view.
    """
    if method not in PAPER_METHODS:
        raise InputError(f"unknown method {method!r}; expected {', '.join(PAPER_METHODS)}.")
    check_columns(start, START_COLUMNS, where="the start points")
    task.check_frames(views.n_frames)
    layout = make_layout(views, start, task, settings=settings, in_space=method != "slic-2d")
    collisions = None
    if method == "paper":
        template = load_template(settings.template or DEFAULT_TEMPLATE)
        collisions = Collisions(layout, template, fps=task.fps)
    run = Run(layout, collisions=collisions)
    frames, tracks = task.frames, task.tracks
    if tracks is None:
        check_every_point_started(start, layout)
        plan = RestartPlan(read_start(start, layout, frames))
        first = min(plan.placements)
    else:
        first = frames[0]
        plan = prepare_again(run, views, start, tracks=tracks, first=first, learn_at=learn_at)
    results = _run(run, views, plan, first, task)
    done = first + len(results)
    rows = np.arange(frames[0], done)
    if tracks is not None:
        known = tracks["frame"].to_numpy()
        rows = np.concatenate([known[known < frames[0]], rows, known[known >= done]])
    new = make_tracks(
        rows,
        layout.points,
        fps=task.fps,
        views=layout.views,
        space=("x", "y") if task.rig is None else ("x", "y", "z"),
        individual=task.individual,
        unit="px" if task.rig is None else task.unit,
    )
    begin = int(np.searchsorted(rows, first))
    _write(new, results, begin)
    if tracks is None or plan.stretch is None:
        return new
    # the last row of each point that was tracked again, as a frame
    last = tracks["frame"].to_numpy()[np.maximum(plan.stretch.until - 1, 0)]
    again = (rows[:, None] >= first) & (rows[:, None] <= np.where(plan.stretch.until, last, -1))
    return keep_rows(tracks, new, ~again)


def _run(
    run: Run, views: Views, plan: RestartPlan, first: int, task: TrackingRequest
) -> list[FrameResult]:
    """Go through the frames from the first on; return a result for each one done."""
    results: list[FrameResult] = []
    total, progress = task.frames[1] - first, task.progress
    for i, pictures in views.frames(first, task.frames[1], partly=True):
        if task.stop is not None and task.stop():
            break
        known = plan.enter(run, i)
        if known is None:
            if progress is not None:
                progress(total, total)
            break
        results.append(run.step(pictures, known))
        plan.leave(i, results[-1].uv)
        if progress is not None:
            progress(len(results), total)
    return results


def _write(tracks: Tracks, results: Sequence[FrameResult], first: int) -> None:
    """Write the results of consecutive frames into Tracks, from row ``first`` on."""
    if not results:
        return
    rows = slice(first, first + len(results))

    def write(name: str, field: str) -> None:
        # (time, ..., space, keypoint, individual): coordinates go before the points
        values = np.stack([getattr(result, field) for result in results])
        if field in {"position", "uv"}:
            values = np.swapaxes(values, -1, -2)
        tracks[name][rows, ..., 0] = values

    for name in ("position", "origin", "confidence", "residual"):
        write(name, name)
    for name in ("image_origin", "image_confidence"):
        write(name, name)
    write("image_position", "uv")
