"""What the feet stand on: how fast it runs, and the ways of body and feet over it."""

from __future__ import annotations

import math

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.events.extremes import Extreme, stance_velocity, stance_velocity_over_time
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.grid import Grid
from pawnb.gait.strides.stride_table import Motion
from pawnb.kinematics import BodyFrame

_SLIP_ALLOWED = 0.15
_CARRIED_OTHERWISE = 0.5
"""Share by which a foot in stance may differ from the feet on the whole and still stand on the
belt: one in the air does not go back, and a ball turns under each side at a speed of its own."""


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
    if stated is not None:
        usual = float(np.median(stated))
        if not math.isfinite(own) or abs(own - usual) <= _SLIP_ALLOWED * abs(usual):
            return stated, []
        if feet.unit != "px":
            return stated, [
                f"{who}: feet in stance go backwards at {own:.4g} {feet.unit}/s where the belt "
                f"is said to run at {usual:.4g}; check belt_speed and its unit. Contact is told "
                "from the feet's own stance; speed and stride length use the stated belt speed."
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
        return np.full(n, own), [note]
    return -np.mean(local, axis=0), [note]


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


def measure_motion(
    feet: FootPaths, frame: BodyFrame, *, lab: FloatArray, belt: FloatArray | None, grid: Grid
) -> Motion:
    """Sum up how far body and feet have come relative to the ground or belt.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    frame : BodyFrame
        Path and heading of the body.
    lab : ndarray, shape (n, k)
        Positions of the feet along forward.
    belt : ndarray, shape (n,), or None
        Speed of the substrate backwards; None where unknown.
    grid : Grid
        The samples.

    Returns
    -------
    Motion
        Distances from an arbitrary zero; unknown without the belt's speed.
    """
    steps = np.einsum("nd,nd->n", np.diff(frame.path, axis=0), frame.forward[:-1])
    if belt is None:
        unknown = np.full(len(lab), np.nan)
        return Motion(time_s=grid.time_s, body=unknown)
    rolled = np.concatenate(([0.0], np.cumsum((belt[1:] + belt[:-1]) / 2.0) / grid.fs_hz))
    known = np.isfinite(frame.path).all(axis=1)
    body = np.concatenate(([0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0)))) + rolled
    return Motion(
        time_s=grid.time_s,
        heading_deg=_heading_deg(frame.forward),
        body=np.where(known, body, np.nan),
        feet={leg: lab[:, k] + rolled for k, leg in enumerate(feet.legs)},
    )


def _heading_deg(forward: FloatArray) -> FloatArray:
    """Return the direction of unit vectors, not wrapped, bridged where it is not known."""
    heading = np.arctan2(forward[:, 1], forward[:, 0])
    known = np.flatnonzero(np.isfinite(heading))
    if not len(known):
        return np.full(len(heading), np.nan)
    return np.degrees(np.interp(np.arange(len(heading)), known, np.unwrap(heading[known])))
