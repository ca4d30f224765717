"""Which place each point was given in each frame."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class Assignment:
    """The places of P points in n frames.

    Parameters
    ----------
    at : ndarray, shape (n, P, d)
        Chosen places; NaN where a point is occluded.
    by_hand : ndarray of bool, shape (n, P)
        Where a person has placed the point: that stays.
    """

    at: FloatArray
    by_hand: BoolArray
