"""Whether a file ends where its own structure says that it ends.

A demultiplexer stops at the end of a file that was cut short as if it were the end of the
recording. The lengths that the file itself declares tell more. Where a container declares
none, a file that ends between two pictures cannot be distinguished from a shorter recording.
"""

from __future__ import annotations

import os
import struct
from enum import Enum
from pathlib import Path
from typing import BinaryIO

_SEGMENT, _CLUSTER = 0x18538067, 0x1F43B675
_TAIL_BYTES = 2**20
_TS_BYTES = 188
_TS_STEPS = ((_TS_BYTES, 0), (192, 0), (204, 16))
"""Bytes from packet to packet, and after one: plain, with time codes, with error correction."""
_TS_LEAST = 4
_CINE_HEADER_BYTES = 44


class Ending(Enum):
    """What a file's own structure says about its end."""

    WHOLE = "it is as long as it declares"
    UNTOLD = "it declares no length: ending here, it may be whole"
    UNKNOWN = "nothing is known of containers of this kind"
    CUT = "it ends inside something that it declares to be longer"
    CUT_IN_PICTURE = "it ends inside the last picture"


def find_ending(path: str | Path, container: str, stream_id: int) -> Ending:
    """Find out whether a file ends where it says that it ends.

    Parameters
    ----------
    path : str or Path
        The file.
    container : str
        FFmpeg's name of the container: Matroska (WebM), MP4 (QuickTime), Flash video, MPEG
        transport streams and Phantom cine are known; of AVI, the number of frames in its header is
        (elsewhere).
    stream_id : int
        The container's own number of the video stream.

    Returns
    -------
    Ending
        What is known.
    """
    with Path(path).open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if "matroska" in container:
            return _end_of_ebml(file, size)
        if "mov" in container:
            return _end_of_boxes(file, size)
        if container == "flv":
            return _end_of_tags(file, size)
        if container == "mpegts":
            return _end_of_transport(file, size, stream_id)
        if container == "cine":
            return _end_of_cine(file, size)
    return Ending.UNTOLD if container == "avi" else Ending.UNKNOWN


def _end_of_ebml(file: BinaryIO, size: int) -> Ending:
    """Walk the elements of a Matroska file (RFC 8794); live ones are of unknown size."""
    at, known = 0, True
    while at < size:
        file.seek(at)
        head = file.read(12)
        id_bytes = 9 - head[0].bit_length()
        if id_bytes > 4:
            return Ending.UNTOLD  # no element
        length_bytes = 9 - head[id_bytes].bit_length() if len(head) > id_bytes else 12
        at += id_bytes + length_bytes
        if at > size:
            break
        name = int.from_bytes(head[:id_bytes], "big")
        bits = 7 * length_bytes
        length = int.from_bytes(head[id_bytes : id_bytes + length_bytes], "big") & (1 << bits) - 1
        if length == (1 << bits) - 1 and name in (_SEGMENT, _CLUSTER):
            known = False  # its elements follow
        else:
            at += length
    return Ending.CUT if at > size else Ending.WHOLE if known else Ending.UNTOLD


def _end_of_boxes(file: BinaryIO, size: int) -> Ending:
    """Walk the boxes of an MP4 file (ISO/IEC 14496-12, 4.2); fragments may go on for ever."""
    at, in_fragments = 0, False
    while at < size:
        file.seek(at)
        head = file.read(16)
        length = int.from_bytes(head[:4], "big")
        if length == 1:
            length = int.from_bytes(head[8:16], "big")
        if len(head) >= 8 and length == 0:
            break  # up to the end of the file
        if len(head) >= 8 and length < 8:
            return Ending.UNTOLD  # no box
        in_fragments |= head[4:8] == b"moof"
        at += max(length, 8)
    return Ending.CUT if at > size else Ending.UNTOLD if in_fragments else Ending.WHOLE


def _end_of_tags(file: BinaryIO, size: int) -> Ending:
    """Walk the tags of a Flash video: 11 bytes, the data, 4 bytes."""
    at = int.from_bytes(file.read(9)[5:9], "big") + 4
    while at < size:
        file.seek(at)
        at += 15 + int.from_bytes(file.read(4)[1:4], "big")
    return Ending.CUT if at > size else Ending.UNTOLD


def _end_of_cine(file: BinaryIO, size: int) -> Ending:
    """Look where a Phantom camera says that its last picture is (CINEFILEHEADER, then offsets)."""
    n, _, _, offsets = struct.unpack("<4I", file.read(_CINE_HEADER_BYTES)[20:36])
    file.seek(offsets + 8 * (n - 1))
    last = int.from_bytes(file.read(8), "little")
    file.seek(last)
    note_bytes = int.from_bytes(file.read(4), "little")  # their last four are the picture's size
    file.seek(last + note_bytes - 4)
    at = last + note_bytes + int.from_bytes(file.read(4), "little")
    return Ending.CUT if not last or at > size else Ending.WHOLE


def _end_of_transport(file: BinaryIO, size: int, stream_id: int) -> Ending:
    """Look at the last packet of the video in a transport stream (ISO/IEC 13818-1, 2.4.3).

    A picture begins with a packet, so the last packet of the one before is filled up with
    stuffing bytes, but for the one time in 184 in which it fits.
    """
    file.seek(max(size - _TAIL_BYTES, 0))
    tail = file.read()
    for step, after in _TS_STEPS:
        begins = _packet_places(tail, step)
        if not begins:
            continue
        for at in reversed(begins):
            packet = tail[at : at + _TS_BYTES]
            if int.from_bytes(packet[1:3], "big") & 0x1FFF == stream_id and packet[3] & 0x10:
                if not _is_stuffed(packet):
                    return Ending.CUT_IN_PICTURE
                break
        rest = len(tail) - (begins[-1] + _TS_BYTES)
        return Ending.UNTOLD if rest == after else Ending.CUT
    return Ending.UNTOLD


def _packet_places(tail: bytes, step: int) -> list[int]:
    """Return where the whole packets of a transport stream begin; none where they do not."""
    for first in range(step):
        places = range(first, len(tail) - _TS_BYTES + 1, step)
        if len(places) >= _TS_LEAST and all(tail[at] == 0x47 for at in places):
            return list(places)
    return []


def _is_stuffed(packet: bytes) -> bool:
    """Tell whether a packet's adaptation field is longer than what it holds."""
    if not packet[3] & 0x20:
        return False
    length, flags = packet[4], packet[5]
    if length == 0:
        return True
    used = 1 + 6 * bool(flags & 0x10) + 6 * bool(flags & 0x08) + bool(flags & 0x04)
    for flag in (0x02, 0x01):  # private data, extension: their length comes first
        if flags & flag:
            used += 1 + (packet[5 + used] if 5 + used < _TS_BYTES else 0)
    return length > used
