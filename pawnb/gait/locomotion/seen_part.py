"""The part of a recording in which a jointed animal is seen: not where it comes or goes."""

from __future__ import annotations

from typing import Any

import numpy as np

from pawnb.gait.locomotion.pose_body import leg_roots
from pawnb.schema import ORIGIN_CODE, Tracks

_LEAST_LEGS_SHARE = 0.5
"""An animal of which fewer of its legs are seen is not yet, or no longer, in the picture. Set by
hand: of an animal that enters, the legs that are not there are placed up to a leg's length away."""
_UNSEEN = [ORIGIN_CODE["predicted"], ORIGIN_CODE["missing"]]


def seen_part(tracks: Tracks) -> tuple[Tracks, list[dict[str, Any]]]:
    """Leave out the ends of tracks of a jointed animal in which too few of its legs are seen.

    A tracker gives a pose from the first frame on in which something of the animal is there. Its
    other legs are placed by their neighbours alone, and would make steps that nobody has seen.
    Between frames with the animal, where a leg may be hidden for a while, nothing is left out.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; others than those of a jointed animal are returned as they are.

    Returns
    -------
    tracks : xarray.Dataset
        The tracks from the first to the last frame in which half of the legs are seen.
    dropped : list of dict
        What is left out: leg, start_s, end_s, what, why.
    """
    if "heading" not in tracks:
        return tracks, []
    points = [str(point) for point in tracks["keypoint"].to_numpy()]
    tips = list(leg_roots(points))
    origin = tracks["origin"].sel(keypoint=tips).transpose("time", "keypoint", "individual")
    seen = ~np.isin(origin.to_numpy(), _UNSEEN)
    ever = seen.any(axis=0).sum(axis=0)  # of an animal that lacks legs, those it has
    enough = (seen.sum(axis=1) >= np.maximum(1, _LEAST_LEGS_SHARE * ever)).any(axis=1)
    rows = np.flatnonzero(enough)
    if not len(rows):
        return tracks, []
    begin, stop = int(rows[0]), int(rows[-1]) + 1
    time, dropped = tracks["time"].to_numpy(), []
    for first, last in ((0, begin - 1), (stop, len(time) - 1)):
        if first <= last:
            span = {"start_s": float(time[first]), "end_s": float(time[last])}
            why = "fewer than half of the legs are seen"
            dropped.append({"leg": "", **span, "what": "frames", "why": why})
    return tracks.isel(time=slice(begin, stop)), dropped
