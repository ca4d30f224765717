"""JPEG pictures of which any part can be decoded by itself.

The whole picture is read through once, which finds damage and where its blocks are, but
decodes none. A part then costs what its own blocks cost: the surroundings of an animal that
fills an eighth of the picture are had in a quarter of the time that the picture takes.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from pawnb.core.jpeg.block_loops import decode_units
from pawnb.core.jpeg.header import Plan, header_length, read_plan
from pawnb.core.jpeg.huffman_loops import MOST_BITS, scan_units, take_words

_MARGIN_BYTES = 4 * (10 * 64 * MOST_BITS // 32 + 2) + 8
"""More than one unit of blocks can take: no bit is read that is not there."""


@dataclass(frozen=True)
class CodedPicture:
    """A picture that was read through.

    Parameters
    ----------
    plan : Plan
        What its headers say.
    words : ndarray of uint32
        Its bits.
    begins, levels : ndarray
        See :func:`~pawnb.core.jpeg.huffman_loops.scan_units`.
    """

    plan: Plan
    words: np.ndarray
    begins: np.ndarray
    levels: np.ndarray

    def planes(
        self, u0: int, v0: int, u1: int, v1: int
    ) -> tuple[list[np.ndarray], tuple[int, int]]:
        """Decode a part.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            The half-open region that is needed, px.

        Returns
        -------
        planes : list of ndarray, shape (h, w), uint8
            Luma, and Cb and Cr where the picture is in colour, of all units in which the
            region lies.
        origin : tuple of int
            Left and top of the first of these units, px.
        """
        plan = self.plan
        (width, height), (step_u, step_v) = plan.unit, plan.steps
        left, top = u0 // width, v0 // height
        size = ((-(-v1 // height) - top) * height, (-(-u1 // width) - left) * width)
        chroma = (size[0] // step_v, size[1] // step_u)
        chroma = chroma if plan.n_planes == 3 else (0, 0)
        planes = (
            np.empty(size, np.uint8), np.empty(chroma, np.uint8), np.empty(chroma, np.uint8)
        )  # fmt: skip
        decode_units(
            self.words, self.begins, self.levels, plan.blocks, plan.tables, plan.scales,
            (left, top), plan.columns, planes,
        )  # fmt: skip
        return list(planes[: plan.n_planes]), (left * width, top * height)


def read_coded(data: bytes) -> CodedPicture | None:
    """Read through a picture without decoding it.

    Parameters
    ----------
    data : bytes
        A JPEG picture.

    Returns
    -------
    CodedPicture or None
        None where anything about it is not as expected: the picture is damaged, or of a
        sort that only a whole decoder understands.
    """
    begin = header_length(data)
    plan = read_plan(data[:begin]) if begin else None
    if plan is None:
        return None
    n_units = plan.columns * plan.rows
    if n_units > 4 * len(data):  # not even two bits for each
        return None
    words = np.empty((len(data) + _MARGIN_BYTES) // 4, np.uint32)
    as_bytes = words.view(np.uint8)
    restarts = np.empty((n_units - 1) // plan.interval, np.int32)
    n_bytes = take_words(np.frombuffer(data, np.uint8), begin, as_bytes, restarts)
    if n_bytes < 0:
        return None
    # after its last bit there are zeros, for a unit that is damaged
    as_bytes[n_bytes : n_bytes + _MARGIN_BYTES - 8] = 0
    if sys.byteorder == "little":
        words.byteswap(inplace=True)
    begins = np.empty(n_units, np.int32)
    levels = np.empty((n_units, plan.n_planes), np.int16)
    if not scan_units(
        words, 8 * n_bytes, plan.interval, restarts, plan.blocks, plan.tables, begins, levels
    ):
        return None
    return CodedPicture(plan, words, begins, levels)
