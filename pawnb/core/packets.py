"""The packet index of a video file: which packet is which frame, and where to begin.

Pure bookkeeping on what the container says; :mod:`pawnb.core.video` lists the packets.
"""

from __future__ import annotations

import bisect
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

_UNKNOWN = np.iinfo(np.int64).min
_MOST_REORDERED = 16
"""Pictures that H.264 and HEVC allow to be decoded before one that is shown first."""
_IDR = {"h264": {5}, "hevc": {19, 20}}


class Packet(NamedTuple):
    """What the container says of one packet, in the order of decoding.

    Parameters
    ----------
    pts, dts : int or None
        Time of display and of decoding, in ticks.
    position : int or None
        Where it begins in the file, bytes.
    is_key : bool
        Whether decoding can begin here.
    is_hidden : bool
        Whether it is needed for decoding only (an edit list cuts it off).
    is_fresh : bool
        Whether display, too, begins anew here: nothing before it is shown after it.
    """

    pts: int | None
    dts: int | None
    position: int | None
    is_key: bool
    is_hidden: bool
    is_fresh: bool


class PacketIndex:
    """Frames and packets of a file, matched.

    Parameters
    ----------
    packets : sequence of Packet
        All packets, in the order of decoding.
    tick_s : float
        Unit of the time stamps, s.
    intra_only : bool
        Whether every packet of this codec is a whole picture.
    trusts_pts : bool
        Whether the container's display times can be believed where they are unique.
    rate_hz : float, optional
        The container's frame rate, used where the time stamps are of no use.
    is_cut : bool
        Whether packets are missing at the end. Then the last frames in the order of display
        are left out, as a frame shown before them may be among the missing.

    Attributes
    ----------
    n_packets, n_frames : int
        How many there are.
    numbers : ndarray of int, shape (n_packets,), or None
        Frame number of each packet, -1 where it is hidden; None where only counting the
        pictures that come out of the decoder tells.
    stamps_s : ndarray, shape (n_frames,)
        Time stamps, s.
    is_variable_rate : bool
        Whether they are not evenly spaced.
    """

    def __init__(
        self,
        packets: Sequence[Packet],
        *,
        tick_s: float,
        intra_only: bool,
        trusts_pts: bool,
        rate_hz: float | None = None,
        is_cut: bool = False,
    ) -> None:
        pts, dts, self._positions = (_column(packets, k) for k in range(3))
        self._dts = dts
        self._seek_ticks = np.where(dts != _UNKNOWN, dts, pts)
        hidden = np.array([p.is_hidden for p in packets], bool)
        trusted = intra_only or trusts_pts
        if is_cut and trusted and not intra_only and _UNKNOWN not in dts:
            hidden |= pts > dts[-1]  # a packet is never shown before it is decoded
        keys = np.array([p.is_key or intra_only for p in packets], bool)
        # a file may begin between key frames; sequential reading begins there all the same
        keys[:1] = True
        self.n_packets = len(packets)
        self.n_frames = int((~hidden).sum())
        shown = pts[~hidden]
        unique = len(np.unique(shown)) == len(shown) and _UNKNOWN not in shown
        self.numbers: np.ndarray | None = None
        ticks = np.sort(dts[~hidden])
        if unique and trusted:
            ticks = np.sort(shown)
            self.numbers = np.where(hidden, -1, np.searchsorted(ticks, pts))
            begins = [(int(np.searchsorted(ticks, pts[k])), int(k)) for k in np.flatnonzero(keys)]
        else:
            if intra_only:
                self.numbers = np.where(hidden, -1, np.cumsum(~hidden) - 1)
            else:
                keys = np.array([p.is_key and p.is_fresh for p in packets], bool)
                keys[:1] = True
            before = np.cumsum(~hidden) - ~hidden
            begins = [(int(before[k]), int(k)) for k in np.flatnonzero(keys)]
            if is_cut and not intra_only:
                self.n_frames = max(self.n_frames - _MOST_REORDERED, 0)
        begins.sort()
        self._firsts = [first for first, _ in begins]
        self._restarts = [packet for _, packet in begins]
        self._in_order = sorted(self._restarts)
        self.stamps_s, self.is_variable_rate = _stamps(ticks[: self.n_frames], tick_s, rate_hz)

    def restart_for(self, index: int) -> tuple[int, int]:
        """Return the packet to decode from for a frame, and the first frame it gives."""
        at = max(bisect.bisect_right(self._firsts, index) - 1, 0)
        return self._restarts[at], self._firsts[at]

    def spoilt_by(self, packet: int) -> set[int]:
        """Return the packets whose pictures cannot be relied upon where one is damaged.

        Those up to the next packet at which decoding can begin, and those after it that are
        shown before it, as they may rest on what came before. Where pictures are counted,
        one that is lost shifts the numbers of all that come out later, too.
        """
        at = bisect.bisect_right(self._in_order, packet)
        ends = [*self._in_order[at : at + 2], self.n_packets, self.n_packets]
        if self.numbers is None:
            return set(range(self._in_order[at - 1], ends[0]))
        spoilt = set(range(packet, ends[0]))
        leading = range(ends[0], ends[1])
        return spoilt.union(k for k in leading if self.numbers[k] < self.numbers[ends[0]])

    def is_shown(self, packet: int, first: int) -> bool:
        """Tell whether a packet gives a picture from frame ``first`` on."""
        return self.numbers is None or bool(self.numbers[packet] >= first)

    def is_restart(self, packet: int) -> bool:
        """Tell whether decoding can begin at a packet."""
        at = bisect.bisect_left(self._in_order, packet)
        return at < len(self._in_order) and self._in_order[at] == packet

    def identify(self, position: int | None, dts: int | None) -> int | None:
        """Return which packet lies at that position, or None where that is not certain."""
        if position is None or position < 0:
            return None
        found = np.flatnonzero(self._positions == position)
        if len(found) > 1 and dts is not None:
            found = found[self._dts[found] == dts]
        return int(found[0]) if len(found) == 1 else None

    def seek_ticks(self, packet: int, *, step: int) -> list[int]:
        """Return time stamps to seek to, in the order of trying, to land at or before a packet.

        Parameters
        ----------
        packet : int
            Where decoding is to begin.
        step : int
            How far to step back first, ticks; doubled each time.

        Returns
        -------
        list of int
            Ticks; empty where the packet has no time stamp.
        """
        tick, start = int(self._seek_ticks[packet]), int(self._seek_ticks[0])
        if tick == _UNKNOWN:
            return []
        tries = [tick]
        while start != _UNKNOWN and tries[-1] > start and len(tries) < 8:
            tries.append(max(tick - step, start))
            step *= 2
        return tries


