"""Pictures that a file says are to be turned or mirrored before they are looked at.

A phone keeps the picture as its sensor lies and writes how it was held beside it: players, and
other programs that track, show it upright.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.pixels.colour import Picture


class Turn(NamedTuple):
    """How a picture is to be shown: first transposed, then mirrored.

    Parameters
    ----------
    transposed : bool
        Whether rows become columns.
    flips_u, flips_v : bool
        Whether left and right, above and below are exchanged after that.
    """

    transposed: bool = False
    flips_u: bool = False
    flips_v: bool = False

    @property
    def words(self) -> str:
        """What is done to a picture, in words."""
        if self.transposed != (self.flips_u != self.flips_v):
            return "mirrored and turned by 90 degrees" if self.transposed else "mirrored"
        if not self.transposed:
            return "turned by 180 degrees"
        return f"turned by 90 degrees {'' if self.flips_u else 'anti'}clockwise"


def turn_of_frame(frame: Any) -> Turn | None:
    """Read how a decoded frame is to be shown; None as it is, and for angles between.

    Parameters
    ----------
    frame : av.VideoFrame
        The frame; its display matrix maps (u, v) to (a u + c v, b u + d v), as in
        ISO/IEC 14496-12, 8.3.2.
    """
    # by its name: PyAV up to 18 lists what stands beside a picture, and from 19 on its kinds
    data = frame.side_data.get("DISPLAYMATRIX")
    if data is not None:
        a, b, _, c, d = np.sign(np.frombuffer(bytes(data), np.int32)[:5]).tolist()
        if (a and d and not b and not c) or (b and c and not a and not d):
            turn = Turn(not a, (a or c) < 0, (d or b) < 0)
            return turn if any(turn) else None
    return None


class TurnedPicture:
    """A picture as it is to be shown.

    Parameters
    ----------
    picture : Picture
        The picture as it was kept.
    turn : Turn
        How it is to be shown.
    """

    def __init__(self, picture: Picture, turn: Turn) -> None:
        self._picture, self._turn = picture, turn
        size = (picture.width, picture.height)
        self.width, self.height = size[::-1] if turn.transposed else size
        self.is_colour = picture.is_colour

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """
        transposed, flips_u, flips_v = self._turn
        if flips_u:
            u0, u1 = self.width - u1, self.width - u0
        if flips_v:
            v0, v1 = self.height - v1, self.height - v0
        box = (v0, u0, v1, u1) if transposed else (u0, v0, u1, v1)
        pixels = self._picture.region(*box)
        if transposed:
            pixels = pixels.swapaxes(0, 1)
        step_u, step_v = (-1 if flips else 1 for flips in (flips_u, flips_v))
        return np.ascontiguousarray(pixels[::step_v, ::step_u])
