"""Video files, exactly: the frame you ask for is the frame you get.

Containers lie about where frames are: key frames of H.264 in AVI carry no usable
display time, edit lists hide frames, time stamps are missing, repeated or uneven.
So the packets of a file are listed once when it is opened (no decoding), every
packet is fed to the decoder under its own number, and so every picture that comes
out is known by the packet it came from. Seeking goes to a packet where decoding can
begin, checks where it landed, and decodes on.
"""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict, deque
from collections.abc import Iterator
from pathlib import Path

import av
import numpy as np

from pawnb.core.pixels.colour import PartPicture, Picture
from pawnb.core.pixels.planes import picture_of_frame
from pawnb.core.pixels.turned import Turn, TurnedPicture, turn_of_frame
from pawnb.core.video.doubts.interlaced import HOW_TO_MEND
from pawnb.core.video.endings import Ending
from pawnb.core.video.listing import list_packets, read_packets
from pawnb.core.video.packets import PacketIndex
from pawnb.core.video.parts import PartReader
from pawnb.errors import VideoError
from pawnb.files import check_file

_EXPECTED = "a video file, a folder of pictures or a glob such as frames/*.png"

_BLOCK_BYTES = 64 * 2**20
"""Memory for pictures met on the way to the one asked for: stepping back needs them.

A decoder keeps the memory of as many as it ever had to hold.
"""

_SQUARE_WITHIN = 0.01
"""How far from 1 the sides of a pixel may be: less than a paw can be placed."""

_MOST_BROKEN_INTO = 4
"""Packets after a seek of which one must be known; the first may be what is left of a picture."""

_MOST_REORDERED = 32
"""Packets after which a picture that has not come out never will (H.264 allows 16)."""


