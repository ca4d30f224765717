"""How points move in a recording: what is known of it before they are tracked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FASTEST = 12.0
"""Speed of the fastest swings, in spans per second."""


@dataclass(frozen=True)
class Manner:
    """How points move; lengths in the unit of space, times in frames.

    Parameters
    ----------
    acceleration : float
        Standard deviation of the acceleration.
    jerk : float
        Standard deviation of the change of acceleration from frame to frame.
    speed : float
        Speed of the fastest swings.
    drift : ndarray, shape (d,)
        Speed of paws that stand.
    axes : ndarray, shape (d, d)
        Unit vectors: forward, across (in space only), up.
    ground : float
        Height of the lowest click.
    span : float
        Distance of front from hind paws.
    thickness : float
        Thickness of a paw.
    """

    acceleration: float
    jerk: float
    speed: float
    drift: np.ndarray
    axes: np.ndarray
    ground: float
    span: float
    thickness: float

    @property
    def fps(self) -> float:
        """Frames per second of a recording in which points move so."""
        return FASTEST * self.span / self.speed
