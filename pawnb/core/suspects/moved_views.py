"""Views that do not fit the others over a whole recording: cameras that moved, or are not in step.

Where points are in space is a compromise of the views, and each leaves an offset in each view. A
landmark that was clicked on another place of the skin in one view leaves one of that point; a
camera that has moved leaves the same one of all points. So each point counts once, however many
frames it has, and how much points differ says what a mean over them is worth. A view that shows
things earlier or later than the others leaves offsets that follow the velocity of each point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE, Tracks

_LEAST_OFFSET_PX = 2.5
"""Views are said to be off from here on. Set by hand: in seven real recordings by several cameras
(a fly, a wheel, four of a rat, two of a spider, a board) one view is off by at most 2.2 px with
chances below 0.01 (the spider, in pictures in which it is 400 to 690 px long)."""
_CHANCE_TO_SAY = 0.02
"""Chance, over all views, that points differ so much from each other that they look like this."""
_POINT_SD_PX, _POINT_SD_WORTH = 2.0, 3
"""What is known of how far one point is clicked at different places by view, and worth how many
points: standard deviations are 0.8 to 1.6 px in these recordings, 8 px in a cage."""
_LEAST_SHARE = 0.08
"""Share of an offset in some direction that views leave, at least, where it can be told: along
an epipolar line of two views nothing is left of it."""
_LEAST_REMAINING = 0.2
"""The same of one point, over all its frames."""
_AS_LIKELY = 9.0
"""Views explain offsets equally well where their sums of squares differ by less, in variances:
three standard errors. With 4 another view is named in 6 of 13 cases on the spider whose view was
moved by 3 px, with 9 in 4."""

_LEAST_LAG, _LEAST_LAG_PX, _LEAST_LAG_SDS = 0.25, 1.5, 4.0
"""Lag that is told: in frames, in px at the usual velocity, and in standard errors. Set by hand:
films that were triggered together seem up to 0.14 frames apart (wheel, rat, spider)."""
_BLOCKS, _FEWEST_IN_BLOCK, _FEWEST_BLOCKS = 4, 10, 6
"""The recording of each point is cut into so many blocks, which count as independent."""

_SURE = 0.5
"""Labels that are right with a lower probability do not count."""
_ASTRAY = 3.0
"""Nor those whose views disagree by so many times the median of the point, of at least 0.5 px."""
MOVED_VIEWS = "moved_views"
"""Attribute of tracks: what was found of their views, in words, as JSON."""
_LEAST_TOLD = 1e-9
"""Numerics: share of the diagonal that is added to a matrix, so that it has an inverse."""
_MOST_FRAMES = 600
"""More frames, evenly chosen, say nothing new of a camera."""


@dataclass(frozen=True)
class MovedView:
    """A view that shows all points aside of where the other views put them.

    Parameters
    ----------
    views : tuple of str
        The view; several where it cannot be told which of them it is, as with two cameras.
    offset_px : float
        How far, px.
    n_points : int
        Points that say so.
    """

    views: tuple[str, ...]
    offset_px: float
    n_points: int

    @property
    def brief(self) -> str:
        """What was found."""
        px, points = f"{self.offset_px:.0f} px", f"all {self.n_points} points alike"
        if len(self.views) == 1:
            return f"view {self.views[0]} lies {px} from where the other views put {points}"
        return (
            f"views {', '.join(self.views[:-1])} and {self.views[-1]} lie {px} apart across "
            f"their epipolar lines, in {points}"
        )

    @property
    def sentence(self) -> str:
        """What was found, and what to do; without the full stop."""
        which = "it" if len(self.views) == 1 else "one of them"
        return (
            f"{self.brief}: {which} has moved, or its calibration is off, and places in space are "
            "wrong by more than their standard deviations say; calibrate it again"
        )


@dataclass(frozen=True)
class LaggingView:
    """A view that shows what moves earlier or later than the others.

    Parameters
    ----------
    view : str
        The view.
    lag_frames, lag_ms : float
        By how much it is later, at least: what jitters makes it seem less.
    """

    view: str
    lag_frames: float
    lag_ms: float

    @property
    def brief(self) -> str:
        """What was found."""
        when = "later" if self.lag_frames > 0 else "earlier"
        return (
            f"view {self.view} shows what moves {abs(self.lag_frames):.1f} frames "
            f"({abs(self.lag_ms):.1f} ms) or more {when} than the others"
        )

    @property
    def sentence(self) -> str:
        """What was found, and what to do; without the full stop."""
        return (
            f"{self.brief}: fast points are wrong in space; trigger the cameras together (offset "
            "of a view in trial.toml mends whole frames only)"
        )


def find_moved_views(
    uv: FloatArray, *, rig: Rig, frames: IntArray, fps: float
) -> list[MovedView | LaggingView]:
    """Find a view that is off, and one that is not in step, by where points are seen.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Where points are seen, px, in the order of the rig's views; NaN where they are not.
    rig : Rig
        The calibrated views.
    frames : ndarray of int, shape (n,)
        Their frames, in ascending order.
    fps : float
        Frames per second.

    Returns
    -------
    list of MovedView or LaggingView
        At most one of each; empty where all views fit, or it cannot be told.
    """
    left = _Offsets.of(uv, rig.coefs, frames)
    lagging = _find_lag(left, rig.names, fps)
    if lagging is not None:
        left = left.in_step(rig.names.index(lagging.view), lagging.lag_frames)
    moved = _find_moved(left, rig.names)
    return [found for found in (moved, lagging) if found is not None]


def moved_views_of(tracks: Tracks, rig: Rig | None) -> list[MovedView | LaggingView]:
    """Find the views that do not fit the others over a recording.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    rig : Rig, optional
        The calibrated views; without them, and without image positions, nothing is found.

    Returns
    -------
    list of MovedView or LaggingView
        As :func:`find_moved_views`.
    """
    if rig is None or "image_position" not in tracks or not tracks.sizes["time"]:
        return []
    there = {str(name) for name in tracks["view"].to_numpy()}
    rig = rig.subset(name for name in rig.names if name in there)
    if len(rig.names) < 2:
        return []
    uv = _seen(tracks.sel(view=list(rig.names)))
    frames = tracks["frame"].to_numpy()
    return find_moved_views(uv, rig=rig, frames=frames, fps=float(tracks.attrs["fps"]))


@dataclass(frozen=True)
class _Offsets:
    """What is left in the views where each point is put in space by all of them.

    Parameters
    ----------
    left : ndarray, shape (n, P, 2 V)
        Seen minus projected, px; 0 where not seen.
    remains : ndarray, shape (n, P, 2 V, 2 V)
        What remains of offsets in the views once the place in space has followed them.
    used : ndarray of bool, shape (n, P)
        Which count.
    velocity : ndarray, shape (n, P, V, 2)
        px a frame, NaN where unknown.
    """

    left: FloatArray
    remains: FloatArray
    used: BoolArray
    velocity: FloatArray

    @classmethod
    def of(cls, uv: FloatArray, coefs: FloatArray, frames: IntArray) -> _Offsets:
        """Return those of points seen at uv (n, P, V, 2)."""
        velocity = np.full(uv.shape, np.nan)
        between = np.flatnonzero(frames[2:] - frames[:-2] == 2) + 1
        velocity[between] = (uv[between + 1] - uv[between - 1]) / 2
        shared = np.flatnonzero((np.isfinite(uv[..., 0]).sum(axis=-1) > 1).any(axis=-1))
        step = max(1, -(-len(shared) // _MOST_FRAMES))
        chosen = shared[::step]
        uv, velocity = uv[chosen], velocity[chosen]
        n, P, V, _ = uv.shape
        found = dlt.triangulate(coefs, uv, refine=True)
        seen = np.isfinite(uv).all(axis=-1) & np.isfinite(found.residual_px)[..., None]
        left = np.where(seen[..., None], uv - dlt.project(coefs, found.xyz), 0.0)
        J = Projection(coefs).jacobian(np.nan_to_num(found.xyz)) * seen[..., None, None]
        J = J.reshape(n, P, 2 * V, 3)
        # orthogonal to what a step in space does: the hat matrix of least squares
        follows = (
            J @ np.linalg.inv(_not_singular(np.swapaxes(J, -1, -2) @ J)) @ np.swapaxes(J, -1, -2)
        )
        known = np.repeat(seen.astype(float), 2, axis=-1)[..., None] * np.eye(2 * V)
        residual = found.residual_px
        usual = np.array([np.median(r[np.isfinite(r)]) if np.isfinite(r).any() else 0.0
                          for r in residual.T])  # fmt: skip
        used = residual <= _ASTRAY * np.maximum(usual, 0.5)
        return cls(left.reshape(n, P, 2 * V), known - follows, used, velocity)

    def shown(self, view: int) -> FloatArray:
        """Return (n, P, 2 V) what a view leaves that is one frame early; NaN where unknown."""
        own = self.remains[..., 2 * view : 2 * view + 2]
        return np.einsum("npij,npj->npi", own, self.velocity[:, :, view])

    def in_step(self, view: int, lag_frames: float) -> _Offsets:
        """Return what is left once a view is moved in time."""
        by = self.shown(view)
        known = np.asarray(np.isfinite(by).all(axis=-1))
        left = self.left + lag_frames * np.where(known[..., None], by, 0.0)
        return _Offsets(left, self.remains, self.used & known, self.velocity)


def _not_singular(square: FloatArray) -> FloatArray:
    """Return matrices (..., 3, 3) that have an inverse also where nothing is known."""
    size = np.trace(square, axis1=-2, axis2=-1)[..., None, None]
    return square + np.where(size > 0.0, _LEAST_TOLD * size, 1.0) * np.eye(3)


def _orthogonal(mean: FloatArray, remains: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Return means and what remains of offsets as projections, and the sum of their ranks.

    Where a view sees a point in some frames only, less is left of its offset, on the average.
    """
    values, axes = np.linalg.eigh(remains)
    told = values > _LEAST_REMAINING
    along = np.einsum("pij,pi->pj", axes, mean) * told / np.where(told, values, 1.0)
    projections = (axes * told[:, None]) @ np.swapaxes(axes, -1, -2)
    return np.einsum("pij,pj->pi", axes, along), projections, int(told.sum())