class VideoFile:
    """The first video stream of a file.

    Parameters
    ----------
    path : str or Path
        The file.
    n_files : int
        How many files share the memory for stepping back.

    Attributes
    ----------
    n_frames, width, height : int
        Number and size of the frames as they are shown, px.
    stamps_s : ndarray, shape (n_frames,)
        The container's time stamps, s.
    is_variable_rate : bool
        Whether they are not evenly spaced.
    filmed_fps : float or None
        Frames per second of the recording, where the camera wrote them into the file.
    frame_bytes : ndarray of int, shape (n_frames,), or None
        Bytes that each frame takes in the file, where that is known.
    notes : list of str
        What a user should know, in plain sentences: a file that is cut short, turned,
        interlaced, or whose pixels are not square.

    Raises
    ------
    VideoError
        If the file is missing, is not a video, or holds no frame that can be decoded.

    Notes
    -----
    One codec thread a file: views are decoded side by side in threads of their own, and
    an error can be distinguished from the packet that caused it.
    """

    def __init__(self, path: str | Path, *, n_files: int = 1) -> None:
        self.path = Path(path)
        self._n_files = n_files
        self.name = str(path)
        self.notes: list[str] = []
        self._lock = threading.RLock()
        self._is_open = True
        self._container, self._stream = self._open()
        self._decoded: Iterator[tuple[int, av.VideoFrame | PartPicture | None]] = iter(())
        self._partly = False
        self._parts = PartReader() if self._stream.codec_context.name == "mjpeg" else None
        self._kept: OrderedDict[int, Picture] = OrderedDict()
        try:
            self._index = self._list_packets()
            # only the first packet that is ever read carries a palette
            self._has_palette = self._stream.pix_fmt == "pal8"
            self.n_frames = self._index.n_frames
            self.stamps_s: np.ndarray | None = self._index.stamps_s
            self.is_variable_rate = self._index.is_variable_rate
            self.filmed_fps = _filmed_fps(self._container)
            self.frame_bytes = self._index.frame_bytes
            self._coded = self._stream.width, self._stream.height
            size = max(self._coded[0] * self._coded[1] * 2, 1)
            self._block = min(max(_BLOCK_BYTES // (n_files * size), 4), 64)
            self._at: int | None = None
            self._began = 0
            self._turn: Turn | None = None
            self._is_looked_at = self._is_interlaced = False
            first = self.grab(0)
            self.width, self.height = first.width, first.height
            self.notes += self._shape_notes()
        except VideoError:
            self.close()
            raise

    def grab(self, index: int, *, partly: bool = False) -> Picture:
        """Return the picture of that number.

        Parameters
        ----------
        index : int
            Frame number, 0 for the first that the file shows.
        partly : bool
            Whether only small parts of it will be looked at: Motion JPEG is then read
            through, and decoded where it is looked at. What they hold is the same.

        Returns
        -------
        Picture
            The decoded planes.

        Raises
        ------
        VideoError
            If that frame cannot be decoded, or the file is closed.
        """
        with self._lock:
            if not self._is_open:
                raise VideoError(f"{self.name} is closed; open it again to read frame {index}.")
            if index in self._kept:
                return self._kept[index]
            self._partly = partly
            restarts = self._index.restarts_for(index)
            for restart, first in restarts:
                picture = self._found(index, restart, first)
                if picture is not None:
                    return picture
                if self._began <= restarts[-1][0]:  # read from where it would have come
                    break
            raise VideoError(
                f"{self.name}: frame {index} cannot be decoded; the file is damaged there or "
                "shortly before."
            )

    def _found(self, index: int, restart: int, first: int) -> Picture | None:
        """Return a picture, reading on from where it is or from ``restart``; None if damaged."""
        reads_on = self._at is not None and first - 1 <= self._at < index
        if not reads_on:
            self._kept.clear()
            self._begin_at(restart, first)
        for number, frame in self._decoded:
            self._at = number
            if number > index:
                break
            if frame is not None:
                self._kept[number] = self._picture(frame, number)
            while len(self._kept) > (1 if reads_on else self._block):
                self._kept.popitem(last=False)
            if number == index:
                break
        return self._kept.get(index)

    def again(self) -> VideoFile:
        """Open the file once more, to be read and closed by itself."""
        return VideoFile(self.path, n_files=self._n_files)

    def close(self) -> None:
        """Close the file; reading after that is refused."""
        with self._lock:
            self._is_open = False
            self._decoded = iter(())
            self._kept.clear()
            self._container.close()

    def _open(self) -> tuple[av.container.InputContainer, av.video.stream.VideoStream]:
        """Open the file and its first video stream."""
        check_file(self.path, expected=_EXPECTED, error=VideoError)
        if not self.path.stat().st_size:
            raise VideoError(
                f"{self.name}: the file is empty (0 bytes); record it or copy it once more."
            )
        try:
            # a name is a file's, whatever it looks like, and no file fetches another
            container = av.open(
                f"file:{self.name}", container_options={"protocol_whitelist": "file"}
            )
        except (av.FFmpegError, OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise VideoError(
                f"{self.name}: not a video that can be read ({reason}); it may be cut short, "
                "damaged or of another kind."
            ) from None
        stream = next(iter(_films(container)), None)
        if stream is None:
            container.close()
            raise VideoError(
                f"{self.name}: holds no video that can be read; it may be cut short, damaged or "
                "hold sound only."
            )
        stream.codec_context.thread_count = 1
        return container, stream

    def _list_packets(self) -> PacketIndex:
        """Read through the file once without decoding, and note where it is cut short."""
        stream = self._stream
        index, ending, n_lost = list_packets(self.path, self._container, stream)
        if not index.n_frames:
            raise VideoError(f"{self.name}: holds no whole frame; the file is empty or cut short.")
        n_films = len(_films(self._container))
        if n_films > 1:
            self.notes.append(
                f"{self.name} holds {n_films} films; the first is used ({stream.width} x "
                f"{stream.height} px, frames: {index.n_frames})."
            )
        if n_lost:
            self.notes.append(
                f"{self.name} begins in between, as films do that were cut without being encoded "
                f"anew: pictures at its beginning ({n_lost}) rest on others that were cut off, and "
                "are left out; frame 0 is the first after them."
            )
        if index.begins_anew:
            self.notes.append(
                f"{self.name}: its time stamps begin anew within the file, as in recordings that "
                "were put one behind the other; frames are taken to be evenly spaced, and nothing "
                "is known of the time between the recordings."
            )
        if ending is Ending.UNKNOWN:
            self.notes.append(
                f"{self.name}: a file of this kind ({self._container.format.name}) does not tell "
                "whether it is whole; look whether its last frame is."
            )
        if ending is Ending.CUT:
            promised = f"it promises {stream.frames} frames and "
            self.notes.append(
                f"{self.name} is cut short: {promised * (stream.frames > index.n_packets)}"
                f"ends with frame {index.n_frames - 1}."
            )
        return index

    def _shape_notes(self) -> list[str]:
        """Say where the picture is shown otherwise than it was kept, or is not to scale."""
        notes = []
        if self._turn is not None:
            notes.append(
                f"{self.name} says how the camera was held: its pictures are {self._turn.words}, "
                "as players show them, and positions are counted in these."
            )
        if self._is_interlaced:
            notes.append(
                f"{self.name} says that its pictures are interlaced, each of two that were taken "
                f"one after the other: {HOW_TO_MEND}"
            )
        aspect = self._stream.sample_aspect_ratio
        if aspect and abs(float(aspect) - 1.0) > _SQUARE_WITHIN:
            notes.append(
                f"{self.name}: its pixels are {float(aspect):.3g} times as wide as high. Lengths "
                "and angles are wrong where views are not calibrated by DLT; make the pixels "
                "square with: ffmpeg -i IN -vf scale=iw*sar:ih,setsar=1 -crf 12 OUT.mp4"
            )
        return notes

    def _begin_at(self, restart: int, first: int) -> None:
        """Make ``self._decoded`` start with the picture ``first``, decoding from ``restart``."""
        packets = self._seek(restart)
        self._at, self._began = first - 1, restart
        self._decoded = self._decode(packets, first)

    def _seek(self, restart: int) -> Iterator[tuple[int, av.Packet | None]]:
        """Return the packets from ``restart`` on, each with its number; None ends them."""
        step = int(0.25 / float(self._stream.time_base or 1)) + 1
        ticks_to_try = self._index.seek_ticks(restart, step=step)
        if self._has_palette and self._at is None:
            ticks_to_try = []
        for ticks in ticks_to_try:
            try:
                self._container.seek(ticks, stream=self._stream, backward=True)
            except av.FFmpegError:
                continue
            packets = read_packets(self._container, self._stream)
            for head in itertools.islice(packets, _MOST_BROKEN_INTO):
                landed = self._index.identify(head.pos, head.size, dts=head.dts)
                if landed is not None and landed <= restart:
                    return self._numbered(itertools.chain([head], packets), landed, restart)
        self._container.close()
        self._container, self._stream = self._open()
        packets = read_packets(self._container, self._stream)
        return self._numbered(packets, 0, 0 if self._has_palette else restart)

    def _numbered(
        self, packets: Iterator[av.Packet], landed: int, restart: int
    ) -> Iterator[tuple[int, av.Packet | None]]:
        """Yield packets numbered from ``landed`` on, and leave out what lies before ``restart``."""
        for number, packet in enumerate(packets, landed):
            if restart <= number < self._index.n_packets:
                packet.pts = packet.dts = number  # the picture carries it out of the decoder
                yield number, packet
        yield self._index.n_packets, None

    def _decode(
        self, packets: Iterator[tuple[int, av.Packet | None]], first: int
    ) -> Iterator[tuple[int, av.VideoFrame | PartPicture | None]]:
        """Yield pictures in the order of display from ``first`` on; None where damaged.

        A picture may rest on one that was decoded before it and is shown after it. So each
        is held back until all that were decoded before it have come out and proved sound.
        """
        index = self._index
        spoilt: set[int] = set()  # packets whose pictures cannot be relied upon
        inside: set[int] = set()  # packets whose pictures have not come out yet
        held: deque[tuple[int, int, av.VideoFrame]] = deque()
        count = first
        for at, packet in packets:
            if packet is not None and index.is_shown(at, first):
                inside.add(at)
            part = self._part(packet)
            if part is not None and index.numbers is not None:
                inside.discard(at)
                if index.numbers[at] >= first:
                    yield int(index.numbers[at]), part
                continue
            try:
                frames = self._stream.codec_context.decode(packet)
            except av.FFmpegError:
                frames = []
                inside.discard(at)
                spoilt.update(index.spoilt_by(at))
            for frame in frames:
                came_from = -1 if frame.pts is None else int(frame.pts)
                inside.discard(came_from)
                if index.numbers is None:
                    anew = index.number_of_restart(came_from)
                    number = count if anew is None else anew
                    count = number + 1
                else:
                    number = int(index.numbers[came_from]) if came_from >= 0 else -1
                if number < first:  # hidden, or shown before the picture decoding began with
                    continue
                if frame.is_corrupt and came_from not in spoilt:
                    spoilt.update(index.spoilt_by(came_from))
                held.append((number, came_from, frame))
            late = packet is None  # the decoder is empty: nothing is inside any more
            inside = set() if late else {p for p in inside if p > at - _MOST_REORDERED}
            while held and (not inside or min(inside) > held[0][1]):
                number, came_from, frame = held.popleft()
                yield number, None if came_from in spoilt else frame

    def _part(self, packet: av.Packet | None) -> PartPicture | None:
        """Return the picture of a packet that need not be decoded now, if there is one."""
        if packet is None or self._parts is None or not self._partly:
            return None
        return self._parts.read(packet, self._stream.codec_context)

    def _picture(self, frame: av.VideoFrame | PartPicture, number: int) -> Picture:
        """Return the decoded planes in the shape that fits their format."""
        width, height = self._coded
        if (frame.width, frame.height) != (width, height):
            raise VideoError(
                f"{self.name}: frame {number} is {frame.width} x {frame.height} px, but the video "
                f"is {width} x {height}; all frames must be of one size."
            )
        if isinstance(frame, PartPicture):
            picture: Picture = frame
        else:
            picture = picture_of_frame(frame)
            if not self._is_looked_at:  # what holds of the first holds of all
                self._turn, self._is_looked_at = turn_of_frame(frame), True
                self._is_interlaced = frame.interlaced_frame
        return picture if self._turn is None else TurnedPicture(picture, self._turn)


def _filmed_fps(container: av.container.InputContainer) -> float | None:
    """Return the rate that Android's cameras write beside a film, also one in slow motion."""
    try:
        rate = float(container.metadata.get("com.android.capture.fps", ""))
    except ValueError:
        return None
    return rate if 0.0 < rate < float("inf") else None


def _films(container: av.container.InputContainer) -> list[av.video.stream.VideoStream]:
    """Return the video streams of a file that can be read, without a cover picture."""
    cover = av.stream.Disposition.attached_pic
    return [
        s
        for s in container.streams.video
        if s.codec_context is not None and not s.disposition & cover
    ]