def _column(packets: Sequence[Packet], field: int) -> np.ndarray:
    """Return one field of every packet, with ``_UNKNOWN`` for None."""
    return np.array([_UNKNOWN if p[field] is None else p[field] for p in packets], np.int64)


def _stamps(ticks: np.ndarray, tick_s: float, rate_hz: float | None) -> tuple[np.ndarray, bool]:
    """Return time stamps in seconds, and whether they are unevenly spaced."""
    n = len(ticks)
    if n < 2 or ticks[0] == _UNKNOWN or ticks[-1] == ticks[0]:
        return np.arange(n) / (rate_hz or 1.0), False
    even = np.linspace(ticks[0], ticks[-1], n)
    # time stamps are rounded to ticks: half a tick each, and at both ends of the line
    allowed = max(1.01, 1e-3 * (ticks[-1] - ticks[0]) / (n - 1))
    return ticks * tick_s, bool(np.abs(ticks - even).max() > allowed)


def may_begin_anew(codec: str) -> bool:
    """Tell whether :func:`begins_anew` looks at the packets of a codec."""
    return codec in _IDR


def begins_anew(data: bytes, codec: str, extradata: bytes | None) -> bool:
    """Tell whether a key packet starts display anew (H.264 and HEVC: an IDR picture).

    Parameters
    ----------
    data : bytes
        The packet.
    codec : str
        Name of the codec: other codecs than h264 and hevc give False.
    extradata : bytes, optional
        The codec's header; it tells whether units carry their length or a start code.

    Returns
    -------
    bool
        Whether the first picture unit is an IDR picture (ITU-T H.264 Table 7-1, types 1
        to 5; H.265 Table 7-1, types below 32).
    """
    if codec not in _IDR:
        return False
    for unit in _unit_heads(data, codec, extradata):
        kind = unit & 31 if codec == "h264" else unit >> 1 & 63
        if (1 <= kind <= 5) if codec == "h264" else kind < 32:
            return kind in _IDR[codec]
    return False


def _unit_heads(data: bytes, codec: str, extradata: bytes | None) -> Iterator[int]:
    """Yield the first byte of each unit of a packet."""
    at_length = 4 if codec == "h264" else 21
    if extradata and extradata[0] == 1 and len(extradata) > at_length:
        length_bytes = (extradata[at_length] & 3) + 1
        at = length_bytes
        while at < len(data):
            yield data[at]
            at += int.from_bytes(data[at - length_bytes : at], "big") + length_bytes
        return
    at = data.find(b"\x00\x00\x01")
    while 0 <= at < len(data) - 3:
        yield data[at + 3]
        at = data.find(b"\x00\x00\x01", at + 3)
