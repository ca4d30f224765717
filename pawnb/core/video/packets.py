"""The packet index of a video file: which packet is which frame, and where to begin.

Pure bookkeeping on what the container says; :mod:`pawnb.core.video` lists the packets.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pawnb.arrays import BoolArray, IntArray

_UNKNOWN = np.iinfo(np.int64).min
MOST_REORDERED = 16
"""Pictures that H.264 and HEVC allow to be decoded before one that is shown first."""


class Packet(NamedTuple):
    """What the container says of one packet, in the order of decoding.

    Parameters
    ----------
    pts, dts : int or None
        Time of display and of decoding, in ticks.
    position, size : int or None
        Where it begins in the file and how long it is, bytes.
    is_hidden : bool
        Whether it is needed for decoding only (an edit list cuts it off).
    recovery : int or None
        Where decoding begins here, reference pictures, counted from this one, after which
        pictures are exact; None where decoding cannot begin here.
    is_fresh : bool
        Whether display, too, begins anew here: nothing before it is shown after it.
    is_sure : bool
        Whether a picture that cannot be decoded from here on is damaged for certain.
    is_reference : bool
        Whether other pictures may rest on this one.
    """

    pts: int | None
    dts: int | None
    position: int | None
    size: int
    is_hidden: bool
    recovery: int | None
    is_fresh: bool = False
    is_sure: bool = True
    is_reference: bool = True


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
    reorders : int
        Most pictures that are decoded before one that is shown first.
    counts_ticks : bool
        Whether time stamps are counts (of the chunks of an AVI), not times rounded to ticks.

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
    begins_anew : bool
        Whether time begins anew within the file; stamps are then those of an even rate.
    frame_bytes : ndarray of int, shape (n_frames,), or None
        Bytes of the packet of each frame; None where ``numbers`` is.
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
        reorders: int = MOST_REORDERED,
        counts_ticks: bool = False,
    ) -> None:
        pts, dts, self._positions, self._sizes = (_column(packets, k) for k in range(4))
        self._dts = dts
        is_lacking = dts == _UNKNOWN
        # long files have hundreds of thousands of packets: one column where one will do
        self._seek_ticks = np.where(is_lacking, pts, dts) if is_lacking.any() else dts
        hidden = np.array([p.is_hidden for p in packets], bool)
        self.begins_anew = _goes_back(dts)
        trusted = (intra_only or trusts_pts) and not self.begins_anew
        trusted = trusted and _UNKNOWN not in pts[~hidden] and not _repeats(pts[~hidden])
        if is_cut and trusted and not intra_only:
            hidden |= _uncertain_at_end(pts, hidden, reorders)
        self.n_packets = len(packets)
        self.n_frames = int((~hidden).sum())
        self.numbers: np.ndarray | None = None
        ticks = np.sort(dts[~hidden])
        places = np.cumsum(~hidden) - ~hidden
        if trusted:
            ticks = np.sort(pts[~hidden])
            places = np.searchsorted(ticks, pts)
        if trusted or intra_only:
            self.numbers = np.where(hidden, -1, places).astype(np.int32)
        elif is_cut:
            self.n_frames = max(self.n_frames - MOST_REORDERED, 0)
        self.frame_bytes = self._bytes_of_frames()
        # arrays, as each packet of Motion JPEG is one at which decoding can begin
        self._firsts, self._restarts = np.array(self._begins(packets, places), np.int32).T.copy()
        self._in_order = np.sort(self._restarts)
        is_sure = [k == 0 or packets[k].is_sure for k in self._in_order.tolist()]
        self._sure = self._in_order[np.array(is_sure, bool)]
        ticks = ticks[: self.n_frames]
        if self.begins_anew:
            ticks = np.full(len(ticks), _UNKNOWN)
        self.stamps_s, is_uneven = _stamps(ticks, tick_s, rate_hz)
        is_uneven |= counts_ticks and len(np.unique(np.diff(ticks))) > 1
        self.is_variable_rate = is_uneven

    def _bytes_of_frames(self) -> IntArray | None:
        """Return how long the packets of the frames are, where it is known whose they are."""
        if self.numbers is None:
            return None
        known = (self.numbers >= 0) & (self.numbers < self.n_frames)
        lengths = np.zeros(self.n_frames, np.int64)
        lengths[self.numbers[known]] = self._sizes[known]
        return lengths

    def _begins(self, packets: Sequence[Packet], places: IntArray) -> list[tuple[int, int]]:
        """Return the packets where decoding can begin, and before them the first exact frame."""
        references = np.flatnonzero([p.is_reference for p in packets])
        begins = []
        for k, packet in enumerate(packets):
            if packet.recovery is None or (self.numbers is None and not packet.is_fresh):
                continue
            exact = k
            if packet.recovery:
                at = np.searchsorted(references, k) + packet.recovery
                if at >= len(references):
                    continue
                exact = int(references[at])
            begins.append((int(max(places[exact], places[k])), k))
        if not any(k == 0 for _, k in begins):
            # a file may begin in between; sequential reading begins there all the same
            begins.append((0, 0))
        return sorted(begins)

    def restarts_for(self, index: int) -> list[tuple[int, int]]:
        """Return where to decode a frame from, in the order of trying.

        Parameters
        ----------
        index : int
            The frame.

        Returns
        -------
        list of tuple of int
            The packet to decode from and the first frame that it gives. Where the nearest is
            one from which a sound picture may fail to come, a second one from which it cannot.
        """
        at = max(_up_to(self._firsts, index) - 1, 0)
        found = [(int(self._restarts[at]), int(self._firsts[at]))]
        before = _up_to(self._sure, found[0][0]) - 1
        sure = int(self._sure[max(before, 0)])
        if sure < found[0][0]:
            found.append((sure, self._first_of(sure)))
        return found

    def _first_of(self, packet: int) -> int:
        """Return the first exact frame of a packet at which decoding can begin."""
        return int(self._firsts[np.flatnonzero(self._restarts == packet)[0]])

    def spoilt_by(self, packet: int) -> set[int]:
        """Return the packets whose pictures cannot be relied upon where one is damaged.

        Those up to the next packet at which decoding can begin, and those after it that are
        shown before the first exact one, as they may rest on what came before. Where pictures
        are counted, one that is lost shifts the numbers of all that come out later, too.
        """
        at = _up_to(self._in_order, packet)
        end = int(self._in_order[at]) if at < len(self._in_order) else self.n_packets
        if self.numbers is None:
            return set(range(int(self._in_order[at - 1]), end))
        spoilt = set(range(packet, end))
        if end < self.n_packets:
            leading = end + np.flatnonzero(self.numbers[end:] < self._first_of(end))
            spoilt.update(leading.tolist())
        return spoilt

    def is_shown(self, packet: int, first: int) -> bool:
        """Tell whether a packet gives a picture from frame ``first`` on."""
        return self.numbers is None or bool(self.numbers[packet] >= first)

    def number_of_restart(self, packet: int) -> int | None:
        """Return the frame from which counting begins anew at a packet, None where it does not."""
        at = _up_to(self._in_order, packet)
        is_restart = at > 0 and int(self._in_order[at - 1]) == packet
        return self._first_of(packet) if is_restart else None

    def identify(self, position: int | None, size: int, *, dts: int | None) -> int | None:
        """Return which packet lies at that position, or None where that is not certain.

        Parameters
        ----------
        position, size : int or None
            Where a packet begins in the file and how long it is, bytes.
        dts : int or None
            Its decoding time, ticks.

        Returns
        -------
        int or None
            Its number in the file.

        Notes
        -----
        In MPEG program streams what is left of the picture before comes first, at the
        position and with the time of the one that was sought: only its size is another.
        """
        if position is None or position < 0:
            return None
        found = np.flatnonzero((self._positions == position) & (self._sizes == size))
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


def _up_to(numbers: IntArray, number: int) -> int:
    """Return how many of sorted numbers are not above one."""
    return int(np.searchsorted(numbers, number, side="right"))


def _column(packets: Sequence[Packet], field: int) -> IntArray:
    """Return one field of every packet, with ``_UNKNOWN`` for None."""
    return np.array([_UNKNOWN if p[field] is None else p[field] for p in packets], np.int64)


def _repeats(ticks: IntArray) -> bool:
    """Tell whether a time stamp is there twice."""
    return len(np.unique(ticks)) < len(ticks)


def _goes_back(dts: IntArray) -> bool:
    """Tell whether time begins anew: decoding times go back by more than pictures are reordered."""
    steps = np.diff(dts[dts != _UNKNOWN])
    return len(steps) > 0 and bool(steps.min() < -MOST_REORDERED * max(np.median(steps), 1))


def _uncertain_at_end(pts: IntArray, hidden: BoolArray, reorders: int) -> np.ndarray:
    """Return which pictures may be shown after one that is missing at the end.

    A missing picture comes after all that are there in the order of decoding. In the order of
    display it is at most ``reorders`` earlier than that.
    """
    shown = np.flatnonzero(~hidden)
    order = shown[np.argsort(pts[shown])]
    uncertain = np.zeros(len(pts), bool)
    uncertain[order[max(len(order) - reorders, 0) :]] = True
    return uncertain


def _stamps(ticks: IntArray, tick_s: float, rate_hz: float | None) -> tuple[np.ndarray, bool]:
    """Return time stamps in seconds, and whether they are unevenly spaced."""
    n = len(ticks)
    if n < 2 or ticks[0] == _UNKNOWN or ticks[-1] == ticks[0]:
        return np.arange(n) / (rate_hz or 1.0), False
    even = np.linspace(ticks[0], ticks[-1], n)
    # time stamps are rounded to ticks: half a tick each, and at both ends of the line
    allowed = max(1.01, 1e-3 * (ticks[-1] - ticks[0]) / (n - 1))
    return ticks * tick_s, bool(np.abs(ticks - even).max() > allowed)
