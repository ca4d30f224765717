"""JPEG pictures of which any part can be decoded by itself.

The whole picture is read through once, which finds damage and where its blocks are, but
decodes none. A part then costs what its own blocks cost: the surroundings of an animal that
fills an eighth of the picture are had in a quarter of the time that the picture takes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import ByteArray, IntArray
from pawnb.core.jpeg.block_kernels import STRIP_PX, decode_units
from pawnb.core.jpeg.header import JpegHeader, header_length, read_plan
from pawnb.core.jpeg.huffman_kernels import MOST_BITS, scan_units, take_words

_MARGIN_WORDS = 10 * 64 * MOST_BITS // 64 + 4
"""More than one unit of blocks can take: no bit is read that is not there."""


@dataclass(frozen=True)
class CodedPicture:
    """A picture that was read through.

    Parameters
    ----------
    plan : JpegHeader
        What its headers say.
    words : ndarray of uint64
        Its bits.
    begins, levels : ndarray
        See :func:`~pawnb.core.jpeg.huffman_kernels.scan_units`.
    """

    plan: JpegHeader
    words: IntArray
    begins: IntArray
    levels: IntArray

    def planes(self, u0: int, v0: int, u1: int, v1: int) -> tuple[list[ByteArray], tuple[int, int]]:
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
        box = (u0 // width, v0 // height, -(-u1 // width), -(-v1 // height))
        h, w = (box[3] - box[1]) * height, (box[2] - box[0]) * width
        sizes = [(h, w), *[(h // step_v, w // step_u)] * (plan.n_planes - 1)]
        strips = [np.empty((h, -(-w // STRIP_PX) * STRIP_PX), np.uint8) for h, w in sizes]
        luma, chroma_u, chroma_v = strips if len(strips) == 3 else strips * 3
        decode_units(
            self.words, self.begins, self.levels, plan.blocks, plan.tables, plan.scales,
            box, plan.columns, (luma, chroma_u, chroma_v),
        )  # fmt: skip
        planes = [strip[:, :w] for strip, (_, w) in zip(strips, sizes, strict=True)]
        return planes, (box[0] * width, box[1] * height)


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
    eights = np.frombuffer(data, np.uint64, len(data) // 8)
    words = np.empty(len(eights) + _MARGIN_WORDS, np.uint64)
    restarts = np.empty((n_units - 1) // plan.interval, np.int32)
    n_bytes = take_words(np.frombuffer(data, np.uint8), eights, begin, words, restarts)
    if n_bytes < 0:
        return None
    # after its last bit there are zeros, for a unit that is damaged
    words[n_bytes // 8 + 1 :] = 0
    begins = np.empty(n_units, np.int32)
    levels = np.empty((n_units, plan.n_planes), np.int16)
    if not scan_units(
        words, 8 * n_bytes, plan.interval, restarts, plan.blocks, plan.tables, begins, levels
    ):
        return None
    return CodedPicture(plan, words, begins, levels)
