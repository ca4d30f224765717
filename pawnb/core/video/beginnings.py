"""Which pictures at the beginning of a file rest on others that were cut off.

A film that is cut without being encoded anew may begin anywhere. Pictures before the first at
which decoding can begin are lost, and so are those that are stored after it, shown before it
and rest on what came before (the leading pictures of open groups).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import av

from pawnb.core.video.packets import MOST_REORDERED, Packet

_MOST_PACKETS = 600
"""Packets at most among which the first whole picture is looked for: longer than groups are."""


class Beginning:
    """The first packets of a file, kept until it is certain what can be decoded of them.

    Parameters
    ----------
    intra_only : bool
        Whether every packet is a whole picture: none is lost then, and none, as large as that
        of uncompressed film, is kept.
    """

    def __init__(self, *, intra_only: bool) -> None:
        self._is_of_use = not intra_only
        self._kept: list[av.Packet] = []
        self._first: int | None = None

    def add(self, packet: av.Packet, *, is_restart: bool) -> None:
        """Take the next packet of the file; it is kept only as long as it is of use."""
        if not self._is_of_use:
            return
        number = len(self._kept)
        if self._first is None and is_restart:
            self._first = number
        end = _MOST_PACKETS if self._first is None else self._first + MOST_REORDERED
        if number < end:
            self._kept.append(packet)

    def lost(self, packets: Sequence[Packet], codec: av.CodecContext) -> set[int]:
        """Return which packets at the beginning give no picture.

        Parameters
        ----------
        packets : sequence of Packet
            All packets, in the order of decoding.
        codec : CodecContext
            That of the stream; another of its kind decodes the beginning.
        """
        first = self._first
        if first is None:
            return set()
        doubtful = set(range(first))
        for number in range(first + 1, min(len(packets), len(self._kept))):
            if not _is_before(packets[number], packets[first]):
                break
            doubtful.add(number)
        if not doubtful:
            return doubtful
        # other decoders make a picture out of grey where they lack what it rests on
        is_told = codec.name in ("h264", "hevc")
        doubtful -= self._decoded(codec, 0 if is_told else first)
        return {k for k in doubtful if not packets[k].is_hidden}

    def _decoded(self, codec: av.CodecContext, start: int) -> set[int]:
        """Decode what was kept, and return the packets of which a sound picture comes."""
        decoder: Any = av.CodecContext.create(codec.name, "r")
        decoder.thread_count = 1
        if codec.extradata:
            decoder.extradata = codec.extradata
        found: set[int] = set()
        for number, packet in [*enumerate(self._kept[start:], start), (-1, None)]:
            if packet is not None:
                packet.pts = packet.dts = number
            try:
                frames = decoder.decode(packet)
            except av.FFmpegError:
                continue
            found.update(f.pts for f in frames if f.pts is not None and not f.is_corrupt)
        return found


def _is_before(packet: Packet, first: Packet) -> bool:
    """Tell whether a picture is shown before another; those without a time at a beginning are."""
    return packet.pts is None or (first.pts is not None and packet.pts < first.pts)