def _find_moved(left: _Offsets, names: Sequence[str]) -> MovedView | None:
    """Return the view that explains best what is left, if chance does not.

    Each point may be clicked on other places by view, off by normal deviates of one variance: what
    is left of them has that variance, too, and the rank of what remains as its degrees of freedom.
    """
    count = left.used.sum(axis=0)
    points = np.flatnonzero(count)
    if not len(points):
        return None
    weight = left.used[:, points] / count[points]
    mean = np.einsum("np,npi->pi", weight, left.left[:, points])
    remains = np.einsum("np,npij->pij", weight, left.remains[:, points])
    mean, remains, rank = _orthogonal(mean, remains)
    fits = [_fit(mean, remains, view) for view in range(len(names))]
    best = min(range(len(names)), key=lambda view: fits[view].squares)
    fit = fits[best]
    rest = max(rank - fit.rank, 0)
    variance = (_POINT_SD_WORTH * _POINT_SD_PX**2 + fit.squares) / (_POINT_SD_WORTH + rest)
    if fit.rank == 0 or fit.n_points < 2 or fit.offset_px < _LEAST_OFFSET_PX:
        return None
    ratio = (float((mean**2).sum()) - fit.squares) / fit.rank / variance
    if f_distribution.sf(ratio, fit.rank, _POINT_SD_WORTH + rest) * len(names) > _CHANCE_TO_SAY:
        return None
    alike = tuple(
        name for name, other in zip(names, fits, strict=True)
        if other.squares - fit.squares < _AS_LIKELY * variance
    )  # fmt: skip
    return MovedView(alike, fit.offset_px, fit.n_points)


