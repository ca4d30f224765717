"""What was found, written as Tracks: smoothed places, their projections, and how sure they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from pawnb.arrays import AnyArray, BoolArray, IntArray
from pawnb.core.paws.layout import Layout, Placement
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.request import TrackingRequest
from pawnb.schema import ORIGIN_CODE, Tracks, make_tracks


def empty_result(n: int, layout: Layout) -> SmoothedTracks:
    """Return tracks of all points in n frames of which nothing is known yet."""
    n_views, n_points = layout.tracked.shape
    return SmoothedTracks.unknown(n, n_points, n_views, 2 if layout.rig is None else 3)


def blank_tracks(
    layout: Layout, task: TrackingRequest, n: int, *, in_space: bool
) -> tuple[Tracks, int, IntArray]:
    """Return Tracks in which nothing is known yet, with standard deviations and residuals.

    Parameters
    ----------
    layout : Layout
        Its points and views.
    task : TrackingRequest
        What was asked for; rows of tracks that are gone on from are there, too.
    n : int
        Frames, from the task's first on.
    in_space : bool
        Whether positions are in space, not in a picture.

    Returns
    -------
    new : Tracks
        The tracks.
    begin : int
        Row of the task's first frame.
    kept : ndarray of int
        Frames of the other rows.
    """
    first = task.frames[0]
    rows, kept = np.arange(first, first + n), np.empty(0, int)
    if task.tracks is not None:
        known = task.tracks["frame"].to_numpy()
        kept = known[(known < first) | (known >= first + n)]
        rows = np.sort(np.concatenate([kept, rows]))
    new = make_tracks(
        rows, layout.points, fps=task.fps, views=layout.views,
        space=("x", "y", "z") if in_space else ("x", "y"), individual=task.individual,
        unit=task.unit if in_space else "px",
    )  # fmt: skip
    new["sd"] = new["position"].copy()
    new["image_residual"] = xr.full_like(new["image_confidence"], np.nan).assign_attrs(units="px")
    return new, int(np.searchsorted(rows, first)), kept


def as_tracks(
    result: SmoothedTracks,
    layout: Layout,
    task: TrackingRequest,
    *,
    placed: Mapping[int, Sequence[Placement]],
) -> Tracks:
    """Return what was found as Tracks.

    Parameters
    ----------
    result : SmoothedTracks
        Of the task's frames, from the first on; fewer where the run was stopped.
    layout : Layout
        Points and views.
    task : TrackingRequest
        What was asked for. Of tracks that are gone on from, the other rows are kept.
    placed : dict
        Row of ``result`` to what was placed by hand there.

    Returns
    -------
    Tracks
        See :func:`.tracker.track_treadmill`.
    """
    n = len(result.x)
    new, begin, kept = blank_tracks(layout, task, n, in_space=task.rig is not None)
    new["revision"] = new["residual"].copy().assign_attrs(units=new["position"].attrs["units"])
    # logarithms of odds, and standard deviations
    new["image_separation"] = xr.full_like(new["image_confidence"], np.nan).assign_attrs(units="1")
    new["image_offset"] = new["image_position"].copy()
    new["passes_apart"] = new["residual"].copy().assign_attrs(units="1")
    if n:
        _write(new, begin, result, placed, layout)
    return new if task.tracks is None else keep_rows(task.tracks, new, kept)


def _write(
    new: Tracks,
    begin: int,
    result: SmoothedTracks,
    placed: Mapping[int, Sequence[Placement]],
    layout: Layout,
) -> None:
    """Write refined tracks into Tracks, from row ``begin`` on."""
    n, _, d = result.x.shape
    rows = slice(begin, begin + n)
    uv = Projection(None if layout.rig is None else layout.rig.coefs).project(result.x)
    seen = np.isfinite(result.measured[..., 0])
    known = np.isfinite(result.x[..., 0])
    count = seen.sum(axis=-1)
    origin, image_origin = _origins(seen, enough=1 if d == 2 else 2)
    detection_probability = np.where(seen, result.detection_probability, 0.0)
    confidence = detection_probability.sum(axis=-1) / np.maximum(count, 1)
    offset = result.measured - uv  # NaN where a view saw nothing
    off = np.linalg.norm(offset, axis=-1)
    square = np.where(seen, off**2, 0.0).sum(axis=-1)
    residual = np.where(count > 0, np.sqrt(square / np.maximum(count, 1)), np.nan)
    for t, here in placed.items():
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
    new["revision"][rows, ..., 0] = np.where(known, result.displacement_from_first_pass, np.nan)
    new["passes_apart"][rows, ..., 0] = np.where(known, result.forward_backward_distance, np.nan)
    new["origin"][rows, ..., 0] = origin
    new["confidence"][rows, ..., 0] = np.where(known, confidence, 0.0)
    new["residual"][rows, ..., 0] = residual
    new["image_position"][rows, ..., 0] = uv.transpose(0, 2, 3, 1)
    new["image_origin"][rows, ..., 0] = image_origin.transpose(0, 2, 1)
    new["image_confidence"][rows, ..., 0] = detection_probability.transpose(0, 2, 1)
    new["image_residual"][rows, ..., 0] = off.transpose(0, 2, 1)
    new["image_offset"][rows, ..., 0] = offset.transpose(0, 2, 3, 1)
    new["image_separation"][rows, ..., 0] = result.association_log_odds.transpose(0, 2, 1)


def _origins(seen: BoolArray, *, enough: int) -> tuple[IntArray, IntArray]:
    """Return the origins of positions (n, P) and image positions (n, P, V), given who saw them."""
    count = seen.sum(axis=-1)
    alone = np.where(count == 1, ORIGIN_CODE["resolved"], ORIGIN_CODE["predicted"])
    others = np.where((count > 0)[..., None], ORIGIN_CODE["reprojected"], ORIGIN_CODE["predicted"])
    return (
        np.where(count >= enough, ORIGIN_CODE["measured"], alone),
        np.where(seen, ORIGIN_CODE["measured"], others),
    )


def keep_rows(old: Tracks, new: Tracks, kept: AnyArray) -> Tracks:
    """Copy the rows of ``old`` that were not tracked again, and its times and attributes.

    Parameters
    ----------
    old, new : Tracks
        Tracks before and after.
    kept : ndarray of int
        Frames that were not tracked again.

    Returns
    -------
    xarray.Dataset
        The new tracks with these rows.
    """
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
