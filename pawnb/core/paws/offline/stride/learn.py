"""What strides are, learnt from tracks: cycle, duty factor, swings and lift-offs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.gap_closing.rejection import without_hops
from pawnb.core.paws.offline.gap_closing.state import GapClosing
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.stride.cycle import learn_cycle
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor, learn_duty_factor
from pawnb.core.paws.offline.stride.model import StrideModel
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.stance import Stance, learn_liftoff_velocity
from pawnb.core.paws.offline.stride.swing import Swings, learn_swings
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL


@dataclass(frozen=True)
class KnownGait:
    """What is known of the points before their strides are.

    Parameters
    ----------
    kinds : list of str
        Kind of each point.
    tracked_in_view : ndarray of bool, shape (P, V)
        Which view tracks which point.
    motion_model : MotionModel
        How points move.
    fps : float
        Frames per second.
    stride_s : tuple of float
        Shortest and longest stride, s.
    """

    kinds: list[str]
    tracked_in_view: BoolArray
    motion_model: MotionModel
    fps: float
    stride_s: tuple[float, float]


def learn_stride(
    smoothed: SmoothedTracks, gap_closing: GapClosing, body: FloatArray, *, gait: KnownGait
) -> StrideModel:
    """Learn strides from tracks.

    Parameters
    ----------
    smoothed : SmoothedTracks
        The tracks.
    gap_closing : GapClosing
        When points stand, and which of their places are certain.
    body : ndarray, shape (n, d)
        The slowly moving middle of the tracks.
    gait : KnownGait
        What is known beforehand.

    Returns
    -------
    StrideModel
        What they say; parts that they do not tell are None.
    """
    motion_model = gait.motion_model
    sd = smoothed.sd.mean(axis=-1) / motion_model.paw_width
    duty_factor = learn_duty_factor(gap_closing.stances, gait.kinds)
    stances, lost = without_hops(gap_closing.stances, gap_closing.is_open, duty_factor)
    shortest, longest = gait.stride_s
    cycle = learn_cycle(
        smoothed.x, body, axes=motion_model.axes, frames=(shortest * gait.fps, longest * gait.fps),
        noise=STRIDE.cycle_noise * motion_model.paw_width,
        trust=np.where(lost, 0.0, 1.0 / (1.0 + (sd / TREADMILL.learnt_from) ** 2)),
    )  # fmt: skip
    swings = _swings(smoothed, gap_closing, stances, duty_factor, lost=lost, gait=gait)
    liftoff_velocity = _liftoff_velocity(smoothed, gap_closing, gait)
    return StrideModel(cycle, liftoff_velocity, duty_factor, swings, lost)


def _liftoff_velocity(
    smoothed: SmoothedTracks, gap_closing: GapClosing, gait: KnownGait
) -> np.ndarray | None:
    """Return how much speeds change at lift-off; None where nothing is known of the ground."""
    if gap_closing.substrate is None:
        return None
    return learn_liftoff_velocity(
        gap_closing.substrate, smoothed.x, np.isfinite(smoothed.measured[..., 0]).any(axis=-1),
        lift_offs=gap_closing.lift_offs, frames=max(1, round(TREADMILL.rising_s * gait.fps)),
    )  # fmt: skip


def _swings(
    smoothed: SmoothedTracks,
    gap_closing: GapClosing,
    stances: list[list[Stance]],
    duty_factor: DutyFactor | None,
    *,
    lost: BoolArray,
    gait: KnownGait,
) -> Swings | None:
    """Return where points swing; None without a rhythm, or where no view shows heights.

    Frames (n, P) in which points were ``lost`` tell nothing.
    """
    substrate = gap_closing.substrate
    if duty_factor is None or substrate is None or np.isnan(substrate.height).all():
        return None
    seen = (np.isfinite(smoothed.measured[..., 0]) & gait.tracked_in_view).any(axis=-1) & ~lost
    # arcs go forward and up: that a single view tells no depth takes nothing from them
    ahead = gait.motion_model.axes[[0, -1]]
    sd = np.sqrt(smoothed.sd**2 @ (ahead**2).T).mean(axis=-1) / gait.motion_model.paw_width
    return learn_swings(
        smoothed.x,
        seen / (1.0 + (sd / TREADMILL.learnt_from) ** 2),
        stances,
        certain=~gap_closing.is_open,
        substrate=substrate,
        duty_factor=duty_factor,
        kinds=gait.kinds,
        fps=gait.fps,
    )
