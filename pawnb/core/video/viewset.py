"""The views of a trial side by side, read ahead in threads."""

from __future__ import annotations

import operator
import os
import threading
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.closing import Closing
from pawnb.core.video.views import Frame, ViewReader, no_such_frame
from pawnb.errors import VideoError

_MANY = 0.05
"""Share of odd intervals between frames above which these are not frames that were dropped."""

_FASTER = 1.5
"""How many times as fast as it was filmed a film may be played before it is said."""

_OTHER_FPS = 1.2
"""How many times the rate that a camera wrote into its file may differ before it is said: phones
write 30 for 29.97, and films in slow motion 120 or 240 that are played at 30."""

READ_AHEAD = 4
"""Frames of each view that may wait, decoded, for whoever asked for them."""

_OTHER_RATE = 0.05
"""Frame rates of two files that differ by more are not one rate, written in two ways (by hand)."""


class ViewSet(Closing):
    """The views of a trial, side by side, numbered by trial frames.

    Made by :func:`pawnb.core.video.open_views`; a context manager. The file's frame is
    the trial's frame plus the offset of the view.

    Parameters
    ----------
    readers : mapping of str to ViewReader
        The views by name, in the order of the trial.
    offsets : mapping of str to int
        Each file's frame that belongs to frame 0 of the trial; 0 where not named.
    fps : float
        Frames per second of the recording.

    Attributes
    ----------
    names : tuple of str
        Names of the views.
    readers : dict of str to ViewReader
        The views, by name.
    first_frame : int
        First trial frame that every view has (0 unless an offset is negative).
    n_frames : int
        One past the last trial frame that every view has.
    notes : list of str
        What a user should know about the files, in plain sentences.

    Raises
    ------
    VideoError
        If no frame is common to all views.
    """

    def __init__(
        self,
        readers: Mapping[str, ViewReader],
        *,
        fps: float,
        offsets: Mapping[str, int] | None = None,
    ) -> None:
        self.readers = dict(readers)
        self.names = tuple(self.readers)
        self._fps = fps
        self._pool: ThreadPoolExecutor | None = None  # made when it is first of use
        self._pool_lock, self._is_closed = threading.Lock(), False
        self._offsets = {name: (offsets or {}).get(name, 0) for name in self.names}
        ends = {name: r.n_frames - self._offsets[name] for name, r in self.readers.items()}
        self.first_frame = max(0, *(-offset for offset in self._offsets.values()))
        self.n_frames = min(ends.values())
        if self.n_frames <= self.first_frame:
            shortest = min(ends, key=ends.__getitem__)
            raise VideoError(
                f"view {shortest!r} ends at frame {self.n_frames - 1} of the trial, before every "
                f"view has begun (frame {self.first_frame}); mend the offsets."
            )
        self.notes = [*self._file_notes(), *self._rate_notes(), *self._length_notes(ends)]

    @property
    def time_s(self) -> FloatArray:
        """Time of each trial frame, s, shape (n_frames,), 0 at frame 0.

        Frame / fps; where the rate of a file varies, the time stamps of the first such view.
        """
        for name, reader in self.readers.items():
            offset = self._offsets[name]
            if reader.is_variable_rate and offset >= 0:
                stamps = reader.time_s[offset : offset + self.n_frames]
                return stamps - stamps[0]
        return np.arange(self.n_frames) / self._fps

    def frame(self, index: int) -> dict[str, Frame]:
        """Return one trial frame of every view.

        Parameters
        ----------
        index : int
            Trial frame.

        Returns
        -------
        dict of str to Frame
            One frame a view; ``Frame.index`` is the trial frame.

        Raises
        ------
        VideoError
            If a view lacks that frame or it cannot be decoded.
        """
        index = operator.index(index)
        self._check(index)
        found: dict[str, Frame] = {}
        for part in self._side_by_side(index):
            found.update(part)
        return {name: found[name] for name in self.names}

    def _side_by_side(self, index: int) -> list[dict[str, Frame]]:
        """Read one frame of all files, each in a thread: decoding is most of the time."""
        groups = self._groups()
        with self._pool_lock:
            if self._pool is None and len(groups) > 1 and not self._is_closed:
                workers = min(len(groups), os.cpu_count() or 1)
                self._pool = ThreadPoolExecutor(workers, thread_name_prefix="pawnb-frame")
            jobs = [self._pool.submit(self._read, g, index) for g in groups] if self._pool else []
        if jobs:
            return [job.result() for job in jobs]
        return [self._read(group, index) for group in groups]

    def frames(
        self, start: int, stop: int, *, step: int = 1, partly: bool = False
    ) -> Iterator[tuple[int, dict[str, Frame]]]:
        """Iterate over trial frames, read ahead in one thread a file.

        Parameters
        ----------
        start, stop, step : int
            As in :class:`range`: backwards from 99 to 0 is ``frames(99, -1, step=-1)``.
        partly : bool
            Whether only small parts of each frame will be looked at. Where the file allows
            it (Motion JPEG), no more than these is decoded, when they are asked for; what
            they hold is the same.

        Yields
        ------
        index : int
            Trial frame.
        frames : dict of str to Frame
            One frame a view.

        Raises
        ------
        VideoError
            If a view lacks a frame of the range (at once), or one cannot be decoded (after
            the frames before it were handed out).
        """
        numbers = range(start, stop, step)
        for end in (numbers[0], numbers[-1]) if numbers else ():
            self._check(end)
        return self._ahead(numbers, partly=partly)

    def _ahead(self, numbers: range, *, partly: bool) -> Iterator[tuple[int, dict[str, Frame]]]:
        """Keep up to READ_AHEAD frames of each file in the making or waiting."""
        groups = self._groups()
        pools = [ThreadPoolExecutor(1, thread_name_prefix=f"pawnb-{g[0]}") for g in groups]
        waiting: deque[tuple[int, list[Future[dict[str, Frame]]]]] = deque()
        todo = iter(numbers)
        try:
            for _ in numbers:
                while len(waiting) < READ_AHEAD and (following := next(todo, None)) is not None:
                    jobs = zip(pools, groups, strict=True)
                    waiting.append(
                        (following, [p.submit(self._read, g, following, partly) for p, g in jobs])
                    )
                index, futures = waiting.popleft()
                found: dict[str, Frame] = {}
                for future in futures:
                    found.update(future.result())
                del futures, future
                yield index, {name: found.pop(name) for name in self.names}
        finally:
            for pool in pools:
                pool.shutdown(wait=True, cancel_futures=True)

    def _groups(self) -> list[list[str]]:
        """Return the names of views that show the same frame of the same file together."""
        groups: dict[tuple[int, int], list[str]] = {}
        for name, reader in self.readers.items():
            groups.setdefault((id(reader.source), self._offsets[name]), []).append(name)
        return list(groups.values())

    def _read(self, group: Sequence[str], index: int, partly: bool = False) -> dict[str, Frame]:
        """Decode one file's picture once and return the frame of each of its views."""
        picture = self.readers[group[0]].grab(index + self._offsets[group[0]], partly=partly)
        return {name: self.readers[name].frame_of(picture, index) for name in group}

    def _check(self, index: int) -> None:
        """Raise VideoError unless every view has that trial frame."""
        for name, reader in self.readers.items():
            at = index + self._offsets[name]
            if not 0 <= at < reader.n_frames:
                where = f" (frame {index} of the trial)" if self._offsets[name] else ""
                raise VideoError(f"view {name!r}: {no_such_frame(reader.source, at)[:-1]}{where}.")

    def check_range(self, start: int, stop: int) -> None:
        """Raise VideoError unless every view has the trial frames ``start`` to ``stop - 1``."""
        self._check(start)
        self._check(stop - 1)

    def _file_notes(self) -> list[str]:
        """Collect what is known about the files, once a file."""
        notes: dict[str, None] = {}
        for name, reader in self.readers.items():
            notes.update(dict.fromkeys(reader.source.notes))
            filmed = reader.source.filmed_fps
            if filmed is not None and not 1 / _OTHER_FPS < filmed / self._fps < _OTHER_FPS:
                note = (
                    f"{name}: the file says that it was filmed with {filmed:.4g} frames/s, but fps "
                    f"is {self._fps:.4g}: speeds and durations are wrong by as much. Mend fps, or "
                    "leave it where the film was brought to another rate afterwards."
                )
                notes[note] = None
                continue
            if reader.is_variable_rate:
                notes[f"{name}: the frame rate varies ({self._time_note(reader)}."] = None
            elif reader.file_fps > _FASTER * self._fps:
                note = (
                    f"{name}: the file says {reader.file_fps:.4g} frames/s, but fps is "
                    f"{self._fps:.4g}: hardly a film is played faster than it was filmed. Mend fps "
                    "if it was not; the strides are too long else."
                )
                notes[note] = None
        return list(notes)

    def _rate_notes(self) -> list[str]:
        """Say which files have another frame rate than the first: theirs are other instants."""
        rates: dict[str, float] = {}
        for name, reader in self.readers.items():
            stamps = reader.source.stamps_s
            if stamps is not None and len(stamps) > 1 and (step := np.median(np.diff(stamps))) > 0:
                rates[name] = 1.0 / float(step)
        first = next(iter(rates), None)
        return [
            f"the file of {name} has {rate:.4g} frames/s, that of {first} {rates[first]:.4g}: "
            "frames of one number are taken to be of one instant, and are not if the cameras ran "
            "so; bring both to one rate."
            for name, rate in rates.items()
            if first is not None and abs(rate / rates[first] - 1.0) > _OTHER_RATE
        ]

    def _time_note(self, reader: ViewReader) -> str:
        """Say what time the frames of a file of varying rate have."""
        slower = reader.played_slower
        rate = (reader.n_frames - 1) / float(reader.time_s[-1]) / slower
        rates = f"mean {rate:.4g} frames/s, fps is {self._fps:.4g})"
        if slower == 1.0:
            return f"{rates}; the file's own time stamps are used{_interval_note(reader)}"
        times = f"{slower:.3g} times slower" if slower > 1.0 else f"{1 / slower:.3g} times faster"
        return (
            f"{rates}: the film is taken to be played {times} than it was filmed, and only how "
            f"uneven its time stamps are is used. If it is not, mend fps{_interval_note(reader)}"
        )

    def _length_notes(self, ends: Mapping[str, int]) -> list[str]:
        """Say which frames are left out because a view is shorter or begins later."""
        shortest = min(ends, key=ends.__getitem__)
        end = ends[shortest]
        since = " from frame 0 of the trial on" if any(self._offsets.values()) else ""
        notes = [
            f"{shortest} has {end} frames{since}, {name} has {other}: frames {end} to "
            f"{other - 1} are left out."
            for name, other in ends.items()
            if other > end
        ]
        notes += [
            f"{name} begins at frame {-offset} of the trial: it lacks frames 0 to {-offset - 1}."
            for name, offset in self._offsets.items()
            if offset < 0
        ]
        return notes

    def close(self) -> None:
        """Close every file."""
        with self._pool_lock:
            pool, self._pool, self._is_closed = self._pool, None, True
        if pool is not None:
            pool.shutdown(wait=True, cancel_futures=True)
        for reader in self.readers.values():
            reader.close()


def _interval_note(reader: ViewReader) -> str:
    """Say where parts of a film have another frame rate, which are no frames that were dropped."""
    share = reader.share_of_odd_intervals
    if share <= _MANY:
        return ""
    return (
        f". {share:.0%} of its frames last more than three times as long, or as short, as most: "
        "where a part is in slow motion, times are wrong; make a film of its own of each part: "
        "ffmpeg -i IN -vf trim=start_frame=A:end_frame=B,setpts=PTS-STARTPTS -crf 12 OUT.mp4"
    )
