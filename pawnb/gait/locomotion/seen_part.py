"""The part of a recording in which an animal is seen: not where it comes or goes, or is frozen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pawnb.gait.locomotion.pose_body import leg_roots
from pawnb.schema import ORIGIN_CODE, Tracks

_LEAST_LEGS_SHARE = 0.5
"""An animal of which fewer of its legs are seen is not yet, or no longer, in the picture. Set by
hand: of an animal that enters, the legs that are not there are placed up to a leg's length away."""
_FEWEST_FRAMES = 3
"""Frames that an analysis needs at least."""
_UNSEEN = [ORIGIN_CODE["predicted"], ORIGIN_CODE["missing"]]


def _without_unseen_frames(tracks: Tracks, feet: Sequence[str]) -> Tracks:
    """Return tracks without positions in frames that show nothing of an animal.

    Where a film stands still every foot is predicted, with no confidence at all. Taken for a
    path, such feet stand, and one stride reaches over two.
    """
    order = ("time", "keypoint", "individual")
    own = tracks[["origin", "confidence"]].sel(keypoint=list(feet)).transpose(*order)
    origin, sure = own["origin"].to_numpy(), own["confidence"].to_numpy()
    is_blind = (origin == ORIGIN_CODE["predicted"]) & (sure == 0.0)
    is_gone = origin == ORIGIN_CODE["missing"]
    rows = np.flatnonzero((is_blind | is_gone).all(axis=(1, 2)) & is_blind.any(axis=(1, 2)))
    if not len(rows):
        return tracks
    tracks = tracks.copy(deep=True)
    for name in ("position", "image_position", "joint_angle"):
        if name in tracks:
            tracks[name].values[rows] = np.nan
    return tracks


def seen_part(
    tracks: Tracks, *, feet: Sequence[str] = (), least: float = 0.0
) -> tuple[Tracks, list[dict[str, Any]]]:
    """Leave out what shows nothing of an animal, and where too little of a jointed one is seen.

    Frames in which every foot is predicted without confidence, as where a film stands still, have
    no position in any case. The ends go in which no foot has a place: how much of a film goes on
    before and after an animal must not change its gait. Of a jointed animal those go in which too
    few legs are seen.

    A tracker gives a pose from the first frame on in which something of the animal is there. Its
    other legs are placed by their neighbours alone, and would make steps that nobody has seen.
    Between frames with the animal, where a leg may be hidden for a while, nothing is left out. A
    leg that is not seen up to some frame, or from one on, has no foot and no angles there.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    feet : sequence of str
        Points that are feet; of a jointed animal these are the tips of its legs.
    least : float
        Places with a lower confidence do not count; of a jointed animal they do.

    Returns
    -------
    tracks : xarray.Dataset
        The tracks from the first to the last frame in which a foot is seen; of a jointed animal
        in which half of the legs are, without what comes before a leg is seen first and after it
        is seen last.
    dropped : list of dict
        What is left out: leg, start_s, end_s, what, why.
    """
    if "heading" not in tracks:
        return (
            _with_feet(_without_unseen_frames(tracks, feet), feet, least) if feet else (tracks, [])
        )
    points = [str(point) for point in tracks["keypoint"].to_numpy()]
    tips = list(leg_roots(points))
    tracks = _without_unseen_frames(tracks, tips)
    origin = tracks["origin"].sel(keypoint=tips).transpose("time", "keypoint", "individual")
    seen = ~np.isin(origin.to_numpy(), _UNSEEN)
    ever = seen.any(axis=0).sum(axis=0)  # of an animal that lacks legs, those it has
    enough = (seen.sum(axis=1) >= np.maximum(1, _LEAST_LEGS_SHARE * ever)).any(axis=1)
    rows = np.flatnonzero(enough)
    if not len(rows):
        return tracks, []
    begin, stop = int(rows[0]), int(rows[-1]) + 1
    why = "fewer than half of the legs are seen"
    dropped = _say_ends(tracks["time"].to_numpy(), begin, stop, leg="", why=why)
    part = tracks.isel(time=slice(begin, stop))
    ends = _unseen_ends(np.any(seen[begin:stop], axis=2))
    if not ends:
        return part, dropped
    part, time = part.copy(deep=True), part["time"].to_numpy()
    for place, (first, end) in ends.items():
        leg = tips[place]
        outside = np.r_[0:first, end : len(time)]
        _take_away(part, leg, outside)
        dropped += _say_ends(time, first, end, leg=leg, why="the leg is not seen")
    return part, dropped


def _with_feet(
    tracks: Tracks, feet: Sequence[str], least: float
) -> tuple[Tracks, list[dict[str, Any]]]:
    """Leave out the ends in which no foot has a place, unless hardly a frame would be left."""
    seen = np.zeros(tracks.sizes["time"], dtype=bool)
    own = tracks.sel(keypoint=list(feet))
    for name, sure, axis in (
        ("position", "confidence", "space"),
        ("image_position", "image_confidence", "image_space"),
    ):
        if name in own:
            placed = own[name].notnull().all(axis) & ~(own[sure] < least)
            seen |= placed.any([dim for dim in placed.dims if dim != "time"]).to_numpy()
    rows = np.flatnonzero(seen)
    if not len(rows) or rows[-1] - rows[0] + 1 < _FEWEST_FRAMES:
        return tracks, []
    begin, stop = int(rows[0]), int(rows[-1]) + 1
    why = "no foot is seen"
    return (
        tracks.isel(time=slice(begin, stop)),
        _say_ends(tracks["time"].to_numpy(), begin, stop, leg="", why=why),
    )


def _unseen_ends(seen: np.ndarray) -> dict[int, tuple[int, int]]:
    """Return, of each leg unseen at an end, its first row seen and one past its last.

    ``seen`` has a row a frame and a column a leg; a leg never seen has no rows.
    """
    ends = {}
    for place, column in enumerate(seen.T):
        rows = np.flatnonzero(column)
        first, stop = (int(rows[0]), int(rows[-1]) + 1) if len(rows) else (len(column), len(column))
        if first > 0 or stop < len(column):
            ends[place] = (first, stop)
    return ends


def _take_away(tracks: Tracks, leg: str, rows: np.ndarray) -> None:
    """Take away foot and joint angles of a leg in some rows of tracks, which are changed."""
    at = [str(point) for point in tracks["keypoint"].to_numpy()].index(leg)
    for name in ("position", "image_position"):
        tracks[name].values[rows, ..., at, :] = np.nan
    for name in ("origin", "image_origin"):
        tracks[name].values[rows, ..., at, :] = ORIGIN_CODE["missing"]
    if "joint_angle" in tracks:
        own = [str(joint).startswith(f"{leg}_") for joint in tracks["joint"].to_numpy()]
        tracks["joint_angle"].values[np.ix_(rows, np.flatnonzero(own))] = np.nan


def _say_ends(
    time_s: np.ndarray, begin: int, stop: int, *, leg: str, why: str
) -> list[dict[str, Any]]:
    """Return a row for what lies before ``begin`` and one for what lies from ``stop`` on."""
    ends = ((0, begin - 1), (stop, len(time_s) - 1))
    return [
        {"leg": leg, "start_s": float(time_s[first]), "end_s": float(time_s[last]),
         "what": "frames", "why": why}
        for first, last in ends
        if first <= last
    ]  # fmt: skip
