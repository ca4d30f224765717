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

MOST_TILTED_DEG = 50.0
"""Feet may be lifted so far aside of up. Set by hand: four recordings of a rat are 1 to 12 degrees
off, 20 with the legs of one side alone, a fly on a ball, whose feet go on a sphere, 40 to 44."""


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
    return stated, _doubt_forward(feet, stated, from_feet) if n_dims == 3 else []


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


def _doubt_forward(feet: FootPaths, forward: FloatArray, from_feet: FloatArray) -> list[str]:
    """Say how far the feet's way is from forward.

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
    return notes


def doubt_up(
    feet: FootPaths,
    path: FloatArray,
    *,
    up: FloatArray | None,
    treadmill: bool,
    forward: FloatArray | None = None,
) -> list[str]:
    """Say where feet are lifted, or the animal goes, along another direction than they can.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    path : ndarray, shape (n, d)
        Low-passed path of the body.
    up : ndarray, shape (3,), or None
        Upwards; None in a picture, of which nothing is said.
    treadmill : bool
        Whether the animal runs in one place.
    forward : ndarray, shape (d,), optional
        Towards the front, as :func:`choose_direction` gives it. Where the feet of an animal that
        runs in one place seem to swing the other way, nothing is said of how they are lifted.

    Returns
    -------
    list of str
        The notes: axes of a camera, a board or a wand are not those of the animal.
    """
    if up is None:
        return []
    places = feet.positions - path[:, :, None]
    way = main_axis(places - np.nanmean(places, axis=0)) if treadmill else _way(path)
    notes = [] if treadmill or way is None else _doubt_level(feet, way, up)
    lift = _lift(feet, places, path, way=way, treadmill=treadmill, forward=forward)
    if lift is None:
        return notes
    aside_deg = float(np.degrees(np.arccos(np.clip(lift @ up / np.linalg.norm(lift), -1.0, 1.0))))
    if aside_deg > 180.0 - MOST_TILTED_DEG:
        notes.append(
            f"{feet.label}: the feet are lower in swing than in stance by {-lift @ up:.3g} (mean); "
            f"is up = {up.tolist()} the wrong way round?"
        )
    elif aside_deg > MOST_TILTED_DEG:
        x, y, z = (round(float(number), 3) + 0.0 for number in lift / np.linalg.norm(lift))
        notes.append(
            f"{feet.label}: in swing the feet are lifted {aside_deg:.0f} degrees aside of up = "
            f"{up.tolist()}, so that heights and places to the side are wrong, and lengths where "
            "the animal goes along up; if the axes are those of a camera, board or wand, write "
            f"into trial.toml [calibration] up = [{x}, {y}, {z}], and forward."
        )
    return notes


def _way(path: FloatArray) -> FloatArray | None:
    """Return the direction in which an animal goes straight, or None where it does not."""
    way, straight = travel_direction(path)
    return way if straight > _STRAIGHT else None


def _doubt_level(feet: FootPaths, way: FloatArray, up: FloatArray) -> list[str]:
    """Say where an animal climbs, or goes down, more steeply than it would on the ground."""
    slope_deg = float(np.degrees(np.arcsin(np.clip(way @ up, -1.0, 1.0))))
    if abs(slope_deg) <= MOST_ASIDE_DEG:
        return []
    return [
        f"{feet.label}: the animal goes {'up' if slope_deg > 0 else 'down'} by "
        f"{abs(slope_deg):.0f} degrees where up = {up.tolist()}, and lengths are level, "
        f"{1 - np.cos(np.radians(slope_deg)):.0%} shorter than its way; unless it climbs, the axes "
        "are those of a camera, board or wand: write the right up into trial.toml [calibration]."
    ]


def _lift(
    feet: FootPaths,
    places: FloatArray,
    path: FloatArray,
    *,
    way: FloatArray | None,
    treadmill: bool,
    forward: FloatArray | None,
) -> FloatArray | None:
    """Return from where to where feet are lifted in swing, the mean of legs; None if hardly so."""
    if treadmill and way is not None:
        front = swing_direction(feet.positions, fs_hz=1.0)
        against = forward is not None and forward.ndim == 1 and forward @ front < 0.0
        if against or abs(way @ front) <= 0.7:  # which end of it is in front cannot be told
            return None
        swings = np.diff(np.einsum("ndk,d->nk", places, way * np.sign(way @ front)), axis=0) > 0.0
    else:  # on the ground a foot in swing is faster than the body, and one in stance slower
        speed = np.linalg.norm(np.diff(feet.positions, axis=0), axis=1)
        swings = speed > np.linalg.norm(np.diff(path, axis=0), axis=1)[:, None]
    middle = (places[1:] + places[:-1]) / 2
    known = np.asarray(np.isfinite(middle).all(axis=1))
    lifts = []
    for k in range(places.shape[2]):
        swing, stance = (known[:, k] & one[:, k] for one in (swings, ~swings))
        if swing.any() and stance.any():
            lifts.append(middle[swing, :, k].mean(axis=0) - middle[stance, :, k].mean(axis=0))
    if not lifts:
        return None
    lift = np.mean(lifts, axis=0)
    if way is not None:
        lift = lift - (lift @ way) * way
    reach = places - np.nanmean(places, axis=0)
    length = 2.0 * float(np.nanpercentile(np.linalg.norm(reach, axis=1), 90))
    return lift if np.linalg.norm(lift) > LEAST_LIFT * length else None


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
