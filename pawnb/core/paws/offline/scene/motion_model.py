"""How points move in a recording: what is known of it before they are tracked."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.scene.parameters import MOVEMENT


@dataclass(frozen=True)
class MotionModel:
    """How points move; lengths in the unit of space, times in frames.

    Parameters
    ----------
    acceleration : float
        Standard deviation of the acceleration.
    jerk : float
        Standard deviation of the change of acceleration from frame to frame.
    speed : float
        Speed of the fastest swings.
    substrate_velocity : ndarray, shape (d,)
        Speed of paws that stand.
    axes : ndarray, shape (d, d)
        Unit vectors: forward, across (in space only), up.
    substrate : float
        Height of the lowest click.
    body_scale : float
        Distance of front from hind paws.
    paw_width : float
        Width of a paw.
    """

    acceleration: float
    jerk: float
    speed: float
    substrate_velocity: FloatArray
    axes: FloatArray
    substrate: float
    body_scale: float
    paw_width: float

    @property
    def fps(self) -> float:
        """Frames per second of a recording in which points move so."""
        return MOVEMENT.fastest * self.body_scale / self.speed
