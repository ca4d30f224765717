"""What is in place beforehand: clicks, corrections, and tracks that are gone on from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.layout import (
    Layout,
    Placement,
    check_every_point_started,
    read_start,
)
from pawnb.schema import ORIGIN_CODE, Tracks


def read_placements(
    start: pd.DataFrame, layout: Layout, frames: tuple[int, int], *, tracks: Tracks | None
) -> tuple[dict[int, list[Placement]], dict[int, list[Placement]]]:
    """Return what is in place beforehand.

    Parameters
    ----------
    start : DataFrame
        Clicks with columns frame, view, point, u, v (px).
    layout : Layout
        Which point is tracked in which view.
    frames : tuple of int
        First frame and one past the last.
    tracks : Tracks or None
        Tracks to go on from: where they are in the first frame, and what was corrected.

    Returns
    -------
    by_hand, anchors : dict
        Frame to what was placed by hand, and to what tracks must pass through.

    Raises
    ------
    InputError
        If a click does not fit, or without tracks a point has none.
    """
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


def placed_points(placed: Mapping[int, Sequence[Placement]]) -> set[int]:
    """Return the points that are placed in any frame."""
    return {place.point for here in placed.values() for place in here}


def annotated_points(
    placed: Mapping[int, Sequence[Placement]], shape: tuple[int, ...]
) -> BoolArray:
    """Return where (n, P, V) points are certain."""
    certain = np.zeros(shape, dtype=bool)
    for t, here in placed.items():
        for place in here:
            certain[t, place.point, place.view] = True
    return certain


def annotated_positions(
    placed: Mapping[int, Sequence[Placement]], n: int, layout: Layout
) -> FloatArray:
    """Return image positions (n, P, V, 2) that are certain, by row, NaN elsewhere.

    Parameters
    ----------
    placed : mapping
        Row to what is certain there.
    n : int
        Rows.
    layout : Layout
        Points and views.

    Returns
    -------
    ndarray, shape (n, P, V, 2)
        Positions, px; NaN where nothing is certain.
    """
    uv = np.full((n, len(layout.points), len(layout.views), 2), np.nan)
    for t, here in placed.items():
        for place in here:
            uv[t, place.point, place.view] = place.uv
    return uv
