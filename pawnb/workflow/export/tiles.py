"""The views of a frame side by side in one picture, with what was tracked drawn over them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pawnb.core.video.views import Frame
from pawnb.core.video.viewset import ViewSet
from pawnb.errors import InputError, did_you_mean
from pawnb.workflow.export.marks import TRAIL, Marks, write

_TILE_GAP_PX = 4
_ASPECT = 1.6
"""Width over height that a picture of several parts comes nearest to."""
_PAPER = (255, 255, 255)


class TileLayout:
    """Where the pictures of some views stand in one picture.

    Parameters
    ----------
    sizes : mapping of str to tuple of int
        Width and height of each view, px, in their order.
    width : int
        Width of the whole picture, px.

    Attributes
    ----------
    part : int
        Width of each view in it, px.
    at : dict of str to tuple of int
        Top, left and height of each view in it, px.
    size : tuple of int
        Width and height of the whole picture, px, both even.
    """

    def __init__(self, sizes: Mapping[str, tuple[int, int]], *, width: int) -> None:
        columns = best_columns(list(sizes.values()))
        self.part = (width - _TILE_GAP_PX * (columns - 1)) // columns
        heights = [max(1, round(self.part * h / w)) for w, h in sizes.values()]
        rows = [heights[i : i + columns] for i in range(0, len(heights), columns)]
        tops = np.cumsum([0, *(max(row) + _TILE_GAP_PX for row in rows)])
        self.at = {
            name: (int(tops[i // columns]), (i % columns) * (self.part + _TILE_GAP_PX), heights[i])
            for i, name in enumerate(sizes)
        }
        high = max(2, int(tops[-1]) - _TILE_GAP_PX)
        self.size = (width + width % 2, high + high % 2)

    def whole(self, parts: Mapping[str, np.ndarray], said: str) -> np.ndarray:
        """Put the pictures of all views into one, with their names and what is said of them.

        Parameters
        ----------
        parts : mapping of str to ndarray
            Picture of each view, (height, part, 3) RGB uint8.
        said : str
            Written at the lower left.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            The whole picture.
        """
        whole = np.full((self.size[1], self.size[0], 3), _PAPER, np.uint8)
        words = []
        for name, (top, left, height) in self.at.items():
            whole[top : top + height, left : left + self.part] = parts[name]
            words.append((name, np.array([left + 4.0, top + 2.0]), _PAPER))
        last = (said, np.array([4.0, self.size[1] - 22.0]), _PAPER)
        write(whole, [*(words if len(words) > 1 else []), last])
        return whole


class Tiles:
    """Pictures of a trial, all of one size, with tracks over them.

    Parameters
    ----------
    views : ViewSet
        The open views.
    marks : Marks
        What is drawn over them.
    shown : sequence of str, optional
        Which views, in which order; default all.
    width : int
        Width of the whole picture, px; it becomes even.
    trail : int
        Frames of the past that trails show.

    Attributes
    ----------
    size : tuple of int
        Width and height of every picture, px, both even.

    Raises
    ------
    InputError
        If there is no such view, or the width cannot be.
    """

    def __init__(
        self,
        views: ViewSet,
        marks: Marks,
        *,
        shown: Sequence[str] | None = None,
        width: int = 1280,
        trail: int = TRAIL,
    ) -> None:
        self._views, self._marks, self._trail = views, marks, trail
        self.shown = list(views.names if shown is None else shown)
        for name in self.shown:
            if name not in views.names:
                hint = did_you_mean(name, views.names)
                raise InputError(f"no view {name!r}{hint}; there are {', '.join(views.names)}.")
        if not 64 <= width <= 8192:
            raise InputError(f"width is {width}; expected 64 to 8192 px.")
        sizes = {
            name: (views.readers[name].width, views.readers[name].height) for name in self.shown
        }
        self._layout = TileLayout(sizes, width=width)
        self.size = self._layout.size
        self._times = np.asarray(views.time_s)

    def picture(self, frame: int, frames: Mapping[str, Frame] | None = None) -> np.ndarray:
        """Return the views at one frame, (height, width, 3) RGB uint8.

        Parameters
        ----------
        frame : int
            Frame of the trial.
        frames : mapping of str to Frame, optional
            Its pictures, where they were read already.

        Returns
        -------
        ndarray
            The picture.
        """
        read = self._views.frame(frame) if frames is None else frames
        part, parts = self._layout.part, {}
        for name, (_, _, height) in self._layout.at.items():
            parts[name] = resized(read[name], (part, height))
            scale = part / read[name].width
            self._marks.draw(parts[name], name, frame, scale=scale, trail=self._trail)
        return self._layout.whole(parts, f"frame {frame}, {self._times[frame]:.3f} s")


def resized(frame: Frame, size: tuple[int, int]) -> np.ndarray:
    """Return a frame at another size, RGB, also where it is grey.

    Parameters
    ----------
    frame : Frame
        The frame.
    size : tuple of int
        Width and height, px.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        A fresh array.
    """
    most = min(frame.width // size[0], frame.height // size[1])
    return resized_array(frame.shrunk(max(1, most)), size)


def resized_array(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a picture at another size, RGB, also where it is grey.

    Parameters
    ----------
    image : ndarray of uint8, shape (H, W) or (H, W, 3)
        The picture.
    size : tuple of int
        Width and height, px.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        A fresh array.
    """
    smaller = image.shape[1] > size[0]
    image = cv2.resize(image, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
    return image if image.ndim == 3 else np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2RGB))


def best_columns(sizes: Sequence[tuple[int, int]]) -> int:
    """Return in how many columns pictures of such sizes come nearest to a usual page.

    Parameters
    ----------
    sizes : sequence of tuple of int
        Width and height of each.

    Returns
    -------
    int
        From 1 to their number.
    """

    def off(columns: int) -> float:
        tall = [h / w for w, h in sizes]
        rows = [max(tall[i : i + columns]) for i in range(0, len(tall), columns)]
        return abs(math.log(columns / sum(rows) / _ASPECT))

    return min(range(1, len(sizes) + 1), key=off)
