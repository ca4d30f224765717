"""Which way is forward, and which way up."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.locomotion.feet_heading import heading_of_feet
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.kinematics import main_axis, swing_direction, travel_direction
from pawnb.trial import Trial

_STRAIGHT = 0.9
"""Progress of the animal on the ground, as a share of its way, below which its heading turns."""

MOST_ASIDE_DEG = 15.0
"""Feet may go so far aside of forward: lengths are 3.4 % short there (by hand; those of rendered
mice go 3 to 4 degrees aside, for they are also lifted, and those of a single leg 8)."""

LEAST_LIFT = 0.03
"""A swing that is lower than the stance by this share of its length is upside down (by hand)."""


def find_up(trial: Trial | None, feet: FootPaths) -> FloatArray | None:
    """Find the direction upwards.

    Parameters
    ----------
    trial : Trial or None
        Description of the trial.
    feet : FootPaths
        The feet.

    Returns
    -------
    ndarray, shape (3,), or None
        Unit vector in calibrated space; None in a picture, where up cannot be told.
    """
    if feet.positions.shape[1] != 3:
        return None
    if trial is not None and trial.calibration is not None:
        return np.array(trial.calibration.up)
    return np.array([0.0, 0.0, 1.0])


def choose_direction(
    feet: FootPaths,
    path: FloatArray,
    *,
    trial: Trial | None,
    forward: FloatArray | None,
    treadmill: bool,
    cutoff_hz: float,
    fs_hz: float,
) -> tuple[FloatArray, list[str]]:
    """Choose the direction towards the front.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    path : ndarray, shape (n, d)
        Low-passed path of the body.
    trial : Trial or None
        Description of the trial.
    forward : ndarray, shape (d,), or None
        Direction stated by the caller; it comes before all others.
    treadmill : bool
        On the ground the animal faces where it goes; along a path that bends its heading
        turns with its feet (:mod:`pawnb.gait.locomotion.feet_heading`). On a treadmill the
        direction is the trial's in calibrated space, the view's ``facing`` in a picture, or told
        from the swing of the feet.
    cutoff_hz : float
        Low-pass of the body's turns.
    fs_hz : float
        Sampling rate.

    Returns
    -------
    direction : ndarray, shape (d,), or (n, d) where it turns
        Towards the front.
    notes : list of str
        Where it was derived, and what looks wrong.

    Raises
    ------
    InputError
        If ``forward`` is not a direction in this space.
    """
    n_dims = feet.positions.shape[1]
    who = feet.label
    if forward is not None:
        if forward.shape != (n_dims,) or not np.linalg.norm(forward) > 0:
            raise InputError(
                f"forward is {forward.tolist()}; expected {n_dims} numbers that are not all zero."
            )
        return forward, []
    if not treadmill:
        direction, straight = travel_direction(path, up=find_up(trial, feet))
        if straight < _STRAIGHT:
            return _turning(
                feet,
                path,
                direction,
                straight,
                up=find_up(trial, feet),
                cutoff_hz=cutoff_hz,
                fs_hz=fs_hz,
            )
        return direction, []
    from_feet = swing_direction(feet.positions, fs_hz=fs_hz)
    facing = image_facing(trial, feet.source) if n_dims == 2 else None
    if n_dims == 3:
        calibration = trial.calibration if trial is not None else None
        stated = np.array(calibration.forward if calibration else (1.0, 0.0, 0.0))
    elif facing is not None:
        stated = np.array([float(facing), 0.0])
    else:
        side = _say_direction(from_feet)
        return from_feet, [f"{who}: the animal faces {side}, told from the swing of its feet."]
    if stated @ from_feet < -0.5:
        return stated, [
            f"{who}: the feet swing fastest backwards; is forward = {stated.tolist()} "
            "(or facing) the wrong way round?"
        ]
    return stated, _doubt_axes(trial, feet, stated, from_feet) if n_dims == 3 else []


def _turning(
    feet: FootPaths,
    path: FloatArray,
    direction: FloatArray,
    straight: float,
    *,
    up: FloatArray | None,
    cutoff_hz: float,
    fs_hz: float,
) -> tuple[FloatArray, list[str]]:
    """Return the heading along a path that is not straight, from the feet where it can be told."""
    said = f"{feet.label}: the path is not straight ({straight:.0%} of its length is progress); "
    heading = heading_of_feet(feet.positions, path, up=up, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    if heading is None:
        return direction, [
            said
            + "all of it is seen along one direction, from its beginning to its end: where the "
            "animal turns or goes back, strides are missed, and lengths, speeds and duty factors "
            "are wrong. Name points of the body in [animal] body for a heading that turns."
        ]
    return heading, [
        said + "the heading turns as the feet do about each other, and its front is where the "
        "animal goes on the whole. Name points of the body, rear to front, in [animal] body for a "
        "better one."
    ]


def _doubt_axes(
    trial: Trial | None, feet: FootPaths, forward: FloatArray, from_feet: FloatArray
) -> list[str]:
    """Say how far the feet's way is from forward, and whether they are lifted downwards.

    Axes of a calibration by a board or a wand need not be those of the animal.
    """
    places = feet.positions - np.nanmean(feet.positions, axis=0)
    axis = main_axis(places)
    is_told = abs(axis @ from_feet) > 0.7  # which end of it is in front
    axis = axis * np.sign(axis @ (from_feet if is_told else forward))
    turned_deg = float(np.degrees(np.arccos(np.clip(axis @ forward, -1.0, 1.0))))
    notes = []
    if turned_deg > MOST_ASIDE_DEG:
        x, y, z = (round(float(number), 3) + 0.0 for number in axis)
        notes.append(
            f"{feet.label}: the feet go to and fro {turned_deg:.0f} degrees aside of forward = "
            f"{forward.tolist()}, so that lengths along forward come out wrong; if the axes are "
            "those of a board or wand and not of the animal, write into trial.toml [calibration] "
            f"forward = [{x}, {y}, {z}]{'' if is_told else ', or the opposite of it,'} and up."
        )
    up = find_up(trial, feet)
    if up is not None and is_told:
        along, height = (np.einsum("ndk,d->nk", places, way) for way in (axis, up))
        speed, height = np.diff(along, axis=0), (height[1:] + height[:-1]) / 2
        lift = float(np.nanmean(height[speed > 0]) - np.nanmean(height[speed < 0]))
        if lift < -LEAST_LIFT * float(np.nanpercentile(along, 95) - np.nanpercentile(along, 5)):
            notes.append(
                f"{feet.label}: the feet are lower in swing than in stance by {-lift:.3g} (mean); "
                f"is up = {up.tolist()} the wrong way round?"
            )
    return notes


def _say_direction(direction: FloatArray) -> str:
    """Name a direction in a picture."""
    if abs(direction[0]) >= abs(direction[1]):
        return "right" if direction[0] > 0 else "left"
    return "down" if direction[1] > 0 else "up"


def image_facing(trial: Trial | None, source: str) -> int | None:
    """Look up which way the animal faces in a picture.

    Parameters
    ----------
    trial : Trial or None
        Description of the trial.
    source : str
        Name of a view, or ``"position"`` for the only view of an uncalibrated trial.

    Returns
    -------
    int or None
        +1 right, -1 left, None where the trial does not say.
    """
    if trial is None:
        return None
    if source == "position":
        return trial.views[0].facing if len(trial.views) == 1 else None
    return next((v.facing for v in trial.views if v.name == source), None)
