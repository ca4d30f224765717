"""What the feet stand on: how fast it runs, and how fast feet move over it."""

from __future__ import annotations

import math

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.events.extremes import Extreme, stance_velocity, stance_velocity_over_time
from pawnb.gait.legs import find_leg_place
from pawnb.gait.locomotion.foot_trajectories import FootPaths

_SLIP_ALLOWED = 0.15
_CARRIED_OTHERWISE = 0.5
"""Share by which a foot in stance may differ from the feet on the whole and still stand on the
belt: one in the air does not go back, and a ball turns under each side at a speed of its own."""

_SIDES_APART = 0.2
"""Share of their mean by which feet of the left and of the right go back at speeds of their own. By
hand: split belts run at 1.5 to 1 and more; perspective of a side view makes near feet some percent
faster than far ones."""


def find_belt_speed(
    feet: FootPaths,
    velocity: FloatArray,
    extremes: list[list[Extreme]],
    *,
    stated: FloatArray | None,
    treadmill: bool,
) -> tuple[FloatArray | None, list[str]]:
    """Find how fast the substrate runs backwards.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    velocity : ndarray, shape (n, k)
        Their velocities along forward, in the laboratory.
    extremes : list of list of Extreme
        AEP and PEP of each.
    stated : ndarray, shape (n,), or None
        Belt speed in the trial's unit per second; None where unknown.
    treadmill : bool
        Whether the animal runs on a treadmill or ball, and not on the ground.

    Returns
    -------
    belt : ndarray, shape (n,), or None
        In the unit of the positions per second: ``stated`` itself where it can be used, 0 on the
        ground, else what the feet do in stance, from stance to stance, on the mean of the feet.
        None where no foot goes backwards in stance.
    notes : list of str
        What was taken from the feet, and where they disagree with what is stated.
    """
    n = len(velocity)
    if not treadmill:
        return np.zeros(n), []
    who = feet.label
    stance = [stance_velocity(v, e) for v, e in zip(velocity.T, extremes, strict=True)]
    known = [s for s in stance if math.isfinite(s)]
    own = -float(np.median(known)) if known else math.nan
    split = _say_split(feet, stance)
    if stated is not None:
        usual = float(np.median(stated))
        if not math.isfinite(own) or abs(own - usual) <= _SLIP_ALLOWED * abs(usual):
            return stated, split
        if feet.unit != "px":
            return stated, [
                f"{who}: feet in stance go backwards at {own:.4g} {feet.unit}/s where the belt "
                f"is said to run at {usual:.4g}; check belt_speed and its unit. Contact is told "
                "from the feet's own stance; speed and stride length use the stated belt speed.",
                *split,
            ]
    if not (math.isfinite(own) and own > 0):
        return None, []
    why = f"none is known in {feet.unit}/s."
    if stated is not None:
        why = (
            f"the stated one, {usual:.4g}, does not fit them in px/s and is taken to be in another "
            "unit: px_per_unit below [calibration] brings both to one."
        )
    note = (
        f"{who}: belt speed about {own:.4g} {feet.unit}/s, taken from the feet in stance, stride "
        f"by stride, because {why}"
    )
    carried = [abs(s + own) <= _CARRIED_OTHERWISE * own for s in stance]  # not where s is NaN
    off = [
        leg
        for leg, s, with_it in zip(feet.legs, stance, carried, strict=True)
        if math.isfinite(s) and not with_it
    ]
    if off:
        note += (
            f" {', '.join(off)} {'are' if len(off) > 1 else 'is'} carried otherwise and not "
            "counted: does the foot stand on the belt?"
        )
    local = [
        stance_velocity_over_time(v, e)
        for v, e, with_it in zip(velocity.T, extremes, carried, strict=True)
        if with_it
    ]
    if not local:
        return np.full(n, own), [note, *split]
    return -np.mean(local, axis=0), [note, *split]


def _say_split(feet: FootPaths, stance: list[float]) -> list[str]:
    """Say where feet of one side go back in stance at another speed than those of the other."""
    sides: dict[str, list[tuple[str, float]]] = {"L": [], "R": []}
    for leg, speed in zip(feet.legs, stance, strict=True):
        place = find_leg_place(leg)
        if place is not None and math.isfinite(speed):
            sides[place.side].append((leg, -speed))
    speeds = [[speed for _, speed in sides[side]] for side in "LR"]
    if not all(speeds):
        return []
    left, right = (float(np.median(own)) for own in speeds)
    apart = abs(left - right)
    alike = max(float(np.ptp(own)) for own in speeds) < apart / 2.0
    if not alike or apart <= _SIDES_APART * (left + right) / 2.0:
        return []
    alone = " and ".join(f"--legs {' '.join(leg for leg, _ in sides[side])}" for side in "LR")
    return [
        f"{feet.label}: in stance feet of the left go backwards at {left:.4g} {feet.unit}/s and "
        f"those of the right at {right:.4g}, as on split belts or in a turn. One speed stands for "
        "all legs in speed and stride_length; phases and durations are right. For lengths over "
        f"each belt analyse each side by itself ({alone}, without a belt_speed or with its own)."
    ]


def speed_over_substrate(
    velocity: FloatArray, belt: FloatArray, extremes: list[Extreme], *, follow: bool
) -> FloatArray:
    """Compute the speed of a foot relative to what it stands on.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Velocity of the foot along forward, in the laboratory.
    belt : ndarray, shape (n,)
        Speed of the substrate backwards.
    extremes : list of Extreme
        AEP and PEP of the foot.
    follow : bool
        Whether the substrate under this foot may run at its own speed from stance to stance, as
        that of a ball does, which turns under one side faster than under the other. Otherwise a
        foot's own speed in stance is taken off only where it is too large to be slip.

    Returns
    -------
    ndarray, shape (n,)
        The speed; 0 in the middle of stance.
    """
    over = velocity + belt
    if follow:
        return over - np.nan_to_num(stance_velocity_over_time(over, extremes))
    slip = stance_velocity(over, extremes)
    return over - (slip if abs(slip) > _SLIP_ALLOWED * abs(float(np.median(belt))) > 0 else 0.0)
