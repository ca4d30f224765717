"""Decoded pictures, and RGB or grey made of only the region that is asked for.

A decoder hands out planes (YUV, grey, RGB in one of several layouts). Every class
here keeps them as they are and offers ``region(u0, v0, u1, v1)``: a fresh array of
exactly that half-open region, ``(H, W, 3)`` RGB or ``(H, W)`` grey, uint8. What a
region holds never depends on where its borders lie: all arithmetic is on integers,
pixel by pixel, and chroma is spread over its block of luma pixels (nearest), so a
crop is bit-identical to the same part of the whole picture on every machine.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

import cv2
import numpy as np

from pawnb.arrays import AnyArray, ByteArray


class Picture(Protocol):
    """What every decoded picture offers: its size, and any region of it."""

    @property
    def width(self) -> int:
        """Width in px."""

    @property
    def height(self) -> int:
        """Height in px."""

    @property
    def is_colour(self) -> bool:
        """Whether regions are RGB rather than grey."""

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region, (H, W, 3) RGB or (H, W) grey, uint8.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """


class ArrayBased:
    """Size of a picture kept in an array whose first two axes are v and u."""

    is_colour: bool

    def __init__(self, pixels: np.ndarray) -> None:
        self._pixels = pixels
        self.height, self.width = pixels.shape[:2]


class GreyPicture(ArrayBased):
    """One byte a pixel.

    Parameters
    ----------
    pixels : ndarray, shape (H, W), uint8
        Grey values.
    """

    is_colour = False

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8, shape (v1 - v0, u1 - u0)
            Its pixels.
        """
        return self._pixels[v0:v1, u0:u1].copy()


class PackedPicture(ArrayBased):
    """Three or four interleaved channels.

    Parameters
    ----------
    pixels : ndarray, shape (H, W, 3 or 4), uint8
        The channels as decoded.
    channels : tuple of int
        Where red, green and blue are found in the last axis.
    """

    is_colour = True

    def __init__(self, pixels: np.ndarray, channels: tuple[int, int, int] = (0, 1, 2)) -> None:
        super().__init__(pixels)
        self._channels = list(channels)

    def region(self, u0: int, v0: int, u1: int, v1: int) -> AnyArray:
        """Return that half-open region as a fresh RGB array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8, shape (v1 - v0, u1 - u0, 3)
            Its pixels.
        """
        part = self._pixels[v0:v1, u0:u1]
        if self._channels == [0, 1, 2]:
            return part[..., :3].copy()
        return cv2.merge([np.ascontiguousarray(part[..., c]) for c in self._channels])


class PlanarPicture(ArrayBased):
    """Red, green and blue in a plane each.

    Parameters
    ----------
    red, green, blue : ndarray, shape (H, W), uint8
        The planes.
    """

    is_colour = True

    def __init__(self, red: np.ndarray, green: np.ndarray, blue: np.ndarray) -> None:
        super().__init__(red)
        self._planes = (red, green, blue)

    def region(self, u0: int, v0: int, u1: int, v1: int) -> AnyArray:
        """Return that half-open region as a fresh RGB array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8, shape (v1 - v0, u1 - u0, 3)
            Its pixels.
        """
        return cv2.merge([plane[v0:v1, u0:u1] for plane in self._planes])


class PalettePicture(ArrayBased):
    """Indices into 256 colours; many uncompressed AVI files of grey cameras are such.

    Parameters
    ----------
    pixels : ndarray, shape (H, W), uint8
        Indices.
    palette : ndarray, shape (256, 3), uint8
        RGB of each index. Where every entry is grey, so is the picture.
    """

    def __init__(self, pixels: np.ndarray, palette: np.ndarray) -> None:
        super().__init__(pixels)
        self.is_colour = not is_grey(palette)
        self._palette = palette.copy() if self.is_colour else palette[:, 0].copy()

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """
        return self._palette[self._pixels[v0:v1, u0:u1]]


class LazyPicture:
    """A rare format, converted whole when its first region is asked for.

    Parameters
    ----------
    width, height : int
        Size in px.
    load : callable
        Returns the whole picture as (H, W, 3) RGB or (H, W) grey, uint8.
    is_colour : bool
        Whether that is RGB.
    """

    def __init__(
        self, width: int, height: int, load: Callable[[], np.ndarray], *, is_colour: bool = True
    ) -> None:
        self.width, self.height = width, height
        self.is_colour = is_colour
        self._load = load
        self._pixels: np.ndarray | None = None
        # a picture kept by the reader is handed to several threads, and converting one
        # frame twice at the same time crashes libswscale
        self._lock = threading.Lock()

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """
        with self._lock:
            if self._pixels is None:
                self._pixels = self._load()
        return self._pixels[v0:v1, u0:u1].copy()


class PartPicture:
    """A picture of which only the part that is asked for is decoded, each time anew.

    Parameters
    ----------
    width, height : int
        Size in px.
    load : callable
        ``load(u0, v0, u1, v1)`` returns a picture that holds at least that half-open region,
        and where its left and top are.
    is_colour : bool
        Whether regions are RGB.
    """

    def __init__(
        self,
        width: int,
        height: int,
        load: Callable[[int, int, int, int], tuple[Picture, tuple[int, int]]],
        *,
        is_colour: bool,
    ) -> None:
        self.width, self.height = width, height
        self.is_colour = is_colour
        self._load = load

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8
            Its pixels.
        """
        picture, box = self.part((u0, v0, u1, v1))
        return picture.region(*box)

    def part(self, box: tuple[int, int, int, int]) -> tuple[Picture, tuple[int, int, int, int]]:
        """Return a picture that holds a region, and where the region lies in it."""
        picture, (left, top) = self._load(*box)
        return picture, (box[0] - left, box[1] - top, box[2] - left, box[3] - top)

    def whole(self) -> Picture:
        """Return the whole picture, decoded."""
        return self._load(0, 0, self.width, self.height)[0]


def is_grey(palette: ByteArray) -> bool:
    """Tell whether every colour of a palette, shape (n, 3), is a grey."""
    return bool((palette == palette[:, :1]).all())
