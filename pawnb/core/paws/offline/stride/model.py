"""What a recording's strides say of its points."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.swing import Swings


@dataclass(frozen=True)
class StrideModel:
    """What is known of strides; nothing before tracks are there to learn it from.

    Parameters
    ----------
    cycle : Cycle, optional
        Where points are expected.
    liftoff_velocity : ndarray, shape (P, d), optional
        How much speeds change at lift-off.
    duty_factor : DutyFactor, optional
        When points lift off.
    swings : Swings, optional
        Where they swing.
    hopped : ndarray of bool, shape (n, P), optional
        Frames in which tracks were where no swing leads.
    """

    cycle: Cycle | None = None
    liftoff_velocity: FloatArray | None = None
    duty_factor: DutyFactor | None = None
    swings: Swings | None = None
    hopped: BoolArray | None = None

    @property
    def is_known(self) -> bool:
        """Whether it says where points are: two strides give a rhythm and swings, but no cycle."""
        return self.cycle is not None or self.swings is not None
