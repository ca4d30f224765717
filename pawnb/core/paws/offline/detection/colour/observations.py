"""What every view shows in every frame: candidates as positions of each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.detection.colour.label_offsets import Offsets
from pawnb.core.paws.offline.detection.colour.likelihood import Judge
from pawnb.core.paws.offline.detection.colour.padding import side_by_side
from pawnb.core.paws.offline.projection import Geometry


@dataclass(frozen=True)
class Sights:
    """Candidates of n frames, V views and P points, at most C in a picture.

    Parameters
    ----------
    raw : ndarray, shape (n, V, C, 2)
        The candidates, px.
    at : ndarray, shape (n, P, V, C, 2)
        Where each says that each point is, px.
    quality : ndarray, shape (n, V, C)
        How much each looks like the end of a paw, 0 to 1.
    is_there : ndarray of bool, shape (n, V, C)
        False where a picture has fewer candidates.
    """

    raw: np.ndarray
    at: np.ndarray
    quality: np.ndarray
    is_there: np.ndarray

    def only(self, frame: int) -> Sights:
        """Return one frame of them, n = 1."""
        one = slice(frame, frame + 1)
        return Sights(self.raw[one], self.at[one], self.quality[one], self.is_there[one])


def read_sights(
    found: Sequence[Sequence[np.ndarray]],
    offsets: Offsets | Sequence[Offsets],
    *,
    facing: Sequence[int],
    judge: Judge,
) -> Sights:
    """Return what candidates say.

    Parameters
    ----------
    found : sequence
        Candidates of every frame and view.
    offsets : Offsets or sequence of Offsets
        Where the tracked points lie relative to them, in all views or in each.
    facing : sequence of int
        +1 or -1 for each view.
    judge : Judge
        Tells how much candidates look like paws.

    Returns
    -------
    Sights
        Positions and qualities.
    """
    rows, is_there = side_by_side(found)
    n, n_views, most = is_there.shape
    by_view = [offsets] * n_views if isinstance(offsets, Offsets) else offsets
    n_points = len(by_view[0].along)
    quality = np.empty((n, n_views, most))
    at = np.empty((n, n_points, n_views, most, 2))
    for v in range(n_views):
        flat = rows[:, v].reshape(-1, rows.shape[-1])
        quality[:, v] = judge.likeness(flat, v).reshape(n, -1)
        for p in range(n_points):
            moved = by_view[v].apply(
                flat, p, thickness_px=judge.thickness_px[v], facing=facing[v] or 1
            )
            at[:, p, v] = moved.reshape(n, -1, 2)
    return Sights(rows[..., :2].astype(float), at, quality, is_there)


def tracked_points(
    places: np.ndarray,
    sights: Sights,
    *,
    geometry: Geometry,
    thickness_px: np.ndarray,
    view: int | None = None,
) -> np.ndarray:
    """Return where the tracked points are of places made of candidates.

    Parameters
    ----------
    places : ndarray, shape (n, P, d)
        Places where candidates meet, NaN where there is none.
    sights : Sights
        What the candidates say.
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view; candidates within it of a place belong to it.
    view : int, optional
        The only view whose candidates the places are made of; default all.

    Returns
    -------
    ndarray, shape (n, P, d)
        The places, each moved by what its candidates say on average.
    """
    which = np.ones(len(thickness_px), bool)
    if view is not None:
        which = np.arange(len(thickness_px)) == view
    known = np.isfinite(places[..., 0])
    x = np.nan_to_num(places)
    away = np.linalg.norm(sights.raw[:, None] - geometry.project(x)[..., None, :], axis=-1)
    away = np.where(sights.is_there[:, None], away / thickness_px[:, None], np.inf)
    nearest = away.argmin(axis=-1)[..., None]
    near = (np.take_along_axis(away, nearest, axis=-1)[..., 0] < 1.0) & which
    step = sights.at - sights.raw[:, None]
    step = np.take_along_axis(step, nearest[..., None], axis=3)[:, :, :, 0]
    J = geometry.jacobian(x) * np.where(near, 1.0, 0.0)[..., None, None]
    normal = np.einsum("npvik,npvil->npkl", J, J, optimize=True)
    # what one view alone does not tell stays as it is
    size = np.trace(normal, axis1=-2, axis2=-1)[..., None, None]
    normal = normal + (0.01 * size + 1e-9) * np.eye(x.shape[-1])
    target = np.einsum("npvik,npvi->npk", J, step, optimize=True)
    moved = x + np.linalg.solve(normal, target[..., None])[..., 0]
    return np.where(known[..., None], moved, np.nan)
