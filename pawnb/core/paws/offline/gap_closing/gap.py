"""A stretch of frames in which a point is not certain, with what is known on either side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, IntArray
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.stride.stance import Stance


@dataclass(frozen=True)
class Gap:
    """Frames of a point that are associated again, in the order in which they are followed.

    Parameters
    ----------
    before, frames, after : ndarray of int
        Certain frames that tell how it begins, its own, and certain ones that tell how it ends.
    is_last : bool
        Whether hardly anything follows.
    way : int
        +1, or -1 where it is followed backwards in time.
    """

    before: IntArray
    frames: IntArray
    after: IntArray
    is_last: bool
    way: int

    @classmethod
    def of(cls, first: int, stop: int, is_open: BoolArray) -> Gap:
        """Return a stretch of open frames; one that begins a recording goes backwards.

        Parameters
        ----------
        first, stop : int
            Its first frame, and the one after its last.
        is_open : ndarray of bool, shape (n,)
            Frames in which the point is not certain.

        Returns
        -------
        Gap
            The stretch, and the certain frames that are read on either side.
        """
        n = len(is_open)
        frames = np.arange(n)
        if first == 0:
            # before the first frame nothing is known: it is found from what follows
            begin = stop + _certain_frames(is_open[stop:], GAP_CLOSING.gap_before)
            return cls(frames[stop:begin][::-1], frames[:stop][::-1], frames[:0], True, -1)
        # going back from the stretch is going forward in reversed time
        begin = first - _certain_frames(is_open[:first][::-1], GAP_CLOSING.gap_before)
        end = stop + _certain_frames(is_open[stop:], GAP_CLOSING.gap_after)
        return cls(
            frames[begin:first],
            frames[first:stop],
            frames[stop:end],
            stop + GAP_CLOSING.gap_after > n,
            1,
        )

    def stance(self, stances: Sequence[Stance]) -> Stance | None:
        """Return the stance of the point where the stretch begins; None where it does not stand."""
        if not len(self.before):
            return None
        edge = int(self.before[-1])
        ends = [one.stop - 1 if self.way > 0 else one.first for one in stances]
        return stances[ends.index(edge)] if edge in ends else None


def _certain_frames(is_open: BoolArray, most: int) -> int:
    """Return how many frames are certain before the first open one, at most ``most``."""
    near = is_open[:most]
    return int(np.argmax(near)) if near.any() else len(near)
