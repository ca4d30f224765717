"""The place in space of a corrected point, from where the views see it."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray, Points2D, Points3D
from pawnb.core.edits.hand_placed import views_in_force
from pawnb.core.edits.stretches import EDITED, MISSING, PREDICTED, REPROJECTED
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks

MEASURED, RESOLVED = ORIGIN_CODE["measured"], ORIGIN_CODE["resolved"]


class RigLike(Protocol):
    """What is asked of a rig; :class:`pawnb.core.rig.Rig` has it."""

    @property
    def names(self) -> Any:
        """Names of its views."""

    def triangulate(self, uv: Points2D) -> Any:
        """Return xyz (..., 3) and residual_px (...) of uv (..., V, 2)."""

    def project(self, xyz: Points3D) -> Points2D:
        """Return uv (..., V, 2) of xyz (..., 3)."""

    def nearest_in_sight(self, name: str, uv: Points2D, *, xyz: FloatArray) -> FloatArray:
        """Return the point that a view sees at some place and that is nearest to another point.

        Parameters
        ----------
        name : str
            The view.
        uv : ndarray, shape (2,)
            Where it sees the point, px.
        xyz : ndarray, shape (3,)
            The other point, in the unit of the calibration.

        Returns
        -------
        ndarray, shape (3,)
            The nearest point that is seen there.
        """


class PositionSolver:
    """Computes 3D positions again, in place, for some rows and points."""

    def __init__(self, tracks: Tracks, rig: RigLike | None, px_per_unit: float | None) -> None:
        flat = tracks.sizes["space"] == 2
        if rig is None and not flat:
            raise InputError(
                "these tracks are in 3D, and no calibration was given to compute a corrected "
                "point again; open them with their trial, or give rig=."
            )
        self.tracks, self.rig, self.px_per_unit = tracks, None if flat else rig, px_per_unit

    def __call__(self, rows: IntArray, points: list[int], *, keep_depth: bool = False) -> None:
        """Solve these rows (n,) and points (p,) again from their image positions.

        Parameters
        ----------
        rows : ndarray of int, shape (n,)
            Which rows.
        points : list of int
            Which points.
        keep_depth : bool
            Whether a point that one view only sees stays as far from its camera as it was, which
            is what the tracker gives points of one view. Not for what was taken away,
            exchanged or interpolated: the place came from what was wrong.
        """
        t = self.tracks
        at = np.ix_(rows, np.asarray(points))
        # (n, p, V, 2) and (n, p, V)
        uv = np.moveaxis(t["image_position"].values[rows][:, :, :, points, 0], (1, 2), (2, 3))
        origin = np.moveaxis(t["image_origin"].values[rows][:, :, points, 0], 1, 2)
        confidence = np.moveaxis(t["image_confidence"].values[rows][:, :, points, 0], 1, 2)
        used = usable_views(uv, origin)
        if self.rig is None:
            xyz, residual, used = self._first_view(uv, used)
            best = _best(origin, used)
        else:
            used = self._in_force(self.rig, uv, used=used, by_hand=origin == EDITED)
            xyz, residual, used = triangulate_views(t, self.rig, uv, used=used)
            best = _best(origin, used)
            if keep_depth:
                alone = used & (used.sum(axis=-1, keepdims=True) == 1)
                was = np.moveaxis(t["position"].values[rows][:, :, points, 0], 1, 2)
                xyz = self._in_sight(self.rig, uv, alone=alone, was=was, otherwise=xyz)
                best = np.where(alone.any(axis=-1) & (best != PREDICTED), RESOLVED, best)
        there = np.isfinite(xyz).all(axis=-1)
        t["position"].values[at[0], :, at[1], 0] = xyz
        t["residual"].values[at[0], at[1], 0] = residual
        count = np.maximum(used.sum(axis=-1), 1)
        t["confidence"].values[at[0], at[1], 0] = np.where(
            there, np.where(used, confidence, 0).sum(axis=-1) / count, 0.0
        )
        t["origin"].values[at[0], at[1], 0] = np.where(there, best, MISSING)
        # the tracker's doubts do not describe what a person placed
        if "sd" in t:
            t["sd"].values[at[0], :, at[1], 0] = np.nan
        if "revision" in t:
            t["revision"].values[at[0], at[1], 0] = np.nan
        if "passes_apart" in t:
            t["passes_apart"].values[at[0], at[1], 0] = np.nan
        for name in ("image_residual", "image_separation", "image_offset"):
            if name in t:
                t[name].values[at[0], :, ..., at[1], 0] = np.nan
        self._refresh_reprojected(rows, points, xyz, origin)

    def _in_force(
        self, rig: RigLike, uv: Points2D, *, used: BoolArray, by_hand: BoolArray
    ) -> BoolArray:
        """Leave out tracked views that disagree with two or more in which a person placed it."""

        def triangulate(own: Points2D, counts: BoolArray) -> tuple[AnyArray, AnyArray]:
            return triangulate_views(self.tracks, rig, own, used=counts)[:2]

        return views_in_force(
            uv, used=used, by_hand=by_hand, triangulate=triangulate, project=self._project
        )

    def _project(self, xyz: Points3D) -> FloatArray:
        """Return where the views see places in space; NaN in those that the rig does not have."""
        views = [str(name) for name in self.tracks["view"].to_numpy()]
        projected = np.full((*xyz.shape[:-1], len(views), 2), np.nan)
        if self.rig is not None:
            places = [views.index(name) for name in self.rig.names if name in views]
            keep = [name in views for name in self.rig.names]
            projected[..., places, :] = np.asarray(self.rig.project(xyz))[..., keep, :]
        return projected

    def _in_sight(
        self, rig: RigLike, uv: Points2D, *, alone: BoolArray, was: FloatArray,
        otherwise: FloatArray,
    ) -> FloatArray:  # fmt: skip
        """Put points that one view only sees into its sight, nearest to where they were."""
        xyz, views = otherwise.copy(), self.tracks["view"].to_numpy()
        for i, j, view in np.argwhere(alone & np.isfinite(was).all(axis=-1, keepdims=True)):
            xyz[i, j] = rig.nearest_in_sight(str(views[view]), uv[i, j, view], xyz=was[i, j])
        return xyz

    def _first_view(
        self, uv: Points2D, used: BoolArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Without a calibration, the image position in the first view that has the point."""
        first = used.argmax(axis=-1)[..., None]
        only = used & (np.arange(used.shape[-1]) == first)
        xy = np.take_along_axis(uv, first[..., None], axis=2)[:, :, 0]
        xy = np.where(used.any(axis=-1, keepdims=True), xy, np.nan) / (self.px_per_unit or 1.0)
        return xy, np.full(xy.shape[:-1], np.nan), only

    def _refresh_reprojected(
        self, rows: IntArray, points: list[int], xyz: FloatArray, origin: IntArray
    ) -> None:
        """Move the image positions that only show the 3D point in views not tracking it."""
        follow = origin == REPROJECTED
        if self.rig is None or not follow.any():
            return
        projected = self._project(xyz)
        n, p, view = np.nonzero(follow)
        target = self.tracks["image_position"].values
        target[rows[n], view, :, np.asarray(points)[p], 0] = projected[n, p, view]


