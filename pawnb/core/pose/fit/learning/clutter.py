"""What of a recording is not the animal as it is painted, as far as it was learnt."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Clutter:
    """Places that do not count; None where nothing was learnt of them.

    Parameters
    ----------
    attached : ndarray of bool, shape (side, side), or None
        Where something that is no leg is fixed to the body; see :mod:`.attached_clutter`.
    body : ndarray, shape (side, side), or None
        How much places of the body count in the last fits; see :mod:`.body_clutter`.
    legs : ndarray of bool, shape (legs, segments, along, across), or None
        Places beside legs that do not count in the last fits; see :mod:`.leg_clutter`.
    """

    attached: BoolArray | None = None
    body: FloatArray | None = None
    legs: BoolArray | None = None