@dataclass(frozen=True)
class _Fit:
    """One offset of a view for all points: its length, its rank, what it leaves, its points."""

    offset_px: float
    rank: int
    squares: float
    n_points: int


def _fit(mean: FloatArray, remains: FloatArray, view: int) -> _Fit:
    """Fit an offset of one view to the mean (P, 2 V) that is left of each point."""
    own = slice(2 * view, 2 * view + 2)
    here = remains[:, own, own]
    n_points = int((np.trace(here, axis1=1, axis2=2) > 0.01).sum())
    values, axes = np.linalg.eigh(here.sum(axis=0))
    told = values > _LEAST_SHARE * max(n_points, 1)
    along = (axes.T @ mean[:, own].sum(axis=0))[told] / values[told]
    offset = axes[:, told] @ along
    squares = float(((mean - remains[:, :, own] @ offset) ** 2).sum())
    return _Fit(float(np.linalg.norm(offset)), int(told.sum()), squares, n_points)


def _find_lag(left: _Offsets, names: Sequence[str], fps: float) -> LaggingView | None:
    """Return the view whose lag explains most of what is left, if it is clear."""
    best, found = 0.0, None
    for view, name in enumerate(names):
        products, squares = _against_velocity(left, view)
        if len(squares) < _FEWEST_BLOCKS or not squares.sum() > 0:
            continue
        early = products.sum() / squares.sum()
        off = products - early * squares
        error = np.sqrt((off**2).sum() * len(off) / (len(off) - 1)) / squares.sum()
        speed = np.sqrt(np.nanmean((left.velocity[:, :, view] ** 2).sum(axis=-1)))
        clear = abs(early) > max(_LEAST_LAG, _LEAST_LAG_SDS * error)
        gain = early * products.sum()
        if clear and abs(early) * speed > _LEAST_LAG_PX and gain > best:
            best, found = gain, LaggingView(name, -float(early), -1e3 * float(early) / fps)
    return found


