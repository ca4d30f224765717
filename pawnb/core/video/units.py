"""What H.264 and HEVC packets hold, as far as it tells where decoding can begin.

A container calls a packet a key packet where a player may begin. That is less than is needed
here, where every picture has to be the one that reading from the start gives: pictures may
still lean on what came before (open groups), and with periodic intra refresh no picture is
whole by itself, but all are some pictures after a recovery point.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

_SEI, _RECOVERY_POINT = 6, 6


class Entry(NamedTuple):
    """How decoding can begin at a packet.

    Parameters
    ----------
    recovery : int or None
        Reference pictures, counted from this one, after which pictures are exact; 0 from
        this one on, None where they never are for certain.
    is_fresh : bool
        Whether display, too, begins anew here: nothing before it is shown after it.
    is_sure : bool
        Whether a picture that cannot be decoded from here on is damaged for certain.
    is_reference : bool
        Whether other pictures may rest on this one.
    """

    recovery: int | None
    is_fresh: bool = False
    is_sure: bool = True
    is_reference: bool = True


def read_entry(data: bytes, codec: str, extradata: bytes | None, *, is_key: bool) -> Entry:
    """Read from a packet how decoding can begin there.

    Parameters
    ----------
    data : bytes
        The packet; not looked at where the codec is neither h264 nor hevc.
    codec : str
        Name of the codec.
    extradata : bytes or None
        The codec's header; it tells whether units carry their length or a start code.
    is_key : bool
        Whether the container calls it a key packet.

    Returns
    -------
    Entry
        H.264: exact from an IDR picture on, and after a recovery point that promises an exact
        match (ITU-T H.264 Table 7-1, D.1.8 and D.2.8). HEVC: exact from a picture at which a
        reader may begin (ITU-T H.265 Table 7-1, types 16 to 21). Others: what the container
        says.
    """
    if codec == "h264":
        return _read_h264(data, extradata)
    if codec == "hevc":
        kind = next((k for k in _kinds_hevc(data, extradata) if k < 32), 0)
        return Entry(0 if 16 <= kind <= 21 else None, is_fresh=kind in (19, 20))
    return Entry(0 if is_key else None)


def _kinds_hevc(data: bytes, extradata: bytes | None) -> Iterator[int]:
    """Yield the type of each unit of an HEVC packet."""
    for unit, _, _ in _units(data, extradata, at_length=21):
        yield unit >> 1 & 63


def _read_h264(data: bytes, extradata: bytes | None) -> Entry:
    """Read an H.264 packet up to its first picture unit."""
    recovery = None
    for unit, begin, end in _units(data, extradata, at_length=4):
        kind = unit & 31
        if kind == _SEI:
            # no further than the unit: what follows it would be read as messages, too
            recovery = _recovery_point(data[begin + 1 : min(end, begin + 4096)], recovery)
        elif 1 <= kind <= 5:
            if kind == 5:
                return Entry(0, is_fresh=True)
            return Entry(recovery, is_sure=False, is_reference=bool(unit & 0x60))
    return Entry(None)


def _recovery_point(data: bytes, found: int | None) -> int | None:
    """Return the count of an exact recovery point among the messages of an SEI unit."""
    data = data.replace(b"\0\0\3", b"\0\0")  # emulation prevention (H.264, 7.4.1.1)
    at = 0
    while at + 2 < len(data):
        numbers = []
        for _ in range(2):  # type and size: bytes of 255 and a last one
            number = 0
            while at < len(data) and data[at] == 255:
                number, at = number + 255, at + 1
            if at >= len(data):
                return found
            number, at = number + data[at], at + 1
            numbers.append(number)
        kind, size = numbers
        if kind == _RECOVERY_POINT:
            return _exact_count(data[at : at + size])
        at += size
    return found


def _exact_count(message: bytes) -> int | None:
    """Return recovery_frame_cnt where exact_match_flag is set and broken_link_flag is not."""
    bits = "".join(f"{byte:08b}" for byte in message[:8])
    zeros = len(bits) - len(bits.lstrip("0"))
    end = 2 * zeros + 1  # Exp-Golomb (H.264, 9.1)
    if bits[end : end + 2] != "10":
        return None
    return int(bits[zeros:end], 2) - 1


def _units(
    data: bytes, extradata: bytes | None, *, at_length: int
) -> Iterator[tuple[int, int, int]]:
    """Yield the first byte of each unit of a packet, where it stands, and where the unit ends."""
    if extradata and extradata[0] == 1 and len(extradata) > at_length:
        length_bytes = (extradata[at_length] & 3) + 1
        at = length_bytes
        while at < len(data):
            end = at + int.from_bytes(data[at - length_bytes : at], "big")
            yield data[at], at, end
            at = end + length_bytes
        return
    at = data.find(b"\x00\x00\x01")
    while 0 <= at < len(data) - 3:
        following = data.find(b"\x00\x00\x01", at + 3)
        yield data[at + 3], at + 3, len(data) if following < 0 else following
        at = following
