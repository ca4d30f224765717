"""Frames at the ends of a recording with hardly a right label, as where the animal is not in view.

An animal that passes a camera is there in a part of the recording only. Labels before and after
lower every mean, however good those between are; a person should know which frames to use.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class UsableFrames:
    """A part of a recording that is better than the whole.

    Parameters
    ----------
    first, stop : int
        The first frame to use, and one past the last.
    right : float
        Share of labels in it that are expected to be right.
    left_out : tuple of (int, int, float)
        First and last frame of what is before it, and after it, with the share in it.
    """

    first: int
    stop: int
    right: float
    left_out: tuple[tuple[int, int, float], ...]

    def words(self) -> str:
        """Say what is wrong with the rest, and what to do."""
        parts = " and ".join(
            f"{first} to {last} ({100 * right:.0f} % of labels expected right)"
            for first, last, right in self.left_out
        )
        return (
            f"if the animal is not in view in frames {parts}, write frames = "
            f"[{self.first}, {self.stop}] under [trial] and track again"
        )


def find_usable_frames(
    chance: FloatArray, frames: IntArray, *, clicked: BoolArray, limit: float
) -> UsableFrames | None:
    """Find the part of a recording that is left when poor ends are cut off.

    It is the run of frames in which labels are farthest above the limit, added up: what is cut off
    before it and after it lies below the limit on average, however it is divided.

    Parameters
    ----------
    chance : ndarray, shape (n,)
        Mean probability of a frame's labels to be right.
    frames : ndarray of int, shape (n,)
        Their numbers.
    clicked : ndarray of bool, shape (n,)
        Frames in which a person clicked a point: the animal is in view there.
    limit : float
        Ends below it are poor.

    Returns
    -------
    UsableFrames or None
        None where nothing is to be cut off, or a clicked frame would be.
    """
    above = np.concatenate([[0.0], np.cumsum(chance - limit)])
    lowest = np.minimum.accumulate(above)
    stop = int(np.argmax(above - lowest))
    begin = int(np.argmin(above[: stop + 1]))
    outside = np.ones(len(chance), bool)
    outside[begin:stop] = False
    if not outside.any() or outside.all() or (outside & clicked).any():
        return None
    ends = [slice(0, begin), slice(stop, len(chance))]
    return UsableFrames(
        int(frames[begin]), int(frames[stop - 1]) + 1, float(chance[begin:stop].mean()),
        tuple(
            (int(frames[end][0]), int(frames[end][-1]), float(chance[end].mean()))
            for end in ends if len(frames[end])
        ),
    )  # fmt: skip
