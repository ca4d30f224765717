"""Views of a trial: frames after debayering, straightening, cropping and mirroring.

This module knows no container and no codec; :mod:`pawnb.core.video` opens the files.
"""

from __future__ import annotations

import operator
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray, IntArray, Points2D
from pawnb.core.closing import Closing
from pawnb.core.lens import Lens, StraightPicture
from pawnb.core.pixels.bayer import debayered
from pawnb.core.pixels.colour import Picture
from pawnb.core.pixels.yuv import reduce_region
from pawnb.errors import VideoError
from pawnb.trial import View

_MOST_APART = 3.0
"""How far the rate of the recording and that of a file may lie apart for both to be of one time.

A film in slow motion is played four times slower or more; a camera that is short of light takes
half as many frames as it says.
"""


class Source(Protocol):
    """Pictures by number: a video file or a folder of pictures."""

    name: str
    n_frames: int
    width: int
    height: int
    notes: list[str]
    stamps_s: np.ndarray | None
    is_variable_rate: bool
    filmed_fps: float | None
    frame_bytes: IntArray | None

    def grab(self, index: int, *, partly: bool = False) -> Picture:
        """Return the picture of that number; safe to call from any thread.

        ``partly`` says that small parts of it will be looked at: it may be decoded then.
        """

    def again(self) -> Source:
        """Open the same once more, to be read and closed by itself."""

    def close(self) -> None:
        """Close the file."""


