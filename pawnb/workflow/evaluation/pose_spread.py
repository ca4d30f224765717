"""How much poses vary where there is no truth: jitter, and forward against reverse.

The evaluations of Pullar 2009, §4.1 (Tables 4.1 and 4.2). Frames that one side lacks are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, leg_angles
from pawnb.core.pose.track_result import PoseTrack
from pawnb.errors import InputError

TOTAL = "total leg"


def build_jitter_table(animal: StickAnimal, poses: Poses) -> pd.DataFrame:
    """Tell how much the pose of an animal that keeps still varies (Table 4.1).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses in frames in which it does not move; frames without a pose are left out.

    Returns
    -------
    DataFrame
        measure, legs, range, sd and unit: x, y and heading; then for each pair of legs every
        joint and the total leg angle: maximum less minimum, and standard deviation (n - 1), each
        the mean of the pair's two legs.

    Raises
    ------
    InputError
        If there are fewer than two poses.
    """
    poses = _there(poses)
    if len(poses) < 2:
        raise InputError(f"jitter needs two poses or more; found {len(poses)}.")
    return _by_pair(
        animal,
        {"x": poses.xy[:, 0], "y": poses.xy[:, 1]},
        {"heading": _unwrapped(poses.heading_deg)},
        _unwrapped(poses.angles_deg),
        _unwrapped(leg_angles(animal, poses)),
        {"range": np.ptp, "sd": lambda v: float(np.std(v, ddof=1))},
    )


def build_direction_table(animal: StickAnimal, forward: Poses, reverse: Poses) -> pd.DataFrame:
    """Compare tracking in one direction with tracking in the other (Table 4.2).

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    forward, reverse : Poses
        The poses found either way, of which the frames they share are compared.

    Returns
    -------
    DataFrame
        measure, legs, rms_difference and unit: root mean square of the differences in x, y and
        heading; then, for each pair of legs, in every joint and in the total leg angle, the mean
        of the two legs' root mean squares.

    Raises
    ------
    InputError
        If they share no frame.
    """
    one, other = shared_frames(forward, reverse)
    xy = one.xy - other.xy
    return _by_pair(
        animal,
        {"x": xy[:, 0], "y": xy[:, 1]},
        {"heading": wrapped_deg(one.heading_deg - other.heading_deg)},
        wrapped_deg(one.angles_deg - other.angles_deg),
        wrapped_deg(leg_angles(animal, one) - leg_angles(animal, other)),
        {"rms_difference": rms},
    )


def compare_directions(
    track: Callable[[Poses], PoseTrack],
    starts: tuple[Poses, Poses],
    *,
    animal: StickAnimal,
    disturb_px: float = 0.0,
    disturb_deg: float = 0.0,
    seed: int = 0,
) -> pd.DataFrame:
    """Track from the first frame forwards and from the last backwards, and compare (Table 4.2).

    Parameters
    ----------
    track : callable
        Tracks the whole recording from one start pose.
    starts : tuple of Poses
        The pose in the first frame and that in the last.
    animal : StickAnimal
        The animal.
    disturb_px, disturb_deg : float
        Standard deviation of what is added at random to each start pose: to x and y, and to
        the heading and every joint.
    seed : int
        Seed of that.

    Returns
    -------
    DataFrame
        As :func:`build_direction_table`.
    """
    rng = np.random.default_rng(seed)
    both = [
        track(disturbed(start, px=disturb_px, deg=disturb_deg, rng=rng)).poses for start in starts
    ]
    return build_direction_table(animal, *both)


def disturbed(poses: Poses, *, px: float, deg: float, rng: np.random.Generator) -> Poses:
    """Return poses with Gaussian errors: ``px`` in x and y, ``deg`` in heading and joints.

    Parameters
    ----------
    poses : Poses
        The poses.
    px : float
        Standard deviation in x and y, px.
    deg : float
        Standard deviation in heading and joints, degrees.
    rng : numpy.random.Generator
        Source of chance.

    Returns
    -------
    Poses
        The disturbed poses.
    """
    return Poses(
        frames=poses.frames,
        xy=poses.xy + rng.normal(0, px, poses.xy.shape),
        heading_deg=poses.heading_deg + rng.normal(0, deg, poses.heading_deg.shape),
        scale=poses.scale,
        angles_deg=poses.angles_deg + rng.normal(0, deg, poses.angles_deg.shape),
        lengths_px=poses.lengths_px,
    )


def _by_pair(
    animal: StickAnimal,
    place: dict[str, np.ndarray],
    heading: dict[str, np.ndarray],
    joints: np.ndarray,
    total: np.ndarray,
    measures: dict[str, Callable[[np.ndarray], float]],
) -> pd.DataFrame:
    """Return measures of place, heading, and of joints and legs averaged over pairs of legs."""
    rows: list[dict[str, Any]] = []

    def add(name: str, legs: str, unit: str, series: list[np.ndarray]) -> None:
        values = {k: float(np.mean([f(s) for s in series])) for k, f in measures.items()}
        rows.append({"measure": name, "legs": legs, **values, "unit": unit})

    for name, series in place.items():
        add(name, "", "px", [series])
    for name, series in heading.items():
        add(name, "", "deg", [series])
    for pair in _pairs(animal):
        legs = ", ".join(pair)
        leg = animal.leg(pair[0])
        for joint, free in zip(leg.joints, leg.free, strict=True):
            if free:
                cols = [animal.joints.index(f"{name}_{joint}") for name in pair]
                add(joint, legs, "deg", [joints[:, c] for c in cols])
        add(TOTAL, legs, "deg", [total[:, animal.leg_names.index(name)] for name in pair])
    return pd.DataFrame(rows, columns=["measure", "legs", *measures, "unit"])


def _pairs(animal: StickAnimal) -> list[tuple[str, ...]]:
    """Return the legs in pairs, front to rear; a leg without a partner alone."""
    partner = animal.mirrored_names()
    pairs: list[tuple[str, ...]] = []
    done: set[str] = set()
    for name in animal.leg_names:
        if name not in done:
            pair = (name, partner[name]) if name in partner else (name,)
            pairs.append(pair)
            done.update(pair)
    return pairs


def _there(poses: Poses) -> Poses:
    """Return the frames that have a pose."""
    return poses.take(np.isfinite(poses.xy[:, 0]))


def shared_frames(one: Poses, other: Poses) -> tuple[Poses, Poses]:
    """Return both poses of the frames in which both are there; raises InputError if none is."""
    one, other = _there(one), _there(other)
    frames, i, j = np.intersect1d(one.frames, other.frames, return_indices=True)
    if not len(frames):
        raise InputError("the two have no frame with a pose in common; nothing to compare.")
    return one.take(i), other.take(j)


def wrapped_deg(angle_deg: np.ndarray) -> np.ndarray:
    """Return angles in [-180, 180)."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def _unwrapped(angle_deg: np.ndarray) -> np.ndarray:
    """Return angles without jumps of a whole turn from frame to frame."""
    return np.unwrap(angle_deg, axis=0, period=360.0)


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