def _against_velocity(left: _Offsets, view: int) -> tuple[FloatArray, FloatArray]:
    """Return sums of products and squares of each block of each point, about its means."""
    shown = left.shown(view)
    known = left.used & np.isfinite(shown).all(axis=-1)
    products, squares = [], []
    for p in range(known.shape[1]):
        rows = np.flatnonzero(known[:, p])
        if len(rows) < _BLOCKS * _FEWEST_IN_BLOCK:
            continue
        for block in np.array_split(rows, _BLOCKS):
            x = shown[block, p] - shown[block, p].mean(axis=0)
            y = left.left[block, p] - left.left[block, p].mean(axis=0)
            products.append(float((x * y).sum()))
            squares.append(float((x * x).sum()))
    return np.array(products), np.array(squares)


def _seen(tracks: Tracks) -> FloatArray:
    """Return where points of all animals were seen (n, P, V, 2), px; NaN where they were not."""
    order = ("time", "keypoint", "individual", "view")
    uv = tracks["image_position"].transpose(*order, "image_space").to_numpy()
    if "image_offset" in tracks:  # image positions are projections there
        uv = uv + tracks["image_offset"].transpose(*order, "image_space").to_numpy()
    # NaN: who digitised points did not say how sure each is
    seen = ~(tracks["image_confidence"].transpose(*order).to_numpy() < _SURE)
    found = [ORIGIN_CODE[name] for name in ("measured", "edited")]
    seen &= np.isin(tracks["image_origin"].transpose(*order).to_numpy(), found)
    n, P, A, V, _ = uv.shape
    return np.where(seen[..., None], uv, np.nan).reshape(n, P * A, V, 2)
