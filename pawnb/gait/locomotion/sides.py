"""How far feet are to the animal's right, also where it is seen from below or in a mirror."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.legs import find_leg_place
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.kinematics import BodyFrame


def place_across(
    feet: FootPaths, frame: BodyFrame, *, up: FloatArray | None
) -> tuple[FloatArray, list[str]]:
    """Return how far feet are to the animal's right.

    A picture does not tell whether it is taken from above, or from below or in a mirror, where
    right is on the other side of forward: the names of the legs do.

    Parameters
    ----------
    feet : FootPaths
        The feet of one space.
    frame : BodyFrame
        Their body frame.
    up : ndarray, shape (3,), or None
        Direction upwards, in space; None in a picture.

    Returns
    -------
    across : ndarray, shape (n, k)
        Positive to the right, in the unit of the positions. In a picture right is where the
        right legs are, and as seen from above where that is not clear.
    notes : list of str
        What is said of a picture from below, and of right legs that are on the left in space.
    """
    across = frame.lateral(feet.positions, up=up)
    if not _right_is_left(across, feet.legs):
        return across, []
    if up is None:
        return -across, [
            f"{feet.label}: the legs named right are on the left of the animal if it is seen from "
            "above. It is taken to be seen from below, or in a mirror; if it was filmed from "
            "above, the names of left and right are exchanged."
        ]
    return across, [
        f"{feet.label}: the legs named right are on the left of the animal. Are the names of left "
        "and right exchanged, or does up or forward point the other way ([calibration] up, "
        "forward), or is space mirrored? Phases and what is said of left and right legs are those "
        "of the other ones then."
    ]


def _right_is_left(across: FloatArray, legs: tuple[str, ...]) -> bool:
    """Say whether right legs are to the left of left ones, by more than each moves across.

    In a view from the side they are not: right and left are apart by 0.1 of the standard deviation
    of a leg there (a mouse by LocoMouse), by 1.8 to 8 in views from below (that mouse, and one
    in an open field).
    """
    middles: dict[str, list[float]] = {"R": [], "L": []}
    spreads = []
    for leg, column in zip(legs, across.T, strict=True):
        place, known = find_leg_place(leg), column[np.isfinite(column)]
        if place is not None and len(known):
            middles[place.side].append(float(np.median(known)))
            spreads.append(float(known.std()))
    if not all(middles.values()):
        return False
    to_the_left = np.mean(middles["L"]) - np.mean(middles["R"])
    return bool(to_the_left > np.median(spreads))
