"""What gaps are closed by, and what was taken in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.stride.model import StrideModel
from pawnb.core.paws.offline.stride.stance import Stance, Substrate


@dataclass(frozen=True)
class GapClosing:
    """What was taken where paths are not certain.

    Parameters
    ----------
    is_open : ndarray of bool, shape (n, P)
        Frames whose detections were chosen here.
    choice : ndarray of int, shape (n, P, V)
        Number of the detection taken, -1 where none.
    negative_log_odds : ndarray, shape (n, P, V, C)
        What speaks against each detection being each point, minus a logarithm of odds.
    held : ndarray, shape (n, P, d), optional
        Where points stand though no path says so, NaN elsewhere.
    lift_offs : list of (int, int)
        Number of a point and the last frame in which it stands, for every lift-off.
    substrate : Substrate, optional
        What points stand on.
    stances : list of list of Stance
        When each point stands.
    """

    is_open: np.ndarray
    choice: np.ndarray
    negative_log_odds: np.ndarray
    held: np.ndarray | None = None
    lift_offs: list[tuple[int, int]] = field(default_factory=list)
    substrate: Substrate | None = None
    stances: list[list[Stance]] = field(default_factory=list)


@dataclass(frozen=True)
class TrackingState:
    """What is known of the points so far.

    Parameters
    ----------
    assignment : Assignment
        Certain places, NaN elsewhere.
    before : ndarray, shape (n, P, d)
        Tracks of an earlier pass, NaN where there was none, and
    trust : ndarray, shape (n, P)
        how much they are to be believed, 0 to 1.
    stride : StrideModel
        What is known of strides.
    body : ndarray, shape (n, d), optional
        The slowly moving middle of the animal, about which points stay.
    kinds : sequence of str
        Kind of each point: those of one kind go as far.
    are_apart : bool
        Whether places are known so well that two points keep their distance in space, and that
        a point's own say how far it goes.
    """

    assignment: Assignment
    before: FloatArray
    trust: FloatArray
    stride: StrideModel
    body: FloatArray | None = None
    kinds: Sequence[str] = ()
    are_apart: bool = True

    @property
    def chosen(self) -> FloatArray:
        """Certain places (n, P, d), NaN elsewhere."""
        return self.assignment.at
