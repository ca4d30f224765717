"""Corrections of a stretch of frames, as a review offers them; without the widget."""

from __future__ import annotations

import numpy as np

from pawnb.core.edits.crossings import find_crossings
from pawnb.core.edits.log import Delete, Hide, Interpolate, Swap
from pawnb.core.edits.stretches import place_of, row_of
from pawnb.schema import ORIGIN_CODE
from pawnb.widgets.corrected_tracks import CorrectedTracks


class StretchEdits(CorrectedTracks):
    """What a person does to points over a stretch of frames: from ``frame`` up to ``stop``.

    ``stop`` is one past the last frame. ``view`` is the one view that is meant; None means
    every view.
    """

    def swap(
        self,
        frame: int,
        first: str,
        second: str,
        *,
        stop: int | None = None,
        view: str | None = None,
    ) -> str:
        """Exchange two points from a frame on, or over a stretch; returns what was done, in words.

        Parameters
        ----------
        frame : int
            From which frame on.
        first, second : str
            The points.
        stop : int, optional
            One past the last frame; default to the end.
        view : str, optional
            The one view in which that is done; default every view.

        Returns
        -------
        str
            What was done.
        """
        return self.apply(Swap(frame=frame, first=first, second=second, stop=stop, view=view))

    def hide(self, frame: int, view: str | None, point: str, *, stop: int | None = None) -> str:
        """Mark a point as not visible; returns what was done, in words.

        Parameters
        ----------
        frame : int
            The frame.
        view : str or None
            The view; None for every view.
        point : str
            The point.
        stop : int, optional
            One past the last frame; default only this frame.

        Returns
        -------
        str
            What was done.
        """
        return self.apply(Hide(frame=frame, view=view, point=point, stop=stop))

    def delete(self, frame: int, stop: int, point: str, *, view: str | None = None) -> str:
        """Take away what was tracked over a stretch; returns what was done, in words.

        Parameters
        ----------
        frame, stop : int
            First frame, and one past the last.
        point : str
            The point.
        view : str, optional
            The one view in which that is done; default every view.

        Returns
        -------
        str
            What was done.
        """
        return self.apply(Delete(frame=frame, stop=stop, point=point, view=view))

    def interpolate(self, frame: int, stop: int, point: str, *, view: str | None = None) -> str:
        """Lead a point smoothly over a stretch; returns what was done, in words.

        Parameters
        ----------
        frame, stop : int
            First frame, and one past the last.
        point : str
            The point.
        view : str, optional
            The one view in which that is done; default every view.

        Returns
        -------
        str
            What was done.

        Raises
        ------
        InputError
            If the point is not known at both sides of the stretch.
        """
        return self.apply(Interpolate(frame=frame, stop=stop, point=point, view=view))

    def next_crossing(self, frame: int, first: str, second: str) -> int:
        """Return the frame in which two points pass each other next.

        Parameters
        ----------
        frame : int
            The frame looked at; an encounter that it lies in does not count.
        first, second : str
            The points.

        Returns
        -------
        int
            The frame of least distance; one past the last frame where they meet no more.
        """
        row, frames, crossings = self._crossings(frame, first, second)
        later = [near for begin, near, _ in crossings if begin > row]
        return int(frames[later[0]]) if later else int(frames[-1]) + 1

    def are_together(self, frame: int, first: str, second: str) -> bool:
        """Tell whether two points are passing each other in a frame: then neither is the other.

        Parameters
        ----------
        frame : int
            The frame.
        first, second : str
            The points.

        Returns
        -------
        bool
            Whether the frame lies in one of their encounters.
        """
        row, _, crossings = self._crossings(frame, first, second)
        return any(begin <= row < stop for begin, _, stop in crossings)

    def stretch_between_crossings(self, frame: int, first: str, second: str) -> tuple[int, int]:
        """Return the stretch about a frame in which two points do not pass each other.

        Parameters
        ----------
        frame : int
            The frame.
        first, second : str
            The points.

        Returns
        -------
        tuple of int
            Its first frame, that of least distance where they have met before, and one past its
            last; the ends of the tracks where they meet no more.
        """
        row, frames, crossings = self._crossings(frame, first, second)
        before = [near for _, near, _ in crossings if near <= row]
        after = [near for _, near, _ in crossings if near > row]
        begin = int(frames[before[-1]]) if before else int(frames[0])
        return begin, int(frames[after[0]]) if after else int(frames[-1]) + 1

    def _crossings(
        self, frame: int, first: str, second: str
    ) -> tuple[int, np.ndarray, list[tuple[int, int, int]]]:
        """Return the row of a frame, all frames, and the encounters of two points."""
        with self.lock:
            tracks = self.present
        uv = tracks["image_position"].to_numpy()[..., 0]
        pair = [uv[..., place_of(tracks, "keypoint", name)] for name in (first, second)]
        return row_of(tracks, frame), tracks["frame"].to_numpy(), find_crossings(*pair)

    def frame_to_track_from(self, frame: int, stop: int) -> int:
        """Return where tracking a stretch again begins: at what was placed by hand in it.

        Parameters
        ----------
        frame, stop : int
            First frame of the stretch, and one past the last.

        Returns
        -------
        int
            The first frame of the stretch with a point placed by hand, else its first.
        """
        with self.lock:
            tracks = self.present
        edited = (tracks["image_origin"] == ORIGIN_CODE["edited"]).to_numpy().any(axis=(1, 2, 3))
        frames = tracks["frame"].to_numpy()
        placed = frames[edited & (frames >= frame) & (frames < stop)]
        return int(placed[0]) if len(placed) else frame


def order_partners(point: str, points: list[str], pairs: list[tuple[str, str]]) -> list[str]:
    """Return the other points in the order in which one is likely to be mistaken for them.

    Parameters
    ----------
    point : str
        The point.
    points : list of str
        Every point.
    pairs : list of tuple
        Pairs that can be mistaken for one another, the likeliest first.

    Returns
    -------
    list of str
        Those paired with it first, then the rest.
    """
    paired = [b if a == point else a for a, b in pairs if point in (a, b)]
    return list(dict.fromkeys([*paired, *(name for name in points if name != point)]))