class Frame:
    """One picture of a view; colour is converted only where it is asked for.

    Attributes
    ----------
    index : int
        The frame number that was asked for.
    width, height : int
        Size of the view, px.
    is_colour : bool
        Whether arrays are (H, W, 3) RGB rather than (H, W) grey.
    """

    __slots__ = ("_mirror", "_origin", "_picture", "height", "index", "is_colour", "width")

    def __init__(
        self, index: int, picture: Picture, box: tuple[int, int, int, int], *, mirror: bool = False
    ) -> None:
        self.index = index
        self._picture = picture
        self._origin = box[:2]
        self.width, self.height = box[2] - box[0], box[3] - box[1]
        self.is_colour = picture.is_colour
        self._mirror = mirror

    def image(self) -> ByteArray:
        """Return the whole view.

        Returns
        -------
        ndarray, shape (H, W, 3) RGB or (H, W) grey, uint8
            A fresh array.
        """
        return self.crop(0, 0, self.width, self.height)

    def crop(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return the half-open region, bit-identical to that part of :meth:`image`.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Left, top, right and bottom in px of the view; right and bottom are one past
            the last pixel.

        Returns
        -------
        ndarray, shape (v1 - v0, u1 - u0, 3) RGB or (v1 - v0, u1 - u0) grey, uint8
            A fresh array.

        Raises
        ------
        VideoError
            If the region is empty or reaches outside the view.
        """
        return self.reduced(u0, v0, u1, v1, factor=1)

    def reduced(self, u0: int, v0: int, u1: int, v1: int, *, factor: int) -> ByteArray:
        """Return the half-open region reduced by a whole factor, quicker than :meth:`crop`.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            As for :meth:`crop`; width and height are multiples of ``factor``.
        factor : int
            Pixels of the view along each side of a pixel of the result.

        Returns
        -------
        ndarray, shape (H / factor, W / factor, 3) RGB or (H / factor, W / factor) grey, uint8
            A fresh array; each pixel is the mean of a square of the region's, to rounding.

        Raises
        ------
        VideoError
            If the region is empty, reaches outside the view, or is no multiple of ``factor``.
        """
        if not (0 <= u0 < u1 <= self.width and 0 <= v0 < v1 <= self.height):
            raise VideoError(
                f"frame {self.index}: the region {[u0, v0, u1, v1]} is empty or reaches outside "
                f"the view of {self.width} x {self.height} px."
            )
        if (u1 - u0) % factor or (v1 - v0) % factor:
            raise VideoError(
                f"frame {self.index}: the region {[u0, v0, u1, v1]} cannot be reduced by {factor}: "
                f"its width and height are no multiples of it."
            )
        if self._mirror:
            u0, u1 = self.width - u1, self.width - u0
        left, top = self._origin
        box = (left + u0, top + v0, left + u1, top + v1)
        pixels = reduce_region(self._picture, box, factor)
        return np.ascontiguousarray(pixels[:, ::-1]) if self._mirror else pixels

    def shrunk(self, factor: int) -> ByteArray:
        """Return the whole view reduced by a whole factor, whatever its size.

        Parameters
        ----------
        factor : int
            Pixels of the view along each side of a pixel of the result.

        Returns
        -------
        ndarray, shape (H / factor, W / factor, 3) RGB or (H / factor, W / factor) grey, uint8
            A fresh array, its size rounded; see :meth:`reduced`, which is quicker and is used
            where the size is a multiple of ``factor``.
        """
        if self.width % factor == 0 and self.height % factor == 0:
            return self.reduced(0, 0, self.width, self.height, factor=factor)
        size = [max(1, round(side / factor)) for side in (self.width, self.height)]
        return np.asarray(cv2.resize(self.image(), size, interpolation=cv2.INTER_AREA))


class ViewReader(Closing):
    """The frames of one view, by number; may be used from several threads.

    Made by :func:`pawnb.core.video.open_view`; a context manager.

    Parameters
    ----------
    view : View
        What to show of the file.
    source : Source
        The open file.
    lens : Lens, optional
        Distortion to remove.
    fps : float, optional
        Frames per second of the recording; without it the file's own time is used.

    Attributes
    ----------
    name : str
        Name of the view.
    n_frames : int
        Number of frames in the file.
    width, height : int
        Size of the resulting view, px.
    is_colour : bool
        Whether the format carries colour (a YUV video of a grey scene does).
    is_variable_rate : bool
        Whether the file's time stamps are not evenly spaced.
    lens : Lens or None
        Distortion that is removed.

    Raises
    ------
    VideoError
        If the crop reaches outside the picture, or the first picture is not readable.
    """

    def __init__(
        self, view: View, source: Source, *, lens: Lens | None = None, fps: float | None = None
    ) -> None:
        self.name = view.name
        self.source = source
        self.n_frames = source.n_frames
        self.is_variable_rate = source.is_variable_rate
        self._view = view
        self.lens = lens
        self._fps = fps
        self._box = view.crop or (0, 0, source.width, source.height)
        u0, v0, u1, v1 = self._box
        if not (0 <= u0 < u1 <= source.width and 0 <= v0 < v1 <= source.height):
            raise VideoError(
                f"view {self.name!r}: crop is {list(self._box)}, but the picture of {source.name} "
                f"is {source.width} x {source.height} px; keep u0, v0, u1, v1 inside it."
            )
        self.width, self.height = u1 - u0, v1 - v0
        self.is_colour = self.frame(0).is_colour

    @property
    def time_s(self) -> FloatArray:
        """Time of each frame since the first, s, shape (n_frames,).

        The file's time stamps where the rate varies or no fps was given, else
        frame / fps. Stamps of a film that is :attr:`played_slower` are brought to the
        time of the recording. Raises VideoError for pictures without fps: they carry no time.
        """
        if self._fps is not None and not self.is_variable_rate:
            return np.arange(self.n_frames) / self._fps
        if self.source.stamps_s is None:
            raise VideoError(f"view {self.name!r}: pictures carry no time; give fps.")
        return (self.source.stamps_s - self.source.stamps_s[0]) / self.played_slower

    @property
    def played_slower(self) -> float:
        """How many times slower than it was filmed a file of varying rate is played; else 1."""
        if self._fps is None or not self.is_variable_rate or self.source.stamps_s is None:
            return 1.0
        slower = self._fps * float(np.median(np.diff(self.source.stamps_s)))
        return 1.0 if slower == 0 or 1 / _MOST_APART <= slower <= _MOST_APART else slower

    @property
    def file_fps(self) -> float:
        """Frames per second by the file's time stamps; 0 where it has none."""
        if self.source.stamps_s is None or self.n_frames < 2:
            return 0.0
        return (self.n_frames - 1) / float(self.source.stamps_s[-1] - self.source.stamps_s[0])

    @property
    def share_of_odd_intervals(self) -> float:
        """Share of frames that last more than three times as long, or as short, as most do."""
        if self.source.stamps_s is None or self.n_frames < 2:
            return 0.0
        steps = np.diff(self.source.stamps_s)
        usual = float(np.median(steps))
        return float(np.mean((steps > _MOST_APART * usual) | (steps < usual / _MOST_APART)))

    def frame(self, index: int) -> Frame:
        """Return a frame of this file.

        Parameters
        ----------
        index : int
            Frame number, 0 for the first of the file.

        Returns
        -------
        Frame
            The frame, not yet converted to RGB.

        Raises
        ------
        VideoError
            If there is no such frame or it cannot be decoded.
        """
        return self.frame_of(self.grab(operator.index(index)), index)

    def grab(self, index: int, *, partly: bool = False) -> Picture:
        """Return the undecorated picture of the file; views of one file share it.

        ``partly`` as for :meth:`pawnb.core.video.viewset.ViewSet.frames`.
        """
        if not 0 <= index < self.n_frames:
            raise VideoError(f"view {self.name!r}: {no_such_frame(self.source, index)}")
        try:
            return self.source.grab(index, partly=partly)
        except VideoError as error:
            raise VideoError(f"view {self.name!r}: {error}") from None

    def frame_of(self, picture: Picture, index: int) -> Frame:
        """Return the frame that this view shows of a picture, under the number given."""
        if self._view.bayer is not None:
            picture = debayered(picture, self._view.bayer, where=f"view {self.name!r}")
        if self.lens is not None:
            picture = StraightPicture(picture, self.lens)
        return Frame(index, picture, self._box, mirror=self._view.mirror)

    def uv_of_file(self, uv: Points2D) -> Points2D:
        """Return where positions (..., 2) in the file's own picture lie in the view, px."""
        straight = np.asarray(uv, float) if self.lens is None else self.lens.straighten(uv)
        shown = straight - np.array(self._box[:2], float)
        if self._view.mirror:
            shown = np.array([self.width - 1.0, 0.0]) + np.array([-1.0, 1.0]) * shown
        return shown

    def read(self, index: int) -> ByteArray:
        """Return the whole view at that frame: (H, W, 3) RGB or (H, W) grey, uint8."""
        return self.frame(index).image()

    def again(self) -> ViewReader:
        """Return a reader of the same view with a file of its own.

        Two that read in different places at once do not keep each other waiting.
        """
        return ViewReader(self._view, self.source.again(), lens=self.lens, fps=self._fps)

    def close(self) -> None:
        """Close the file; other views of the same file close with it."""
        self.source.close()


def no_such_frame(source: Source, index: int) -> str:
    """Say that a file lacks a frame, and what is known about why."""
    known = f" ({' '.join(source.notes)})" if source.notes and index >= 0 else ""
    return (
        f"{source.name} has no frame {index}; it has {source.n_frames} frames, "
        f"0 to {source.n_frames - 1}{known}."
    )
