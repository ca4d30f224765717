"""Motion JPEG packets as pictures that are decoded only where somebody looks.

The first packet is decoded by FFmpeg as well. Only if both ways give the same samples, all
of them, is the file read so; and any packet that is not like the first, or seems damaged,
is left to FFmpeg, which knows more kinds of JPEG and tells what is damaged.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import av
import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.first_run import is_ready
from pawnb.core.pixels.colour import PartPicture, Picture
from pawnb.core.pixels.planes import Shown, picture_of_planes, planes_of_frame, shown_as

if TYPE_CHECKING:
    from pawnb.core.jpeg.coded import CodedPicture


class PartReader:
    """Makes pictures of the packets of one Motion JPEG file."""

    def __init__(self) -> None:
        self._is_new = True
        self._kind = b""
        self._format = ""
        self._shown = Shown(standard="", full_range=True)

    def read(self, packet: av.Packet, codec: av.VideoCodecContext) -> PartPicture | None:
        """Return the picture of a packet; None where FFmpeg is to decode it.

        Parameters
        ----------
        packet : Packet
            One frame.
        codec : VideoCodecContext
            Decodes the first packet, to compare.
        """
        if not (self._is_new or self._kind) or not is_ready():
            return None
        # compiled loops: loaded where they are needed, not by whoever opens a video
        from pawnb.core.jpeg.coded import read_coded

        coded = read_coded(bytes(packet))
        if self._is_new:
            self._is_new = False
            self._compare(coded, packet, codec)
        if coded is None or coded.plan.kind != self._kind:
            return None
        plan = coded.plan
        load = functools.partial(self._load, coded)
        return PartPicture(plan.width, plan.height, load, is_colour=plan.n_planes == 3)

    def _compare(
        self, coded: CodedPicture | None, packet: av.Packet, codec: av.VideoCodecContext
    ) -> None:
        """Find out from the first packet whether packets can be read so."""
        try:
            frames = codec.decode(packet)
        except av.FFmpegError:
            return
        if coded is None or len(frames) != 1 or frames[0].is_corrupt:
            return
        frame, plan = frames[0], coded.plan
        planes = planes_of_frame(frame)
        if (frame.width, frame.height) != (plan.width, plan.height):
            return
        own, _ = coded.planes(0, 0, plan.width, plan.height)
        sizes = [(plan.height, plan.width)]
        sizes += [(-(-plan.height // plan.steps[1]), -(-plan.width // plan.steps[0]))] * 2
        if len(planes) == len(own) and all(
            np.array_equal(a[:h, :w], b[:h, :w])
            for a, b, (h, w) in zip(planes, own, sizes, strict=False)
        ):
            self._format, self._shown = frame.format.name, shown_as(frame)
            if self._show(own, plan.width, plan.height) is not None:
                self._kind = plan.kind

    def _load(
        self, coded: CodedPicture, u0: int, v0: int, u1: int, v1: int
    ) -> tuple[Picture, tuple[int, int]]:
        """Decode the units in which a region lies."""
        planes, (left, top) = coded.planes(u0, v0, u1, v1)
        width = min(planes[0].shape[1], coded.plan.width - left)
        height = min(planes[0].shape[0], coded.plan.height - top)
        picture = self._show(planes, width, height)
        if picture is None:
            raise AssertionError(self._format)
        return picture, (left, top)

    def _show(self, planes: list[ByteArray], width: int, height: int) -> Picture | None:
        """Return the picture of planes in the format of the first frame."""
        return picture_of_planes(self._format, planes, width=width, height=height, **self._shown)