def usable_views(uv: Points2D, origin: IntArray) -> BoolArray:
    """Tell which views count for a 3D point.

    Parameters
    ----------
    uv : ndarray, shape (..., V, 2)
        Image positions, px; NaN where missing.
    origin : ndarray of int, shape (..., V)
        Origin codes of :mod:`pawnb.schema`.

    Returns
    -------
    ndarray of bool, shape (..., V)
        Views that see the point (measured, resolved, edited). Where fewer than two do,
        predicted positions count as well; a reprojected one never does, since it comes
        from the 3D point itself.
    """
    there = np.isfinite(uv).all(axis=-1) & (origin != REPROJECTED) & (origin != MISSING)
    seen = there & (origin != PREDICTED)
    return np.where(seen.sum(axis=-1, keepdims=True) >= 2, seen, there)


def triangulate_views(
    tracks: Tracks, rig: RigLike, uv: Points2D, *, used: BoolArray
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Triangulate image positions that are in the order of the views of the tracks.

    Parameters
    ----------
    tracks : xarray.Dataset
        For the names of the views.
    rig : Rig
        The calibrated views, in any order.
    uv : ndarray, shape (..., V, 2)
        Image positions, px.
    used : ndarray of bool, shape (..., V)
        Which of them count.

    Returns
    -------
    xyz : ndarray, shape (..., 3)
        Positions in the unit of the rig; NaN with fewer than two views.
    residual_px : ndarray, shape (...)
        RMS reprojection error over the views used, px.
    used : ndarray of bool, shape (..., V)
        ``used`` without the views that the rig does not have.
    """
    views = [str(name) for name in tracks["view"].to_numpy()]
    known = np.array([name in set(rig.names) for name in views])
    used = used & known
    in_rig = np.full((*uv.shape[:-2], len(rig.names), 2), np.nan)
    for place, name in enumerate(rig.names):
        if name in views:
            view = views.index(name)
            in_rig[..., place, :] = np.where(used[..., view, None], uv[..., view, :], np.nan)
    found = rig.triangulate(in_rig)
    enough = used.sum(axis=-1) >= 2
    xyz = np.where(enough[..., None], np.asarray(found.xyz), np.nan)
    return xyz, np.where(enough, np.asarray(found.residual_px), np.nan), used


def _best(origin: IntArray, used: BoolArray) -> IntArray:
    """Return the origin of a 3D point: the strongest among the views it was made from."""
    result = np.full(origin.shape[:-1], PREDICTED, dtype=origin.dtype)
    for code in (RESOLVED, MEASURED, EDITED):
        result = np.where(((origin == code) & used).any(axis=-1), code, result)
    return result
