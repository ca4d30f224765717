"""The displacement of body and feet over what they stand on, along a heading that may turn."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.grid import Grid
from pawnb.gait.strides.stride_table import Motion
from pawnb.kinematics import BodyFrame


def displacement_along(positions: FloatArray, forward: FloatArray) -> FloatArray:
    """Sum up how far each foot has come along forward, from sample to sample.

    Of a heading that turns, the position along it changes with every turn, the more the further
    the feet are from the origin of the picture: a foot that stands would seem to move.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions; NaN where missing.
    forward : ndarray, shape (n, d)
        Unit vectors towards the front.

    Returns
    -------
    ndarray, shape (n, k)
        Each from where the foot is first seen; NaN where it is not. Over a gap it is the straight
        way, along the mean of the headings before and after it.
    """
    headed = np.isfinite(forward).all(axis=1, keepdims=True)
    known: BoolArray = np.asarray(np.isfinite(positions).all(axis=1) & headed)
    displacement = np.full(known.shape, np.nan)
    for foot in range(known.shape[1]):
        rows = np.flatnonzero(known[:, foot])
        steps = np.diff(positions[rows, :, foot], axis=0)
        between = (forward[rows[1:]] + forward[rows[:-1]]) / 2.0
        gone = np.cumsum(np.einsum("nd,nd->n", steps, between))
        displacement[rows, foot] = np.concatenate(([0.0], gone))[: len(rows)]
    return displacement


def measure_motion(
    feet: FootPaths,
    frame: BodyFrame,
    *,
    displacement: FloatArray,
    fore_aft: FloatArray,
    belt: FloatArray | None,
    grid: Grid,
) -> Motion:
    """Sum up how far body and feet have come relative to the ground or belt.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    frame : BodyFrame
        Path and heading of the body.
    displacement : ndarray, shape (n, k)
        How far each foot has come along forward, in the laboratory.
    fore_aft : ndarray, shape (n, k)
        Positions of the feet along forward in the body's frame.
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
        unknown = np.full(len(displacement), np.nan)
        return Motion(time_s=grid.time_s, body=unknown)
    rolled = np.concatenate(([0.0], np.cumsum((belt[1:] + belt[:-1]) / 2.0) / grid.fs_hz))
    known = np.isfinite(frame.path).all(axis=1)
    body = np.concatenate(([0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0)))) + rolled
    ahead = body + np.einsum("nd,nd->n", frame.origin - frame.path, frame.forward)
    return Motion(
        time_s=grid.time_s,
        heading_deg=_heading_deg(frame.forward),
        body=np.where(known, body, np.nan),
        feet={leg: displacement[:, k] + rolled for k, leg in enumerate(feet.legs)},
        places={leg: ahead + fore_aft[:, k] for k, leg in enumerate(feet.legs)},
    )


def _heading_deg(forward: FloatArray) -> FloatArray:
    """Return the direction of unit vectors, not wrapped, bridged where it is not known."""
    heading = np.arctan2(forward[:, 1], forward[:, 0])
    known = np.flatnonzero(np.isfinite(heading))
    if not len(known):
        return np.full(len(heading), np.nan)
    return np.degrees(np.interp(np.arange(len(heading)), known, np.unwrap(heading[known])))
