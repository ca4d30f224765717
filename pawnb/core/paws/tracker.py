"""Tracking points through one or more views: from clicks to Tracks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.core.paws.again import Plan, prepare_again
from pawnb.core.paws.collisions import Collisions
from pawnb.core.paws.found import FrameResult
from pawnb.core.paws.layout import (
    Views,
    check_every_point_started,
    make_layout,
    read_start,
)
from pawnb.core.paws.run import Run
from pawnb.core.paws.settings import PaperSettings
from pawnb.core.paws.stretch import keep_rows
from pawnb.core.paws.template import DEFAULT_TEMPLATE, load_template
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS, Tracks, check_columns, make_tracks

PAPER_METHODS = ("slic-2d", "slic-3d", "paper")
"""The method of 2019 (``paper``) and the two lesser variants it is compared with."""


def track_paws(
    views: Views,
    start: pd.DataFrame,
    *,
    rig: Rig | None,
    settings: PaperSettings,
    method: str = "paper",
    points_by_view: Mapping[str, Sequence[str]],
    facing: Mapping[str, int] | None = None,
    frames: tuple[int, int],
    fps: float,
    individual: str = "animal",
    unit: str = "px",
    tracks: Tracks | None = None,
    learn_at: Mapping[str, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tracks:
    """Track points by superpixels and Kalman filters, and through collisions by a template.

    The method of Haji Maghsoudi et al. 2019 (Algorithms 1 to 4, Eq. 1 to 9): in each frame
    the Kalman prediction is projected into each view, a sub-image around it is divided
    into superpixels, and the one with the highest fused score is the point. Two views or
    more give its 3D position, which updates the filter. Without a rig, and for a point
    that one view alone has found, a 2D filter predicts in the picture. Collisions are the
    matter of :mod:`pawnb.core.paws.collisions`. Outside of collisions a point
    is never given up: where it is hidden, the superpixel most like it is taken.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px); one frame or more. A second
        start frame gives new colours, and velocities where it is the next frame. A
        point that is not clicked in a view is hidden there; see ``settings.hidden``.
    rig : Rig, optional
        The calibrated views. Without it each view is tracked by itself.
    settings : PaperSettings
        The settings.
    method : {"paper", "slic-3d", "slic-2d"}
        ``"slic-3d"`` does nothing about collisions (the paper's SLIC + 3D); ``"slic-2d"``
        predicts in each view by itself as well (SLIC + 2D), and the rig only gives the
        positions in space afterwards.
    points_by_view : mapping
        Points that each view tracks; none listed means every point.
    facing : mapping, optional
        +1 or -1 where the animal faces right or left in a view; default by the rig's
        forward direction, else by the clicks of front and hind points. Where it stays
        unknown the seventh feature is left out.
    frames : tuple of int
        First frame and one past the last. Tracking begins with the first start frame;
        frames before it stay missing.
    fps : float
        Frames per second.
    individual : str
        The animal's id.
    unit : str
        Unit of the rig's space; without a rig ``position`` is x = u, y = v, in px, of the
        first view in which the point was clicked.
    tracks : Tracks, optional
        Tracks to go on from: rows before ``frames[0]`` are kept, and every state is made
        anew from them and from the positions in ``frames[0]``. Points put in place by hand
        there are tracked on, each to the next frame in which it was put in place by hand,
        or to where it has met the old track; other points and all other rows stay as they
        are. Where none was put in place there, all are tracked to the end, and positions
        placed by hand in later frames hold. ``start`` need only have points that
        ``tracks`` lack.
    learn_at : mapping, optional
        With ``tracks``: point to the frame, in which it was put in place by hand, whose
        colour is its initial colour from then on. The paper keeps that of the start
        unless the user asks for a new one.
    progress : callable, optional
        ``progress(done, total)`` after each frame.
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is returned (and with
        ``tracks``, later rows stay as they were).

    Returns
    -------
    xarray.Dataset
        Tracks of ``frames``. ``origin`` is ``edited`` for a clicked position, ``measured``
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
    _check_frames(frames, views.n_frames)
    layout = make_layout(
        views,
        start,
        rig=rig,
        settings=settings,
        points_by_view=points_by_view,
        facing=facing,
        in_space=method != "slic-2d",
    )
    collisions = None
    if method == "paper":
        template = load_template(settings.template or DEFAULT_TEMPLATE)
        collisions = Collisions(layout, template, fps=fps)
    run = Run(layout, collisions=collisions)
    if tracks is None:
        check_every_point_started(start, layout)
        plan = Plan(read_start(start, layout, frames))
        first = min(plan.placements)
    else:
        first = frames[0]
        plan = prepare_again(run, views, start, tracks=tracks, first=first, learn_at=learn_at)
    results = _run(run, views, plan, (first, frames[1]), progress=progress, stop=stop)
    done = first + len(results)
    rows = np.arange(frames[0], done)
    if tracks is not None:
        known = tracks["frame"].to_numpy()
        rows = np.concatenate([known[known < frames[0]], rows, known[known >= done]])
    new = make_tracks(
        rows,
        layout.points,
        fps=fps,
        views=layout.views,
        space=("x", "y") if rig is None else ("x", "y", "z"),
        individual=individual,
        unit="px" if rig is None else unit,
    )
    begin = int(np.searchsorted(rows, first))
    _write(new, results, begin)
    if tracks is None or plan.stretch is None:
        return new
    # the last row of each point that was tracked again, as a frame
    last = tracks["frame"].to_numpy()[np.maximum(plan.stretch.until - 1, 0)]
    again = (rows[:, None] >= first) & (rows[:, None] <= np.where(plan.stretch.until, last, -1))
    return keep_rows(tracks, new, ~again)


def _check_frames(frames: tuple[int, int], n_frames: int) -> None:
    """Check the range of frames against the recording."""
    if not 0 <= frames[0] < frames[1] <= n_frames:
        raise InputError(
            f"frames {frames[0]} to {frames[1] - 1} are to be tracked, but the views have "
            f"frames 0 to {n_frames - 1}; choose a range within."
        )


def _run(
    run: Run,
    views: Views,
    plan: Plan,
    frames: tuple[int, int],
    *,
    progress: Callable[[int, int], None] | None,
    stop: Callable[[], bool] | None,
) -> list[FrameResult]:
    """Go through the frames; return a result for each one done."""
    results: list[FrameResult] = []
    total = frames[1] - frames[0]
    for i, pictures in views.frames(*frames):
        if stop is not None and stop():
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
