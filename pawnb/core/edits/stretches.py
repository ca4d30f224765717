"""Corrections of a stretch of frames: which rows it has, and what is cleared or interpolated."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from pawnb.core.edits.copies import copy_tracks
from pawnb.core.edits.records import Edit, Retrack, Swap
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import ORIGIN_CODE, Tracks

MISSING, PREDICTED = ORIGIN_CODE["missing"], ORIGIN_CODE["predicted"]
REPROJECTED, EDITED = ORIGIN_CODE["reprojected"], ORIGIN_CODE["edited"]
KNOTS_BESIDE = 4
"""Known positions at either side that a path over a gap is led through: the slopes of a
piecewise cubic need two, and more than these do not change it within the gap."""


def row_of(tracks: Tracks, frame: int) -> int:
    """Return the row of a frame number; raises InputError where there is none."""
    frames = tracks["frame"].to_numpy()
    rows = np.flatnonzero(frames == frame)
    if not len(rows):
        raise InputError(f"frame {frame} is not in the tracks ({frames[0]} to {frames[-1]}).")
    return int(rows[0])


def place_of(tracks: Tracks, dim: str, name: str) -> int:
    """Return the place of a view or point along its dimension.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks.
    dim : str
        "view" or "keypoint".
    name : str
        Which one.

    Returns
    -------
    int
        Its place.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    names = [str(n) for n in tracks[dim].to_numpy()]
    if name not in names:
        word = {"keypoint": "point"}.get(dim, dim)
        raise InputError(
            f"the tracks have no {word} {name!r}{did_you_mean(name, names)}; "
            f"expected {', '.join(names)}."
        )
    return names.index(name)


def rows_of_edit(tracks: Tracks, edit: Edit) -> slice:
    """Return the rows that a correction changes: those of its stretch, its frame, or to the end.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks.
    edit : Edit
        The correction, of any kind but tracking again.

    Returns
    -------
    slice
        Rows, in order.

    Raises
    ------
    InputError
        If its frame is not in the tracks, or its stretch is empty.
    """
    begin = getattr(edit, "since", None)
    begin = edit.frame if begin is None else begin
    first, stop = row_of(tracks, begin), getattr(edit, "stop", None)
    if stop is None:
        return slice(first, tracks.sizes["time"] if isinstance(edit, Swap) else first + 1)
    if stop <= begin:
        raise InputError(
            f"the stretch from frame {begin} ends before frame {stop}; expected a frame after "
            "its first."
        )
    return slice(first, int(np.searchsorted(tracks["frame"].to_numpy(), stop)))


def clear(tracks: Tracks, rows: slice, point: str, *, view: str | None) -> None:
    """Take a point away over some rows, in place.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks, changed in place.
    rows : slice
        Which rows.
    point : str
        Which point.
    view : str or None
        In which view; None for every view.
    """
    views, p = _views(tracks, view), place_of(tracks, "keypoint", point)
    for v in views:
        tracks["image_position"].values[rows, v, :, p, 0] = np.nan
        tracks["image_origin"].values[rows, v, p, 0] = MISSING
        tracks["image_confidence"].values[rows, v, p, 0] = 0.0


def interpolate(tracks: Tracks, rows: slice, point: str, *, view: str | None) -> None:
    """Lead a point smoothly over some rows from what is known around them, in place.

    A piecewise cubic without overshoot (PCHIP; Fritsch and Carlson 1980, SIAM J Numer Anal 17,
    238-246) goes through the known positions at either side and through those that were placed
    by hand within. New positions are of origin ``predicted``, and as sure as the less sure of
    their two neighbours.

    Parameters
    ----------
    tracks : xarray.Dataset
        The tracks, changed in place.
    rows : slice
        Which rows.
    point : str
        Which point.
    view : str or None
        In which view; None for every view that knows the point at both sides.

    Raises
    ------
    InputError
        If the point is not known at both sides in any of the views.
    """
    p, done = place_of(tracks, "keypoint", point), False
    for v in _views(tracks, view):
        done |= _interpolate_view(tracks, rows, v, p)
    if not done:
        first, last = (int(tracks["frame"].values[r]) for r in (rows.start, rows.stop - 1))
        raise InputError(
            f"{point} is not known both before frame {first} and after frame {last}, so there is "
            "nothing to interpolate between; place it in the first and last frame of the stretch."
        )


def only_within(tracks: Tracks, new: Tracks, edit: Retrack) -> Tracks:
    """Return what was tracked again within its stretch, and the tracks as they were outside.

    Parameters
    ----------
    tracks, new : xarray.Dataset
        The tracks before and after tracking again.
    edit : Retrack
        The correction, with its stretch.

    Returns
    -------
    xarray.Dataset
        The tracks with the new rows of the stretch.

    Raises
    ------
    InputError
        If the new tracks are of other frames.
    """
    frames = tracks["frame"].to_numpy()
    if not np.array_equal(frames, new["frame"].to_numpy()):
        raise InputError(
            f"tracking again from frame {edit.frame} gave other frames; the tracks stay as they "
            "were."
        )
    outside = np.ones(len(frames), dtype=bool)
    outside[rows_of_edit(tracks, edit)] = False
    result = copy_tracks(new)
    for name, was in tracks.data_vars.items():
        if name in result and "time" in was.dims and result[name].dims == was.dims:
            result[name].values[outside] = was.values[outside]
    return result


def _interpolate_view(tracks: Tracks, rows: slice, view: int, point: int) -> bool:
    """Do so in one view; say whether the point is known at both sides there."""
    frames = tracks["frame"].to_numpy().astype(float)
    uv = tracks["image_position"].values[:, view, :, point, 0]
    origin = tracks["image_origin"].values[:, view, point, 0]
    confidence = tracks["image_confidence"].values[:, view, point, 0]
    known = np.isfinite(uv).all(axis=1) & ~np.isin(origin, (MISSING, REPROJECTED))
    within = np.zeros(len(frames), dtype=bool)
    within[rows] = True
    known &= ~within | (origin == EDITED)
    before = np.flatnonzero(known & (np.arange(len(frames)) < rows.start))[-KNOTS_BESIDE:]
    after = np.flatnonzero(known & (np.arange(len(frames)) >= rows.stop))[:KNOTS_BESIDE]
    knots = np.concatenate([before, np.flatnonzero(known & within), after])
    new = np.flatnonzero(within & ~known)
    new = new[(new > knots.min(initial=len(frames))) & (new < knots.max(initial=-1))]
    if not len(new):
        return False
    uv[new] = PchipInterpolator(frames[knots], uv[knots])(frames[new])
    at = np.searchsorted(knots, new)
    confidence[new] = np.minimum(confidence[knots[at - 1]], confidence[knots[at]])
    origin[new] = PREDICTED
    return True


def _views(tracks: Tracks, view: str | None) -> list[int]:
    """Return the places of one view, or of all."""
    return [*range(tracks.sizes["view"])] if view is None else [place_of(tracks, "view", view)]
