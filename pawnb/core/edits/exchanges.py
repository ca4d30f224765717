"""Exchanges that a person made hold when the trial is tracked again."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.edits.records import Swap
from pawnb.core.edits.stretches import place_of, row_of, rows_of_edit
from pawnb.schema import ORIGIN_CODE, Tracks

_UNSEEN_PX = 50.0
"""A point that is known in one of two tracks only counts as so far apart. Set by hand."""


def exchange_again(
    tracks: Tracks,
    new: Tracks,
    swaps: Iterable[Swap],
    *,
    frame: int,
    exchange: Callable[[Tracks, Swap], Tracks],
) -> Tracks:
    """Exchange two points again where tracking again has taken back what a person exchanged.

    The tracker decides by what it sees which point is which, as it did when it was wrong. A row
    counts as taken back where the two new places fit the two old ones better crosswise. Rows in
    which one of the two was put in place by hand keep the other, too. A pair of which a point was
    put in ``frame`` where the other was is left alone: a person has changed their mind.

    Parameters
    ----------
    tracks, new : xarray.Dataset
        The tracks before and after tracking again.
    swaps : iterable of Swap
        All exchanges so far.
    frame : int
        The frame from which it was tracked again.
    exchange : callable
        ``exchange(tracks, swap)`` returns tracks with an exchange made.

    Returns
    -------
    xarray.Dataset
        The new tracks with the exchanges.
    """
    if not np.array_equal(tracks["frame"], new["frame"]):
        return new
    views = [str(name) for name in tracks["view"].to_numpy()]
    for (first, second), turned in _exchanged_rows(tracks, swaps, views).items():
        pair = [place_of(tracks, "keypoint", name) for name in (first, second)]
        was, now = (t["image_position"].values[..., pair, 0] for t in (tracks, new))
        placed = tracks["image_origin"].values[..., pair, 0] == ORIGIN_CODE["edited"]
        if _mind_changed(was, turned, placed, row_of(tracks, frame)):
            continue
        by_hand = placed.any(axis=2)
        everywhere = turned.all(axis=1) & ~by_hand.any(axis=1)
        found: list[tuple[str | None, BoolArray]] = [(None, everywhere & _is_crosswise(was, now))]
        for v, name in enumerate(views):
            alone = turned[:, v] & ~turned.all(axis=1) & ~by_hand[:, v]
            found.append((name, alone & _is_crosswise(was[:, [v]], now[:, [v]])))
        for view, rows in found:
            for begin, stop in _runs(rows, tracks["frame"].to_numpy()):
                swap = Swap(frame=begin, stop=stop, first=first, second=second, view=view)
                new = exchange(new, swap)
        _keep_beside_placed(tracks, new, pair, np.asarray(turned.all(axis=1)))
    return new


def _keep_beside_placed(tracks: Tracks, new: Tracks, pair: list[int], turned: BoolArray) -> None:
    """Put a point back, in place, in rows in which its partner was put in place by hand.

    There nothing is exchanged; the point has followed the tracker to where its partner is.
    """
    for point, partner in (pair, pair[::-1]):
        was, now = (t["image_position"].values[..., [point], 0] for t in (tracks, new))
        other = tracks["image_position"].values[..., [partner], 0]
        placed = tracks["image_origin"].values[..., [point, partner], 0] == ORIGIN_CODE["edited"]
        beside = placed[..., 1].any(axis=1) & ~placed[..., 0].any(axis=1)
        away, near = (_distance(place, now).sum(axis=(1, 2)) for place in (was, other))
        rows = np.flatnonzero(turned & beside & (near < away))
        for name, own in new.data_vars.items():
            if name in tracks and {"time", "keypoint"} <= set(own.dims):
                at: list[Any] = [slice(None)] * own.ndim
                at[own.dims.index("time")], at[own.dims.index("keypoint")] = rows, point
                own.values[tuple(at)] = tracks[name].values[tuple(at)]


def _exchanged_rows(
    tracks: Tracks, swaps: Iterable[Swap], views: list[str]
) -> dict[tuple[str, str], BoolArray]:
    """Return for each pair of points in which rows and views (n, V) they are exchanged."""
    found: dict[tuple[str, str], BoolArray] = {}
    for swap in swaps:
        a, b = sorted((swap.first, swap.second))
        turned = found.setdefault((a, b), np.zeros((tracks.sizes["time"], len(views)), bool))
        own = slice(None) if swap.view is None else views.index(swap.view)
        turned[rows_of_edit(tracks, swap), own] ^= True
    return found


def _mind_changed(was: FloatArray, turned: BoolArray, placed: BoolArray, row: int) -> bool:
    """Tell whether a point was put by hand where the other of its pair is just before or after."""
    beside = [r for r in (row - 1, row + 1) if 0 <= r < len(was)]
    for r, point in itertools.product(beside, range(2)):
        views = placed[row, :, point] & turned[row] & turned[r]
        own, other = (
            np.linalg.norm(was[row, views, :, point] - was[r, views, :, p], axis=-1)
            for p in (point, 1 - point)
        )
        if np.nansum(other) < np.nansum(own):
            return True
    return False


def _is_crosswise(was: FloatArray, now: FloatArray) -> BoolArray:
    """Tell in which rows two points (n, V, 2 px, 2 points) fit better with their places changed."""
    straight, cross = (_distance(was, other).sum(axis=(1, 2)) for other in (now, now[..., ::-1]))
    return np.asarray(cross < straight)


def _distance(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return distances (n, V, 2 points), px; 0 where both are unknown."""
    known = np.isfinite(one).all(axis=2), np.isfinite(other).all(axis=2)
    far = np.linalg.norm(one - other, axis=2)
    return np.where(known[0] & known[1], far, np.where(known[0] | known[1], _UNSEEN_PX, 0.0))


def _runs(rows: BoolArray, frames: np.ndarray) -> list[tuple[int, int]]:
    """Return first frame and one past the last of each run of rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]])))
    return [(int(frames[a]), int(frames[b - 1]) + 1) for a, b in edges.reshape(-1, 2)]
