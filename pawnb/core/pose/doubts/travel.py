"""Whether an animal goes to where its head is."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses

TRAVEL_FRAMES = (4, 8, 16, 32)
"""So many frames before and after a frame it is looked where the animal goes, the nearest first."""
_TRAVEL_BODIES, _BACKWARDS = 0.25, -0.7
"""It goes somewhere once it is a quarter of its body's length further, and backwards where the
cosine of the angle to its heading is below this. By hand: it is 0.995 and more in eleven frames of
a rendered spider, and never below in eleven of a real walking fly (flies-topview), of which nine
are found once they are turned about."""
_MOSTLY = 0.5
"""An animal goes backwards in a recording that does so in more of the frames in which it goes."""


def is_backwards(way: FloatArray, heading_deg: float, *, body_px: float) -> bool | None:
    """Tell whether an animal has gone to its rear.

    Parameters
    ----------
    way : ndarray, shape (2,)
        How far its body went, px.
    heading_deg : float
        Direction of the body, degrees from +u towards +v.
    body_px : float
        Length of the body, px.

    Returns
    -------
    bool or None
        None where it went nowhere.
    """
    length, turn = float(np.hypot(*way)), np.radians(heading_deg)
    if not length >= _TRAVEL_BODIES * body_px:
        return None
    return bool(way @ [np.cos(turn), np.sin(turn)] < _BACKWARDS * length)


def goes_backwards(animal: StickAnimal, poses: Poses) -> bool:
    """Tell whether an animal goes to its rear in most frames of a recording in which it goes.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses, frames ascending; NaN where it is not there.

    Returns
    -------
    bool
        False where it goes nowhere.
    """
    known = poses.take(np.flatnonzero(np.isfinite(poses.xy).all(axis=1)))
    told = [is_so for t in range(len(known)) if (is_so := _at(animal, known, t)) is not None]
    return bool(told) and float(np.mean(told)) > _MOSTLY


def _at(animal: StickAnimal, poses: Poses, row: int) -> bool | None:
    """Tell whether an animal goes backwards about one row of its poses."""
    frame, body_px = int(poses.frames[row]), animal.body_length * float(poses.scale[row])
    for apart in TRAVEL_FRAMES:
        first = int(np.searchsorted(poses.frames, frame - apart))
        last = int(np.searchsorted(poses.frames, frame + apart, side="right")) - 1
        way = poses.xy[last] - poses.xy[first]
        told = is_backwards(way, float(poses.heading_deg[row]), body_px=body_px)
        if told is not None:
            return told
    return None
