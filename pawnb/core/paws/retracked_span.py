"""The stretch that a correction touches: what is tracked again, and what stays.

A correction of some points in a frame touches these points only, from that frame on to the
next frame in which a person put the point in place, or to where the new track has met the
old one. Other points and all other frames keep their rows.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr
from scipy.ndimage import binary_dilation, label

from pawnb.arrays import BoolArray, FloatArray, IntArray, Points2D
from pawnb.schema import ORIGIN_CODE, Tracks

TOLERANCE_PX = 2.0
"""Tracks as near as this in every view are the same, in pictures 2048 px wide."""

_FAR_OF_TOLERANCE = 10.0
"""A point has left its place where it is so many tolerances away: 20 px, half a paw."""

MET_FRAMES = 10
"""The new track has met the old one after so many frames in a row on it."""


class Stretch:
    """Which points are still being tracked again, row by row.

    Parameters
    ----------
    uv : ndarray, shape (n, V, P, 2)
        The old tracks, px; NaN where missing.
    by_hand : ndarray of bool, shape (n, V, P)
        Where a person put a point in place.
    here : int
        The corrected row. Where nothing was put in place in it, every point is tracked
        again to the end.
    tolerance_px : ndarray, shape (V,)
        Distance within which tracks are the same.

    Attributes
    ----------
    idle : ndarray of bool, shape (P,)
        Points that keep their rows from the current one on.
    until : ndarray of int, shape (P,)
        One past the last row that each point was tracked again in.
    """

    def __init__(
        self, uv: Points2D, by_hand: BoolArray, here: int, *, tolerance_px: FloatArray
    ) -> None:
        self._uv, self._tolerance = uv, tolerance_px
        self._placed: np.ndarray = np.asarray(by_hand.any(axis=1))
        touched = np.asarray(self._placed[here])
        self._ends = bool(touched.any())
        self.idle = ~touched if self._ends else np.zeros(len(touched), dtype=bool)
        self.until = np.full(len(touched), here)
        # corrections in the frames right after this one belong to it
        self._opening = touched.copy()
        self._met = np.zeros(len(touched), dtype=int)

    @property
    def is_over(self) -> bool:
        """Whether no point is left to track again."""
        return bool(self.idle.all())

    def enter(self, row: int) -> None:
        """Let points rest from a row on where a person has put them in place by hand."""
        if self._ends:
            placed = self._placed[row]
            self.idle |= placed & ~self._opening
            self._opening &= placed

    def leave(self, row: int, uv: Points2D) -> None:
        """Take in where the points are now, (V, P, 2): those back on the old track rest."""
        self.until[~self.idle] = row + 1
        if not self._ends:
            return
        old = self._uv[row]
        there = np.isfinite(uv).all(axis=-1), np.isfinite(old).all(axis=-1)
        with np.errstate(invalid="ignore"):
            near = np.linalg.norm(uv - old, axis=-1) <= self._tolerance[:, None]
        same = np.where(there[0] & there[1], near, ~there[0] & ~there[1]).all(axis=0)
        seen = there[1].any(axis=0)
        self._met = np.where(same, self._met + seen, 0)
        self.idle |= self._met >= MET_FRAMES


def keep_rows(old: Tracks, new: Tracks, keep: BoolArray) -> Tracks:
    """Copy rows of single points from old tracks, and all their times and attributes.

    Parameters
    ----------
    old : Tracks
        What there was. Frames, views and points that it lacks are left as they are new.
    new : Tracks
        The new tracks.
    keep : ndarray of bool, shape (n, P)
        Which rows of which points of ``new`` are to be as in ``old``.

    Returns
    -------
    Tracks
        The new tracks with the old rows.
    """
    rows = pd.Index(old["frame"].to_numpy()).get_indexer(new["frame"].to_numpy())
    shared = rows >= 0
    keep = keep & shared[:, None]
    joined = {}
    for name, own in new.data_vars.items():
        if name in old.data_vars and "keypoint" in own.dims:
            was = _values_in(old[name], own, rows)
            axes = [axis for axis, d in enumerate(own.dims) if d not in ("time", "keypoint")]
            kept = np.expand_dims(keep, axes)
            joined[name] = own.copy(data=np.where(kept, was, own.to_numpy()).astype(own.dtype))
    time = new["time"].to_numpy().copy()
    time[shared] = old["time"].to_numpy()[rows[shared]]
    return new.assign(joined).assign_coords(time=time).assign_attrs(old.attrs)


def _values_in(old: xr.DataArray, new: xr.DataArray, rows: IntArray) -> np.ndarray:
    """Return old values in the order of new ones, in rows of the old ones.

    What the old ones lack, or say nothing of, is 0 in counts and confidences, else NaN.
    """
    values = old.transpose(*new.dims).to_numpy()
    lacking = np.zeros(new.shape, bool)
    for axis, dim in enumerate(new.dims):
        if dim != "time" and not (dim in old.indexes and dim in new.indexes):
            continue
        order = rows if dim == "time" else old.indexes[dim].get_indexer(new.indexes[dim])
        values = values.take(order, axis=axis)
        lacking |= np.expand_dims(order < 0, [other for other in range(new.ndim) if other != axis])
    counted = new.dtype.kind == "i" or "confidence" in str(new.name)
    if counted and values.dtype.kind == "f":
        lacking |= np.isnan(values)
    return np.where(lacking, 0 if counted else np.nan, values)


def keep_untouched(
    old: Tracks,
    new: Tracks,
    frame: int,
    *,
    tolerance_px: Mapping[str, float],
    joint: bool = False,
) -> Tracks:
    """Keep of new tracks only the stretch that the corrections in a frame touch.

    Parameters
    ----------
    old : Tracks
        Tracks with the corrections applied.
    new : Tracks
        The same frames tracked again from ``frame`` on; changed in place.
    frame : int
        The corrected frame.
    tolerance_px : mapping
        For each view, the distance within which tracks are the same.
    joint : bool
        Whether all points were decided together: then a point that was where a corrected
        one is tracked again to takes its new rows, too, about where it has moved away from
        there, up to the next frame in which it was put in place. Where one paw was taken for
        another, setting one right sets the other right.

    Returns
    -------
    Tracks
        New where the correction touches it, else old.
    """
    views = new["view"].to_numpy().tolist()
    axes = ("time", "view", "keypoint")
    was = old.isel(individual=0).swap_dims(time="frame").reindex(
        frame=new["frame"].to_numpy(), view=views, keypoint=new["keypoint"].to_numpy(),
        fill_value={"image_origin": ORIGIN_CODE["missing"]},
    )  # fmt: skip
    axes_was = ("frame", *axes[1:])
    uv = was["image_position"].transpose(*axes_was, "image_space").to_numpy()
    origin = was["image_origin"].transpose(*axes_was).to_numpy()
    by_hand = origin == ORIGIN_CODE["edited"]
    flat = new.isel(individual=0)
    now = flat["image_position"].transpose(*axes, "image_space").to_numpy()
    # what only shows a position in space tells nothing of its own
    shown = origin == ORIGIN_CODE["reprojected"]
    shown |= flat["image_origin"].transpose(*axes).to_numpy() == ORIGIN_CODE["reprojected"]
    uv, now = (np.where(shown[..., None], np.nan, x) for x in (uv, now))
    here = int(np.flatnonzero(new["frame"].to_numpy() == frame)[0])
    tolerance = np.array([tolerance_px[view] for view in views])
    stretch = Stretch(uv, by_hand, here, tolerance_px=tolerance)
    for row in range(here, len(now)):
        stretch.enter(row)
        if stretch.is_over:
            break
        stretch.leave(row, now[row])
    rows = np.arange(len(now))[:, None]
    keep = (rows < here) | (rows >= stretch.until)
    if joint:
        anew = (rows >= here) & (rows < stretch.until)
        limit = _FAR_OF_TOLERANCE * tolerance
        made_way = _made_way(uv, now, by_hand.any(axis=1), here, anew=anew, limit=limit)
        keep &= ~_with_room(made_way, uv, now, anew=anew, limit=limit)
    return keep_rows(old, new, keep)


def _made_way(
    uv: Points2D,
    now: FloatArray,
    placed: BoolArray,
    here: int,
    *,
    anew: BoolArray,
    limit: FloatArray,
) -> BoolArray:
    """Tell about which rows (n, P) points have left a place that a corrected point has taken.

    ``limit`` (V,) is the distance within which two places are the same. A corrected point takes
    places only in the rows ``anew`` (n, P) that it was tracked again in: in its other rows it is
    on its old track.
    """
    with np.errstate(invalid="ignore"):
        left = (np.linalg.norm(now - uv, axis=-1) > limit[:, None]).any(axis=1)
        taken = np.zeros_like(left)
        for point in np.flatnonzero(placed[here]):
            away = np.linalg.norm(now[:, :, [point]] - uv, axis=-1)
            near = (away <= limit[:, None]) | np.isnan(away)
            there = near.all(axis=1) & np.isfinite(away).any(axis=1)
            taken |= there & anew[:, [point]]
    made_way = left & taken
    made_way[:here] = False
    made_way = binary_dilation(made_way, np.ones((2 * MET_FRAMES + 1, 1), bool))
    made_way[:here] = False
    later = placed.copy()
    later[: here + 1] = False
    return np.asarray(made_way & ~np.logical_or.accumulate(later, axis=0))


def _with_room(
    made_way: BoolArray, uv: Points2D, now: FloatArray, *, anew: BoolArray, limit: FloatArray
) -> BoolArray:
    """Leave out the stretches in which a point that made way would share another point's place.

    The tracker takes back what a person has exchanged: one of the two alone must not follow it.
    Points that only cross are in one place in less than half of a stretch.
    """
    n_points = made_way.shape[1]
    made_way = made_way.copy()
    while True:
        staying = ~anew & ~made_way
        crowded = np.zeros_like(made_way)
        for other in range(n_points):
            with np.errstate(invalid="ignore"):
                away = np.linalg.norm(now - uv[:, :, [other]], axis=-1)  # (n, V, P)
            near = ((away <= limit[:, None]) | np.isnan(away)).all(axis=1)
            near &= np.isfinite(away).any(axis=1) & staying[:, [other]]
            near[:, other] = False
            crowded |= near
        left_out = np.zeros_like(made_way)
        for point in range(n_points):
            runs, n_runs = label(made_way[:, point])
            for run in range(1, n_runs + 1):
                rows = runs == run
                left_out[rows, point] = crowded[rows, point].mean() > 0.5
        if not left_out.any():
            return made_way
        made_way &= ~left_out
