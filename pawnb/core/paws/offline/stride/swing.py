"""Where paws are while they swing, from the arc that the recording's swings share.

A swing goes from one stance to the next. Where a paw is occluded for a part of it, the arc says
where it was; after the last stance of a recording and before the first one, a stride's rhythm
says when the paw landed or lifted off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.stance import Stance, Substrate
from pawnb.core.paws.offline.stride.swing_detection import (
    Swing,
    find_swings,
    since_landing,
)
from pawnb.core.paws.offline.stride.swing_trajectory import (
    Guess,
    Part,
    SwingTrajectory,
    changes,
    fit_swings,
    learn_trajectory,
    trajectory_at,
)


@dataclass(frozen=True)
class Swings:
    """Where points swing.

    Parameters
    ----------
    place : ndarray, shape (n, P, d)
        Where the arc has them, NaN where they stand or it is not known.
    sd : ndarray, shape (n, P, d)
        Standard deviations along forward, across and up.
    jerk_mean : ndarray, shape (n, P, d)
        Third differences of the arcs, NaN where they are not known.
    lift_offs : tuple of tuple
        Number of the point, frame of the lift-off, and its standard deviation.
    """

    place: FloatArray
    sd: FloatArray
    jerk_mean: FloatArray
    lift_offs: tuple[tuple[int, float, float], ...]

    def due(self, point: int, frames: IntArray, fps: float) -> FloatArray | None:
        """Return what speaks against lifting off just before each of some frames.

        Parameters
        ----------
        point : int
            Number of the point.
        frames : ndarray of int, shape (n,)
            Consecutive frames.
        fps : float
            Frames per second.

        Returns
        -------
        ndarray, shape (n,), or None
            Costs; None if no swing is known to begin there.
        """
        reach = max(STRIDE.near_s * fps, STRIDE.swing_nearest)
        near = [
            0.5 * ((frames - STRIDE.half_frame - lift) / max(sd, STRIDE.due_sd)) ** 2
            for p, lift, sd in self.lift_offs
            if p == point and frames[0] - reach < lift < frames[-1] + reach
        ]
        return np.minimum(np.min(near, axis=0), STRIDE.most_cost) if near else None


def learn_swings(
    x: FloatArray,
    weight: FloatArray,
    stances: Sequence[Sequence[Stance]],
    *,
    certain: BoolArray,
    substrate: Substrate,
    duty_factor: DutyFactor | None,
    kinds: Sequence[str],
    fps: float,
) -> Swings:
    """Learn how points swing, and where they are while they do.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Tracks.
    weight : ndarray, shape (n, P)
        How much each place counts, 0 where nothing was seen.
    stances : sequence
        Those of each point.
    certain : ndarray of bool, shape (n, P)
        Where places are certain. In swings after the last stance and before the first one the
        others count less: only one side tells them.
    substrate : Substrate
        What they stand on.
    duty_factor : DutyFactor, optional
        When they lift off.
    kinds : sequence of str
        Kind of each point: those of a kind have one arc.
    fps : float
        Frames per second.

    Returns
    -------
    Swings
        Nothing of kinds with fewer than three swings.
    """
    motion_model = substrate.motion_model
    seen = (weight > STRIDE.swing_seen) & np.isfinite(x[..., 0])
    stances = since_landing(stances, x, seen=seen, substrate=substrate)
    every = find_swings(
        stances, seen, duty_factor, certain=certain, fps=fps,
        substrate_velocity=substrate.substrate_velocity,
    )  # fmt: skip
    least = STRIDE.least_step * motion_model.paw_width
    found = [one for one in every if (one.end - one.begin) @ motion_model.axes[0] > least]
    place, sd, jerk_mean = (np.full(x.shape, np.nan) for _ in range(3))
    lift_offs: list[tuple[int, float, float]] = []
    still = (
        x - np.arange(len(x))[:, None, None] * substrate.substrate_velocity
    ) @ motion_model.axes.T
    for kind in sorted(set(kinds)):
        mine = _usual([swing for swing in found if kinds[swing.point] == kind])
        whole = [swing for swing in mine if swing.is_whole]
        if len(whole) < STRIDE.swing_least:
            continue
        trajectory = learn_trajectory(
            _part(whole, still, weight, motion_model, certain=certain), _guess(whole)
        )
        part = _part(mine, still, weight, motion_model, certain=certain)
        for swing, values, covariance in zip(
            mine, *fit_swings(trajectory, part, _guess(mine)), strict=True
        ):
            frames, path, spread = _path(swing, values, covariance, trajectory, substrate)
            inside, bent, third = _bend(frames, path, values, len(x))
            place[frames[inside], swing.point] = path[inside]
            sd[frames[inside], swing.point] = spread[inside]
            jerk_mean[frames[bent], swing.point] = third[bent]
            lift_offs.append((swing.point, float(values[0]), float(np.sqrt(covariance[0, 0]))))
    return Swings(place, sd, jerk_mean, tuple(lift_offs))


def _usual(swings: Sequence[Swing]) -> list[Swing]:
    """Leave out swings that last much longer or shorter than most: a stance was missed there."""
    if not swings:
        return []
    lasts = np.array([land - lift for lift, land in (one.times for one in swings)])
    usual = float(np.median(lasts))
    usually = (lasts > usual / STRIDE.unusual_ratio) & (lasts < usual * STRIDE.unusual_ratio)
    return [one for one, kept in zip(swings, usually, strict=True) if kept]


def _bend(
    frames: IntArray, path: FloatArray, values: FloatArray, n: int
) -> tuple[BoolArray, BoolArray, FloatArray]:
    """Return which frames lie in a swing, in which its path tells how it bends, and how."""
    third = np.full(path.shape, np.nan)
    third[1:-2] = np.diff(path, 3, axis=0)
    here = (frames >= 0) & (frames < n)
    inside = here & (frames > values[0]) & (frames < values[1])
    bent = here & np.isfinite(third[:, 0]) & (frames < values[1])
    return inside, bent, third


def _guess(swings: Sequence[Swing]) -> Guess:
    """Return what is known of swings."""
    return Guess(np.array([one.times for one in swings]), np.array([one.sd for one in swings]))


def _part(
    swings: Sequence[Swing],
    still: FloatArray,
    weight: FloatArray,
    motion_model: MotionModel,
    *,
    certain: BoolArray,
) -> Part:
    """Return what is seen of swings, given places (n, P, d) along the axes on the ground."""
    first = np.array([int(one.times[0]) - STRIDE.swing_margin for one in swings])
    length = max(int(one.times[1]) - int(one.times[0]) for one in swings) + 2 * STRIDE.swing_margin
    frames = first[:, None] + np.arange(length)
    last = np.array([int(one.times[1]) + STRIDE.swing_margin for one in swings])
    point = np.array([one.point for one in swings])
    begin, end = (
        np.array([getattr(one, name) for one in swings]) @ motion_model.axes.T
        for name in ("begin", "end")
    )
    inside = (frames >= 0) & (frames < np.minimum(last, len(still))[:, None])
    at = np.clip(frames, 0, len(still) - 1)
    places = still[at, point[:, None]]
    inside &= np.isfinite(places).all(axis=-1)
    places = np.where(inside[..., None], places, begin[:, None])
    step = end - begin
    way = (places[..., 0] - begin[:, None, 0]) / step[:, None, 0]
    line = begin[:, None] + np.clip(way, 0.0, 1.0)[..., None] * step[:, None]
    off = (places - line) / motion_model.paw_width
    is_whole = np.array([one.is_whole for one in swings])
    sure = certain[at, point[:, None]] | is_whole[:, None]
    counted = weight[at, point[:, None]] * np.where(sure, 1.0, STRIDE.swing_uncertain)
    return Part(
        frames, way, off[..., -1], np.where(inside, counted, 0.0),
        step[:, 0] / motion_model.paw_width,
    )  # fmt: skip


def _path(
    swing: Swing,
    values: FloatArray,
    covariance: FloatArray,
    trajectory: SwingTrajectory,
    substrate: Substrate,
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return frames (T,) about a swing, where the paw is (T, d), and how sure that is (T, d)."""
    motion_model = substrate.motion_model
    axes, paw_width = motion_model.axes, motion_model.paw_width
    frames = np.arange(
        int(np.ceil(values[0])) - STRIDE.swing_margin + 1, int(values[1]) + STRIDE.swing_margin
    )
    way, up = trajectory_at(values, trajectory.shape, frames)
    begin, end = axes @ swing.begin, axes @ swing.end
    along = begin + way[:, None] * (end - begin)
    along[:, -1] += up * paw_width
    by_value, by_shape = changes(values, trajectory.shape, frames)
    variance = np.einsum("iat,jat,ij->ta", by_value, by_value, covariance)
    variance += np.einsum("iat,jat,ij->ta", by_shape, by_shape, trajectory.covariance)
    variance = variance * np.array([end[0] - begin[0], paw_width]) ** 2
    variance += (STRIDE.swing_unsure * paw_width) ** 2
    if len(axes) == 3:
        aside = (STRIDE.swing_unsure**2 + STRIDE.unsure_aside**2) * paw_width**2
        variance = np.insert(variance, 1, aside, axis=1)
    return frames, along @ axes + frames[:, None] * substrate.substrate_velocity, np.sqrt(variance)
