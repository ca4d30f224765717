"""MPEG-4 whose B pictures are packed, two in a packet, as DivX and Xvid write them into AVI.

AVI has one packet a picture and no display times, so such files put a picture and the one shown
before it into one packet, and an empty one after them. They are unpacked as they are read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import av
from av.bitstream import BitStreamFilterContext

MPEG4 = "mpeg4"
_VOP, _TYPE_B = b"\x00\x00\x01\xb6", 2
_HEADER_BYTES = 2048
"""Where a picture begins in its packet, at the latest: headers and comments stand before it."""


def unpacked(
    packets: Iterable[av.Packet], stream: av.video.stream.VideoStream
) -> Iterator[av.Packet]:
    """Yield the packets of an MPEG-4 stream, one a picture; those that are not packed as they are.

    Parameters
    ----------
    packets : iterable of av.Packet
        Packets that hold data, in the order of the file, from any on.
    stream : VideoStream
        The stream that they are of.

    Yields
    ------
    av.Packet
        What one picture needs.
    """
    unpack = BitStreamFilterContext("mpeg4_unpack_bframes", stream)
    for packet in packets:
        yield from unpack.filter(packet)


def is_shown_at_once(packet: av.Packet) -> bool:
    """Tell whether a packet is a B picture (ISO/IEC 14496-2, Table 6-20)."""
    head = memoryview(packet)[:_HEADER_BYTES].tobytes()
    at = head.find(_VOP)
    return 0 <= at < len(head) - 4 and head[at + 4] >> 6 == _TYPE_B


def display_times(dts: Sequence[int | None], at_once: Sequence[bool]) -> list[int | None]:
    """Return when pictures are shown: a B picture at once, another once the next such comes.

    Parameters
    ----------
    dts : sequence of int or None
        Decoding times, ticks.
    at_once : sequence of bool
        Which are B pictures.
    """
    order: list[int] = []
    held: int | None = None
    for number, is_b in enumerate(at_once):
        if is_b:
            order.append(number)
            continue
        if held is not None:
            order.append(held)
        held = number
    if held is not None:
        order.append(held)
    times: list[int | None] = [None] * len(dts)
    for number, time in zip(order, dts, strict=True):
        times[number] = time
    return times
