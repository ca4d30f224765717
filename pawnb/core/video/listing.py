"""The packets of a file, listed once without decoding, and whether some are missing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.video.beginnings import Beginning
from pawnb.core.video.endings import Ending, find_ending
from pawnb.core.video.packed import MPEG4, display_times, is_shown_at_once, unpacked
from pawnb.core.video.packets import MOST_REORDERED, Packet, PacketIndex
from pawnb.core.video.units import read_entry


def list_packets(
    path: Path, container: av.container.InputContainer, stream: av.video.stream.VideoStream
) -> tuple[PacketIndex, Ending, int]:
    """Read through a file once.

    Parameters
    ----------
    path : Path
        The file.
    container, stream
        The file, open, and the stream to list.

    Returns
    -------
    index : PacketIndex
        Its packets and frames.
    ending : Ending
        What is known of its end; ``CUT`` wherever pictures are missing.
    n_lost : int
        Pictures at the beginning that rest on others that were cut off; they are no frames.
    """
    codec = stream.codec_context
    name, extradata = codec.name, codec.extradata
    looks_inside = name in ("h264", "hevc")
    packets: list[Packet] = []
    at_once: list[bool] = []
    is_partial, end = False, 0
    beginning = Beginning(intra_only=codec.codec.intra_only)
    lost: list[Exception] = []
    for packet in read_packets(container, stream, lost):
        data = bytes(packet) if looks_inside else b""
        at_once.append(name == MPEG4 and is_shown_at_once(packet))
        is_key = packet.is_keyframe and not at_once[-1]  # as is what carries one after unpacking
        entry = read_entry(data, name, extradata, is_key=is_key)
        packets.append(
            Packet(packet.pts, packet.dts, packet.pos, packet.size, packet.is_discard, *entry)
        )
        beginning.add(packet, is_restart=entry.recovery is not None)
        is_partial = packet.is_corrupt
        end = max(end, (packet.pts or 0) + (packet.duration or 0))
    ending = find_ending(path, container.format.name, stream.id)
    is_partial |= ending is Ending.CUT_IN_PICTURE
    if packets and is_partial:
        packets.pop()
    if "avi" in container.format.name and name == MPEG4:
        packets = _timed_by_kind(packets, at_once)
    without = beginning.lost(packets, codec)
    packets = [p._replace(is_hidden=True) if k in without else p for k, p in enumerate(packets)]
    is_cut = is_partial or ending is Ending.CUT or bool(lost)
    is_cut = is_cut or _lacks_packets(container, stream, packets, end)
    times = [p.pts for p in packets if p.pts is not None and not p.is_hidden]
    # H.264 and HEVC in AVI, and streams that reorder but show no sign of it, carry
    # the order of decoding in the place of display times
    mistrusted = ("avi" in container.format.name and looks_inside) or (
        bool(codec.has_b_frames) and times == sorted(times)
    )
    reorders = _reorder_depth(packets) if codec.has_b_frames else 0
    is_open = ending in (Ending.UNTOLD, Ending.UNKNOWN)
    if is_open and not is_cut and not mistrusted and reorders:
        is_cut = _has_gap_at_end(packets, reorders)
    index = PacketIndex(
        packets,
        tick_s=float(stream.time_base or 1),
        intra_only=codec.codec.intra_only,
        trusts_pts=not mistrusted,
        rate_hz=float(stream.average_rate) if stream.average_rate else None,
        is_cut=is_cut,
        reorders=reorders,
        counts_ticks="avi" in container.format.name,
    )
    return index, Ending.CUT if is_cut else ending, len(without)


def _timed_by_kind(packets: list[Packet], at_once: list[bool]) -> list[Packet]:
    """Return packets of MPEG-4 in AVI, which has no display times, with those of their kinds."""
    shown = display_times([p.dts for p in packets], at_once[: len(packets)])
    return [p._replace(pts=pts) for p, pts in zip(packets, shown, strict=True)]


def read_packets(
    container: av.container.InputContainer,
    stream: av.video.stream.VideoStream,
    lost: list[Exception] | None = None,
) -> Iterator[av.Packet]:
    """Yield packets that hold data, up to the end or to where the file is damaged.

    Parameters
    ----------
    container, stream
        The file, open, and the stream to read.
    lost : list, optional
        Told why what comes after a damaged place cannot be read. (PyAV raises IndexError for a
        packet of a stream that was not there when the file was opened.)

    Yields
    ------
    av.Packet
        Packets in the order of the file.
    """
    packets: Iterator[av.Packet] = (packet for packet in container.demux(stream) if packet.size)
    try:
        if stream.codec_context.name == MPEG4:
            packets = unpacked(packets, stream)
        yield from packets
    except (av.FFmpegError, IndexError) as error:
        if lost is not None:
            lost.append(error)


def _lacks_packets(
    container: av.container.InputContainer,
    stream: av.video.stream.VideoStream,
    packets: list[Packet],
    end: int,
) -> bool:
    """Tell whether the file's header promises more packets than there are."""
    if stream.frames <= len(packets):
        return False
    if container.format.name == "avi" and packets:
        # a dropped frame is an empty chunk: it is counted, moves the time on, and is no packet;
        # so is every other one of a film that was copied at twice its rate
        return (packets[-1].dts or 0) + max(_times(packets)[2], 1) < stream.frames
    if "mov" not in container.format.name or not stream.duration:
        return True
    # an edit list may leave frames out: then the duration agrees with what is there
    missing = (stream.start_time or 0) + stream.duration - end
    return missing * 2 > stream.duration / stream.frames


def _times(packets: list[Packet]) -> tuple[FloatArray, FloatArray, float]:
    """Return display and decoding times, NaN where unknown, and the usual step from frame to frame.

    Decoding times are even where display times, in the order of the file, are not.
    """
    pts, dts = (
        np.array([np.nan if t is None else t for t in times], float)
        for times in ([p.pts for p in packets], [p.dts for p in packets])
    )
    steps = np.diff(dts if np.isfinite(dts).all() else np.sort(pts))
    return pts, dts, float(np.median(steps)) if len(steps) else 0.0


def _reorder_depth(packets: list[Packet]) -> int:
    """Return how many pictures at most are decoded before one that is shown first.

    Seen in the packets themselves, and in the head start of the first decoding time.
    """
    pts, dts, step = _times(packets)
    is_told = np.isfinite(dts).all() and np.isfinite(pts[:1]).all() and step > 0
    if len(packets) <= MOST_REORDERED and not is_told:
        return MOST_REORDERED
    seen = int(np.max(np.argsort(pts, kind="stable") - np.arange(len(pts))))
    return min(max(seen, round((pts[0] - dts[0]) / step) if is_told else 0), MOST_REORDERED)


def _has_gap_at_end(packets: list[Packet], reorders: int) -> bool:
    """Tell whether a picture shown before one of the last is missing, by times else even."""
    pts, _, step = _times([p for p in packets if not p.is_hidden])
    if not step > 0 or not np.isfinite(pts).all():
        return False
    is_gap = np.diff(np.sort(pts)) > 1.5 * step
    return bool(is_gap[-reorders:].any() and not is_gap[:-reorders].any())
