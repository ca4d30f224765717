"""Clicks that seem to be exchanged between points or views, to be of one point, or disagree."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.dlt import Triangulation
from pawnb.core.rig import Rig

MAX_CLICK_RESIDUAL_PX = 10.0
"""Clicks of one point in several views may disagree by so much."""

_AGREE_BETTER, _LIE_NEARER = 0.7, 0.7
"""Exchanged, clicks of two points agree better and all points lie nearer to each other: shares of
what they do as they are. Set by hand: points that are exchanged in one of two cameras at one side
agree within 3 px, 150 mm apart across a mouse of 60 mm; those that are not come no nearer."""
_DISAGREE_PX, _MUCH_BETTER = 3.0, 1 / 3
"""Two views that are exchanged, or clicks in three views or more, disagree by so much, RMS, and by
less than that share of it once put right."""

_ONE_PLACE_PX = 1.5
"""Clicks of two points that lie nearer are of one place: a click is no more exact."""

Clicks = Mapping[tuple[str, str], tuple[float, float]]
"""View and point to u, v in px, of one frame."""


def tell_exchanged(rig: Rig, clicks: Clicks) -> list[str]:
    """Say which views, or which points in a view, seem to be exchanged in one frame.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    clicks : mapping of (str, str) to tuple of float
        View and point to u, v in px.

    Returns
    -------
    list of str
        At most one sentence: of views if they are, else of the points that fit best exchanged.
    """
    points = [p for p in dict.fromkeys(p for _, p in clicks) if sum(q == p for _, q in clicks) > 1]
    if len(points) < 2:
        return []
    uv = {p: _of_point(rig, clicks, p) for p in points}
    views = _exchanged_views(rig, uv)
    if views is not None:
        a, b = views
        return [
            f"views {a} and {b} fit each other's calibration: their films, or their columns in "
            "the calibration, seem to be exchanged"
        ]
    found = _exchanged_points(rig, uv)
    if found is None:
        return []
    first, second, seen = found
    return [
        f"{first} and {second} seem to be exchanged in {' or '.join(seen)}: their clicks agree "
        "better, and lie nearer to the other points, with these names the other way round there"
    ]


def tell_exchanged_clicks(rig: Rig, clicks: pd.DataFrame) -> list[str]:
    """Say which clicks of a table (frame, view, point, u, v) seem to be exchanged.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    clicks : pandas.DataFrame
        The start clicks.

    Returns
    -------
    list of str
        A sentence for each frame with such clicks.
    """
    said = []
    for frame, group in clicks.groupby("frame", sort=True):
        rows = group[["view", "point", "u", "v"]].itertuples(index=False, name=None)
        own = {(str(view), str(point)): (float(u), float(v)) for view, point, u, v in rows}
        said += [f"start clicks of frame {frame}: {text}" for text in tell_exchanged(rig, own)]
    return said


def tell_one_place(clicks: pd.DataFrame) -> list[str]:
    """Say which two points are clicked on one place in every view that both are clicked in.

    Parameters
    ----------
    clicks : pandas.DataFrame
        The start clicks: frame, view, point, u, v.

    Returns
    -------
    list of str
        A sentence for each such pair of a frame.
    """
    said = []
    for frame, group in clicks.groupby("frame", sort=True):
        u, v = (
            group.pivot_table(index="view", columns="point", values=name) for name in ("u", "v")
        )
        for a, b in combinations(dict.fromkeys(group["point"]), 2):
            apart = np.hypot(u[a] - u[b], v[a] - v[b]).dropna()
            if len(apart) and (apart < _ONE_PLACE_PX).all():
                said.append(
                    f"start clicks of frame {frame}: {a} and {b} lie on one place in "
                    f"{' and '.join(map(str, apart.index))}: one of them seems to be clicked on "
                    "the other; where it is hidden behind it, leave its click out there"
                )
    return said


def solve_clicks(rig: Rig, clicks: pd.DataFrame) -> dict[tuple[int, str], Triangulation]:
    """Return where clicked points are in space.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    clicks : pandas.DataFrame
        The start clicks: frame, view, point, u, v.

    Returns
    -------
    dict of (int, str) to Triangulation
        Frame and point to its place; NaN where fewer than two views have it.
    """
    solved = {}
    for (frame, point), group in clicks.groupby(["frame", "point"], sort=True):
        rows = group[["view", "u", "v"]].itertuples(index=False, name=None)
        own = {(str(view), str(point)): (float(u), float(v)) for view, u, v in rows}
        solved[int(str(frame)), str(point)] = rig.triangulate(_of_point(rig, own, str(point)))
    return solved


def tell_disagreeing_clicks(solved: Mapping[tuple[int, str], Triangulation]) -> list[str]:
    """Say which points are clicked in places that no one place in space is projected to.

    Parameters
    ----------
    solved : mapping of (int, str) to Triangulation
        Of :func:`solve_clicks`.

    Returns
    -------
    list of str
        A sentence for each frame with such points.
    """
    far: dict[int, dict[str, float]] = {}
    for (frame, point), place in solved.items():
        if (off := float(place.residual_px)) > MAX_CLICK_RESIDUAL_PX:
            far.setdefault(frame, {})[point] = off
    return [
        f"start clicks of {', '.join(own)} in frame {frame} disagree between the views by "
        f"{'up to ' if len(own) > 1 else ''}{max(own.values()):.0f} px: one of them is on another "
        "point, or the calibration is off"
        for frame, own in far.items()
    ]


def _of_point(rig: Rig, clicks: Clicks, point: str) -> FloatArray:
    """Return where a point is clicked in each view (n_views, 2), px; NaN where it is not."""
    nowhere = (np.nan, np.nan)
    return np.array([clicks.get((view, point), nowhere) for view in rig.names], float)


def _solve(rig: Rig, uv: Mapping[str, FloatArray]) -> dict[str, Triangulation]:
    """Return the place of each point in space."""
    return {point: rig.triangulate(own) for point, own in uv.items()}


def _residual_px(solved: Mapping[str, Triangulation]) -> float:
    """Return the RMS residual of all points, px."""
    return float(np.sqrt(np.mean([float(one.residual_px) ** 2 for one in solved.values()])))


def _exchanged_views(rig: Rig, uv: Mapping[str, FloatArray]) -> tuple[str, str] | None:
    """Return the two views that fit well once exchanged; None where all do as they are."""
    before = _residual_px(_solve(rig, uv))
    if not before > _DISAGREE_PX:
        return None
    best, found = min(before * _MUCH_BETTER, _DISAGREE_PX), None
    for i, j in combinations(range(len(rig.names)), 2):
        order = list(range(len(rig.names)))
        order[i], order[j] = j, i
        after = _residual_px(_solve(rig, {point: own[order] for point, own in uv.items()}))
        if after < best:
            best, found = after, (rig.names[i], rig.names[j])
    return found


def _exchanged_points(rig: Rig, uv: Mapping[str, FloatArray]) -> tuple[str, str, list[str]] | None:
    """Return two points, and the views in which they seem exchanged; of two views it is either."""
    solved = _solve(rig, uv)
    before, apart = _residual_px(solved), _widest(solved)
    best, found = before * _AGREE_BETTER, None
    for first, second in combinations(uv, 2):
        both = np.isfinite(uv[first][:, 0]) & np.isfinite(uv[second][:, 0])
        for k in np.flatnonzero(both):
            two = {first: uv[first].copy(), second: uv[second].copy()}
            two[first][k], two[second][k] = uv[second][k], uv[first][k]
            exchanged = {**solved, **_solve(rig, two)}
            after = _residual_px(exchanged)
            # of three views or more two show which click of the third is wrong
            in_two = int(both.sum()) == 2
            clear = not in_two and before > _DISAGREE_PX and after < _MUCH_BETTER * before
            if after < best and (clear or _widest(exchanged) < _LIE_NEARER * apart):
                best = after
                alike = np.flatnonzero(both) if in_two else [k]
                found = first, second, [rig.names[i] for i in alike]
    return found


def _widest(solved: Mapping[str, Triangulation]) -> float:
    """Return the largest distance of two points."""
    places = [one.xyz for one in solved.values()]
    return max(float(np.linalg.norm(a - b)) for a, b in combinations(places, 2))
